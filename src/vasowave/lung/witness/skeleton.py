"""The second witness: the lumen thinned to a skeleton by another library, which knows nothing of paths and tubes."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from vasowave.base.errors import EXTRAS, InputError
from vasowave.lung.lumen.segmentation import Segmentation

SPUR = 1.0, 4.0
"""A branch of the skeleton is a vessel if it reaches so many radii + voxels beyond the middle of its junction."""


@dataclass(frozen=True, eq=False)
class Thinned:
    """The lumen's skeleton and the way from each of its points to the root.

    Attributes
    ----------
    places : float array, shape (point, 3)
        z, y, x, cm.
    depth, way : float array, shape (point,)
        Distance to the wall, and along the skeleton to the root, cm; infinite where it does not lead there.
    above : int array, shape (point,)
        The next point toward the root; negative at the root.
    start : int
        The root's point.
    spacing : float
        Voxel size, cm.
    """

    places: np.ndarray
    depth: np.ndarray
    way: np.ndarray
    above: np.ndarray
    start: int
    spacing: float


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


def thinned(lumen: Segmentation, root: np.ndarray, surface: np.ndarray) -> Thinned:
    """Return the lumen's skeleton (Lee's thinning), seen from `root` (z, y, x, cm).

    Parameters
    ----------
    lumen : Segmentation
    root : float array, shape (3,)
    surface : float array, shape (corner, 3)
        Points of the lumen's surface, cm.

    Raises
    ------
    InputError
        Without the extra 'imaging'.
    """
    points, pairs = skeleton_voxels(lumen, "the second witness needs")
    places = points * lumen.spacing + lumen.origin
    depth = cKDTree(surface).query(places)[0]
    length = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1) * lumen.spacing
    graph = coo_array((length, pairs.T), shape=(len(points),) * 2).tocsr()
    start = int(np.argmin(np.linalg.norm(places - root, axis=1)))
    root_distance, above = dijkstra(graph, directed=False, indices=start, return_predecessors=True)
    above[~np.isfinite(root_distance)] = start
    return Thinned(places, depth, root_distance, above, start, lumen.spacing)


def skeleton_voxels(lumen: Segmentation, subject: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the voxels of the lumen's skeleton (Lee's thinning), shape (voxel, 3), and the pairs that touch.

    Without the extra 'imaging' an `InputError` says that the `subject` needs it.
    """
    try:
        from skimage.morphology import skeletonize
    except ImportError:
        raise InputError(f"{subject} the extra 'imaging': {EXTRAS}") from None
    points = np.argwhere(skeletonize(np.pad(lumen.mask, 1))) - 1
    return points, cKDTree(points).query_pairs(1.8, output_type="ndarray")


def skeleton_branches(skeleton: Thinned, ends: np.ndarray | None = None) -> Branches:
    """Return the branches of a skeleton: those to its tips, without spurs, or to the points nearest to given `ends`.

    Ends, z, y, x, cm, shape (end, 3), are where vessels end by what the user gave, outlets or edits, be it inside a
    vessel that goes on.
    """
    on_branch = np.zeros(len(skeleton.places), dtype=bool)
    on_branch[skeleton.start] = True
    if ends is None:
        _keep_vessels(skeleton, on_branch)
    else:
        reached = np.flatnonzero(np.isfinite(skeleton.way))
        for tip in reached[cKDTree(skeleton.places[reached]).query(ends)[1]].tolist():
            on_branch[_run(skeleton, on_branch, tip)] = True
    return _branches(skeleton, on_branch)


def _run(skeleton: Thinned, on_branch: np.ndarray, tip: int) -> list[int]:
    """Return the points from `tip` to the first that is kept, without that."""
    run, point = [], tip
    while not on_branch[point]:
        run.append(point)
        point = int(skeleton.above[point])
    return run


def _keep_vessels(skeleton: Thinned, on_branch: np.ndarray) -> None:
    """Mark the ways to tips that are farther from longer ways than spurs of noise reach."""
    leaf = np.ones(len(on_branch), dtype=bool)
    leaf[skeleton.above[skeleton.above >= 0]] = False
    places, depth = skeleton.places, skeleton.depth
    for tip in sorted(
        np.flatnonzero(leaf & np.isfinite(skeleton.way)).tolist(), key=lambda point: -skeleton.way[point]
    ):
        run = _run(skeleton, on_branch, tip)
        point = int(skeleton.above[run[-1]]) if run else tip
        if np.linalg.norm(places[tip] - places[point]) > SPUR[0] * depth[point] + SPUR[1] * skeleton.spacing:
            on_branch[run] = True


def _branches(skeleton: Thinned, on_branch: np.ndarray) -> Branches:
    """Cut the kept points where they branch."""
    root_distance, above, start = skeleton.way, skeleton.above, skeleton.start
    points = np.flatnonzero(on_branch & (np.arange(len(on_branch)) != start))
    count = np.bincount(above[points], minlength=len(on_branch))
    rows: list[tuple[int, int, int]] = []
    number = {start: -1}
    for point in sorted(points.tolist(), key=lambda index: root_distance[index]):
        if count[point] == 1:
            continue
        ancestor = int(above[point])
        while ancestor != start and count[ancestor] == 1:
            ancestor = int(above[ancestor])
        number[point] = len(rows)
        rows.append((ancestor, point, number[ancestor]))
    begin, end, parent = np.array(rows).reshape(-1, 3).T
    radius = np.maximum(skeleton.depth[begin], skeleton.depth[end])
    return Branches(
        skeleton.places[begin], skeleton.places[end], parent, root_distance[end] - root_distance[begin], radius
    )
