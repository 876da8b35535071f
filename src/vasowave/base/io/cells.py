"""Cells of a table: what separates them, and which are numbers, gaps, times or dates."""

import csv
import re
from pathlib import Path

from vasowave.base.errors import InputError
from vasowave.base.io.clocks import is_clock, is_date

GAPS = frozenset({"", "NA", "N/A", "NAN", "-", "--", "#NV", "#N/A", "#NULL!", "#WERT!", "#VALUE!", "#DIV/0!"})
"""Cells without a number, as R and spreadsheets write them too."""
COMMA = re.compile(r"[+-]?(\d+,\d*|,\d+)([eE][+-]?\d+)?")


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
        cells = text.split()
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
