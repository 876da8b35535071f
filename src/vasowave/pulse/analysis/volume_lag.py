"""How much later the volume of a ventricle comes than its pressure, by where ejection and filling begin.

A ventricle ejects from about the steepest rise of its pressure on, and fills once its pressure is down to that at the
end of diastole: valves open there. Both places are read off the mean steady beat.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vasowave.pulse.analysis.loops import PressureVolumeLoop, mean_loop


@dataclass(frozen=True)
class VolumeLagRules:
    """What is read off the mean beat."""

    samples: int = 400  # of the mean beat
    harmonics: float = 12.0  # at which its Gaussian smoothing has fallen to 0.6
    begun_share: float = 0.15  # of the peak of outflow and inflow, at which either has begun
    filling_share: float = 0.35  # of a beat from where it is emptiest, in which its first inflow peaks
    relaxed_share: float = 0.02  # of the pulse above the end of diastole, at which filling begins
    max_share: float = 0.015  # of a beat, by which ejection and filling may both be late


RULES = VolumeLagRules()


class VolumeLag(NamedTuple):
    """By which share of a beat ejection and filling begin later in the volume than by the pressure."""

    ejection: float
    filling: float

    @property
    def mean(self) -> float:
        """The lag of the volume, as a share of the beat."""
        return 0.5 * (self.ejection + self.filling)

    @property
    def sure(self) -> bool:
        """Whether both tell the same sign, and more than a heart makes: hearts in step have one of them near 0."""
        return self.ejection * self.filling > 0 and min(abs(self.ejection), abs(self.filling)) > RULES.max_share


def volume_lag(loops: Sequence[PressureVolumeLoop]) -> VolumeLag:
    """Return by how much the volume of steady beats comes later than their pressure."""
    pressure, volume = mean_loop(loops, RULES.samples)
    at_end = float(pressure[0])
    pressure, rise = _with_slope(pressure)
    volume, inflow = _with_slope(volume)
    count, falls = len(volume), int(np.argmin(rise))
    fills = (int(np.argmin(volume)) + np.arange(int(RULES.filling_share * count))) % count
    fullest_inflow = int(fills[np.argmax(inflow[fills])])
    ejection = _falls_below(-inflow, int(np.argmin(inflow)), RULES.begun_share * float(-inflow.min()), -1)
    filling = _falls_below(inflow, fullest_inflow, RULES.begun_share * float(inflow[fullest_inflow]), -1)
    relaxed = _falls_below(pressure, falls, at_end + RULES.relaxed_share * float(np.ptp(pressure)), 1)
    late = np.array([ejection - int(np.argmax(rise)), filling - relaxed]) / count
    return VolumeLag(*map(float, (late + 0.5) % 1.0 - 0.5))


def _with_slope(wave: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a beat and its slope, both smooth and periodic."""
    count = len(wave) - 1
    number = np.arange(count // 2 + 1)
    closed = wave[:-1] - (wave[-1] - wave[0]) * np.arange(count) / count
    spectrum = np.fft.rfft(closed) * np.exp(-0.5 * (number / RULES.harmonics) ** 2)
    return np.fft.irfft(spectrum, count), np.fft.irfft(2j * np.pi * number * spectrum, count)


def _falls_below(wave: np.ndarray, start: int, level: float, step: int) -> float:
    """Return where a periodic wave first falls below a level, in samples, from one of them on; NaN where nowhere."""
    turned = np.roll(wave[::step], -(start if step > 0 else len(wave) - 1 - start))
    low = np.flatnonzero(turned < level)
    if not len(low) or low[0] == 0:
        return float("nan")
    before, after = turned[low[0] - 1], turned[low[0]]
    return start + step * float(low[0] - 1 + (before - level) / (before - after))
