"""The threshold to begin with: between the background and what the middle of the widest vessels shows."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from vasowave.imaging.lumen.background import background_level
from vasowave.imaging.read.volume import Volume

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
    every = -(-max(volume.grey.shape) // FINEST)
    grey = ndimage.gaussian_filter(np.asarray(volume.grey[::every, ::every, ::every], dtype=np.float32), SMOOTH)
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
