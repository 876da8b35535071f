"""Active contour: the lumen's surface as a front that moves by grey levels and resists bending ("snake evolution")."""

import numpy as np
from scipy import ndimage

from vasowave.base.errors import EXTRAS, InputError
from vasowave.lung.lumen.segmentation import Segmentation, Smoothed, connected_lumen, parts_of, segment
from vasowave.lung.read.volume import Volume

CURVATURE = 0.1
"""Weight of the front's stiffness against its speed; more removes larger spurs of noise, and thin vessels."""
ITERATIONS = 80  # of the level set, at most
_MARGIN = 8  # voxels around the lumen in which the front may move


def level_set(volume: Volume, threshold: float = 45.0, seed: np.ndarray | None = None) -> Segmentation:
    """Return the lumen within a front that grows where it is brighter than `threshold` and shrinks where darker.

    The front starts at the lumen that `segment` finds and moves by ∂φ/∂t = speed + CURVATURE · κ with the speed
    (grey - threshold)/contrast, clipped to ±1, until it rests: the evolution of ITK-SNAP's thresholding mode.

    Raises
    ------
    InputError
        As `segment`; a front that shrinks to nothing.
    """
    start = segment(volume, threshold, seed)
    levels = Smoothed(volume, threshold)
    grey = levels.whole
    low = np.maximum(start.corner - _MARGIN, 0)
    high = np.minimum(start.corner + np.array(start.mask.shape) + _MARGIN, grey.shape)
    box = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
    before = np.zeros(high - low, dtype=bool)
    before[tuple(slice(a, a + n) for a, n in zip(start.corner - low, start.mask.shape, strict=True))] = start.mask
    contrast = threshold - levels.background
    phi = _evolved(_signed_distance(before), np.clip((grey[box] - threshold) / contrast, -1, 1))
    if not (phi < 0).any():
        raise InputError("the active contour shrank to nothing; lower the threshold or use the method 'threshold'")
    # The surface is where φ = 0, between the voxels; `grey` carries it on as the threshold.
    grey[box] = threshold - 0.5 * contrast * np.clip(phi, -3, 3)
    inside = np.zeros(grey.shape, dtype=bool)
    inside[box] = phi < 0
    return connected_lumen(volume, parts_of(grey), inside, threshold, levels, seed, closes_inclusions=True)


def _signed_distance(mask: np.ndarray) -> np.ndarray:
    """Return the distance from the surface of `mask`, half a voxel off its outer voxels, negative inside, voxels."""
    return np.where(
        mask, 0.5 - ndimage.distance_transform_edt(mask), ndimage.distance_transform_edt(~mask) - 0.5
    ).astype(np.float32)


def _evolved(phi: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Return φ (negative inside, voxels) at rest."""
    try:
        import SimpleITK
    except ImportError:
        raise InputError(f"the level set needs the extra 'imaging': {EXTRAS}") from None
    front = SimpleITK.ThresholdSegmentationLevelSetImageFilter()
    front.SetLowerThreshold(0.0)  # between 0 and 1 the filter's speed is its feature image itself
    front.SetUpperThreshold(2.0)
    front.SetPropagationScaling(1.0)
    front.SetCurvatureScaling(CURVATURE)
    front.SetMaximumRMSError(0.002)
    front.SetNumberOfIterations(ITERATIONS)
    front.SetNumberOfThreads(1)  # the same result on every machine
    images = (SimpleITK.GetImageFromArray(values.astype(np.float32)) for values in (phi, speed))
    return SimpleITK.GetArrayFromImage(front.Execute(*images))
