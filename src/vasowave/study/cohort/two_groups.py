"""Two groups compared quantity by quantity: η, ratio, Hedges' g, rank test; and again without each animal."""

from itertools import combinations
from math import comb

import numpy as np
import pandas as pd

from vasowave.base.descriptions import LEVEL
from vasowave.base.errors import InputError
from vasowave.study.cohort.table import values_of

MAX_EXACT_ANIMALS = 200
"""Animals of two groups together up to which a Mann-Whitney test is exact; its work grows with their fourth power."""


def importance_index(reference: float, group_mean: float) -> float:
    """Importance index η = (χ_other - χ_reference)/χ_reference (eq. 20); never below -1 for positive quantities."""
    return (group_mean - reference) / reference


def importance_interval(reference: np.ndarray, group: np.ndarray) -> tuple[float, float]:
    """Return the interval of 95 % of η of two groups' values: Fieller's, with Welch's degrees of freedom.

    NaN with fewer than two values in a group, without variation, or where the reference mean may be zero.
    """
    from scipy.special import stdtrit

    if min(len(reference), len(group)) < 2:
        return np.nan, np.nan
    mean, above = float(np.mean(reference)), float(np.mean(group))
    variances = [float(np.var(x, ddof=1)) / len(x) for x in (reference, group)]
    ratio = above / mean
    terms = ratio**2 * variances[0], variances[1]
    spread = terms[0] ** 2 / (len(reference) - 1) + terms[1] ** 2 / (len(group) - 1)
    if not spread > 0:
        return np.nan, np.nan
    t = stdtrit(sum(terms) ** 2 / spread, (1 + LEVEL) / 2)
    lead, constant = mean**2 - t**2 * variances[0], above**2 - t**2 * variances[1]
    if lead <= 0:
        return np.nan, np.nan
    root = np.sqrt((mean * above) ** 2 - lead * constant)
    low, high = sorted(((mean * above - root) / lead, (mean * above + root) / lead))
    return low - 1, high - 1


def hedges_g(x: np.ndarray, y: np.ndarray, level: float = LEVEL) -> tuple[float, float, float]:
    """Hedges' g of y against x with its interval, by inverting the noncentral t distribution (equal variances).

    Raises
    ------
    InputError
        Fewer than two values in a group, or no variation in either.
    """
    from scipy.optimize import brentq
    from scipy.special import gammaincinv, ndtr

    if min(len(x), len(y)) < 2:
        raise InputError("Hedges' g needs two values in each group")
    freedom = len(x) + len(y) - 2
    pooled = np.sqrt(((len(x) - 1) * x.var(ddof=1) + (len(y) - 1) * y.var(ddof=1)) / freedom)
    if not pooled > 0:
        raise InputError("Hedges' g needs variation within a group")
    scale = np.sqrt(1 / len(x) + 1 / len(y))
    t = float((y.mean() - x.mean()) / pooled / scale)

    # The noncentral t distribution, averaged over the pooled SD; SciPy's own is NaN far out in its tail.
    turn = (np.arange(400) + 0.5) * np.pi / 400  # quantiles that crowd towards 0 and 1, where the tails are
    sd = np.sqrt(2 * gammaincinv(freedom / 2, 0.5 * (1 - np.cos(turn))) / freedom)
    share = np.sin(turn) / np.sin(turn).sum()

    def center(tail: float) -> float:
        reach = 10 + 5 * abs(t)
        return float(brentq(lambda shift: (share * ndtr(t * sd - shift)).sum() - tail, t - reach, t + reach))

    correction = (1 - 3 / (4 * freedom - 1)) * scale
    return correction * t, correction * center((1 + level) / 2), correction * center((1 - level) / 2)


def mann_whitney(x: np.ndarray, y: np.ndarray) -> float:
    """Two-sided p of the rank-sum test: exact for up to `MAX_EXACT_ANIMALS` animals, else by the normal distribution.

    The normal distribution is corrected for ties and for the ranks' being whole numbers.
    """
    from scipy.stats import mannwhitneyu

    if len(x) + len(y) <= MAX_EXACT_ANIMALS:
        return exact_mann_whitney(x, y)
    return float(mannwhitneyu(x, y, method="asymptotic").pvalue)


