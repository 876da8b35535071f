"""Vessels that run on straight through a junction: two that touch or cross look like branches of one tree."""

import numpy as np
from scipy.spatial.distance import cdist

from vasowave.imaging.axes.stretches import clear_stretches
from vasowave.imaging.tree import Line, Tree
from vasowave.imaging.witness.doubts import Doubt, Grade, doubt_kind

STRAIGHT = 150.0
"""Two vessels that leave a junction in directions so far apart (degrees) may be one that passes: daughters lie within
about 130 degrees of one another."""
NEAR, OVER = 2.0, 3.0
"""Their beginnings lie within so many times the sum of their radii; directions are taken over so many radii from where
they have left their junction and their sisters: before, they bend toward the vessel that they only cross."""

PASSING = doubt_kind(
    "witness.passing-vessel",
    Grade.LOOK,
    "vessel(s) {vessels}: run on straight into one another, as one vessel does that touches or crosses another: "
    "{remedy}",
    "if it is not of this tree, remove both",
)


def crossing_doubts(tree: Tree) -> list[Doubt]:
    """Return a doubt for each pair of vessels, neither beyond the other, that could be one vessel passing by."""
    ways = np.array(
        [_direction(line, begin) for line, (begin, _) in zip(tree.lines, clear_stretches(tree), strict=True)]
    )
    begins = np.array([line.points[0] for line in tree.lines])
    near = NEAR * np.add.outer(*[[line.typical_radius for line in tree.lines]] * 2)
    passing = (ways @ ways.T < np.cos(np.radians(STRAIGHT))) & (cdist(begins, begins) < near)
    doubts = []
    for one, other in np.argwhere(np.triu(passing, 1)).tolist():
        if not (_is_beyond(tree, one, other) or _is_beyond(tree, other, one)):
            names = str(one + 1), str(other + 1)
            places = np.array([tree.lines[row].points[-1] for row in (one, other)])
            doubts.append(Doubt("topology", PASSING(vessels=", ".join(names)), names, places))
    return doubts


def _direction(line: Line, begin: float) -> np.ndarray:
    """Return the unit vector in which a vessel goes on from `begin`, cm along it."""
    near, far = np.searchsorted(line.run, [begin, begin + OVER * line.typical_radius])
    way = line.points[min(far, len(line) - 1)] - line.points[min(near, len(line) - 2)]
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-12))


def _is_beyond(tree: Tree, row: int, other: int) -> bool:
    """Whether `row` lies beyond `other`."""
    while row >= 0 and row != other:
        row = int(tree.parent[row])
    return row == other
