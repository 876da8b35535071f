"""What the Explorer shows of all animals: every number with its interval, and the mean of each group."""

import threading
from typing import Any

from vasowave.animal.files import read_result
from vasowave.animal.result import AnimalResult
from vasowave.cohort import Cohort
from vasowave.cohort.comparison import group_means
from vasowave.errors import InputError
from vasowave.figures.style import group_looks, source_looks
from vasowave.findings import texts
from vasowave.study.results import Results, read_results
from vasowave.workbench.desk import Desk
from vasowave.workbench.values import number


class Cohorts:
    """Numbers of the animals that have results; a file is read once, as long as it stays as it is."""

    def __init__(self) -> None:
        self._numbered: dict[str, tuple[int, dict[str, Any]]] = {}
        self._gathered: tuple[int, Cohort] | None = None
        self._lock = threading.Lock()

    def animals(self, desk: Desk) -> dict[str, Any]:
        """Return who has results, and the numbers of every animal and law."""
        stored = read_results(desk.folder)
        groups = {one.animal: one.group for one in stored.animals}
        looks = group_looks(stored.settings.groups)
        numbers = [self._numbers(stored, name) for name in stored]
        sources = dict.fromkeys(source for one in numbers for source in one["laws"])
        return {
            "animals": [
                {"name": name, "group": groups[name], **more} for name, more in zip(stored, numbers, strict=True)
            ],
            "groups": {label: looks[label].color for label in stored.settings.groups},
            "reference": next((label for label in stored.settings.groups if label in groups.values()), ""),
            "quantities": {name: what for one in reversed(numbers) for name, what in one.pop("described").items()},
            "sources": {name: look.filled for name, look in source_looks(sources).items()},
            "failures": [f"{one.animal}: {one}" for one in stored.failures],
        }

    def _numbers(self, stored: Results, name: str) -> dict[str, Any]:
        """Return all numbers of an animal; a file is read once, as long as it stays as it is."""
        path = stored.folder / stored.file_of(name)
        mark = path.stat().st_mtime_ns
        if self._numbered.get(name, (0,))[0] != mark:
            self._numbered[name] = mark, _numbers_of(read_result(path))
        return dict(self._numbered[name][1])

    def means(self, desk: Desk, name: str) -> dict[str, dict[str, list[float | None]]]:
        """Return the mean of a quantity in each group with its interval, by source; as in the report's figures.

        Raises
        ------
        InputError
            No animal has this quantity; the file of an animal is missing or damaged.
        """
        with self._lock:
            stored = read_results(desk.folder)
            mark = (stored.folder / "index.json").stat().st_mtime_ns
            if self._gathered is None or self._gathered[0] != mark:
                results = stored.in_order(whole=False)
                self._gathered = mark, stored.gathered(results, results[0].group if results else None)
            cohort = self._gathered[1]
        if name not in cohort.symbols:
            raise InputError(f"no animal has a quantity '{name[:80]}'")
        found = {source: group_means(cohort, source, name) for source in cohort.sources}
        return {
            source: {group: [number(end) for end in mean] for group, mean in means.items()}
            for source, means in found.items() if means
        }  # fmt: skip


def _numbers_of(result: AnimalResult) -> dict[str, Any]:
    """Return the numbers of an animal by source, what they mean, and its findings."""
    laws = {
        source: {
            str(quantity): [number(float(value)), *(
                number(float(value.attrs[f"interval_{end}"])) if f"interval_{end}" in value.attrs else None
                for end in ("low", "high"))]
            for quantity, value in one.quantities.data_vars.items()
        }
        for source, one in result.sources.items()
    }  # fmt: skip
    described = {
        str(name): [value.attrs.get("symbol", str(name)), value.attrs["units"], value.attrs["long_name"]]
        for one in reversed(result.sources.values())
        for name, value in one.quantities.data_vars.items()
    }
    return {"laws": laws, "findings": texts(result.findings), "described": described}
