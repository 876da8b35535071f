"""Where the points of a surface stand on tubes around polylines."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree


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
    """

    nodes: np.ndarray
    radius: np.ndarray
    rows: tuple[np.ndarray, ...]
    places: tuple[np.ndarray, ...]
    parent: np.ndarray


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
    """

    gap: np.ndarray
    normal: np.ndarray
    nodes: np.ndarray
    places: np.ndarray
    share: np.ndarray
    vessel: np.ndarray


def feet_on(tubes: Tubes, points: np.ndarray) -> Feet:
    """Return where those of `points` that lie near a tube's wall stand on the tube nearest to them."""
    ends = np.setdiff1d(np.arange(len(tubes.rows)), tubes.parent)
    gap, share = np.full(len(points), np.inf), np.zeros(len(points))
    nodes, places = np.zeros((len(points), 2), dtype=int), np.zeros((len(points), 2), dtype=int)
    vessel, wall, normal = np.full(len(points), -1), np.zeros(len(points), dtype=bool), np.zeros((len(points), 3))
    for row, (own, place) in enumerate(zip(tubes.rows, tubes.places, strict=True)):
        axis, radius = tubes.nodes[own], tubes.radius[place]
        reach = radius + 3 + np.linalg.norm(np.diff(axis, axis=0), axis=1).max()
        near, nearest = _near(axis, points, reach)
        piece, along, away = _projected(axis, points[near], nearest)
        held, distance = np.clip(along, 0, 1), np.linalg.norm(away, axis=1)
        beyond = distance - (1 - held) * radius[piece] - held * radius[piece + 1]
        less = beyond < gap[near]
        at, piece, along = near[less], piece[less], along[less]
        gap[at], share[at], vessel[at] = beyond[less], held[less], row
        normal[at] = away[less] / np.maximum(distance[less], 1e-9)[:, None]
        nodes[at] = np.stack([own[piece], own[piece + 1]], axis=1)
        places[at] = np.stack([place[piece], place[piece + 1]], axis=1)
        # No wall: what lies before the root, and a terminal's last radius with its cap.
        wall[at] = along >= 0 if tubes.parent[row] < 0 else True
        if row in ends:
            left = (len(axis) - 1 - piece - along) * np.linalg.norm(axis[-1] - axis[-2])
            wall[at] &= left > radius[-1]
    return Feet(*(values[wall] for values in (gap, normal, nodes, places, share, vessel)))


def _near(axis: np.ndarray, points: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which of `points` lie within its `reach` of the node of `axis` nearest to them, and that node."""
    rows, most = np.arange(len(points)), float(reach.max())
    for along, low, high in zip(points.T, axis.min(axis=0) - most, axis.max(axis=0) + most, strict=True):
        own = along[rows]
        rows = rows[(own >= low) & (own <= high)]
    distance, nearest = cKDTree(axis).query(points[rows], distance_upper_bound=most * (1 + 1e-9))
    found = distance <= np.append(reach, -1.0)[nearest]
    return rows[found], nearest[found]


def _projected(axis: np.ndarray, points: np.ndarray, nearest: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return each point's nearest piece of `axis`, where its foot lies along it, and the vector to it from the piece.

    The foot's position is 0 to 1, beyond these past the ends of the axis; `nearest` is the node nearest to each point.
    """
    sides = []
    for piece in (np.maximum(nearest - 1, 0), np.minimum(nearest, len(axis) - 2)):
        along = axis[piece + 1] - axis[piece]
        foot = ((points - axis[piece]) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-12)
        sides.append((piece, foot, points - axis[piece] - np.clip(foot, 0, 1)[:, None] * along))
    before, after = sides
    nearer = np.linalg.norm(before[2], axis=1) < np.linalg.norm(after[2], axis=1)
    piece, foot = (np.where(nearer, one, other) for one, other in zip(before[:2], after[:2], strict=True))
    return piece, foot, np.where(nearer[:, None], before[2], after[2])
