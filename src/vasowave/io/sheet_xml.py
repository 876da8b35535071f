"""The parts of an Excel workbook, element by element as a parser meets them; no more is kept than what is asked for."""

import math
import re
from datetime import datetime, timedelta
from typing import NamedTuple

from vasowave.errors import InputError

_MOST_ROWS, _MOST_COLUMNS, _LONGEST_CELL = 1 << 20, 1 << 14, 1 << 16  # Excel's own limits, or above them
_PLACE = re.compile(r"([A-Z]{1,3})(\d{1,7})")
_DATES = {*range(14, 23), *range(27, 37), *range(45, 48), *range(50, 59)}  # built-in formats of dates and times
_NOT_SHOWN = re.compile(r'"[^"]*"|\\.|_.|\*.|\[(?![hms]+\])[^\]]*\]', re.IGNORECASE)  # of a format: literals, colors


class Book(NamedTuple):
    """What is known of the workbook before its sheet is read."""

    shared: list[str]
    dates: list[bool]  # by style
    epoch: datetime


class Handler:
    """What is done with the elements of a part, as they come; nothing is kept that is not asked for."""

    def start(self, tag: str, given: dict[str, str]) -> None:
        """Take the beginning of an element, its name without prefix and its attributes."""

    def end(self, tag: str) -> None:
        """Take the end of an element."""

    def data(self, text: str) -> None:
        """Take a piece of the text between."""


class Elements(Handler):
    """The attributes of the elements of some names."""

    def __init__(self, *tags: str) -> None:
        self._tags, self.elements = tags, list[tuple[str, dict[str, str]]]()

    def start(self, tag: str, given: dict[str, str]) -> None:
        """Take the beginning of an element."""
        if tag in self._tags:
            self.elements.append((tag, given))


class Text(Handler):
    """The text of elements, gathered where it is wanted."""

    def __init__(self) -> None:
        self._wanted = False
        self.begin()

    def begin(self) -> None:
        """Forget what was gathered."""
        self._parts, self._length = list[str](), 0

    def data(self, text: str) -> None:
        """Gather text where it is wanted."""
        if self._wanted:
            self._length += len(text)
            if self._length > _LONGEST_CELL:
                raise InputError(f"a cell with more than {_LONGEST_CELL} characters is no table's")
            self._parts.append(text)

    @property
    def text(self) -> str:
        """What was gathered."""
        return "".join(self._parts)


class SharedStrings(Text):
    """The texts that cells refer to by number; how a word is pronounced (rPh) is no part of it."""

    def __init__(self) -> None:
        super().__init__()
        self.texts: list[str] = []
        self._aside = False

    def start(self, tag: str, given: dict[str, str]) -> None:
        """Take the beginning of an element."""
        if tag == "si":
            self.begin()
        self._aside = self._aside or tag == "rPh"
        self._wanted = tag == "t" and not self._aside

    def end(self, tag: str) -> None:
        """Take the end of an element."""
        self._wanted = False
        self._aside = self._aside and tag != "rPh"
        if tag == "si":
            self.texts.append(self.text)


class Styles(Handler):
    """Which styles show a number as a date or a time."""

    def __init__(self) -> None:
        self._formats: dict[int, str] = {}
        self._used: list[int] = []
        self._inside = False

    def start(self, tag: str, given: dict[str, str]) -> None:
        """Take the beginning of an element."""
        self._inside = self._inside or tag == "cellXfs"
        if tag == "numFmt":
            self._formats[int(given["numFmtId"])] = given["formatCode"]
        elif tag == "xf" and self._inside:
            self._used.append(int(given.get("numFmtId", 0)))

    def end(self, tag: str) -> None:
        """Take the end of an element."""
        self._inside = self._inside and tag != "cellXfs"

    def dates(self) -> list[bool]:
        """Return for each style whether it shows dates or times."""
        shown = {number: _NOT_SHOWN.sub("", code) for number, code in self._formats.items()}
        dated = {number for number, code in shown.items() if re.search("[dmyhs]", code, re.IGNORECASE)}
        return [number in dated or (number in _DATES and number not in shown) for number in self._used]


class Sheet(Text):
    """The rows of a sheet."""

    def __init__(self, book: Book) -> None:
        super().__init__()
        self._book = book
        self._rows: list[tuple[int, list[str]]] = []
        self._row, self._column, self._cells = 0, 0, dict[int, str]()
        self._kind, self._style = "n", 0

    def taken(self) -> list[tuple[int, list[str]]]:
        """Return the rows that were finished since the last call."""
        rows, self._rows = self._rows, []
        return rows

    def start(self, tag: str, given: dict[str, str]) -> None:
        """Take the beginning of an element."""
        if tag == "row":
            self._start_row(int(given.get("r", self._row + 1)))
        elif tag == "c":
            self._column = self._column_of(given.get("r"))
            self._kind, self._style = given.get("t", "n"), int(given.get("s", 0))
            self.begin()
        self._wanted = tag in ("v", "t")

    def end(self, tag: str) -> None:
        """Take the end of an element."""
        self._wanted = False
        if tag == "c" and self.text:
            self._cells[self._column] = self._value()
        elif tag == "row" and any(self._cells.values()):
            self._rows.append((self._row, [self._cells.get(i, "") for i in range(1, max(self._cells) + 1)]))

    def _start_row(self, number: int) -> None:
        if not self._row < number <= _MOST_ROWS:
            raise InputError(f"row {number} follows row {self._row}; save the sheet again")
        self._row, self._column, self._cells = number, 0, {}

    def _column_of(self, place: str | None) -> int:
        match = _PLACE.fullmatch(place or "")
        column = self._column + 1
        if match:
            column = 0
            for letter in match[1]:
                column = 26 * column + ord(letter) - 64
        if not self._column < column <= _MOST_COLUMNS:
            raise InputError(f"row {self._row}: cell {place} is out of place; save the sheet again")
        return column

    def _value(self) -> str:
        if self._kind == "s":
            return self._book.shared[int(self.text)] if int(self.text) >= 0 else ""
        if self._kind == "b":
            return "TRUE" if self.text == "1" else "FALSE"
        if self._kind == "e":  # '#DIV/0!' at the start of a row would make a remark of it
            return f"error {self.text.strip('#')}"
        if self._kind != "n":
            return self.text
        value = math.nan if "_" in self.text else float(self.text)
        if self._style < len(self._book.dates) and self._book.dates[self._style]:
            return str(self._book.epoch + timedelta(days=value))
        return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
