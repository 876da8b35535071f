"""How often studies of one size show an effect: cohorts are drawn, and judged as the primary comparison judges them."""

from collections.abc import Iterator, Sequence

import numpy as np

from vasowave.cohort.joint import Fitted, joint
from vasowave.cohort.mixed import Structure, fit_mixed
from vasowave.cohort.pairs import changes_of, structure_of_pairs
from vasowave.cohort.pooling import difference, pooled_means
from vasowave.cohort.simultaneous import Row, critical_p
from vasowave.cohort.spreads import Spread

_LEAST = 1e-9  # p of one row that is as good as none
_DRAWS, _PAIRED_DRAWS = 4_000, 2_000
_STUDIES, _DRAWS_OF_STUDY = 40, 1_999

Drawn = Iterator[tuple[np.ndarray, float, np.ndarray]]
"""Of each quantity its values without an effect (study, group, animal), the error of one, what moves the groups."""


def power_of_groups(
    spreads: Sequence[Spread], root: np.ndarray, size: int, occasions: int, seed: int, effect: float
) -> np.ndarray:
    """Return p of the effect in drawn studies of two groups, shape (quantity, study)."""
    found = []
    for one, (values, error, moved) in zip(spreads, _groups(spreads, root, size, occasions, seed, _DRAWS), strict=True):
        first, second = (pooled_means(values[:, group], np.full(size, error)) for group in (0, 1))
        shifted = second._replace(value=second.value + np.log(effect) + moved)
        found.append(difference(first, shifted, one.shared).p)
    return np.array(found)


def critical_of_groups(spreads: Sequence[Spread], root: np.ndarray, size: int, occasions: int, seed: int) -> np.ndarray:
    """Return of some studies the p of one row below which the family's is below its level, from low to high."""
    drawn = list(_groups(spreads, root, size, occasions, seed, _STUDIES))
    other, found = np.arange(2 * size) >= size, []
    for study in range(_STUDIES):
        rows = [
            Row(place, np.arange(2 * size), other, values[study].ravel(), np.full(2 * size, error), one.shared)
            for place, (one, (values, error, _)) in enumerate(zip(spreads, drawn, strict=True))
        ]
        found.append(max(critical_p(rows, _DRAWS_OF_STUDY, study), _LEAST))
    return np.sort(found)


def power_of_pairs(
    spreads: Sequence[Spread], root: np.ndarray, size: int, occasions: int, seed: int, effect: float, alike: float,
    littermates: bool,
) -> np.ndarray:  # fmt: skip
    """Return p of the effect in drawn studies of pairs, shape (quantity, study), by the mixed model of their design."""
    drawn = _pairs(spreads, root, size, occasions, seed, _PAIRED_DRAWS, alike)
    return np.array([changes_of(values, error, littermates).p(np.log(effect)) for values, error, _ in drawn])


def critical_of_pairs(
    spreads: Sequence[Spread], root: np.ndarray, size: int, occasions: int, seed: int, alike: float, littermates: bool
) -> np.ndarray:
    """Return of some studies the p of one row below which the family's is below its level, from low to high."""
    drawn = list(_pairs(spreads, root, size, occasions, seed, _STUDIES, alike))
    found, rows, change = [], np.arange(2 * size), np.array([[-1.0, 1.0]])
    fixed, random = structure_of_pairs(size, littermates)
    for study in range(_STUDIES):
        models = [
            Fitted(
                fit_mixed(values[study].ravel(), Structure(fixed, random, error**2 * np.eye(2 * size))), rows, change
            )
            for values, error, _ in drawn
        ]
        found.append(max(joint(models, _DRAWS_OF_STUDY, study).critical, _LEAST))
    return np.sort(found)


def _groups(spreads: Sequence[Spread], root: np.ndarray, size: int, occasions: int, seed: int, count: int) -> Drawn:
    rng = np.random.default_rng(seed)  # the same for every scenario
    scores = (rng.standard_normal((count, 2 * size, len(spreads))) @ root.T).reshape(count, 2, size, -1)
    common = rng.standard_normal((count, len(spreads))) @ root.T
    for place, one in enumerate(spreads):
        error = one.error / occasions**0.5
        spread = np.array([np.hypot(one.on_one_occasion(group, occasions), error) for group in (0, 1)])
        yield scores[..., place] * spread[:, np.newaxis], error, one.shared * common[:, place]


def _pairs(
    spreads: Sequence[Spread], root: np.ndarray, size: int, occasions: int, seed: int, count: int, alike: float
) -> Drawn:
    """Recordings are averaged on each of the two occasions; what a pair shares, an image for instance, cancels."""
    rng = np.random.default_rng(seed)
    both, each, again = (rng.standard_normal((count, group, size, len(spreads))) @ root.T for group in (1, 2, 2))
    scores = np.sqrt(alike) * both + np.sqrt(1 - alike) * each
    for place, one in enumerate(spreads):
        error = one.error / occasions**0.5
        spread = np.array([one.on_one_occasion(group) for group in (0, 1)])
        yield scores[..., place] * spread[:, np.newaxis] + error * again[..., place], error, np.zeros(count)
