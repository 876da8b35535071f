"""From center paths to vessels: cut at junctions, measure lengths and radii."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from vasowave.errors import InputError
from vasowave.network import Network


@dataclass(frozen=True, eq=False)
class Tree:
    """Vessels in space; row i of every field is the same vessel, parents before daughters.

    Attributes
    ----------
    lines : tuple of float array, shape (point, 4)
        z, y, x, inscribed radius of each vessel from its junction to its end, cm.
    parent : int array, shape (vessel,)
        Row of the parent, -1 for the root.
    """

    lines: tuple[np.ndarray, ...]
    parent: np.ndarray


def cut_at_junctions(points: np.ndarray, above: np.ndarray, collapse: float = 0.6) -> Tree:
    """Cut a tree of points into vessels and collapse junctions that lie inside one another.

    An inner vessel shorter than `collapse` radii + the point distance is no vessel: its junctions are one.

    Parameters
    ----------
    points : float array, shape (point, 4)
        z, y, x, inscribed radius, cm.
    above : int array, shape (point,)
        The next point toward the root, -1 at the root.
    collapse : float
        In radii; 0 keeps every vessel longer than the point distance.

    Raises
    ------
    InputError
        No root or more than one, fewer than two points, a root from which several vessels leave.
    """
    starts = np.flatnonzero(above < 0)
    if len(starts) != 1 or len(above) < 2:
        raise InputError(f"the paths have {len(starts)} roots and {len(above)} points; one root is needed")
    below: list[list[int]] = [[] for _ in above]
    for point, up in enumerate(above):
        if up >= 0:
            below[up].append(point)
    if len(below[starts[0]]) > 1:
        raise InputError(f"{len(below[starts[0]])} vessels leave the first point of the root; move the root outward")
    lines: list[np.ndarray] = []
    parent: list[int] = []
    waiting = deque((int(starts[0]), first, -1) for first in below[starts[0]])
    while waiting:
        junction, point, upstream = waiting.popleft()
        run = [junction, point]
        while len(below[run[-1]]) == 1:
            run.append(below[run[-1]][0])
        line = points[run]
        if below[run[-1]] and upstream >= 0 and _length(line) < _shortest(line, collapse):
            waiting.extend((run[-1], first, upstream) for first in below[run[-1]])
            continue
        waiting.extend((run[-1], first, len(lines)) for first in below[run[-1]])
        lines.append(line)
        parent.append(upstream)
    return Tree(tuple(lines), np.array(parent))


def _shortest(line: np.ndarray, collapse: float) -> float:
    return float(collapse * line[:, 3].mean() + np.linalg.norm(line[1, :3] - line[0, :3]))


def _length(line: np.ndarray) -> float:
    """Length: sum of the distances of successive points, cm (eq. 1)."""
    return float(np.linalg.norm(np.diff(line[:, :3], axis=0), axis=1).sum())


def distance_along(line: np.ndarray) -> np.ndarray:
    """Distance of each point from the first, along `line`, cm."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line[:, :3], axis=0), axis=1))])


def network_of(tree: Tree) -> Network:
    """Return lengths and mean radii of `tree` (eq. 1); vessels are numbered from 1 in the order of the tree.

    The radius is the mean over the points outside the junctions' inscribed balls and sisters' tubes and farther than
    a radius from a free end; the median of all points where no such point exists.

    Raises
    ------
    InputError
        As `Network`.
    """
    length = [distance_along(line)[-1] for line in tree.lines]
    radius = []
    for line, (begin, end) in zip(tree.lines, clear_stretches(tree), strict=True):
        run = distance_along(line)
        away = (run > begin) & (run < end)
        radius.append(float(line[away, 3].mean()) if away.any() else typical_radius(line))
    return Network(tuple(str(i + 1) for i in range(len(length))), tree.parent, np.array(length), np.array(radius))


def free_length(tree: Tree) -> np.ndarray:
    """Return the length of each vessel in its clear stretch (see `clear_stretches`), cm, shape (vessel,)."""
    return np.array([max(end - begin, 0.0) for begin, end in clear_stretches(tree)])


def free_stretches(tree: Tree) -> list[tuple[float, float]]:
    """Return where each vessel leaves its first junction's ball and where it enters the last or nears its end, cm."""
    ends = set(range(len(tree.lines))) - set(tree.parent.tolist())
    found = []
    for row, line in enumerate(tree.lines):
        tail = typical_radius(line) if row in ends else line[-1, 3]
        found.append((float(line[0, 3]), float(distance_along(line)[-1] - tail)))
    return found


def clear_stretches(tree: Tree) -> list[tuple[float, float]]:
    """Return the free stretches of `tree` without what lies in the tube of a sister, cm.

    A thin vessel runs on in the wide tube of its sister long after it has left the junction's ball, and its center
    path there is not its axis. At most half a vessel's length is given up to its sisters.
    """
    typical = [typical_radius(line) for line in tree.lines]
    found = []
    for row, (begin, end) in enumerate(free_stretches(tree)):
        line, run = tree.lines[row], distance_along(tree.lines[row])
        for sister in np.flatnonzero((tree.parent == tree.parent[row]) & (tree.parent >= 0)):
            if sister != row:
                distance = cKDTree(tree.lines[sister][:, :3]).query(line[:, :3])[0]
                near = distance < typical[sister] + 0.5 * typical[row]
                first = len(run) - 1 if near.all() else int(np.argmin(near))
                begin = max(begin, min(float(run[first]), 0.5 * float(run[-1])))
        found.append((begin, end))
    return found


def with_inscribed_radii(lines: Sequence[np.ndarray], parent: np.ndarray, surface: np.ndarray) -> Tree:
    """Return the tree of `lines` (z, y, x, cm), each point with its distance to the nearest of the `surface`'s."""
    index = cKDTree(surface)
    return Tree(tuple(np.column_stack([line, index.query(line)[0]]) for line in lines), parent)


def typical_radius(line: np.ndarray) -> float:
    """Return the median inscribed radius of `line` without its first third, which is often wider, cm."""
    return float(np.median(line[len(line) // 3 :, 3]))
