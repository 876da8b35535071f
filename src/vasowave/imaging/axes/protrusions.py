"""Short vessels beside wide ones: what of the lumen sticks out of the tubes of the vessels found so far."""

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from vasowave.imaging.axes.paths import MinimalPaths, end_around
from vasowave.imaging.axes.stretches import free_stretches
from vasowave.imaging.sections import tangents
from vasowave.imaging.tree import Line, Tree

SHELL = 0.7
"""The lumen farther than this outside all tubes is looked at, voxels; within, noise and stairs decide."""
HEIGHT, MISFIT = (1.1, 1.2), (0.35, 0.25)
"""A piece of it is a vessel if it rises so many voxels, and so many radii of its neighbor, from the tubes: the first
number in an image without noise, the second added times its roughness (see `MinimalPaths`)."""
CORNER = 2.0
"""What rises within so many radii of a vessel's end is a corner of that end: opposite corners are 2 radii apart."""


def tips_outside(tree: Tree, ways: MinimalPaths) -> list[int]:
    """Return the tip (a voxel of `ways`) of each vessel that is missing in `tree`.

    A tip that is judged by its distance to one ball of a wide neighbor is easily missed or invented. Here the
    vessels' own radii, carried into their junctions, make tubes; ends go on straight, for a flat end has corners.
    """
    height, radius = height_outside(tree, ways.points, ways.spacing)
    out = np.flatnonzero((height > SHELL) & ~end_around(ways, ways.start))
    shape = ways.voxels.max(axis=0) + 2
    image = np.zeros(shape, dtype=bool)
    image[tuple(ways.voxels[out].T)] = True
    pieces = ndimage.label(image, np.ones((3, 3, 3)))[0][tuple(ways.voxels[out].T)]
    ends = [tree.lines[row] for row in tree.terminals]
    places = np.array([line.points[-1] for line in ends])
    corner = np.array([CORNER * _stub_radius(line) for line in ends])
    least, misfit = (base + added * ways.roughness for base, added in (HEIGHT, MISFIT))
    tips = []
    for piece in range(1, int(pieces.max(initial=0)) + 1):
        inside = out[pieces == piece]
        tip = int(inside[np.argmax(height[inside])])
        is_corner = bool((np.linalg.norm(places - ways.points[tip], axis=1) < corner).any())
        if height[tip] >= max(least, misfit * radius[tip]) and not is_corner:
            tips.append(tip)
    return tips


def height_outside(tree: Tree, points: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return for each point its distance from the nearest tube (negative inside) and that tube's radius, voxels."""
    height, wide = np.full(len(points), np.inf), np.zeros(len(points))
    for row, (line, stretch) in enumerate(zip(tree.lines, free_stretches(tree), strict=True)):
        axis, radius = _calm(line.points), _tube_radius(line, stretch, row in tree.terminals)
        if tree.parent[row] < 0:
            axis, radius = _prolonged(axis[::-1], radius[::-1], spacing)
            axis, radius = axis[::-1], radius[::-1]
        if row in tree.terminals:
            axis, radius = _prolonged(axis, radius, spacing)
        reach = radius.max() + 8 * spacing
        near = np.flatnonzero(((points > axis.min(axis=0) - reach) & (points < axis.max(axis=0) + reach)).all(axis=1))
        fine = np.linspace(0, len(axis) - 1, 2 * len(axis) - 1)
        between = np.stack([np.interp(fine, np.arange(len(axis)), axis[:, k]) for k in range(3)], axis=1)
        distance, nearest = cKDTree(between).query(points[near])
        own = np.interp(fine, np.arange(len(axis)), radius)[nearest]
        nearer = distance - own < height[near]
        height[near[nearer]], wide[near[nearer]] = (distance - own)[nearer], own[nearer]
    return height / spacing, wide / spacing


def _tube_radius(line: Line, stretch: tuple[float, float], is_end: bool) -> np.ndarray:
    """Return the vessel's own radius along `line`: in its junctions, where balls are wider, that beside them.

    A path to the corner of a flat end leaves the axis two radii before it, so there, too, the radius before counts.
    """
    run = line.run
    free = (run > stretch[0]) & (run < stretch[1])
    if free.sum() < 3:
        return np.full(len(line), _stub_radius(line))
    well = free & (run < run[-1] - 2.5 * np.median(line.radius[free])) if is_end else free
    free = well if well.sum() >= 3 else free
    radius = ndimage.percentile_filter(line.radius[free], 35, size=min(int(free.sum()), 15), mode="nearest")
    return np.interp(run, run[free], radius)


def _stub_radius(line: Line) -> float:
    """Return the radius of a vessel that is nowhere free: the largest ball of its second half."""
    return float(line.radius[len(line) // 2 :].max())


def _prolonged(axis: np.ndarray, radius: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the tube with 1.5 radii more at its end."""
    steps = np.arange(1, int(1.5 * radius[-1] / spacing) + 2)[:, None] * spacing
    added = axis[-1] + steps * tangents(axis)[-1]
    return np.concatenate([axis, added]), np.append(radius, np.full(len(steps), radius[-1]))


def _calm(axis: np.ndarray) -> np.ndarray:
    """Return `axis` without the bulge that a vessel still missing beside it makes."""
    straight = np.linspace(axis[0], axis[-1], len(axis))
    return straight + ndimage.gaussian_filter1d(axis - straight, min(3.0, len(axis) / 6), axis=0, mode="mirror")
