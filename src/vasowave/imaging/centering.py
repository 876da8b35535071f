"""Vessel axes to a fraction of a voxel: the center of the grey levels of every cross-section."""

import numpy as np
from scipy.ndimage import gaussian_filter1d

from vasowave.imaging.sections import STEP, across, disc, sampled, tangents
from vasowave.imaging.segmentation import Segmentation
from vasowave.imaging.tree import Tree, clear_stretches, distance_along, with_inscribed_radii

ROUNDS = 2
"""The second round sees sections across the axis that the first one found."""

LARGEST = 0.6
"""A larger move is not an axis made precise but a neighbor in the section: the point stays. Voxels."""


def centered(tree: Tree, lumen: Segmentation, surface: np.ndarray) -> Tree:
    """Return `tree` (without stairs) on the vessels' axes, inscribed radii measured anew.

    Where a vessel is free of junctions and clear of its sisters, its points move to the center of what is brighter
    than the threshold in their section; within junctions the axis leads straight on to the junction, which keeps its
    place.

    Parameters
    ----------
    tree : Tree
    lumen : Segmentation
    surface : float array, shape (corner, 3)
        Points of the lumen's surface, cm.
    """
    for _ in range(ROUNDS):
        lines = [
            np.column_stack([_moved(line, stretch, lumen), line[:, 3]])
            for line, stretch in zip(tree.lines, clear_stretches(tree), strict=True)
        ]
        tree = without_stairs(Tree(tuple(lines), tree.parent), surface, lumen.spacing, 1.5)
    return tree


def without_stairs(tree: Tree, surface: np.ndarray, spacing: float, width: float = 3.0) -> Tree:
    """Return `tree` smoothed over `width` points at equal steps of about a voxel, inscribed radii measured anew."""
    return with_inscribed_radii([_smoothed(line[:, :3], spacing, width) for line in tree.lines], tree.parent, surface)


def _smoothed(line: np.ndarray, spacing: float, width: float) -> np.ndarray:
    """Return `line` at equal steps of about a voxel, without stairs; its ends stay."""
    run = distance_along(line)
    at = np.linspace(0, run[-1], max(round(run[-1] / spacing), 3) + 1)
    line = np.stack([np.interp(at, run, line[:, k]) for k in range(3)], axis=1)
    straight = np.linspace(line[0], line[-1], len(line))
    middle = straight + gaussian_filter1d(line - straight, min(width, len(line) / 6), axis=0, mode="mirror")
    middle[[0, -1]] = line[[0, -1]]
    return middle


def _moved(line: np.ndarray, stretch: tuple[float, float], lumen: Segmentation) -> np.ndarray:
    """Return the positions of `line`, those in the free `stretch` at the center of their sections."""
    run = distance_along(line)
    free = np.flatnonzero((run > stretch[0]) & (run < stretch[1]))
    if len(free) < 2:
        return line[:, :3]
    radius = float(np.median(line[free, 3]))
    u, v = across(tangents(line)[free])
    grid = disc(radius + 1.5 * lumen.spacing, STEP * lumen.spacing)
    places = line[free, None, :3] + grid[:, :1] * u[:, None] + grid[:, 1:] * v[:, None]
    weight = np.maximum(sampled(lumen.grey, places, lumen.origin, lumen.spacing) - lumen.threshold, 0)
    aside = (weight @ grid) / np.maximum(weight.sum(axis=1, keepdims=True), 1e-9)
    aside[np.linalg.norm(aside, axis=1) > LARGEST * lumen.spacing] = 0.0
    moved = line[free, :3] + aside[:, :1] * u + aside[:, 1:] * v
    # Before and after the free stretch the axis leads straight on: sections there see the other vessels.
    before = np.linspace(line[0, :3], moved[0], free[0] + 1)[:-1]
    after = np.linspace(moved[-1], line[-1, :3], len(line) - free[-1])[1:]
    return np.concatenate([before, moved, after])
