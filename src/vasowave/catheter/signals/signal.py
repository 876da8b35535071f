"""One signal as it stands in a file: samples, times, units, and where each sample is written."""

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation

import numpy as np

from vasowave.base import units
from vasowave.base.cures import UNKNOWN, SetCells
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, Severity, kind
from vasowave.catheter.signals.gaps import leaps_closed

_MAX_UNEVENNESS = 3e-3  # of a step: a scanner writes 44.100 and 44.200 ms
_EQUAL_STEP_SHARE = 1e-6  # steps that differ by less than this share of their mean are equal
RATE_NAMES = ("fs", "sampling_rate", "samplingrate", "samplerate", "sample_rate", "srate", "samples_per_second")
"""What files call the number of samples a second."""
MAX_RATE_DIFFERENCE = 1e-3
"""Between two rates that are said of one signal, as a share."""
ALIASES = {
    "t": "time",
    "zeit": "time",
    "temps": "time",
    "tiempo": "time",
    "timestamp": "time",
    "elapsed time": "time",
    "elapsed_time": "time",
    "x_value": "time",
    "p": "pressure",
    "pap": "pressure",
    "mpap": "pressure",
    "press": "pressure",
    "druck": "pressure",
    "pression": "pressure",
    "presion": "pressure",
    "q": "flow",
    "flow rate": "flow",
    "flowrate": "flow",
    "fluss": "flow",
    "debit": "flow",
    "flujo": "flow",
}
"""Other titles of the columns, lower case."""
WEDGE_TITLES = (
    "wedge", "wedge pressure", "mean wedge", "mean wedge pressure", "pcwp", "mpcwp", "pawp", "mpawp", "paop", "pcw",
    "ppcw", "lap", "mlap", "left atrial pressure", "keil", "keildruck", "wedgedruck", "wedge druck", "verschlussdruck",
    "pcp", "papo", "pression capillaire",
)  # fmt: skip
"""What tables call the pressure behind the beds, in lower case."""

NAME_THE_RATE = "say how many samples a second has"
RATE = SetCells("Give the sampling rate", (("sampling rate [1/s]", UNKNOWN),))
"""What to do where a file has no times."""


def unit_cures(column: str, quantity: str) -> list[SetCells]:
    """Return what to do where no unit of a quantity is said: that it is the usual one, or another."""
    usual = units.CANONICAL[quantity]
    return [SetCells(f"The {column} is in {usual}", ((f"{column} unit", usual),)),
            SetCells(f"Name the unit of {column}", ((f"{column} unit", UNKNOWN),))]  # fmt: skip


UNIT_REPLACED = kind(
    "recording.unit-replaced",
    Severity.LOOK,
    "{name} was taken to be in {unit}, as given, although the file says {stated}",
    "Make sure that the unit that was given is the right one.",
)


@dataclass(frozen=True, eq=False)
class Signal:
    """One signal as it stands in a file: values and times in canonical units, and how errors call it."""

    quantity: str
    values: np.ndarray
    time: np.ndarray | None
    quantum: float
    """Rounding of the written times, s."""
    file: str
    places: tuple[str, ...]
    """Where each sample stands: ``FILE, line 7``."""
    assumed_unit: str = ""
    notes: tuple[Finding, ...] = ()


def even_step(time: np.ndarray, quantum: float, file: str, place: Callable[[int], str]) -> float:
    """Return the sampling interval, s; `InputError` names the place where it changes.

    Parameters
    ----------
    time : float array, shape (sample,)
        s.
    quantum : float
        Rounding of the written times, s.
    file, place
        How errors call the file, and a sample by its number.
    """
    steps = np.diff(time)
    step = float(time[-1] - time[0]) / len(steps)
    backward = np.flatnonzero(steps < 0)
    if step <= 0 or len(backward):
        row = int(backward[0]) + 1 if len(backward) else 1
        raise InputError(f"{place(row)}, column 'time': time does not increase; sort or cut the table")
    if quantum >= step and np.ptp(steps) > _EQUAL_STEP_SHARE * step:  # equal steps were not rounded
        raise InputError(
            f"{file}, column 'time': written to {quantum:g} s, coarser than the sampling interval "
            f"({step:.3g} s); write more decimals, or leave the column out and give the period of "
            "a cycle or the rate of a continuous recording",
            [SetCells("Give the period", (("period [s]", UNKNOWN),)), RATE],
        )
    uneven = np.flatnonzero(np.abs(steps - step) > quantum + _MAX_UNEVENNESS * step)
    if len(uneven):
        # A gap shifts the mean step too; the row that deviates most is the one to look at.
        row = int(np.argmax(np.abs(steps - np.median(steps)))) + 1
        raise InputError(
            f"{place(row)}, column 'time': uneven sampling, a step of {steps[row - 1]:.6g} s "
            f"where the others have {np.median(steps):.6g} s; resample evenly or fill the gap"
        )
    return step


def sampling(
    time: np.ndarray, quantum: float, file: str, place: Callable[[int], str]
) -> tuple[float, np.ndarray | None]:
    """Return samples per second, and the places of samples if the times leap over gaps; raises as `even_step`."""
    if len(gaps := np.flatnonzero(~np.isfinite(time))):
        raise InputError(f"{place(int(gaps[0]))}, time: the cell is empty or no number")
    leaps = leaps_closed(time)
    even, places = (time, None) if leaps is None else leaps
    return 1.0 / even_step(even, quantum, file, place), places


def given_unit(quantity: str, stated: str, requested: str | None, where: str) -> tuple[float, tuple[Finding, ...]]:
    """Return what a value is multiplied by, and a note where the unit that was given is not the one stated.

    Raises
    ------
    InputError
        Neither is there, or one is not of the quantity.
    """
    if not (stated or requested):
        raise InputError(f"{where}: {quantity} has no unit; give it ({quantity}_unit={units.CANONICAL[quantity]!r})")
    factors = [units.factor(unit, quantity) for unit in (stated, requested) if unit]
    notes = (UNIT_REPLACED(name=quantity, unit=str(requested), stated=stated),) if factors[0] != factors[-1] else ()
    return factors[-1], notes


def written_to(cells: list[str]) -> float:
    """Return the place value of the last digit written in any of the cells: 0.001 for '0.2', '0.213'."""
    finest = 0
    for cell in cells:
        try:
            finest = min(finest, int(Decimal(cell.strip()).as_tuple().exponent))
        except (InvalidOperation, ValueError):
            continue
    return 10.0 ** max(finest, -300)
