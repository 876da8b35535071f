"""Whether equal steps of grey level are equal steps of contrast agent, by how much the noise moves each level.

Noise is the same everywhere before a scale is bent, windowed or saturated. Afterwards it is large where the scale is
steep and small where it is flat: the noise at a level is the slope of the scale there. Noise is what differs between
sections of one vessel at the same place of the section, so neither the wall nor the vessel's axis counts as noise.
"""

from dataclasses import dataclass, replace

import numpy as np

from vasowave.lung.kernels import in_tube
from vasowave.lung.read.volume import Volume
from vasowave.lung.sections import carried, disc, sampled_by_splines, tangents
from vasowave.lung.tree import Tree, clear_stretches

LAG = 3
"""Sections so many points apart have noise of their own; the middle one differs from the mean of both others by it."""
REACH_VOXELS, STEP_VOXELS, RING_VOXELS = 4.5, 0.5, 0.25
"""Sections reach so far beyond the radius, are sampled at this distance, and in rings of this width; voxels."""
CLEARANCE_VOXELS = 3.0
"""What lies nearer to another vessel's wall is left out, voxels."""
SECTIONS_AT_ONCE = 16
"""So many sections are interpolated from one box of the image."""
MIN_SECTIONS, SAMPLES = 12, 40
"""A vessel with fewer sections, and a ring with fewer samples, shows no noise."""
MIN_NOISE_SHARE = 0.012
"""Of the contrast: where there is less noise, what interpolation adds at the walls is no small part of it."""
MIN_RINGS, DEGREE = 30, 3
"""Fewer rings show no scale; the logarithm of the noise is a polynomial of this degree in the level."""
NORMAL_SHARE = 0.683
"""So large a share of normal noise lies within one deviation; where a vessel narrows or bends, the rest is no noise."""
ROUNDS, OUTLIER = 10, 2.0
"""Of the robust fit, in which a ring so many deviations off counts half."""
KNOTS = 9
"""Pairs of a correction."""


@dataclass(frozen=True, eq=False)
class GreyScale:
    """A grey scale between background and lumen.

    Attributes
    ----------
    measured : float array, shape (level,)
        Grey levels of the image at equal steps, the first that of the background, the last that of the lumen.
    linear : float array, shape (level,)
        What they would be on a linear scale on which the first and the last are the same.
    noise : float array, shape (level,)
        SD of the noise at each, grey levels.
    """

    measured: np.ndarray
    linear: np.ndarray
    noise: np.ndarray

    @property
    def bend(self) -> float:
        """The most that a level is off, as a share of the contrast; positive where the image is too bright."""
        off = (self.measured - self.linear) / np.ptp(self.measured)
        return float(off[np.argmax(np.abs(off))])

    @property
    def flatness(self) -> float:
        """The slope of the flatter end of the scale over the mean slope."""
        slope = self.noise / (np.ptp(self.measured) / np.trapezoid(1 / self.noise, self.measured))
        return float(min(slope[0], slope[-1]))

    @property
    def pairs(self) -> tuple[tuple[float, float], ...]:
        """Measured and linear levels that correct the scale."""
        knots = np.linspace(0, len(self.measured) - 1, KNOTS).round().astype(int)
        return tuple(zip(self.measured[knots].tolist(), self.linear[knots].tolist(), strict=True))


def corrected(volume: Volume, pairs: tuple[tuple[float, float], ...]) -> Volume:
    """Return `volume` with the linear level of every measured one, straight between the `pairs` and beyond them."""
    measured, linear = np.array(pairs).T
    slope = np.diff(linear) / np.diff(measured)
    segment = np.clip(np.searchsorted(measured, volume.grey, side="right") - 1, 0, len(slope) - 1)
    return replace(volume, grey=linear[segment] + slope[segment] * (volume.grey - measured[segment]))


