"""How many animals a study needs: what is known of its quantities, power by its size, and what would save some."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from vasowave.base.accessors import Accessor
from vasowave.base.errors import InputError
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.designed import occasions_apart
from vasowave.study.cohort.independent import known_values, source_of
from vasowave.study.cohort.pooling import pooled_mean
from vasowave.study.cohort.power import PlannedStudies, Planning, Spread, critical_of_studies, p_of_effect
from vasowave.study.cohort.primary import Family, comparable, primary_law
from vasowave.study.cohort.simultaneous_intervals import correlation_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_JUDGED_SIZES = (3, 4, 6, 10, 20)
"""Sizes of which studies are judged as real ones are; the critical p follows logarithms between, hardly moves above."""
GROUP_SIZES = (3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 20, 24, 28, 32, 40, 50, 60)
"""Animals of each group that are tried."""


def spreads_of(cohort: Cohort, family: Family | None = None) -> tuple[list[Spread], np.ndarray]:
    """Return the spreads of a study's quantities in its first two groups, and their correlation within animals.

    Raises
    ------
    InputError
        There are not two groups that can be compared.
    """
    contrasts = comparable(cohort, family or Family())
    if not contrasts:
        raise InputError("the study has no two groups that can be compared; a plan needs spreads of two")
    animals = {
        name: place
        for place, name in enumerate(dict.fromkeys(name for contrast in contrasts for name in contrast.names))
    }
    residuals, spreads = np.zeros((len(animals), len(contrasts))), []
    for place, contrast in enumerate(contrasts):
        groups = [
            pooled_mean(contrast.estimates.logs[mask], contrast.estimates.errors[mask])
            for mask in (~contrast.in_second, contrast.in_second)
        ]
        # The error that, the same in all animals, makes a group's mean as well known as theirs do.
        error = float(np.sqrt(np.mean(contrast.estimates.errors**2)))
        spreads.append(Spread(contrast.name, (groups[0].between, groups[1].between), error, contrast.shared))
        group_index = contrast.in_second.astype(int)
        total = np.hypot(np.array([group.between for group in groups])[group_index], contrast.estimates.errors)
        center = np.array([group.value for group in groups])[group_index]
        residuals[[animals[name] for name in contrast.names], place] = (contrast.estimates.logs - center) / total
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
    law, corrected = primary_law(cohort, family or Family()), []
    for spread in spreads:
        values = known_values(cohort, source_of(spread.quantity, law), spread.quantity, list(cohort.groups))
        within = min(occasions_apart(cohort, values), *spread.between)
        animal_sd = [float(np.sqrt(max(between**2 - within**2, 0.0))) for between in spread.between]
        corrected.append(spread._replace(between=(animal_sd[0], animal_sd[1]), within=within))
    return corrected


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
    powers: dict[tuple[object, ...], np.ndarray] = {}
    criticals: dict[int, np.ndarray] = {}
    counts = {}
    for name, (scenario_spreads, scenario) in _scenarios(spreads, settings).items():
        if scenario.occasions not in criticals:  # which other spreads hardly change
            criticals[scenario.occasions] = _criticals(spreads, root, scenario)
        if (scenario_spreads, scenario.occasions) not in powers:
            sizes_and_criticals = zip(GROUP_SIZES, criticals[scenario.occasions], strict=True)
            powers[scenario_spreads, scenario.occasions] = np.array(
                [_power(PlannedStudies(scenario_spreads, root, scenario, n), p) for n, p in sizes_and_criticals]
            )
        counts[name] = _needed(powers[scenario_spreads, scenario.occasions], settings.power)
    names = [spread.quantity for spread in spreads]
    # No scenario needs more, which it would by the draws alone.
    counts_needed = {name: np.fmin(count, counts["as it is"]) for name, count in counts.items()}
    needed = pd.DataFrame(counts_needed, index=names)
    index = pd.Index(GROUP_SIZES, name="animals" if settings.pairs is None else "pairs")
    return Plan(
        settings, tuple(spreads), source, pd.DataFrame(powers[tuple(spreads), settings.occasions], index, names), needed
    )


def _scenarios(spreads: Sequence[Spread], settings: Planning) -> dict[str, tuple[tuple[Spread, ...], Planning]]:
    """Return spreads and occasions as they are, and as what may save animals makes them; images of a pair cancel."""
    halved = tuple(spread._replace(error=spread.error / 2) for spread in spreads)
    own_images = tuple(
        spread._replace(shared=0.0, error=float(np.hypot(spread.error, spread.shared / 2**0.5))) for spread in spreads
    )
    twice = replace(settings, occasions=2 * settings.occasions)
    has_errors = any(spread.error or spread.within for spread in spreads)
    again = tuple(spreads), twice if has_errors else settings
    scenarios = {"as it is": (tuple(spreads), settings), "errors halved": (halved, settings)}
    if settings.pairs is None:
        return scenarios | {"own images": (own_images, settings), "a second occasion": again}
    return scenarios | {"two recordings each time": again}


def _needed(powers: np.ndarray, power: float) -> list[float]:
    """Return the least size, between those tried by the line through them, that has the power."""
    sizes = []
    for curve in np.maximum.accumulate(powers, axis=0).T:
        if curve[-1] < power:
            sizes.append(np.nan)
            continue
        place = int(np.argmax(curve >= power))
        if place == 0:
            sizes.append(float(GROUP_SIZES[0]))
            continue
        share = (power - curve[place - 1]) / (curve[place] - curve[place - 1])
        sizes.append(float(np.ceil(GROUP_SIZES[place - 1] + share * (GROUP_SIZES[place] - GROUP_SIZES[place - 1]))))
    return sizes


def _criticals(spreads: Sequence[Spread], root: np.ndarray, settings: Planning) -> np.ndarray:
    """Return the critical p of some studies of every size, shape (size, study)."""
    exact = np.log([critical_of_studies(PlannedStudies(spreads, root, settings, size)) for size in _JUDGED_SIZES])
    return np.exp([np.interp(np.log(GROUP_SIZES), np.log(_JUDGED_SIZES), log_critical) for log_critical in exact.T]).T


def _power(studies: PlannedStudies, critical: np.ndarray) -> np.ndarray:
    """Return how often each quantity's effect is shown, over studies' critical p."""
    return np.array(
        [np.mean(np.searchsorted(np.sort(p_values), critical)) / len(p_values) for p_values in p_of_effect(studies)]
    )
