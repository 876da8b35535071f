"""The pressure in a ventricle over one beat."""

from dataclasses import dataclass

import numpy as np

from vasowave.base.errors import InputError

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
            raise InputError(f"{self.source}: sample {int(np.argmin(np.isfinite(pressure))) + 1} is no finite number")
        if not np.ptp(pressure) > 1.0:
            raise InputError(f"{self.source}: the pressure changes by {np.ptp(pressure):.2g} mmHg; is its unit mmHg?")
        if not (np.isfinite(self.period) and self.period > 0):
            raise InputError(f"{self.source}: a period of {self.period:g} s; give a positive number")
        pressure.setflags(write=False)
        object.__setattr__(self, "pressure", pressure)
