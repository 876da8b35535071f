"""What is dark and what is bright in an image: background, noise, lumen, and the threshold to begin with.

What a mask or a reconstruction filled in around the vessels does not count.
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from vasowave.lung.read.volume import Volume

LAG = 3
"""Noise is the difference of voxels so far apart: neighbors share their noise, distant ones differ by cupping."""
SAMPLE_STRIDE = 4
"""One voxel in so many along each axis is looked at."""
MAX_LABELS = 8
"""An image of at most so many grey levels is drawn, not scanned."""
CONTRAST_SHARE = 0.4
"""The threshold lies at this share of the contrast: at half of it, thin vessels that blur has dimmed are lost."""
MAX_EDGE_VOXELS = 200
"""At most so many voxels along an edge are looked at: the widest vessels are seen on a coarser grid too."""
SMOOTHING_VOXELS = 0.7
"""Standard deviation of the smoothing, voxels of that grid."""
FIRST_PERCENTILE, CORE_QUANTILE = 99.9, 0.8
"""The lumen is first as bright as this percentile, then as its deepest voxels, those beyond this quantile."""
ROUNDS, SETTLED_SHARE = 8, 0.01
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
    scanned = real.any() and len(np.unique(grey)) > MAX_LABELS
    return float(np.median(grey[real] if scanned else grey))


def _sample(volume: Volume, shift: int) -> tuple[np.ndarray, np.ndarray]:
    """Return every so many-th voxel, `shift` farther along the last axis, and whether it differs from its neighbors."""
    grey = volume.grey
    places = [np.arange(0, count, SAMPLE_STRIDE) for count in grey.shape]
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
        return float(f"{self.background + CONTRAST_SHARE * (self.lumen - self.background):.3g}")


def levels_of(volume: Volume) -> Levels:
    """Return background and lumen of `volume`: the largest bright piece is looked at, again and again."""
    stride = -(-max(volume.grey.shape) // MAX_EDGE_VOXELS)
    grey = ndimage.gaussian_filter(
        np.asarray(volume.grey[::stride, ::stride, ::stride], dtype=np.float32), SMOOTHING_VOXELS
    )
    dark, bright = background_level(volume), float(np.percentile(grey, FIRST_PERCENTILE))
    for _ in range(ROUNDS):
        pieces, count = ndimage.label(grey > dark + CONTRAST_SHARE * (bright - dark))
        if not count:
            break
        lumen = pieces == 1 + int(np.argmax(np.bincount(pieces.ravel())[1:]))
        depth = ndimage.distance_transform_edt(np.pad(lumen, 1))[1:-1, 1:-1, 1:-1]
        before, bright = bright, float(np.median(grey[depth >= np.quantile(depth[lumen], CORE_QUANTILE)]))
        if abs(bright - before) < SETTLED_SHARE * abs(bright - dark):
            break
    return Levels(dark, bright)
