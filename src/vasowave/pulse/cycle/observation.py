"""What was measured at one place of one vessel, beside the recording at the inlet."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from vasowave.base.errors import InputError, did_you_mean
from vasowave.pulse.cycle.cycle import cycle_samples

QUANTITIES = {"pressure": "mmHg", "flow": "ml/s", "velocity": "cm/s", "area": "cm2", "diameter": "cm"}
"""What can be observed, and the unit in which it is held."""

NUMBERS = ("mean", "systolic", "diastolic")
"""Numbers that stand for a cycle: its mean, its largest and its smallest value."""

ZERO_SD = 0.5
"""SD of the zero of a further catheter, mmHg, where nothing else is said: as for that at the inlet."""

GAIN_SD = 0.05
"""SD of the gain of what is no pressure, where nothing else is said: of probes, of images beside each other."""

MAX_PERIOD_DIFFERENCE = 0.02
"""Share by which the period of what is recorded elsewhere may differ from the recording's."""


@dataclass(frozen=True, eq=False)
class Observation:
    """What was measured at one place: a waveform over the cycle of the recording, or numbers that stand for one.

    Attributes
    ----------
    quantity : str
        ``pressure`` (mmHg), ``flow`` (ml/s), ``velocity`` (cm/s, mean over the cross-section), ``area`` (cm²) or
        ``diameter`` (cm).
    vessel : str
        Name of the vessel.
    error : float
        SD of its error: of each value of a waveform, of each number.
    place : float, optional
        Share of the vessel's length from its inlet; by default 0.5.
    cm : float, optional
        Distance from the vessel's inlet, cm, in place of a share.
    waveform : float array, shape (sample,), optional
        Evenly spaced over the period of the recording, in step with it, the first sample not repeated at the end.
    mean, systolic, diastolic : float, optional
        Mean, largest and smallest value, in place of a waveform.
    zero_sd : float
        SD of the zero of this catheter, mmHg; only of a pressure.
    gain_sd : float, optional
        SD of a factor of all values, as a share: of a flow probe, or of this image beside that of the network. By
        default 0 of a pressure, else 0.05.
    period : float, optional
        Period of the waveform, s, where its file says it; it must be that of the recording.

    Raises
    ------
    InputError
        Another quantity, a place outside the vessel, an error that is not positive, waveform and numbers or none of
        both, too few samples, a value that is not finite.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Observation("flow", "LPA", error=0.01, place=0.3, mean=0.08)
    Observation(flow in 'LPA', 0.3 of its length: mean 0.08 ± 0.01 ml/s)
    """

    quantity: str
    vessel: str
    error: float
    place: float | None = None
    cm: float | None = None
    waveform: np.ndarray | None = None
    mean: float | None = None
    systolic: float | None = None
    diastolic: float | None = None
    zero_sd: float = ZERO_SD
    gain_sd: float | None = None
    period: float | None = None

    def __post_init__(self) -> None:
        """Check the values and freeze the array."""
        if self.quantity not in QUANTITIES:
            hint = did_you_mean(self.quantity, QUANTITIES)
            raise InputError(f"site: '{self.quantity}' cannot be observed{hint}; known are: {', '.join(QUANTITIES)}")
        place, cm = _number(self.place, "place"), _number(self.cm, "cm")
        for name in ("error", "zero_sd"):
            if _number(getattr(self, name), name) is None:
                raise InputError(f"site: {name} is None; give the SD, a number")
        _number(self.gain_sd, "gain_sd")
        if place is not None and cm is not None:
            raise InputError(f"{self.title}: a share of the length and a distance are given; give one of them")
        if place is not None and not 0 <= place <= 1:
            raise InputError(f"{self.title}: place {place:g} lies outside the vessel; give a share from 0 to 1, or cm")
        if cm is not None and cm < 0:
            raise InputError(f"{self.title}: {cm:g} cm lies before the vessel")
        if not (np.isfinite(self.error) and self.error > 0):
            raise InputError(f"{self.title}: error {self.error:g} is not valid; give a positive SD")
        if not (np.isfinite(self.zero_sd) and self.zero_sd >= 0):
            raise InputError(f"{self.title}: zero_sd {self.zero_sd:g} is not valid; give an SD of 0 mmHg or more")
        if not (np.isfinite(self.gain) and 0 <= self.gain <= 2):
            raise InputError(f"{self.title}: gain_sd {self.gain:g} is not valid; give a share from 0 to 2")
        if (self.waveform is None) == (not self.numbers):
            raise InputError(f"{self.title}: give a waveform, or at least one of {', '.join(NUMBERS)}")
        if self.waveform is not None:
            object.__setattr__(self, "waveform", cycle_samples(self.waveform, self.title))
        self._check_values()
        object.__setattr__(self, "place", place if place is not None or cm is not None else 0.5)

    def _check_values(self) -> None:
        """Raise `InputError` for values that no cycle has, or that say nothing of its size."""
        low, middle, high = (self.numbers.get(name) for name in ("diastolic", "mean", "systolic"))
        ordered = [value for value in (low, middle, high) if value is not None]
        if ordered != sorted(ordered) or (low is not None and low == high):
            raise InputError(f"{self.title}: diastolic, mean and systolic must rise in this order; are two exchanged?")
        if self.waveform is not None and np.ptp(self.waveform) == 0:
            raise InputError(f"{self.title}: the waveform is the same number throughout; give a mean instead")
        if self.quantity != "pressure" and ordered and not any(ordered):
            raise InputError(f"{self.title}: nothing but 0 says nothing of its size")
        minimum = min(ordered) if ordered else float(np.min(self.waveform))  # type: ignore[arg-type]
        if self.quantity in ("area", "diameter") and minimum <= 0:
            raise InputError(f"{self.title}: {minimum:g} {self.unit} is no vessel's; is its zero right?")

    @property
    def title(self) -> str:
        """What was observed, where."""
        where = f"{self.cm:g} cm from its inlet" if self.cm is not None else f"{self.place or 0:g} of its length"
        return f"{self.quantity} in '{self.vessel}'{'' if self.place is None and self.cm is None else f', {where}'}"

    @property
    def unit(self) -> str:
        """Unit of its values."""
        return QUANTITIES[self.quantity]

    @property
    def gain(self) -> float:
        """SD of the factor of all values."""
        usual = 0.0 if self.quantity == "pressure" else GAIN_SD
        return usual if self.gain_sd is None else float(self.gain_sd)

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers that are known, by name; of a waveform none."""
        values = {name: _number(getattr(self, name), name) for name in NUMBERS}
        return {name: value for name, value in values.items() if value is not None}

    @property
    def pulse(self) -> float | None:
        """Largest minus smallest value; None where they are not known."""
        if self.waveform is not None:
            return float(np.ptp(self.waveform))
        numbers = self.numbers
        return numbers["systolic"] - numbers["diastolic"] if {"systolic", "diastolic"} <= set(numbers) else None

    def __repr__(self) -> str:
        values = ", ".join(f"{name} {value:.4g}" for name, value in self.numbers.items())
        if self.waveform is not None:
            values = f"{self.waveform.min():.4g} to {self.waveform.max():.4g}, {len(self.waveform)} samples,"
        return f"Observation({self.title}: {values} ± {self.error:.3g} {self.unit})"


def _number(value: Any, field: str) -> float | None:
    if value is None:
        return None
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        number = np.nan
    if not np.isfinite(number):
        raise InputError(f"site: {field} is {value!r}; give a number, or leave it out")
    return number
