"""From the beats of a continuous recording to one averaged cycle, with the scatter of the beats around it."""

import warnings
from collections import Counter
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt, Le

from vasowave.errors import InputError, NumericalError, VasowaveWarning
from vasowave.recording.beats import HEART_RATES, find_beats, foot
from vasowave.recording.cycle import FEWEST_SAMPLES, Recording
from vasowave.recording.plausibility import check_flow, check_pressure, odd_values
from vasowave.recording.raw import RawRecording
from vasowave.recording.rejection import rejection_reasons
from vasowave.settings import Range


@dataclass(frozen=True)
class Beat:
    """One detected beat.

    Attributes
    ----------
    start, end : float
        s since the first sample.
    averaged : bool
        Whether it is part of the average.
    rejected : str
        Why it may not be averaged; empty for a good beat.
    """

    start: float
    end: float
    averaged: bool
    rejected: str = ""


@dataclass(frozen=True, eq=False)
class EnsembleAverage:
    """The average of consecutive beats.

    Attributes
    ----------
    recording : Recording
        The averaged cycle; its notes say which beats it came from.
    pressure_sd, flow_sd : float array, shape (sample,)
        Standard deviation of the averaged beats around the cycle, mmHg and ml/s.
    beats : tuple of Beat
        Every detected beat, in order.
    fiducial : str
        ``ecg`` or ``pressure``: what the beats were aligned by.
    delay : float
        p-q delay: by how much the foot of the flow follows the foot of the pressure, s.
    delay_corrected : bool
        Whether the flow was advanced by `delay`.
    """

    recording: Recording
    pressure_sd: np.ndarray
    flow_sd: np.ndarray
    beats: tuple[Beat, ...]
    fiducial: str
    delay: float
    delay_corrected: bool

    def __repr__(self) -> str:
        used = sum(beat.averaged for beat in self.beats)
        lost = sum(bool(beat.rejected) for beat in self.beats)
        return f"EnsembleAverage({used} of {len(self.beats)} beats, {lost} rejected, {self.recording!r})"


def average_beats(
    raw: RawRecording,
    beats: Annotated[int, Ge(2)] = 20,
    *,
    samples: Annotated[int, Ge(FEWEST_SAMPLES)] = 256,
    harmonics: Annotated[int, Ge(1)] | None = 20,
    fiducial: Literal["ecg", "pressure"] | None = None,
    heart_rates: Range = HEART_RATES,
    length_tolerance: Annotated[float, Gt(0), Le(1)] = 0.1,
    least_correlation: Annotated[float, Ge(-1), Le(1)] = 0.9,
    reject_ventilation: bool = True,
    correct_delay: bool = False,
) -> EnsembleAverage:
    """Average consecutive beats of pressure and flow to one cycle, with the ECG as fiducial.

    Each beat, from one fiducial to the next, is brought to `samples` samples and thereby to the mean length. Of all
    runs of beats that hold `beats` good ones, the run with the fewest rejected beats is averaged, the first of equals.
    The mean step from the cycle's end to its start is then spread over the cycle as a straight line of mean zero.

    Parameters
    ----------
    raw : RawRecording
    beats : int
        Number of beats to average, 20 in the paper.
    samples : int
        Samples of the cycle.
    harmonics : int, optional
        Harmonics of the averaged cycle that are kept; None keeps all. What is above 20 is noise, which would push the
        largest and the smallest value (sPAP, dPAP) apart.
    fiducial : {"ecg", "pressure"}, optional
        R wave, or foot of the pressure; the ECG by default, where there is one.
    heart_rates : (float, float), optional
        Slowest and fastest heart rate to look for, beats/min.
    length_tolerance : float
        A beat whose length differs by a larger fraction from the median of its neighbours is rejected.
    least_correlation : float
        A beat whose pressure or flow correlates less with the median beat is rejected.
    reject_ventilation : bool
        Whether a beat whose mean pressure or flow stands off the end-expiratory level (more than 2.5 SD of the
        narrowest quarter of all beats) is rejected.
    correct_delay : bool
        Whether the flow is advanced by the estimated p-q delay. It is estimated in any case.

    Raises
    ------
    InputError
        An argument out of range; a recording with fewer than `beats` beats; a pressure or flow of impossible size.
    NumericalError
        No beats found, or fewer than `beats` good ones: the reasons are counted.

    Warns
    -----
    VasowaveWarning
        If more than half of the beats in the averaged run were rejected, or a value looks like a slip.
    """
    if harmonics is not None and harmonics < 1:
        raise InputError(f"harmonics={harmonics}: at least one must be kept; None keeps all")
    if beats < 2 or samples < FEWEST_SAMPLES:
        raise InputError(f"beats={beats}, samples={samples}: at least 2 beats and {FEWEST_SAMPLES} samples are needed")
    found = find_beats(raw, fiducial, heart_rates)
    starts, ends = found.times[:-1], found.times[1:]
    if len(starts) < beats:
        raise InputError(
            f"{raw.source}: {len(starts)} whole beats found, {beats} wanted; record longer or average fewer"
        )
    pressure, flow = (_cut(values, raw.sampling_rate, found.times, samples + 1) for values in (raw.pressure, raw.flow))
    reasons = rejection_reasons(ends - starts, pressure, flow, length_tolerance, least_correlation, reject_ventilation)
    used, run = _choose(reasons, beats, raw.source)
    period = float(np.mean((ends - starts)[used]))
    cycles, notes = [], [] if harmonics is None else [f"harmonics above {harmonics} of the cycle were left out"]
    for name, cut in (("pressure", pressure[used]), ("flow", flow[used])):
        cycle, step = _close(cut.mean(axis=0))
        cycles.append(cycle if harmonics is None else _low_pass(cycle, harmonics))
        notes.append(f"{name}: a step of {100 * step:.2g} % of its range from end to start was spread over the cycle")
    check_pressure(cycles[0], raw.source)
    check_flow(cycles[1], raw.source)
    delay = _delay(cycles[0], cycles[1], period)
    deviations = [cut[used, :-1].std(axis=0, ddof=1) for cut in (pressure, flow)]
    if correct_delay:
        cycles[1], deviations[1] = (_advance(values, delay / period) for values in (cycles[1], deviations[1]))
        notes.append(f"the flow was advanced by the estimated p-q delay of {1e3 * delay:.2f} ms")
    warned = odd_values(cycles[0], cycles[1], period)
    lost = sum(bool(reasons[i]) for i in range(run.start, run.stop))
    if lost > beats:
        warned.append(
            f"{lost} of the {run.stop - run.start} beats between the first and the last averaged were rejected"
        )
    for message in warned:
        warnings.warn(f"{raw.source}: {message}", VasowaveWarning, stacklevel=2)
    summary = _summary(found.fiducial, reasons, beats, starts[used[0]], ends[used[-1]])
    recording = Recording(cycles[0], cycles[1], period, raw.source, (*raw.notes, summary, *notes, *warned))
    chosen = set(used.tolist())
    listed = tuple(Beat(float(starts[i]), float(ends[i]), i in chosen, reason) for i, reason in enumerate(reasons))
    return EnsembleAverage(
        recording, deviations[0], np.maximum(deviations[1], 0.0), listed, found.fiducial, delay, correct_delay
    )


