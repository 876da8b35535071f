"""What a plan of a study starts from, and how often studies of one size show an effect.

Cohorts are drawn, and judged as the primary comparison judges them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Ge, Gt, Le, Lt

from vasowave.base.errors import InputError
from vasowave.base.settings import settings_class
from vasowave.study.cohort.balanced import changes_of, effects_of_repeated, structure_of_pairs
from vasowave.study.cohort.mixed import Structure, fit_mixed
from vasowave.study.cohort.pooling import difference, pooled_means
from vasowave.study.cohort.simultaneous_intervals import ComparedQuantity, Fitted, critical_p, joint

_MIN_P = 1e-9  # p of one row that is as good as none
_CRITICAL_DRAWS, _PAIR_DRAWS = 4_000, 2_000  # draws of a critical p: of two groups, of pairs
_DRAWN_STUDIES, _DRAWS_PER_STUDY = 40, 1_999  # studies whose critical p is averaged, and cohorts drawn for each

Drawn = Iterator[tuple[np.ndarray, float, np.ndarray]]
"""Of each quantity its values without an effect (study, group, animal), the error of one, what moves the groups."""


class Spread(NamedTuple):
    """What is known of one quantity before a study."""

    quantity: str
    between: tuple[float, float]
    """SD of the animals' logarithms in the two groups, without the errors."""
    error: float = 0.0
    """SD of the logarithm of one animal's estimate; 0 where `between` contains it."""
    shared: float = 0.0
    """Standard error of the difference of the groups from images that they share."""
    within: float = 0.0
    """SD of the logarithm of one animal from occasion to occasion, without the errors; 0 where `between` contains
    it."""

    @property
    def alike(self) -> float:
        """Correlation of an animal's true values on two occasions, in the mean of the groups; 1 if it is not known."""
        animals = float(np.mean(np.square(self.between)))
        return animals / (animals + self.within**2) if animals else 0.0

    def on_one_occasion(self, group: int) -> float:
        """Return the SD of the true values of a group."""
        return float(np.hypot(self.between[group], self.within))


@settings_class
class Planning:
    """What a study shall show."""

    effect: Annotated[float, Gt(0)] = 1.5
    """Ratio of the groups that shall be shown."""
    power: Annotated[float, Gt(0.05), Lt(1)] = 0.8
    """How often it shall be."""
    occasions: Annotated[int, Ge(1), Le(20)] = 1
    """Recordings of each animal, in pairs of each of the two: what differs between them falls by the root of their
    number, an error always, what an animal differs from occasion to occasion where groups are compared."""
    pairs: Annotated[float, Ge(0), Lt(1)] | None = None
    """Correlation of the two true values of a pair, where pairs are compared, an animal before and after for instance.
    None: groups of independent animals."""
    littermates: bool = False
    """Whether a pair is two littermates, of which each group has one; else one animal on two occasions."""
    seed: Annotated[int, Ge(0)] = 0
    """Of the cohorts that are drawn."""

    def __post_init__(self) -> None:
        """Refuse an effect that is none."""
        if abs(np.log(self.effect)) < 1e-3:
            raise InputError("effect: a ratio of 1 is no effect; give one such as 1.5 or 0.7")
        if self.littermates and self.pairs is None:
            raise InputError("littermates: say how far their true values are correlated (pairs), 0.5 for instance")


class PlannedStudies(NamedTuple):
    """Studies of one size that are drawn: groups of independent animals, animals recorded again, or pairs."""

    spreads: Sequence[Spread]
    root: np.ndarray
    """Whose product with itself is the correlation of the quantities within animals. Shape (quantity, quantity)."""
    settings: Planning
    size: int
    """Animals of each group, or pairs."""


def p_of_effect(studies: PlannedStudies) -> np.ndarray:
    """Return p of the effect in drawn studies, shape (quantity, study), as the primary comparison of such studies."""
    settings, effect = studies.settings, np.log(studies.settings.effect)
    p_values = []
    if settings.pairs is not None:
        for values, error, _ in _pairs(studies, _PAIR_DRAWS):
            change = changes_of(values, error, settings.littermates)
            p_values.append(replace(change, value=change.value + effect).p)
    elif settings.occasions > 1:
        for spread, (values, error, moved) in zip(studies.spreads, _repeated(studies, _PAIR_DRAWS), strict=True):
            contrast = effects_of_repeated(values, error, spread.shared)
            p_values.append(replace(contrast, value=contrast.value + (effect + moved)).p)
    else:
        for spread, (values, error, moved) in zip(studies.spreads, _groups(studies, _CRITICAL_DRAWS), strict=True):
            first, second = (pooled_means(values[:, group], np.full(studies.size, error)) for group in (0, 1))
            p_values.append(difference(first, second._replace(value=second.value + effect + moved), spread.shared).p)
    return np.array(p_values)


def critical_of_studies(studies: PlannedStudies) -> np.ndarray:
    """Return of some studies the p of one row below which the family's is below its level, from low to high."""
    if studies.settings.pairs is not None:
        unshared = [spread._replace(shared=0.0) for spread in studies.spreads]  # what pairs share cancels
        structure = structure_of_pairs(studies.size, studies.settings.littermates)
        return np.sort(_critical_of_models(_pairs(studies, _DRAWN_STUDIES), *structure, unshared))
    if studies.settings.occasions > 1:
        return np.sort(_critical_of_subjects(studies))
    return np.sort(_critical_of_groups(studies))


