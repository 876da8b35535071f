"""The baseline of a continuous pressure: the drift of its diastolic level, told apart from breaths and from the animal.

A transducer that warms up or a catheter that clots shifts the pressure and nothing else. Breaths return; a step of an
instrument is over within a beat; and a pressure that the animal changes itself comes with another pulse or flow.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vasowave.base.cures import STRETCH, ZERO_TIME
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.catheter.baseline.breaths import breathing
from vasowave.catheter.baseline.smooth import Curve, smooth_curve
from vasowave.catheter.beats.cuts import Cuts
from vasowave.catheter.signals.channels import Comment
from vasowave.catheter.signals.interventions import near
from vasowave.pulse.cycle.trend import RULES, Baseline, LevelStep, Settling

STEADY = note_kind("baseline.steady", "baseline: the diastolic level is steady within {within:.2g} mmHg")
_DRIFT_TEXT = (
    "baseline: the diastolic level drifts by {size:+.2g} ± {error:.1g} mmHg from {zero:.3g} to {far:.3g} s, breaths "
    "set apart ({here:+.2g} mmHg in the averaged beats); {done}. The zero is taken to be right at {zero:.3g} s"
)
_STEP_TEXT = "baseline: a step of {height:+.2g} mmHg at {time:.4g} s within one beat: {whose}; {done}"
_ZERO_REMEDY = "Say when the zero was right, or average a shorter stretch."
DRIFTS = look_kind("baseline.drifts", _DRIFT_TEXT, _ZERO_REMEDY, ZERO_TIME, STRETCH)
DRIFTS_LITTLE = note_kind("baseline.drifts-little", _DRIFT_TEXT)
STEPS = look_kind("baseline.steps", _STEP_TEXT, _ZERO_REMEDY, ZERO_TIME, STRETCH)
STEPS_LITTLE = note_kind("baseline.steps-little", _STEP_TEXT)
SETTLES = look_kind(
    "baseline.settles",
    "baseline: the level begins {height:+.2g} mmHg off that of all beats after {until:.3g} s, as when a catheter "
    "settles; the beats before are left out, and the zero is taken to be right after them. The difference counts as an "
    "error of the mean pressure",
    "Say when the zero was right.",
    ZERO_TIME,
)
ZERO_WITHIN = look_kind(
    "baseline.zero-within",
    "baseline: at {zero:.3g} s, where the zero is taken to be right, the level lies {height:.2g} mmHg {side} that of "
    "before and after, as when something passes; the pressures of all beats are moved by that",
    "Say another instant at which the zero was right.",
    ZERO_TIME,
)
CHANGED_BESIDE = look_kind(
    "baseline.changed-beside",
    "baseline: beside the stretch that is read the level moves, and with it {what}, as when the animal itself changes; "
    "the drift is judged in this stretch alone, and the zero is taken to be right at {zero:.3g} s",
    _ZERO_REMEDY,
    ZERO_TIME,
    STRETCH,
)


def baseline_findings(
    baseline: Baseline, first: float, last: float, comments: Sequence[Comment] = ()
) -> list[Finding]:  # fmt: skip
    """Return the drift, what was done about it, and its size in the beats averaged from first to last."""
    peak_time = float(baseline.time[np.argmax(np.abs(baseline.trend))])
    findings = [CHANGED_BESIDE(what=baseline.elsewhere, zero=baseline.zero)] if baseline.elsewhere else []
    if baseline.settling and baseline.settling.error:
        findings.append(SETTLES(until=baseline.settling.until, height=baseline.settling.height))
    if not baseline.sure:
        return [*findings, STEADY(within=float(max(abs(baseline.size), baseline.error)))]
    done = "removed" if baseline.removed else "left in"
    if baseline.own:
        done += f" because with it {baseline.own}, as when the animal itself changes; average a shorter stretch"
    if not baseline.removed:
        done += "; it counts as an error of the mean pressure"
    drifts, steps = (DRIFTS, STEPS) if baseline.alarming else (DRIFTS_LITTLE, STEPS_LITTLE)
    drift = drifts(
        size=float(baseline.size), error=float(baseline.error), zero=baseline.zero, far=peak_time,
        here=float(baseline.mean_drift(first, last)), done=done,
    )  # fmt: skip
    step_findings = (
        steps(height=float(step.height), time=float(step.time), whose=_whose(step, comments), done=done)
        for step in baseline.steps
    )
    return [*findings, drift, *_zero_within(baseline), *step_findings]


def _zero_within(baseline: Baseline) -> list[Finding]:
    """Return a finding if the instant of the zero stands within what passes: most levels on both sides are alike."""
    sides = [baseline.trend[side] for side in (baseline.time < baseline.zero, baseline.time > baseline.zero)]
    if not baseline.removed or min(map(len, sides)) < RULES.side_beats:
        return []
    before, after = (float(np.median(trend)) for trend in sides)
    if before * after <= 0 or min(abs(before), abs(after)) < max(RULES.min_size, abs(before - after)):
        return []
    height = 0.5 * (before + after)
    return [ZERO_WITHIN(zero=baseline.zero, height=abs(height), side="below" if height > 0 else "above")]


def _whose(step: LevelStep, comments: Sequence[Comment]) -> str:
    """Say who made a step: an instrument, or perhaps the animal where a comment stands beside it."""
    comment = near(comments, step.time)
    if comment is None:
        return "an instrument's (its zero or calibration), not the animal's"
    return f"beside the comment '{comment.text}' at {comment.time:.4g} s, so that it may be the animal's"


def with_comments(baseline: Baseline, comments: Sequence[Comment]) -> Baseline:
    """Return the baseline, whose steps beside a comment may be the animal's own."""
    comment = next(
        (candidate for candidate in (near(comments, step.time) for step in baseline.steps) if candidate), None
    )
    if baseline.own or comment is None:
        return baseline
    return replace(baseline, own=f"'{comment.text}' is noted at {comment.time:.4g} s")


