"""How often studies of one size show an effect: cohorts are drawn, and judged as the primary comparison judges them."""

from collections.abc import Iterator, Sequence

import numpy as np

from vasowave.cohort.balanced import changes_of, effects_of_repeated, structure_of_pairs
from vasowave.cohort.joint import Fitted, joint
from vasowave.cohort.mixed import Structure, fit_mixed
from vasowave.cohort.pooling import difference, pooled_means
from vasowave.cohort.simultaneous import Row, critical_p
from vasowave.cohort.spreads import Spread

_LEAST = 1e-9  # p of one row that is as good as none
_DRAWS, _FEWER_DRAWS = 4_000, 2_000
_STUDIES, _DRAWS_OF_STUDY = 40, 1_999

Drawn = Iterator[tuple[np.ndarray, float, np.ndarray]]
"""Of each quantity its values without an effect (study, group, animal), the error of one, what moves the groups."""


def power_of_groups(spreads: Sequence[Spread], root: np.ndarray, size: int, seed: int, effect: float) -> np.ndarray:
    """Return p of the effect in drawn studies of two groups, shape (quantity, study)."""
    found = []
    for one, (values, error, moved) in zip(spreads, _groups(spreads, root, size, seed, _DRAWS), strict=True):
        first, second = (pooled_means(values[:, group], np.full(size, error)) for group in (0, 1))
        shifted = second._replace(value=second.value + np.log(effect) + moved)
        found.append(difference(first, shifted, one.shared).p)
    return np.array(found)


def critical_of_groups(spreads: Sequence[Spread], root: np.ndarray, size: int, seed: int) -> np.ndarray:
    """Return of some studies the p of one row below which the family's is below its level, from low to high."""
    drawn = list(_groups(spreads, root, size, seed, _STUDIES))
    other, found = np.arange(2 * size) >= size, []
    for study in range(_STUDIES):
        rows = [
            Row(place, np.arange(2 * size), other, values[study].ravel(), np.full(2 * size, error), one.shared)
            for place, (one, (values, error, _)) in enumerate(zip(spreads, drawn, strict=True))
        ]
        found.append(max(critical_p(rows, _DRAWS_OF_STUDY, study), _LEAST))
    return np.sort(found)


def power_of_subjects(
    spreads: Sequence[Spread], root: np.ndarray, size: int, occasions: int, seed: int, effect: float
) -> np.ndarray:
    """Return the same of studies that record each animal on several occasions: a design with subjects judges those."""
    drawn = zip(spreads, _repeated(spreads, root, size, occasions, seed, _FEWER_DRAWS), strict=True)
    return np.array([
        effects_of_repeated(values, error, one.shared).p(np.log(effect) + moved)
        for one, (values, error, moved) in drawn
    ])  # fmt: skip


def critical_of_subjects(
    spreads: Sequence[Spread], root: np.ndarray, size: int, occasions: int, seed: int
) -> np.ndarray:
    """Return the same of them; more than two occasions as two, of which each is the mean of a half."""
    halves = [one._replace(error=one.error / (occasions / 2) ** 0.5, within=one.within / (occasions / 2) ** 0.5)
              for one in spreads]  # fmt: skip
    group = [np.kron(np.diag([1.0, 0.0]), np.eye(size)), np.kron(np.diag([0.0, 1.0]), np.eye(size))]
    random = [np.kron(one, both) for one in group for both in (np.eye(2), np.ones((2, 2)))]
    fixed = np.kron(np.eye(2), np.ones((2 * size, 1)))
    drawn = _repeated(halves, root, size, 2, seed, _STUDIES)
    return _criticals_of_models(drawn, fixed, random, spreads)


def power_of_pairs(
    spreads: Sequence[Spread], root: np.ndarray, size: int, occasions: int, seed: int, effect: float, alike: float,
    littermates: bool,
) -> np.ndarray:  # fmt: skip
    """Return p of the effect in drawn studies of pairs, shape (quantity, study), by the mixed model of their design."""
    drawn = _pairs(spreads, root, size, occasions, seed, _FEWER_DRAWS, alike)
    return np.array([changes_of(values, error, littermates).p(np.log(effect)) for values, error, _ in drawn])


def critical_of_pairs(
    spreads: Sequence[Spread], root: np.ndarray, size: int, occasions: int, seed: int, alike: float, littermates: bool
) -> np.ndarray:
    """Return of some studies the p of one row below which the family's is below its level, from low to high."""
    drawn = _pairs(spreads, root, size, occasions, seed, _STUDIES, alike)
    own = [one._replace(shared=0.0) for one in spreads]  # what pairs share cancels
    return _criticals_of_models(drawn, *structure_of_pairs(size, littermates), own)


def _criticals_of_models(
    drawn: Drawn, fixed: np.ndarray, random: Sequence[np.ndarray], spreads: Sequence[Spread]
) -> np.ndarray:
    """Return the critical p of studies whose quantities have a mixed model of first and second values."""
    rows, change = np.arange(len(fixed)), np.array([[-1.0, 1.0]])
    together = np.outer(fixed[:, 1], fixed[:, 1])
    known = [
        (values.reshape(len(values), -1), error**2 * np.eye(len(fixed)) + one.shared**2 * together)
        for one, (values, error, _) in zip(spreads, drawn, strict=True)
    ]
    found = []
    for study in range(_STUDIES):
        models = [Fitted(fit_mixed(values[study], Structure(fixed, random, errors)), rows, change)
                  for values, errors in known]  # fmt: skip
        found.append(max(joint(models, _DRAWS_OF_STUDY, study).critical, _LEAST))
    return np.sort(found)


def _groups(spreads: Sequence[Spread], root: np.ndarray, size: int, seed: int, count: int) -> Drawn:
    rng = np.random.default_rng(seed)  # the same for every scenario
    scores = (rng.standard_normal((count, 2 * size, len(spreads))) @ root.T).reshape(count, 2, size, -1)
    common = rng.standard_normal((count, len(spreads))) @ root.T
    for place, one in enumerate(spreads):
        spread = np.array([np.hypot(one.on_one_occasion(group), one.error) for group in (0, 1)])
        yield scores[..., place] * spread[:, np.newaxis], one.error, one.shared * common[:, place]


def _repeated(spreads: Sequence[Spread], root: np.ndarray, size: int, occasions: int, seed: int, count: int) -> Drawn:
    """Values have an axis more, of the occasions."""
    rng = np.random.default_rng(seed)
    own = rng.standard_normal((count, 2, size, 1, len(spreads))) @ root.T
    each = rng.standard_normal((count, 2, size, occasions, len(spreads))) @ root.T
    common = rng.standard_normal((count, len(spreads))) @ root.T
    for place, one in enumerate(spreads):
        between = own[..., place] * np.array(one.between)[:, np.newaxis, np.newaxis]
        yield between + np.hypot(one.within, one.error) * each[..., place], one.error, one.shared * common[:, place]


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
