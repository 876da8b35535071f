"""How many animals a study needs: what is known of its quantities, power by its size, and what would save some."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from vasowave.accessors import Accessor
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.designed import occasions_apart
from vasowave.cohort.pooling import pooled_mean
from vasowave.cohort.power import PlannedStudies, critical_of_studies, p_of_effect
from vasowave.cohort.primary import Family, comparable, known_values, primary_law, source_of
from vasowave.cohort.simultaneous import correlation_of
from vasowave.cohort.spread import Planning, Spread
from vasowave.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_JUDGED = (3, 4, 6, 10, 20)
"""Sizes of which studies are judged as real ones are; the critical p follows logarithms between, hardly moves above."""
_SIZES = (3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 20, 24, 28, 32, 40, 50, 60)
"""Animals of each group that are tried."""


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
        # The error that, the same in all animals, makes a group's mean as well known as theirs do.
        error = float(np.sqrt(np.mean(one.known.errors**2)))
        spreads.append(Spread(one.name, (groups[0].between, groups[1].between), error, one.shared))
        which = one.other.astype(int)
        total = np.hypot(np.array([group.between for group in groups])[which], one.known.errors)
        center = np.array([group.value for group in groups])[which]
        residuals[[animals[name] for name in one.names], place] = (one.known.logs - center) / total
    return spreads, correlation_of(residuals, len(animals) - 2)


def with_occasions(spreads: Sequence[Spread], cohort: Cohort, family: Family | None = None) -> list[Spread]:
    """Return spreads with what an animal differs from occasion to occasion taken out of what animals differ.

    Parameters
    ----------
    spreads : sequence of Spread
        Of one recording of each subject.
    cohort : Cohort
        All recordings of the subjects, with their design.
    family : Family, optional
    """
    law, found = primary_law(cohort, family or Family()), []
    for one in spreads:
        values = known_values(cohort, source_of(one.quantity, law), one.quantity, list(cohort.groups))
        within = min(occasions_apart(cohort, values), *one.between)
        left = [float(np.sqrt(max(between**2 - within**2, 0.0))) for between in one.between]
        found.append(one._replace(between=(left[0], left[1]), within=within))
    return found


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
        One row a quantity: animals of each group, or pairs, ``as it is``, with ``errors halved``; of groups with ``own
        images``, ``a second occasion`` of each animal; of pairs ``two recordings each time``. NaN where more than are
        tried.
    """

    settings: Planning
    spreads: tuple[Spread, ...]
    source: str
    powers: pd.DataFrame
    needed: pd.DataFrame

    def __repr__(self) -> str:
        return f"Plan(effect {self.settings.effect:g}, power {self.settings.power:g}, by {self.source})\n{self.needed}"

    @Accessor
    def figure(self) -> "Figure":
        """Draw power by the number of animals, a line for each quantity."""
        raise NotImplementedError


def plan_of(spreads: Sequence[Spread], correlation: np.ndarray, source: str, settings: Planning) -> Plan:
    """Return the plan of a study of two groups, or of pairs, whose quantities have these spreads.

    Cohorts of every size are drawn and judged as the primary comparison judges them: groups by pooled ratios, pairs by
    the mixed model of their design. The p of one row below which the family's is below 0.05 is that of studies that go
    through `simultaneous`, or `joint` with pairs.

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
    found: dict[tuple[object, ...], np.ndarray] = {}
    criticals: dict[int, np.ndarray] = {}
    counts = {}
    for name, (some, asked) in _scenarios(spreads, settings).items():
        if asked.occasions not in criticals:  # which other spreads hardly change
            criticals[asked.occasions] = _criticals(spreads, root, asked)
        if (some, asked.occasions) not in found:
            each = zip(_SIZES, criticals[asked.occasions], strict=True)
            found[some, asked.occasions] = np.array([_power(PlannedStudies(some, root, asked, n), p) for n, p in each])
        counts[name] = _needed(found[some, asked.occasions], settings.power)
    names = [one.quantity for one in spreads]
    least = {name: np.fmin(count, counts["as it is"]) for name, count in counts.items()}  # else by the draws alone
    needed = pd.DataFrame(least, index=names)
    index = pd.Index(_SIZES, name="animals" if settings.pairs is None else "pairs")
    return Plan(
        settings, tuple(spreads), source, pd.DataFrame(found[tuple(spreads), settings.occasions], index, names), needed
    )


def _scenarios(spreads: Sequence[Spread], settings: Planning) -> dict[str, tuple[tuple[Spread, ...], Planning]]:
    """Return spreads and occasions as they are, and as what may save animals makes them; images of a pair cancel."""
    halved = tuple(one._replace(error=one.error / 2) for one in spreads)
    own = tuple(one._replace(shared=0.0, error=float(np.hypot(one.error, one.shared / 2**0.5))) for one in spreads)
    twice = replace(settings, occasions=2 * settings.occasions)
    known = any(one.error or one.within for one in spreads)
    again = tuple(spreads), twice if known else settings
    found = {"as it is": (tuple(spreads), settings), "errors halved": (halved, settings)}
    if settings.pairs is None:
        return found | {"own images": (own, settings), "a second occasion": again}
    return found | {"two recordings each time": again}


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
    exact = np.log([critical_of_studies(PlannedStudies(spreads, root, settings, size)) for size in _JUDGED])
    return np.exp([np.interp(np.log(_SIZES), np.log(_JUDGED), one) for one in exact.T]).T


def _power(asked: PlannedStudies, critical: np.ndarray) -> np.ndarray:
    """Return how often each quantity's effect is shown, over studies' critical p."""
    return np.array([np.mean(np.searchsorted(np.sort(one), critical)) / len(one) for one in p_of_effect(asked)])
