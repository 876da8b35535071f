"""What one cycle of pressure and flow tells without a model: ejection, slopes, notch, load, power, energy of waves.

Marks are found on the harmonics that carry the wave, so that neither noise nor the sampling moves them.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, note_kind
from vasowave.pulse.analysis.impedance_spectrum import characteristic_impedances
from vasowave.pulse.cycle.averaged import EnsembleAverage, one_cycle
from vasowave.pulse.cycle.cycle import MIN_SAMPLES, Recording, resample
from vasowave.pulse.cycle.harmonics import harmonic_errors
from vasowave.pulse.cycle.waveform import close_cycle, low_pass


@dataclass(frozen=True)
class CycleRules:
    """How the marks of a cycle are found; shares of the period unless they say otherwise.

    Attributes
    ----------
    pressure_harmonics, flow_harmonics : int
        Harmonics that are kept: above the first, noise moves slopes; the second place the peak of the flow.
    sure_harmonics, around : int
        Above the first, each of the pressure's harmonics counts by the share that signal has in the power of those
        so near to it, both sides.
    samples : int
        Marks are found on so many samples a cycle.
    low, high : float
        Shares of the peak of the flow above its rest: the line through both meets the rest where ejection begins and
        where it ends, so that neither a step nor a slow start moves it by much.
    rest_first, rest_last : float
        The flow rests between these before its steepest rise.
    notch_reach : float
        The notch lies so near to the end of ejection.
    min_notch_rise : float
        The pressure rises behind it by such a share of its pulse.
    """

    pressure_harmonics: int = 20
    flow_harmonics: int = 40
    sure_harmonics: int = 5
    around: int = 2
    samples: int = 1024
    low: float = 0.05
    high: float = 0.15
    rest_first: float = 0.40
    rest_last: float = 0.15
    notch_reach: float = 0.15
    min_notch_rise: float = 0.01


RULES = CycleRules()
MIN_OUTPUT_SHARE = 1e-3
"""Of the range of the flow: a mean flow below it drives nothing, and a load per stroke volume means nothing."""
NO_EJECTION = note_kind(
    "cycle.no-ejection",
    "the flow does not come back to its rest after its peak, so that ejection has no end: no ejection time, notch and "
    "end-systolic pressure",
)
NO_NOTCH = note_kind(
    "cycle.no-notch",
    "the pressure does not fall and rise again about the end of ejection: no dicrotic notch",
)
NO_UPSTROKE = note_kind(
    "cycle.no-upstroke",
    "the flow has no upstroke from which Z_c could be told: no energy of incident and reflected waves",
)


class CycleIndices(NamedTuple):
    """Numbers of a cycle by the names of `QUANTITIES`, and why others are not there."""

    values: dict[str, float]
    absent: tuple[Finding, ...]


class _Marks(NamedTuple):
    """Samples (decimal, counted on across the end of the cycle) at which ejection begins, peaks and ends."""

    begin: float
    peak: float
    end: float


def cycle_indices(recording: Recording | EnsembleAverage, Z_c: float | None = None) -> CycleIndices:
    """Return what a cycle tells without a model and without an image of vessels.

    Parameters
    ----------
    recording : Recording or EnsembleAverage
    Z_c : float, optional
        Characteristic impedance, mmHg s/ml; by default that of the upstroke's first half.

    Returns
    -------
    CycleIndices
        ``SV`` (ml); ``ejection_time`` and ``acceleration_time`` (s; onset of the flow to its end, and to its peak);
        ``dp_dt_max`` and ``dp_dt_min`` (mmHg/s); ``notch`` (mmHg); ``RC`` (s, PVR times SV over pulse pressure,
        Lankhaar et al. 2008); ``E_a_artery`` (mmHg/ml, pressure at the end of ejection over SV, Sunagawa et al. 1983);
        ``augmentation`` (share of the pulse pressure that comes after the peak of the flow, Kelly et al. 1989, negative
        where the pressure peaks before); ``power``, ``steady_power``, ``oscillatory_power`` (mW, mean of p q, p̄ q̄, and
        their difference; kinetic energy is not in them) and ``oscillatory_share`` (Milnor 1989); ``incident_energy``
        and ``reflected_energy`` (mJ a beat, of what oscillates: T mean((p' ± Z_c q')²)/(4 Z_c), Westerhof et al. 1972;
        their difference is the oscillatory power times T).

    Raises
    ------
    InputError
        What is given is not a cycle, a mean flow that is not positive, or an impedance that is not.

    Examples
    --------
    >>> import vasowave as vw
    >>> mouse = vw.virtual_mouse()
    >>> values = vw.cycle_indices(mouse).values
    >>> bool(abs(values["power"] - values["steady_power"] - values["oscillatory_power"]) < 1e-12)
    True
    """
    recording = one_cycle(recording)
    if not recording.cardiac_output > MIN_OUTPUT_SHARE * np.ptp(recording.flow):
        raise InputError(
            f"{recording.source}: the mean flow is {recording.cardiac_output:.3g} ml/s; are its sign and its zero "
            "right?"
        )
    if Z_c is not None and Z_c <= 0:
        raise InputError(f"a characteristic impedance of {Z_c:g} mmHg s/ml; it is positive")
    Z_c = _impedance(recording) if Z_c is None else Z_c
    count = max(len(recording.pressure), len(recording.flow))
    pressure, flow = (resample(values, count) for values in (recording.pressure, recording.flow))
    return _indices(pressure, flow, _without_noise(recording), recording, Z_c)


def beat_indices(average: EnsembleAverage, recording: Recording | None = None) -> pd.DataFrame:
    """Return Table 1 and `cycle_indices` of every beat that was averaged, by when it begins, s; NaN where absent.

    Each beat is closed as the mean cycle is; Z_c is that of the mean cycle.

    Parameters
    ----------
    average : EnsembleAverage
    recording : Recording, optional
        The mean cycle, where it holds more than `average` does: what lies behind the beds.

    Examples
    --------
    >>> import numpy as np
    >>> import vasowave as vw
    >>> from vasowave.catheter.synthetic import synthetic_raw_recording
    >>> raw = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(1), duration=6.0).raw
    >>> len(vw.beat_indices(vw.average_beats(raw, 10)))
    10
    """
    if not isinstance(average, EnsembleAverage):
        raise InputError(f"{type(average).__name__} was given where beats are needed; average them: raw.average()")
    mean = average.recording if recording is None else recording
    Z_c = _impedance(mean)
    beats = [beat for beat in average.beats if beat.averaged]
    rows = []
    for beat, pressure, flow in zip(beats, average.beat_pressure, average.beat_flow, strict=True):
        cycle = Recording(close_cycle(pressure)[0], close_cycle(flow)[0], beat.end - beat.start)
        if mean.wedge_pressure < cycle.mean_pressure:
            cycle = replace(cycle, wedge_pressure=mean.wedge_pressure)
        driven = cycle.cardiac_output > MIN_OUTPUT_SHARE * np.ptp(cycle.flow)
        rows.append({**cycle.indices(), **cycle_indices(cycle, Z_c).values} if driven else cycle.indices())
    return pd.DataFrame(rows, index=pd.Index([beat.start for beat in beats], name="start [s]"))


def _impedance(recording: Recording) -> float:
    try:
        return float(characteristic_impedances(recording)["first half"])
    except InputError:
        return np.nan


def _without_noise(recording: Recording) -> np.ndarray:
    """Return the cycle's pressure, each harmonic by the share of signal in the power of those around it."""
    modulus, error, _ = harmonic_errors(recording)
    count, reach = RULES.pressure_harmonics + 1, 2 * RULES.around + 1
    power, noise = modulus[:count] ** 2, 2 * error[:count] ** 2
    signal = np.maximum(np.convolve(power - noise, np.full(reach, 1 / reach), "same"), 0.0)
    share = signal / np.maximum(signal + noise, 1e-300)
    share[: RULES.sure_harmonics + 1] = 1.0
    spectrum = np.fft.rfft(recording.pressure)
    spectrum[: len(share)] *= share
    return np.fft.irfft(spectrum, len(recording.pressure))


