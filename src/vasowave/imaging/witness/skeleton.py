"""The second witness: the lumen thinned to a skeleton by another library, which knows nothing of paths and tubes."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from vasowave.errors import InputError
from vasowave.imaging.lumen.segmentation import Segmentation

SPUR = 1.0, 4.0
"""A branch of the skeleton is a vessel if it reaches so many radii + voxels beyond the middle of its junction."""


@dataclass(frozen=True, eq=False)
class Branches:
    """A tree of branches of the skeleton; row i of every field is the same branch.

    Attributes
    ----------
    begin, end : float array, shape (branch, 3)
        z, y, x, cm.
    parent : int array, shape (branch,)
        -1 for those that leave the root.
    length : float array, shape (branch,)
        cm.
    radius : float array, shape (branch,)
        Largest distance to the wall at the two ends, cm.
    """

    begin: np.ndarray
    end: np.ndarray
    parent: np.ndarray
    length: np.ndarray
    radius: np.ndarray


def skeleton_branches(lumen: Segmentation, root: np.ndarray, surface: np.ndarray) -> Branches:
    """Return the branches of the lumen's skeleton (Lee's thinning), without spurs, seen from `root` (z, y, x, cm).

    Parameters
    ----------
    lumen : Segmentation
    root : float array, shape (3,)
    surface : float array, shape (corner, 3)
        Points of the lumen's surface, cm.
    """
    try:
        from skimage.morphology import skeletonize
    except ImportError:
        raise InputError("the second witness needs the extra 'imaging': install vasowave[imaging]") from None
    points = np.argwhere(skeletonize(np.pad(lumen.mask, 1))) - 1
    places = points * lumen.spacing + lumen.origin
    depth = cKDTree(surface).query(places)[0]
    pairs = cKDTree(points).query_pairs(1.8, output_type="ndarray")
    far = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1) * lumen.spacing
    graph = coo_array((far, pairs.T), shape=(len(points),) * 2).tocsr()
    start = int(np.argmin(np.linalg.norm(places - root, axis=1)))
    way, above = dijkstra(graph, directed=False, indices=start, return_predecessors=True)
    above[~np.isfinite(way)] = start
    kept = _without_spurs(places, depth, way, above, start, lumen.spacing)
    return _branches(places, depth, way, above, kept, start)


def _without_spurs(
    places: np.ndarray, depth: np.ndarray, way: np.ndarray, above: np.ndarray, start: int, spacing: float
) -> np.ndarray:
    """Return which points lie on ways to tips that are farther from longer ways than spurs of noise reach."""
    leaf = np.ones(len(places), dtype=bool)
    leaf[above[above >= 0]] = False
    kept = np.zeros(len(places), dtype=bool)
    kept[start] = True
    for tip in sorted(np.flatnonzero(leaf & np.isfinite(way)), key=lambda at: -way[at]):
        run, at = [], int(tip)
        while not kept[at]:
            run.append(at)
            at = int(above[at])
        if np.linalg.norm(places[tip] - places[at]) > SPUR[0] * depth[at] + SPUR[1] * spacing:
            kept[run] = True
    return kept


def _branches(
    places: np.ndarray, depth: np.ndarray, way: np.ndarray, above: np.ndarray, kept: np.ndarray, start: int
) -> Branches:
    """Cut the kept points where they branch."""
    points = np.flatnonzero(kept & (np.arange(len(kept)) != start))
    count = np.bincount(above[points], minlength=len(kept))
    rows: list[tuple[int, int, int]] = []
    number = {start: -1}
    for point in sorted(points.tolist(), key=lambda at: way[at]):
        if count[point] == 1:
            continue
        at = int(above[point])
        while at != start and count[at] == 1:
            at = int(above[at])
        number[point] = len(rows)
        rows.append((at, point, number[at]))
    begin, end, parent = np.array(rows).reshape(-1, 3).T
    return Branches(places[begin], places[end], parent, way[end] - way[begin], np.maximum(depth[begin], depth[end]))
