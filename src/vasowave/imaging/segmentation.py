"""Which voxels are vessel: smoothing by the measured noise, a threshold, the component that holds the seed."""

import warnings
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from vasowave.errors import InputError, VasowaveWarning
from vasowave.imaging.volume import Volume


@dataclass(frozen=True, eq=False)
class Segmentation:
    """One connected lumen, cropped.

    Attributes
    ----------
    mask : bool array, shape (z, y, x)
        The lumen within the crop.
    grey : float array, shape (z, y, x)
        Smoothed grey levels of the crop; other components are set to below the threshold.
    corner : int array, shape (3,)
        Voxel of the volume at which the crop starts.
    spacing : float
        Voxel size, cm.
    origin : float array, shape (3,)
        Position of the crop's voxel (0, 0, 0), cm.
    threshold, noise : float
        Grey levels; noise is the standard deviation measured in the volume.
    """

    mask: np.ndarray
    grey: np.ndarray
    corner: np.ndarray
    spacing: float
    origin: np.ndarray
    threshold: float
    noise: float


def noise_level(volume: Volume) -> float:
    """Return the standard deviation of the noise, grey levels: the robust spread of the whole volume.

    Vessels are a few voxels in a thousand, so the median absolute deviation sees the background alone.
    """
    sample = volume.grey[::4, ::4, ::4]
    return float(1.4826 * np.median(np.abs(sample - np.median(sample))))


def segment(volume: Volume, threshold: float = 45.0, seed: np.ndarray | None = None) -> Segmentation:
    """Return the vessel tree of `volume` brighter than `threshold`.

    Parameters
    ----------
    volume : Volume
        Cubic voxels (see `isotropic`).
    threshold : float
        Grey level of the wall (the paper's 45).
    seed : float array, shape (3,), optional
        A point (z, y, x, cm) in the tree; the largest component where none is given.

    Raises
    ------
    InputError
        Voxels not cubic, nothing or nearly everything above the threshold, a seed outside the lumen.

    Warns
    -----
    VasowaveWarning
        A second tree of comparable size; a lumen that touches the border of the volume.
    """
    if not np.allclose(volume.spacing, volume.spacing[0], rtol=2e-3):
        raise InputError(f"segment: spacing {volume.spacing} cm is not cubic; call isotropic(volume) first")
    noise = noise_level(volume)
    contrast = max(threshold - float(np.median(volume.grey[::4, ::4, ::4])), 1e-9)
    # The wall is half the contrast away, so noise/contrast says how much smoothing the surface needs.
    width = float(np.clip(0.5 + 1.1 * noise / contrast, 0.5, 1.3))
    grey = ndimage.gaussian_filter(np.asarray(volume.grey), width, truncate=3.0)
    bright = grey > threshold
    labels, count = ndimage.label(bright)
    if count == 0:
        raise InputError(f"no voxel is brighter than {threshold:g}; the brightest has {grey.max():.4g}: lower it")
    sizes = np.bincount(labels[bright])  # of the few bright voxels alone: a copy of all labels takes a gigabyte
    if sizes.sum() > 0.5 * grey.size:
        raise InputError(f"more than half of the volume is brighter than {threshold:g}; raise the threshold")
    chosen = _component(volume, labels, sizes, seed)
    where = ndimage.find_objects(labels, chosen)[chosen - 1]
    if any(s.start == 0 or s.stop == n for s, n in zip(where, grey.shape, strict=True)):
        _warn("the lumen touches the border of the volume: the vessels that leave it end there, cut")
    box = tuple(slice(max(s.start - 3, 0), min(s.stop + 3, n)) for s, n in zip(where, grey.shape, strict=True))
    mask = ndimage.binary_fill_holes(labels[box] == chosen)
    local = np.where(ndimage.binary_dilation(mask, iterations=2), grey[box], threshold - contrast)
    local = np.where(mask, np.maximum(local, threshold + 1e-3 * contrast), np.minimum(local, threshold - 1e-6))
    corner = np.array([s.start for s in box])
    spacing = float(volume.spacing[0])
    return Segmentation(mask, local, corner, spacing, volume.origin + corner * spacing, threshold, noise)


def _component(volume: Volume, labels: np.ndarray, sizes: np.ndarray, seed: np.ndarray | None) -> int:
    if seed is not None:
        voxel = np.round((np.asarray(seed) - volume.origin) / volume.spacing).astype(int)
        inside = bool((voxel >= 0).all() and (voxel < labels.shape).all())
        if not inside or labels[tuple(voxel)] == 0:
            raise InputError(
                f"the seed {np.asarray(seed)} cm (z, y, x) is not inside a vessel; move it or the threshold"
            )
        return int(labels[tuple(voxel)])
    largest, second = np.argsort(sizes)[::-1][:2]
    if sizes[second] > 0.1 * sizes[largest]:
        _warn(f"two separate trees ({sizes[largest]} and {sizes[second]} voxels): took the larger; a seed chooses")
    return int(largest)


def surface_points(lumen: Segmentation) -> np.ndarray:
    """Return corners of the iso-surface of the grey levels (not of the mask), z, y, x, cm, shape (corner, 3)."""
    try:
        from skimage.measure import marching_cubes
    except ImportError:
        raise InputError("the iso-surface needs the extra 'imaging': install vasowave[imaging]") from None
    grey = np.pad(lumen.grey, 1, constant_values=float(lumen.grey.min()))
    return (marching_cubes(grey, lumen.threshold)[0] - 1) * lumen.spacing + lumen.origin


def _warn(message: str) -> None:
    warnings.warn(message, VasowaveWarning, stacklevel=3)
