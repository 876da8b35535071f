"""Whether the noise of a signal falls off as behind a filter: the spectrum of what beats do not repeat.

Noise of transducer and amplifier is flat before a filter of order n and W / (1 + (f/f_c)^2n) behind it. Noise that
falls as powers of the frequency (drift, 1/f) and a converter's flat one have no plateau with a knee, in any sum.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vasowave.base.cures import UNKNOWN, SetCells, SetSetting
from vasowave.base.findings import Finding, look_kind
from vasowave.catheter.signals.hum import hum_of


@dataclass(frozen=True)
class NoiseRules:
    """When the noise of a signal is taken for filtered.

    Attributes
    ----------
    window, samples : float, int
        The last part of each beat that is looked at, s and samples at most.
    beats : (int, int)
        With fewer nothing is said; more are not looked at.
    shapes : int
        Ways in which beats vary beside level, slope, size and delay.
    octave : int
        Values of the spectrum in an octave.
    highest : float
        Share of the sampling rate up to which it is looked at, below filters against aliasing.
    exact : float
        Its relative error beside that by chance.
    slowest : float
        Least cut-off that is told, Hz: the animal itself fluctuates more slowly.
    fastest : (float, float)
        Largest ones of first and second order, shares of the sampling rate: means of two and three samples look alike.
    resampled : float
        Ratio of second differences of every so manieth sample from which on samples are held or interpolated.
    rounded : float
        Least median of the noise in steps of the converter.
    better, left, misfit : float
        By how much a filter lowers the sum of squared errors; the share of it and their mean that may be left.
    second : float
        By how much the second order must fit better than the first.
    steady : float
        Largest ratio of the noise's power between quarters of the window, and of the recording.
    """

    window: float = 0.25
    samples: int = 384
    beats: tuple[int, int] = (16, 300)
    shapes: int = 4
    octave: int = 8
    highest: float = 0.35
    exact: float = 0.05
    slowest: float = 14.0
    fastest: tuple[float, float] = (0.22, 0.14)
    resampled: float = 2.0
    rounded: float = 0.4
    better: float = 20.0
    residual_share: float = 0.6
    misfit: float = 2.0
    second: float = 6.0
    steady: float = 3.0


RULES = NoiseRules()
_FREQUENCY_POWERS = np.arange(5)  # of the frequency, by which noise without a filter falls

ROLLS_OFF = look_kind(
    "recording.noise-rolls-off",
    "the noise of the {what} falls off above about {cutoff:.0f} Hz as behind a low-pass of order {order}, which makes "
    "arteries look soft; random fluctuations of the animal with a memory of {memory:.2g} ms look alike",
    "Ask which filters amplifier and recorder have, and give their cut-off frequency; where nobody knows, allow for a "
    "lag of the pressure as a known error.",
    SetCells("Give the filter of the pressure", (("pressure cutoff [Hz]", UNKNOWN),)),
    SetCells("Give the filter of the flow", (("flow cutoff [Hz]", UNKNOWN),)),
    SetSetting("Allow for a lag", "pressure_lag_sd"),
)


class Filter(NamedTuple):
    """A filter that fits: sum of squared errors, cut-off, Hz, order."""

    error: float
    cutoff: float
    order: int


def noise_findings(
    pressure: np.ndarray, flow: np.ndarray, sampling_rate: float, starts: np.ndarray, rules: NoiseRules = RULES
) -> list[Finding]:
    """Return a finding for each signal, mmHg and ml/s, whose noise looks filtered; beats start at so many s."""
    findings = []
    for signal, values in (("pressure", pressure), ("flow", flow)):
        best = _filter_of(values - hum_of(values, sampling_rate).course, sampling_rate, starts, rules)
        if best is not None:
            memory = 1e3 / (2 * np.pi * best.cutoff)
            findings.append(ROLLS_OFF(what=signal, cutoff=best.cutoff, order=best.order, memory=memory))
    return findings


def _filter_of(values: np.ndarray, rate: float, starts: np.ndarray, rules: NoiseRules) -> Filter | None:
    """Return the filter that explains the noise of a signal, None if none does."""
    lasts = int(np.quantile(np.diff(starts), 0.1) * rate)
    count = int(min(lasts, rules.window * rate, rules.samples))
    beat_starts = np.rint(starts[:-1][np.diff(starts) * rate >= lasts] * rate).astype(int)
    if len(beat_starts) < rules.beats[0] or _resampled(values) > rules.resampled:
        return None
    beat_starts = beat_starts[np.linspace(0, len(beat_starts) - 1, min(len(beat_starts), rules.beats[1])).astype(int)]
    beats = values[beat_starts[:, None] + np.arange(lasts - count, lasts)]
    noise, power, kernel = _noise(beats, rules)
    step = np.diff(np.unique(beats[:40])).min(initial=np.inf)
    levels = [[np.median(np.abs(quarter)) for quarter in np.array_split(noise, 4, axis=axis)] for axis in (0, 1)]
    if np.median(np.abs(noise)) < rules.rounded * step or any(max(p) ** 2 > rules.steady * min(p) ** 2 for p in levels):
        return None
    number = np.arange(1, int(rules.highest * count))
    places = np.floor(rules.octave * np.log2(number))
    same = (places == np.unique(places)[:, None]).astype(float)
    size = same.sum(axis=1, keepdims=True)
    chance = 1 / (0.3 * len(noise) * np.maximum(1.0, 0.6 * size))  # medians, and neighbors that share a window
    scores = (same @ kernel[number]) / (same @ power[number])[:, None] / np.sqrt(chance + rules.exact**2)
    plain, first, second = _fits(scores, 1 / np.sqrt(chance + rules.exact**2)[:, 0], rate)
    best = second if second.error < first.error - rules.second else first
    sure = best.error < min(plain - rules.better, rules.residual_share * plain, rules.misfit * len(size))
    return best if sure and rules.slowest <= best.cutoff <= rules.fastest[best.order - 1] * rate else None


def _resampled(values: np.ndarray) -> float:
    """Return how unlike the second differences of every second to tenth sample are; interpolated samples have none."""
    bends, ratios = np.abs(np.diff(values, 2)), []
    for step in range(2, 11):
        means = np.mean(bends[: len(bends) // step * step].reshape(-1, step), axis=0)
        ratios.append(means.max() / max(means.min(), 1e-300))
    return float(max(ratios))


def _noise(beats: np.ndarray, rules: NoiseRules) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what beats, shape (beat, sample), do not repeat, its spectrum, and what that holds of each frequency."""
    count, usual = beats.shape[1], np.median(beats, axis=0)
    window, line = np.hanning(count + 2)[1:-1], np.linspace(-1, 1, count)
    regressors = np.linalg.qr(np.stack([np.ones(count), line, usual, np.gradient(usual)], axis=1))[0]
    residual = beats - usual
    residual -= (residual @ regressors) @ regressors.T
    noise, power, kernel = np.empty_like(residual), np.zeros(count // 2 + 1), np.zeros((count // 2 + 1, 2 * count))
    for half in (0, 1):  # how beats vary is learnt from the others, lest it be their noise
        training = residual[1 - half :: 2]
        varied = training.T @ np.linalg.eigh(training @ training.T)[1][:, -rules.shapes :]
        basis = np.linalg.qr(np.column_stack([regressors, varied]))[0]
        noise[half::2] = residual[half::2] - (residual[half::2] @ basis) @ basis.T
        power += np.median(np.abs(np.fft.rfft(window * noise[half::2])) ** 2, axis=0) / (2 * np.log(2))
        turned = np.fft.rfft(window[:, None] * (np.eye(count) - basis @ basis.T), axis=0)
        kernel += np.abs(np.fft.fft(turned, 2 * count)) ** 2 / (4 * count)
    return noise, power, kernel


def _fits(scores: np.ndarray, weight: np.ndarray, rate: float) -> tuple[float, Filter, Filter]:
    """Return the squared error without a filter, and the best filters of first and second order, analog or digital.

    `scores` is what true power at each frequency gives in the spectrum, whose values are `weight` each.
    """
    from scipy.optimize import nnls

    def misfit(true: np.ndarray) -> float:
        columns = scores @ true
        return float(nnls(columns / np.linalg.norm(columns, axis=0), weight, maxiter=1000)[1] ** 2)

    frequency = np.maximum(np.abs(np.fft.fftfreq(scores.shape[1], 1 / rate)), rate / (2 * scores.shape[1]))
    plain = (frequency[:, None] / 30.0) ** -_FREQUENCY_POWERS
    fits: dict[int, list[Filter]] = {1: [], 2: []}
    for cutoff in np.geomspace(6.0, 0.3 * rate, 36).tolist():
        digital = np.tan(np.minimum(np.pi * frequency / rate, 1.57)) / np.tan(np.pi * cutoff / rate)  # bilinear
        for ratio in (frequency / cutoff, digital):
            for order, tried in fits.items():
                filtered = 1 / (1 + ratio ** (2 * order))
                tried.append(Filter(misfit(np.column_stack([plain, filtered])), cutoff, order))
    return misfit(plain), min(fits[1]), min(fits[2])
