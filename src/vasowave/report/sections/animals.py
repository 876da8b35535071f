"""Every animal: what must be considered, its beats, its fits, its values with intervals, how they were searched."""

import pandas as pd
import xarray as xr

from vasowave.animal.reading import data_of, group_of, is_synthetic, name_of, notes_of, wall_laws
from vasowave.cohort.cohort import Cohort
from vasowave.figures.measured import beats_figure
from vasowave.figures.modeled import fit_figure
from vasowave.figures.style import group_looks
from vasowave.report.blocks import Block, Bullets, Drawing, Fold, Heading, Remarks, Section
from vasowave.report.sections.fits import fit_sentences
from vasowave.report.tables import animal as tables


def animals_section(cohort: Cohort, written: dict[str, str]) -> Section:
    """All animals, each folded."""
    colors = {group: look.color for group, look in group_looks(cohort.groups).items()}
    folds = []
    for place, tree in enumerate(cohort.trees, start=1):
        details = _sentences(tree, written) + _search(tree, written)
        blocks = _remarks(tree) + _animal(tree, place, colors[group_of(tree)], written)
        blocks += [Fold("The fits in words; search, correlations, numerics", details, printed=False)] if details else []
        folds.append(Fold(_title(tree), blocks))
    return Section("animals", "Every animal", folds)


def animal_sections(cohort: Cohort, written: dict[str, str]) -> tuple[Section, Section]:
    """The only animal: what was found of it, and how it was searched for."""
    (tree,) = cohort.trees
    color = group_looks(cohort.groups)[group_of(tree)].color
    return (
        Section(
            "animal", "Fit and values", [*_sentences(tree, written), *_animal(tree, 1, color, written), *_notes(tree)]
        ),
        Section("search", "Search, correlations, numerics", _search(tree, written)),
    )


def _title(tree: xr.DataTree) -> str:
    made = ", synthetic" if is_synthetic(tree) else ""
    count = len(notes_of(tree))
    said = f", {count} {'note' if count == 1 else 'notes'}" if count else ""
    return f"{name_of(tree)} ({group_of(tree)}{made}{said})"


def _remarks(tree: xr.DataTree) -> list[Block]:
    notes = notes_of(tree)
    return [Remarks("Notes", notes)] if notes else []


def _notes(tree: xr.DataTree) -> list[Block]:
    """Return the notes folded, as they stand with the animals of a cohort."""
    remarks = _remarks(tree)
    return [Fold(f"Notes ({len(notes_of(tree))})", remarks)] if remarks else []


def _sentences(tree: xr.DataTree, written: dict[str, str]) -> list[Block]:
    blocks: list[Block] = []
    for wall in wall_laws(tree):
        blocks += [Heading(f"{wall.capitalize()} wall"), Bullets(fit_sentences(tree, wall, written))]
    return blocks


def _animal(tree: xr.DataTree, place: int, color: str, written: dict[str, str]) -> list[Block]:
    """Return the fit, all values, and the beats."""
    blocks: list[Block] = []
    if wall_laws(tree):
        caption = "Measured (black) and fitted pressure and flow at the inlet, and what is left."
        blocks.append(Drawing(f"fit-{place}", caption, fit_figure(tree, color)))
    blocks.append(tables.values(tree, written))
    drawn = [wall for wall in wall_laws(tree) if "inference" in tree[wall].children]
    blocks += [tables.posterior(tree, wall, written) for wall in drawn]
    if "beats" in tree.children and "trace_pressure" in data_of(tree, "beats").data_vars:
        blocks.append(Drawing(f"beats-{place}", _beats_caption(tree), beats_figure(tree)))
    return blocks


def _search(tree: xr.DataTree, written: dict[str, str]) -> list[Block]:
    """Return how the parameters were searched and what was simulated."""
    blocks: list[Block] = []
    for wall in wall_laws(tree):
        blocks += [
            tables.estimates(tree, wall, written),
            tables.correlations(tree, wall, written),
            tables.starts(tree, wall),
        ]
    return [*blocks, tables.numerics(tree)] if blocks else []


def _beats_caption(tree: xr.DataTree) -> str:
    beats = data_of(tree, "beats")
    kept = int(beats["kept"].sum())
    reasons = pd.Series([str(reason).split(":")[0] for reason in beats["reason"].values if reason])
    rejected = "; ".join(f"{count} rejected: {reason}" for reason, count in reasons.value_counts().items())
    return (
        f"{beats.sizes['beat']} beats detected, {kept} averaged{f'; {rejected}' if rejected else ''}. Above: recorded "
        "signals, triangles at detected beats; below: the averaged cycle."
    )
