"""How far the lumen's surface lies from the tubes of the answer."""

import numpy as np
from scipy.spatial import cKDTree

from vasowave.imaging.axes.stretches import free_stretches
from vasowave.imaging.tree import Tree


def surface_misfit(tree: Tree, radius: np.ndarray, surface: np.ndarray, spacing: float) -> np.ndarray:
    """Return how far half of the surface around each vessel lies from its tube at least, as a share of the radius.

    A round lumen on its axis has a misfit of noise alone; one that is not round, is shared with a vessel that the
    tree lacks, or lies beside its axis has a larger one. Taken outside junctions and ends.

    Parameters
    ----------
    tree : Tree
    radius : float array, shape (vessel,)
        cm.
    surface : float array, shape (corner, 3)
        Points of the lumen's surface, cm.
    spacing : float
        Voxel size, cm.

    Returns
    -------
    float array, shape (vessel,)
        NaN for vessels without a free stretch.
    """
    distance, nearest = cKDTree(tree.line.points).query(surface)
    owner = tree.owner[nearest]
    run = np.concatenate([line.run for line in tree.lines])[nearest]
    # What a tube's own taper explains is no misfit: the gap is taken from the mean along it.
    misfit = np.full(len(tree), np.nan)
    for row, (begin, end) in enumerate(free_stretches(tree)):
        own = (owner == row) & (run > begin) & (run < end) & (distance < 3 * radius[row] + 3 * spacing)
        if own.sum() < 30:
            continue
        bins = (run[own] / max(radius[row], spacing)).astype(int)
        mean = np.bincount(bins, distance[own]) / np.maximum(np.bincount(bins), 1)
        misfit[row] = float(np.median(np.abs(distance[own] - mean[bins]))) / radius[row]
    return misfit
