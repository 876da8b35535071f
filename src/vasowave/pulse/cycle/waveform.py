"""Operations on the waveform of beats and cycles: cut, closed, smoothed, set earlier, measured for its delay."""

import numpy as np


def cut_beats(values: np.ndarray, rate: float, times: np.ndarray, count: int) -> np.ndarray:
    """Return every beat at `count` evenly spaced times, both ends included, shape (beat, sample)."""
    from scipy.interpolate import CubicSpline

    phase = np.linspace(0.0, 1.0, count)
    sample_times = times[:-1, None] + np.diff(times)[:, None] * phase
    return CubicSpline(np.arange(len(values)) / rate, values)(sample_times)


def close_cycle(mean: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the cycle without its repeated last sample, closed, and the step it had as a fraction of its range."""
    step = mean[-1] - mean[0]
    closed = mean - step * (np.linspace(0.0, 1.0, len(mean)) - 0.5)
    return closed[:-1], float(step / max(np.ptp(mean), 1e-300))


def foot_delay(pressure: np.ndarray, flow: np.ndarray, period: float) -> float:
    """Return by how much the foot of the flow follows that of the pressure, s.

    Before reflections return, pressure and flow rise together, so their feet belong to one instant.
    """
    delay = cycle_foot(flow) - cycle_foot(pressure)
    return float((delay + 0.5) % 1 - 0.5) * period


def cycle_foot(values: np.ndarray) -> float:
    """Return where the upstroke of a cycle begins, as a fraction of the cycle; negative before its first sample."""
    count, smooth = len(values), low_pass(values, 12)
    top = int(np.argmax(np.roll(smooth, -1) - np.roll(smooth, 1)))
    # Turned so that the upstroke stands in the middle and the foot cannot fall off the start.
    turned = np.roll(smooth, count // 2 - top)[count // 4 :]
    return float(foot(turned, count // 2 - count // 4) + top - (count // 2 - count // 4)) / count


def low_pass(values: np.ndarray, harmonics: int) -> np.ndarray:
    """Return a cycle without its harmonics above `harmonics`."""
    spectrum = np.fft.rfft(values)
    spectrum[harmonics + 1 :] = 0
    return np.fft.irfft(spectrum, len(values))


def advance(values: np.ndarray, cycles: float) -> np.ndarray:
    """Return a periodic signal earlier by a fraction of a cycle, by its Fourier phases."""
    harmonic = np.fft.rfftfreq(len(values), 1.0 / len(values))
    return np.fft.irfft(np.fft.rfft(values) * np.exp(2j * np.pi * harmonic * cycles), len(values))


def harmonic_error(cuts: np.ndarray) -> np.ndarray:
    """Return the standard error of every harmonic's amplitude in the mean of beats, shape (harmonic,).

    The beats, shape (beat, sample), last one period each, the end not repeated.
    """
    spectra = amplitudes(cuts)
    square = np.mean(np.abs(spectra - spectra.mean(axis=0)) ** 2, axis=0) / (len(cuts) - 1)
    # The square error of a complex harmonic is that of two components; the mean has one.
    square[1:] /= 2.0
    return np.sqrt(square)


def amplitudes(values: np.ndarray) -> np.ndarray:
    """Return complex amplitudes along the last axis: the mean first, then each harmonic's."""
    count = values.shape[-1]
    spectrum = np.fft.rfft(values) * (2.0 / count)
    spectrum[..., 0] /= 2.0
    if count % 2 == 0:
        spectrum[..., -1] /= 2.0
    return spectrum


def foot(values: np.ndarray, steepest: int) -> float:
    """Return where the tangent at the steepest rise meets the level of the lowest value before it, in samples."""
    window = slice(max(steepest - 3, 1), steepest + 4)
    slopes = np.gradient(values)
    steepest = window.start + int(np.argmax(slopes[window]))
    lowest = values[: steepest + 1].min()
    return steepest - (values[steepest] - lowest) / slopes[steepest] if slopes[steepest] > 0 else float(steepest)
