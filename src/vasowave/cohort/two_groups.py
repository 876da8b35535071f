"""Two groups compared quantity by quantity: η, ratio, Hedges' g, rank test; and again without each animal."""

from itertools import combinations

import numpy as np
import pandas as pd

from vasowave.cohort.effects import hedges_g, importance_index
from vasowave.cohort.rank_tests import holm, mann_whitney
from vasowave.cohort.table import values_of
from vasowave.descriptions import LEVEL
from vasowave.errors import InputError


def contrasts(
    table: pd.DataFrame, quantities: list[str], reference: str, other: str, level: float = LEVEL
) -> pd.DataFrame:
    """Compare two groups: η (eq. 20), ratio of geometric means with Welch interval, Mann-Whitney, Holm.

    Hedges' g stands with its interval from the noncentral t distribution. The ratio needs positive values.

    Raises
    ------
    InputError
        As `describe`; a group with fewer than two animals; a value that is not positive.
    """
    from scipy import stats

    rows = []
    for quantity in quantities:
        x, y = values_of(table, quantity, reference), values_of(table, quantity, other)
        if min(len(x), len(y)) < 2:
            raise InputError(f"'{quantity}': a contrast needs two animals in each of '{reference}' and '{other}'")
        if min(x.min(), y.min()) <= 0:
            raise InputError(f"'{quantity}' holds a value that is not positive; a ratio needs positive values")
        welch = stats.ttest_ind(np.log(y), np.log(x), equal_var=False).confidence_interval(level)
        ratio = np.exp(np.log(y).mean() - np.log(x).mean())
        p = mann_whitney(x, y)
        eta = importance_index(x.mean(), y.mean())
        rows.append((quantity, eta, ratio, np.exp(welch.low), np.exp(welch.high), *hedges_g(x, y, level), p))
    columns = ["quantity", "eta", "ratio", "ratio low", "ratio high", "Hedges g", "g low", "g high", "p"]
    result = pd.DataFrame(rows, columns=columns)
    result["p Holm"] = holm(result["p"].to_numpy())
    return result


def pairwise_contrasts(table: pd.DataFrame, quantities: list[str], level: float = LEVEL) -> pd.DataFrame:
    """`contrasts` of every pair of groups, first-named as reference; Holm runs over all pairs and quantities."""
    labels = table["group"].unique().tolist() if "group" in table.columns else []
    parts = []
    for reference, other in combinations(labels, 2):
        part = contrasts(table, quantities, reference, other, level)
        part.insert(0, "reference", reference)
        part.insert(1, "other", other)
        parts.append(part)
    if not parts:
        raise InputError("a comparison needs a column 'group' with at least two labels")
    result = pd.concat(parts, ignore_index=True)
    result["p Holm"] = holm(result["p"].to_numpy())
    return result


def leave_one_out(table: pd.DataFrame, quantities: list[str], reference: str, other: str) -> pd.DataFrame:
    """Repeat the ratio of `contrasts` without each animal in turn, to see whether one of them carries it.

    Returns
    -------
    DataFrame
        One row per quantity and animal: ``left out`` (the index of `table`), ``group``, ``ratio`` without it, and
        ``ratio shift``, that ratio over the one of all animals.

    Raises
    ------
    InputError
        As `contrasts`; a group with fewer than three animals.
    """
    pair = table[table["group"].isin([reference, other])] if "group" in table.columns else table
    smallest = min(values_of(pair, name, group).min() for name in quantities for group in (reference, other))
    if pair["group"].value_counts().min() < 3:
        raise InputError(f"leaving one animal out needs three animals in each of '{reference}' and '{other}'")
    if smallest <= 0:
        raise InputError(f"one of {', '.join(quantities)} holds a value that is not positive; a ratio needs them")
    logs, second = np.log(pair[quantities].to_numpy(float)), (pair["group"] == other).to_numpy()
    sizes = np.where(second, second.sum(), (~second).sum())[:, np.newaxis]
    means = {label: logs[second == label].mean(axis=0) for label in (False, True)}
    own = np.where(second[:, np.newaxis], means[True], means[False])
    shift = (own - logs) / (sizes - 1)  # of the mean of its group, without the animal
    everyone = means[True] - means[False]
    ratio = np.exp(everyone + np.where(second[:, np.newaxis], shift, -shift))
    labels = {
        "quantity": quantities * len(pair),
        "left out": np.repeat(pair.index, len(quantities)),
        "group": np.repeat(pair["group"].to_numpy(), len(quantities)),
    }
    ratios = {"ratio": ratio.ravel(), "ratio shift": (ratio / np.exp(everyone)).ravel()}
    return pd.DataFrame(labels | ratios).sort_values("quantity", kind="stable", ignore_index=True)
