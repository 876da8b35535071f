"""Groups of animals: description, contrasts with intervals, exact tests."""

from collections.abc import Sequence
from math import comb
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from vasowave.errors import InputError

if TYPE_CHECKING:
    import xarray as xr


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

    Hedges' g stands with its interval from the noncentral t distribution. The ratio needs positive values.

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
        ratio = np.exp(np.log(y).mean() - np.log(x).mean())
        p = exact_mann_whitney(x, y)
        eta = importance_index(x.mean(), y.mean())
        rows.append((quantity, eta, ratio, np.exp(welch.low), np.exp(welch.high), *hedges_g(x, y, level), p))
    columns = ["quantity", "eta", "ratio", "ratio low", "ratio high", "Hedges g", "g low", "g high", "p"]
    found = pd.DataFrame(rows, columns=columns)
    found["p Holm"] = holm(found["p"].to_numpy())
    return found


def leave_one_out(table: pd.DataFrame, quantities: list[str], reference: str, other: str) -> pd.DataFrame:
    """Repeat `contrasts` without each animal in turn, to see whether one of them carries the result.

    Returns
    -------
    DataFrame
        One row per quantity and animal: ``left out`` (the index of `table`), ``group``, ``eta``, ``ratio``,
        ``Hedges g``, ``p`` and ``p Holm`` (over `quantities`) without it, ``ratio shift``, that ratio over the one of
        all animals, and ``decides``: whether leaving it out moves p after Holm across 0.05. One animal less costs
        power by itself.

    Raises
    ------
    InputError
        As `contrasts`; a group with fewer than three animals.
    """
    pair = table[table["group"].isin([reference, other])] if "group" in table.columns else table
    everyone = contrasts(pair, quantities, reference, other)
    if pair["group"].value_counts().min() < 3:
        raise InputError(f"leaving one animal out needs three animals in each of '{reference}' and '{other}'")
    parts = []
    for row, animal in enumerate(pair.index):
        without = contrasts(pair[np.arange(len(pair)) != row], quantities, reference, other)
        part = without[["quantity", "eta", "ratio", "Hedges g", "p", "p Holm"]].copy()
        part.insert(1, "left out", animal)
        part.insert(2, "group", pair["group"].iloc[row])
        part["ratio shift"] = without["ratio"] / everyone["ratio"]
        part["decides"] = (without["p Holm"] < 0.05) != (everyone["p Holm"] < 0.05)
        parts.append(part)
    return pd.concat(parts, ignore_index=True).sort_values("quantity", kind="stable", ignore_index=True)


def several_groups(
    table: pd.DataFrame, quantities: list[str], rng: np.random.Generator | None = None, permutations: int = 20_000
) -> pd.DataFrame:
    """Kruskal-Wallis test over all groups, its p from random relabelings of the animals, Holm over the quantities.

    With these group sizes the χ² approximation is poor, and all relabelings are too many: the p value counts those
    with at least the observed H, the observed one included, so it is never below 1/(permutations + 1).

    Raises
    ------
    InputError
        As `describe`; fewer than two groups.
    """
    rng = rng or np.random.default_rng(0)
    labels = table["group"].unique().tolist() if "group" in table.columns else []
    if len(labels) < 2:
        raise InputError("a comparison needs a column 'group' with at least two labels")
    rows = []
    for quantity in quantities:
        samples = [_values(table, quantity, label) for label in labels]
        sizes = [len(x) for x in samples]
        H, drawn = _kruskal(samples, rng, permutations)
        p = (1 + np.sum(drawn >= H - 1e-9)) / (permutations + 1)
        rows.append((quantity, len(labels), sum(sizes), H, float(p)))
    found = pd.DataFrame(rows, columns=["quantity", "groups", "n", "H", "p"])
    found["p Holm"] = holm(found["p"].to_numpy())
    return found


