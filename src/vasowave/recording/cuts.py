"""The beats of a continuous recording cut out, and brought to one diastolic level."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vasowave.errors import VasowaveError
from vasowave.recording.baseline import Baseline, find_baseline
from vasowave.recording.beats import find_beats
from vasowave.recording.raw import RawRecording
from vasowave.recording.rejection import Rejection, mark_inspiration, mark_steps, misshapen_beats
from vasowave.recording.waveform import cut_beats


class Cuts(NamedTuple):
    """Beats cut from a recording: times of start and end, s, and their samples, shape (beat, sample), end included."""

    starts: np.ndarray
    ends: np.ndarray
    pressure: np.ndarray
    flow: np.ndarray

    def chosen(self, which: np.ndarray) -> "Cuts":
        """Return some of the beats, by number or by truth."""
        return Cuts(*(part[which] for part in self))


def cut_all(raw: RawRecording, times: np.ndarray, samples: int) -> Cuts:
    """Return all beats of a recording, from one of `times` to the next, brought to `samples` and one more."""
    since = times - raw.origin
    pressure, flow = (cut_beats(one, raw.sampling_rate, since, samples + 1) for one in (raw.pressure, raw.flow))
    return Cuts(times[:-1], times[1:], pressure, flow)


def cut_beside(
    raw: RawRecording, cut: Cuts, fiducial: str, heart_rates: tuple[float, float], length_tolerance: float,
    least_correlation: float,
) -> Cuts:  # fmt: skip
    """Return the beats beside the stretch that is read whose length is usual and whose shape is that of its beats."""
    shapes = (np.median(cut.pressure, axis=0), np.median(cut.flow, axis=0))
    found = [Cuts(*(part[:0] for part in cut))]
    for stretch in raw.beside:
        try:
            times = find_beats(stretch, fiducial, heart_rates).times
        except VasowaveError:  # nothing beats there
            continue
        if len(times) > 1:
            beats = cut_all(stretch, times, cut.pressure.shape[1] - 1)
            lengths = beats.ends - beats.starts
            reasons = misshapen_beats(lengths, beats.pressure, beats.flow, length_tolerance, least_correlation, shapes)
            found.append(beats.chosen(~np.array([bool(reason) for reason in reasons])))
    return Cuts(*(np.concatenate(parts) for parts in zip(*found, strict=True)))


def levelled(
    cut: Cuts, beside: Cuts, reasons: list[Rejection], zero_time: float, remove: bool, reject_ventilation: bool
) -> tuple[Cuts, Baseline]:
    """Return the beats with their drift removed, if it may be, and the baseline; more reasons to reject are added."""
    baseline = _baseline(cut, ~np.array([bool(reason) for reason in reasons]), beside, zero_time)
    within = np.linspace(0, 1, cut.pressure.shape[1])
    level = cut.pressure - baseline.drift_at(cut.starts[:, None] + np.outer(cut.ends - cut.starts, within))
    here = baseline.time[np.searchsorted(baseline.time, cut.starts)]
    mark_steps(reasons, [int(np.searchsorted(here, step.time)) for step in baseline.steps])
    if reject_ventilation:
        mark_inspiration(reasons, level, cut.flow)
    if remove and baseline.sure and not baseline.own:
        return cut._replace(pressure=level), replace(baseline, removed=True)
    return cut, baseline


def _baseline(cut: Cuts, good: np.ndarray, beside: Cuts, zero_time: float) -> Baseline:
    """Return the baseline over the whole recording; over the stretch alone where the animal changes beside it."""
    if not len(beside.starts):
        return find_baseline(*cut, good, zero_time)
    both = Cuts(*(np.concatenate(parts) for parts in zip(cut, beside, strict=True)))
    order = np.argsort(both.starts)
    usable = np.append(good, np.ones(len(beside.starts), dtype=bool))[order]
    whole = find_baseline(*both.chosen(order), usable, zero_time)
    if not whole.own:
        return whole
    return replace(find_baseline(*cut, good, zero_time), elsewhere=whole.own)
