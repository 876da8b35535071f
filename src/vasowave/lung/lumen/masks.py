"""Masks drawn by hand, as the lumen or as a region outside which there is none."""

from dataclasses import dataclass, field

import numpy as np
from scipy import ndimage

from vasowave.base.errors import InputError
from vasowave.lung.lumen.levels import background_level
from vasowave.lung.lumen.segmentation import Segmentation, Segmenter, Smoothed, connected_lumen, parts_of, segment
from vasowave.lung.read.labels import in_mm
from vasowave.lung.read.volume import Volume


def box_region(volume: Volume, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return which voxels of `volume` lie between the corners `low` and `high` of a box, bool, shape (z, y, x).

    The corners are places along the image's own axes, z, y, x, cm.

    Raises
    ------
    InputError
        If no voxel does.
    """
    inside = np.ones(volume.grey.shape, dtype=bool)
    for axis, count in enumerate(volume.grey.shape):
        positions = volume.origin[axis] + np.arange(count) * volume.spacing[axis]
        a, b = sorted((low[axis], high[axis]))
        shape = [1, 1, 1]
        shape[axis] = count
        inside &= ((positions >= a) & (positions <= b)).reshape(shape)
    if not inside.any():
        last = volume.frame.world(volume.origin + (np.array(volume.grey.shape) - 1) * volume.spacing)
        raise InputError(
            f"the region holds no voxel; the image spans {in_mm(volume.origin)} to {in_mm(last)} mm (x, y, z)"
        )
    return inside


@dataclass(frozen=True, eq=False)
class Within:
    """A segmenter that sees only the voxels in `region` (bool, on the grid of `grid`)."""

    region: np.ndarray
    grid: Volume = field(compare=False)  # that of the image
    segmenter: Segmenter = segment

    def __call__(self, volume: Volume, threshold: float, seed: np.ndarray | None) -> Segmentation:
        """Return the lumen inside the region, see `segment`; `volume` is `grid` or a part of it."""
        background = np.float32(background_level(volume))
        inside = _part(self.region, self.grid, volume)
        masked = Volume(np.where(inside, volume.grey, background), volume.spacing, volume.origin)
        return self.segmenter(masked, threshold, seed)


@dataclass(frozen=True, eq=False)
class EditedMask:
    """A segmenter that takes the lumen from a mask (bool, on the grid of `grid`).

    At `threshold` the lumen is the mask. At other thresholds, by which the uncertainty of radii is measured, its
    surface follows the grey level within two voxels of the mask, except where the mask overrules the threshold.
    """

    mask: np.ndarray
    grid: Volume = field(compare=False)
    threshold: float

    def __call__(self, volume: Volume, threshold: float, seed: np.ndarray | None) -> Segmentation:
        """Return the piece of the mask that holds `seed`; `volume` is `grid` or a part of it."""
        mask = _part(self.mask, self.grid, volume)
        levels = Smoothed(volume, self.threshold)
        grey = levels.whole
        bright = grey > self.threshold
        added, removed = mask & ~bright, bright & ~mask
        region = ndimage.binary_dilation(mask, iterations=2)
        # Half the contrast on either side: there the surface runs midway between voxels.
        half = 0.5 * abs(threshold - levels.background)
        grey = np.where(added, threshold + half, np.where(removed, threshold - half, grey))
        return connected_lumen(volume, parts_of(grey), region & (grey > threshold), threshold, levels, seed)


def _part(mask: np.ndarray, grid: Volume, volume: Volume) -> np.ndarray:
    """Return what of `mask`, on the grid of `grid`, lies in its part `volume`."""
    low = np.round((volume.origin - grid.origin) / grid.spacing).astype(int)
    return mask[tuple(slice(a, a + n) for a, n in zip(low, volume.grey.shape, strict=True))]
