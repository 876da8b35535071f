"""Synthetic continuous recordings: the beats of one known cycle, with everything that makes a real one untidy."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import note_kind
from vasowave.catheter.signals.raw import RawRecording
from vasowave.pulse.cycle.cycle import Recording, resample

_WAVES = ((-0.022, 0.0035, 0.12), (-0.0022, 0.0009, -0.15), (0.0, 0.0011, 1.0), (0.0026, 0.0012, -0.35))
"""P, Q, R, S of a mouse's ECG: time after the R peak (s), width (s), height (mV)."""
_T_WAVE = (0.17, 0.07, 0.18)
"""T wave: centre and width as fractions of the beat, height (mV)."""
_FINE = 4096  # samples of the cycle from which beats of any length are read


SYNTHETIC = note_kind("recording.synthetic", "synthetic: made from one cycle, not measured")


@dataclass(frozen=True)
class Disturbances:
    """What separates a recording from a repeated cycle. Zero switches a disturbance off.

    Attributes
    ----------
    length_variation, amplitude_variation : float
        SD of beat length and of pulse amplitude from beat to beat, as fractions.
    breaths_per_minute : float
        Rate of the ventilator.
    ventilation_pressure : float
        Rise of the pressure at the height of inspiration, mmHg.
    ventilation_flow : float
        Fall of the stroke volume at the height of inspiration, as a fraction.
    pressure_drift : float
        Drift of the transducer, mmHg/min; zero at the start, where it was zeroed.
    pressure_noise, flow_noise, ecg_noise : float
        SD of white noise in mmHg, ml/s, mV.
    mains : float
        Amplitude of 50 Hz in the ECG, mV.
    ecg_wander : float
        Amplitude of the ECG's slow baseline, mV.
    """

    length_variation: float = 0.015
    amplitude_variation: float = 0.01
    breaths_per_minute: float = 90.0
    ventilation_pressure: float = 1.5
    ventilation_flow: float = 0.05
    pressure_drift: float = 0.5
    pressure_noise: float = 0.1
    flow_noise: float = 0.005
    ecg_noise: float = 0.05
    mains: float = 0.05
    ecg_wander: float = 0.3


@dataclass(frozen=True, eq=False)
class SyntheticRecording:
    """A synthetic recording and what is true about it.

    Attributes
    ----------
    raw : RawRecording
    beat_times : float array, shape (beat,)
        True times of the R waves, where the cycle starts, s; all inside the recording.
    inspiration : float array, shape (beat,)
        Height of inspiration at each of them, 0 (end of expiration) to 1.
    """

    raw: RawRecording
    beat_times: np.ndarray
    inspiration: np.ndarray


@dataclass(frozen=True)
class _Instruments:
    """What instruments do to the signals, see `synthetic_raw_recording`."""

    flow_delay: float = 0.0
    ecg: bool = True
    baseline: Callable[[np.ndarray], np.ndarray] | None = None


