"""How often studies of one size show an effect: cohorts are drawn, and judged as the primary comparison judges them."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vasowave.cohort.balanced import changes_of, effects_of_repeated, structure_of_pairs
from vasowave.cohort.mixed import Structure, fit_mixed
from vasowave.cohort.pooling import difference, pooled_means
from vasowave.cohort.simultaneous import ComparedQuantity, Fitted, critical_p, joint
from vasowave.cohort.spread import Planning, Spread

_LEAST = 1e-9  # p of one row that is as good as none
_DRAWS, _FEWER_DRAWS = 4_000, 2_000
_STUDIES, _DRAWS_OF_STUDY = 40, 1_999

Drawn = Iterator[tuple[np.ndarray, float, np.ndarray]]
"""Of each quantity its values without an effect (study, group, animal), the error of one, what moves the groups."""


class PlannedStudies(NamedTuple):
    """Studies of one size that are drawn: groups of independent animals, animals recorded again, or pairs.

    Attributes
    ----------
    spreads : sequence of Spread
    root : array, shape (quantity, quantity)
        Whose product with itself is the correlation of the quantities within animals.
    settings : Planning
    size : int
        Animals of each group, or pairs.
    """

    spreads: Sequence[Spread]
    root: np.ndarray
    settings: Planning
    size: int


def p_of_effect(asked: PlannedStudies) -> np.ndarray:
    """Return p of the effect in drawn studies, shape (quantity, study), as the primary comparison of such studies."""
    settings, effect = asked.settings, np.log(asked.settings.effect)
    found = []
    if settings.pairs is not None:
        for values, error, _ in _pairs(asked, _FEWER_DRAWS):
            change = changes_of(values, error, settings.littermates)
            found.append(change._replace(value=change.value + effect).p)
    elif settings.occasions > 1:
        for one, (values, error, moved) in zip(asked.spreads, _repeated(asked, _FEWER_DRAWS), strict=True):
            apart = effects_of_repeated(values, error, one.shared)
            found.append(apart._replace(value=apart.value + (effect + moved)).p)
    else:
        for one, (values, error, moved) in zip(asked.spreads, _groups(asked, _DRAWS), strict=True):
            first, second = (pooled_means(values[:, group], np.full(asked.size, error)) for group in (0, 1))
            found.append(difference(first, second._replace(value=second.value + effect + moved), one.shared).p)
    return np.array(found)


def critical_of_studies(asked: PlannedStudies) -> np.ndarray:
    """Return of some studies the p of one row below which the family's is below its level, from low to high."""
    if asked.settings.pairs is not None:
        own = [one._replace(shared=0.0) for one in asked.spreads]  # what pairs share cancels
        structure = structure_of_pairs(asked.size, asked.settings.littermates)
        return np.sort(_critical_of_models(_pairs(asked, _STUDIES), *structure, own))
    if asked.settings.occasions > 1:
        return np.sort(_critical_of_subjects(asked))
    return np.sort(_critical_of_groups(asked))


def _critical_of_groups(asked: PlannedStudies) -> list[float]:
    drawn, animals = list(_groups(asked, _STUDIES)), np.arange(2 * asked.size)
    found = []
    for study in range(_STUDIES):
        rows = [
            ComparedQuantity(
                place, animals, animals >= asked.size, values[study].ravel(), np.full(len(animals), error), one.shared
            )
            for place, (one, (values, error, _)) in enumerate(zip(asked.spreads, drawn, strict=True))
        ]
        found.append(max(critical_p(rows, _DRAWS_OF_STUDY, study), _LEAST))
    return found


def _critical_of_subjects(asked: PlannedStudies) -> list[float]:
    """Return the same with subjects; more than two occasions count as two, of which each is the mean of a half."""
    size, half = asked.size, (asked.settings.occasions / 2) ** 0.5
    halves = [one._replace(error=one.error / half, within=one.within / half) for one in asked.spreads]
    group = [np.kron(np.diag([1.0, 0.0]), np.eye(size)), np.kron(np.diag([0.0, 1.0]), np.eye(size))]
    random = [np.kron(one, both) for one in group for both in (np.eye(2), np.ones((2, 2)))]
    fixed = np.kron(np.eye(2), np.ones((2 * size, 1)))
    twice = asked._replace(spreads=halves, settings=replace(asked.settings, occasions=2))
    return _critical_of_models(_repeated(twice, _STUDIES), fixed, random, asked.spreads)


def _critical_of_models(
    drawn: Drawn, fixed: np.ndarray, random: Sequence[np.ndarray], spreads: Sequence[Spread]
) -> list[float]:
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
    return found


def _groups(asked: PlannedStudies, count: int) -> Drawn:
    rng, root = np.random.default_rng(asked.settings.seed), asked.root  # the same for every scenario
    shape = count, 2 * asked.size, len(asked.spreads)
    scores = (rng.standard_normal(shape) @ root.T).reshape(count, 2, asked.size, -1)
    common = rng.standard_normal((count, len(asked.spreads))) @ root.T
    for place, one in enumerate(asked.spreads):
        spread = np.array([np.hypot(one.on_one_occasion(group), one.error) for group in (0, 1)])
        yield scores[..., place] * spread[:, np.newaxis], one.error, one.shared * common[:, place]


def _repeated(asked: PlannedStudies, count: int) -> Drawn:
    """Values have an axis more, of the occasions."""
    rng, quantities = np.random.default_rng(asked.settings.seed), len(asked.spreads)
    own = rng.standard_normal((count, 2, asked.size, 1, quantities)) @ asked.root.T
    each = rng.standard_normal((count, 2, asked.size, asked.settings.occasions, quantities)) @ asked.root.T
    common = rng.standard_normal((count, quantities)) @ asked.root.T
    for place, one in enumerate(asked.spreads):
        between = own[..., place] * np.array(one.between)[:, np.newaxis, np.newaxis]
        yield between + np.hypot(one.within, one.error) * each[..., place], one.error, one.shared * common[:, place]


def _pairs(asked: PlannedStudies, count: int) -> Drawn:
    """Recordings are averaged on each of the two occasions; what a pair shares, an image for instance, cancels."""
    rng, alike = np.random.default_rng(asked.settings.seed), asked.settings.pairs or 0.0
    shapes = ((count, group, asked.size, len(asked.spreads)) for group in (1, 2, 2))
    both, each, again = (rng.standard_normal(shape) @ asked.root.T for shape in shapes)
    scores = np.sqrt(alike) * both + np.sqrt(1 - alike) * each
    for place, one in enumerate(asked.spreads):
        error = one.error / asked.settings.occasions**0.5
        spread = np.array([one.on_one_occasion(group) for group in (0, 1)])
        yield scores[..., place] * spread[:, np.newaxis] + error * again[..., place], error, np.zeros(count)
