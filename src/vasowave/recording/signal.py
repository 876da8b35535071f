"""One signal as it stands in a file: samples, times, units, and where each sample is written."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vasowave import units
from vasowave.errors import InputError
from vasowave.findings import Finding, Severity, kind
from vasowave.io.columns import Columns, read_columns
from vasowave.io.textfile import read_start
from vasowave.recording.choosing import TAKEN, choose, with_time
from vasowave.recording.labchart_text import is_labchart_text
from vasowave.recording.matlab import read_mat, text, vector

_EXACT = 1e-6  # steps that differ by less than this share of their mean are equal
ALIASES = {
    "t": "time",
    "p": "pressure",
    "pap": "pressure",
    "mpap": "pressure",
    "press": "pressure",
    "q": "flow",
    "flow rate": "flow",
    "flowrate": "flow",
}
"""Other titles of the columns, lower case."""

_CONTINUOUS = (
    "a continuous recording exported by LabChart, not one cycle; in a study, write 'raw' into the column 'kind' (in "
    "Python: read_raw_recording, then average_beats)"
)


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


class ColumnTitle(NamedTuple):
    """A column of a table, its title and its unit."""

    place: int
    title: str
    unit: str


def read_signals(path: str | Path, wanted: Mapping[str, str | None]) -> list[Signal]:
    """Read the quantities `wanted` (with the unit to take where the file names none) from one file."""
    if Path(path).suffix.lower() == ".mat":
        variables = _named(path, read_mat(path))
        return [_from_mat(path, variables, quantity, unit) for quantity, unit in wanted.items()]
    if is_labchart_text(read_start(path)):
        raise InputError(f"{path}: {_CONTINUOUS}")
    table = read_columns(path, ALIASES)
    table.warn()
    return [_from_table(table, quantity, unit, alone=len(wanted) == 1) for quantity, unit in wanted.items()]


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
    if quantum >= step and np.ptp(steps) > _EXACT * step:  # equal steps were not rounded
        raise InputError(
            f"{file}, column 'time': written to {quantum:g} s, coarser than the sampling interval "
            f"({step:.3g} s); write more decimals, or leave the column out and give the period"
        )
    uneven = np.flatnonzero(np.abs(steps - step) > quantum + 1e-3 * step)
    if len(uneven):
        # A gap shifts the mean step too; the row that deviates most is the one to look at.
        row = int(np.argmax(np.abs(steps - np.median(steps)))) + 1
        raise InputError(
            f"{place(row)}, column 'time': uneven sampling, a step of {steps[row - 1]:.6g} s "
            f"where the others have {np.median(steps):.6g} s; resample evenly or fill the gap"
        )
    return step


def _from_table(table: Columns, quantity: str, unit: str | None, alone: bool) -> Signal:
    if not table.names and not (alone and len(table.cells[0]) == 1):
        raise InputError(f"{table.source}: {_headerless(table)}")
    column, notes = _column(table, quantity) if table.names else (0, ())
    stated = table.units[column] if table.units else ""
    assumed = "" if table.names or unit else units.CANONICAL[quantity]
    places = tuple(f"{table.source}, line {line}" for line in table.lines)
    values = table.numbers(column, quantity, unit or assumed)
    if stated and unit and (ratio := units.factor(unit, quantity) / units.factor(stated, quantity)) != 1.0:
        values, notes = values * ratio, (*notes, UNIT_REPLACED(name=quantity, unit=unit, stated=stated))
    named = with_time(table.names, table.units)
    column_of_time = named.index("time") if "time" in named else None
    if column_of_time is None:
        return Signal(quantity, values, None, 0.0, table.source, places, assumed, notes)
    time = table.numbers(column_of_time, "time")
    quantum = written_to([row[column_of_time] for row in table.cells])
    quantum *= units.factor(table.units[column_of_time], "time")
    return Signal(quantity, values, time, quantum, table.source, places, assumed, notes)


def _column(table: Columns, quantity: str) -> tuple[int, tuple[Finding, ...]]:
    """Return the column of a quantity: the one called so, else the one that its title or unit leaves alone, noted."""
    if table.find(quantity) is None:
        columns = [ColumnTitle(i, *pair) for i, pair in enumerate(zip(table.names, table.units, strict=True))]
        choice = choose(columns, {"pressure": None, "flow": None})
        if quantity in choice.picked:
            found, why = choice.picked[quantity], choice.guessed.get(quantity, "")
            return found.place, (TAKEN(title=found.title, name=quantity, why=why),) if why else ()
    return table.require(quantity, ()), ()


def _headerless(table: Columns) -> str:
    """Say what a table without a header lacks, by what stands in it."""
    width = len(table.cells[0])
    if width == 1:
        return "one column without a header; give the file of the flow too, after that of the pressure"
    comma = "; if the comma is a decimal one, write a point" if width == 2 else ""
    return f"{width} columns without a header{comma}; the first line must read: time [s],pressure [mmHg],flow [ml/s]"


def written_to(cells: list[str]) -> float:
    """Return the place value of the last digit written in any of the cells: 0.001 for '0.2', '0.213'."""
    finest = 0
    for cell in cells:
        try:
            finest = min(finest, int(Decimal(cell.strip()).as_tuple().exponent))
        except (InvalidOperation, ValueError):
            continue
    return 10.0 ** max(finest, -300)


def _named(path: str | Path, variables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the variables of a ``.mat`` file under vasowave's names."""
    if {"datastart", "dataend"} <= set(variables):
        raise InputError(f"{path}: {_CONTINUOUS}")
    named: dict[str, Any] = {}
    for name, value in variables.items():
        key = ALIASES.get(name.lower(), name.lower())
        if key in named and key in ("time", "pressure", "flow"):
            raise InputError(f"{path}: two variables hold {key}; keep one of them")
        named[key] = value
    return named


def _from_mat(path: str | Path, named: Mapping[str, Any], quantity: str, unit: str | None) -> Signal:
    if quantity not in named:
        raise InputError(f"{path}: no variable '{quantity}'; it has: {', '.join(named) or 'nothing'}")
    stated = text(named.get(f"{quantity}_unit", ""))
    assumed = "" if stated or unit else units.CANONICAL[quantity]
    values = _finite(path, quantity, named[quantity]) * units.factor(unit or stated or assumed, quantity)
    replaced = stated and unit and units.factor(stated, quantity) != units.factor(unit, quantity)
    notes = (UNIT_REPLACED(name=quantity, unit=unit, stated=stated),) if replaced and unit else ()
    places = tuple(f"{path}, {quantity}({i + 1})" for i in range(len(values)))
    if "time" not in named:
        return Signal(quantity, values, None, 0.0, str(path), places, assumed, notes)
    raw = named["time"]
    scale = units.factor(text(named.get("time_unit", "")) or "s", "time")
    time = _finite(path, "time", raw) * scale
    if len(time) != len(values):
        raise InputError(
            f"{path}: time has {len(time)} samples and {quantity} {len(values)}; "
            "leave time out and give the period if the two signals differ in rate"
        )
    precision = np.finfo(raw.dtype if raw.dtype.kind == "f" else np.float64).eps
    quantum = 4 * float(precision) * float(np.abs(time).max(initial=0.0))
    return Signal(quantity, values, time, quantum, str(path), places, assumed, notes)


def _finite(path: str | Path, name: str, value: object) -> np.ndarray:
    values = vector(value, f"{path}: variable '{name}'")
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        raise InputError(f"{path}: {name}({bad[0] + 1}) is {values[bad[0]]} (a gap); fill it before averaging")
    return values