def synthetic_raw_recording(
    recording: Recording,
    rng: np.random.Generator,
    *,
    duration: float = 10.0,
    sampling_rate: float = 2000.0,
    heart_rate: float | None = None,
    disturbances: Disturbances = Disturbances(),
    **instruments: Any,
) -> SyntheticRecording:
    """Return a continuous recording whose end-expiratory beats repeat one cycle.

    Every beat is the cycle stretched to the beat's length, so the truth about any average is known. Inspiration takes
    40 % of a breath, as a smooth hump; the rest is a plateau on which the beats are the cycle itself.

    Parameters
    ----------
    recording : Recording
        The cycle.
    rng : numpy.random.Generator
    duration : float
        s.
    sampling_rate : float
        Samples per second.
    heart_rate : float, optional
        Beats/min; the recording's own by default. Another rate stretches the cycle.
    disturbances : Disturbances, optional
    flow_delay : float, optional
        By how much the flow signal comes late, s: the p-q delay of the instruments.
    ecg : bool, optional
        Whether there is an ECG.
    baseline : callable, optional
        What the transducer adds to the pressure, mmHg, at times in s: any other drift than a straight one.

    Raises
    ------
    InputError
        A duration, rate or heart rate that is not positive.
    """
    amplifier = _Instruments(**instruments)
    period = 60.0 / heart_rate if heart_rate else recording.period
    if not (duration > 0 and sampling_rate > 0 and np.isfinite(period) and period > 0):
        raise InputError("duration, sampling_rate and heart_rate of a synthetic recording must be positive")
    time = np.arange(round(duration * sampling_rate)) / sampling_rate
    starts, gains, breaths = _beats(rng, period, duration, disturbances)
    swell = _inspiration(time, disturbances, breaths)
    pressure = _repeat(recording.pressure, time, starts, gains) + disturbances.pressure_drift * time / 60.0
    if amplifier.baseline is not None:
        pressure += amplifier.baseline(time)
    pressure += disturbances.ventilation_pressure * swell
    pressure += disturbances.pressure_noise * rng.standard_normal(len(time))
    late = time - amplifier.flow_delay
    flow = _repeat(recording.flow, late, starts, gains)
    flow *= 1.0 - disturbances.ventilation_flow * _inspiration(late, disturbances, breaths)
    flow += disturbances.flow_noise * rng.standard_normal(len(time))
    raw = RawRecording(
        pressure=pressure,
        flow=flow,
        sampling_rate=sampling_rate,
        ecg=_ecg(time, starts, disturbances, rng) if amplifier.ecg else None,
        source="synthetic recording",
        notes=(SYNTHETIC(),),
    )
    inside = starts[(starts >= 0) & (starts <= time[-1])]
    return SyntheticRecording(raw, inside, _inspiration(inside, disturbances, breaths))


def _beats(
    rng: np.random.Generator, period: float, duration: float, disturbances: Disturbances
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the starts of the beats (from before the recording to after it), their gains, and the breaths' phase."""
    count = int(1.5 * duration / period) + 20
    variation = np.clip(rng.standard_normal((2, count)), -3, 3)
    lengths = period * (1.0 + disturbances.length_variation * variation[0])
    starts = np.concatenate([[0.0], np.cumsum(lengths)]) - period * (4.0 + rng.random())
    gains = 1.0 + disturbances.amplitude_variation * variation[1]
    if starts[-1] < duration + 2 * period:
        raise InputError("the beat lengths vary too much for a synthetic recording; lower length_variation")
    return starts, gains, float(rng.random())


def _inspiration(time: np.ndarray, disturbances: Disturbances, shift: float) -> np.ndarray:
    """Return the height of inspiration, 0 to 1: a hump in 40 % of each breath."""
    phase = (time * disturbances.breaths_per_minute / 60.0 + shift) % 1.0
    return np.where(phase < 0.4, np.sin(np.pi * phase / 0.4) ** 2, 0.0)


def _repeat(cycle: np.ndarray, time: np.ndarray, starts: np.ndarray, gains: np.ndarray) -> np.ndarray:
    """Return the cycle repeated at `starts`; gains scale the excursion from its first value, so no steps arise."""
    beat = np.searchsorted(starts, time, side="right") - 1
    phase = (time - starts[beat]) / (starts[beat + 1] - starts[beat])
    fine = resample(cycle, max(_FINE, len(cycle)))
    excursion = np.interp(phase, np.linspace(0.0, 1.0, len(fine) + 1), np.append(fine, fine[0])) - fine[0]
    return fine[0] + gains[beat] * excursion


def _ecg(time: np.ndarray, starts: np.ndarray, disturbances: Disturbances, rng: np.random.Generator) -> np.ndarray:
    ecg = np.zeros(len(time))
    for start, length in zip(starts[:-1], np.diff(starts), strict=True):
        centre, width, height = _T_WAVE
        for peak, spread, size in (*_WAVES, (centre * length, width * length, height)):
            window = slice(*np.searchsorted(time, [start + peak - 6 * spread, start + peak + 6 * spread]))
            ecg[window] += size * np.exp(-0.5 * ((time[window] - start - peak) / spread) ** 2)
    ecg += disturbances.mains * np.sin(2 * np.pi * (50.0 * time + rng.random()))
    wander = disturbances.breaths_per_minute / 60.0
    ecg += disturbances.ecg_wander * np.sin(2 * np.pi * (wander * time + rng.random()))
    return ecg + disturbances.ecg_noise * rng.standard_normal(len(time))
