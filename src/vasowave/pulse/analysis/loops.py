"""Loops of pressure and volume in a ventricle, beat by beat: where diastole and systole end, and what a loop tells."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.pulse.cycle.repetition import repeat_length
from vasowave.pulse.cycle.ventricular import PressureVolume


@dataclass(frozen=True)
class LoopRules:
    """How beats are found and what is read off them; shares are of the period unless they say otherwise."""

    heart_rates: tuple[float, float] = (30.0, 900.0)  # beats/min, between which beats are looked for
    upstroke_smoothing: float = 0.012  # SD of the smoothing by which upstrokes are looked for
    refractory_share: float = 0.55  # between two upstrokes, at least
    min_upstroke_share: float = 0.3  # of the steepness of the usual upstroke: it falls with the preload
    min_beat_samples: int = 20  # of a beat, below which slopes and corners mean nothing
    harmonics: int = 25  # of the heart, above which noise outweighs the signal: the cut-off of the filter
    onset_share: float = 0.08  # of the steepest rise, at which contraction begins
    max_rise: float = 0.35  # from where contraction begins to the steepest rise
    top_share: float = 0.75  # of the largest elastance: the cubic at its top goes through what has it
    top_reach: float = 0.2  # from the top, at most, of that cubic
    min_top_samples: int = 5  # of that cubic; of fewer the largest is taken
    top_places: int = 201  # at which it is computed
    corner_weight: float = 1.5  # of volume to pressure in the corner: the end-systolic line is steeper than the loop
    beats_around: int = 3  # on either side, whose median says where a beat is fullest and emptiest
    extreme_width: float = 0.05  # of the parabola that says the volume there
    relaxed_pressure: float = 5.0  # mmHg above the end of diastole, where relaxation ends (Weiss et al. 1976)
    relaxed_share: float = 0.05  # of the pulse: as much of that of a right ventricle
    min_relaxation_samples: int = 5


RULES = LoopRules()


class EndSystole(NamedTuple):
    """The point of a loop at the end of systole: ml, mmHg."""

    volume: float
    pressure: float


@dataclass(frozen=True, eq=False)
class PressureVolumeLoop:
    """One beat, from the end of a diastole to the end of the next.

    Attributes
    ----------
    start, period : float
        End of the diastole before it, s since the start of the recording; its length, s.
    pressure, volume, slope : float array, shape (sample,)
        mmHg, ml and dp/dt in mmHg/s; smoothed, both ends included.
    fullest, emptiest : int
        Samples at which the volume of the beats around is largest and smallest. Noise that chose the extremes of its
        own beat would make each stroke too large.
    """

    start: float
    period: float
    pressure: np.ndarray
    volume: np.ndarray
    slope: np.ndarray
    fullest: int
    emptiest: int

    def end_systole(self, zero_volume: float | None = None) -> EndSystole:
        """Return where the elastance ``p / (V - V0)`` is largest (Sagawa 1978), by a cubic through its top.

        Without `zero_volume`, ml, the upper left corner: where pressure over its range is farthest above 1.5 times the
        volume over its range, which no offset of the volume moves.
        """
        systole = slice(0, int(np.argmin(self.slope)) + 1)
        pressure, volume = self.pressure[systole], self.volume[systole]
        if zero_volume is None or not volume.min() > zero_volume:
            height = pressure / np.ptp(self.pressure) - RULES.corner_weight * volume / np.ptp(self.volume)
            corner = int(np.argmax(height))
            return EndSystole(float(volume[corner]), float(pressure[corner]))
        elastance = pressure / (volume - zero_volume)
        top, reach = int(np.argmax(elastance)), int(RULES.top_reach * len(self.pressure))
        first, last = max(top - reach, 0), min(top + reach + 1, len(elastance))
        high = elastance >= RULES.top_share * elastance[top]
        first = max([first, *(np.flatnonzero(~high[:top]) + 1)])
        last = min([last, *(np.flatnonzero(~high[top:]) + top)])
        if last - first < RULES.min_top_samples:
            return EndSystole(float(volume[top]), float(pressure[top]))
        places = np.arange(first, last) - top
        fine = np.linspace(places[0], places[-1], RULES.top_places)
        curve = np.polyval(np.polyfit(places, elastance[first:last], 3), fine)  # it rises more slowly than it falls
        highest = int(np.argmax(curve))
        volume_there = float(np.polyval(np.polyfit(places, volume[first:last], 1), fine[highest]))
        return EndSystole(volume_there, float(curve[highest]) * (volume_there - zero_volume))

    @property
    def largest_volume(self) -> float:
        """Volume where it is fullest, ml."""
        return _by_parabola(self.volume, self.fullest)

    @property
    def stroke_volume(self) -> float:
        """Volume where it is fullest less that where it is emptiest, ml."""
        return self.largest_volume - _by_parabola(self.volume, self.emptiest)

    @property
    def stroke_work(self) -> float:
        """Area of the closed loop, mJ, by Green's theorem; positive where it turns as hearts do."""
        p, V = self.pressure, self.volume
        return float(0.5 * units.MILLIWATT * np.sum(V * np.roll(p, -1) - p * np.roll(V, -1)))

    def values(self) -> dict[str, float]:
        """Return the numbers of the beat by the names of `VENTRICULAR`; NaN where it does not tell one.

        Those of the end of systole are of the corner, whether a V_0 is known or not: they mean the same in all animals.
        """
        end = self.end_systole()
        filled, stroke = float(self.volume[0]), self.stroke_volume
        logarithmic, asymptotic = relaxation(self)
        return {
            "HR": 60.0 / self.period,
            "EDV": filled,
            "ESV": end.volume,
            "SV": stroke,
            "EF": stroke / self.largest_volume if self.largest_volume > stroke else np.nan,
            "EDP": float(self.pressure[0]),
            "ESP": end.pressure,
            "stroke_work": self.stroke_work,
            "dp_dt_max": float(self.slope.max()),
            "dp_dt_min": float(self.slope.min()),
            "tau_weiss": logarithmic,
            "tau_glantz": asymptotic,
            "E_a": end.pressure / stroke,
        }


