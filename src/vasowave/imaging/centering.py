"""Vessel axes to a fraction of a voxel: the center of the grey levels of every cross-section."""

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from vasowave.imaging.sections import STEP, across, disc, sampled, tangents
from vasowave.imaging.segmentation import Segmentation
from vasowave.imaging.tree import Tree, distance_along, free_stretches

ROUNDS = 2
"""The second round sees sections across the axis that the first one found."""

LARGEST = 0.6
"""A larger move is not an axis made precise but a neighbor in the section: the point stays. Voxels."""


def centered(tree: Tree, lumen: Segmentation, surface: np.ndarray) -> Tree:
    """Return `tree` on the vessels' axes, points about a voxel apart, inscribed radii measured anew.

    Where a vessel is free of junctions, its points move to the center of what is brighter than the threshold in
    their section; within junctions the axis leads straight on to the junction, which keeps its place.

    Parameters
    ----------
    tree : Tree
        Axes that follow voxels.
    lumen : Segmentation
    surface : float array, shape (corner, 3)
        Points of the lumen's surface, cm.
    """
    index = cKDTree(surface)
    lines = [_smoothed(line[:, :3], lumen.spacing, 3.0) for line in tree.lines]
    for _ in range(ROUNDS):
        measured = [np.column_stack([line, index.query(line)[0]]) for line in lines]
        free = free_stretches(Tree(tuple(measured), tree.parent))
        lines = [
            _smoothed(_moved(line, stretch, lumen), lumen.spacing, 1.5)
            for line, stretch in zip(measured, free, strict=True)
        ]
    return Tree(tuple(np.column_stack([line, index.query(line)[0]]) for line in lines), tree.parent)


def _smoothed(line: np.ndarray, spacing: float, width: float) -> np.ndarray:
    """Return `line` at equal steps of about a voxel, without stairs; its ends stay."""
    run = distance_along(line)
    at = np.linspace(0, run[-1], max(int(round(run[-1] / spacing)), 3) + 1)
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
    return np.concatenate([line[:1, :3], moved, line[-1:, :3]])
