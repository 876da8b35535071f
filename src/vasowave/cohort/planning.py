"""How many animals a study needs: power of the primary comparison by its size, and what would save some."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np
import pandas as pd
from annotated_types import Ge, Gt, Le, Lt

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.joint import Fitted, joint
from vasowave.cohort.mixed import Structure, fit_mixed
from vasowave.cohort.pooling import Means, difference, pooled_mean, pooled_means
from vasowave.cohort.primary import Compared, Family, comparable
from vasowave.cohort.simultaneous import Row, correlation_of, critical_p
from vasowave.errors import InputError
from vasowave.notebook import upstairs
from vasowave.settings import settings_class

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LEAST = 1e-9  # p of one row that is as good as none
_DRAWS, _STUDIES, _DRAWS_OF_STUDY = 4_000, 40, 1_999
_JUDGED = (3, 4, 6, 10, 20)
"""Sizes of which studies are judged as real ones are; the critical p follows logarithms between, hardly moves above."""
_SIZES = (3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 20, 24, 28, 32, 40, 50, 60)
"""Animals of each group that are tried."""


@settings_class
class Planning:
    """What a study shall show."""

    effect: Annotated[float, Gt(0)] = 1.5
    """Ratio of the groups that shall be shown."""
    power: Annotated[float, Gt(0.05), Lt(1)] = 0.8
    """How often it shall be."""
    occasions: Annotated[int, Ge(1), Le(20)] = 1
    """Recordings of each animal, averaged: the error of one of them falls by their root."""
    pairs: Annotated[float, Ge(0), Lt(1)] | None = None
    """Correlation of the two true values of a pair, where pairs are compared: one animal before and after, or
    littermates of which each group has one. None: groups of independent animals."""
    seed: Annotated[int, Ge(0)] = 0
    """Of the cohorts that are drawn."""

    @property
    def groups(self) -> int:
        """Groups whose means are compared: two, or one of the changes of pairs."""
        return 2 if self.pairs is None else 1

    def __post_init__(self) -> None:
        """Refuse an effect that is none."""
        if abs(np.log(self.effect)) < 1e-3:
            raise InputError("effect: a ratio of 1 is no effect; give one such as 1.5 or 0.7")


class Spread(NamedTuple):
    """What is known of one quantity before a study.

    Attributes
    ----------
    quantity : str
    between : (float, float)
        SD of the animals' logarithms in the two groups, without the errors.
    error : float
        SD of the logarithm of one animal's estimate; 0 where `between` contains it.
    shared : float
        Standard error of the difference of the groups from images that they share.
    """

    quantity: str
    between: tuple[float, float]
    error: float = 0.0
    shared: float = 0.0

    def of_changes(self, alike: float) -> "Spread":
        """Return the spread of the changes of pairs whose true values are correlated; what a pair shares cancels."""
        one, other = self.between
        change = float(np.sqrt(one**2 + other**2 - 2 * alike * one * other))
        return Spread(self.quantity, (change, change), 2**0.5 * self.error)


@dataclass(frozen=True, eq=False)
class Plan:
    """How many animals a study of two groups needs.

    Attributes
    ----------
    settings : Planning
    spreads : tuple of Spread
    source : str
        Whose spreads they are.
    powers : DataFrame
        Rows ``animals`` of each group, or ``pairs``; of each quantity how often its effect is shown, for the family
        together.
    needed : DataFrame
        One row a quantity: animals of each group, or pairs, ``as it is``, with ``errors halved``, ``own images`` (of
        groups), ``two recordings of each animal``; NaN where more than are tried.
    """

    settings: Planning
    spreads: tuple[Spread, ...]
    source: str
    powers: pd.DataFrame
    needed: pd.DataFrame

    def __repr__(self) -> str:
        return f"Plan(effect {self.settings.effect:g}, power {self.settings.power:g}, by {self.source})\n{self.needed}"

    def figure(self) -> "Figure":
        """Draw power by the number of animals, a line for each quantity."""
        drawn: Figure = upstairs("figures.planned:planned_figure")(self)
        return drawn


def plan_of(spreads: Sequence[Spread], correlation: np.ndarray, source: str, settings: Planning) -> Plan:
    """Return the plan of a study of two groups, or of pairs, whose quantities have these spreads.

    Cohorts of every size are drawn and judged as the primary comparison judges them, by pooled ratios. The p of one row
    below which the family's is below 0.05 is that of studies that go through `simultaneous`, or `joint` with pairs.

    Parameters
    ----------
    spreads : sequence of Spread
        One for each quantity of the family.
    correlation : array, shape (quantity, quantity)
        Of the quantities within animals.
    source : str
    settings : Planning
    """
    root = np.linalg.cholesky(correlation + 1e-9 * np.eye(len(spreads)))
    scenarios = {
        "as it is": spreads,
        "errors halved": [one._replace(error=one.error / 2) for one in spreads],
        "own images": [
            one._replace(shared=0.0, error=float(np.hypot(one.error, one.shared / 2**0.5))) for one in spreads
        ],
        "two recordings of each animal": [one._replace(error=one.error / 2**0.5) for one in spreads],
    }
    if settings.pairs is not None:
        del scenarios["own images"]  # those of a pair cancel
        scenarios = {name: [one.of_changes(settings.pairs) for one in some] for name, some in scenarios.items()}
    criticals = _criticals(scenarios["as it is"], root, settings)  # which the scenarios hardly change
    found = {name: _powers(some, root, settings, criticals) for name, some in scenarios.items()}
    names = [one.quantity for one in spreads]
    counts = {name: _needed(powers, settings.power) for name, powers in found.items()}
    least = {name: np.fmin(count, counts["as it is"]) for name, count in counts.items()}  # else by the draws alone
    needed = pd.DataFrame(least, index=names)
    powers = pd.DataFrame(
        found["as it is"], columns=names, index=pd.Index(_SIZES, name="pairs" if settings.groups == 1 else "animals")
    )
    return Plan(settings, tuple(spreads), source, powers, needed)


def _needed(powers: np.ndarray, power: float) -> list[float]:
    """Return the least size, between those tried by the line through them, that has the power."""
    found = []
    for one in np.maximum.accumulate(powers, axis=0).T:
        if one[-1] < power:
            found.append(np.nan)
            continue
        place = int(np.argmax(one >= power))
        if place == 0:
            found.append(float(_SIZES[0]))
            continue
        share = (power - one[place - 1]) / (one[place] - one[place - 1])
        found.append(float(np.ceil(_SIZES[place - 1] + share * (_SIZES[place] - _SIZES[place - 1]))))
    return found


def _criticals(spreads: Sequence[Spread], root: np.ndarray, settings: Planning) -> np.ndarray:
    """Return the critical p of some studies of every size, shape (size, study)."""
    exact = np.log([_critical(spreads, root, settings, size) for size in _JUDGED])
    return np.exp([np.interp(np.log(_SIZES), np.log(_JUDGED), one) for one in exact.T]).T


def _powers(spreads: Sequence[Spread], root: np.ndarray, settings: Planning, criticals: np.ndarray) -> np.ndarray:
    return np.array([_power(spreads, root, settings, *one) for one in zip(_SIZES, criticals, strict=True)])


def _drawn(
    spreads: Sequence[Spread], root: np.ndarray, settings: Planning, size: int, count: int
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return of each quantity the values of cohorts without an effect, errors of animals, and errors of the ratio."""
    rng, whole = np.random.default_rng(settings.seed), settings.groups * size  # the same for every scenario
    scores = rng.standard_normal((count, whole, len(spreads))) @ root.T
    common = rng.standard_normal((count, len(spreads))) @ root.T
    for place, one in enumerate(spreads):
        error = one.error / settings.occasions**0.5
        values = scores[:, :, place] * np.hypot(np.repeat(one.between[: settings.groups], size), error)
        yield values, np.full(whole, error), one.shared * common[:, place]


