"""Center paths of a lumen: minimal paths from the root that keep to the middle (the TEASAR idea)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from vasowave.base.errors import InputError
from vasowave.lung.axes.skeleton import Skeleton
from vasowave.lung.lumen.segmentation import Segmentation
from vasowave.lung.lumen.surface import surface_points
from vasowave.lung.places import written
from vasowave.lung.tree import Line

BALL, MARGIN = 1.5, 2.5
"""A tip counts as long if it protrudes from all balls of BALL inscribed radii + MARGIN voxels around longer paths."""

LONG = 2.5
"""Twigs that are shorter, radii of the path that they leave, may be horns of the lumen beside a clot: `tips_outside`
judges them."""

END = 2.0
"""The end of a vessel reaches so many radii from its tip."""

MAX_FILL, MAX_FLAT_ENDS, FLAT_REACH = 30.0, 12, 4.0
"""Within FLAT_REACH radii r of a vessel's end lie 4 π r³ of lumen, at the edge of a plate four times as much: more than
MAX_FILL r³ at more than MAX_FLAT_ENDS ends, and at a third of all, are a holder's, which no tubes are fitted to."""

STEEPNESS = 8
"""A path costs its length / depth**STEEPNESS: with 2 it still cuts the corners of wide vessels."""


@dataclass(frozen=True, eq=False)
class MinimalPaths:
    """For every voxel of a lumen the way to the root that keeps to the middle.

    Attributes
    ----------
    voxels : int array, shape (voxel, 3)
        Voxels of the lumen within its crop.
    points : float array, shape (voxel, 3)
        Their positions, z, y, x, cm.
    depth : float array, shape (voxel,)
        Distance to the surface, voxels.
    travelled : float array, shape (voxel,)
        Distance to the root through the lumen, voxels; -1 where it was not reached.
    above : int array, shape (voxel,)
        The next voxel toward the root.
    start : int
        The root's voxel.
    surface : float array, shape (corner, 3)
        Points of the lumen's surface, cm.
    spacing : float
        Voxel size, cm.
    roughness : float
        Noise over the contrast between wall and background: how much noise bends the surface.
    """

    voxels: np.ndarray
    points: np.ndarray
    depth: np.ndarray
    travelled: np.ndarray
    above: np.ndarray
    start: int
    surface: np.ndarray
    spacing: float
    roughness: float


def minimal_paths(lumen: Segmentation, root: np.ndarray) -> MinimalPaths:
    """Return the minimal paths from everywhere in `lumen` to `root`.

    Parameters
    ----------
    lumen : Segmentation
    root : float array, shape (3,)
        A point in or at the lumen where the blood enters (z, y, x, cm).

    Raises
    ------
    InputError
        A root farther than 5 voxels from the lumen.
    """
    surface = surface_points(lumen)
    voxels = np.argwhere(lumen.mask)
    points = voxels * lumen.spacing + lumen.origin
    depth = cKDTree(surface).query(points)[0] / lumen.spacing
    graph, lengths = _neighbors(lumen.mask, depth)
    start = int(_nearest(points, lumen.spacing, np.atleast_2d(root), "root")[0])
    travelled = dijkstra(lengths, indices=start)
    _, above = dijkstra(graph, indices=start, return_predecessors=True)
    travelled[~np.isfinite(travelled)] = -1.0
    return MinimalPaths(voxels, points, depth, travelled, above, start, surface, lumen.spacing, lumen.roughness)


def paths_to(paths: MinimalPaths, tips: Sequence[int]) -> Skeleton:
    """Return the union of the minimal paths to the voxels `tips`."""
    rows = np.flatnonzero(_walk(paths.above, tips, paths.start))
    new = np.full(len(paths.points), -1)
    new[rows] = np.arange(len(rows))
    up = np.where(rows == paths.start, -1, new[np.maximum(paths.above[rows], 0)])
    return Skeleton(Line(paths.points[rows], paths.depth[rows] * paths.spacing), up)


def _neighbors(mask: np.ndarray, depth: np.ndarray) -> tuple[csr_array, csr_array]:
    """Return the 26-neighbor graph of the lumen twice: cost that favors the middle, and plain length."""
    from skimage.graph import pixel_graph  # the surface was of it, too

    lengths, _ = pixel_graph(mask, connectivity=3, sparse_type="array")
    held = np.maximum(depth, 0.2)
    middle = 0.5 * (np.repeat(held, np.diff(lengths.indptr)) + held[lengths.indices])
    return csr_array((lengths.data / middle**STEEPNESS, lengths.indices, lengths.indptr), lengths.shape), lengths


