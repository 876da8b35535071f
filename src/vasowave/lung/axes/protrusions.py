"""Short vessels beside wide ones: what of the lumen sticks out of the tubes of the vessels found so far."""

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree

from vasowave.lung.axes.paths import MinimalPaths, end_around
from vasowave.lung.sections import tangents
from vasowave.lung.tree import Line, Tree, free_stretches

SHELL = 0.7
"""The lumen farther than this outside all tubes is looked at, voxels; within, noise and stairs decide."""
HEIGHT, MISFIT = (1.1, 1.2), (0.35, 0.25)
"""A piece of it is a vessel if it rises so many voxels, and so many radii of its neighbor, from the tubes: the first
number in an image without noise, the second added times its roughness (see `MinimalPaths`)."""
CORNER = 2.0
"""What rises within so many radii of a vessel's end is a corner of that end: opposite corners are 2 radii apart."""
NEIGHBOR_RADII = 5.0
"""A vessel that is missing bends its neighbor for some radii of that, which lets the other side of it stick out. Of
tips that lie within so many radii only the highest is a vessel at once; with it, the others are judged anew."""
ROUND_EXCESS_VOXELS, MIN_STATIONS = 2.0, 10
"""A round tube is exceeded everywhere by up to so many voxels, times the image's roughness. Where the middle of at
least so many voxels of a vessel exceeds it by more, the vessel is not round, and heights count from its own outline."""
STIFF = 1000.0
"""How much less than a node's place a change of curvature counts: bumps shorter than some 20 voxels are smoothed."""
DENT, BEYOND, DENTED_WEIGHT = 0.85, 75, 0.01
"""No vessel widens away from the heart: where it is narrower than the first share of what lies beyond, by its
percentile, a clot or a bubble dents it. Its tube there is that beside the dent; its axis, which that moves, counts so
much."""


def tips_outside(tree: Tree, paths: MinimalPaths) -> list[int]:
    """Return the tips (voxels of `paths`) of vessels that are missing in `tree`, the highest where several stand close.

    A tip that is judged by its distance to one ball of a wide neighbor is easily missed or invented. Here the
    vessels' own radii, carried into their junctions, make tubes; ends go on straight, for a flat end has corners.
    """
    height, radius = height_outside(tree, paths.points, paths.spacing, ROUND_EXCESS_VOXELS * paths.roughness)
    out = np.flatnonzero((height > SHELL) & ~end_around(paths, paths.start))
    touching = cKDTree(paths.voxels[out]).query_pairs(1.8, output_type="ndarray").T
    graph = coo_array((np.ones(touching.shape[1], dtype=bool), touching), shape=(len(out),) * 2)
    count, pieces = connected_components(graph, directed=False)
    ends = [tree.lines[row] for row in tree.terminals]
    places = np.array([line.points[-1] for line in ends])
    corner = np.array([CORNER * _stub_radius(line) for line in ends])
    min_height, misfit = (base + added * paths.roughness for base, added in (HEIGHT, MISFIT))
    tips = []
    for piece in range(count):
        inside = out[pieces == piece]
        tip = int(inside[np.argmax(height[inside])])
        is_corner = bool((np.linalg.norm(places - paths.points[tip], axis=1) < corner).any())
        if height[tip] >= max(min_height, misfit * radius[tip]) and not is_corner:
            tips.append(tip)
    return _highest(tips, paths.points, height, NEIGHBOR_RADII * radius * paths.spacing)


def _highest(tips: list[int], points: np.ndarray, height: np.ndarray, reach: np.ndarray) -> list[int]:
    """Return the highest of `tips`, and those of the others that lie beyond the reach of all that are returned."""
    highest: list[int] = []
    for tip in sorted(tips, key=lambda candidate: -height[candidate]):
        if all(np.linalg.norm(points[tip] - points[neighbor]) > reach[[tip, neighbor]].max() for neighbor in highest):
            highest.append(tip)
    return highest