def _indices(
    pressure: np.ndarray, flow: np.ndarray, smooth: np.ndarray, recording: Recording, Z_c: float
) -> CycleIndices:
    """Return the indices of pressure and flow on the same times, and of a pressure without its noise."""
    fine_pressure, fine_flow = _fine(smooth, RULES.pressure_harmonics), _fine(flow, RULES.flow_harmonics)
    period, wedge = recording.period, recording.wedge_pressure
    mean, output = float(pressure.mean()), float(flow.mean())
    stroke, pulse = output * period, float(np.ptp(pressure))
    slope = _slope(fine_pressure, period)
    power, steady = float(np.mean(pressure * flow)), mean * output
    values = {
        "SV": stroke,
        "dp_dt_max": float(slope.max()),
        "dp_dt_min": float(slope.min()),
        "RC": (mean - wedge) * period / pulse,
        "augmentation": _augmentation(fine_pressure, int(np.argmax(fine_flow))),
        "power": units.MILLIWATT * power,
        "steady_power": units.MILLIWATT * steady,
        "oscillatory_power": units.MILLIWATT * (power - steady),
        "oscillatory_share": 1 - steady / power,
    }
    absent = []
    marks = _marks(fine_flow)
    step = period / RULES.samples
    if marks is None:
        absent.append(NO_EJECTION())
    else:
        end_systolic = float(np.interp(marks.end % RULES.samples, np.arange(RULES.samples), fine_pressure))
        values |= {
            "ejection_time": (marks.end - marks.begin) * step,
            "acceleration_time": (marks.peak - marks.begin) * step,
            "E_a_artery": end_systolic / stroke,
        }
        notch = _notch(fine_pressure, marks.end)
        absent += [] if np.isfinite(notch) else [NO_NOTCH()]
        if np.isfinite(notch):
            values["notch"] = notch
    if Z_c > 0:
        moving, outflow = pressure - mean, Z_c * (flow - output)
        energies = (
            units.MILLIWATT * period * float(np.mean((moving + sign * outflow) ** 2)) / (4 * Z_c) for sign in (1, -1)
        )
        values |= dict(zip(("incident_energy", "reflected_energy"), energies, strict=True))
    else:
        absent.append(NO_UPSTROKE())
    return CycleIndices({name: float(value) for name, value in values.items()}, tuple(absent))


