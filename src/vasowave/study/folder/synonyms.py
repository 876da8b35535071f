"""Titles and units by which labs call the numbers of the table of animals."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from vasowave.base import units
from vasowave.base.io.cells import is_number, number
from vasowave.base.io.columns import split_unit
from vasowave.catheter.signals.signal import WEDGE_TITLES
from vasowave.study.folder.animal_columns import COLUMNS, WEDGE

_SYNONYMS = {
    WEDGE: WEDGE_TITLES,
    "hematocrit [1]": ("hct", "hkt", "pcv", "haematocrit", "hématocrite", "hämatokrit", "hematokrit", "hematocrito",
                       "ematocrito", "packed cell volume"),
    "temperature [°C]": ("temp", "body temp", "body temperature", "core temp", "core temperature", "rectal temp",
                         "rectal temperature", "blood temperature", "temperatur", "körpertemperatur", "température",
                         "temperatura"),
    "image pressure [mmHg]": ("imaging pressure",),
}  # fmt: skip
_LINES = {
    "hematocrit [1]": {**dict.fromkeys(("l/l", "fraction"), (1.0, 0.0)),
                       **dict.fromkeys(("%", "percent", "vol%", "vol.%"), (0.01, 0.0))},
    "temperature [°C]": {**dict.fromkeys(("c", "degc", "celsius"), (1.0, 0.0)),
                         **dict.fromkeys(("°f", "f"), (5 / 9, -160 / 9)), "k": (1.0, -273.15)},
}  # fmt: skip
"""Factor and offset from units that are no others' in the program."""


class Understood(NamedTuple):
    """The column that a title stands for, factor and offset to its unit, and the unit that the title names, if any."""

    column: str
    factor: float
    offset: float
    unit: str

    def __str__(self) -> str:
        converted = f", in place of {self.unit or '%'}" if (self.factor, self.offset) != (1.0, 0.0) else ""
        return f"{self.column}{converted}{'' if self.unit else ', as it names no unit'}"


def understood_title(name: str, unit: str, cells: Sequence[str] = ()) -> Understood | None:
    """Return the column of numbers that a title and its unit stand for, None if they stand for none.

    Without a unit that of the column is meant; a hematocrit is in percent if most of its `cells` exceed 1.

    Examples
    --------
    >>> from vasowave.study.folder.synonyms import understood_title
    >>> understood_title("Hct", "%").column, understood_title("PCV", "", ["41", "44"]).factor
    ('hematocrit [1]', 0.01)
    """
    head, _, last = name.strip().rpartition(" ")
    for title, title_unit in ((name, unit), *([] if unit else [(head, last)])):  # pcwp mmhg
        column = _COLUMN_OF.get(_plain(title), "")
        if column and (line := _line(column, title_unit, cells)):
            return Understood(column, *line, title_unit)
    return None


def resembling_column(name: str) -> str:
    """Return the column of which a longer title speaks (``Hct week 3``)."""
    words = f" {_plain(name)} "
    return next((column for title, column in _COLUMN_OF.items() if column in _SYNONYMS and f" {title} " in words), "")


def _plain(title: str) -> str:
    return " ".join(re.findall(r"[^\W_]+", title.casefold()))


_COLUMN_OF = {_plain(split_unit(column)[0]): column for column in COLUMNS if column.endswith("]")}
_COLUMN_OF |= {synonym: column for column, synonyms in _SYNONYMS.items() for synonym in synonyms}


def _line(column: str, unit: str, cells: Sequence[str]) -> tuple[float, float] | None:
    """Return factor and offset from a unit to that of a column; None if it is no unit of that."""
    target = split_unit(column)[1]
    if not unit and column == "hematocrit [1]":
        values = [number(text) for text in cells if is_number(text)]
        return (0.01, 0.0) if sum(value > 1 for value in values) > len(values) / 2 else (1.0, 0.0)
    if not unit or unit.casefold() == target.casefold():
        return (1.0, 0.0) if unit or column in _SYNONYMS else None  # a 'start' may be a day
    if column in _LINES:
        return _LINES[column].get(unit.casefold().replace(" ", ""))
    quantity = next((name for name in units.CANONICAL if units.is_of(target, name) and units.is_of(unit, name)), "")
    return (units.factor(unit, quantity) / units.factor(target, quantity), 0.0) if quantity else None
