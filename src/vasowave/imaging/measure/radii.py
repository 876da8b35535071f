"""The densitometric radius: the grey level integrated over the cross-section, which hardly knows the threshold."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree
from scipy.stats import trim_mean

from vasowave.imaging.axes.stretches import clear_stretches
from vasowave.imaging.read.volume import Volume
from vasowave.imaging.sections import STEP, across, disc, sampled, tangents
from vasowave.imaging.tree import Line, Tree

DISC, RING = 2.0, 7.0
"""A section is integrated up to DISC voxels beyond the radius, its background taken from there to RING voxels."""
CLEARANCE, DIRECTIONS, SEEN = 1.0, 32, 0.3
"""Directions (of so many) in which a section comes within CLEARANCE voxels of another vessel are not measured; sections
of which less than SEEN is left are not used."""

BLURRED = 4.0
"""Blur does not reach farther into a vessel, voxels."""


def densitometric_radii(tree: Tree, volume: Volume, inscribed: np.ndarray) -> np.ndarray:
    """Return a radius per vessel, cm, shape (vessel,); NaN for vessels without a free stretch.

    The area of a section is ∫(g - background)/(lumen - background) dA, the background being that of a ring around
    it and the lumen's grey level that in the middle of the vessels wider than 4 voxels.
    Blur conserves this integral, so neither blur nor threshold changes it.

    Parameters
    ----------
    tree : Tree
    volume : Volume
    inscribed : float array, shape (vessel,)
        First estimate of the radii, cm.
    """
    lumen = lumen_grey(tree, volume)
    found = np.full(len(tree), np.nan)
    for row, (line, (begin, end)) in enumerate(zip(tree.lines, clear_stretches(tree), strict=True)):
        tail = 1.3 * inscribed[row] if row in tree.terminals else 1.5 * line.radius[-1]
        first = max(begin, 1.5 * line.radius[0] + 0.5 * inscribed[row])
        free = np.flatnonzero((line.run > first) & (line.run < min(end, line.length - tail)))
        others = [other for k, other in enumerate(tree.lines) if k != row]
        found[row] = densitometric_radius(line, free, inscribed[row], volume, lumen, others)
    return found


def densitometric_radius(
    line: Line,
    sections: np.ndarray,
    inscribed: float,
    volume: Volume,
    lumen: float,
    others: Sequence[Line] = (),
) -> float:
    """Return the radius from the mean area of `sections` (points of `line`), cm; NaN without sections.

    Directions in which one of the `others` comes into a section are left out together with
    their opposites. The mean is that of the middle half: neighbors disturb some sections, noise all.
    """
    if len(sections) == 0:
        return np.nan
    spacing = volume.spacing[0]
    inner, outer = inscribed + DISC * spacing, inscribed + RING * spacing
    u, v = across(tangents(line.points, 4)[sections])
    grid = disc(outer, STEP * spacing)
    places = line.points[sections, None] + grid[:, :1] * u[:, None] + grid[:, 1:] * v[:, None]
    grey = sampled(volume.grey, places, volume.origin, spacing)
    foreign = _within(places, others, CLEARANCE * spacing)
    within = np.hypot(*grid.T) <= inner
    direction = (
        np.floor(np.arctan2(grid[:, 1], grid[:, 0]) / (2 * np.pi) * DIRECTIONS + 0.5) % (DIRECTIONS // 2)
    ).astype(int)
    areas = []
    for levels, taken in zip(grey, foreign, strict=True):
        ring = levels[~within & ~taken]
        kept = within & ~np.isin(direction, direction[within & taken])
        if kept.sum() < SEEN * within.sum() or len(ring) == 0:
            continue
        background = np.median(ring)
        areas.append(
            max((levels[kept] - background).mean() / (lumen - background), 0.0) * within.sum() * (STEP * spacing) ** 2
        )
    return float(np.sqrt(trim_mean(areas, 0.25) / np.pi)) if areas else np.nan


def _within(places: np.ndarray, others: Sequence[Line], margin: float) -> np.ndarray:
    """Return which of `places` lie inside the tubes of `others` or nearer to them than `margin`."""
    inside = np.zeros(places.shape[:-1], dtype=bool)
    low, high = places.min(axis=(0, 1)), places.max(axis=(0, 1))
    for line in others:
        reach = line.radius.max() + margin
        if ((line.points > low - reach) & (line.points < high + reach)).all(axis=1).any():
            distance, nearest = cKDTree(line.points).query(places, distance_upper_bound=reach)
            inside |= distance < np.append(line.radius, 0.0)[nearest] + margin
    return inside


def lumen_grey(tree: Tree, volume: Volume) -> float:
    """Return the grey level of the lumen: the median in the middle of the wide vessels, which blur does not reach."""
    spacing = volume.spacing[0]
    wide = min(BLURRED * spacing, np.quantile(tree.line.radius, 0.8))
    levels = []
    for line in tree.lines:
        deep = line.radius > wide
        u, v = across(tangents(line.points)[deep])
        grid = disc(max(float(np.median(line.radius[deep])) - BLURRED * spacing, 0.0) if deep.any() else 0.0, spacing)
        places = line.points[deep, None] + grid[:, :1] * u[:, None] + grid[:, 1:] * v[:, None]
        levels.append(sampled(volume.grey, places, volume.origin, spacing).ravel())
    return float(np.median(np.concatenate(levels)))