def pairwise_contrasts(table: pd.DataFrame, quantities: list[str], level: float = 0.95) -> pd.DataFrame:
    """`contrasts` of every pair of groups, first-named as reference; Holm runs over all pairs and quantities."""
    from itertools import combinations

    labels = table["group"].unique().tolist() if "group" in table.columns else []
    parts = []
    for reference, other in combinations(labels, 2):
        part = contrasts(table, quantities, reference, other, level)
        part.insert(0, "reference", reference)
        part.insert(1, "other", other)
        parts.append(part)
    if not parts:
        raise InputError("a comparison needs a column 'group' with at least two labels")
    found = pd.concat(parts, ignore_index=True)
    found["p Holm"] = holm(found["p"].to_numpy())
    return found


def hedges_g(x: np.ndarray, y: np.ndarray, level: float = 0.95) -> tuple[float, float, float]:
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


def importance_index(reference: float, other: float) -> float:
    """Importance index η = (χ_other - χ_reference)/χ_reference (eq. 20); never below -1 for positive quantities."""
    return (other - reference) / reference


def exact_mann_whitney(x: np.ndarray, y: np.ndarray) -> float:
    """Two-sided exact p of the rank-sum permutation test; ties get mean ranks and stay exact."""
    from scipy.stats import rankdata

    ranks = np.rint(2 * rankdata(np.concatenate([x, y]))).astype(int)  # doubled, so that mean ranks are integers
    total = int(ranks.sum())
    # How many choices of k animals have each rank sum, one animal after the other: no list of all choices is needed.
    choices = np.zeros((len(x) + 1, total + 1))
    choices[0, 0] = 1
    for rank in ranks:
        choices[1:, rank:] += choices[:-1, : total + 1 - rank].copy()
    center = len(x) * total / len(ranks)
    extreme = np.abs(np.arange(total + 1) - center) >= abs(ranks[: len(x)].sum() - center) - 1e-9
    return float(choices[-1][extreme].sum() / comb(len(ranks), len(x)))


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


def _kruskal(samples: list[np.ndarray], rng: np.random.Generator, permutations: int) -> tuple[float, np.ndarray]:
    """Return H of the samples, corrected for ties, and H of random relabelings."""
    from scipy.stats import rankdata

    ranks = rankdata(np.concatenate(samples))
    sizes = np.array([len(x) for x in samples])
    spread = ((ranks - ranks.mean()) ** 2).sum() / (len(ranks) - 1)
    if spread == 0:
        return 0.0, np.zeros(permutations)
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])

    def statistic(rows: np.ndarray) -> np.ndarray:
        means = np.add.reduceat(rows, starts, axis=-1) / sizes
        return (sizes * (means - ranks.mean()) ** 2).sum(-1) / spread

    shuffled = rng.permuted(np.tile(ranks, (permutations, 1)), axis=1)
    return float(statistic(ranks)), statistic(shuffled)


def cohort_table(trees: Sequence["xr.DataTree"]) -> pd.DataFrame:
    """Return the single numbers of all animals: one row per animal and source (measured, linear, tangent).

    Columns ``animal, group, source``, then one per quantity, ``NAME [unit]``; NaN where a source has no such quantity.

    Raises
    ------
    InputError
        Two animals of the same name, or a quantity in two units.
    """
    rows: list[dict[str, object]] = []
    units: dict[str, str] = {}
    for tree in trees:
        for source, node in tree.children.items():
            if "quantities" not in node.children:
                continue
            row: dict[str, object] = {"animal": str(tree.attrs["animal"]), "group": str(tree.attrs["group"])}
            row["source"] = source
            for name, value in node["quantities"].data_vars.items():
                unit = str(value.attrs.get("units", "1"))
                if units.setdefault(str(name), unit) != unit:
                    raise InputError(f"'{name}' of animal '{row['animal']}' is in {unit}, before in {units[str(name)]}")
                row[f"{name} [{unit}]"] = float(value)
            rows.append(row)
    names = [str(tree.attrs["animal"]) for tree in trees]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(f"two animals are called '{twice}'; give every animal its own name")
    return pd.DataFrame(rows)
