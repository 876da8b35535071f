"""A text table whose columns carry a name and a unit in the header: ``pressure [mmHg]``."""

import csv
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vasowave import units
from vasowave.errors import InputError, did_you_mean

_HEADING = re.compile(r"^\s*(?P<name>[^\[\](]*?)\s*(?:[\[(]\s*(?P<unit>[^\])]*)[\])])?\s*$")

_BLANK_SEPARATED = re.compile(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?")


@dataclass(frozen=True)
class Columns:
    """The cells of a text table, as text, with what is needed to speak about them.

    Attributes
    ----------
    source : str
        File the table came from; error messages start with it.
    names, units : tuple of str
        Per column; a column without a unit has an empty one. Empty tuples if the file has no header.
    cells : tuple of tuple of str
        Rows of text.
    lines : tuple of int
        Line of the file on which each row stands, counted from 1.
    """

    source: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    cells: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]

    def find(self, name: str, also: Sequence[str] = ()) -> int | None:
        """Return the index of the column called `name` (or one of `also`), None if there is none."""
        wanted = {name, *also}
        hits = [i for i, found in enumerate(self.names) if found in wanted]
        if len(hits) > 1:
            raise InputError(f"{self.source}: two columns are called '{name}'; keep one of them")
        return hits[0] if hits else None

    def require(self, name: str, also: Sequence[str] = ()) -> int:
        """Like `find`, but a missing column is an `InputError`."""
        column = self.find(name, also)
        if column is None:
            hint = did_you_mean(name, self.names)
            raise InputError(
                f"{self.source}: no column '{name}'{hint}; the header has: {', '.join(self.names) or 'nothing'}"
            )
        return column

    def numbers(self, column: int, quantity: str, default_unit: str = "") -> np.ndarray:
        """Return a column as floats in the canonical unit of `quantity`, shape (rows,).

        Raises
        ------
        InputError
            Unit missing or of another quantity; a cell that is empty, not a number, or not finite,
            with its line and column.
        """
        unit = (self.units[column] if self.units else "") or default_unit
        title = self.names[column] if self.names else f"column {column + 1}"
        if not unit:
            raise InputError(
                f"{self.source}: column '{title}' has no unit; write it in the header, "
                f"for example '{title} [{units.CANONICAL[quantity]}]'"
            )
        try:
            scale = units.factor(unit, quantity)
        except InputError as error:
            raise InputError(f"{self.source}: column '{title}': {error}") from None
        return scale * np.array([self._number(row, column, title) for row in range(len(self.cells))])

    def _number(self, row: int, column: int, title: str) -> float:
        text = self.cells[row][column]
        try:
            value = number(text)
        except ValueError:
            comma = "; write a decimal point instead of a comma" if re.fullmatch(r"\s*-?\d+,\d+\s*", text) else ""
            what = f"'{text}' is not a number{comma}" if text.strip() else "the cell is empty"
            raise InputError(f"{self.source}, line {self.lines[row]}, column '{title}': {what}") from None
        if not math.isfinite(value):
            raise InputError(
                f"{self.source}, line {self.lines[row]}, column '{title}': {text.strip()} "
                "(a gap); fill it or cut the recording before it is averaged"
            )
        return value


def read_columns(path: str | Path, aliases: Mapping[str, str] | None = None) -> Columns:
    """Read a CSV, TSV or blank-separated text file.

    Parameters
    ----------
    path : path
        Text file, UTF-8 (or cp1252). Lines that start with ``#`` and empty lines are skipped.
    aliases : mapping, optional
        Other spellings of column names, lower case, to the names vasowave uses.

    Raises
    ------
    InputError
        File missing, empty, binary, or with rows of different width (the line is named).
    """
    path = Path(path)
    rows, lines = _split(path)
    header: tuple[str, ...] = ()
    if not all(_is_number(cell) for cell in rows[0]):
        header = tuple(rows[0])
        rows, lines = rows[1:], lines[1:]
    if not rows:
        raise InputError(f"{path}: a header and no data")
    width = len(header) if header else len(rows[0])
    for row, line in zip(rows, lines, strict=True):
        if len(row) != width:
            raise InputError(f"{path}, line {line}: {len(row)} columns where {width} were expected")
    names, column_units = [], []
    for heading in header:
        match = _HEADING.match(heading)
        if match is None:
            raise InputError(f"{path}: cannot read the column title '{heading}'; write 'name [unit]'")
        name = match["name"].strip().lower()
        names.append((aliases or {}).get(name, name))
        column_units.append((match["unit"] or "").strip())
    return Columns(str(path), tuple(names), tuple(column_units), tuple(map(tuple, rows)), tuple(lines))


def split_unit(label: str) -> tuple[str, str]:
    """Split ``"S [mmHg2]"`` into ``("S", "mmHg2")``; the unit of a label without one is empty."""
    match = re.fullmatch(r"(.*?)\s*\[(.*)\]", label)
    return (match[1], match[2]) if match else (label, "")


def _split(path: Path) -> tuple[list[list[str]], list[int]]:
    """Return the cells of every line that is not blank or a comment, and the line numbers."""
    try:
        raw = path.read_bytes()
    except OSError as error:
        reason = "is a folder" if path.is_dir() else (error.strerror or "cannot be read").lower()
        raise InputError(f"{path}: {reason}") from None
    if b"\0" in raw:
        utf16 = raw[:2] in (b"\xff\xfe", b"\xfe\xff")
        cure = "text in UTF-16; save it as 'CSV UTF-8'" if utf16 else "not a text file; export it as CSV first"
        raise InputError(f"{path}: {cure}")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("cp1252", errors="replace")
    kept = [
        (n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.lstrip().startswith("#")
    ]
    if not kept:
        raise InputError(f"{path}: the file is empty")
    first = kept[0][1]
    separator = next((mark for mark in ("\t", ";", ",") if mark in first), None)
    if separator is None:
        # Titles hold blanks between name and unit ("pressure [mmHg]"), so only numbers split at blanks.
        rows = [line.split() if all(map(_is_number, line.split())) else [line.strip()] for _, line in kept]
        titles = _BLANK_SEPARATED.findall(first)
        if len(kept) > 1 and len(titles) == len(rows[1]):
            rows[0] = titles
    else:
        try:
            rows = [[cell.strip() for cell in row] for row in csv.reader([x for _, x in kept], delimiter=separator)]
        except csv.Error as error:
            raise InputError(f"{path}: not a table of text ({error})") from None
        if len(rows) != len(kept):
            raise InputError(f"{path}: a quotation mark is opened and not closed on its line; remove it")
    return rows, [n for n, _ in kept]


def number(text: str) -> float:
    """Return the number that `text` is; `ValueError` if it is none (Python's own ``1_000`` is none in a table)."""
    if "_" in text:
        raise ValueError(text)
    return float(text)


def _is_number(text: str) -> bool:
    try:
        number(text)
    except ValueError:
        return False
    return True
