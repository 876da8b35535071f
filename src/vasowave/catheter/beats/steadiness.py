"""Whether the animal stays the same while it is recorded: pulse and flow of its beats from the first to the last."""

import numpy as np

from vasowave.base.findings import Finding, look_kind
from vasowave.catheter.beats.cuts import Cuts

_CHANGES = 0.14
"""A pulse or a mean flow that is lower by more than this share in one stretch of the beats than in another is told."""

_PULSE_APART, _FLOW_APART = 0.1, 0.05
"""Averaged beats whose pulse or mean flow is off that of all beats by more than this share are told: breaths alone, of
which the average takes one part, make 6 % of the pulse."""

_FEWEST = 20  # beats: five in a stretch
_STRETCH, _STRIDE = 0.25, 0.0625  # of the beats that a stretch has, and by which the next one begins later
_SURE = 4.0  # standard errors

_ALTERNATES = 0.9
"""Share of neighboring changes from beat to beat that go opposite ways where beats alternate; by chance it is 2/3."""

_UNLIKE = 0.05  # of the pulse or the mean flow, by which alternating beats differ

UNSTEADY = look_kind(
    "recording.unsteady",
    "{what} differs by {percent:.0f} % within the recording: {low:.3g} {unit} from {low_start:.3g} to {low_end:.3g} s, "
    "{high:.3g} {unit} from {high_start:.3g} to {high_end:.3g} s; the average is that of {start:.3g} to {end:.3g} s",
    "Choose with `start` and `end` the stretch that stands for the animal; where the probe lost its contact, leave the "
    "rest out.",
)
APART = look_kind(
    "recording.average-apart",
    "{what} of the averaged beats ({start:.3g} to {end:.3g} s) is {percent:+.0f} % off that of all beats",
    "Choose with `start` and `end` the stretch that stands for the animal.",
)
ALTERNATING = look_kind(
    "recording.alternating",
    "{what} alternates from beat to beat, by {percent:.0f} %; the averaged beats may be of one kind, and the others be "
    "called beats of inspiration. {remedy}",
    "Turn off averaging.reject_ventilation, so that both kinds are averaged.",
)


def unsteady(cut: Cuts, used: np.ndarray, start: float, end: float) -> list[Finding]:
    """Return findings where pulse pressure or mean flow change in the course of a recording, or alternate.

    Parameters
    ----------
    cut : Cuts
        Beats of usual length and shape in the order of time, those of inspiration among them.
    used : bool array, shape (beat,)
        Which are averaged.
    start, end
        Between which instants they are, s.
    """
    courses = (
        ("the pulse pressure", "mmHg", np.ptp(cut.pressure, axis=1), _PULSE_APART),
        ("the mean flow", "ml/s", cut.flow.mean(axis=1), _FLOW_APART),
    )
    findings = []
    for quantity, unit, values, limit in courses:
        if len(values) < _FEWEST or np.median(values) <= 0:
            continue
        findings += _differs(cut, values, what=quantity, unit=unit, start=start, end=end)
        findings += _alternates(values, quantity)
        off = float(np.mean(values[used]) / np.mean(values) - 1.0) if used.any() else 0.0  # all kept by hand
        if abs(off) > limit:
            findings.append(APART(what=quantity, percent=100 * off, start=start, end=end))
    return findings


def _alternates(values: np.ndarray, quantity: str) -> list[Finding]:
    """Return a finding if every second beat is larger than the ones around it."""
    change = np.diff(values)
    size = float(np.median(np.abs(change)) / np.median(values))
    if size <= _UNLIKE or np.mean(change[1:] * change[:-1] < 0) <= _ALTERNATES:
        return []
    return [ALTERNATING(what=quantity, percent=100 * size)]


def _differs(cut: Cuts, values: np.ndarray, **fields: str | float) -> list[Finding]:
    """Return a finding if the lowest and the highest median of a stretch differ by more than chance and `_CHANGES`."""
    count = len(values)
    size, stride = max(5, round(_STRETCH * count)), max(1, round(_STRIDE * count))
    begins = np.unique(np.append(np.arange(0, count - size, stride), count - size))
    stretches = np.array([values[begin : begin + size] for begin in begins])
    medians, errors = np.median(stretches, axis=1), stretches.std(axis=1) / np.sqrt(size)
    low, high = int(np.argmin(medians)), int(np.argmax(medians))
    fall = medians[high] - medians[low]
    if fall <= max(_CHANGES * medians[high], _SURE * np.hypot(errors[low], errors[high])):
        return []
    where = {
        f"{name}_{side}": float(bounds[begins[index] + last])
        for name, index in (("low", low), ("high", high))
        for side, bounds, last in (("start", cut.starts, 0), ("end", cut.ends, size - 1))
    }
    levels = {"low": float(medians[low]), "high": float(medians[high])}
    return [UNSTEADY(percent=100 * fall / medians[high], **levels, **where, **fields)]