def exact_mann_whitney(x: np.ndarray, y: np.ndarray) -> float:
    """Two-sided exact p of the rank-sum permutation test; ties get mean ranks and stay exact."""
    from scipy.stats import rankdata

    ranks = np.rint(2 * rankdata(np.concatenate([x, y]))).astype(int)  # doubled, so that mean ranks are integers
    ranks //= np.gcd.reduce(ranks)
    total, k = int(ranks.sum()), len(x)
    # How many choices of k animals have each rank sum, one animal after the other: no list of all choices is needed.
    choices = np.zeros((k + 1, total + 1))
    choices[0, 0] = 1
    ascending = np.sort(ranks)
    for count, (rank, largest) in enumerate(zip(ascending, np.cumsum(ascending), strict=True), start=1):
        fewest = max(1, k - (len(ranks) - count))  # with fewer there are not k in the end
        for chosen in range(min(count, k), fewest - 1, -1):
            choices[chosen, rank : largest + 1] += choices[chosen - 1, : largest + 1 - rank]
    center = k * total / len(ranks)
    extreme = np.abs(np.arange(total + 1) - center) >= abs(ranks[:k].sum() - center) - 1e-9
    return float(choices[-1][extreme].sum() / comb(len(ranks), k))


def holm(p: np.ndarray) -> np.ndarray:
    """Holm's step-down adjusted p values, in the order given."""
    order = np.argsort(p)
    stepped = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    adjusted = np.empty(len(p))
    adjusted[order] = np.minimum(stepped, 1.0)
    return adjusted


def contrasts(
    table: pd.DataFrame, quantities: list[str], reference: str, group: str, level: float = LEVEL
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
        x, y = values_of(table, quantity, reference), values_of(table, quantity, group)
        if min(len(x), len(y)) < 2:
            raise InputError(f"'{quantity}': a contrast needs two animals in each of '{reference}' and '{group}'")
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
    pair_tables = []
    for reference, group in combinations(labels, 2):
        pair_table = contrasts(table, quantities, reference, group, level)
        pair_table.insert(0, "reference", reference)
        pair_table.insert(1, "other", group)
        pair_tables.append(pair_table)
    if not pair_tables:
        raise InputError("a comparison needs a column 'group' with at least two labels")
    result = pd.concat(pair_tables, ignore_index=True)
    result["p Holm"] = holm(result["p"].to_numpy())
    return result


def leave_one_out(table: pd.DataFrame, quantities: list[str], reference: str, group: str) -> pd.DataFrame:
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
    pair = table[table["group"].isin([reference, group])] if "group" in table.columns else table
    smallest = min(values_of(pair, name, label).min() for name in quantities for label in (reference, group))
    if pair["group"].value_counts().min() < 3:
        raise InputError(f"leaving one animal out needs three animals in each of '{reference}' and '{group}'")
    if smallest <= 0:
        raise InputError(f"one of {', '.join(quantities)} holds a value that is not positive; a ratio needs them")
    logs, second = np.log(pair[quantities].to_numpy(float)), (pair["group"] == group).to_numpy()
    sizes = np.where(second, second.sum(), (~second).sum())[:, np.newaxis]
    means = {label: logs[second == label].mean(axis=0) for label in (False, True)}
    group_means = np.where(second[:, np.newaxis], means[True], means[False])
    shift = (group_means - logs) / (sizes - 1)  # of the mean of its group, without the animal
    everyone = means[True] - means[False]
    ratio = np.exp(everyone + np.where(second[:, np.newaxis], shift, -shift))
    labels = {
        "quantity": quantities * len(pair),
        "left out": np.repeat(pair.index, len(quantities)),
        "group": np.repeat(pair["group"].to_numpy(), len(quantities)),
    }
    ratios = {"ratio": ratio.ravel(), "ratio shift": (ratio / np.exp(everyone)).ravel()}
    return pd.DataFrame(labels | ratios).sort_values("quantity", kind="stable", ignore_index=True)
