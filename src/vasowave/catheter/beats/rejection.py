"""The beats that may not be averaged, and the reasons: by their length, their shape, and the breath they fall into."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from vasowave.base.cures import AVERAGE_BREATHS, STRETCH, Cure, SetSetting, Visit
from vasowave.base.errors import NumericalError
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.pulse.cycle.averaged import Rejection

_UNUSUAL_SHARE = 0.3
"""Of all beats: from here on rejections for length or shape ask for a look."""

_MAX_UNLIKE_SHARE = 0.45
"""Of all beats: where so many are unlike the others, more in length than in shape, none is usual; all are averaged."""

_MAX_MEAN_CHANGE = 0.02
"""Rejected beats with which mean flow, pressure or heart rate would change by so much ask for a look."""

_SHAPE_HARMONICS = 12
"""Shapes of beats are compared up to this harmonic; above there is noise."""

_MIN_BEAT_SHARE = 0.4
"""Of the beats that are wanted: with fewer good ones there is no average."""

AVERAGED = note_kind(
    "recording.averaged",
    "mean of {beats} beats from {start:.3f} to {end:.3f} s, aligned by the {by}; {found} beats found, rejected: "
    "{rejected}",
)
MANY_REJECTED = look_kind(
    "recording.many-rejected",
    "{lost} of the {beats} beats between the first and the last averaged were rejected",
    "Look at the beats, and choose a quieter stretch.",
    Visit("recording"),
    STRETCH,
)
FEW = look_kind(
    "recording.few-beats",
    "only {beats} good beats were found and averaged, {wanted} are wanted; errors count accordingly",
    "Choose a longer stretch, average over the breath where breaths reject most beats, or record longer.",
    STRETCH,
    AVERAGE_BREATHS,
)
MANY_UNUSUAL = look_kind(
    "recording.unusual-beats",
    "{percent:.0f} % of all beats were rejected as unusual ({rejected}), and are not in the average: with them the "
    "mean flow is {flow:.3g} ml/s ({flow_percent:+.0f} %), the mean pressure {pressure:.3g} mmHg "
    "({pressure_percent:+.0f} %), the heart rate {rate:.0f} beats/min ({rate_percent:+.0f} %)",
    "Look at the beats: if the rhythm has long, short or empty ones, these numbers are the animal's over time.",
    Visit("recording"),
)
OVER_BREATHS = look_kind(
    "recording.over-breaths",
    "only {good} beats stand at end-expiration, so that beats of all parts of the breath were averaged; the mean "
    "pressure may be off that of end-expiration by {error:.2g} mmHg, the scatter of the beats",
    "Record longer.",
)
OVER_RHYTHM = look_kind(
    "recording.over-rhythm",
    "only {good} beats are alike and at end-expiration, so that all {beats} were averaged, each by the time that it "
    "lasts: mean pressure, flow and heart rate are those over time and breaths, but the cycle has no beat's shape, so "
    "that its pulse, its impedance and all that fits find of walls and waves are not the animal's",
    "Use the means alone, or choose a stretch in which beats are alike.",
    STRETCH,
)
_LENGTH_CAUSE = note_kind("beat.length", "length {length:.1f} ms, {usual:.1f} ms around it")
_SHAPE_CAUSE = note_kind("beat.correlation", "correlation of {signal} {correlation:.2f} with the median beat")
_STEP_CAUSE = note_kind("beat.step", "step of the pressure")
_SETTLING_CAUSE = note_kind("beat.settling", "before the pressure settles")


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
        As in `Averaging`.
    shapes : pair of float arrays, shape (sample,)
        Pressure and flow that the beats are compared with.
    """
    from scipy.ndimage import median_filter

    reasons: list[Rejection] = [None] * len(lengths)
    usual = median_filter(lengths, min(11, len(lengths)), mode="reflect")  # an odd first beat is no majority
    for i in np.flatnonzero(np.abs(lengths / usual - 1.0) > length_tolerance):
        reasons[i] = _LENGTH_CAUSE(length=1e3 * float(lengths[i]), usual=1e3 * float(usual[i]))
    for name, beats, shape in (("pressure", pressure, shapes[0]), ("flow", flow, shapes[1])):
        alike = _correlation(beats, shape)
        for i in np.flatnonzero(~(alike >= least_correlation)):
            reasons[i] = reasons[i] or _SHAPE_CAUSE(signal=name, correlation=float(alike[i]))
    return reasons


