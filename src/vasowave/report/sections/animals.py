"""Every animal: what must be considered, its beats, its fits, its values with intervals, how they were searched."""

from collections.abc import Sequence

import pandas as pd
import xarray as xr

from vasowave.animal.result import AnimalResult
from vasowave.cohort.cohort import Cohort
from vasowave.figures.measured import beats_figure
from vasowave.figures.modeled import fit_figure
from vasowave.figures.sheet import ON_A_SHEET, sheet_figure, sheets
from vasowave.figures.style import group_looks
from vasowave.findings import texts
from vasowave.report.blocks import Block, Bullets, Drawing, Fold, Heading, OnScreen, Paragraph, Remarks, Section
from vasowave.report.sections.fits import fit_sentences
from vasowave.report.tables import animal as tables
from vasowave.report.tables.models import laws_by_posterior


def animals_section(cohort: Cohort, written: dict[str, str]) -> Section:
    """All animals small, on sheets; each by itself folded, which paper leaves out; a few are drawn large there."""
    large = len(cohort.results) <= ON_A_SHEET
    colors = {group: look.color for group, look in group_looks(cohort.groups).items()}
    folds = []
    for place, result in enumerate(cohort.results, start=1):
        drawings = (_fit(result, place, colors[result.group]), _beats(result, place)) if large else ([], [])
        folds.append(_folded(result, *drawings, written))
    looks = [f"{result.name}: {text}" for result in cohort.results for text in texts(result.looks)]
    return Section(
        "animals",
        "Every animal",
        [*_sheets(cohort), *([Remarks("Recordings to look at", looks)] if looks else []), OnScreen(folds)],
    )


def animal_sections(cohort: Cohort, written: dict[str, str]) -> tuple[Section, Section]:
    """The only animal: what was found of it, and how it was searched for."""
    (result,) = cohort.results
    color = group_looks(cohort.groups)[result.group].color
    fit = [*_sentences(result, written), *_fit(result, 1, color)]
    return (
        Section("animal", "Fit and values", [*fit, *_values(result, written), *_beats(result, 1), *_notes(result)]),
        Section("search", "Search, correlations, numerics", _search(result, written)),
    )


def _title(result: AnimalResult) -> str:
    made = ", synthetic" if result.synthetic else ""
    count = len(result.findings)
    said = f", {count} {'note' if count == 1 else 'notes'}" if count else ""
    return f"{result.name} ({result.group}{made}{said})"


def _remarks(result: AnimalResult) -> list[Block]:
    notes = texts(result.findings)
    return [Remarks("Notes", notes)] if notes else []


def _notes(result: AnimalResult) -> list[Block]:
    """Return the notes folded, as they stand with the animals of a cohort."""
    remarks = _remarks(result)
    return [Fold(f"Notes ({len(result.findings)})", remarks)] if remarks else []


def _sentences(result: AnimalResult, written: dict[str, str]) -> list[Block]:
    blocks: list[Block] = []
    for wall in result.laws:
        blocks += [Heading(f"{wall.capitalize()} wall"), Bullets(fit_sentences(result, wall, written))]
    return blocks


def _folded(result: AnimalResult, fit: Sequence[Block], beats: Sequence[Block], written: dict[str, str]) -> Fold:
    details = _sentences(result, written) + _search(result, written)
    blocks = [*_remarks(result), *fit, *_values(result, written), *beats]
    blocks += [Fold("The fits in words; search, correlations, numerics", details)] if details else []
    return Fold(_title(result), blocks)


def _sheets(cohort: Cohort) -> list[Block]:
    caption = (
        "Measured (black) and fitted pressure at the inlet over one cycle, the largest error first; above each panel "
        "the RMSE in mmHg, in it the range of the measured pressure in mmHg, which its height shows"
    )
    parts = sheets(cohort.results)
    figures = [
        Drawing(f"fits-{place}", f"{caption} (sheet {place} of {len(parts)}).", sheet_figure(part, list(cohort.groups)))
        for place, part in enumerate(parts, start=1)
    ]
    where = "Beats, values and notes of each are on the page; one alone: vasowave report STUDY --animal NAME."
    return [Paragraph(where), *figures]


def _fit(result: AnimalResult, place: int, color: str) -> list[Block]:
    if not result.laws:
        return []
    caption = "Measured (black) and fitted pressure and flow at the inlet, and what is left."
    return [Drawing(f"fit-{place}", caption, fit_figure(result, color))]


def _beats(result: AnimalResult, place: int) -> list[Block]:
    """Return the beats of a continuous recording; an averaged cycle has none."""
    if result.beats is None or "trace_pressure" not in result.beats.data_vars:
        return []
    return [Drawing(f"beats-{place}", _beats_caption(result.beats), beats_figure(result))]


def _values(result: AnimalResult, written: dict[str, str]) -> list[Block]:
    """Return all values, with their intervals, and what the laws say together."""
    posteriors = {wall: law.posterior for wall, law in result.laws.items() if law.posterior is not None}
    laws = [laws_by_posterior(result.evidence)] if result.evidence is not None else []
    return [tables.values(result, written), *(tables.posterior(*one, written) for one in posteriors.items()), *laws]


def _search(result: AnimalResult, written: dict[str, str]) -> list[Block]:
    """Return how the parameters were searched and what was simulated."""
    blocks: list[Block] = []
    for wall in result.laws:
        blocks += [
            tables.estimates(result, wall, written),
            tables.correlations(result, wall, written),
            tables.starts(result, wall),
        ]
    return [*blocks, tables.numerics(result)] if blocks else []


def _beats_caption(beats: xr.Dataset) -> str:
    kept = int(beats["kept"].sum())
    causes = pd.Series([str(cause) for cause in beats["cause"].values if cause])
    rejected = "; ".join(f"{count} rejected: {cause}" for cause, count in causes.value_counts().items())
    return (
        f"{beats.sizes['beat']} beats detected, {kept} averaged{f'; {rejected}' if rejected else ''}. Above: recorded "
        "signals, triangles at detected beats; then every beat's diastolic level over the whole recording, with its "
        "drift; below: the averaged cycle."
    )