def find_baseline(cuts: Cuts, usual: np.ndarray, good: np.ndarray, zero_time: float | None) -> Baseline:
    """Return the trend of the diastolic level, from beats cut to equal numbers of samples.

    Level = smooth trend + breaths + steps + scatter; steps are added one by one while one stands out.

    Parameters
    ----------
    cuts : Cuts
    usual : float array, shape (sample,)
        The median beat of the pressure, mmHg.
    good : bool array, shape (beat,)
        Beats whose length and shape are usual.
    zero_time : float, optional
        The instant at which the transducer's zero is taken to be right, s; by default the start of the recording, and
        first beats that lie apart from all others do not count.
    """
    starts, ends, pressure, flow = cuts
    if good.sum() < RULES.min_beats:
        none = np.zeros(len(starts))
        return Baseline(0.5 * (starts + ends), pressure.min(axis=1), none, (), np.inf, zero_time or 0.0)
    low = np.argsort(usual)[: max(2, int(RULES.low_share * pressure.shape[1]))]
    level = pressure[:, low].mean(axis=1)
    time = starts + (ends - starts) * low.mean() / (pressure.shape[1] - 1)
    settling = _settling(time, level, good) if zero_time is None else None
    good = good & (time >= settling.until) if settling else good.copy()
    zero_time = settling.until if settling and settling.error else _known_zero(zero_time or 0.0, time[good])
    first: list[int] = []
    while True:
        shifts = (np.arange(len(time))[:, None] >= np.array(first, dtype=int)).astype(float)
        breathless, curve = _without_breaths(time, level, good, shifts, zero_time)
        step = _sharpest_step(time, breathless - shifts @ curve.extra, good)
        if step is None or len(first) == RULES.max_steps:
            break
        first.append(step)
        good[step - 1 : step + 1] = False  # one of the two stands between the levels
    times = np.array([0.5 * (time[index - 1] + time[index]) for index in first])
    trend = curve.values + shifts @ curve.extra - curve.at_anchor - float((times <= zero_time) @ curve.extra)
    largest = int(np.argmax(np.abs(trend)))
    own_change = ""
    if first or abs(trend[largest]) > RULES.sure * curve.error[largest]:
        own_change = _own_change(pressure[good], flow[good], trend[good])
    steps = (LevelStep(float(t), float(h)) for t, h in sorted(zip(times, curve.extra, strict=True)))
    persistence = _persistence((breathless - curve.values - shifts @ curve.extra)[good])
    return Baseline(
        time, level, trend, tuple(steps), float(curve.error[largest]), zero_time, own_change, settling=settling,
        persistence=persistence, errors=curve.error,
    )  # fmt: skip


def _settling(time: np.ndarray, level: np.ndarray, good: np.ndarray) -> Settling | None:
    """Return how the first beats lie apart from the level of all others carried back to them; None if none does.

    What is carried back is as wrong as the breaths and the drift make it: the same is tried from later beats on.
    """
    time, level = time[good], level[good]
    if len(time) < 6 * RULES.side_beats or max(
        RULES.first_seconds, time[RULES.side_beats] - time[0]
    ) > RULES.reach * np.ptp(time):
        return None
    distance, settling = _begins_apart(time, level)
    if distance < RULES.min_size:
        return None
    later = np.linspace(np.searchsorted(time, settling.until), RULES.later * len(time), 8).astype(int)
    usual = max(_begins_apart(time[index:], level[index:])[0] for index in later)
    return settling if distance > RULES.beyond * usual else None


