"""What the Explorer shows of all animals: every number with its interval, and the mean of each group."""

from pathlib import Path
from typing import Any

from vasowave.base.errors import InputError
from vasowave.base.findings import texts
from vasowave.base.io.remembered import remembered
from vasowave.study.animal.files import read_result
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.comparison import group_means
from vasowave.study.figures.matplotlib_style import group_looks, source_looks
from vasowave.study.results.results import Results
from vasowave.workbench.desk import Desk
from vasowave.workbench.values import number, numbers


class Cohorts:
    """Numbers of the animals that have results."""

    def animals(self, desk: Desk) -> dict[str, Any]:
        """Return who has results, and the numbers of every animal and law."""
        stored = desk.stored()
        groups = {animal.animal: animal.group for animal in stored.animals}
        looks = group_looks(stored.settings.groups)
        numbers = [_numbers_in(stored.folder / animal.file) for animal in stored.animals]
        sources = dict.fromkeys(source for entry in numbers for source in entry["laws"])
        return {
            "animals": [
                {"name": name, "group": groups[name], "laws": entry["laws"], "findings": entry["findings"]}
                for name, entry in zip(stored, numbers, strict=True)
            ],
            "groups": {label: looks[label].color for label in stored.settings.groups},
            "reference": next((label for label in stored.settings.groups if label in groups.values()), ""),
            "quantities": {
                name: description for entry in reversed(numbers) for name, description in entry["described"].items()
            },
            "sources": {name: style.filled for name, style in source_looks(sources).items()},
            "failures": [f"{failure.animal}: {failure}" for failure in stored.failures],
        }

    def means(self, desk: Desk, name: str) -> dict[str, dict[str, list[float | None]]]:
        """Return the mean of a quantity in each group with its interval, by source; as in the report's figures.

        Raises
        ------
        InputError
            No animal has this quantity; the file of an animal is missing or damaged.
        """
        stored = desk.stored()
        cohort = desk.of_results("cohort", lambda: _cohort_of(stored))
        if name not in cohort.symbols:
            raise InputError(f"no animal has a quantity '{name[:80]}'")
        means_by_source = {source: group_means(cohort, source, name) for source in cohort.sources}
        return {
            source: {group: numbers(mean) for group, mean in means.items()}
            for source, means in means_by_source.items() if means
        }  # fmt: skip


def _cohort_of(stored: Results) -> Cohort:
    """Return the animals of results in their groups."""
    results = stored.in_order(whole=False)
    return stored.gathered(results, results[0].group if results else None)


@remembered
def _numbers_in(path: Path) -> dict[str, Any]:
    """Return the numbers of an animal by source, what they mean, and its findings, from the file of its result."""
    result = read_result(path)
    laws = {
        source: {
            str(quantity): [number(float(value)), *(
                number(float(value.attrs[f"interval_{end}"])) if f"interval_{end}" in value.attrs else None
                for end in ("low", "high"))]
            for quantity, value in source_result.quantities.data_vars.items()
        }
        for source, source_result in result.sources.items()
    }  # fmt: skip
    described = {
        str(name): [value.attrs.get("symbol", str(name)), value.attrs["units"], value.attrs["long_name"]]
        for source_result in reversed(result.sources.values())
        for name, value in source_result.quantities.data_vars.items()
    }
    return {"laws": laws, "findings": texts(result.findings), "described": described}