def height_outside(tree: Tree, points: np.ndarray, spacing: float, even: float) -> tuple[np.ndarray, np.ndarray]:
    """Return how far each point lies outside the nearest vessel (negative inside), and that vessel's radius, voxels.

    A vessel is its tube and what exceeds this by more than `even` (voxels) along its whole length, as where its
    sections are flat or irregular.
    """
    height, wide = np.full(len(points), np.inf), np.zeros(len(points))
    station, begins = np.zeros(len(points), dtype=int), [0]
    for row, (line, stretch) in enumerate(zip(tree.lines, free_stretches(tree), strict=True)):
        radius, weight = _tube_radius(line, stretch, row in tree.terminals)
        axis = _calm(line.points, weight)
        if tree.parent[row] < 0:
            axis, radius = _prolonged(axis[::-1], radius[::-1], spacing)
            axis, radius = axis[::-1], radius[::-1]
        if row in tree.terminals:
            axis, radius = _prolonged(axis, radius, spacing)
        reach = radius.max() + 8 * spacing
        candidates = np.flatnonzero(
            ((points > axis.min(axis=0) - reach) & (points < axis.max(axis=0) + reach)).all(axis=1)
        )
        fine = np.linspace(0, len(axis) - 1, 2 * len(axis) - 1)
        between = np.stack([np.interp(fine, np.arange(len(axis)), axis[:, k]) for k in range(3)], axis=1)
        distance, nearest = cKDTree(between).query(points[candidates])
        nearest_radius = np.interp(fine, np.arange(len(axis)), radius)[nearest]
        nearer = distance - nearest_radius < height[candidates]
        height[candidates[nearer]], wide[candidates[nearer]] = (
            (distance - nearest_radius)[nearer],
            nearest_radius[nearer],
        )
        station[candidates[nearer]] = begins[-1] + nearest[nearer]
        begins.append(begins[-1] + len(fine))
    height /= spacing
    rings = np.full(begins[-1], -np.inf)
    np.maximum.at(rings, station, height)
    outlines = np.array([_outline(ring) for ring in np.split(rings, begins[1:-1])])
    owner = np.searchsorted(begins, station, side="right") - 1
    return height - np.maximum(outlines - even, 0.0)[owner], wide / spacing


def _outline(ring: np.ndarray) -> float:
    """Return the middle of what exceeds a vessel's tube at its stations, each half a voxel; 0 if they are too few."""
    heights = ring[np.isfinite(ring)]
    return float(np.median(heights)) if len(heights) >= 2 * MIN_STATIONS else 0.0


def _tube_radius(line: Line, stretch: tuple[float, float], is_end: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return the vessel's own radius along `line`: in its junctions, where balls are wider, and in dents that beside
    them; and how much each point says of the axis.

    A path to the corner of a flat end leaves the axis two radii before it, so there, too, the radius before counts.
    """
    run = line.run
    free = (run > stretch[0]) & (run < stretch[1])
    if free.sum() < 3:
        return np.full(len(line), _stub_radius(line)), np.ones(len(line))
    well = free & (run < run[-1] - 2.5 * np.median(line.radius[free])) if is_end else free
    free = well if well.sum() >= 3 else free
    count = int(free.sum())
    beyond = ndimage.percentile_filter(line.radius[free], BEYOND, size=count, mode="reflect", origin=-(count // 2))
    is_full = line.radius[free] >= DENT * beyond
    radius = ndimage.percentile_filter(line.radius[free][is_full], 35, size=min(int(is_full.sum()), 15), mode="nearest")
    weight = np.where(np.interp(run, run[free], is_full) < 1, DENTED_WEIGHT, 1.0)
    return np.interp(run, run[free][is_full], radius), weight


def _stub_radius(line: Line) -> float:
    """Return the radius of a vessel that is nowhere free: the largest ball of its second half."""
    return float(line.radius[len(line) // 2 :].max())


def _prolonged(axis: np.ndarray, radius: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the tube with 1.5 radii more at its end."""
    steps = np.arange(1, int(1.5 * radius[-1] / spacing) + 2)[:, None] * spacing
    added = axis[-1] + steps * tangents(axis)[-1]
    return np.concatenate([axis, added]), np.append(radius, np.full(len(steps), radius[-1]))


def _calm(axis: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return `axis` without the bulge that a vessel still missing beside it makes; arcs stay as they are."""
    if len(axis) < 4:
        return axis
    bends = diags_array([-1.0, 3.0, -3.0, 1.0], offsets=(0, 1, 2, 3), shape=(len(axis) - 3, len(axis)))
    matrix = (diags_array(weight) + STIFF * bends.T @ bends).tocsc()
    return np.asarray(spsolve(matrix, weight[:, None] * axis))
