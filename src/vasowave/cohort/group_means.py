"""The mean of each group with its interval: random effects on logarithms, as in the primary comparison."""

from typing import NamedTuple

import numpy as np

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.estimates import Estimates
from vasowave.cohort.pooling import pooled_mean
from vasowave.cohort.primary import known_values
from vasowave.descriptions import LEVEL


class GroupMean(NamedTuple):
    """A group's geometric mean and its interval, in the quantity's unit; ends are NaN where nothing tells them."""

    value: float
    low: float
    high: float


def group_means(cohort: Cohort, source: str, name: str) -> dict[str, GroupMean]:
    """Return the geometric mean of a quantity of a source in every cell that has it, each interval by itself.

    Cells are the groups, or groups at an occasion or level (`Cohort.cells`).

    Animals are weighted by how well each is known, and what they share (`Estimates.shared`) is not averaged away; of
    several recordings of one animal the mean counts.
    Cells with a value that is not positive are left out.
    """
    means = {}
    for label, cell in cohort.cells.items():
        found = known_values(cohort, source, name, [cell.group], cell.results)
        if found is not None and len(found.results) and np.all(np.isfinite(found.known.logs)):
            means[label] = pooled(found.known.by_animal([cohort.subjects[one.name] for one in found.results]))
    return means


def pooled(known: Estimates) -> GroupMean:
    """Return the geometric mean of animals with its interval of 95 % (Hartung and Knapp; Satterthwaite's t)."""
    from scipy.special import stdtrit

    if len(known.logs) < 2 or (not np.any(known.errors) and np.ptp(known.logs) < 1e-9):
        return GroupMean(float(np.exp(known.logs.mean())), np.nan, np.nan)
    one = pooled_mean(known.logs, known.errors)
    common = float((known.covariance - np.diag(known.errors**2)).mean())
    variance = one.error**2 + common
    freedom = one.freedom * (variance / one.error**2) ** 2
    reach = stdtrit(freedom, (1 + LEVEL) / 2) * np.sqrt(variance)
    return GroupMean(*np.exp([one.value, one.value - reach, one.value + reach]).tolist())
