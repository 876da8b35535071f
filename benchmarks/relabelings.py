"""Family-wise p of many quantities at once, from all relabelings of the animals (Westfall and Young's max-|t|)."""

from itertools import combinations
from math import comb

import numpy as np

from vasowave.base import InputError
from vasowave.study.cohort import MAX_RELABELINGS


def family_p(values: np.ndarray, other: np.ndarray, rng: np.random.Generator | None = None) -> np.ndarray:
    """Return the family-wise p of every quantity: step-down max-|t| (Westfall and Young 1993; Ge et al. 2003).

    Under the hypothesis that the distributions of the groups are the same, spreads included, the labels of the animals
    can be exchanged. Where the smaller group varies more, the p is too small (docs/comparisons.md): the primary
    comparison uses `simultaneous`. A quantity's p is the share
    of all relabelings in which the largest |t| of it and of those with smaller |t| reaches its own. The quantities of
    one animal stay together, so that what is correlated is not paid for twice.

    Parameters
    ----------
    values : array, shape (animal, quantity)
        Usually logarithms; NaN where an animal has no value.
    other : array of bool, shape (animal,)
        Which animals belong to the second group.
    rng : Generator, optional
        Needed only beyond `MAX_RELABELINGS`.

    Raises
    ------
    InputError
        A group without an animal, fewer than three animals, or a quantity that does not vary.
    """
    n = int(other.sum())
    if not 0 < n < len(other) or len(other) < 3:
        raise InputError(f"a permutation test needs two groups and three animals; there are {len(other) - n} and {n}")
    if np.any(np.nanmax(values, axis=0) == np.nanmin(values, axis=0)):
        raise InputError("a quantity has the same value in every animal; there is nothing to test")
    labels = np.vstack([other, _relabelings(len(other), n, rng)])
    t = np.abs(_student(values, labels))
    order = np.argsort(-t[0])
    largest = np.maximum.accumulate(t[1:, order][:, ::-1], axis=1)[:, ::-1]
    reached = (largest >= t[0, order] * (1 - 1e-9)).mean(axis=0)  # rounding does not part what is equal
    p = np.empty(len(order))
    p[order] = np.maximum.accumulate(reached)
    return p


def _relabelings(count: int, n: int, rng: np.random.Generator | None) -> np.ndarray:
    """Return who is of the second group in all relabelings, or in many; shape (relabeling, animal)."""
    if comb(count, n) > MAX_RELABELINGS:
        rng = rng or np.random.default_rng(0)
        first = np.arange(count) < n
        drawn = rng.permuted(np.tile(first, (MAX_RELABELINGS - 1, 1)), axis=1)
        return np.vstack([first, drawn])
    chosen = np.array(list(combinations(range(count), n)))
    labels = np.zeros((len(chosen), count), dtype=bool)
    np.put_along_axis(labels, chosen, True, axis=1)
    return labels


def _student(values: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """Return Student's t of every quantity under every labeling, shape (labeling, quantity); 0 for an empty group."""
    known = np.isfinite(values)
    count = known.sum(axis=0)
    centered = np.where(known, values - np.nanmean(values, axis=0), 0.0)
    n = labels @ known.astype(float)
    sums = labels @ centered  # those of the two groups are opposite, since the whole is centered
    with np.errstate(divide="ignore", invalid="ignore"):
        between = sums**2 * (1 / n + 1 / (count - n))
        within = np.maximum((centered**2).sum(axis=0) - between, 0.0)
        t = np.sign(sums) * np.sqrt((count - 2) * between / within)
    return np.where((n > 0) & (n < count), t, 0.0)
