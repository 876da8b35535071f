"""Whether two continuous recordings of one sampling rate are stretches of one, however they were cut or rounded."""

from typing import NamedTuple

import numpy as np

from vasowave.catheter.signals.raw import RawRecording

_MAX_STRETCH_S, _STRETCH_SHARE = 2.0, 0.15
"""The stretches that are looked for, beginning, middle and end of the shorter recording: so many s, or such a share of
it where that is less. Two stretches of one recording that overlap share the end of one of them."""
_MAX_RESIDUAL_SD_SHARE = 0.01
"""Share of the signal's standard deviation by which two exports of one stretch differ, at most: a pulse of 15 mmHg
written to 0.1 mmHg differs by 0.6 %. Beats of one animal differ from each other by several times as much."""
_MIN_STRETCH_BEATS = 4  # beats in a stretch
_MAX_HEART_RATE_DIFFERENCE = 0.05  # relative difference of heart rates above which nothing is compared


class PressureTrace(NamedTuple):
    """The pressure of a recording, mmHg, its samples/s, and its heart rate, beats/min."""

    pressure: np.ndarray
    rate: float
    heart_rate: float


def trace_of(raw: RawRecording, heart_rate: float) -> PressureTrace:
    """Return what a recording is compared by; gaps count as the mean."""
    finite = np.isfinite(raw.pressure)
    pressure = np.where(finite, raw.pressure, raw.pressure[finite].mean())
    return PressureTrace(pressure.astype(np.float32), raw.sampling_rate, heart_rate)


def are_of_one(trace: PressureTrace, other_trace: PressureTrace) -> bool:
    """Whether beginning, middle or end of the shorter of two traces of one rate stands anywhere in the longer one."""
    if (
        trace.rate != other_trace.rate
        or abs(trace.heart_rate - other_trace.heart_rate) > _MAX_HEART_RATE_DIFFERENCE * trace.heart_rate
    ):
        return False
    short, long = (values.astype(float) for values in sorted((trace.pressure, other_trace.pressure), key=len))
    fewest = _MIN_STRETCH_BEATS * 60.0 * trace.rate / trace.heart_rate
    count = int(min(_MAX_STRETCH_S * trace.rate, max(_STRETCH_SHARE * len(short), fewest)))
    if not fewest - 1 < count <= len(short):
        return False
    last = len(short) - count
    return any(_stands_in(short[first : first + count], long - long.mean()) for first in (0, last // 2, last))


def _stands_in(piece: np.ndarray, signal: np.ndarray) -> bool:
    """Whether a stretch stands in a signal without mean, but for its own mean."""
    from scipy.signal import correlate

    count, piece = len(piece), piece - piece.mean()
    sums, squares = (np.append(0.0, np.cumsum(values)) for values in (signal, signal**2))
    of_window = squares[count:] - squares[:-count] - (sums[count:] - sums[:-count]) ** 2 / count
    square = float(piece @ piece)
    distance = square + of_window - 2 * correlate(signal, piece, mode="valid", method="fft")
    return bool(distance.min() < _MAX_RESIDUAL_SD_SHARE**2 * square)
