"""Whether two continuous recordings of one sampling rate are stretches of one, however they were cut or rounded."""

from typing import NamedTuple

import numpy as np

from vasowave.recording.raw import RawRecording

LONGEST, SHARE = 5.0, 0.4
"""The stretch that is looked for: so many s, or such a share of the shorter recording where that is less."""
LEFT = 0.01
"""Share of the signal's standard deviation by which two exports of one stretch differ, at most: a pulse of 15 mmHg
written to 0.1 mmHg differs by 0.6 %. Beats of one animal differ from each other by several times as much."""
_LEAST = 3  # beats in the stretch
_RATES_APART = 0.05  # relative difference of heart rates above which nothing is compared


class Trace(NamedTuple):
    """The pressure of a recording, mmHg, its samples/s, and its heart rate, beats/min."""

    pressure: np.ndarray
    rate: float
    heart_rate: float


def trace_of(raw: RawRecording, heart_rate: float) -> Trace:
    """Return what a recording is compared by; gaps count as the mean."""
    known = np.isfinite(raw.pressure)
    whole = np.where(known, raw.pressure, raw.pressure[known].mean())
    return Trace(whole.astype(np.float32), raw.sampling_rate, heart_rate)


def are_of_one(one: Trace, other: Trace) -> bool:
    """Whether the middle of the shorter of two traces of one rate stands anywhere in the longer one."""
    from scipy.signal import correlate

    if one.rate != other.rate or abs(one.heart_rate - other.heart_rate) > _RATES_APART * one.heart_rate:
        return False
    short, whole = (values.astype(float) for values in sorted((one.pressure, other.pressure), key=len))
    count = int(min(LONGEST * one.rate, SHARE * len(short)))
    if count < _LEAST * 60.0 * one.rate / one.heart_rate:
        return False
    first = (len(short) - count) // 2
    piece = short[first : first + count]
    piece, whole = piece - piece.mean(), whole - whole.mean()
    sums, squares = (np.append(0.0, np.cumsum(values)) for values in (whole, whole**2))
    of_window = squares[count:] - squares[:-count] - (sums[count:] - sums[:-count]) ** 2 / count
    together = correlate(whole, piece, mode="valid", method="fft")
    square = float(piece @ piece)
    left = square + of_window - 2 * together
    return bool(left.min() < LEFT**2 * square)
