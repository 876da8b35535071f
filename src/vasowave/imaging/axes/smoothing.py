"""Voxel paths without their stairs."""

import numpy as np
from scipy.ndimage import gaussian_filter1d

from vasowave.imaging.tree import Line, Tree, with_inscribed_radii


def without_stairs(tree: Tree, surface: np.ndarray, spacing: float) -> Tree:
    """Return `tree` smoothed over three points at equal steps of about a voxel, inscribed radii measured anew."""
    return with_inscribed_radii([_smoothed(line, spacing) for line in tree.lines], tree.parent, surface)


def _smoothed(line: Line, spacing: float) -> np.ndarray:
    """Return the points of `line` at equal steps of about a voxel, without stairs; its ends stay."""
    at = np.linspace(0, line.length, max(round(line.length / spacing), 3) + 1)
    points = np.stack([np.interp(at, line.run, line.points[:, k]) for k in range(3)], axis=1)
    straight = np.linspace(points[0], points[-1], len(points))
    middle = straight + gaussian_filter1d(points - straight, min(3.0, len(points) / 6), axis=0, mode="mirror")
    middle[[0, -1]] = points[[0, -1]]
    return middle
