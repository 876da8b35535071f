"""The lumen for other programs: its mask as an image, its smoothed surface as triangles."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.sparse import coo_array, diags_array

from vasowave.lung.lumen.segmentation import Segmentation
from vasowave.lung.read.itk import write_image
from vasowave.lung.read.volume import Volume

_SHRINK, _SWELL = 0.5, -0.53  # Taubin's pair: smooths without losing volume


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed surface of triangles.

    Attributes
    ----------
    points : float array, shape (point, 3)
        z, y, x, cm.
    triangles : int array, shape (triangle, 3)
        Rows of `points`; counter-clockwise seen from outside.
    """

    points: np.ndarray
    triangles: np.ndarray


def surface_points(lumen: Segmentation) -> np.ndarray:
    """Return corners of the iso-surface of the grey levels (not of the mask), z, y, x, cm, shape (corner, 3)."""
    return (lumen.iso_surface[0] - 1) * lumen.spacing + lumen.origin


def smooth_surface(lumen: Segmentation, rounds: int = 10) -> Surface:
    """Return the iso-surface of the lumen's grey levels, smoothed by `rounds` of Taubin's two steps.

    Raises
    ------
    InputError
        Without the extra 'imaging'.
    """
    corners, triangles = lumen.iso_surface
    mean = _neighbor_mean(triangles, len(corners))
    for _ in range(rounds):
        for weight in (_SHRINK, _SWELL):
            corners = corners + weight * (mean @ corners - corners)
    return Surface((corners - 1) * lumen.spacing + lumen.origin, triangles[:, ::-1])


def write_mask(lumen: Segmentation, image: Volume, path: str | Path) -> None:
    """Write the lumen's voxels as an image of 0 and 1 on the grid of `image` (.nrrd, .nii.gz, .mha), in mm.

    That is the volume as read: a lumen found on a resampled grid goes back to the nearest voxels.
    """
    write_image(full_mask(lumen, image).astype(np.uint8), image, path)


def full_mask(lumen: Segmentation, image: Volume) -> np.ndarray:
    """Return which voxels of `image` lie in the lumen, bool, shape (z, y, x)."""
    inside = np.zeros(image.grey.shape, dtype=bool)
    places = []
    for axis, count in enumerate(image.grey.shape):
        positions = image.origin[axis] + np.arange(count) * image.spacing[axis]
        voxels = np.round((positions - lumen.origin[axis]) / lumen.spacing).astype(int)
        rows = np.flatnonzero((voxels >= 0) & (voxels < lumen.mask.shape[axis]))
        places.append((rows, voxels[rows]))
    inside[np.ix_(*(rows for rows, _ in places))] = lumen.mask[np.ix_(*(voxels for _, voxels in places))]
    return inside


def _neighbor_mean(triangles: np.ndarray, count: int) -> coo_array:
    """Return the matrix that replaces each point by the mean of its neighbors."""
    a, b = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).T
    touching = coo_array((np.ones(2 * len(a)), (np.r_[a, b], np.r_[b, a])), shape=(count, count)).tocsr()
    touching.data[:] = 1.0
    return diags_array(1.0 / np.maximum(touching.sum(axis=1), 1.0)) @ touching
