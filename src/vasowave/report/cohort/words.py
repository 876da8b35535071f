"""What a cohort shows, in sentences; every number comes from the trees."""

import json
from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.animal.reading import data_of, wall_laws
from vasowave.cohort.comparison import Comparison, column, rows_of
from vasowave.cohort.statistics import what_n_can_show
from vasowave.figures.cohort_gallery import Cohort
from vasowave.report.cohort.selection_table import selection_table
from vasowave.report.wording import listed, name_and_unit, number
from vasowave.selection.criteria import UNDECIDED

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
        text = (
            f"clear after Holm (over these {len(rows)}) are {listed(changed)}"
            if changed
            else "no difference is clear after Holm"
        )
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
    votes = [_vote(data_of(tree, "selection")) for tree in cohort.trees if "selection" in tree.children]
    told = listed([f"the {wall} wall in {votes.count(wall)}" for wall in cohort.walls])
    data = selection_table(cohort).data
    assert data is not None
    joint = data[data["sharing"] == "joint"] if "sharing" in data else data
    counts = joint["AICc prefers"].value_counts()
    others = listed([f"{wall} {int(counts.get(wall, 0))}" for wall in cohort.walls])
    return [
        f"Under the likeliest noise model of each animal, AICc at the least-squares optimum prefers {told} of "
        f"{len(votes)} animals and leaves {votes.count('undecided')} undecided. Over all noise models (animals times "
        f"models): {others}, undecided {int(counts.get('undecided', 0))}, discarded {int(counts.get('discarded', 0))}."
    ]


def _vote(table: xr.Dataset) -> str:
    """Return the wall law that AICc prefers under the likeliest noise model of one animal, or "undecided"."""
    frame = table.to_dataframe()
    best = frame[frame["covariance"] == table.attrs.get("preferred_covariance", frame["covariance"].iloc[0])]
    for key, first in (("sharing", "joint"), ("optimum", "OLS")):
        if key in best:
            best = best[best[key] == first]
    scores = best.set_index("wall")["AICc"]
    return str(scores.idxmin()) if scores.max() - scores.min() >= UNDECIDED else "undecided"


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
    sentences += _one_geometry(cohort)
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
            f"Leaving out one animal moves p (after Holm) across 0.05 in {len(carried)} combinations of animal and "
            "quantity: see the tables of one animal left out."
        )
    elif any(len(one.without_one) for one in found.values()):
        sentences.append("Leaving out any one animal moves no p (after Holm) across 0.05.")
    return sentences


def _one_geometry(cohort: Cohort) -> list[str]:
    """Say where a group has one network for all its animals: its geometry is then one measurement, not n."""
    first, *others = cohort.groups
    single = [group for group, trees in cohort.groups.items() if len(trees) > 1 and _share_a_network(trees)]
    if not single:
        return []
    area = {
        group: float(data_of(trees[0], "network")["radius"].values[0]) ** 2 for group, trees in cohort.groups.items()
    }
    factors = listed([f"{number((area[group] / area[first]) ** 2, 2)} ({group} / {first})" for group in others])
    return [
        f"All animals of {listed(single)} share the network of their group. Stiffness, compliance and wave speed "
        "contain its geometry (β grows with A0² of the root, here by a factor of "
        f"{factors}), which no interval and no test above knows: for geometry n is 1."
    ]


def _share_a_network(trees: list[xr.DataTree]) -> bool:
    first, *rest = (data_of(tree, "network") for tree in trees)
    return all(one.sizes == first.sizes and np.array_equal(one["radius"], first["radius"]) for one in rest)


def _symbol(row: pd.Series, written: Mapping[str, str]) -> str:
    name = name_and_unit(row["quantity"])[0]
    return written.get(name, name)


def settings_of(cohort: Cohort) -> dict[str, object]:
    """Return the settings that all animals share; those that differ are left out."""
    each = [json.loads(tree.attrs.get("settings", "{}")) for tree in cohort.trees]
    return {key: value for key, value in each[0].items() if all(one.get(key) == value for one in each)}
