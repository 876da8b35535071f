"""Tests that ask for the order of the animals only: Mann-Whitney; Holm's adjustment of many."""

from math import comb

import numpy as np

MOST_EXACT = 200
"""Animals of two groups together up to which a Mann-Whitney test is exact; its work grows with their fourth power."""


def mann_whitney(x: np.ndarray, y: np.ndarray) -> float:
    """Two-sided p of the rank-sum test: exact for up to `MOST_EXACT` animals, else by the normal distribution.

    The normal distribution is corrected for ties and for the ranks' being whole numbers.
    """
    from scipy.stats import mannwhitneyu

    if len(x) + len(y) <= MOST_EXACT:
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
    for seen, (rank, largest) in enumerate(zip(ascending, np.cumsum(ascending), strict=True), start=1):
        fewest = max(1, k - (len(ranks) - seen))  # with fewer there are not k in the end
        for chosen in range(min(seen, k), fewest - 1, -1):
            choices[chosen, rank : largest + 1] += choices[chosen - 1, : largest + 1 - rank]
    center = k * total / len(ranks)
    extreme = np.abs(np.arange(total + 1) - center) >= abs(ranks[:k].sum() - center) - 1e-9
    return float(choices[-1][extreme].sum() / comb(len(ranks), k))


def smallest_p(n_reference: int, n_other: int) -> float:
    """Return the p of `exact_mann_whitney` for two groups of these sizes that do not overlap: none is smaller."""
    return 2 / comb(n_reference + n_other, n_reference)


def holm(p: np.ndarray) -> np.ndarray:
    """Holm's step-down adjusted p values, in the order given."""
    order = np.argsort(p)
    stepped = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    adjusted = np.empty(len(p))
    adjusted[order] = np.minimum(stepped, 1.0)
    return adjusted
