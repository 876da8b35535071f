"""The beats of a continuous recording cut out, and those beside the stretch that is read."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import VasowaveError
from vasowave.catheter.beats.beats import find_beats
from vasowave.catheter.beats.rejection import misshapen_beats
from vasowave.catheter.signals.raw import RawRecording
from vasowave.pulse.cycle.waveform import cut_beats

_MARGIN_SAMPLES = 64  # samples


class Cuts(NamedTuple):
    """Beats cut from a recording: times of start and end, s, and their samples, shape (beat, sample), end included."""

    starts: np.ndarray
    ends: np.ndarray
    pressure: np.ndarray
    flow: np.ndarray

    def chosen(self, selection: np.ndarray) -> "Cuts":
        """Return some of the beats, by number or by truth."""
        return Cuts(*(array[selection] for array in self))


def cut_all(raw: RawRecording, times: np.ndarray, samples: int) -> Cuts:
    """Return all beats of a recording, from one of `times` to the next, brought to `samples` and one more."""
    since = times - raw.origin
    pressure, flow = (cut_beats(signal, raw.sampling_rate, since, samples + 1) for signal in (raw.pressure, raw.flow))
    return Cuts(times[:-1], times[1:], pressure, flow)


def cut_again(raw: RawRecording, cut: Cuts, times: np.ndarray) -> Cuts:
    """Return `cut` with the beats cut anew that begin or end elsewhere by `times`.

    A sample's weight in a cubic spline falls by 0.27 a sample, so that what is far from a beat does not reach it.
    """
    pressure, flow = cut.pressure.copy(), cut.flow.copy()
    for row in np.flatnonzero((times[:-1] != cut.starts) | (times[1:] != cut.ends)):
        ends = times[row : row + 2] - raw.origin
        first = max(0, int(ends[0] * raw.sampling_rate) - _MARGIN_SAMPLES)
        window = slice(first, int(ends[1] * raw.sampling_rate) + _MARGIN_SAMPLES)
        for cuts, signal in ((pressure, raw.pressure), (flow, raw.flow)):
            since = ends - first / raw.sampling_rate
            cuts[row] = cut_beats(signal[window], raw.sampling_rate, since, cuts.shape[1])[0]
    return Cuts(times[:-1], times[1:], pressure, flow)


def beats_beside(
    raw: RawRecording, shapes: tuple[np.ndarray, np.ndarray], fiducial: str, heart_rates: tuple[float, float],
    length_tolerance: float, least_correlation: float,
) -> list[Cuts]:  # fmt: skip
    """Return the beats of each stretch beside the one that is read whose length is usual and whose shape `shapes`."""
    neighbours = []
    for stretch in raw.beside:
        try:
            times = find_beats(stretch, fiducial, heart_rates).times
        except VasowaveError:  # nothing beats there
            continue
        if len(times) > 1:
            beats = cut_all(stretch, times, len(shapes[0]) - 1)
            lengths = beats.ends - beats.starts
            reasons = misshapen_beats(lengths, beats.pressure, beats.flow, length_tolerance, least_correlation, shapes)
            neighbours.append(beats.chosen(~np.array([bool(reason) for reason in reasons])))
    return neighbours


def merged(cut: Cuts, neighbours: Sequence[Cuts]) -> tuple[Cuts, np.ndarray]:
    """Return all beats in the order of their times, and which of them are those of `cut`."""
    if not any(len(neighbour.starts) for neighbour in neighbours):
        return cut, np.ones(len(cut.starts), dtype=bool)
    union = Cuts(*(np.concatenate(arrays) for arrays in zip(cut, *neighbours, strict=True)))
    order = np.argsort(union.starts)
    return union.chosen(order), order < len(cut.starts)
