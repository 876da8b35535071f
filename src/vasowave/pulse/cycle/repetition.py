"""After how many samples a signal repeats: the length of a beat before any beat is known."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class RepetitionRules:
    """What counts as a repetition in an autocorrelation."""

    repeat_share: float = 0.75  # of its best peak, that the first one has which is a beat and no multiple
    min_repetition: float = 0.15  # of its value without lag, below which nothing repeats


RULES = RepetitionRules()


def repeat_length(signal: np.ndarray, shortest: float, longest: float, smoothing: float = 0.0) -> float | None:
    """Return after how many samples a signal without its mean repeats, None where it does not.

    Parameters
    ----------
    signal : float array, shape (sample,)
    shortest, longest : float
        Between which lags, in samples.
    smoothing : float
        SD of the smoothing of the autocorrelation, in samples.
    """
    from scipy.ndimage import gaussian_filter1d
    from scipy.signal import find_peaks

    spectrum = np.abs(np.fft.rfft(signal, 2 * len(signal))) ** 2
    repetition = np.fft.irfft(spectrum)[: len(signal)] / np.arange(len(signal), 0, -1)
    if smoothing:
        repetition = gaussian_filter1d(repetition, smoothing)
    window = repetition[: int(longest) + 2]
    peaks = find_peaks(window)[0]
    peaks = peaks[(peaks >= shortest) & (peaks <= longest)]
    if not len(peaks) or window[peaks].max() < RULES.min_repetition * repetition[0]:
        return None
    return float(peaks[window[peaks] >= RULES.repeat_share * window[peaks].max()][0])
