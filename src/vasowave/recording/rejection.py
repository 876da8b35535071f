"""The beats that may not be averaged, and the reasons: by their length, their shape, and the breath they fall into."""

from collections import Counter

import numpy as np

from vasowave.errors import NumericalError
from vasowave.findings import Finding, look_kind, note_kind

_BREATHS = 31
"""Beats over which the end-expiratory level is followed: three breaths or more."""

_OFF = 2.5
"""A beat further off the end-expiratory level than this many SD is one of inspiration."""

_NO_BREATH = 0.001
"""Levels that differ by less than this share of the signal's pulse show no breath, however quiet the others are."""


AVERAGED = note_kind(
    "recording.averaged",
    "mean of {beats} beats from {start:.3f} to {end:.3f} s, aligned by the {by}; {found} beats found, rejected: "
    "{rejected}",
)
MANY_REJECTED = look_kind(
    "recording.many-rejected",
    "{lost} of the {beats} beats between the first and the last averaged were rejected",
    "Look at the beats, and choose a quieter stretch with `start` and `end`.",
)
_LENGTH = note_kind("beat.length", "length {length:.1f} ms, {usual:.1f} ms around it")
_SHAPE = note_kind("beat.correlation", "correlation of {signal} {correlation:.2f} with the median beat")
_STEP = note_kind("beat.step", "step of the pressure")
_SETTLING = note_kind("beat.settling", "before the pressure settles")
_VENTILATION = note_kind("beat.ventilation", "ventilation: mean {signal} {off:+.3g} {unit} from end-expiration")

Rejection = Finding | None
"""Why a beat may not be averaged; None for a good one."""


def cause(reason: Finding) -> str:
    """Return what a beat was rejected for, in one word."""
    return reason.code.partition(".")[2]


def misshapen_beats(
    lengths: np.ndarray, pressure: np.ndarray, flow: np.ndarray, length_tolerance: float, least_correlation: float,
    shapes: tuple[np.ndarray, np.ndarray],
) -> list[Rejection]:  # fmt: skip
    """Return for every beat why its length or its shape is not that of the others, None if it is.

    Parameters
    ----------
    lengths : float array, shape (beat,)
        s.
    pressure, flow : float array, shape (beat, sample)
        mmHg and ml/s.
    length_tolerance, least_correlation
        As in `average_beats`.
    shapes : pair of float arrays, shape (sample,)
        Pressure and flow that the beats are compared with.
    """
    from scipy.ndimage import median_filter

    reasons: list[Rejection] = [None] * len(lengths)
    usual = median_filter(lengths, min(11, len(lengths)), mode="reflect")  # an odd first beat is no majority
    for i in np.flatnonzero(np.abs(lengths / usual - 1.0) > length_tolerance):
        reasons[i] = _LENGTH(length=1e3 * float(lengths[i]), usual=1e3 * float(usual[i]))
    for name, beats, shape in (("pressure", pressure, shapes[0]), ("flow", flow, shapes[1])):
        alike = _correlation(beats, shape)
        for i in np.flatnonzero(~(alike >= least_correlation)):
            reasons[i] = reasons[i] or _SHAPE(signal=name, correlation=float(alike[i]))
    return reasons


def mark_steps(reasons: list[Rejection], first_beats: list[int]) -> None:
    """Reject the beats before and after which the level jumped; `first_beats` stand at a new level.

    0, or the number of beats, is a step beside the beats.
    """
    for first in first_beats:
        for beat in (first - 1, first) if 0 < first < len(reasons) else ():
            reasons[beat] = reasons[beat] or _STEP()


def mark_settling(reasons: list[Rejection], beats: np.ndarray) -> None:
    """Reject the first beats, given by their numbers, whose level lies apart from that of all others."""
    for beat in beats:
        reasons[beat] = reasons[beat] or _SETTLING()


def mark_inspiration(
    reasons: list[Rejection], means: tuple[np.ndarray, np.ndarray], shapes: tuple[np.ndarray, np.ndarray]
) -> None:
    """Reject the beats whose mean pressure or flow stands off the end-expiratory level.

    Parameters
    ----------
    reasons : list of Finding or None
        Are added to.
    means : pair of float arrays, shape (beat,)
        Mean pressure, mmHg, its drift removed, and mean flow, ml/s.
    shapes : pair of float arrays, shape (sample,)
        The usual beat of both.
    """
    for name, mean, shape, unit in zip(("pressure", "flow"), means, shapes, ("mmHg", "ml/s"), strict=True):
        off, limit = _off_level(mean)
        limit = max(limit, _NO_BREATH * float(np.ptp(shape)))
        for i in np.flatnonzero(np.abs(off) > limit):
            reasons[i] = reasons[i] or _VENTILATION(signal=name, off=float(off[i]), unit=unit)


def choose_run(reasons: list[Rejection], beats: int, source: str) -> tuple[np.ndarray, range]:
    """Return the indices of the beats to average, and the run of beats they come from."""
    good = np.array([i for i, reason in enumerate(reasons) if not reason], dtype=int)
    if len(good) < beats:
        raise NumericalError(
            f"{source}: {len(good)} good beats of {len(reasons)}, {beats} wanted (rejected: {_counted(reasons)}); "
            "look at the beats (vasowave open), choose another stretch (start [s], end [s]) or average fewer "
            "(averaging.beats). Of an animal that breathes by itself, without a ventilator, or whose beats alternate, "
            "turn averaging.reject_ventilation off"
        )
    first = int(np.argmin(good[beats - 1 :] - good[: len(good) - beats + 1]))
    used = good[first : first + beats]
    return used, range(int(used[0]), int(used[-1]) + 1)


def summarize(fiducial: str, reasons: list[Rejection], beats: int, start: float, end: float) -> Finding:
    """Return which beats were averaged and how many were rejected for what."""
    by = "R wave" if fiducial == "ecg" else "foot of the pressure"
    return AVERAGED(beats=beats, start=start, end=end, by=by, found=len(reasons), rejected=_counted(reasons) or "none")


def _counted(reasons: list[Rejection]) -> str:
    causes = Counter(cause(reason) for reason in reasons if reason)
    return ", ".join(f"{count} for {name}" for name, count in causes.most_common())


def lost_in_run(reasons: list[Rejection], run: range, beats: int) -> list[Finding]:
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
        followed = median_filter(means[plateau], min(_BREATHS, len(plateau)), mode="reflect")
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
