"""Titles and units by which labs call the numbers of the table of animals."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from vasowave.base import units
from vasowave.base.io.cells import number
from vasowave.base.io.columns import split_unit
from vasowave.catheter.signals.signal import WEDGE_TITLES
from vasowave.study.folder.animal_columns import COLUMNS, NUMBERS, WEDGE

HEMATOCRIT, TEMPERATURE = "hematocrit [1]", "temperature [°C]"
_MAX_SHARE = 1.0
"""A hematocrit above it, of a title without unit, is in percent."""

_SYNONYMS = {
    WEDGE: WEDGE_TITLES,
    HEMATOCRIT: ("hct", "hkt", "pcv", "haematocrit", "hématocrite", "hämatokrit", "hematokrit", "hematocrito",
                 "ematocrito", "packed cell volume"),
    TEMPERATURE: ("temp", "body temp", "body temperature", "core temp", "core temperature", "rectal temp",
                  "rectal temperature", "blood temperature", "temperatur", "körpertemperatur", "température",
                  "temperatura"),
    "image pressure [mmHg]": ("imaging pressure",),
}  # fmt: skip
_OWN_UNITS = {
    HEMATOCRIT: {"1": (1.0, 0.0), "l/l": (1.0, 0.0), "fraction": (1.0, 0.0), "%": (0.01, 0.0), "percent": (0.01, 0.0),
                 "vol%": (0.01, 0.0), "vol.%": (0.01, 0.0)},
    TEMPERATURE: {"°c": (1.0, 0.0), "c": (1.0, 0.0), "degc": (1.0, 0.0), "celsius": (1.0, 0.0),
                  "°f": (5 / 9, -160 / 9), "f": (5 / 9, -160 / 9), "k": (1.0, -273.15)},
}  # fmt: skip
"""Units that are no others' in the program: factor and what is added."""


class Understood(NamedTuple):
    """The column that a title stands for, and the line that brings its numbers to the unit of the column.

    Attributes
    ----------
    column : str
    factor, offset : float
    unit : str
        As the title names it; empty if it names none.
    """

    column: str
    factor: float
    offset: float
    unit: str

    def __str__(self) -> str:
        """Return the column in words, with what was done to its numbers."""
        if (self.factor, self.offset) != (1.0, 0.0):
            return f"{self.column}, in place of {self.unit or '% (its numbers exceed 1)'}"
        return self.column if self.unit else f"{self.column}, as it names no unit"


def understood_title(name: str, unit: str, cells: Sequence[str] = ()) -> Understood | None:
    """Return the column of numbers that a title and its unit stand for, None if they stand for none.

    Without a unit the column's own is meant; a hematocrit is in percent if most of its `cells` exceed 1.

    Examples
    --------
    >>> from vasowave.study.folder.synonyms import understood_title
    >>> understood_title("Hct", "%").column, understood_title("PCV", "", ["41", "44"]).factor
    ('hematocrit [1]', 0.01)
    """
    for title, title_unit in ((name, unit), *([] if unit else [_last_word(name)])):
        column = _COLUMN_OF.get(_plain(title))
        line = column and _line(column, title_unit, cells)
        if column and line:
            return Understood(column, *line, title_unit)
    return None


def resembling_column(name: str) -> str:
    """Return the column of which a longer title speaks, as ``Hct week 3`` does; empty if of none."""
    words = _plain(name).split()
    pieces = {" ".join(words[i:j]) for i in range(len(words)) for j in range(i + 1, len(words) + 1)}
    columns = (_COLUMN_OF.get(piece, "") for piece in sorted(pieces, key=len, reverse=True))
    return next((column for column in columns if column in _SYNONYMS), "")


def _plain(title: str) -> str:
    return " ".join(re.findall(r"[^\W_]+", title.casefold()))


_COLUMN_OF = {_plain(split_unit(column)[0]): column for column in NUMBERS if column in COLUMNS and "[" in column}
_COLUMN_OF |= {synonym: column for column, synonyms in _SYNONYMS.items() for synonym in synonyms}


def _last_word(name: str) -> tuple[str, str]:
    """Return a name and its last word, which may be its unit: ``pcwp mmhg``."""
    head, _, last = name.strip().rpartition(" ")
    return head, last


def _line(column: str, unit: str, cells: Sequence[str]) -> tuple[float, float] | None:
    """Return factor and offset from a unit to that of a column; None if it is no unit of that."""
    target = split_unit(column)[1]
    if column == HEMATOCRIT and not unit:
        return _OWN_UNITS[column]["%" if _mostly_above(_MAX_SHARE, cells) else "1"]
    if not unit:  # a 'start' may be a day
        return (1.0, 0.0) if column in _SYNONYMS else None
    if unit.casefold() == target.casefold():
        return 1.0, 0.0
    if column in _OWN_UNITS:
        return _OWN_UNITS[column].get(unit.casefold().replace(" ", ""))
    quantity = next((name for name in units.CANONICAL if units.is_of(target, name)), "")
    if not quantity or not units.is_of(unit, quantity):
        return None
    return units.factor(unit, quantity) / units.factor(target, quantity), 0.0


def _mostly_above(limit: float, cells: Sequence[str]) -> bool:
    values = []
    for text in cells:
        try:
            values.append(number(text))
        except ValueError:
            continue
    return sum(value > limit for value in values) > len(values) / 2
