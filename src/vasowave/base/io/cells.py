"""Cells of a table: what separates them, and which are numbers, gaps, times or dates."""

import csv
import re
from collections.abc import Sequence
from pathlib import Path

from vasowave.base.errors import InputError
from vasowave.base.io.clocks import is_clock, is_date

GAPS = frozenset({"", "NA", "N/A", "NAN", "-", "--", "#NV", "#N/A", "#NULL!", "#WERT!", "#VALUE!", "#DIV/0!"})
"""Cells without a number, as R and spreadsheets write them too."""
COMMA = re.compile(r"[+-]?(\d+,\d*|,\d+)([eE][+-]?\d+)?")


_THOUSANDS = (("[,]", "[.]"), ("[.]", "[,]"), ("['\u2019 \u00a0\u202f]", "[.,]"))
"""Marks between thousands, and those before the decimals of such numbers."""


def _grouped(thousand: str, decimal: str, always: bool = False) -> re.Pattern[str]:
    """Return what finds numbers whose thousands have marks, in cells between tabs, semicolons or quotation marks."""
    decimals = rf"({decimal}\d+){'' if always else '?'}"
    return re.compile(rf"(?<![^\t;\"+-])([1-9]\d{{0,2}}(?:{thousand}\d{{3}})+){decimals}(?![^\t;\"\r\n])")


def _ungrouped(mark: str) -> re.Pattern[str]:
    """Return what finds numbers with a mark where no thousands end, as in ``12.34`` and ``0.125``."""
    return re.compile(rf"(?<![^\t;\"+-])(?![1-9]\d{{0,2}}{mark}\d{{3}}(?!\d))\d+{mark}\d+(?![^\t;\"\r\n])")


def without_thousands(texts: Sequence[str]) -> list[str]:
    """Return rows without the marks that programs write between thousands: ``1,234.5``, ``1.234,5``, ``1 234,5``.

    They are taken for such where rows of numbers have another mark before decimals, in these numbers or in others, and
    none with their mark where no thousands end, as in ``12.34``. Of cells that commas separate only quoted ones can
    have them.
    """
    separator = separator_of(texts[len(texts) // 2]) if texts else None
    rows = [text for text in texts if '"' in text] if separator == "," else texts
    shown = [_grouped(*marks) for marks in _THOUSANDS if separator and _is_shown(rows, separator, *marks)]
    if len(shown) != 1:
        return list(texts)
    return [shown[0].sub(_plain, text) if separator != "," or '"' in text else text for text in texts]


def _is_shown(rows: Sequence[str], separator: str, thousand: str, decimal: str) -> bool:
    """Whether rows of numbers hold a mark between thousands and another before decimals, and none the other way."""
    if not all(any(mark in row for row in rows for mark in marks.strip("[]")) for marks in (thousand, decimal)):
        return False
    grouped = _grouped(thousand, decimal)

    def holds(form: re.Pattern[str]) -> bool:
        return any(is_number_row(grouped.sub("0", form.sub("0", row)), separator) for row in rows if form.search(row))

    decimals = (_grouped(thousand, decimal, always=True), _ungrouped(decimal))
    return holds(grouped) and any(map(holds, decimals)) and not holds(_ungrouped(thousand))


def _plain(match: re.Match[str]) -> str:
    """Return a number without the marks between its thousands."""
    return re.sub(r"\D", "", match[1]) + (match[2] or "")


def is_number_row(text: str, separator: str) -> bool:
    """Whether all cells of a row are numbers, gaps, times of day or dates."""
    return all(is_value(cell.strip(' "\r')) for cell in text.split(separator))


def is_value(cell: str) -> bool:
    """Whether a cell is a number, a gap, a time of day or a date."""
    return is_numeric(cell) or cell.upper() in GAPS or is_clock(cell) or is_date(cell)


def is_row(text: str) -> bool:
    """Whether a line is neither blank nor a comment."""
    return bool(text.strip()) and not text.lstrip().startswith("#")


def separator_of(first: str) -> str | None:
    """Return what separates the cells of a table, by its first line; None for blanks."""
    return next((mark for mark in ("\t", ";", ",") if mark in first), None)


def split_cells(path: str | Path, line: int, text: str, separator: str | None) -> list[str]:
    """Return the cells of one line; only numbers and clocks are split at blanks."""
    if separator is None:
        cells = [cell.strip('"') for cell in text.split()]
        return cells if all(map(is_value, cells)) else [text.strip()]
    try:
        rows = list(csv.reader([text], delimiter=separator, strict=True))
    except csv.Error:
        raise InputError(
            f"{path}, line {line}: a quotation mark is opened and not closed on its line, or a cell has no end; "
            "remove the mark"
        ) from None
    return [cell.strip() for cell in rows[0]]


def number(text: str) -> float:
    """Return the number that `text` is; `ValueError` if it is none (Python's own ``1_000`` is none in a table)."""
    if "_" in text:
        raise ValueError(text)
    return float(text)


def is_numeric(text: str) -> bool:
    """Whether a cell is a number, with either decimal mark."""
    return is_number(text) or COMMA.fullmatch(text) is not None


def is_number(text: str) -> bool:
    """Whether a cell is a number as Python writes it."""
    try:
        number(text)
    except ValueError:
        return False
    return True
