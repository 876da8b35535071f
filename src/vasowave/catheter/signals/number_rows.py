"""Rows of numbers that are read block by block: quick where they are usual, cell by cell where they are not."""

import math
import re
from bisect import bisect_right
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.cells import GAPS, number
from vasowave.base.io.textfile import Lines
from vasowave.catheter.signals.signal import RATE

_ROWS_PER_CHUNK = 4096
"""Rows that are read cell by cell are stored this many at once."""


_CLOCK = re.compile(r"\d{1,2}:\d{2}(:\d{2}([.,]\d+)?)?")
_NO_CLOCK = (
    "; a time of day is not read: write seconds since the start, or leave the column out and say how many samples a "
    "second has"
)


class DecimalMark:
    """The decimal mark that a file uses; both in one file would make values a thousandfold."""

    def __init__(self, path: str | Path) -> None:
        self._path, self._seen = path, ""

    def comma(self, lines: Lines) -> bool:
        """Return whether numbers are written with a comma; `InputError` names the line of the second mark."""
        for mark in ",.":
            if mark == self._seen or not lines.hold(mark):
                continue
            if self._seen:
                line, text = next((i, text) for i, text in enumerate(lines.texts, lines.first) if mark in text)
                if clock := _CLOCK.search(text):
                    raise InputError(f"{self._path}, line {line}: '{clock[0]}' is not a number{_NO_CLOCK}", [RATE])
                raise InputError(
                    f"{self._path}, line {line}: numbers with a decimal comma and with a decimal point in one file; "
                    "export it again with one of them"
                )
            self._seen = mark
        return self._seen == ","


class NumberRows:
    """Columns of numbers that grow; every row has the same number of cells.

    Parameters
    ----------
    place : str
        How errors call the table.
    titles : sequence of str
        One per column.
    separator : str, optional
        None for blanks.
    """

    def __init__(self, place: str, titles: Sequence[str], separator: str | None) -> None:
        self.place: str = place
        self.titles: tuple[str, ...] = tuple(titles)
        self.separator: str | None = separator
        self.count: int = 0
        self._parts: list[list[np.ndarray]] = [[] for _ in titles]
        self._runs: list[tuple[int, int]] = []
        self._pending: list[list[float]] = []

    def add_block(self, first_line: int, lines: list[str], comma: bool) -> bool:
        """Add consecutive lines at once; False, and nothing added, where one of them is not just numbers."""
        if not lines:
            return True
        written = [line.replace(",", ".") for line in lines] if comma and self.separator != "," else lines
        try:
            rows = np.loadtxt(written, delimiter=self.separator, comments=None, ndmin=2)
        except ValueError:
            return False
        # The parser skips empty lines, and takes what a table should not hold for numbers.
        if rows.shape != (len(lines), len(self.titles)):
            return False
        rows[np.isinf(rows)] = math.nan
        self._start_at(first_line)
        self._flush()
        self._store(rows)
        self.count += len(rows)
        return True

    def add_row(self, line: int, cells: list[str], comma: bool) -> None:
        """Add one row; an empty cell, ``NaN`` or a spreadsheet's mark of no value is a gap.

        Raises
        ------
        InputError
            Another number of cells, or a cell that is not a number.
        """
        if len(cells) != len(self.titles):
            defect = "missing" if len(cells) < len(self.titles) else "surplus"
            if not self.count and defect == "surplus":
                raise InputError(
                    f"{self.place}, line {line}: {len(cells)} columns below a header of {len(self.titles)}; if title "
                    "lines stand above the names of the columns, remove them, so that the names come first"
                )
            raise InputError(
                f"{self.place}, line {line}: {len(cells)} columns where {len(self.titles)} were expected; {defect} "
                "values: the line was cut or damaged, export the file again"
            )
        self._start_at(line)
        self._pending.append([self._number(line, *pair, comma) for pair in zip(cells, self.titles, strict=True)])
        self.count += 1
        if len(self._pending) >= _ROWS_PER_CHUNK:
            self._flush()

    def _number(self, line: int, cell: str, title: str, comma: bool) -> float:
        text = cell.strip()
        try:
            value = math.nan if text.upper() in GAPS else number(text.replace(",", ".") if comma else text)
        except ValueError:
            hint, cures = (_NO_CLOCK, [RATE]) if _CLOCK.fullmatch(text) else ("", [])
            place = f"{self.place}, line {line}, column '{title}'"
            raise InputError(f"{place}: '{text}' is not a number{hint}", cures) from None
        return value if math.isfinite(value) else math.nan

    def _start_at(self, line: int) -> None:
        """Note where rows stand, if `line` does not follow the last one."""
        if not self._runs or self.line(self.count) != line:
            self._runs.append((self.count, line))

    def _flush(self) -> None:
        if self._pending:
            self._store(np.array(self._pending))
            self._pending = []

    def _store(self, rows: np.ndarray) -> None:
        for chunks, column in zip(self._parts, rows.T, strict=True):
            chunks.append(column.copy())

    def line(self, row: int) -> int:
        """Return the line of the file on which a row stands."""
        run = bisect_right(self._runs, (row, math.inf)) - 1
        return self._runs[run][1] + row - self._runs[run][0]

    def take(self, column: int) -> np.ndarray:
        """Return one column, shape (row,), and forget it, so that no more than one is held twice."""
        self._flush()
        chunks, self._parts[column] = self._parts[column], []
        return np.concatenate(chunks) if chunks else np.empty(0)