def relaxation(loop: PressureVolumeLoop) -> tuple[float, float]:
    """Return two time constants, s, of the fall of the pressure, from its steepest until near the next end of diastole.

    The logarithm of the pressure is a line in time (Weiss, Frederiksen and Weisfeldt 1976, doi 10.1172/JCI108522), or
    the pressure an exponential with an asymptote (Raff and Glantz 1981, doi 10.1161/01.RES.48.6.813). NaN where the
    fall has too few samples or no such constant.
    """
    first, ends = int(np.argmin(loop.slope)), float(loop.pressure[-1])
    above = min(RULES.relaxed_pressure, RULES.relaxed_share * float(np.ptp(loop.pressure)))
    low = np.flatnonzero(loop.pressure[first:] <= ends + above)
    last = first + int(low[0]) if len(low) else first
    pressure = loop.pressure[first:last]
    if len(pressure) < RULES.min_relaxation_samples:
        return np.nan, np.nan
    time = np.arange(len(pressure)) * loop.period / (len(loop.pressure) - 1)
    slope = np.polyfit(time, np.log(pressure), 1)[0] if pressure.min() > 0 else np.nan
    return (-1.0 / slope if slope < 0 else np.nan), _with_asymptote(time, pressure)


def _with_asymptote(time: np.ndarray, pressure: np.ndarray) -> float:
    """Return the time constant of an exponential with an asymptote, by least squares; NaN where none is best."""
    from scipy.optimize import minimize_scalar

    def misfit(log_tau: float) -> float:
        columns = np.stack([np.exp(-time / np.exp(log_tau)), np.ones_like(time)], axis=1)
        return float(np.sum((columns @ np.linalg.lstsq(columns, pressure)[0] - pressure) ** 2))

    bounds = float(np.log(0.1 * time[-1])), float(np.log(10.0 * time[-1]))
    best = float(minimize_scalar(misfit, bounds=bounds, method="bounded").x)
    return float(np.exp(best)) if bounds[0] + 0.05 < best < bounds[1] - 0.05 else np.nan


