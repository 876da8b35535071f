"""Where along a vessel its lumen is its own: outside junctions, ends and the tubes of its sisters."""

import numpy as np
from scipy.spatial import cKDTree

from vasowave.imaging.tree import Line, Tree


def free_length(tree: Tree) -> np.ndarray:
    """Return the length of each vessel in its clear stretch (see `clear_stretches`), cm, shape (vessel,)."""
    return np.array([max(end - begin, 0.0) for begin, end in clear_stretches(tree)])


def free_stretches(tree: Tree) -> list[tuple[float, float]]:
    """Return where each vessel leaves its first junction's ball and where it enters the last or nears its end, cm."""
    return [free_stretch(line, row in tree.terminals) for row, line in enumerate(tree.lines)]


def free_stretch(line: Line, is_terminal: bool) -> tuple[float, float]:
    """Return where one vessel leaves its first junction's ball and where it enters the last or nears its end, cm."""
    tail = line.typical_radius if is_terminal else line.radius[-1]
    return float(line.radius[0]), float(line.length - tail)


def clear_stretches(tree: Tree) -> list[tuple[float, float]]:
    """Return the free stretches of `tree` without what lies in the tube of a sister, cm, see `clear_stretch`."""
    return [clear_stretch(tree, row, stretch) for row, stretch in enumerate(free_stretches(tree))]


def clear_stretch(tree: Tree, row: int, free: tuple[float, float]) -> tuple[float, float]:
    """Return the `free` stretch of one vessel without what lies in the tube of a sister, cm.

    A thin vessel runs on in the wide tube of its sister long after it has left the junction's ball, and its center
    path there is not its axis. At most half a vessel's length is given up to its sisters.
    """
    line, (begin, end) = tree.lines[row], free
    for sister in np.flatnonzero((tree.parent == tree.parent[row]) & (tree.parent >= 0)):
        if sister != row:
            distance = cKDTree(tree.lines[sister].points).query(line.points)[0]
            near = distance < tree.lines[sister].typical_radius + 0.5 * line.typical_radius
            first = len(line) - 1 if near.all() else int(np.argmin(near))
            begin = max(begin, min(float(line.run[first]), 0.5 * line.length))
    return begin, end
