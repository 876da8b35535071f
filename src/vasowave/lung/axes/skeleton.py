"""A tree of points, and its vessels: cut at junctions."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from vasowave.base.errors import InputError
from vasowave.lung.tree import Line, Tree


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Points that lead to the root.

    Attributes
    ----------
    line : Line
        Position and inscribed radius of each point, cm.
    above : int array, shape (point,)
        The next point toward the root, -1 at the root.
    """

    line: Line
    above: np.ndarray


def cut_at_junctions(skeleton: Skeleton, collapse: float = 0.6) -> Tree:
    """Cut a tree of points into vessels and collapse junctions that lie inside one another.

    An inner vessel shorter than `collapse` radii + the point distance is not a vessel: its junctions are one.

    Parameters
    ----------
    skeleton : Skeleton
    collapse : float
        In radii; 0 keeps every vessel longer than the point distance.

    Raises
    ------
    InputError
        No root or more than one, fewer than two points, a root from which several vessels leave.
    """
    root, below = _below(skeleton.above)
    lines: list[Line] = []
    parent: list[int] = []
    waiting = deque((root, first, -1) for first in below[root])
    while waiting:
        junction, point, upstream = waiting.popleft()
        run = [junction, point]
        while len(below[run[-1]]) == 1:
            run.append(below[run[-1]][0])
        line = skeleton.line[run]
        if below[run[-1]] and upstream >= 0 and line.length < shortest(line, collapse):
            waiting.extend((run[-1], first, upstream) for first in below[run[-1]])
            continue
        waiting.extend((run[-1], first, len(lines)) for first in below[run[-1]])
        lines.append(line)
        parent.append(upstream)
    return Tree(tuple(lines), np.array(parent))


def _below(above: np.ndarray) -> tuple[int, list[list[int]]]:
    """Return the root and the points below each point."""
    starts = np.flatnonzero(above < 0)
    if len(starts) != 1 or len(above) < 2:
        raise InputError(f"the paths have {len(starts)} roots and {len(above)} points; one root is needed")
    below: list[list[int]] = [[] for _ in above]
    for point, up in enumerate(above):
        if up >= 0:
            below[up].append(point)
    if len(below[starts[0]]) > 1:
        raise InputError(f"{len(below[starts[0]])} vessels leave the first point of the root; move the root outward")
    return int(starts[0]), below


def shortest(line: Line, collapse: float) -> float:
    """Return the least length of an inner vessel along `line`: `collapse` radii + the point distance, cm."""
    return float(collapse * line.radius.mean() + line.run[1])
