"""The contrast of each vessel's lumen: what its own middle shows, with what the tree as a whole says."""

from collections.abc import Sequence

import numpy as np

from vasowave.lung.measure.profiles import Profile

BLUR = 0.9
"""Standard deviation of the blur where no vessel is wide enough to show it, voxels."""
WIDE = 3.5
"""A vessel of so many voxels of radius shows the blur in the slope of its wall."""
UNKNOWN_BLUR_SHARE = 1.0
"""Of what blur takes from a vessel's middle, this share is not known: a thin vessel does not show its own contrast."""
MIN_PLATEAU_ERROR = 0.01
"""Least relative error of a plateau: background and axis are never quite right."""


def blur_of(profiles: Sequence[Profile | None], inscribed: np.ndarray, spacing: float) -> float:
    """Return the standard deviation of the blur, cm: a wall of contrast C falls by C/(σ√(2π)) at its steepest.

    Bends and sections that are not round flatten the mean wall too, so the steepest of the wide vessels counts.
    """
    widths = [
        float(np.median(sections.plateau)) / (np.sqrt(2 * np.pi) * sections.slope)
        for sections, radius in zip(profiles, inscribed, strict=True)
        if sections is not None and sections.slope > 0 and radius > WIDE * spacing
    ]
    return min(widths) if widths else BLUR * spacing


def own_contrast(sections: Profile, blur: float) -> tuple[float, float]:
    """Return the contrast that a vessel's own middle shows, and its standard error, grey levels.

    Blur leaves 1 - exp(-r²/2σ²) of the contrast C on the axis of a round vessel, and r² = signal / (π C).
    """
    plateau, signal = float(np.mean(sections.plateau)), float(np.mean(sections.signal))
    contrast = plateau
    for _ in range(20):
        axis_share = _left(signal, contrast, blur)
        contrast = 0.5 * (contrast + plateau / axis_share)
    noise = float(np.std(sections.plateau)) / np.sqrt(max(len(sections.plateau) / 3, 1))  # neighbors share their noise
    return contrast, float(
        np.hypot(noise / axis_share, np.hypot(UNKNOWN_BLUR_SHARE * (1 - axis_share), MIN_PLATEAU_ERROR) * contrast)
    )


def contrasts(profiles: Sequence[Profile | None], distance: np.ndarray, blur: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the contrast of every vessel and its standard deviation, grey levels, shape (vessel,); NaN if unknown.

    All vessels of an evenly filled tree have one contrast; agent that thins out makes it fall along the way; agent
    that is not mixed makes vessels differ. How much they differ beyond their errors says how far each is believed
    by itself: the mean of its own value and of the tree's line, weighted by their variances (empirical Bayes).

    Parameters
    ----------
    profiles : sequence of Profile or None
    distance : float array, shape (vessel,)
        Distance of the vessel's middle from the root.
    blur : float
        See `blur_of`, cm.
    """
    pairs = [
        own_contrast(sections, blur) if sections is not None and sections.plateau.mean() > 0 else (np.nan, np.nan)
        for sections in profiles
    ]
    value, error = np.array(pairs).T
    is_known = np.isfinite(value)
    if not is_known.any():
        return value, error
    line, between = _line(value[is_known], error[is_known], distance[is_known])
    trend, trend_error = line(distance)
    trusted = 1 / error**2
    prior = 1 / np.maximum(between + trend_error**2, 1e-12)
    best = (np.nan_to_num(value * trusted) + trend * prior) / (np.nan_to_num(trusted) + prior)
    return np.where(is_known, best, trend), np.sqrt(1 / (np.nan_to_num(trusted) + prior))


def _left(signal: float, contrast: float, blur: float) -> float:
    """Return the share of the contrast that blur leaves on the axis."""
    square = signal / (np.pi * max(contrast, 1e-9))
    return float(max(1 - np.exp(-square / (2 * blur**2)), 0.05))


def _line(value: np.ndarray, error: np.ndarray, distance: np.ndarray):  # type: ignore[no-untyped-def]
    """Return the tree's contrast along the way, a function to value and error, and the variance about it."""
    between, slope = 0.0, len(value) > 3
    for _ in range(30):
        matrix = np.column_stack([np.ones_like(distance), distance]) if slope else np.ones((len(distance), 1))
        weight = 1 / (error**2 + between)
        covariance = np.linalg.pinv((matrix * weight[:, None]).T @ matrix)
        fit = covariance @ (matrix * weight[:, None]).T @ value
        if slope and abs(fit[1]) < 2 * np.sqrt(covariance[1, 1]):
            slope = False
            continue
        square = (value - matrix @ fit) ** 2
        # Paule and Mandel: the variance at which the weighted squares equal the degrees of freedom.
        excess = (weight * square).sum() - max(len(value) - matrix.shape[1], 1)
        between = max(between + excess / max((weight**2 * square).sum(), 1e-12), 0.0)

    def along(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        full = np.column_stack([np.ones_like(positions), positions])[:, : len(fit)]
        return full @ fit, np.sqrt(np.maximum((full @ covariance * full).sum(axis=1), 0))

    return along, between
