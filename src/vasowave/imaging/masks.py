"""Masks drawn or edited by hand in ITK-SNAP or 3D Slicer: read, checked against the image, used as lumen or region."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import ndimage

from vasowave.errors import InputError
from vasowave.imaging.extraction import Segmenter
from vasowave.imaging.segmentation import Segmentation, connected_lumen, segment, smoothed
from vasowave.imaging.volume import Volume, read_volume

LUMEN, ROOT = 1, 2
"""Labels of a mask: the lumen, a spot in it where the blood enters; every higher label marks one outlet."""


def read_labels(path: str | Path, image: Volume, spacing: float | None = None) -> np.ndarray:
    """Return the labels in a mask file on the grid of `image`, int array, shape (z, y, x).

    Parameters
    ----------
    path : path
        NRRD, NIfTI or MetaImage as ITK-SNAP and 3D Slicer save it, or a TIFF stack.
    image : Volume
        The volume the mask was drawn on, as read (not resampled).
    spacing : float, optional
        Voxel size, cm, where it replaced the image file's: then the mask file's own is not compared.

    Raises
    ------
    InputError
        Unreadable or empty file, labels that are not whole numbers, another shape, spacing or origin than the image.
    """
    mask = read_volume(path, spacing if spacing or Path(path).suffix.lower() in (".tif", ".tiff") else None)
    if mask.grey.shape != image.grey.shape:
        raise InputError(
            f"{path}: the mask has {_size(mask)} voxels, the image {_size(image)}; save it with the image's geometry"
        )
    if spacing is None:
        if not np.allclose(mask.spacing, image.spacing, rtol=1e-3):
            raise InputError(
                f"{path}: the mask's voxels measure {_mm(mask.spacing)} mm (x, y, z), the image's "
                f"{_mm(image.spacing)}; save it with the image's geometry"
            )
        if not np.allclose(mask.origin, image.origin, atol=0.5 * float(image.spacing.min())):
            raise InputError(
                f"{path}: the mask begins at {_mm(mask.origin)} mm (x, y, z), the image at {_mm(image.origin)}; "
                "save it with the image's geometry"
            )
    labels = np.round(mask.grey).astype(np.int32)
    if not np.array_equal(labels, mask.grey) or labels.min() < 0:
        raise InputError(f"{path}: values that are not whole numbers from 0 on; this is an image, not a mask")
    return labels


def on_grid_of(labels: np.ndarray, volume: Volume) -> np.ndarray:
    """Return `labels` on the grid of the resampled `volume` that spans the same space, by the nearest voxel."""
    for axis, (old, new) in enumerate(zip(labels.shape, volume.grey.shape, strict=True)):
        if old != new:
            labels = np.take(labels, np.round(np.linspace(0, old - 1, new)).astype(int), axis=axis)
    return labels


def marks(labels: np.ndarray, volume: Volume) -> dict[int, np.ndarray]:
    """Return the center of every label above LUMEN, z, y, x, cm: the root (label ROOT) and the outlets."""
    numbers = [int(label) for label in np.unique(labels) if label > LUMEN]
    centers = ndimage.center_of_mass(labels > LUMEN, labels, numbers) if numbers else []
    return {
        label: np.array(center) * volume.spacing + volume.origin for label, center in zip(numbers, centers, strict=True)
    }


def box_region(volume: Volume, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return which voxels of `volume` lie between the corners `low` and `high` (z, y, x, cm), bool, shape (z, y, x).

    Raises
    ------
    InputError
        If no voxel does.
    """
    inside = np.ones(volume.grey.shape, dtype=bool)
    for axis, count in enumerate(volume.grey.shape):
        at = volume.origin[axis] + np.arange(count) * volume.spacing[axis]
        a, b = sorted((low[axis], high[axis]))
        shape = [1, 1, 1]
        shape[axis] = count
        inside &= ((at >= a) & (at <= b)).reshape(shape)
    if not inside.any():
        last = volume.origin + (np.array(volume.grey.shape) - 1) * volume.spacing
        raise InputError(f"the region holds no voxel; the image spans {_mm(volume.origin)} to {_mm(last)} mm (x, y, z)")
    return inside


@dataclass(frozen=True, eq=False)
class Within:
    """A segmenter that sees only the voxels in `region` (bool, on the grid of `grid`)."""

    region: np.ndarray
    grid: Volume
    segmenter: Segmenter = segment

    def __call__(self, volume: Volume, threshold: float, seed: np.ndarray) -> Segmentation:
        """Return the lumen inside the region, see `segment`; `volume` is `grid` or a part of it."""
        background = np.float32(np.median(volume.grey[::4, ::4, ::4]))
        inside = _part(self.region, self.grid, volume)
        seen = Volume(np.where(inside, volume.grey, background), volume.spacing, volume.origin)
        return self.segmenter(seen, threshold, seed)


@dataclass(frozen=True, eq=False)
class EditedMask:
    """A segmenter that takes the lumen from a mask (bool, on the grid of `grid`).

    At `threshold` the lumen is the mask. At other thresholds, by which the uncertainty of radii is measured, its
    surface follows the grey level within two voxels of the mask, except where the mask overrules the threshold.
    """

    mask: np.ndarray
    grid: Volume
    threshold: float

    def __call__(self, volume: Volume, threshold: float, seed: np.ndarray) -> Segmentation:
        """Return the piece of the mask that holds `seed`; `volume` is `grid` or a part of it."""
        mask = _part(self.mask, self.grid, volume)
        grey, noise = smoothed(volume, self.threshold)
        bright = grey > self.threshold
        added, removed = mask & ~bright, bright & ~mask
        near = ndimage.binary_dilation(mask, iterations=2)
        # Half the contrast on either side: there the surface runs midway between voxels.
        half = 0.5 * abs(threshold - float(np.median(volume.grey[::4, ::4, ::4])))
        grey = np.where(added, threshold + half, np.where(removed, threshold - half, grey))
        return connected_lumen(volume, grey, near & (grey > threshold), threshold, noise, seed)


def _part(mask: np.ndarray, grid: Volume, volume: Volume) -> np.ndarray:
    """Return what of `mask`, on the grid of `grid`, lies in its part `volume`."""
    low = np.round((volume.origin - grid.origin) / grid.spacing).astype(int)
    return mask[tuple(slice(a, a + n) for a, n in zip(low, volume.grey.shape, strict=True))]


def _size(volume: Volume) -> str:
    return " × ".join(str(count) for count in volume.grey.shape[::-1])


def _mm(zyx: np.ndarray) -> str:
    return ", ".join(f"{10 * value:.4g}" for value in zyx[::-1])
