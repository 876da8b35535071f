"""What a report holds: its sections in order, and where everything came from."""

from collections.abc import Mapping

from vasowave.animal.reading import data_of, name_of
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.comparison import Comparison, compare
from vasowave.provenance import provenance
from vasowave.report.blocks import Report, Section
from vasowave.report.sections.animals import animals_section
from vasowave.report.sections.data import data_section
from vasowave.report.sections.groups import groups_section
from vasowave.report.sections.methods import methods_section
from vasowave.report.sections.models import model_section
from vasowave.report.sections.summary import summary_section, synthetic_banner
from vasowave.report.tables.cells import symbols
from vasowave.report.tables.records import records

_SAID_ELSEWHERE = ("title", "Conventions", "animal", "group", "synthetic", "notes")


def report_of(cohort: Cohort, failures: Mapping[str, str], title: str = "") -> Report:
    """Return the report of a cohort, which may be one animal."""
    comparisons = {} if cohort.single else {source: compare(cohort, source) for source in cohort.sources}
    heading, subtitle = _titles(cohort)
    return Report(
        title or heading,
        subtitle,
        synthetic_banner(cohort),
        _sections(cohort, comparisons, failures),
        origin(cohort),
        records(cohort),
    )


def _sections(cohort: Cohort, comparisons: Mapping[str, Comparison], failures: Mapping[str, str]) -> list[Section]:
    written = symbols(cohort.trees)
    return [
        summary_section(cohort, comparisons, failures, written),
        data_section(cohort),
        *([model_section(cohort, written)] if cohort.walls else []),
        *([] if cohort.single else [groups_section(cohort, comparisons, written)]),
        animals_section(cohort, written),
        methods_section(cohort, comparisons),
    ]


def _titles(cohort: Cohort) -> tuple[str, str]:
    if cohort.single:
        (tree,) = cohort.trees
        source = str(data_of(tree, "recording").attrs.get("source", ""))
        return f"Hemodynamic assessment of {name_of(tree)}", f"Recording: {source}" if source else ""
    groups = f"{len(cohort.groups)} {'group' if len(cohort.groups) == 1 else 'groups'}: {', '.join(cohort.groups)}"
    return "Hemodynamic assessment of a cohort", f"{len(cohort.trees)} animals in {groups}"


def origin(cohort: Cohort) -> dict[str, str]:
    """Return versions, seed, settings and hashes: once where all animals share them, else by animal."""
    made = provenance()
    rows = {"report made": made["created"], "vasowave": made["vasowave"]}
    keys = dict.fromkeys(str(key) for tree in cohort.trees for key in tree.attrs if key not in _SAID_ELSEWHERE)
    for key in keys:
        values = {name_of(tree): str(tree.attrs[key]) for tree in cohort.trees if key in tree.attrs}
        if len(set(values.values())) == 1 and len(values) == len(cohort.trees):
            label = f"{key} of the animals' results" if key in rows else key
            rows[label] = next(iter(values.values()))
        else:
            rows |= {f"{key} ({animal})": value for animal, value in values.items()}
    return rows | {
        f"source of {name_of(tree)}": str(data_of(tree, "recording").attrs.get("source", "")) for tree in cohort.trees
    }
