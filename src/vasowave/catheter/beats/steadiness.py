"""Whether the animal stays the same while it is recorded: pulse and flow of its beats from the first to the last."""

from dataclasses import dataclass

import numpy as np

from vasowave.base.cures import AVERAGE_BREATHS, STRETCH, stretch
from vasowave.base.findings import Finding, look_kind
from vasowave.catheter.beats.cuts import Cuts


@dataclass(frozen=True)
class SteadinessRules:
    """What counts as an animal that changes, an average that is off its beats, and beats that alternate.

    Attributes
    ----------
    max_fall : float
        A pulse or a mean flow that is lower by more than this share in one stretch of the beats than in another is
        told.
    max_pulse_difference : float
        Averaged beats whose pulse is off that of all beats at the same part of the breath by more than this share is
        told.
    max_flow_difference : float
        Likewise their mean flow.
    min_beats : int
        Five in a stretch.
    stretch_share : float
        Share of the beats that a stretch has.
    stride_share : float
        Share of the beats by which the next one begins later.
    min_fall_sd : float
        Standard errors by which stretches differ.
    min_alternating_share : float
        Share of neighboring changes from beat to beat that go opposite ways where beats alternate; by chance it is 2/3.
    min_alternation : float
        Share of the pulse or the mean flow by which alternating beats differ.
    """

    max_fall: float = 0.14
    max_pulse_difference: float = 0.1
    max_flow_difference: float = 0.05
    min_beats: int = 20
    stretch_share: float = 0.25
    stride_share: float = 0.0625
    min_fall_sd: float = 4.0
    min_alternating_share: float = 0.9
    min_alternation: float = 0.05


RULES = SteadinessRules()


UNSTEADY = look_kind(
    "recording.unsteady",
    "{what} differs by {percent:.0f} % within the recording: {low:.3g} {unit} from {low_start:.3g} to {low_end:.3g} s, "
    "{high:.3g} {unit} from {high_start:.3g} to {high_end:.3g} s; the average is that of {start:.3g} to {end:.3g} s",
    "Choose the stretch that stands for the animal; where the probe lost its contact, leave the rest out.",
    stretch("{high_start:.3g}", "{high_end:.3g}"),
    stretch("{low_start:.3g}", "{low_end:.3g}"),
)
APART = look_kind(
    "recording.average-apart",
    "{what} of the averaged beats ({start:.3g} to {end:.3g} s) is {percent:+.0f} % off that of all beats like them",
    "Choose the stretch that stands for the animal.",
    STRETCH,
)
ALTERNATING = look_kind(
    "recording.alternating",
    "{what} alternates from beat to beat, by {percent:.0f} %; the averaged beats may be of one kind, and the others be "
    "called beats of inspiration. {remedy}",
    "Average over the breath, so that both kinds are averaged.",
    AVERAGE_BREATHS,
)


def unsteady(cut: Cuts, used: np.ndarray, alike: np.ndarray, start: float, end: float) -> list[Finding]:
    """Return findings where pulse pressure or mean flow change in the course of a recording, or alternate.

    Parameters
    ----------
    cut : Cuts
        Beats of usual length and shape in the order of time, those of inspiration among them.
    used : bool array, shape (beat,)
        Which are averaged.
    alike : bool array, shape (beat,)
        Which might be: those at end-expiration, unless the average is over the breath.
    start, end
        Between which instants they are, s.
    """
    courses = (
        ("the pulse pressure", "mmHg", np.ptp(cut.pressure, axis=1), RULES.max_pulse_difference),
        ("the mean flow", "ml/s", cut.flow.mean(axis=1), RULES.max_flow_difference),
    )
    findings = []
    for quantity, unit, values, limit in courses:
        if len(values) < RULES.min_beats or np.median(values) <= 0:
            continue
        findings += _differs(cut, values, what=quantity, unit=unit, start=start, end=end)
        findings += _alternates(values, quantity)
        off = float(np.mean(values[used]) / np.mean(values[alike | used]) - 1.0) if used.any() else 0.0  # kept by hand
        if abs(off) > limit:
            findings.append(APART(what=quantity, percent=100 * off, start=start, end=end))
    return findings


def _alternates(values: np.ndarray, quantity: str) -> list[Finding]:
    """Return a finding if every second beat is larger than the ones around it."""
    change = np.diff(values)
    size = float(np.median(np.abs(change)) / np.median(values))
    if size <= RULES.min_alternation or np.mean(change[1:] * change[:-1] < 0) <= RULES.min_alternating_share:
        return []
    return [ALTERNATING(what=quantity, percent=100 * size)]


def _differs(cut: Cuts, values: np.ndarray, **fields: str | float) -> list[Finding]:
    """Return a finding if the lowest and the highest median of a stretch differ by more than chance and the rules."""
    count = len(values)
    size, stride = max(5, round(RULES.stretch_share * count)), max(1, round(RULES.stride_share * count))
    begins = np.unique(np.append(np.arange(0, count - size, stride), count - size))
    stretches = np.array([values[begin : begin + size] for begin in begins])
    medians, errors = np.median(stretches, axis=1), stretches.std(axis=1) / np.sqrt(size)
    low, high = int(np.argmin(medians)), int(np.argmax(medians))
    fall = medians[high] - medians[low]
    if fall <= max(RULES.max_fall * medians[high], RULES.min_fall_sd * np.hypot(errors[low], errors[high])):
        return []
    where = {
        f"{name}_{side}": float(bounds[begins[index] + last])
        for name, index in (("low", low), ("high", high))
        for side, bounds, last in (("start", cut.starts, 0), ("end", cut.ends, size - 1))
    }
    levels = {"low": float(medians[low]), "high": float(medians[high])}
    return [UNSTEADY(percent=100 * fall / medians[high], **levels, **where, **fields)]