def _critical(spreads: Sequence[Spread], root: np.ndarray, settings: Planning, size: int) -> np.ndarray:
    """Return of each of some studies the p of one row below which the family's is below its level, from low to high."""
    other = np.arange(settings.groups * size) >= size
    drawn = list(_drawn(spreads, root, settings, size, _STUDIES))
    found = []
    for study in range(_STUDIES):
        if settings.groups == 1:
            models = [_of_changes(values[study], errors) for values, errors, _ in drawn]
            found.append(max(joint(models, _DRAWS_OF_STUDY, study).critical, _LEAST))
            continue
        rows = [
            Row(place, np.arange(2 * size), other, values[study], errors, one.shared)
            for place, (one, (values, errors, _)) in enumerate(zip(spreads, drawn, strict=True))
        ]
        found.append(max(critical_p(rows, _DRAWS_OF_STUDY, study), _LEAST))
    return np.sort(found)


def _of_changes(values: np.ndarray, errors: np.ndarray) -> Fitted:
    """Return the mixed model of the changes of pairs, with their mean as its effect."""
    size = len(values)
    structure = Structure(np.ones((size, 1)), [np.eye(size)], np.diag(errors**2))
    return Fitted(fit_mixed(values, structure), np.arange(size), np.eye(1))


def _power(
    spreads: Sequence[Spread], root: np.ndarray, settings: Planning, size: int, critical: np.ndarray
) -> np.ndarray:
    """Return how often each quantity's effect is shown with so many animals a group, over studies' critical p."""
    shown = []
    for one, (values, errors, moved) in zip(spreads, _drawn(spreads, root, settings, size, _DRAWS), strict=True):
        means = [pooled_means(values[:, own], errors[own]) for own in np.split(np.arange(len(errors)), settings.groups)]
        shifted = means[-1]._replace(value=means[-1].value + np.log(settings.effect) + moved)
        first = means[0] if settings.groups == 2 else Means(0.0 * moved, 0.0 * moved, 1.0, 0.0 * moved)
        p = np.sort(difference(first, shifted, one.shared).p)
        shown.append(float(np.mean(np.searchsorted(p, critical)) / len(p)))
    return np.array(shown)


def spreads_of(cohort: Cohort, family: Family | None = None) -> tuple[list[Spread], np.ndarray]:
    """Return the spreads of a study's quantities in its first two groups, and their correlation within animals.

    Raises
    ------
    InputError
        There are not two groups that can be compared.
    """
    found = comparable(cohort, family or Family())
    if not found:
        raise InputError("the study has no two groups that can be compared; a plan needs spreads of two")
    animals = {name: place for place, name in enumerate(dict.fromkeys(name for one in found for name in one.names))}
    residuals, spreads = np.zeros((len(animals), len(found))), []
    for place, one in enumerate(found):
        groups = [pooled_mean(one.known.logs[own], one.known.errors[own]) for own in (~one.other, one.other)]
        spreads.append(Spread(one.name, (groups[0].between, groups[1].between), _typical(one), one.shared))
        which = one.other.astype(int)
        total = np.hypot(np.array([group.between for group in groups])[which], one.known.errors)
        center = np.array([group.value for group in groups])[which]
        residuals[[animals[name] for name in one.names], place] = (one.known.logs - center) / total
    return spreads, correlation_of(residuals, len(animals) - 2)


def _typical(one: Compared) -> float:
    """Return the error that, the same in all animals, makes a group's mean as well known as theirs do."""
    return float(np.sqrt(np.mean(one.known.errors**2)))
