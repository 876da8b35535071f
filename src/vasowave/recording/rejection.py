"""Which beats may not be averaged, and why: by their length, their shape, and the breath they fall into."""

from collections import Counter

import numpy as np

from vasowave.errors import NumericalError
from vasowave.findings import Finding, Severity, kind

_BREATHS = 31
"""Beats over which the end-expiratory level is followed: three breaths or more."""

_OFF = 2.5
"""A beat further off the end-expiratory level than this many SD is one of inspiration."""


AVERAGED = kind(
    "recording.averaged",
    Severity.NOTE,
    "mean of {beats} beats from {start:.3f} to {end:.3f} s, aligned by the {by}; {found} beats found, rejected: "
    "{rejected}",
)
MANY_REJECTED = kind(
    "recording.many-rejected",
    Severity.LOOK,
    "{lost} of the {beats} beats between the first and the last averaged were rejected",
    "Look at the beats, and choose a quieter stretch with `start` and `end`.",
)


def misshapen_beats(
    lengths: np.ndarray, pressure: np.ndarray, flow: np.ndarray, length_tolerance: float, least_correlation: float
) -> list[str]:
    """Return for every beat why its length or its shape is not that of the others, empty if it is.

    Parameters
    ----------
    lengths : float array, shape (beat,)
        s.
    pressure, flow : float array, shape (beat, sample)
        mmHg and ml/s.
    length_tolerance, least_correlation
        As in `average_beats`.
    """
    from scipy.ndimage import median_filter

    reasons = [""] * len(lengths)
    usual = median_filter(lengths, min(11, len(lengths)), mode="nearest")
    for i in np.flatnonzero(np.abs(lengths / usual - 1.0) > length_tolerance):
        reasons[i] = f"length {1e3 * lengths[i]:.1f} ms, {1e3 * usual[i]:.1f} ms around it"
    for name, beats in (("pressure", pressure), ("flow", flow)):
        alike = _correlation(beats, np.median(beats, axis=0))
        for i in np.flatnonzero(~(alike >= least_correlation)):
            reasons[i] = reasons[i] or f"correlation of {name} {alike[i]:.2f} with the median beat"
    return reasons


def mark_steps(reasons: list[str], first_beats: list[int]) -> None:
    """Reject the beats before and after which the level jumped; `first_beats` stand at a new level."""
    for first in first_beats:
        for beat in (first - 1, first):
            reasons[beat] = reasons[beat] or "step of the pressure"


def mark_inspiration(reasons: list[str], pressure: np.ndarray, flow: np.ndarray) -> None:
    """Reject the beats whose mean stands off the end-expiratory level; the drift is to be removed before."""
    for name, beats, unit in (("pressure", pressure, "mmHg"), ("flow", flow, "ml/s")):
        off, limit = _off_level(beats.mean(axis=1))
        for i in np.flatnonzero(np.abs(off) > limit):
            reasons[i] = reasons[i] or f"ventilation: mean {name} {off[i]:+.3g} {unit} from end-expiration"


def choose_run(reasons: list[str], beats: int, source: str) -> tuple[np.ndarray, range]:
    """Return the indices of the beats to average, and the run of beats they come from."""
    good = np.array([i for i, reason in enumerate(reasons) if not reason], dtype=int)
    if len(good) < beats:
        kinds = Counter(reason.split(" ")[0].strip(":") for reason in reasons if reason)
        counted = ", ".join(f"{count} for {kind}" for kind, count in kinds.most_common())
        raise NumericalError(
            f"{source}: {len(good)} good beats of {len(reasons)}, {beats} wanted (rejected: {counted}); look at the "
            "beats, choose another stretch, relax the rules or average fewer"
        )
    first = int(np.argmin(good[beats - 1 :] - good[: len(good) - beats + 1]))
    used = good[first : first + beats]
    return used, range(int(used[0]), int(used[-1]) + 1)


def summarize(fiducial: str, reasons: list[str], beats: int, start: float, end: float) -> Finding:
    """Return which beats were averaged and how many were rejected for what."""
    kinds = Counter(reason.split(" ")[0].strip(":") for reason in reasons if reason)
    lost = ", ".join(f"{count} for {name}" for name, count in kinds.most_common()) or "none"
    by = "R wave" if fiducial == "ecg" else "foot of the pressure"
    return AVERAGED(beats=beats, start=start, end=end, by=by, found=len(reasons), rejected=lost)


def lost_in_run(reasons: list[str], run: range, beats: int) -> list[Finding]:
    """Return a finding if more beats of the averaged run were rejected than averaged."""
    lost = sum(bool(reasons[i]) for i in run)
    return [MANY_REJECTED(lost=lost, beats=len(run))] if lost > beats else []


def _correlation(beats: np.ndarray, median: np.ndarray) -> np.ndarray:
    centred, reference = beats - beats.mean(axis=1, keepdims=True), median - median.mean()
    scale = np.sqrt((centred**2).sum(axis=1) * (reference**2).sum())
    return np.divide(centred @ reference, scale, out=np.zeros(len(beats)), where=scale > 0)


def _off_level(means: np.ndarray) -> tuple[np.ndarray, float]:
    """Return how far each beat's mean stands off the end-expiratory level nearby, and what is too far.

    At end-expiration the level is a plateau, so its beats are the narrowest interval that holds a quarter of all; the
    rest of the plateau is judged by their scatter. Then the level is followed through the plateau's beats alone.
    """
    from scipy.ndimage import median_filter

    here = np.arange(len(means))
    plateau = here
    for _ in range(3):
        followed = median_filter(means[plateau], min(_BREATHS, len(plateau)), mode="nearest")
        level = means - np.interp(here, plateau, followed)
        middle, spread = _narrowest_quarter(level)
        plateau = np.flatnonzero(np.abs(level - middle) <= _OFF * spread)
    return level - middle, _OFF * spread


def _narrowest_quarter(level: np.ndarray) -> tuple[float, float]:
    """Return the middle of the narrowest interval with a quarter of the values, and the SD of a normal so narrow."""
    ordered = np.sort(level)
    count = max(2, (len(ordered) + 3) // 4)
    widths = ordered[count - 1 :] - ordered[: len(ordered) - count + 1]
    first = int(np.argmin(widths))
    middle = 0.5 * (ordered[first] + ordered[first + count - 1])
    return float(middle), 0.5 * float(widths[first]) / 0.319
