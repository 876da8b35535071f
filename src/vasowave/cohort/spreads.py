"""What a plan rests on: how far animals differ, how well one is known, and what it differs from time to time."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.designed import occasions_apart
from vasowave.cohort.pooling import pooled_mean
from vasowave.cohort.primary import Compared, Family, comparable, known_values, primary_law, source_of
from vasowave.cohort.simultaneous import correlation_of
from vasowave.errors import InputError


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
    within : float
        SD of the logarithm of one animal from occasion to occasion, without the errors; 0 where `between` contains it.
    """

    quantity: str
    between: tuple[float, float]
    error: float = 0.0
    shared: float = 0.0
    within: float = 0.0

    @property
    def alike(self) -> float:
        """Correlation of an animal's true values on two occasions, in the mean of the groups; 1 if it is not known."""
        animals = float(np.mean(np.square(self.between)))
        return animals / (animals + self.within**2) if animals else 0.0

    def on_one_occasion(self, group: int) -> float:
        """Return the SD of the true values of a group."""
        return float(np.hypot(self.between[group], self.within))


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


def _typical(one: Compared) -> float:
    """Return the error that, the same in all animals, makes a group's mean as well known as theirs do."""
    return float(np.sqrt(np.mean(one.known.errors**2)))
