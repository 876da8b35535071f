"""The pressure in a ventricle: over one beat, and with its volume over many."""

from dataclasses import dataclass

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding

_MIN_SAMPLES = 32  # of a cycle


@dataclass(frozen=True, eq=False)
class VentricularPressure:
    """The pressure in a ventricle over one beat, recorded for itself, not in step with that in the artery.

    Attributes
    ----------
    pressure : float array, shape (sample,)
        Evenly spaced over one period from anywhere in the cycle, not repeated at the end; mmHg.
    period : float
        s.
    source : str
        Where it came from.
    beats : int
        Of how many it is the average.

    Raises
    ------
    InputError
        Fewer than 32 samples, a value that is not finite, a pressure that hardly changes, no positive period.

    Examples
    --------
    >>> import numpy as np
    >>> import vasowave as vw
    >>> pressure = 2 + 24 * np.sin(np.pi * np.arange(64) / 64) ** 2
    >>> vw.VentricularPressure(pressure, period=0.11).beats
    1
    """

    pressure: np.ndarray
    period: float
    source: str = "made in memory"
    beats: int = 1

    def __post_init__(self) -> None:
        """Check the values and freeze the array."""
        pressure = np.array(self.pressure, dtype=float)
        if pressure.ndim != 1 or len(pressure) < _MIN_SAMPLES:
            raise InputError(f"{self.source}: a ventricle's pressure needs {_MIN_SAMPLES} samples or more of one cycle")
        if not np.all(np.isfinite(pressure)):
            raise InputError(
                f"{self.source}: sample {int(np.argmin(np.isfinite(pressure))) + 1} is not a finite number"
            )
        if not np.ptp(pressure) > 1.0:
            raise InputError(f"{self.source}: the pressure changes by {np.ptp(pressure):.2g} mmHg; is its unit mmHg?")
        if not (np.isfinite(self.period) and self.period > 0):
            raise InputError(f"{self.source}: a period of {self.period:g} s; give a positive number")
        pressure.setflags(write=False)
        object.__setattr__(self, "pressure", pressure)


@dataclass(frozen=True, eq=False)
class PressureVolume:
    """Pressure and volume of a ventricle, recorded together over many beats.

    Attributes
    ----------
    pressure : float array, shape (sample,)
        mmHg.
    volume : float array, shape (sample,)
        ml.
    sampling_rate : float
        Samples per second.
    source : str
        Where it came from.
    notes : tuple of Finding
        What was noticed or assumed while it was read.
    origin : float
        Time of the first sample, s: where a stretch was cut out of a longer recording.
    volume_delay : float
        By how much the volume has been made earlier already, s.

    Raises
    ------
    InputError
        Signals of different length or fewer than 32 samples, a value that is not finite, a signal that does not change,
        a rate that is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> import vasowave as vw
    >>> turn = 2 * np.pi * np.arange(0, 4, 0.002)
    >>> vw.PressureVolume(40 - 40 * np.cos(turn), 90 + 30 * np.sin(turn), sampling_rate=500).duration  # s
    4.0
    """

    pressure: np.ndarray
    volume: np.ndarray
    sampling_rate: float
    source: str = "made in memory"
    notes: tuple[Finding, ...] = ()
    origin: float = 0.0
    volume_delay: float = 0.0

    def __post_init__(self) -> None:
        """Check the values and freeze the arrays."""
        if not (np.isfinite(self.sampling_rate) and self.sampling_rate > 0):
            raise InputError(f"{self.source}: {self.sampling_rate:g} samples/s; give a positive number")
        for name in ("pressure", "volume"):
            values = np.array(getattr(self, name), dtype=float)
            if values.ndim != 1 or len(values) < _MIN_SAMPLES or len(values) != len(self.pressure):
                raise InputError(
                    f"{self.source}: pressure and volume need {_MIN_SAMPLES} samples or more, as many each"
                )
            if not np.all(np.isfinite(values)):
                place = self.origin + int(np.argmin(np.isfinite(values))) / self.sampling_rate
                raise InputError(f"{self.source}: {name} has a gap at {place:.4f} s; choose a stretch without")
            if not np.ptp(values) > 0:
                raise InputError(f"{self.source}: the {name} does not change; is it the right channel?")
            values.setflags(write=False)
            object.__setattr__(self, name, values)

    @property
    def duration(self) -> float:
        """Length, s."""
        return len(self.pressure) / self.sampling_rate
