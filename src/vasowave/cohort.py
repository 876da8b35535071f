"""Groups of animals: description, contrasts with intervals, exact tests."""

from math import comb

import numpy as np
import pandas as pd

from vasowave.errors import InputError


def describe(table: pd.DataFrame, quantities: list[str]) -> pd.DataFrame:
    """Mean, SD, median and quartiles of every quantity in every group, in the unit of its column name.

    Parameters
    ----------
    table : DataFrame
        One row per animal, with a column ``group`` of any labels.
    quantities : list of str
        Columns to describe, named ``quantity [unit]``.

    Raises
    ------
    InputError
        A column that is missing or holds a value that is not finite.
    """
    rows = []
    for quantity in quantities:
        for label in table["group"].unique():
            x = _values(table, quantity, label)
            q1, median, q3 = np.percentile(x, [25, 50, 75])
            sd = float(x.std(ddof=1)) if len(x) > 1 else float("nan")
            rows.append((quantity, label, len(x), x.mean(), sd, median, q1, q3))
    return pd.DataFrame(rows, columns=["quantity", "group", "n", "mean", "SD", "median", "Q1", "Q3"])


def contrasts(
    table: pd.DataFrame, quantities: list[str], reference: str, other: str, level: float = 0.95
) -> pd.DataFrame:
    """Compare two groups: η (eq. 20), ratio of geometric means with Welch interval, exact Mann-Whitney, Holm.

    Hedges' g is given without an interval. The ratio needs positive values.

    Raises
    ------
    InputError
        As `describe`; a group with fewer than two animals; a value that is not positive.
    """
    from scipy import stats

    rows = []
    for quantity in quantities:
        x, y = _values(table, quantity, reference), _values(table, quantity, other)
        if min(len(x), len(y)) < 2:
            raise InputError(f"'{quantity}': a contrast needs two animals in each of '{reference}' and '{other}'")
        if min(x.min(), y.min()) <= 0:
            raise InputError(f"'{quantity}' holds a value that is not positive; a ratio needs positive values")
        welch = stats.ttest_ind(np.log(y), np.log(x), equal_var=False).confidence_interval(level)
        pooled = np.sqrt(((len(x) - 1) * x.var(ddof=1) + (len(y) - 1) * y.var(ddof=1)) / (len(x) + len(y) - 2))
        small = 1 - 3 / (4 * (len(x) + len(y)) - 9)
        ratio = np.exp(np.log(y).mean() - np.log(x).mean())
        p = exact_mann_whitney(x, y)
        eta = importance_index(x.mean(), y.mean())
        g = small * (y.mean() - x.mean()) / pooled
        rows.append((quantity, eta, ratio, np.exp(welch.low), np.exp(welch.high), g, p))
    found = pd.DataFrame(rows, columns=["quantity", "eta", "ratio", "ratio low", "ratio high", "Hedges g", "p"])
    found["p Holm"] = holm(found["p"].to_numpy())
    return found


def importance_index(reference: float, other: float) -> float:
    """Importance index η = (χ_other - χ_reference)/χ_reference (eq. 20); never below -1 for positive quantities."""
    return (other - reference) / reference


def exact_mann_whitney(x: np.ndarray, y: np.ndarray) -> float:
    """Two-sided exact p of the rank-sum permutation test; ties get mean ranks and stay exact."""
    from itertools import combinations

    from scipy.stats import rankdata

    if comb(len(x) + len(y), len(x)) > 500_000:
        raise InputError(f"{len(x)} + {len(y)} animals are too many to enumerate; use an asymptotic test")
    ranks = rankdata(np.concatenate([x, y]))
    center = len(x) * ranks.mean()
    sums = np.array([sum(ranks[list(rows)]) for rows in combinations(range(len(ranks)), len(x))])
    return float(np.mean(np.abs(sums - center) >= abs(ranks[: len(x)].sum() - center) - 1e-9))


def holm(p: np.ndarray) -> np.ndarray:
    """Holm's step-down adjusted p values, in the order given."""
    order = np.argsort(p)
    stepped = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    adjusted = np.empty(len(p))
    adjusted[order] = np.minimum(stepped, 1.0)
    return adjusted


def what_n_can_show(n_reference: int, n_other: int, tests: int = 1) -> str:
    """Return a sentence on the smallest p that an exact test of groups of these sizes can give."""
    smallest = 2 / comb(n_reference + n_other, n_reference)
    after = min(1.0, tests * smallest)
    verdict = "can" if after < 0.05 else "cannot"
    return (
        f"With {n_reference} + {n_other} animals complete separation gives p = {smallest:.2g} in an exact rank test, "
        f"{after:.2g} as the first of {tests} tests after Holm: it {verdict} fall below 0.05."
    )


def _values(table: pd.DataFrame, quantity: str, label: str) -> np.ndarray:
    if quantity not in table.columns or "group" not in table.columns:
        raise InputError(
            f"no column '{quantity}' or no column 'group'; there are: {', '.join(map(str, table.columns))}"
        )
    x = table.loc[table["group"] == label, quantity].to_numpy(dtype=float)
    if len(x) == 0 or not np.all(np.isfinite(x)):
        raise InputError(f"'{quantity}' of group '{label}' is empty or holds a value that is not finite")
    return x
