"""Whether two continuous recordings of one sampling rate are stretches of one, however they were cut or rounded."""

from typing import NamedTuple

import numpy as np

from vasowave.recording.raw import RawRecording

LONGEST, SHARE = 2.0, 0.15
"""The stretches that are looked for, beginning, middle and end of the shorter recording: so many s, or such a share of
it where that is less. Two stretches of one recording that overlap share the end of one of them."""
LEFT = 0.01
"""Share of the signal's standard deviation by which two exports of one stretch differ, at most: a pulse of 15 mmHg
written to 0.1 mmHg differs by 0.6 %. Beats of one animal differ from each other by several times as much."""
_LEAST = 4  # beats in a stretch
_RATES_APART = 0.05  # relative difference of heart rates above which nothing is compared


class PressureTrace(NamedTuple):
    """The pressure of a recording, mmHg, its samples/s, and its heart rate, beats/min."""

    pressure: np.ndarray
    rate: float
    heart_rate: float


def trace_of(raw: RawRecording, heart_rate: float) -> PressureTrace:
    """Return what a recording is compared by; gaps count as the mean."""
    known = np.isfinite(raw.pressure)
    whole = np.where(known, raw.pressure, raw.pressure[known].mean())
    return PressureTrace(whole.astype(np.float32), raw.sampling_rate, heart_rate)


def are_of_one(one: PressureTrace, other: PressureTrace) -> bool:
    """Whether beginning, middle or end of the shorter of two traces of one rate stands anywhere in the longer one."""
    if one.rate != other.rate or abs(one.heart_rate - other.heart_rate) > _RATES_APART * one.heart_rate:
        return False
    short, whole = (values.astype(float) for values in sorted((one.pressure, other.pressure), key=len))
    fewest = _LEAST * 60.0 * one.rate / one.heart_rate
    count = int(min(LONGEST * one.rate, max(SHARE * len(short), fewest)))
    if not fewest - 1 < count <= len(short):
        return False
    last = len(short) - count
    return any(_stands_in(short[first : first + count], whole - whole.mean()) for first in (0, last // 2, last))


def _stands_in(piece: np.ndarray, whole: np.ndarray) -> bool:
    """Whether a stretch stands in a signal without mean, but for its own mean."""
    from scipy.signal import correlate

    count, piece = len(piece), piece - piece.mean()
    sums, squares = (np.append(0.0, np.cumsum(values)) for values in (whole, whole**2))
    of_window = squares[count:] - squares[:-count] - (sums[count:] - sums[:-count]) ** 2 / count
    square = float(piece @ piece)
    left = square + of_window - 2 * correlate(whole, piece, mode="valid", method="fft")
    return bool(left.min() < LEFT**2 * square)