def mark_steps(reasons: list[Rejection], first_beats: list[int]) -> None:
    """Reject the beats before and after which the level jumped; `first_beats` stand at a new level.

    0, or the number of beats, is a step beside the beats.
    """
    for first in first_beats:
        for beat in (first - 1, first) if 0 < first < len(reasons) else ():
            reasons[beat] = reasons[beat] or _STEP_CAUSE()


def mark_settling(reasons: list[Rejection], beats: np.ndarray) -> None:
    """Reject the first beats, given by their numbers, whose level lies apart from that of all others."""
    for beat in beats:
        reasons[beat] = reasons[beat] or _SETTLING_CAUSE()


def fewest(beats: int) -> int:
    """Return how many good beats make an average where so many are wanted: two fifths of them, eight of 20."""
    return max(2, int(np.ceil(_MIN_BEAT_SHARE * beats)))


def relax_criteria(reasons: list[Rejection], beats: int) -> tuple[list[Rejection], set[str]]:
    """Return reasons that leave enough beats, and which causes were passed over: the breath, or length and shape, too.

    Of beats that are unlike more often in shape than in length none are let in: that is no rhythm.
    """
    causes = [cause(reason) if reason else "" for reason in reasons]
    by_length, by_shape = causes.count("length"), causes.count("correlation")
    options: list[set[str]] = [set(), {"ventilation"}]
    if by_length >= by_shape:
        options = options[: 2 * (by_length + by_shape < _MAX_UNLIKE_SHARE * len(causes))]
        options.append({"ventilation", "length", "correlation"})
    for over in options:
        remaining = [None if code in over else reason for code, reason in zip(causes, reasons, strict=True)]
        if remaining.count(None) >= fewest(beats):
            return remaining, over
    return reasons, set()


_FEW_GOOD: tuple[Cure, ...] = (
    Visit("recording"),
    STRETCH,
    SetSetting("Average 10 beats", "averaging.beats", "10"),
    AVERAGE_BREATHS,
)


def relaxation_findings(over: set[str], good: int, beats: int, error: float) -> list[Finding]:
    """Return what is said where causes were passed over as only so many beats are good; error of the mean, mmHg."""
    if "length" in over:
        return [OVER_RHYTHM(good=good, beats=beats)]
    return [OVER_BREATHS(good=good, error=error)] if over else []


def choose_run(
    reasons: list[Rejection], beats: int, source: str, noticed: Sequence[Finding] = (),
    levels: np.ndarray | None = None,
) -> tuple[np.ndarray, range]:  # fmt: skip
    """Return the indices of the beats to average, and the run they come from; errors tell what was noticed.

    Of equal runs the first is taken; with `levels` of all beats, shape (quantity, beat), the one that has their means.
    """
    good = np.array([i for i, reason in enumerate(reasons) if not reason], dtype=int)
    if len(good) < fewest(beats):
        raise NumericalError(
            f"{source}: {len(good)} good beats of {len(reasons)}, {beats} wanted (rejected: {_counted(reasons)}); "
            "look at the beats, choose another stretch or average fewer. Of an animal that breathes by itself, without "
            "a ventilator, or whose beats alternate, average over the breath"
            f"{''.join(f'. Besides, {remark}' for remark in noticed)}",
            _FEW_GOOD,
        )
    beats = min(beats, len(good))
    spans = good[beats - 1 :] - good[: len(good) - beats + 1]
    equals = np.flatnonzero(spans == spans.min())
    first = int(equals[0] if levels is None else equals[np.argmin(_off_means(levels[:, good], beats)[equals])])
    used = good[first : first + beats]
    return used, range(int(used[0]), int(used[-1]) + 1)