def _cut(values: np.ndarray, rate: float, times: np.ndarray, count: int) -> np.ndarray:
    """Return every beat at `count` evenly spaced times, both ends included, shape (beat, sample)."""
    from scipy.interpolate import CubicSpline

    phase = np.linspace(0.0, 1.0, count)
    at = times[:-1, None] + np.diff(times)[:, None] * phase
    return CubicSpline(np.arange(len(values)) / rate, values)(at)


def _choose(reasons: list[str], beats: int, source: str) -> tuple[np.ndarray, range]:
    """Return the indices of the beats to average, and the run of beats they come from."""
    good = np.array([i for i, reason in enumerate(reasons) if not reason], dtype=int)
    if len(good) < beats:
        kinds = Counter(reason.split(" ")[0].strip(":") for reason in reasons if reason)
        counted = ", ".join(f"{count} for {kind}" for kind, count in kinds.most_common())
        raise NumericalError(
            f"{source}: {len(good)} good beats of {len(reasons)}, {beats} wanted (rejected: {counted}); look at the "
            "beats, choose another stretch, relax the rules or average fewer"
        )
    first = int(np.argmin(good[beats - 1 :] - good[: len(good) - beats + 1]))
    used = good[first : first + beats]
    return used, range(int(used[0]), int(used[-1]) + 1)


def _close(mean: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the cycle without its repeated last sample, closed, and the step it had as a fraction of its range."""
    step = mean[-1] - mean[0]
    closed = mean - step * (np.linspace(0.0, 1.0, len(mean)) - 0.5)
    return closed[:-1], float(step / max(np.ptp(mean), 1e-300))


def _delay(pressure: np.ndarray, flow: np.ndarray, period: float) -> float:
    """Return by how much the foot of the flow follows that of the pressure, s.

    Before reflections return, pressure and flow rise together, so their feet belong to one instant.
    """
    count = len(pressure)
    feet = []
    for values in (pressure, flow):
        smooth = _low_pass(values, 12)
        top = int(np.argmax(np.roll(smooth, -1) - np.roll(smooth, 1)))
        # Turned so that the upstroke stands in the middle and the foot cannot fall off the start.
        turned = np.roll(smooth, count // 2 - top)[count // 4 :]
        feet.append(foot(turned, count // 2 - count // 4) + top - (count // 2 - count // 4))
    return float((feet[1] - feet[0] + 0.5 * count) % count - 0.5 * count) / count * period


def _low_pass(values: np.ndarray, harmonics: int) -> np.ndarray:
    spectrum = np.fft.rfft(values)
    spectrum[harmonics + 1 :] = 0
    return np.fft.irfft(spectrum, len(values))


def _advance(values: np.ndarray, cycles: float) -> np.ndarray:
    """Return a periodic signal earlier by a fraction of a cycle, by its Fourier phases."""
    harmonic = np.fft.rfftfreq(len(values), 1.0 / len(values))
    return np.fft.irfft(np.fft.rfft(values) * np.exp(2j * np.pi * harmonic * cycles), len(values))


def _summary(fiducial: str, reasons: list[str], beats: int, start: float, end: float) -> str:
    kinds = Counter(reason.split(" ")[0].strip(":") for reason in reasons if reason)
    lost = ", ".join(f"{count} for {kind}" for kind, count in kinds.most_common()) or "none"
    by = "R wave" if fiducial == "ecg" else "foot of the pressure"
    return (
        f"mean of {beats} beats from {start:.3f} to {end:.3f} s, aligned by the {by}; "
        f"{len(reasons)} beats found, rejected: {lost}"
    )
