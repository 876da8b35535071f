"""Where along a vessel its lumen is its own: outside junctions, ends and the tubes of its sisters."""

import numpy as np
from scipy.spatial import cKDTree

from vasowave.imaging.tree import Tree


def free_length(tree: Tree) -> np.ndarray:
    """Return the length of each vessel in its clear stretch (see `clear_stretches`), cm, shape (vessel,)."""
    return np.array([max(end - begin, 0.0) for begin, end in clear_stretches(tree)])


def free_stretches(tree: Tree) -> list[tuple[float, float]]:
    """Return where each vessel leaves its first junction's ball and where it enters the last or nears its end, cm."""
    stretches = []
    for row, line in enumerate(tree.lines):
        tail = line.typical_radius if row in tree.terminals else line.radius[-1]
        stretches.append((float(line.radius[0]), float(line.length - tail)))
    return stretches


def clear_stretches(tree: Tree) -> list[tuple[float, float]]:
    """Return the free stretches of `tree` without what lies in the tube of a sister, cm.

    A thin vessel runs on in the wide tube of its sister long after it has left the junction's ball, and its center
    path there is not its axis. At most half a vessel's length is given up to its sisters.
    """
    stretches = []
    for row, (begin, end) in enumerate(free_stretches(tree)):
        line = tree.lines[row]
        for sister in np.flatnonzero((tree.parent == tree.parent[row]) & (tree.parent >= 0)):
            if sister != row:
                distance = cKDTree(tree.lines[sister].points).query(line.points)[0]
                near = distance < tree.lines[sister].typical_radius + 0.5 * line.typical_radius
                first = len(line) - 1 if near.all() else int(np.argmin(near))
                begin = max(begin, min(float(line.run[first]), 0.5 * line.length))
        stretches.append((begin, end))
    return stretches
