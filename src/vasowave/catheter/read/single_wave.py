"""A table of one signal over time: which column is which, and its samples."""

from typing import NamedTuple

import numpy as np

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.io.columns import Columns
from vasowave.catheter.check.plausibility import moves_at_ends, repeats_first
from vasowave.catheter.signals.signal import even_step, written_to


class SingleWave(NamedTuple):
    """Samples in the canonical unit, their distance in s (None without a column of time), and the header's unit."""

    values: np.ndarray
    step: float | None
    stated: str

    def cycle(self) -> tuple[np.ndarray, float | None]:
        """Return one cycle and how long it lasts, s: without a last sample that is the next cycle's first.

        A wave that rests at both ends repeats nothing.
        """
        repeats = repeats_first(self.values) and moves_at_ends(self.values)
        values = self.values[:-1] if repeats else self.values
        return values, None if self.step is None else self.step * len(values)


def single_wave(table: Columns, quantity: str, kind: str, unit: str) -> SingleWave:
    """Return the only signal of a table.

    Parameters
    ----------
    table : Columns
    quantity : str
        Title of its column; another title is known by its unit, and so is that of the time.
    kind : str
        Of its units: "pressure", "flow", "length" …
    unit : str
        Where the header says none.

    Raises
    ------
    InputError
        No such column or several, no column of time beside it, times that are not even, a cell that is not a number.
    """
    time, column = _columns(table, quantity, kind)
    values = table.numbers(column, kind, unit)
    stated = table.units[column] if table.units else ""
    if time is None:
        return SingleWave(values, None, stated)
    times, quantum = table.numbers(time, "time", "s"), written_to([row[time] for row in table.cells])
    step = even_step(times, quantum, str(table.source), lambda i: f"{table.source}, line {table.lines[i]}")
    return SingleWave(values, step, stated)


def _columns(table: Columns, quantity: str, kind: str) -> tuple[int | None, int]:
    """Return where time (None of a single column) and the signal stand: by their titles, or by their units."""
    width, path = len(table.cells[0]), table.source
    if not table.names:
        if width > 2:
            raise InputError(f"{path}: {width} columns without titles; give time and {quantity}, or titles with units")
        return (0, 1) if width == 2 else (None, 0)
    header = f"the header has: {', '.join(table.names)}"
    time = _only(table, "time", "time")
    if time is None and width > 1:
        raise InputError(f"{path}: no column of time; {header}. Write the unit into its title, as in 'time [s]'")
    column = _only(table, quantity, kind)
    if column is None and width <= 2:
        column = 1 - time if time is not None else 0
    if column is None:
        raise InputError(f"{path}: no column says that it is the {quantity}, and not one alone has a unit of {kind}; "
                         f"{header}. Call it '{quantity}'")  # fmt: skip
    return time, column


def _only(table: Columns, title: str, kind: str) -> int | None:
    """Return the column that is called so, or the only one in such a unit."""
    column = table.find(title)
    of_unit = [i for i, unit in enumerate(table.units) if units.is_of(unit, kind)]
    return column if column is not None else of_unit[0] if len(of_unit) == 1 else None