def grey_scale(tree: Tree, volume: Volume) -> GreyScale | None:
    """Return the scale of `volume` (cubes) as the noise within and around the vessels of `tree` shows it.

    None where there is no noise, or too little of the vessels is clear of others.
    """
    rings = [_rings(tree, row, stretch, volume) for row, stretch in enumerate(clear_stretches(tree))]
    level, noise, weight = np.concatenate(rings, axis=1)
    if len(level) < MIN_RINGS or not np.ptp(level) > 0 or not np.median(noise) > MIN_NOISE_SHARE * np.ptp(level):
        return None
    knots = np.linspace(level.min(), level.max(), 8 * (KNOTS - 1) + 1)
    fitted = np.exp(_smooth(level, np.log(np.maximum(noise, 1e-3 * np.median(noise))), weight, knots))
    steps = np.diff(knots) * (1 / fitted[1:] + 1 / fitted[:-1]) / 2
    share = np.append(0, np.cumsum(steps)) / steps.sum()
    return GreyScale(knots, knots[0] + share * np.ptp(knots), fitted)


def _rings(tree: Tree, row: int, stretch: tuple[float, float], volume: Volume) -> np.ndarray:
    """Return level, noise and count of samples of the rings around one vessel's axis, shape (3, ring)."""
    line, spacing = tree.lines[row], float(volume.spacing[0])
    begin, end = max(stretch[0], 2 * line.radius[0]), min(stretch[1], line.length - 1.5 * line.typical_radius)
    sections = np.flatnonzero((line.run > begin) & (line.run < end))
    if len(sections) < MIN_SECTIONS:
        return np.empty((3, 0))
    u, v = carried(tangents(line.points, 4)[sections])
    grid = disc(line.typical_radius + REACH_VOXELS * spacing, STEP_VOXELS * spacing)
    places = line.points[sections, None] + grid[:, :1] * u[:, None] + grid[:, 1:] * v[:, None]
    count = -(-len(places) // SECTIONS_AT_ONCE)
    pieces = np.array_split(places, count)  # one box around all may be the whole image
    grey = np.concatenate([sampled_by_splines(volume.grey, piece, volume.origin, spacing) for piece in pieces])
    neighbors = tree.line[tree.owner != row]
    if len(neighbors):
        grey[
            in_tube(places, line.points[sections], neighbors.points, neighbors.radius + CLEARANCE_VOXELS * spacing)
        ] = np.nan
    differs = grey[LAG:-LAG] - (grey[: -2 * LAG] + grey[2 * LAG :]) / 2
    ring = (np.hypot(*grid.T) / (RING_VOXELS * spacing)).astype(int)
    samples = []
    for number in np.unique(ring):
        deviations, levels = differs[:, ring == number], grey[LAG:-LAG, ring == number]
        valid = np.isfinite(deviations)
        if valid.sum() >= SAMPLES:
            samples.append(
                (levels[valid].mean(), np.quantile(np.abs(deviations[valid]), NORMAL_SHARE) / np.sqrt(1.5), valid.sum())
            )
    return np.array(samples).reshape(-1, 3).T


def _smooth(level: np.ndarray, value: np.ndarray, weight: np.ndarray, knots: np.ndarray) -> np.ndarray:
    """Return the polynomial through `value` at the levels `knots`, outliers counting less."""

    def basis(levels: np.ndarray) -> np.ndarray:
        return np.polynomial.legendre.legvander(2 * (levels - knots[0]) / (knots[-1] - knots[0]) - 1, DEGREE)

    matrix, full = basis(level), np.sqrt(weight / weight.max())
    root = full
    for _ in range(ROUNDS):
        fit = np.linalg.lstsq(matrix * root[:, None], value * root, rcond=None)[0]
        off = value - matrix @ fit
        size = max(1.4826 * float(np.median(np.abs(off))), 1e-9)
        root = full / np.sqrt(1 + (off / (OUTLIER * size)) ** 2)
    return np.asarray(basis(knots) @ fit)
