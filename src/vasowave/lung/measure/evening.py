"""Sections of a vessel made comparable: without its taper, and with a scatter that few sections do not misjudge."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri

from vasowave.lung.measure.profiles import COPIES, SECTIONS_PER_SAMPLE, Profile

FEWEST = 5
"""A slope is looked for in at least so many sections."""
MIN_SLOPE_ERRORS = 3.0
"""A slope counts beyond so many standard errors: at 2 the radii of vessels that do not narrow scatter more."""
MIN_FREEDOM = 0.3
"""Samples that are left beside a line at least; sections are often too few to tell."""
MIN_UNEVEN, CHANCE = 0.045, 0.01
"""Areas of sections that scatter by this share more than noise explains are not those of one even tube, unless noise
does so by chance in more than this share of vessels."""
MIN_RUGGED, RUGGED_ERROR = 0.011, 4.0
"""An outline with larger waves is one of a lumen with a rim or a clot (round ones show 0 to 0.008), whose radius is off
by so many times the waves: thin half-moons of calcium by 3 to 6."""
MIN_MIXED, MIN_MIXED_RATIO = 0.07, 4.0
"""A middle whose level scatters along the vessel by this share, and by so many times what is usual, holds a clot."""
PRIOR_SECTIONS = 6.0
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


def evened_sections(sections: Profile, middle: float) -> Evened:
    """Return the sections of a vessel carried to its `middle` (cm along it) by the slope of their radius.

    Sections of a vessel that narrows differ, and those that are clear of its junctions lie nearer to one end. The slope
    is the median of all pairs' (Theil and Sen), less what `MIN_SLOPE_ERRORS` of its standard errors explain, so that a
    vessel that does not narrow keeps its sections.
    """
    width = np.sqrt(sections.signal)
    if np.ptp(sections.run) <= 0 or len(width) < FEWEST:
        return Evened(sections, 0.0)
    slope = _median_slope(sections.run, width)
    residual = width - slope * sections.run
    at_middle = float(np.median(residual)) + slope * middle
    samples = len(width) / SECTIONS_PER_SAMPLE
    error = float(np.std(residual)) / (float(np.std(sections.run)) * np.sqrt(samples))
    if at_middle <= 0:
        return Evened(sections, 0.0)
    inflation = np.sqrt(samples / max(samples - 2, MIN_FREEDOM))  # a line takes two of the samples
    taper, taper_sd = -slope / at_middle, error * inflation / at_middle
    slope *= max(0.0, 1 - (MIN_SLOPE_ERRORS * error / max(abs(slope), 1e-12)) ** 2)
    line = np.median(width - slope * sections.run) + slope * np.append(sections.run, middle)
    if line.min() <= 0:
        return Evened(sections, 0.0, taper, taper_sd)
    carried = abs(middle - float(np.mean(sections.run))) * error / float(line[-1])
    return Evened(replace(sections, signal=sections.signal * (line[-1] / line[:-1]) ** 2), carried, taper, taper_sd)


def _median_slope(x: np.ndarray, y: np.ndarray) -> float:
    """Return the median slope of all pairs of points."""
    first, second = np.triu_indices(len(x), 1)
    distinct = x[second] != x[first]
    return float(np.median((y[second] - y[first])[distinct] / (x[second] - x[first])[distinct]))


def moderated(profiles: Sequence[Profile | None], noise_beside: np.ndarray) -> np.ndarray:
    """Return the standard error of each vessel's mean signal, grey levels · cm²; NaN without sections.

    The scatter of a dozen sections is known to a fifth, and where it happens to be small a wrong radius would look
    sure. All vessels of an image share its noise: what that lets a section scatter, by its area and that of its
    background, is scaled to the median of all vessels, and counts as `PRIOR_SECTIONS` beside the vessel's own.
    The same is done with what sections beside their vessel show (`noise_beside`), and the larger error counts:
    sections of one vessel do not show what noise they have in common, those beside it not that they differ.

    Parameters
    ----------
    profiles : sequence of Profile or None
    noise_beside : float array, shape (vessel,)
        See `signal_beside`, NaN where unknown.
    """
    deviation, noise = _scatter(profiles)
    count = np.array(
        [1.0 if sections is None else max(len(sections.signal) / SECTIONS_PER_SAMPLE, 1.0) for sections in profiles]
    )
    scatter = _pooled(deviation, noise, count - 1) / np.sqrt(count)
    common = _pooled(noise_beside, noise / np.sqrt(count), np.full(len(deviation), COPIES / 2))
    return np.asarray(np.fmax(scatter, common))


def unevenness(profiles: Sequence[Profile | None]) -> np.ndarray:
    """Return by what share the areas of each vessel's sections differ along it, or their middles do, or its outline is
    off a tube's; shape (vessel,).

    0 without sections, and where noise explains them: that of all vessels, by the scatter that is usual.
    """
    deviation, noise = _scatter(profiles)
    mean = np.array([np.nan if sections is None else float(np.mean(sections.signal)) for sections in profiles])
    usual = float(np.nanmedian(deviation / noise)) * noise if np.isfinite(deviation).any() else deviation
    share = np.sqrt(np.maximum(deviation**2 - usual**2, 0.0)) / np.maximum(mean, 1e-12)
    along = np.where((share > MIN_UNEVEN) & (deviation > _by_chance(profiles) * usual), share, 0.0)
    pairs = [(0.0, 0.0) if sections is None else (sections.rugged, _mixed(sections)) for sections in profiles]
    rugged, mixed = np.array(pairs).reshape(-1, 2).T
    around = np.where(rugged > MIN_RUGGED, RUGGED_ERROR * rugged, 0.0)
    within = np.where(mixed > max(MIN_MIXED, MIN_MIXED_RATIO * float(np.median(mixed))), mixed, 0.0)
    return np.asarray(np.max([along, around, within], axis=0))


def _by_chance(profiles: Sequence[Profile | None]) -> np.ndarray:
    """Return by what factor the scatter of each vessel's sections exceeds what is usual in one vessel of a hundred."""
    sections = np.array([0 if profile is None else len(profile.signal) for profile in profiles])
    freedom = np.maximum(sections / SECTIONS_PER_SAMPLE - 1, MIN_FREEDOM)
    return np.asarray(np.sqrt(chdtri(freedom, CHANCE) / freedom))


def _mixed(sections: Profile) -> float:
    """Return by what share the level in the middle of the sections scatters."""
    return float(np.std(sections.plateau) / max(np.median(sections.plateau), 1e-12))


def _scatter(profiles: Sequence[Profile | None]) -> tuple[np.ndarray, np.ndarray]:
    """Return the SD of each vessel's signals, and what noise lets expect up to a factor; NaN without sections."""
    pairs = [
        (np.nan, np.nan) if sections is None else (np.std(sections.signal), sections.noise) for sections in profiles
    ]
    deviation, noise = np.array(pairs, dtype=float).reshape(-1, 2).T
    return deviation, noise


def _pooled(deviation: np.ndarray, expected: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Return each vessel's own `deviation`, known from `count` values, moderated by what noise lets all expect."""
    is_known = np.isfinite(deviation)
    if not is_known.any():
        return deviation
    usual = float(np.nanmedian(deviation / expected)) * expected
    count = np.where(is_known, count, 0.0)
    return np.asarray(
        np.sqrt((PRIOR_SECTIONS * usual**2 + count * np.nan_to_num(deviation) ** 2) / (PRIOR_SECTIONS + count))
    )
