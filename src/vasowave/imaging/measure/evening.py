"""Sections of a vessel made comparable: without its taper, and with a scatter that few sections do not misjudge."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vasowave.imaging.measure.profiles import COPIES, Profile

FEWEST = 5
"""A slope is looked for in at least so many sections."""
SURE = 3.0
"""A slope counts beyond so many standard errors: at 2 the radii of vessels that do not narrow scatter more."""
SHARED = 3.0
"""Neighboring sections share their noise: so many count as one."""
BELIEVED = 6.0
"""The scatter that noise alone explains weighs as much as that of so many independent sections."""


@dataclass(frozen=True, eq=False)
class Evened:
    """Sections as wide as they would be in the vessel's middle, the relative error of the radius from that, and taper.

    The taper is the fall of the radius along the vessel as a share of the radius in its middle, 1/cm, with its standard
    error; NaN with too few sections.
    """

    sections: Profile
    error: float
    taper: float = np.nan
    taper_sd: float = np.nan


def evened_sections(one: Profile, middle: float) -> Evened:
    """Return the sections of a vessel carried to its `middle` (cm along it) by the slope of their radius.

    Sections of a vessel that narrows differ, and those that are clear of its junctions lie nearer to one end. The
    slope is the median of all pairs' (Theil and Sen), less what `SURE` of its standard errors explain, so that a vessel
    that does not narrow keeps its sections.
    """
    width = np.sqrt(one.signal)
    if np.ptp(one.run) <= 0 or len(width) < FEWEST:
        return Evened(one, 0.0)
    slope = _median_slope(one.run, width)
    rest = width - slope * one.run
    at_middle = float(np.median(rest)) + slope * middle
    error = float(np.std(rest)) / (float(np.std(one.run)) * np.sqrt(len(width) / SHARED))
    if at_middle <= 0:
        return Evened(one, 0.0)
    taper, taper_sd = -slope / at_middle, error / at_middle
    slope *= max(0.0, 1 - (SURE * error / max(abs(slope), 1e-12)) ** 2)
    line = np.median(width - slope * one.run) + slope * np.append(one.run, middle)
    if line.min() <= 0:
        return Evened(one, 0.0, taper, taper_sd)
    carried = abs(middle - float(np.mean(one.run))) * error / float(line[-1])
    return Evened(replace(one, signal=one.signal * (line[-1] / line[:-1]) ** 2), carried, taper, taper_sd)


def _median_slope(x: np.ndarray, y: np.ndarray) -> float:
    """Return the median slope of all pairs of points."""
    first, second = np.triu_indices(len(x), 1)
    apart = x[second] != x[first]
    return float(np.median((y[second] - y[first])[apart] / (x[second] - x[first])[apart]))


def moderated(profiles: Sequence[Profile | None], beside: np.ndarray) -> np.ndarray:
    """Return the standard error of each vessel's mean signal, grey levels · cm²; NaN without sections.

    The scatter of a dozen sections is known to a fifth, and where it happens to be small a wrong radius would look
    sure. All vessels of an image share its noise: what that lets a section scatter, by its area and that of its
    background, is scaled to the median of all vessels, and counts as `BELIEVED` sections beside the vessel's own.
    The same is done with what the sections show `beside` their vessel, and the larger error counts: sections of one
    vessel do not show what noise they have in common, those beside it not that they differ.

    Parameters
    ----------
    profiles : sequence of Profile or None
    beside : float array, shape (vessel,)
        See `signal_beside`, NaN where unknown.
    """
    own = np.array([np.nan if one is None else float(np.std(one.signal)) for one in profiles])
    noise = np.array([np.nan if one is None else one.noise for one in profiles])
    count = np.array([1.0 if one is None else max(len(one.signal) / SHARED, 1.0) for one in profiles])
    scatter = _pooled(own, noise, count - 1) / np.sqrt(count)
    common = _pooled(beside, noise / np.sqrt(count), np.full(len(own), COPIES / 2))
    return np.asarray(np.fmax(scatter, common))


def _pooled(own: np.ndarray, expected: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Return each vessel's `own` deviation, known from `count` values, moderated by what noise lets all expect."""
    known = np.isfinite(own)
    if not known.any():
        return own
    usual = float(np.nanmedian(own / expected)) * expected
    count = np.where(known, count, 0.0)
    return np.asarray(np.sqrt((BELIEVED * usual**2 + count * np.nan_to_num(own) ** 2) / (BELIEVED + count)))
