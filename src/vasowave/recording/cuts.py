"""The beats of a continuous recording cut out, and brought to one diastolic level."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vasowave.recording.baseline import Baseline, find_baseline
from vasowave.recording.raw import RawRecording
from vasowave.recording.rejection import mark_inspiration, mark_steps
from vasowave.recording.waveform import cut_beats


class Cuts(NamedTuple):
    """Beats cut from a recording: times of start and end, s, and their samples, shape (beat, sample), end included."""

    starts: np.ndarray
    ends: np.ndarray
    pressure: np.ndarray
    flow: np.ndarray


def cut_all(raw: RawRecording, times: np.ndarray, samples: int) -> Cuts:
    """Return all beats of a recording, from one of `times` to the next, brought to `samples` and one more."""
    pressure, flow = (cut_beats(one, raw.sampling_rate, times, samples + 1) for one in (raw.pressure, raw.flow))
    return Cuts(times[:-1], times[1:], pressure, flow)


def levelled(
    cut: Cuts, reasons: list[str], zero_time: float, remove: bool, reject_ventilation: bool
) -> tuple[Cuts, Baseline]:
    """Return the beats with their drift removed, if it may be, and the baseline; more reasons to reject are added."""
    good = ~np.array([bool(reason) for reason in reasons])
    baseline = find_baseline(cut.starts, cut.ends, cut.pressure, cut.flow, good, zero_time)
    within = np.linspace(0, 1, cut.pressure.shape[1])
    level = cut.pressure - baseline.drift_at(cut.starts[:, None] + np.outer(cut.ends - cut.starts, within))
    mark_steps(reasons, [step.beat for step in baseline.steps])
    if reject_ventilation:
        mark_inspiration(reasons, level, cut.flow)
    if remove and baseline.sure and not baseline.own:
        return cut._replace(pressure=level), replace(baseline, removed=True)
    return cut, baseline
