"""Groups divided by the levels of a second column of the design, so that before and after are not described as one."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from vasowave.animal.result import AnimalResult
from vasowave.cohort.variables import Variable

_MOST_LEVELS = 6
"""Levels of a column that are described one by one; a dose or time of more is a number, not a few classes."""


class Cell(NamedTuple):
    """The recordings of one group at one level; of the whole group where the design has no second column."""

    group: str
    level: str
    results: list[AnimalResult]


def levels_of(second: Variable | None) -> list[str]:
    """Return the levels that are described one by one, the reference first; none where there is nothing to divide."""
    order = second.order if second else []
    return order if len(order) <= _MOST_LEVELS else []


def cells_of(groups: Mapping[str, Sequence[AnimalResult]], second: Variable | None) -> dict[str, Cell]:
    """Return the recordings by group and level, called ``group, level``; the groups themselves without a column."""
    levels = levels_of(second)
    if second is None or not levels:
        return {group: Cell(group, "", list(results)) for group, results in groups.items()}
    known = second.levels
    cells = {}
    for group, results in groups.items():
        for level in [*levels, f"{second.name} not known"]:
            own = [one for one in results if known.get(one.name, f"{second.name} not known") == level]
            if own:
                cells[f"{group}, {level}"] = Cell(group, level, own)
    return cells


def common_level(groups: Mapping[str, Sequence[AnimalResult]], second: Variable | None) -> str:
    """Return the first level that every group has, at which one recording of each may stand beside the others."""
    known = {} if second is None else second.levels
    for level in levels_of(second):
        if all(any(known.get(one.name) == level for one in results) for results in groups.values()):
            return level
    return ""