def _off_means(levels: np.ndarray, beats: int) -> np.ndarray:
    """Return how far the means of each run of beats are off those of all, in SD of the beats, shape (run,)."""
    runs = np.lib.stride_tricks.sliding_window_view(levels, beats, axis=1).mean(axis=2)
    off = (runs - levels.mean(axis=1, keepdims=True)) / np.maximum(levels.std(axis=1, keepdims=True), 1e-300)
    return np.abs(off).max(axis=0)


def summarize(
    fiducial: str, reasons: list[Rejection], beats: int, requested: int, start: float, end: float
) -> list[Finding]:  # fmt: skip
    """Return which beats were averaged, how many were rejected for what, and whether they are few."""
    by = "R wave" if fiducial == "ecg" else "foot of the pressure"
    rejected = _counted(reasons) or "none"
    findings = [AVERAGED(beats=beats, start=start, end=end, by=by, found=len(reasons), rejected=rejected)]
    return [*findings, FEW(beats=beats, wanted=requested)] if beats < requested else findings


def _counted(reasons: list[Rejection]) -> str:
    causes = Counter(cause(reason) for reason in reasons if reason)
    return ", ".join(f"{count} for {name}" for name, count in causes.most_common())


def lost_in_run(reasons: list[Rejection], run: range, beats: int) -> list[Finding]:
    """Return a finding if more beats of the averaged run were rejected than averaged, those of breaths set apart.

    Every stretch has breaths; what they do to the means is said elsewhere.
    """
    lost = sum(reason is not None and cause(reason) != "ventilation" for reason in reasons[run.start : run.stop])
    return [MANY_REJECTED(lost=lost, beats=len(run))] if lost > beats else []


def unusual_beats(
    reasons: list[Rejection], lengths: np.ndarray, means: tuple[np.ndarray, np.ndarray]
) -> tuple[list[Finding], np.ndarray]:  # fmt: skip
    """Return how far the beats rejected for length or shape move mean pressure, mmHg, and mean flow, ml/s.

    A finding comes with it if these beats are many, or would change mean values or heart rate.

    Parameters
    ----------
    reasons : list of Finding or None
    lengths : float array, shape (beat,)
        Of all beats, s.
    means : pair of float arrays, shape (beat,)
        Mean pressure, mmHg, and mean flow, ml/s, of all beats.
    """
    unusual = [reason if reason and cause(reason) in ("length", "correlation") else None for reason in reasons]
    usual = np.array([reason is None for reason in unusual])
    if usual.all() or not usual.any():
        return [], np.zeros(2)
    pressure, flow = (float(values @ lengths / lengths.sum()) for values in means)
    rate = 60.0 / float(lengths.mean())
    of_usual = [float(values[usual] @ lengths[usual] / lengths[usual].sum()) for values in means]
    moves = np.array([pressure - of_usual[0], flow - of_usual[1]])
    changes = [*(moves / of_usual), lengths[usual].mean() / lengths.mean() - 1.0]
    if usual.mean() >= 1.0 - _UNUSUAL_SHARE and max(map(abs, changes)) <= _MAX_MEAN_CHANGE:
        return [], moves
    names = ("pressure_percent", "flow_percent", "rate_percent")
    finding = MANY_UNUSUAL(
        percent=100 * float(1 - usual.mean()), rejected=_counted(unusual), pressure=pressure, flow=flow, rate=rate,
        **{name: 100 * float(change) for name, change in zip(names, changes, strict=True)},
    )  # fmt: skip
    return [finding], moves


def _correlation(beats: np.ndarray, median: np.ndarray) -> np.ndarray:
    """Return how far beats go with the median beat up to harmonic `_SHAPE_HARMONICS`, shape (beat,)."""
    spectra, usual = (np.fft.rfft(values)[..., 1 : _SHAPE_HARMONICS + 1] for values in (beats, median))
    scale = np.sqrt((np.abs(spectra) ** 2).sum(axis=1) * (np.abs(usual) ** 2).sum())
    return np.divide((spectra @ usual.conj()).real, scale, out=np.zeros(len(beats)), where=scale > 0)
