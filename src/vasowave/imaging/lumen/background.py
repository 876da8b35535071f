"""What lies around the vessels: its grey level and its noise, without what a mask or a reconstruction filled in."""

import numpy as np

from vasowave.imaging.read.volume import Volume

LAG = 3
"""Noise is the difference of voxels so far apart: neighbors share their noise, distant ones differ by cupping."""
EVERY = 4
"""One voxel in so many along each axis is looked at."""
LABELS = 8
"""An image of at most so many grey levels is drawn, not scanned."""


def background_level(volume: Volume) -> float:
    """Return the median grey level: vessels are a few voxels in a hundred.

    Voxels equal to all their neighbors were filled in, as the frame of a masked image, and do not count, unless the
    image is a drawing: there they are nearly all, and what is left lies at the walls of vessels.
    """
    return _middle(*_sample(volume, 0))


def background_and_noise(volume: Volume) -> tuple[float, float]:
    """Return `background_level` and the noise's standard deviation, from the median of differences; grey levels."""
    (near, one), (far, other) = _sample(volume, 0), _sample(volume, LAG)
    real = one & other
    difference = (far - near)[real] if real.any() else far - near
    return _middle(near, one), float(1.4826 * np.median(np.abs(difference)) / np.sqrt(2))


def _middle(grey: np.ndarray, real: np.ndarray) -> float:
    """Return the median of the `real` ones of a sample of grey levels, or of all."""
    scanned = real.any() and len(np.unique(grey)) > LABELS
    return float(np.median(grey[real] if scanned else grey))


def _sample(volume: Volume, shift: int) -> tuple[np.ndarray, np.ndarray]:
    """Return every so many-th voxel, `shift` farther along the last axis, and whether it differs from its neighbors."""
    grey = volume.grey
    places = [np.arange(0, count, EVERY) for count in grey.shape]
    places[2] = np.minimum(places[2] + shift, grey.shape[2] - 1)
    here = grey[np.ix_(*places)].astype(np.float32)
    real = np.zeros(here.shape, dtype=bool)
    for axis in range(3):
        for step in (-1, 1):
            beside = list(places)
            beside[axis] = np.clip(places[axis] + step, 0, grey.shape[axis] - 1)  # at a face the voxel itself
            real |= grey[np.ix_(*beside)] != here
    return here, real
