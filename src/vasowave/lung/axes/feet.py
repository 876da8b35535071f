"""Where the points of a surface stand on tubes around polylines."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numba import njit

from vasowave.base.runtime.kernels import kept

_OPTIONS: Any = {"nogil": True, "error_model": "numpy"}

BEYOND = 3.0
"""A tube explains points up to so far outside its wall, voxels."""
MARGIN = 4.0
"""Points are looked for so much farther than a tube explains them, voxels: so far a fit hardly moves an axis."""


@dataclass(frozen=True, eq=False)
class Tubes:
    """Tubes around polylines whose nodes are shared at junctions; lengths in voxels.

    Attributes
    ----------
    nodes : float array, shape (node, 3)
    radius : float array, shape (place,)
        At the nodes, one vessel after the other: at a junction each has its own.
    place_nodes : int array, shape (place,)
        The node of each place; the first of a vessel is the last of its parent.
    begins : int array, shape (vessel + 1,)
        The first place of each vessel, and how many there are.
    parent : int array, shape (vessel,)
        -1 for a root; the vessels of a tree follow its root.
    """

    nodes: np.ndarray
    radius: np.ndarray
    place_nodes: np.ndarray
    begins: np.ndarray
    parent: np.ndarray

    @cached_property
    def tree(self) -> np.ndarray:
        """Number of the tree that each vessel belongs to, in the order of their roots, int array, shape (vessel,)."""
        return np.cumsum(self.parent < 0) - 1

    @property
    def state(self) -> np.ndarray:
        """All unknowns: the nodes' coordinates, then the radii."""
        return np.concatenate([self.nodes.ravel(), self.radius])

    @cached_property
    def pieces(self) -> np.ndarray:
        """The first place of each piece of an axis, int array, shape (piece,)."""
        return np.delete(np.arange(len(self.place_nodes)), self.begins[1:] - 1)

    @cached_property
    def lengths(self) -> np.ndarray:
        """Length of each piece, float array, shape (piece,)."""
        pieces = self.nodes[self.place_nodes[self.pieces + 1]] - self.nodes[self.place_nodes[self.pieces]]
        return np.asarray(np.linalg.norm(pieces, axis=1))

    @property
    def explained(self) -> np.ndarray:
        """How much farther than its wall a point may be from a vessel's nearest node, shape (vessel,)."""
        return BEYOND + np.maximum.reduceat(self.lengths, self.begins[:-1] - np.arange(len(self.parent)))


@dataclass(frozen=True, eq=False)
class Feet:
    """Points of the surface and where they stand on the tubes; arrays over the points.

    Attributes
    ----------
    gap : float array
        Distance from the tube, voxels; negative inside.
    normal : float array, shape (point, 3)
        Unit vector from the axis to the point.
    place : int array
        The place before the foot.
    share : float array
        The foot's position between this and the next place, 0 to 1.
    vessel : int array
    lost : int array
        Points that lie near no tube; what lies at a free end lies near one, but on no wall.
    """

    gap: np.ndarray
    normal: np.ndarray
    place: np.ndarray
    share: np.ndarray
    vessel: np.ndarray
    lost: np.ndarray


