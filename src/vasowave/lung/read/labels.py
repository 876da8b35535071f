"""Masks drawn or edited by hand in ITK-SNAP or 3D Slicer, as labels checked against their image."""

import warnings
from pathlib import Path

import numpy as np
from scipy import ndimage

from vasowave.base.errors import InputError, VasowaveWarning
from vasowave.base.findings import found_in
from vasowave.lung.places import VoxelSize
from vasowave.lung.read.files import read_volume
from vasowave.lung.read.findings import INVERTED
from vasowave.lung.read.volume import Volume

LUMEN, ROOT = 1, 2
"""Labels of a mask: the lumen, a spot in it where the blood enters; every higher label marks one outlet."""


def read_labels(path: str | Path, image: Volume, spacing: VoxelSize | None = None) -> np.ndarray:
    """Return the labels in a mask file on the grid of `image`, int array, shape (z, y, x).

    Parameters
    ----------
    path : path
        NRRD, NIfTI or MetaImage as ITK-SNAP and 3D Slicer save it, or a TIFF stack.
    image : Volume
        The volume the mask was drawn on, as read (not resampled).
    spacing : float or sequence of 3 floats, optional
        Voxel size, cm, where it replaced the image file's: then the mask file's own is not compared.

    Raises
    ------
    InputError
        Unreadable or empty file, labels that are not whole numbers, another shape, spacing, origin or
        direction than the image.
    """
    with warnings.catch_warnings(record=True) as caught_warnings:
        warnings.simplefilter("always", VasowaveWarning)
        mask = read_volume(path, spacing)
    if any(finding.code == INVERTED(source="").code for finding in found_in(caught_warnings)):
        raise InputError(f"{path}: a mask whose lowest label is white; save it so that 0 is black")
    if mask.grey.shape != image.grey.shape:
        raise InputError(
            f"{path}: the mask has {_size(mask)} voxels, the image {_size(image)}; save it with the image's geometry"
        )
    if spacing is None:
        if not np.allclose(mask.spacing, image.spacing, rtol=1e-3):
            raise InputError(
                f"{path}: the mask's voxels measure {in_mm(mask.spacing)} mm (x, y, z), the image's "
                f"{in_mm(image.spacing)}; save it with the image's geometry"
            )
        if not np.allclose(mask.origin, image.origin, atol=0.5 * float(image.spacing.min())):
            raise InputError(
                f"{path}: the mask begins at {in_mm(mask.origin)} mm (x, y, z), the image at {in_mm(image.origin)}; "
                "save it with the image's geometry"
            )
    if not np.allclose(mask.axes, image.axes, atol=0.5 / max(image.grey.shape)):
        raise InputError(f"{path}: the mask is turned against the image; save it with the image's geometry")
    labels = np.round(mask.grey).astype(np.int32)
    if not np.array_equal(labels, mask.grey) or labels.min() < 0:
        raise InputError(f"{path}: values that are not whole numbers from 0 on; this is an image, not a mask")
    return labels


def on_grid_of(labels: np.ndarray, image: Volume, volume: Volume) -> np.ndarray:
    """Return `labels`, on the grid of `image`, at the voxels of the resampled `volume`, by the nearest voxel."""
    for axis, count in enumerate(volume.grey.shape):
        positions = volume.origin[axis] + np.arange(count) * volume.spacing[axis]
        nearest = np.round((positions - image.origin[axis]) / image.spacing[axis]).astype(int)
        labels = np.take(labels, np.clip(nearest, 0, labels.shape[axis] - 1), axis=axis)
    return labels


def marks(labels: np.ndarray, volume: Volume) -> dict[int, np.ndarray]:
    """Return the center of every label above LUMEN, z, y, x, cm: the root (label ROOT) and the outlets."""
    numbers = [int(label) for label in np.unique(labels) if label > LUMEN]
    centers = ndimage.center_of_mass(labels > LUMEN, labels, numbers) if numbers else []
    return {
        label: np.array(center) * volume.spacing + volume.origin for label, center in zip(numbers, centers, strict=True)
    }


def _size(volume: Volume) -> str:
    return " × ".join(str(count) for count in volume.grey.shape[::-1])


def in_mm(zyx: np.ndarray) -> str:
    """Return z, y, x (cm) as x, y, z in mm, for messages."""
    return ", ".join(f"{10 * value:.4g}" for value in zyx[::-1])
