"""A ventricle that drives a network: an elastance that varies in time, behind a valve.

Its pressure is ``E(t) (V - V0)``, and its volume becomes less by what it ejects. A cycle begins where the ventricle
begins to contract, filled to the volume at which its resting elastance holds the filling pressure.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from vasowave.base.errors import InputError
from vasowave.pulse.cycle.cycle import Inflow, InletPressure, require_one

LEAST_SAMPLES = 64
_CYCLES, _STEPS = 60, 512  # of the ejection into three elements
RISE, FALL = 1.9, 21.9
"""Exponents of the normalized elastance of Stergiopulos et al. (1996)."""

_RISEN, _FALLEN = 0.7, 1.17  # its times, in times of the peak
_AROUND_PEAK = np.linspace(0.3, 1.6, 1301)  # times at which the peak is looked for


def activation(time: np.ndarray, peak: float) -> np.ndarray:
    """Return the elastance's rise from rest (0) to its peak (1) and back, at times `time` since contraction began.

    `peak` is the time of the peak, in the unit of `time`. Source: the normalized elastance of Stergiopulos, Meister and
    Westerhof (1996), doi 10.1152/ajpheart.1996.270.6.H2050, which Senzaki et al. (1996) found alike in hearts of all
    kinds.
    """
    return raised(np.asarray(time, dtype=float) / peak, RISE, FALL, 1.0)


def raised(t: np.ndarray, rise: float, fall: float, width: float) -> np.ndarray:
    """Return `activation` at times `t`, in times of the peak, with other exponents and times of fall over rise."""
    top = _two_hills(_AROUND_PEAK, rise, fall, width).max()
    return np.asarray(_two_hills(np.clip(t, 1e-9, 1e3), rise, fall, width) / top)


def _two_hills(t: np.ndarray, rise: float, fall: float, width: float) -> np.ndarray:
    risen, fallen = (
        np.exp(np.clip(exponent, -500.0, 500.0))
        for exponent in (rise * np.log(t * np.sqrt(width) / _RISEN), fall * np.log(t / (_FALLEN * np.sqrt(width))))
    )
    return np.asarray(risen / (1.0 + risen) / (1.0 + fallen))


@dataclass(frozen=True, eq=False)
class Ventricle:
    """A ventricle at the inlet of the root vessel: pressure and flow there follow from it and from the network.

    Attributes
    ----------
    elastance : float array, shape (sample,)
        E(t) over one cycle from where contraction begins, the first sample at t = 0, not repeated at the end; mmHg/ml.
    period : float
        Period T, s.
    filling_pressure : float
        At the end of filling, mmHg: the volume above V0 is then ``filling_pressure / E(0)``.
    valve_resistance : float
        Of the open valve, mmHg s/ml. It lets nothing back.

    Raises
    ------
    InputError
        Fewer than 64 samples, a number that is not positive and finite.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> nominal = vw.estimate_nominal(network, mouse)
    >>> model = vw.Model(network, vw.LinearWall(60.0), nominal.outlets)
    >>> ventricle = vw.Ventricle.from_peak(1400.0, rest=100.0, period=0.11, filling_pressure=4.0)
    >>> waves = vw.simulate(model, ventricle)
    >>> round(float(waves.ventricular_volume[0]), 3)  # ml above V0, when contraction begins
    0.04
    """

    elastance: np.ndarray
    period: float
    filling_pressure: float
    valve_resistance: float = 0.01

    of_pressure: ClassVar[bool] = False
    """Whether what is given is a pressure."""

    def __post_init__(self) -> None:
        """Check the values and freeze the array."""
        elastance = np.array(self.elastance, dtype=float)
        if elastance.ndim != 1 or len(elastance) < LEAST_SAMPLES:
            raise InputError(f"the elastance of a ventricle is one row of {LEAST_SAMPLES} samples or more")
        if not np.all(np.isfinite(elastance) & (elastance > 0)):
            raise InputError("the elastance of a ventricle is positive at all times, mmHg/ml")
        elastance.setflags(write=False)
        object.__setattr__(self, "elastance", elastance)
        for name, unit in (("period", "s"), ("filling_pressure", "mmHg"), ("valve_resistance", "mmHg s/ml")):
            value = float(getattr(self, name))
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"the {name} of a ventricle is {value:g} {unit}; give a positive number")
            object.__setattr__(self, name, value)

    @classmethod
    def from_peak(
        cls,
        peak: float,
        rest: float,
        period: float,
        filling_pressure: float,
        *,
        at: float = 0.35,
        valve_resistance: float = 0.01,
    ) -> Self:
        """Return a ventricle whose elastance rises from `rest` to `peak` (mmHg/ml) as `activation` does.

        `at` is when it peaks, as a share of the period. Raises `InputError` for numbers that no ventricle has.
        """
        if not 0 < rest < peak:
            raise InputError(f"the elastance at rest, {rest:g}, is positive and below that of the peak, {peak:g}")
        if not 0 < at < 1:
            raise InputError(f"at = {at:g}: the peak lies between 0 and 1 period after contraction begins")
        shape = activation(np.arange(_STEPS) / _STEPS, at)
        return cls(rest + (peak - rest) * shape, period, filling_pressure, valve_resistance)

    @property
    def filled(self) -> float:
        """Volume above V0 when contraction begins, ml."""
        return float(self.filling_pressure / self.elastance[0])

    def into(self, inlets: Sequence[str]) -> np.ndarray:
        """Return the elastance at the only one of these inlets, mmHg/ml, (sample, 1); `InputError` for several."""
        require_one(inlets, "a ventricle")
        return self.elastance.reshape(-1, 1)

    def resampled(self, count: int) -> np.ndarray:
        """Return `count` evenly spaced values of the elastance, mmHg/ml, on straight lines between the samples."""
        times = np.arange(len(self.elastance)) / len(self.elastance)
        return np.interp(np.arange(count) / count, times, self.elastance, period=1.0)

    def ejecting(self, impedance: float, resistance: float, compliance: float, behind: float) -> Inflow:
        """Return the flow into a bed of three elements before the pressure `behind` (mmHg): a guess for a network.

        `impedance` (mmHg s/ml) stands before `resistance` and `compliance` (ml/mmHg), which lie side by side.
        """
        dt = self.period / _STEPS
        decay, flow = math.exp(-dt / (resistance * compliance)), np.zeros(_STEPS)
        above = self.filled * self.elastance.max() / 4  # pressure of the compliance above that behind
        for _ in range(_CYCLES):
            volume, before = self.filled, above
            for n, stiff in enumerate(self.resampled(_STEPS)):
                meets = self.valve_resistance + impedance + stiff * dt / 2
                flow[n] = max((stiff * volume - above - behind) / meets, 0.0)
                volume -= flow[n] * dt
                above = decay * above + (1.0 - decay) * resistance * flow[n]
            if abs(above - before) < 1e-3:
                break
        return Inflow(flow, self.period)


Driven = Inflow | InletPressure | Ventricle
"""What drives a network."""
