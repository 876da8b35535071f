"""What noise alone adds to a vessel's sections: the same sections laid beside the vessel, where nothing is."""

from collections.abc import Callable

import numpy as np

from vasowave.imaging.kernels import in_tube
from vasowave.imaging.measure.profiles import DISC, RING
from vasowave.imaging.read.volume import Volume
from vasowave.imaging.sections import across, disc, medians, sampled, tangents
from vasowave.imaging.tree import Line

COPIES = 12
"""The sections are laid in so many directions beside their vessel."""
EVERY, FINE = 2.0, 4.0
"""One section in EVERY voxels is enough, and one sample a voxel: neighbors share their noise. In vessels wider than
FINE voxels samples, and then sections, are so many to a radius, for their radii are sure."""
CLEAR = 0.9
"""A section is used if so much of it is no vessel."""
FEWEST = 4
"""Fewer copies that lie clear of all vessels say nothing."""

Beside = Callable[[Line, np.ndarray, float, Volume, Line], float]
"""Tells what noise adds to sections, see `signal_beside`."""


def signal_beside(line: Line, sections: np.ndarray, radius: float, volume: Volume, vessels: Line) -> float:
    """Return the standard deviation of the mean signal of sections beside a vessel, grey levels · cm²; NaN if unknown.

    It holds whatever the image has of noise: grain of any length, rings that run along a vessel, streaks. The scatter
    of a vessel's own sections does not show what they have in common.

    Parameters
    ----------
    line, sections, radius, volume
        See `profile`.
    vessels : Line
        The points of all vessels.
    """
    spacing = float(volume.spacing[0])
    inner, outer = radius + DISC * spacing, radius + RING * spacing
    rows = sections[:: round(max(EVERY, radius / (FINE * spacing)))]
    u, v = (axis[rows] for axis in across(tangents(line.points, 4)))
    grid = disc(outer, max(spacing, radius / FINE))
    within = np.hypot(*grid.T) <= inner
    area, means = np.pi * inner**2, []
    for angle in 2 * np.pi * np.arange(COPIES) / COPIES:
        centers = line.points[rows] + (2 * inner + spacing) * (np.cos(angle) * u + np.sin(angle) * v)
        places = centers[:, None] + grid[:, :1] * u[:, None] + grid[:, 1:] * v[:, None]
        voxels = (places - volume.origin) / spacing
        clear = ~in_tube(places, centers, vessels.points, vessels.radius + spacing) & _inside(voxels, volume.grey.shape)
        good = (clear & within).sum(axis=1) >= CLEAR * within.sum()
        if good.sum() < max(0.5 * len(rows), 1) or not (clear[good] & ~within).any(axis=1).all():
            continue
        grey = sampled(volume.grey, places[good], volume.origin, spacing)
        disc_mean = _mean(grey, clear[good] & within)
        background = medians(grey, clear[good] & ~within)
        means.append(float(np.mean(disc_mean - background)) * area)
    return float(np.median(np.abs(means))) / 0.6745 if len(means) >= FEWEST else np.nan


def reach_beside(radius: float, spacing: float) -> float:
    """Return how far from a vessel's axis the walls lie that matter to the sections beside it, cm."""
    return 2 * (radius + DISC * spacing) + spacing + radius + RING * spacing + spacing


def _inside(voxels: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    return np.asarray(((voxels >= 0) & (voxels <= np.array(shape) - 1)).all(axis=-1))


def _mean(values: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    return np.asarray((values * chosen).sum(axis=1) / chosen.sum(axis=1))
