"""What the animals show, in sentences; every number comes from the trees."""

from collections import Counter
from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.animal.reading import is_synthetic, name_of, notes_of, wall_laws
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.comparison import Comparison
from vasowave.cohort.table import INDICES, column, rows_of
from vasowave.cohort.votes import DISCARDED, UNDECIDED, ballots, vote
from vasowave.report.blocks import Block, Bullets, Heading, Notice, Remarks, Section
from vasowave.report.sections.differences import differences, limits
from vasowave.report.sections.fits import fit_sentences
from vasowave.report.tables.cells import named
from vasowave.report.wording import listed, name_and_unit, number


def summary_section(
    cohort: Cohort, comparisons: Mapping[str, Comparison], failures: Mapping[str, str], written: dict[str, str]
) -> Section:
    """Return what is wrong, what the animals show, and what is good to know."""
    failed = [f"{name}: {why}" for name, why in failures.items()]
    blocks: list[Block] = [Notice("Animals that failed", failed)] if failed else []
    blocks += _one(cohort.trees[0], cohort, written) if cohort.single else _many(cohort, comparisons, written)
    return Section("summary", "Summary", blocks)


def synthetic_banner(cohort: Cohort) -> str:
    """Say which animals are synthetic; empty if none is."""
    made = [tree for tree in cohort.trees if is_synthetic(tree)]
    if not made:
        return ""
    which = f"All {len(made)} animals were" if len(made) == len(cohort.trees) else f"The animals {named(made)} were"
    return (
        f"{'This animal was' if cohort.single else which} made by a model, not measured. The numbers show how the "
        "program works and say nothing about any living animal."
    )


def _one(tree: xr.DataTree, cohort: Cohort, written: dict[str, str]) -> list[Block]:
    blocks: list[Block] = [Bullets([_recording(cohort), *_selection(cohort)])]
    for wall in wall_laws(tree):
        blocks += [Heading(f"{wall.capitalize()} wall"), Bullets(fit_sentences(tree, wall, written))]
    notes = notes_of(tree)
    return [*blocks, *([Remarks("Notes", notes)] if notes else [])]


def _many(cohort: Cohort, comparisons: Mapping[str, Comparison], written: dict[str, str]) -> list[Block]:
    sentences = [
        _animals(cohort),
        *(_indices(cohort, group) for group in cohort.groups),
        *(text for source, one in comparisons.items() for text in differences(cohort, source, one, written)),
        *(_fits(cohort, wall, written) for wall in cohort.walls),
        *_selection(cohort),
        *limits(cohort, comparisons),
    ]
    return [Bullets(sentences), *_considered(cohort)]


def _considered(cohort: Cohort) -> list[Block]:
    """Return what makes animals unlike each other as an alarm, and quietly where notes are."""
    alarms = [
        f"{name_of(tree)} was not calibrated with the {wall} wall."
        for wall in cohort.walls
        for tree in cohort.trees
        if wall not in wall_laws(tree)
    ]
    if differing := cohort.differing_settings:
        alarms.append(f"The animals were not all analyzed with the same settings: {', '.join(differing)}.")
    blocks: list[Block] = [Notice("To be considered", alarms)] if alarms else []
    count = sum(len(notes_of(tree)) for tree in cohort.trees)
    if count:
        blocks.append(Remarks("Notes", [f"{count} notes on single animals stand with them under “Every animal”."]))
    return blocks


def _recording(cohort: Cohort) -> str:
    row = rows_of(cohort.table, "measured").iloc[0]
    value = {name: number(row[column(cohort.table, name)]) for name in INDICES}
    return (
        f"Mean pressure {value['mPAP']} mmHg (systolic {value['sPAP']}, diastolic {value['dPAP']}, pulse "
        f"{value['pPAP']} mmHg) at a cardiac output of {value['CO']} ml/s and {value['HR']} beats/min: a pulmonary "
        f"vascular resistance of {value['PVR']} mmHg s/ml."
    )


def _animals(cohort: Cohort) -> str:
    groups = listed([f"{group} (n = {len(trees)})" for group, trees in cohort.groups.items()])
    walls = listed([f"the {wall} wall law" for wall in cohort.walls])
    calibrated = f", each calibrated with {walls}" if walls else ""
    return f"{len(cohort.trees)} animals: {groups}{calibrated}."


def _indices(cohort: Cohort, group: str) -> str:
    rows = rows_of(cohort.table, "measured")
    rows = rows[rows["group"] == group]
    parts = []
    for name in ("mPAP", "CO", "PVR"):
        label = column(rows, name)
        spread = f" ± {number(rows[label].std(), 2)}" if len(rows) > 1 else ""
        parts.append(f"{name} {number(rows[label].mean())}{spread} {name_and_unit(label)[1]}")
    return f"{group}, measured: {', '.join(parts)}."


def _fits(cohort: Cohort, wall: str, written: Mapping[str, str]) -> str:
    fits = cohort.calibrations(wall)
    rmse = np.array([float(fit["RMSE"]) for fit in fits])
    agree = sum(bool(fit["start_agrees"].values.astype(bool).all()) for fit in fits)
    return (
        f"The {wall} wall leaves a root-mean-square residual of {number(float(np.median(rmse)))} mmHg (median; "
        f"{number(float(rmse.min()))} to {number(float(rmse.max()))}); all starts agreed in {agree} of {len(fits)} "
        f"animals{_undetermined(fits, written)}."
    )


def _undetermined(fits: list[xr.Dataset], written: Mapping[str, str]) -> str:
    open_ones = Counter(
        str(name)
        for fit in fits
        for name in fit["parameter"].values[fit["free"].values.astype(bool) & ~fit["determined"].values.astype(bool)]
    )
    if not open_ones:
        return "; the data determine every parameter"
    parts = [f"{written.get(str(name), name)} in {open_ones[name]}" for name in fits[0]["parameter"].values
             if name in open_ones]  # fmt: skip
    return f"; the data do not determine {listed(parts)} of them"


def _selection(cohort: Cohort) -> list[str]:
    if not cohort.compared:
        return []
    if cohort.single:
        return [_verdict(vote(cohort.trees[0]))]
    votes = Counter(vote(tree) for tree in cohort.compared)
    told = listed([f"the {wall} wall in {votes[wall]}" for wall in cohort.walls])
    lost = f" In {votes[DISCARDED]} no noise model could be kept." if votes[DISCARDED] else ""
    every = pd.concat([ballots(tree) for tree in cohort.compared])
    joint = every[every["sharing"] == "joint"] if "sharing" in every else every
    counts = Counter(joint["AICc prefers"])
    others = listed([f"{wall} {counts[wall]}" for wall in cohort.walls])
    return [
        f"Under the likeliest noise model of each animal, AICc at the least-squares optimum prefers {told} of "
        f"{len(cohort.compared)} animals and leaves {votes[UNDECIDED]} undecided.{lost} Over all noise models (animals "
        f"times models): {others}, undecided {counts[UNDECIDED]}, discarded {counts[DISCARDED]}."
    ]


def _verdict(preferred: str) -> str:
    if preferred == DISCARDED:
        return "No noise model could be kept, so the residuals prefer no wall law."
    says = "does not decide between the wall laws" if preferred == UNDECIDED else f"prefers the {preferred} wall"
    return f"Under the likeliest noise model, AICc at the least-squares optimum {says}."
