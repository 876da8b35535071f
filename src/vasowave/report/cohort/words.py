"""What a cohort shows, in sentences; every number comes from the trees."""

import json
from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.cohort import what_n_can_show
from vasowave.figures.cohort_gallery import Cohort
from vasowave.figures.trees import data_of, wall_laws
from vasowave.report.cohort.selection_table import selection_table
from vasowave.report.cohort.statistics import Comparison, column, rows_of
from vasowave.report.wording import listed, name_and_unit, number

CLEAR = 0.05
"""p after Holm below which the summary calls a difference clear."""


def notes(tree: xr.DataTree) -> list[str]:
    """Return what a reader must know about one animal."""
    return [str(note) for note in json.loads(tree.attrs.get("notes", "[]"))]


def is_synthetic(tree: xr.DataTree) -> bool:
    """Say whether an animal was made and not measured."""
    return bool(int(tree.attrs.get("synthetic", 0)))


def synthetic_banner(cohort: Cohort) -> str:
    """Say which animals are synthetic; empty if none is."""
    made = [str(tree.attrs["animal"]) for tree in cohort.trees if is_synthetic(tree)]
    if not made:
        return ""
    which = f"All {len(made)} animals" if len(made) == len(cohort.trees) else f"The animals {', '.join(made)}"
    return (
        f"{which} were made by a model, not measured. The numbers show how the program works and say nothing about any "
        "living animal."
    )


def summary(cohort: Cohort, found: Mapping[str, Comparison], written: Mapping[str, str]) -> list[str]:
    """Return what the cohort shows: animals, indices, differences, fits, and what the numbers cannot show."""
    return [
        _animals(cohort),
        *(_indices(cohort, group) for group in cohort.groups),
        *(text for source, comparison in found.items() for text in _differences(source, comparison, written)),
        *_fits(cohort),
        *_selection(cohort),
        *_limits(cohort, found),
    ]


def failure_sentences(failures: Mapping[str, str]) -> list[str]:
    """Name the animals that failed, and why."""
    return [f"{name}: {why}" for name, why in failures.items()]


def _animals(cohort: Cohort) -> str:
    groups = listed([f"{group} (n = {len(trees)})" for group, trees in cohort.groups.items()])
    count = len(cohort.trees)
    walls = listed([f"the {wall} wall law" for wall in cohort.walls])
    calibrated = f", each calibrated with {walls}" if walls else ""
    return f"{count} {'animal' if count == 1 else 'animals'}: {groups}{calibrated}."


def _indices(cohort: Cohort, group: str) -> str:
    rows = rows_of(cohort.table, "measured")
    rows = rows[rows["group"] == group]
    parts = []
    for name in ("mPAP", "CO", "PVR"):
        label = column(rows, name)
        if label:
            spread = f" ± {number(rows[label].std(), 2)}" if len(rows) > 1 else ""
            parts.append(f"{name} {number(rows[label].mean())}{spread} {name_and_unit(label)[1]}")
    return f"{group}, measured: {', '.join(parts)}."


def _differences(source: str, found: Comparison, written: Mapping[str, str]) -> list[str]:
    sentences = []
    pairs = found.contrasts[["reference", "other"]].drop_duplicates() if len(found.contrasts) else pd.DataFrame()
    for _, pair in pairs.iterrows():
        rows = found.contrasts
        rows = rows[(rows["reference"] == pair["reference"]) & (rows["other"] == pair["other"])]
        clear, rest = rows[rows["p Holm"] < CLEAR], rows[rows["p Holm"] >= CLEAR]
        what = "measured" if source == "measured" else f"{source} wall"
        lead = f"{pair['other']} against {pair['reference']}, {what}: "
        changed = [
            f"{_symbol(row, written)} {number(row['ratio'], 2)} times [{number(row['ratio low'], 2)}, "
            f"{number(row['ratio high'], 2)}]"
            for _, row in clear.iterrows()
        ]
        text = f"clear after Holm are {listed(changed)}" if changed else "no difference is clear after Holm"
        others = f"; not clear: {', '.join(_symbol(row, written) for _, row in rest.iterrows())}" if len(rest) else ""
        sentences.append(f"{lead}{text}{others if changed else ''}.")
    return sentences


def _fits(cohort: Cohort) -> list[str]:
    sentences = []
    for wall in cohort.walls:
        fits = [data_of(tree, f"{wall}/calibration") for tree in cohort.trees if wall in wall_laws(tree)]
        rmse = np.array([float(fit["RMSE"]) for fit in fits])
        agree = sum(bool(fit["start_agrees"].values.astype(bool).all()) for fit in fits)
        text = (
            f"The {wall} wall leaves a root-mean-square residual of {number(float(np.median(rmse)))} mmHg (median; "
            f"{number(float(rmse.min()))} to {number(float(rmse.max()))}); all starts agreed in {agree} of {len(fits)} "
            "animals"
        )
        sentences.append(f"{text}{_undetermined(fits)}.")
    return sentences


def _undetermined(fits: list[xr.Dataset]) -> str:
    parts = []
    for place, name in enumerate(fits[0]["parameter"].values):
        count = sum(bool(fit["free"].values[place]) and not bool(fit["determined"].values[place]) for fit in fits)
        if count:
            parts.append(f"{name} in {count}")
    return f"; the data do not determine {listed(parts)} of them" if parts else "; the data determine every parameter"


def _selection(cohort: Cohort) -> list[str]:
    if not any("selection" in tree.children for tree in cohort.trees):
        return []
    data = selection_table(cohort).data
    assert data is not None
    counts = data["AICc prefers"].value_counts()
    kept = len(data) - int(counts.get("discarded", 0))
    votes = listed([f"the {wall} wall in {int(counts.get(wall, 0))}" for wall in cohort.walls])
    return [
        f"Of {kept} comparisons of the wall laws (animals times noise models that were not discarded) AICc prefers "
        f"{votes}, and {int(counts.get('undecided', 0))} are undecided."
    ]


def _limits(cohort: Cohort, found: Mapping[str, Comparison]) -> list[str]:
    if len(cohort.groups) < 2:
        return ["There is one group, so nothing is compared between groups."]
    sentences = []
    first = next(iter(cohort.groups))
    tests = max((len(one.contrasts) for one in found.values()), default=0)
    for other in list(cohort.groups)[1:]:
        sizes = len(cohort.groups[first]), len(cohort.groups[other])
        if min(sizes) >= 2 and tests:
            sentences.append(f"{first} and {other}: {what_n_can_show(*sizes, tests)}")
    carried = [
        f"{label} ({source}, without {animal})"
        for source, one in found.items()
        if len(one.without_one)
        for label, animal in one.without_one.loc[one.without_one["decides"], ["quantity", "left out"]].itertuples(
            index=False
        )
    ]
    if carried:
        sentences.append(
            f"Leaving out one animal moves p across 0.05 (before Holm) in {len(carried)} combinations of animal and "
            "quantity: see the tables of one animal left out."
        )
    elif any(len(one.without_one) for one in found.values()):
        sentences.append("Leaving out any one animal moves no p across 0.05 (before Holm).")
    return sentences


def _symbol(row: pd.Series, written: Mapping[str, str]) -> str:
    name = name_and_unit(row["quantity"])[0]
    return written.get(name, name)


def settings_of(cohort: Cohort) -> dict[str, object]:
    """Return the settings that all animals share; those that differ are left out."""
    each = [json.loads(tree.attrs.get("settings", "{}")) for tree in cohort.trees]
    return {key: value for key, value in each[0].items() if all(one.get(key) == value for one in each)}
