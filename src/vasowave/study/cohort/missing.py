"""Which animals a comparison of groups misses, and what that may do: animals fall out because of what they are."""

from dataclasses import asdict, dataclass
from enum import StrEnum

import numpy as np

from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort


class PressureRank(StrEnum):
    """Where the measured mean pressures of missing animals lie among those of the others of their group."""

    ABOVE = "above all others"
    HIGHER = "above the median of the others"
    LOWER = "not above the median of the others"
    BELOW = "below all others"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class Missing:
    """The animals of one group that a comparison misses."""

    group: str
    animals: tuple[str, ...]
    """All that are missing."""
    lost: tuple[str, ...]
    """Those of them that have no result at all, so that comparisons of what was measured miss them too."""
    count: int
    """Animals of the group, with those that are missing."""
    pressures: tuple[float, ...]
    others: tuple[float, ...]
    """Measured mPAP, mmHg: of the missing animals of which it is known, and of the others."""

    @property
    def standing(self) -> PressureRank:
        """Where the missing animals' pressures lie; unknown where there are none to compare, or not of all."""
        if len(self.pressures) < len(self.animals) or not self.others:
            return PressureRank.UNKNOWN
        if min(self.pressures) > max(self.others):
            return PressureRank.ABOVE
        if max(self.pressures) < min(self.others):
            return PressureRank.BELOW
        higher = np.mean(self.pressures) > np.median(self.others)
        return PressureRank.HIGHER if higher else PressureRank.LOWER

    def as_plain(self) -> dict[str, object]:
        """Return the attributes and the standing as JSON can hold them."""
        return asdict(self) | {"standing": str(self.standing)}


def missing_animals(cohort: Cohort, law: str) -> tuple[Missing, ...]:
    """Return, group by group, who is missing from a comparison by a wall law: without a result, or without that law.

    Where no animal has a law (`law` is empty) only those count that have no result.
    """
    groups = [
        *cohort.groups,
        *dict.fromkeys(failure.group for failure in cohort.lost if failure.group not in cohort.groups),
    ]
    by_group = [_missing_of(cohort, group, law) for group in groups]
    return tuple(missing for missing in by_group if missing.animals)


def _missing_of(cohort: Cohort, group: str, law: str) -> Missing:
    lost = [failure for failure in cohort.lost if failure.group == group]
    members = cohort.groups.get(group, [])
    without = [result for result in members if law and law not in result.laws]
    present = [result for result in members if not law or law in result.laws]
    pressures = tuple(failure.mean_pressure for failure in lost if failure.mean_pressure is not None)
    names = tuple(failure.animal for failure in lost)
    return Missing(
        group, (*names, *(result.name for result in without)), names, len(members) + len(lost),
        (*pressures, *map(_pressure, without)), tuple(map(_pressure, present)),
    )  # fmt: skip


def _pressure(result: AnimalResult) -> float:
    return float(result.measured.quantities["mPAP"])