def _fine(values: np.ndarray, harmonics: int) -> np.ndarray:
    """Return a cycle of its first harmonics on the samples of the rules."""
    even = resample(values, max(len(values), MIN_SAMPLES))
    return resample(low_pass(even, harmonics), RULES.samples)


def _slope(values: np.ndarray, period: float) -> np.ndarray:
    """Return the derivative of a cycle by its Fourier series, 1/s."""
    frequency = 2 * np.pi * np.fft.rfftfreq(len(values), period / len(values))
    return np.fft.irfft(1j * frequency * np.fft.rfft(values), len(values))


def _marks(flow: np.ndarray) -> _Marks | None:
    """Return beginning, peak and end of ejection; None where the flow has none."""
    count, peak = len(flow), int(np.argmax(flow))
    steepest = peak - int(np.argmax(np.diff(np.roll(flow, count - 1 - peak))[::-1][: count // 2]))
    before = np.arange(steepest - int(RULES.rest_first * count), steepest - int(RULES.rest_last * count))
    level = float(np.median(flow[before % count]))
    if not flow[peak] - level > 1e-9 * abs(flow[peak]):
        return None
    above = (flow - level) / (flow[peak] - level)
    ends = []
    for side in (-1, 1):
        along = above[(peak + side * np.arange(count // 2 + count // 4)) % count]
        low, high = _first_below(along, RULES.low), _first_below(along, RULES.high)
        if np.isnan(low):
            return None
        ends.append(peak + side * (low + (low - high) * RULES.low / (RULES.high - RULES.low)))
    return _Marks(ends[0], _top(flow, peak), ends[1])


def _first_below(values: np.ndarray, level: float) -> float:
    """Return where values first fall below a level, between samples; NaN where they do not."""
    after = int(np.argmax(values < level))
    if after == 0:
        return np.nan
    return after - (level - values[after]) / (values[after - 1] - values[after])


def _top(values: np.ndarray, peak: int) -> float:
    """Return where the parabola through a peak and its neighbors is highest."""
    before, top, after = (values[(peak + shift) % len(values)] for shift in (-1, 0, 1))
    return peak + float(0.5 * (before - after) / min(before - 2 * top + after, -1e-300))


def _notch(pressure: np.ndarray, end: float) -> float:
    """Return the pressure of the dicrotic notch, the lowest before a rise at the end of ejection; else NaN."""
    count, reach = len(pressure), int(RULES.notch_reach * len(pressure))
    window = pressure[(round(end) + np.arange(-reach, reach + 1)) % count]
    lowest = np.flatnonzero((window[1:-1] < window[:-2]) & (window[1:-1] <= window[2:])) + 1
    for place in lowest:
        if window[place:].max() - window[place] >= RULES.min_notch_rise * np.ptp(pressure):
            return float(window[place])
    return np.nan


def _augmentation(pressure: np.ndarray, peak_of_flow: int) -> float:
    """Return the rise of the pressure after the peak of the flow as a share of its pulse, negative before it."""
    count = len(pressure)
    later = (int(np.argmax(pressure)) - peak_of_flow) % count < count // 2
    return float((1 if later else -1) * (pressure.max() - pressure[peak_of_flow]) / np.ptp(pressure))