def mean_loop(loops: Sequence[PressureVolumeLoop], samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Return mean pressure and volume of beats at equal shares of each, both ends included."""
    shares = np.linspace(0.0, 1.0, samples + 1)

    def mean(waves: Sequence[np.ndarray]) -> np.ndarray:
        spread = [np.interp(shares, np.linspace(0.0, 1.0, len(wave)), wave) for wave in waves]
        return np.asarray(np.mean(spread, axis=0))

    return mean([loop.pressure for loop in loops]), mean([loop.volume for loop in loops])


class CutLoops(NamedTuple):
    """All loops of a recording, and the SD of the noise that is left in their volume, ml."""

    loops: tuple[PressureVolumeLoop, ...]
    volume_noise: float


def cut_loops(recording: PressureVolume) -> CutLoops:
    """Return the loops of a recording from end to end of diastole.

    Raises
    ------
    InputError
        Fewer than 20 samples a beat, a pressure below zero, a volume that stays; a pressure that does not beat between
        30 and 900 beats/min, or fewer than two beats.
    """
    length = beat_length(recording.pressure, recording.sampling_rate, recording.source)
    if length < RULES.min_beat_samples:
        raise InputError(
            f"{recording.source}: {length:.0f} samples a beat; loops need {RULES.min_beat_samples} or more: export at "
            "the full rate"
        )
    upstrokes = find_upstrokes(recording.pressure, length)
    pressure, volume = (_low_pass(values, length) for values in (recording.pressure, recording.volume))
    slope = np.gradient(pressure) * recording.sampling_rate
    starts = np.array([_end_of_diastole(slope, place, length) for place in upstrokes], dtype=int)
    starts = np.unique(starts[starts >= 0])
    if len(starts) < 2:
        raise InputError(
            f"{recording.source}: {len(starts)} ends of diastole in {recording.duration:.3g} s, and a loop lies "
            "between two; give a longer stretch"
        )
    beats = [slice(first, last + 1) for first, last in pairwise(starts)]
    loops = tuple(
        PressureVolumeLoop(
            float(recording.origin + beat.start / recording.sampling_rate),
            float((beat.stop - 1 - beat.start) / recording.sampling_rate),
            pressure[beat], volume[beat], slope[beat], *extremes,
        )
        for beat, extremes in zip(beats, _extremes([volume[beat] for beat in beats]), strict=True)
    )  # fmt: skip
    if not np.median([loop.pressure.max() for loop in loops]) > 0:
        raise InputError(f"{recording.source}: the pressure stays below 0 mmHg; correct its zero or its sign")
    if not np.median([loop.stroke_volume for loop in loops]) > 0:
        raise InputError(f"{recording.source}: the volume does not change within beats; is it the right channel?")
    passed = min(0.9, 2.0 * RULES.harmonics / length)  # of white noise, as a share of its power
    noise = float(np.std(recording.volume - volume)) * np.sqrt(passed / (1.0 - passed))
    return CutLoops(loops, noise)


def _extremes(volumes: Sequence[np.ndarray]) -> list[tuple[int, int]]:
    """Return where each beat is fullest and emptiest: where the median of those around it is."""
    from scipy.signal import savgol_filter

    places, reach = [], RULES.beats_around
    for number, volume in enumerate(volumes):
        around = [*volumes[max(number - reach, 0) : number], *volumes[number + 1 : number + 1 + reach]] or [volume]
        samples = np.arange(len(volume))
        usual = np.median([of_beat[np.minimum(samples, len(of_beat) - 1)] for of_beat in around], axis=0)
        usual = savgol_filter(usual, 2 * _reach(len(usual)) + 1, 2, mode="nearest")
        places.append((int(np.argmax(usual)), int(np.argmin(usual))))
    return places


def _by_parabola(values: np.ndarray, place: int) -> float:
    """Return a signal at a sample by a parabola through those about it."""
    first, last = max(place - _reach(len(values)), 0), place + _reach(len(values)) + 1
    window = values[first:last]
    return float(np.polyval(np.polyfit(np.arange(len(window)) - (place - first), window, min(2, len(window) - 1)), 0.0))


def _reach(samples: int) -> int:
    """Return half the width of the parabola in a beat of so many samples."""
    return max(1, round(0.5 * RULES.extreme_width * samples))


def beat_length(pressure: np.ndarray, rate: float, source: str = "recording") -> float:
    """Return the length of a beat in samples: the first strong peak of the autocorrelation of the pressure's slope."""
    change = np.diff(pressure)
    change = change - change.mean()
    first, last = (rate * 60.0 / beats for beats in reversed(RULES.heart_rates))
    last = min(last, 0.6 * len(change))
    length = repeat_length(change, first, last, max(0.1 * first, 0.5))
    if length is None:
        slowest, fastest = RULES.heart_rates
        lowest, highest = (float(end) for end in np.quantile(pressure, (0.01, 0.99)))
        raise InputError(
            f"{source}: the pressure does not beat between {slowest:g} and {fastest:g} beats/min: "
            f"{len(pressure) / rate:.3g} s between {lowest:.3g} and {highest:.3g} mmHg. Loops need three beats or "
            "more: give a longer stretch, or name the channel that holds the pressure"
        )
    return length


def find_upstrokes(pressure: np.ndarray, length: float) -> np.ndarray:
    """Return the samples where the pressure rises most steeply in each beat of about `length` samples."""
    from scipy.signal import find_peaks

    rise = np.gradient(_smooth(pressure, RULES.upstroke_smoothing * length))
    width = max(1, int(length))
    blocks = rise[: len(rise) // width * width].reshape(-1, width).max(axis=1)
    height = RULES.min_upstroke_share * float(np.median(blocks)) if len(blocks) else 0.0
    return np.asarray(find_peaks(rise, height=height, distance=max(1, int(RULES.refractory_share * length)))[0])


def _end_of_diastole(slope: np.ndarray, upstroke: int, length: float) -> int:
    """Return the sample before an upstroke at which contraction begins, -1 where the recording begins later."""
    reach = max(2, int(0.03 * length))
    steepest = max(upstroke - reach, 0) + int(np.argmax(slope[max(upstroke - reach, 0) : upstroke + reach + 1]))
    first = steepest - int(RULES.max_rise * length)
    before = slope[max(first, 0) : steepest][::-1]
    slow = np.flatnonzero(before < RULES.onset_share * slope[steepest])
    if len(slow):
        return steepest - 1 - int(slow[0])
    return -1 if first < 0 else steepest - 1 - int(np.argmin(before))


def _low_pass(values: np.ndarray, length: float) -> np.ndarray:
    """Return a signal without what is faster than the harmonics of the heart that are kept, without delay."""
    from scipy.signal import butter, sosfiltfilt

    if 2.0 * RULES.harmonics / length > 0.9:
        return np.asarray(values, dtype=float)
    return np.asarray(sosfiltfilt(butter(4, 2.0 * RULES.harmonics / length, output="sos"), values))


def _smooth(values: np.ndarray, samples: float) -> np.ndarray:
    from scipy.ndimage import gaussian_filter1d

    return np.asarray(gaussian_filter1d(values, max(samples, 0.5)))
