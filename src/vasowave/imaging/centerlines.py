"""Center paths of a lumen: minimal paths from the root that keep to the middle (the TEASAR idea)."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from vasowave.errors import InputError
from vasowave.imaging.segmentation import Segmentation, surface_points

BALL, MARGIN = 1.1, 1.9
"""A tip counts if it protrudes from all balls of BALL inscribed radii + MARGIN voxels around longer paths."""


@dataclass(frozen=True, eq=False)
class Paths:
    """Root-to-tip paths that share their beginnings.

    Attributes
    ----------
    points : float array, shape (point, 4)
        z, y, x and inscribed radius, cm.
    above : int array, shape (point,)
        The next point toward the root, -1 at the root.
    surface : float array, shape (corner, 3)
        Points of the lumen's surface, cm.
    """

    points: np.ndarray
    above: np.ndarray
    surface: np.ndarray


def center_paths(lumen: Segmentation, root: np.ndarray, outlets: np.ndarray | None = None) -> Paths:
    """Return the center paths from `root` to every tip, or to the given `outlets`.

    Parameters
    ----------
    lumen : Segmentation
    root : float array, shape (3,)
        A point in or at the lumen where the blood enters (z, y, x, cm).
    outlets : float array, shape (outlet, 3), optional
        Guided mode: one path to each of these and no other.

    Raises
    ------
    InputError
        The root or an outlet farther than 5 voxels from the lumen; each is named.
    """
    surface = surface_points(lumen)
    voxels = np.argwhere(lumen.mask)
    depth = cKDTree(surface).query(voxels * lumen.spacing + lumen.origin)[0] / lumen.spacing
    graph, lengths = _neighbors(lumen.mask, depth)
    start = _nearest(lumen, voxels, np.atleast_2d(root), "root")[0]
    travelled = dijkstra(lengths, indices=start)
    _, above = dijkstra(graph, indices=start, return_predecessors=True)
    travelled[~np.isfinite(travelled)] = -1.0
    if outlets is None:
        kept = _tips(voxels, depth, travelled, above, start)
    else:
        kept = _walk(above, _nearest(lumen, voxels, np.atleast_2d(outlets), "outlet"), start)
    rows = np.flatnonzero(kept)
    new = np.full(len(voxels), -1)
    new[rows] = np.arange(len(rows))
    up = np.where(rows == start, -1, new[np.maximum(above[rows], 0)])
    points = np.column_stack([voxels[rows] * lumen.spacing + lumen.origin, depth[rows] * lumen.spacing])
    return Paths(points, up, surface)


def _neighbors(mask: np.ndarray, depth: np.ndarray) -> tuple[coo_array, coo_array]:
    """Return the 26-neighbor graph of the lumen twice: cost that favors the middle, and plain length."""
    number = np.full(mask.shape, -1, dtype=np.int64)
    number[mask] = np.arange(len(depth))
    padded = np.pad(number, 1, constant_values=-1)
    here, there, length = [], [], []
    offsets = [o for o in np.ndindex(3, 3, 3) if o > (1, 1, 1)]
    for offset in offsets:
        window = tuple(slice(o, o + n) for o, n in zip(offset, mask.shape, strict=True))
        other = padded[window]
        both = mask & (other >= 0)
        here.append(number[both])
        there.append(other[both])
        length.append(np.full(both.sum(), np.linalg.norm(np.array(offset) - 1)))
    i, j, far = np.concatenate(here), np.concatenate(there), np.concatenate(length)
    # Cost 1/depth² per length: a detour through the middle of the vessel is always the cheaper way.
    cost = far / (0.5 * (np.maximum(depth[i], 0.2) + np.maximum(depth[j], 0.2))) ** 2
    shape = (len(depth), len(depth))
    both_ways = (np.concatenate([i, j]), np.concatenate([j, i]))
    return (
        coo_array((np.tile(cost, 2), both_ways), shape=shape).tocsr(),
        coo_array((np.tile(far, 2), both_ways), shape=shape).tocsr(),
    )


def _nearest(lumen: Segmentation, voxels: np.ndarray, places: np.ndarray, what: str) -> np.ndarray:
    distance, found = cKDTree(voxels).query((places - lumen.origin) / lumen.spacing)
    for place, gap in zip(places, distance, strict=True):
        if gap > 5:
            raise InputError(f"{what} {place} cm (z, y, x) was not reached: {gap:.0f} voxels from the lumen; move it")
    return np.asarray(found)


def _walk(above: np.ndarray, tips: np.ndarray, start: int) -> np.ndarray:
    """Return which voxels lie on the paths from `tips` to `start`."""
    kept = np.zeros(len(above), dtype=bool)
    kept[start] = True
    for tip in tips:
        while not kept[tip]:
            kept[tip] = True
            tip = above[tip]
    return kept


def _tips(voxels: np.ndarray, depth: np.ndarray, travelled: np.ndarray, above: np.ndarray, start: int) -> np.ndarray:
    """Return the union of paths to tips that protrude from the inscribed balls of all longer paths."""
    tree = cKDTree(voxels)
    free = travelled >= 0
    kept = np.zeros(len(above), dtype=bool)
    kept[start] = True
    for tip in np.argsort(travelled)[::-1]:
        if not free[tip]:
            continue
        path = []
        while not kept[tip]:
            kept[tip] = True
            path.append(tip)
            tip = above[tip]
        for near in tree.query_ball_point(voxels[path], BALL * depth[path] + MARGIN):
            free[near] = False
    return kept
