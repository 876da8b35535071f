"""Voxel paths without their stairs."""

import numpy as np
from scipy.ndimage import gaussian_filter1d

from vasowave.imaging.tree import Tree, distance_along, with_inscribed_radii


def without_stairs(tree: Tree, surface: np.ndarray, spacing: float) -> Tree:
    """Return `tree` smoothed over three points at equal steps of about a voxel, inscribed radii measured anew."""
    return with_inscribed_radii([_smoothed(line[:, :3], spacing) for line in tree.lines], tree.parent, surface)


def _smoothed(line: np.ndarray, spacing: float) -> np.ndarray:
    """Return `line` at equal steps of about a voxel, without stairs; its ends stay."""
    run = distance_along(line)
    at = np.linspace(0, run[-1], max(round(run[-1] / spacing), 3) + 1)
    line = np.stack([np.interp(at, run, line[:, k]) for k in range(3)], axis=1)
    straight = np.linspace(line[0], line[-1], len(line))
    middle = straight + gaussian_filter1d(line - straight, min(3.0, len(line) / 6), axis=0, mode="mirror")
    middle[[0, -1]] = line[[0, -1]]
    return middle