def _critical_of_groups(studies: PlannedStudies) -> list[float]:
    drawn, animals = list(_groups(studies, _DRAWN_STUDIES)), np.arange(2 * studies.size)
    criticals = []
    for study in range(_DRAWN_STUDIES):
        rows = [
            ComparedQuantity(
                place,
                animals,
                animals >= studies.size,
                values[study].ravel(),
                np.full(len(animals), error),
                spread.shared,
            )
            for place, (spread, (values, error, _)) in enumerate(zip(studies.spreads, drawn, strict=True))
        ]
        criticals.append(max(critical_p(rows, _DRAWS_PER_STUDY, study), _MIN_P))
    return criticals


def _critical_of_subjects(studies: PlannedStudies) -> list[float]:
    """Return the same with subjects; more than two occasions count as two, of which each is the mean of a half."""
    size, half = studies.size, (studies.settings.occasions / 2) ** 0.5
    halves = [spread._replace(error=spread.error / half, within=spread.within / half) for spread in studies.spreads]
    group = [np.kron(np.diag([1.0, 0.0]), np.eye(size)), np.kron(np.diag([0.0, 1.0]), np.eye(size))]
    random = [np.kron(indicator, block) for indicator in group for block in (np.eye(2), np.ones((2, 2)))]
    fixed = np.kron(np.eye(2), np.ones((2 * size, 1)))
    twice = studies._replace(spreads=halves, settings=replace(studies.settings, occasions=2))
    return _critical_of_models(_repeated(twice, _DRAWN_STUDIES), fixed, random, studies.spreads)


def _critical_of_models(
    drawn: Drawn, fixed: np.ndarray, random: Sequence[np.ndarray], spreads: Sequence[Spread]
) -> list[float]:
    """Return the critical p of studies whose quantities have a mixed model of first and second values."""
    rows, change = np.arange(len(fixed)), np.array([[-1.0, 1.0]])
    together = np.outer(fixed[:, 1], fixed[:, 1])
    values_and_errors = [
        (values.reshape(len(values), -1), error**2 * np.eye(len(fixed)) + spread.shared**2 * together)
        for spread, (values, error, _) in zip(spreads, drawn, strict=True)
    ]
    criticals = []
    for study in range(_DRAWN_STUDIES):
        models = [Fitted(fit_mixed(values[study], Structure(fixed, random, errors)), rows, change)
                  for values, errors in values_and_errors]  # fmt: skip
        criticals.append(max(joint(models, _DRAWS_PER_STUDY, study).critical, _MIN_P))
    return criticals


def _groups(studies: PlannedStudies, count: int) -> Drawn:
    rng, root = np.random.default_rng(studies.settings.seed), studies.root  # the same for every scenario
    shape = count, 2 * studies.size, len(studies.spreads)
    scores = (rng.standard_normal(shape) @ root.T).reshape(count, 2, studies.size, -1)
    common = rng.standard_normal((count, len(studies.spreads))) @ root.T
    for place, spread in enumerate(studies.spreads):
        sd = np.array([np.hypot(spread.on_one_occasion(group), spread.error) for group in (0, 1)])
        yield scores[..., place] * sd[:, np.newaxis], spread.error, spread.shared * common[:, place]


def _repeated(studies: PlannedStudies, count: int) -> Drawn:
    """Values have an axis more, of the occasions."""
    rng, quantities = np.random.default_rng(studies.settings.seed), len(studies.spreads)
    animal_effects = rng.standard_normal((count, 2, studies.size, 1, quantities)) @ studies.root.T
    occasion_effects = (
        rng.standard_normal((count, 2, studies.size, studies.settings.occasions, quantities)) @ studies.root.T
    )
    common = rng.standard_normal((count, quantities)) @ studies.root.T
    for place, spread in enumerate(studies.spreads):
        between = animal_effects[..., place] * np.array(spread.between)[:, np.newaxis, np.newaxis]
        yield (
            between + np.hypot(spread.within, spread.error) * occasion_effects[..., place],
            spread.error,
            spread.shared * common[:, place],
        )


def _pairs(studies: PlannedStudies, count: int) -> Drawn:
    """Recordings are averaged on each of the two occasions; what a pair shares, an image for instance, cancels."""
    rng, alike = np.random.default_rng(studies.settings.seed), studies.settings.pairs or 0.0
    shapes = ((count, group, studies.size, len(studies.spreads)) for group in (1, 2, 2))
    pair_effects, value_effects, again = (rng.standard_normal(shape) @ studies.root.T for shape in shapes)
    scores = np.sqrt(alike) * pair_effects + np.sqrt(1 - alike) * value_effects
    for place, spread in enumerate(studies.spreads):
        error = spread.error / studies.settings.occasions**0.5
        sd = np.array([spread.on_one_occasion(group) for group in (0, 1)])
        yield scores[..., place] * sd[:, np.newaxis] + error * again[..., place], error, np.zeros(count)
