"""Where the points of a surface stand on tubes around polylines."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

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
    rows, places : tuple of int array
        Each vessel's nodes, the first being the last of its parent, and where its radii stand.
    parent : int array, shape (vessel,)
        -1 for a root; the vessels of a tree follow its root.
    """

    nodes: np.ndarray
    radius: np.ndarray
    rows: tuple[np.ndarray, ...]
    places: tuple[np.ndarray, ...]
    parent: np.ndarray

    @cached_property
    def tree(self) -> np.ndarray:
        """Number of the tree that each vessel belongs to, in the order of their roots, int array, shape (vessel,)."""
        return np.cumsum(self.parent < 0) - 1

    @property
    def state(self) -> np.ndarray:
        """All unknowns: the nodes' coordinates, then the radii."""
        return np.concatenate([self.nodes.ravel(), self.radius])


@dataclass(frozen=True, eq=False)
class Feet:
    """Points of the surface and where they stand on the tubes; arrays over the points.

    Attributes
    ----------
    gap : float array
        Distance from the tube, voxels; negative inside.
    normal : float array, shape (point, 3)
        Unit vector from the axis to the point.
    nodes, places : int array, shape (point, 2)
        The nodes before and after the foot, and where their radii stand.
    share : float array
        The foot's position between these, 0 to 1.
    vessel : int array
    lost : int array
        Points that lie near no tube; what lies at a free end lies near one, but on no wall.
    """

    gap: np.ndarray
    normal: np.ndarray
    nodes: np.ndarray
    places: np.ndarray
    share: np.ndarray
    vessel: np.ndarray
    lost: np.ndarray


def near_points(tubes: Tubes, row: int, points: np.ndarray) -> np.ndarray:
    """Return the rows of `points` that may lie near the wall of vessel `row`, now and after it has moved by MARGIN."""
    axis, radius = tubes.nodes[tubes.rows[row]], tubes.radius[tubes.places[row]]
    most, rows = float(_reach(axis, radius).max()) + MARGIN, np.arange(len(points))
    for along, low, high in zip(points.T, axis.min(axis=0) - most, axis.max(axis=0) + most, strict=True):
        values = along[rows]
        rows = rows[(values >= low) & (values <= high)]
    return rows[np.isfinite(cKDTree(axis).query(points[rows], distance_upper_bound=most)[0])]


def feet_on(tubes: Tubes, points: np.ndarray, near: Sequence[np.ndarray]) -> Feet:
    """Return where those of `points` that lie near a tube's wall stand on the tube nearest to them.

    Parameters
    ----------
    tubes : Tubes
    points : float array, shape (point, 3)
    near : sequence of int array
        Which of them to look at, by vessel, see `near_points`.
    """
    ends = np.setdiff1d(np.arange(len(tubes.rows)), tubes.parent)
    gap, share = np.full(len(points), np.inf), np.zeros(len(points))
    nodes, places = np.zeros((len(points), 2), dtype=int), np.zeros((len(points), 2), dtype=int)
    vessel, wall, normal = np.full(len(points), -1), np.zeros(len(points), dtype=bool), np.zeros((len(points), 3))
    for row, (own, place, rows) in enumerate(zip(tubes.rows, tubes.places, near, strict=True)):
        axis, radius = tubes.nodes[own], tubes.radius[place]
        distance, nearest = cKDTree(axis).query(points[rows])
        close = distance <= _reach(axis, radius)[nearest]
        rows = rows[close]
        piece, along, away, distance = _projected(axis, points[rows], nearest[close])
        held = np.clip(along, 0, 1)
        beyond = distance - (1 - held) * radius[piece] - held * radius[piece + 1]
        less = beyond < gap[rows]
        at, piece, along = rows[less], piece[less], along[less]
        gap[at], share[at], vessel[at] = beyond[less], held[less], row
        normal[at] = away[less] / np.maximum(distance[less], 1e-9)[:, None]
        nodes[at] = np.stack([own[piece], own[piece + 1]], axis=1)
        places[at] = np.stack([place[piece], place[piece + 1]], axis=1)
        # No wall: what lies before the root, and a terminal's last radius with its cap.
        wall[at] = along >= 0 if tubes.parent[row] < 0 else True
        if row in ends:
            left = (len(axis) - 1 - piece - along) * np.linalg.norm(axis[-1] - axis[-2])
            wall[at] &= left > radius[-1]
    lost = np.flatnonzero(np.isinf(gap))
    return Feet(gap[wall], normal[wall], nodes[wall], places[wall], share[wall], vessel[wall], lost)


def _reach(axis: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Return how far from each node of `axis` a point may be that its tube explains, voxels."""
    return np.asarray(radius + BEYOND + np.linalg.norm(np.diff(axis, axis=0), axis=1).max())


def _projected(axis: np.ndarray, points: np.ndarray, nearest: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return each point's nearest piece of `axis`, where its foot lies along it, the vector to it from there, its norm.

    The foot's position is 0 to 1, beyond these past the ends of the axis; `nearest` is the node nearest to each point.
    """
    steps = np.diff(axis, axis=0)
    square = np.maximum(np.einsum("ij,ij->i", steps, steps), 1e-12)
    sides = []
    for piece in (np.maximum(nearest - 1, 0), np.minimum(nearest, len(axis) - 2)):
        away, along = points - axis[piece], steps[piece]
        foot = np.einsum("ij,ij->i", away, along) / square[piece]
        away -= np.clip(foot, 0, 1)[:, None] * along
        sides.append((piece, foot, away, np.einsum("ij,ij->i", away, away)))
    before, after = sides
    nearer = before[3] < after[3]
    piece, foot, distance = (np.where(nearer, before[k], after[k]) for k in (0, 1, 3))
    return piece, foot, np.where(nearer[:, None], before[2], after[2]), np.sqrt(distance)
