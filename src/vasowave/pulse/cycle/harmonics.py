"""Up to which harmonic a cycle carries signal: the standard error of every harmonic, and what stands above it."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.pulse.cycle.averaged import EnsembleAverage
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.cycle.waveform import amplitudes

_MIN_POWER_RATIO = 4.0
"""A harmonic adds signal if its square exceeds this many times its expected square error."""

_FLAT_OCTAVE_RATIO = 1.5
"""A spectrum is flat where it falls by less than this factor from octave to octave."""


class HarmonicErrors(NamedTuple):
    """The harmonics of a cycle and what is known of their errors.

    Attributes
    ----------
    modulus : float array, shape (harmonic,)
        Amplitude of harmonics 0 (the mean), 1, 2 …, in the unit of the signal.
    error : float array, shape (harmonic,)
        Standard error of the amplitude.
    source : str
        ``beats`` (scatter from beat to beat), or ``file`` (rounding and the cycle's own highest harmonics).
    """

    modulus: np.ndarray
    error: np.ndarray
    source: str

    @property
    def with_signal(self) -> int:
        """The harmonic up to which signal stands above the error; 0 if none does.

        Cut off where the expected square error of the cycle is least, with a margin: the sum over harmonics of
        modulus² - 4 · (expected square error) is largest there. A single weak harmonic below stronger ones does not end
        the signal, a single strong one far above the others' end does not prolong it.
        """
        gain = np.cumsum(self.modulus[1:] ** 2 - _MIN_POWER_RATIO * 2.0 * self.error[1:] ** 2)
        return int(np.argmax(gain)) + 1 if len(gain) and gain.max() > 0 else 0


def harmonic_errors(cycle: EnsembleAverage | Recording, signal: str = "pressure") -> HarmonicErrors:
    """Return the harmonics of the pressure (mmHg) or flow (ml/s) and their standard errors.

    Of averaged beats, the error is the scatter of each harmonic from beat to beat, divided by the root of their number.
    Of a cycle that came averaged, beats are not known: errors are the larger of the rounding of its numbers and the
    level at which its spectrum becomes flat, as of white noise. A cycle that was smoothed before it was written hides
    its noise, and its errors are then too small: they are a lower bound.

    Parameters
    ----------
    cycle : EnsembleAverage or Recording
    signal : {"pressure", "flow"}

    Raises
    ------
    InputError
        A signal that is neither.
    """
    if signal not in ("pressure", "flow"):
        raise InputError(f"signal '{signal}' is neither 'pressure' nor 'flow'")
    recording = cycle.recording if isinstance(cycle, EnsembleAverage) else cycle
    values, errors = getattr(recording, signal), getattr(recording, f"{signal}_error")
    modulus = _modulus(values)
    if errors is not None:
        count = min(len(modulus), len(errors))
        return HarmonicErrors(modulus[:count], errors[:count], "beats")
    floor = _floor(modulus)
    rounding = _quantum(values) / np.sqrt(12.0) * np.sqrt(2.0 / len(values))
    error = np.full(len(modulus), max(floor, rounding))
    error[0] /= np.sqrt(2.0)
    return HarmonicErrors(modulus, error, "file")


def _floor(modulus: np.ndarray) -> float:
    """Return the standard error that the flat part of a spectrum tells.

    Signals of the heart lose more than a third of their modulus from octave to octave. A file that was interpolated is
    empty above the rate it was recorded at, so the first flat part counts, not the highest harmonics.
    """
    edges = [8]
    while 2 * edges[-1] <= len(modulus):
        edges.append(2 * edges[-1])
    levels = [float(np.sqrt(np.mean(modulus[a:b] ** 2))) for a, b in pairwise(edges)]
    flat = [i for i in range(len(levels) - 1) if levels[i] < _FLAT_OCTAVE_RATIO * levels[i + 1]]
    if not flat:
        return float(np.sqrt(0.5 * np.mean(modulus[-(len(modulus) // 4) :] ** 2)))
    last = next((i for i in range(flat[0], len(levels) - 1) if i not in flat), len(levels) - 1)
    return float(np.sqrt(0.5 * np.mean(modulus[edges[flat[0]] : edges[last + 1]] ** 2)))


def _modulus(values: np.ndarray) -> np.ndarray:
    return np.abs(amplitudes(values))


def _quantum(values: np.ndarray) -> float:
    """Return the step to which numbers were rounded: the coarsest power of ten, or half of it or a fifth, that fits."""
    scale = float(np.abs(values).max())
    for exponent in range(int(np.floor(np.log10(scale))) if scale else 0, -12, -1):
        for step in (10.0**exponent, 0.5 * 10.0**exponent, 0.2 * 10.0**exponent):
            if np.all(np.abs(values / step - np.rint(values / step)) < 1e-6 * np.maximum(1.0, np.abs(values / step))):
                return step
    return 0.0
