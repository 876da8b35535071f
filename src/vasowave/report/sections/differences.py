"""How the groups differ, and what such groups can show at all, in sentences."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.animal.reading import data_of
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.comparison import Comparison
from vasowave.cohort.rank_tests import smallest_p
from vasowave.cohort.table import rows_of
from vasowave.report.wording import listed, name_and_unit, number

CLEAR = 0.05
"""p after Holm below which the summary calls a difference clear."""


def differences(cohort: Cohort, source: str, comparison: Comparison, written: Mapping[str, str]) -> list[str]:
    """Return one sentence for each pair of groups: effects with their intervals, and what the tests say of them."""
    if not len(comparison.contrasts):
        return []
    what = "measured" if source == "measured" else f"{source} wall"
    counts = rows_of(cohort.table, source)["group"].value_counts()
    sentences = []
    for pair, rows in comparison.contrasts.groupby(["reference", "other"], sort=False):
        reference, other = map(str, pair)
        sizes = int(counts[reference]), int(counts[other])
        says = _pair(rows, sizes, len(comparison.contrasts), written)
        sentences.append(f"{other} against {reference}, {what}: {says}.")
    return sentences


def limits(cohort: Cohort, comparisons: Mapping[str, Comparison]) -> list[str]:
    """Return what groups of these sizes, with these networks, cannot show."""
    if len(cohort.groups) < 2:
        return ["There is one group, so nothing is compared between groups."]
    tests = max((len(one.contrasts) for one in comparisons.values()), default=0)
    sentences = []
    for other in list(cohort.groups)[1:]:
        sizes = len(cohort.groups[cohort.reference]), len(cohort.groups[other])
        if min(sizes) >= 2 and tests:
            sentences.append(f"{cohort.reference} and {other}: {_what_n_can_show(*sizes, tests)}")
    return [*sentences, *_one_geometry(cohort)]


def _pair(rows: pd.DataFrame, sizes: tuple[int, int], tests: int, written: Mapping[str, str]) -> str:
    clear = rows["p Holm"] < CLEAR
    if clear.any():
        rest = [_symbol(row, written) for _, row in rows[~clear].iterrows()]
        others = f"; not clear: {', '.join(rest)}" if rest else ""
        return f"clear after Holm (over {tests} tests) are {_effects(rows[clear], written)}{others}"
    if tests * smallest_p(*sizes) >= CLEAR:
        return (
            f"{_apart(rows, written)}; {sizes[0]} + {sizes[1]} animals are too few for {tests} exact tests to confirm "
            "any difference"
        )
    return f"{_apart(rows, written)}; no exact test is below {CLEAR:g} after Holm (over {tests} tests)"


def _apart(rows: pd.DataFrame, written: Mapping[str, str]) -> str:
    """Name the ratios whose intervals leave 1 out, or the one that is farthest from 1."""
    apart = (rows["ratio low"] > 1) | (rows["ratio high"] < 1)
    if not apart.any():
        farthest = rows.loc[[np.log(rows["ratio"]).abs().idxmax()]]
        return f"the interval of every ratio holds 1, also of the largest change, {_effects(farthest, written)}"
    return _effects(rows[apart], written) + ("" if apart.all() else " (the other intervals hold 1)")


def _effects(rows: pd.DataFrame, written: Mapping[str, str]) -> str:
    return listed(
        [
            f"{_symbol(row, written)} {number(row['ratio'], 2)} times [{number(row['ratio low'], 2)}, "
            f"{number(row['ratio high'], 2)}]"
            for _, row in rows.iterrows()
        ]
    )


def _what_n_can_show(n_reference: int, n_other: int, tests: int) -> str:
    """Return a sentence on the smallest p that an exact test of groups of these sizes can give."""
    least = smallest_p(n_reference, n_other)
    after = min(1.0, tests * least)
    return (
        f"With {n_reference} + {n_other} animals complete separation gives p = {number(least, 2)} in an exact rank "
        f"test, {number(after, 2)} as the first of {tests} tests after Holm: it "
        f"{'can' if after < CLEAR else 'cannot'} fall below {CLEAR:g}."
    )


def _one_geometry(cohort: Cohort) -> list[str]:
    """Say where a group has one network for all its animals: its geometry is then one measurement, not n."""
    first, *others = cohort.groups
    alike = [group for group, trees in cohort.groups.items() if len(trees) > 1 and _share_a_network(trees)]
    if not alike:
        return []
    radius = {group: float(data_of(trees[0], "network")["radius"].values[0]) for group, trees in cohort.groups.items()}
    factors = listed([f"{number((radius[group] / radius[first]) ** 4, 2)} ({group} / {first})" for group in others])
    return [
        f"All animals of {listed(alike)} share the network of their group. Stiffness, compliance and wave speed "
        "contain its geometry (β grows with A0² of the root, here by a factor of "
        f"{factors}), which no interval and no test above knows: for geometry n is 1."
    ]


def _share_a_network(trees: list[xr.DataTree]) -> bool:
    first, *rest = (data_of(tree, "network") for tree in trees)
    return all(one.sizes == first.sizes and np.array_equal(one["radius"], first["radius"]) for one in rest)


def _symbol(row: pd.Series, written: Mapping[str, str]) -> str:
    name = name_and_unit(row["quantity"])[0]
    return written.get(name, name)
