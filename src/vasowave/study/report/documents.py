"""The two documents: the one result, and behind it every table and figure; and where everything came from."""

import json
from collections.abc import Mapping
from dataclasses import replace

from vasowave.base.software import provenance
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.comparison import SourceComparison, compare
from vasowave.study.cohort.primary import Family, Primary
from vasowave.study.report.answer.page import answer_sections
from vasowave.study.report.blocks import REPORT, SUPPLEMENT, OnScreen, Report, Section, Table
from vasowave.study.report.sections.animals import ANIMALS, animal_sections, animals_section
from vasowave.study.report.sections.data import data_section
from vasowave.study.report.sections.groups import groups_section
from vasowave.study.report.sections.methods import methods_section
from vasowave.study.report.sections.models import model_section
from vasowave.study.report.sections.records import records
from vasowave.study.report.terms import glossary, glossary_table
from vasowave.study.report.wording import named, symbols

ANIMALS_PER_PAGE = 48
"""Animals that one page of the supplement shows one by one: each takes up to 300 kB, and browsers bear 20 MB well."""


def report_of(cohort: Cohort, primary: Primary, family: Family, title: str = "") -> Report:
    """Return the document of one result."""
    heading, subtitle = _titles(cohort)
    return Report(
        REPORT,
        title or heading,
        subtitle,
        synthetic_banner(cohort),
        answer_sections(cohort, primary, family),
        provenance(),
        glossary=glossary(cohort),
        animals=cohort.subjects,
    )


def supplement_of(cohort: Cohort, primary: Primary, title: str = "") -> Report:
    """Return the document of every table and figure."""
    heading, subtitle = _titles(cohort)
    independent = not (cohort.single or cohort.repeated)
    comparisons = {source: compare(cohort, source) for source in cohort.sources} if independent else {}
    return Report(
        SUPPLEMENT,
        f"Supplement: {title or heading}",
        subtitle,
        synthetic_banner(cohort),
        _sections(cohort, primary, comparisons),
        origin(cohort),
        records(cohort),
        glossary(cohort),
        cohort.subjects,
    )


def pages_of(supplement: Report) -> dict[str, Report]:
    """Return the pages of the supplement, by their titles: its own, and those of animals one by one where many are."""
    (folds,) = [
        block.blocks
        for section in supplement.sections
        if section.name == ANIMALS
        for block in section.blocks
        if isinstance(block, OnScreen)
    ] or [[]]
    if len(folds) <= ANIMALS_PER_PAGE:
        return {supplement.title: supplement}
    sections = [
        replace(section, blocks=[block for block in section.blocks if not isinstance(block, OnScreen)])
        if section.name == ANIMALS
        else section
        for section in supplement.sections
    ]
    pages = {supplement.title: replace(supplement, sections=sections)}
    made = {"vasowave": supplement.provenance["vasowave"]}
    for first in range(0, len(folds), ANIMALS_PER_PAGE):
        shown = folds[first : first + ANIMALS_PER_PAGE]
        title = f"Animals {first + 1} to {first + len(shown)}"
        pages[title] = replace(supplement, sections=[Section(ANIMALS, title, shown)], provenance=made)
    return pages


def synthetic_banner(cohort: Cohort) -> str:
    """Say which animals are synthetic; empty if none is."""
    made = [result for result in cohort.results if result.synthetic]
    if not made:
        return ""
    noun = "recordings" if cohort.repeated else "animals"
    subject = f"All {len(made)} {noun} were" if len(made) == len(cohort.results) else f"The {noun} {named(made)} were"
    return (
        f"{'This animal was' if cohort.single else subject} made by a model, not measured. The numbers show how the "
        "program works and say nothing about any living animal."
    )


def _sections(cohort: Cohort, primary: Primary, comparisons: Mapping[str, SourceComparison]) -> list[Section]:
    written = symbols(cohort)
    models = [model_section(cohort, primary, written)] if cohort.walls else []
    last = [
        methods_section(cohort, primary, comparisons),
        Section("glossary", "Glossary", [glossary_table(glossary(cohort))]),
    ]
    if cohort.single:
        summary, search = animal_sections(cohort, written)
        return [*map(_of_one, [summary, data_section(cohort), *models, search]), *last]
    groups, animals = groups_section(cohort, primary, comparisons, written), animals_section(cohort, written)
    return [groups, data_section(cohort), *models, animals, *last]


def _of_one(section: Section) -> Section:
    """Return a section whose tables do not say of every row that it is of the only animal."""
    blocks = [block.hiding("animal", "group", "n") if isinstance(block, Table) else block for block in section.blocks]
    return replace(section, blocks=blocks)


def _titles(cohort: Cohort) -> tuple[str, str]:
    if cohort.single:
        (result,) = cohort.results
        source = str(result.recording.attrs.get("source", ""))
        return f"Hemodynamic assessment of {result.name}", f"Recording: {source}" if source else ""
    groups = f"{len(cohort.groups)} {'group' if len(cohort.groups) == 1 else 'groups'}: {', '.join(cohort.groups)}"
    count, lost = len(cohort.results), len(cohort.lost)
    subject = cohort.variables.get(cohort.design.subject or "")
    noun = f"recordings of {len(subject.order)} animals" if subject else "animals"
    return "Hemodynamic assessment of a cohort", f"{f'{count} of ' if lost else ''}{count + lost} {noun} in {groups}"


def origin(cohort: Cohort) -> dict[str, str]:
    """Return versions, seed, settings and hashes: once where all animals share them, else by animal."""
    made = provenance()
    rows = {"report made": made["created"], "vasowave": made["vasowave"]}
    records = {
        result.name: {"interrupted": "yes" if result.interrupted else "no",
                      "settings": json.dumps(result.settings, sort_keys=True), **result.origin}
        for result in cohort.results
    }  # fmt: skip
    for key in dict.fromkeys(key for record in records.values() for key in record):
        values = {animal: record[key] for animal, record in records.items() if key in record}
        if len(set(values.values())) == 1 and len(values) == len(cohort.results):
            label = f"{key} of the animals' results" if key in rows else key
            rows[label] = next(iter(values.values()))
        else:
            rows |= {f"{key} ({animal})": value for animal, value in values.items()}
    return rows | {
        f"source of {result.name}": str(result.recording.attrs.get("source", "")) for result in cohort.results
    }
