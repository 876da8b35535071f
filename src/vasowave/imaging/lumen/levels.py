"""What is dark and what is bright in an image: background, noise, lumen, and the threshold to begin with.

What a mask or a reconstruction filled in around the vessels does not count.
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from vasowave.imaging.read.volume import Volume

LAG = 3
"""Noise is the difference of voxels so far apart: neighbors share their noise, distant ones differ by cupping."""
EVERY = 4
"""One voxel in so many along each axis is looked at."""
LABELS = 8
"""An image of at most so many grey levels is drawn, not scanned."""
SHARE = 0.4
"""The threshold lies at this share of the contrast: at half of it, thin vessels that blur has dimmed are lost."""
FINEST = 200
"""At most so many voxels along an edge are looked at: the widest vessels are seen on a coarser grid too."""
SMOOTH = 0.7
"""Standard deviation of the smoothing, voxels of that grid."""
FIRST, CORE = 99.9, 0.8
"""The lumen is first as bright as this percentile, then as its deepest voxels, those beyond this quantile."""
ROUNDS, SETTLED = 8, 0.01
"""Rounds at most, until the contrast changes by less than this share."""


def background_level(volume: Volume) -> float:
    """Return the median grey level: vessels are a few voxels in a hundred.

    Voxels equal to all their neighbors were filled in, as the frame of a masked image, and do not count, unless the
    image is a drawing: there they are nearly all, and what is left lies at the walls of vessels.
    """
    return _middle(*_sample(volume, 0))


def background_and_noise(volume: Volume) -> tuple[float, float]:
    """Return `background_level` and the noise's standard deviation, from the median of differences; grey levels."""
    (levels, valid), (shifted_levels, shifted_valid) = _sample(volume, 0), _sample(volume, LAG)
    real = valid & shifted_valid
    difference = (shifted_levels - levels)[real] if real.any() else shifted_levels - levels
    return _middle(levels, valid), float(1.4826 * np.median(np.abs(difference)) / np.sqrt(2))


def _middle(grey: np.ndarray, real: np.ndarray) -> float:
    """Return the median of the `real` ones of a sample of grey levels, or of all."""
    scanned = real.any() and len(np.unique(grey)) > LABELS
    return float(np.median(grey[real] if scanned else grey))


def _sample(volume: Volume, shift: int) -> tuple[np.ndarray, np.ndarray]:
    """Return every so many-th voxel, `shift` farther along the last axis, and whether it differs from its neighbors."""
    grey = volume.grey
    places = [np.arange(0, count, EVERY) for count in grey.shape]
    places[2] = np.minimum(places[2] + shift, grey.shape[2] - 1)
    sample = grey[np.ix_(*places)].astype(np.float32)
    real = np.zeros(sample.shape, dtype=bool)
    for axis in range(3):
        for step in (-1, 1):
            neighbors = list(places)
            neighbors[axis] = np.clip(places[axis] + step, 0, grey.shape[axis] - 1)  # at a face the voxel itself
            real |= grey[np.ix_(*neighbors)] != sample
    return sample, real


@dataclass(frozen=True)
class Levels:
    """What is dark and what is bright in an image.

    Attributes
    ----------
    background, lumen : float
        Grey levels of what lies around the vessels and of the middle of the widest.
    """

    background: float
    lumen: float

    @property
    def threshold(self) -> float:
        """The proposed threshold, to three digits."""
        return float(f"{self.background + SHARE * (self.lumen - self.background):.3g}")


def levels_of(volume: Volume) -> Levels:
    """Return background and lumen of `volume`: the largest bright piece is looked at, again and again."""
    stride = -(-max(volume.grey.shape) // FINEST)
    grey = ndimage.gaussian_filter(np.asarray(volume.grey[::stride, ::stride, ::stride], dtype=np.float32), SMOOTH)
    dark, bright = background_level(volume), float(np.percentile(grey, FIRST))
    for _ in range(ROUNDS):
        pieces, count = ndimage.label(grey > dark + SHARE * (bright - dark))
        if not count:
            break
        lumen = pieces == 1 + int(np.argmax(np.bincount(pieces.ravel())[1:]))
        depth = ndimage.distance_transform_edt(np.pad(lumen, 1))[1:-1, 1:-1, 1:-1]
        before, bright = bright, float(np.median(grey[depth >= np.quantile(depth[lumen], CORE)]))
        if abs(bright - before) < SETTLED * abs(bright - dark):
            break
    return Levels(dark, bright)
