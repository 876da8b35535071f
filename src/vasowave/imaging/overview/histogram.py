"""The grey levels of an image counted, and how finely they are stored."""

from dataclasses import dataclass

import numpy as np

from vasowave.imaging.read.volume import Volume

BINS = 256


@dataclass(frozen=True, eq=False)
class Histogram:
    """How often each grey level occurs.

    Attributes
    ----------
    edges : float array, shape (bin + 1,)
        Grey levels.
    counts : int array, shape (bin,)
        Voxels.
    whole : bool
        Whether all grey levels are whole numbers.
    at_ends : tuple of float
        Shares of the voxels at the lowest and at the highest level.
    """

    edges: np.ndarray
    counts: np.ndarray
    whole: bool
    at_ends: tuple[float, float]

    @property
    def bits(self) -> int | None:
        """Bits that hold all levels; None where they are decimal numbers."""
        return max(1, int(np.ceil(np.log2(np.ptp(self.edges) + 1)))) if self.whole else None


def histogram_of(volume: Volume) -> Histogram:
    """Return the histogram of `volume`."""
    grey = volume.grey
    low, high = float(grey.min()), float(grey.max())
    counts, edges = np.histogram(grey, BINS, (low, high))
    ends = (float(np.mean(grey == low)), float(np.mean(grey == high)))
    return Histogram(edges, counts, bool((grey == np.round(grey)).all()), ends)
