"""The pressure in the ventricle that ejects into the network: one averaged cycle, or some seconds of beats."""

from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.columns import read_columns
from vasowave.catheter.read.single_wave import single_wave
from vasowave.catheter.signals.signal import ALIASES
from vasowave.pulse.cycle.ventricular import VentricularPressure

_UPSTROKE_SLOPE_SHARE = 0.5  # share of the steepest rise from which one is the upstroke of a beat
_MIN_BEAT_DISTANCE = 0.6  # share of the usual distance that lies between two beats at least
_CYCLE_SAMPLES = 512  # samples of an averaged beat
_UPSTROKE_HARMONICS = 15  # harmonics of the heart in which upstrokes are looked for
_NAMES = {"ventricle": "pressure", "rvp": "pressure", "lvp": "pressure", "ventricular pressure": "pressure"}


def read_ventricle(path: str | Path, period: float | None = None) -> VentricularPressure:
    """Read the pressure in a ventricle: a table with a column of time, of one cycle or of several beats.

    Several beats are averaged from upstroke to upstroke. Without a column of time the file is one cycle of `period`, s.

    Raises
    ------
    InputError
        File and line of what cannot be read; no pressure; neither a time nor a period.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(110) / 1000
    >>> pressure = 2 + 24 * np.sin(np.pi * np.minimum(t / 0.05, 1)) ** 2
    >>> np.savetxt("rv.csv", np.c_[t, pressure], delimiter=",", header="time [s],pressure [mmHg]", comments="")
    >>> from vasowave.catheter.read.ventricle import read_ventricle
    >>> read_ventricle("rv.csv").period
    0.11
    """
    table = read_columns(path, {**ALIASES, **_NAMES})
    wave = single_wave(table, "pressure", "pressure", "mmHg")
    values, starts = wave.values, _upstrokes(wave.values)
    if wave.step is None and period is None:
        raise InputError(f"{path}: no column of time; add one, or give the period of the cycle")
    if len(starts) > 1 and wave.step is None:
        raise InputError(f"{path}: {len(starts)} beats and no column of time; add one, or leave one cycle")
    if len(starts) > 1 and wave.step is not None:
        return _averaged(values, starts, wave.step, str(path))
    cycle, lasts = wave.cycle()
    return VentricularPressure(cycle, float(lasts or period or 0.0), str(path))


def _upstrokes(pressure: np.ndarray) -> np.ndarray:
    """Return the samples where the pressure rises most steeply in each beat; none of a single cycle."""
    from scipy.signal import find_peaks

    spectrum = np.fft.rfft(pressure - pressure.mean())
    beats = int(np.argmax(np.abs(spectrum)))
    if beats < 2:
        return np.zeros(0, dtype=int)
    spectrum[_UPSTROKE_HARMONICS * beats :] = 0
    rise = np.gradient(np.fft.irfft(spectrum, len(pressure)))
    peaks, _ = find_peaks(
        rise, height=_UPSTROKE_SLOPE_SHARE * rise.max(), distance=max(_MIN_BEAT_DISTANCE * len(pressure) / beats, 1.0)
    )
    return np.asarray(peaks)


def _averaged(pressure: np.ndarray, starts: np.ndarray, step: float, source: str) -> VentricularPressure:
    """Return the mean beat from upstroke to upstroke; beats whose length is far from the usual one are left out."""
    lengths = np.diff(starts)
    usual = float(np.median(lengths))
    beats = np.flatnonzero(np.abs(lengths - usual) < 0.2 * usual)
    if not len(beats):
        shortest, longest = step * lengths.min(), step * lengths.max()
        raise InputError(
            f"{source}: its beats last {shortest:.3g} to {longest:.3g} s, none of them about as long as usual; give "
            "more beats, or one cycle"
        )
    shares = np.arange(_CYCLE_SAMPLES) / _CYCLE_SAMPLES
    cycles = [np.interp(starts[k] + shares * lengths[k], np.arange(len(pressure)), pressure) for k in beats]
    return VentricularPressure(np.mean(cycles, axis=0), float(np.mean(lengths[beats])) * step, source, len(beats))
