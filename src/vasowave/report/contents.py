"""What a report holds: its sections in order, and where everything came from."""

from collections.abc import Mapping
from dataclasses import replace

from vasowave.animal.reading import data_of, name_of
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.comparison import Comparison, compare
from vasowave.provenance import provenance
from vasowave.report.blocks import Report, Section, Table
from vasowave.report.sections.animals import animal_sections, animals_section
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
    models = [model_section(cohort, written)] if cohort.walls else []
    first, last = summary_section(cohort, comparisons, failures, written), methods_section(cohort, comparisons)
    if cohort.single:
        own, search = animal_sections(cohort, written)
        return list(map(_of_one, [first, own, data_section(cohort), *models, search, last]))
    groups, animals = groups_section(cohort, comparisons, written), animals_section(cohort, written)
    return [first, data_section(cohort), *models, groups, animals, last]


def _of_one(section: Section) -> Section:
    """Return a section whose tables do not say of every row that it is of the only animal."""
    blocks = [block.hiding("animal", "group", "n") if isinstance(block, Table) else block for block in section.blocks]
    return replace(section, blocks=blocks)


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