def _nearest(points: np.ndarray, spacing: float, places: np.ndarray, role: str) -> np.ndarray:
    """Return the voxel nearest to each of `places`; all that are too far are named at once."""
    distance, nearest = cKDTree(points).query(places)
    lost = [
        f"{role} {written(place)} cm (x,y,z) was not reached: {gap:.0f} voxels from the lumen"
        for place, gap in zip(places, distance / spacing, strict=True)
        if gap > 5
    ]
    if lost:
        raise InputError("; ".join(lost) + "; move it, or lower the threshold")
    return np.asarray(nearest)


def outlet_tips(paths: MinimalPaths, outlets: np.ndarray) -> list[int]:
    """Return the voxel of each outlet.

    Raises
    ------
    InputError
        An outlet farther than 5 voxels from the lumen, or one on the way to another; each is named.
    """
    outlets = np.atleast_2d(outlets)
    tips = [int(tip) for tip in _nearest(paths.points, paths.spacing, outlets, "outlet")]
    inner = _walk(paths.above, [int(paths.above[tip]) for tip in tips if tip != paths.start], paths.start)
    lost = [
        f"outlet {written(place)} cm (x,y,z) was not reached as an end: the vessel goes on to another outlet"
        for number, (place, tip) in enumerate(zip(outlets, tips, strict=True))
        if inner[tip] or tip in tips[:number]
    ]
    if lost:
        raise InputError("; ".join(lost) + "; remove it, or move it to the end of a vessel of its own")
    return tips


def _walk(above: np.ndarray, tips: Sequence[int], start: int) -> np.ndarray:
    """Return which voxels lie on the paths from `tips` to `start`."""
    on_path = np.zeros(len(above), dtype=bool)
    on_path[start] = True
    for tip in tips:
        while not on_path[tip]:
            on_path[tip] = True
            tip = above[tip]
    return on_path


def end_around(paths: MinimalPaths, voxel: int) -> np.ndarray:
    """Return which voxels belong to the end of a vessel at `voxel`, bool, shape (voxel,): no other vessel ends there.

    A tip is the farthest corner of an end, the opposite one is two radii away; a root is given by eye.
    """
    distance = np.linalg.norm(paths.voxels - paths.voxels[voxel], axis=1)
    wide = paths.depth[distance <= 1.5 * paths.depth].max(initial=paths.depth[voxel])
    return np.asarray(distance < END * wide)


def require_slender(paths: MinimalPaths, tips: Sequence[int]) -> None:
    """Raise `InputError` if most of `tips` are no ends of vessels, but edges of plates and blocks."""
    tree, fills = cKDTree(paths.voxels), []
    for tip in tips if len(tips) > MAX_FLAT_ENDS else ():
        distance = np.linalg.norm(paths.voxels - paths.voxels[tip], axis=1)
        radius = max(paths.depth[distance <= BALL * paths.depth].max(initial=0.0), BALL)
        count = tree.query_ball_point(paths.voxels[tip], FLAT_REACH * radius, return_length=True)
        fills.append(float(count) / radius**3)
    flat = int(np.sum(np.array(fills) > MAX_FILL))
    if flat > max(MAX_FLAT_ENDS, len(tips) / 3):
        raise InputError(
            f"at {flat} of {len(tips)} ends the lumen is as wide as a plate or a block: a holder or other tissue hangs "
            "together with the vessels, or is taken for them, or stubs stand side by side as in a comb; give a region "
            "or a mask without it, a higher threshold, or for stubs the outlets"
        )


def long_tips(paths: MinimalPaths) -> list[int]:
    """Return the tips that protrude from the inscribed balls of all longer paths, the farthest first."""
    tree = cKDTree(paths.voxels)
    free = (paths.travelled >= 0) & ~end_around(paths, paths.start)
    visited = np.zeros(len(free), dtype=bool)
    visited[paths.start] = True
    tips = []
    for tip in np.argsort(paths.travelled)[::-1]:
        if not free[tip]:
            continue
        tips.append(int(tip))
        path = []
        while not visited[tip]:
            visited[tip] = True
            path.append(tip)
            tip = paths.above[tip]
        for neighbor in tree.query_ball_point(paths.voxels[path], BALL * paths.depth[path] + MARGIN):
            free[neighbor] = False
        free &= ~end_around(paths, tips[-1])
    return tips


def without_horns(paths: MinimalPaths, tips: Sequence[int]) -> list[int]:
    """Return those of `tips`, the farthest first, whose twigs go on for LONG radii of where they leave longer ones."""
    on_path = np.zeros(len(paths.above), dtype=bool)
    on_path[paths.start] = True
    long: list[int] = []
    for tip in tips:
        twig, point = [], tip
        while not on_path[point]:
            twig.append(point)
            point = int(paths.above[point])
        if not long or paths.travelled[tip] - paths.travelled[point] >= LONG * paths.depth[point]:
            on_path[twig] = True
            long.append(tip)
    return long