def _begins_apart(time: np.ndarray, level: np.ndarray) -> tuple[float, Settling]:
    """Return how far, mmHg, a first of good beats surely lies from the level of the others carried back to it, and how.

    Carried back, the level follows the drift; the height that is told is that above the level where the others begin.
    """
    later = (time >= time[0] + RULES.first_seconds) & (np.arange(len(time)) >= RULES.side_beats)
    until = float(time[later][0])
    breathless, curve = _without_breaths(time, level, later, np.zeros((len(time), 0)), until)
    residual = np.where(later, 0.0, np.abs(breathless - curve.values))
    residual[residual < RULES.sure * curve.error] = 0.0
    return float(residual.max()), Settling(until, float(breathless[0] - curve.at_anchor))


def _known_zero(zero_time: float, instants: np.ndarray) -> float:
    """Return the instant of the zero, or the known instant nearest to it where a trend cannot be carried so far."""
    nearest = float(np.clip(zero_time, instants[0], instants[-1]))
    return zero_time if abs(zero_time - nearest) <= RULES.reach * np.ptp(instants) else nearest


def _without_breaths(
    time: np.ndarray, level: np.ndarray, good: np.ndarray, shifts: np.ndarray, zero_time: float
) -> tuple[np.ndarray, Curve]:
    """Return the levels without what returns with the breaths, and the curve through them."""
    breathless = level
    spacing = max(RULES.knot_seconds, RULES.knot_beats * float(np.median(np.diff(time))))
    for _ in range(2):
        curve = smooth_curve(time, breathless, good, spacing, zero_time, shifts)
        breathless = level - breathing(time, level - curve.values - shifts @ curve.extra, good)
    curve = smooth_curve(time, breathless, good, spacing, zero_time, shifts)
    residual = (breathless - curve.values - shifts @ curve.extra)[good]
    return breathless, curve._replace(error=curve.error * _persistence(residual))


def _persistence(residual: np.ndarray) -> float:
    """Return by how much the error of a mean is larger than of white scatter: that of an AR(1) process."""
    residual = residual - residual.mean()
    power = float(residual @ residual)
    correlation = float(residual[1:] @ residual[:-1]) / power if power > 0 else 0.0
    correlation = min(max(correlation + 1.0 / len(residual), 0.0), 0.9)  # a mean that was taken off lowers it by this
    return float(np.sqrt((1.0 + correlation) / (1.0 - correlation)))


def _sharpest_step(time: np.ndarray, level: np.ndarray, good: np.ndarray) -> int | None:
    """Return the first beat after the sharpest step, None if no step stands out.

    A straight line with a step in its middle is fitted to every window of 16 good beats; a step has to stand out from
    the scatter and from all other windows. Over a gap the line goes on, and a step is the less sure the longer it is.
    """
    beats = np.flatnonzero(good)
    if len(beats) < 4 * RULES.side_beats:
        return None
    place = np.arange(2 * RULES.side_beats) - RULES.side_beats + 0.5
    design = np.stack([np.ones(2 * RULES.side_beats), place, place > 0], axis=1)
    weights = np.linalg.pinv(design)[2]
    heights = np.correlate(level[beats], weights, "valid")
    lasts = time[beats[2 * RULES.side_beats - 1 :]] - time[beats[: len(heights)]]
    for window in np.flatnonzero(lasts > RULES.gap * np.median(lasts)):
        window_beats = beats[window : window + 2 * RULES.side_beats]
        design[:, 1] = time[window_beats] - time[window_beats].mean()
        projection = np.linalg.pinv(design)[2]
        heights[window] = projection @ level[window_beats] * np.linalg.norm(weights) / np.linalg.norm(projection)
    scatter = np.median(np.abs(np.diff(level[beats]))) / 0.954
    usual = max(float(np.median(np.abs(heights))) / 0.6745, float(scatter * np.linalg.norm(weights)))
    best = int(np.argmax(np.abs(heights)))
    if abs(heights[best]) < max(RULES.stands_out * usual, RULES.min_size):
        return None
    return int(beats[best + RULES.side_beats])


def _own_change(pressure: np.ndarray, flow: np.ndarray, trend: np.ndarray) -> str:
    """Say whether pulse or flow changes with the level, which a transducer's drift cannot do."""
    centred = pressure - pressure.mean(axis=1, keepdims=True)
    usual = np.median(centred, axis=0)
    quantities = {"the pulse": centred @ usual / (usual @ usual), "the flow": flow.mean(axis=1)}
    design = np.stack([np.ones(len(trend)), trend / np.abs(trend).max()], axis=1)
    inverse = np.linalg.pinv(design)
    changes = []
    for name, values in quantities.items():
        values = values / np.median(values)
        fitted = inverse @ values
        error = np.std(values - design @ fitted) * np.linalg.norm(inverse[1])
        if abs(fitted[1]) > max(RULES.own_change, RULES.sure * error):
            changes.append(f"{name} changes by {100 * np.sign(trend[np.argmax(np.abs(trend))]) * fitted[1]:+.0f} %")
    return " and ".join(changes)