def near_points(tubes: Tubes, points: np.ndarray, begins: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which of `points` may lie near the wall of each vessel, now and after it has moved by MARGIN.

    Parameters
    ----------
    tubes : Tubes
    points : float array, shape (point, 3)
        One tree after the other.
    begins : int array, shape (tree + 1,)
        The first point of each tree, and how many there are.

    Returns
    -------
    int array
        Rows of `points`, one vessel after the other.
    int array, shape (vessel + 1,)
        Where those of each vessel begin, and how many there are.
    """
    reach = np.maximum.reduceat(tubes.radius, tubes.begins[:-1]) + tubes.explained + MARGIN
    return _near(
        tubes.nodes[tubes.place_nodes], tubes.begins, reach, points, begins[tubes.tree], begins[tubes.tree + 1]
    )


def feet_on(tubes: Tubes, points: np.ndarray, candidates: tuple[np.ndarray, np.ndarray]) -> Feet:
    """Return where those of `points`, shape (point, 3), that lie near a tube's wall stand on the tube nearest to them.

    Only the `candidates` are looked at, see `near_points`.
    """
    closed = np.isin(np.arange(len(tubes.parent)), tubes.parent, invert=True)
    gap, place, along, vessel, normal, wall = _stood(
        (tubes.nodes[tubes.place_nodes], tubes.radius, tubes.begins),
        (tubes.explained, tubes.parent, closed),
        points,
        *candidates,
    )
    return Feet(gap[wall], normal[wall], place[wall], along[wall], vessel[wall], np.flatnonzero(np.isinf(gap)))


@kept
@njit(**_OPTIONS)
def _near(nodes, begins, reach, points, first, last):
    """Return which points of its own, from `first` to before `last`, lie within `reach` of a node of each vessel."""
    rows = [0 for _ in range(0)]  # empty, of whole numbers: the compiler asks of what
    row_begins, low, high = np.zeros(len(begins), dtype=np.int64), np.empty(3), np.empty(3)
    for vessel in range(len(reach)):
        axis, farthest = nodes[begins[vessel] : begins[vessel + 1]], reach[vessel]
        for k in range(3):
            low[k], high[k] = axis[:, k].min() - farthest, axis[:, k].max() + farthest
        for row in range(first[vessel], last[vessel]):
            x, y, z = points[row, 0], points[row, 1], points[row, 2]
            if low[0] <= x <= high[0] and low[1] <= y <= high[1] and low[2] <= z <= high[2]:
                for node in range(len(axis)):
                    square = (x - axis[node, 0]) ** 2 + (y - axis[node, 1]) ** 2 + (z - axis[node, 2]) ** 2
                    if square <= farthest * farthest:
                        rows.append(row)
                        break
        row_begins[vessel + 1] = len(rows)
    return np.array(rows), row_begins


@kept
@njit(**_OPTIONS)
def _stood(places, vessels, points, candidates, candidate_begins):
    """Return for each point its gap, piece, the foot along it (0 to 1), vessel, normal, and whether that is a wall.

    `places` are nodes and radii, one vessel after the other, each from its place in `begins`; `candidates` likewise.
    `vessels` are how far each explains points, its parent, and whether it is a terminal.
    """
    (nodes, radius, begins), (explained, parent, closed) = places, vessels
    count = len(points)
    gap, along = np.full(count, np.inf), np.zeros(count)
    piece, vessel = np.zeros(count, dtype=np.int64), np.full(count, -1)
    normal, wall = np.zeros((count, 3)), np.zeros(count, dtype=np.bool_)
    steps = nodes[1:] - nodes[:-1]
    for tube in range(len(parent)):
        first, last = begins[tube], begins[tube + 1] - 1
        last_piece = np.sqrt((steps[last - 1] ** 2).sum())
        for point in candidates[candidate_begins[tube] : candidate_begins[tube + 1]]:
            x, y, z = points[point, 0], points[point, 1], points[point, 2]
            smallest_square, nearest = np.inf, first
            for node in range(first, last + 1):
                square = (x - nodes[node, 0]) ** 2 + (y - nodes[node, 1]) ** 2 + (z - nodes[node, 2]) ** 2
                if square < smallest_square:
                    smallest_square, nearest = square, node
            if smallest_square > (radius[nearest] + explained[tube]) ** 2:
                continue
            # The foot lies on one of the two pieces beside the nearest node; beyond the axis' ends it is held there.
            smallest_square = np.inf
            for segment in (min(nearest, last - 1), max(nearest - 1, first)):
                u, v, w = steps[segment, 0], steps[segment, 1], steps[segment, 2]
                a, b, c = x - nodes[segment, 0], y - nodes[segment, 1], z - nodes[segment, 2]
                foot = (a * u + b * v + c * w) / max(u * u + v * v + w * w, 1e-12)
                held = min(max(foot, 0.0), 1.0)
                a, b, c = a - held * u, b - held * v, c - held * w
                square = a * a + b * b + c * c
                if square < smallest_square:
                    smallest_square, on, free, share, away = square, segment, foot, held, (a, b, c)
            distance = np.sqrt(smallest_square)
            beyond = distance - (1 - share) * radius[on] - share * radius[on + 1]
            if beyond < gap[point]:
                gap[point], piece[point], along[point], vessel[point] = beyond, on, share, tube
                for k in range(3):
                    normal[point, k] = away[k] / max(distance, 1e-9)
                # No wall: what lies before the root, and a terminal's last radius with its cap.
                is_wall = free >= 0 or parent[tube] >= 0
                if closed[tube]:
                    is_wall = is_wall and (last - on - free) * last_piece > radius[last]
                wall[point] = is_wall
    return gap, piece, along, vessel, normal, wall
