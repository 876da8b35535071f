"""A text table whose columns carry a name and a unit in the header: ``pressure [mmHg]``."""

import codecs
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vasowave.base import units
from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import Finding, look_kind, warn
from vasowave.base.io.cells import COMMA, is_number, is_numeric, is_row, number, split_cells, without_thousands
from vasowave.base.io.headings import split_title
from vasowave.base.io.layout import HEAD, head_of, is_long, remarks_above, spread, turned
from vasowave.base.io.remembered import remembered
from vasowave.base.io.spreadsheet import is_workbook
from vasowave.base.io.textfile import read_lines

_MAX_TITLES = 24  # of a header, in a sentence
_POINT = re.compile(r"[+-]?(\d+\.\d*|\.\d+)([eE][+-]?\d+)?")

NO_END = look_kind(
    "file.no-end",
    "the last line has no line end; was the file cut off?",
    "Export the file again, or end its last line.",
)
"""Of a text that may have lost its end."""


class NoRowsError(InputError):
    """A table has a header and nothing below it."""


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
    suspicions : tuple of Finding
        Why the file may not be whole.
    titles : tuple of str
        Of the columns, as they are written.
    row_word : str
        What `lines` counts: "line", or what a file that is not a text has in place of it.
    """

    source: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    cells: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]
    suspicions: tuple[Finding, ...] = ()
    titles: tuple[str, ...] = ()
    row_word: str = "line"

    def warn(self) -> None:
        """Warn that the file may be truncated."""
        for suspicion in self.suspicions:
            warn(suspicion.at(self.source), stacklevel=3)

    def find(self, name: str, also: Sequence[str] = ()) -> int | None:
        """Return the index of the column called `name` (or one of `also`), None if there is none."""
        names = {name, *also}
        hits = [i for i, column_name in enumerate(self.names) if column_name in names]
        if len(hits) > 1:
            titles = {self.titles[i].strip() if self.titles else self.names[i] for i in hits}
            if len(titles) == 1:
                raise InputError(f"{self.source}: two columns are called '{min(titles)}'; keep one of them")
            named = " and ".join(f"'{title}'" for title in sorted(titles))
            raise InputError(f"{self.source}: {named} are both read as {name}; leave out or rename what is none")
        return hits[0] if hits else None

    def unit_of(self, name: str) -> str:
        """Return the unit that the title of a column says; empty without one, and without the column."""
        return dict(zip(self.names, self.units, strict=True)).get(name, "")

    def require(self, name: str, also: Sequence[str] = (), titles: str = "") -> int:
        """Like `find`, but a missing column is an `InputError`, which says the `titles` of such tables."""
        column = self.find(name, also)
        if column is None:
            similar = next((column_name for column_name in self.names if column_name.startswith(f"{name}_")), "")
            hint = (
                f"; write '{similar}' as '{name} [{similar[len(name) + 1 :]}]'"
                if similar
                else did_you_mean(name, self.names)
            )
            examples = f"; such a table has the titles {titles}" if titles and not hint else ""
            raise InputError(f"{self.source}: no column '{name}'{hint}; {self._header()}{examples}")
        return column

    def _header(self) -> str:
        """Say which columns there are, of many the first."""
        count = f" … {len(self.names)} in all" if len(self.names) > _MAX_TITLES else ""
        return f"the header has: {', '.join(self.names[:_MAX_TITLES])}{count}" if self.names else "there is no header"

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
        return scale * self._floats(column, title)

    def matrix(self) -> np.ndarray:
        """Return all cells as floats, shape (rows, columns), of a table without header; errors as of `numbers`."""
        return np.column_stack([self._floats(column, str(column + 1)) for column in range(len(self.cells[0]))])

    def _floats(self, column: int, title: str) -> np.ndarray:
        return np.array([self._number(row, column, title) for row in range(len(self.cells))])

    def _number(self, row: int, column: int, title: str) -> float:
        text = self.cells[row][column]
        try:
            value = number(text)
        except ValueError:
            comma = "; is its comma a decimal mark? write a point" if COMMA.fullmatch(text.strip()) else ""
            fault = f"'{text}' is not a number{comma}" if text.strip() else "the cell is empty"
            raise InputError(f"{self.source}, {self.row_word} {self.lines[row]}, column '{title}': {fault}") from None
        if not math.isfinite(value):
            raise InputError(
                f"{self.source}, {self.row_word} {self.lines[row]}, column '{title}': {text.strip()} "
                "is not a finite number (a gap?); fill it, or leave out the part that holds it"
            )
        return value


_MARKED = {"{": "JSON", "[{": "JSON", "<?": "XML", "<!": "XML"}
"""How files begin that are no table, and what they are."""


def read_columns(path: str | Path, aliases: Mapping[str, str] | None = None, sheet: str = "") -> Columns:
    """Read a table whose cells are separated by tabs, semicolons, commas or blanks.

    Decimal commas are read where cells are not separated by commas too: the cells then hold decimal points.

    Parameters
    ----------
    path : path
        Text file, UTF-8, UTF-16 or cp1252. Lines that start with ``#`` and empty lines are skipped.
    aliases : mapping, optional
        Other spellings of column names, lower case, to the names vasowave uses.
    sheet : str, optional
        Of a workbook; the first visible one without it.

    Raises
    ------
    InputError
        File missing, empty, binary, with rows of different width or with both decimal marks (the line is named).
    """
    header, rows, lines, cut = _rows_of(Path(path), sheet)
    names, column_units = read_headings(path, header, aliases or {})
    return Columns(str(path), names, column_units, rows, lines, (NO_END(),) if cut else (), header)


@remembered
def _rows_of(path: Path, sheet: str = "") -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...], tuple[int, ...], bool]:
    """Return titles, rows, their lines, and whether the file ends without a line end."""
    numbered, cut, remarks = [], False, list[str]()
    for block in read_lines(path, sheet=sheet):
        rows_of_block = enumerate(without_thousands(block.texts), block.first)
        numbered += [(line, text) for line, text in rows_of_block if is_row(text)]
        remarks = remarks or remarks_above(block.texts)
        cut = block.cut
    if is_long([text for _, text in numbered]):
        numbered = list(enumerate(spread(path, numbered), 1))
    if over := turned([text for _, text in numbered[:HEAD]]):
        numbered = list(enumerate(over, 1))
    if not numbered:
        raise InputError(f"{path}: the file is empty")
    if marked := next((form for mark, form in _MARKED.items() if numbered[0][1].lstrip().startswith(mark)), ""):
        raise InputError(f"{path}: {marked} of a form that is not read here; write it as a table, CSV")
    head = head_of(path, numbered, remarks)
    header, separator, plan = head.titles, head.separator, head.plan
    numbered = numbered[head.first :]
    if not numbered:
        raise NoRowsError(f"{path}: a header and no data")
    lines = tuple(line for line, _ in numbered)
    rows = [split_cells(path, line, text, separator) for line, text in numbered]
    times = [plan.time(row) for row in rows] if plan else [[] for _ in rows]
    rows = [plan.numbers(row) for row in rows] if plan else rows
    if separator != ",":
        rows = _with_points(path, rows, lines)
    rows = [[*time, *row] for time, row in zip(times, rows, strict=True)]
    width = len(header) if header else len(rows[0])
    for row, line in zip(rows, lines, strict=True):
        if len(row) != width:
            comma = separator == "," and len(row) == 2 * width and all(is_number(cell) for cell in row)
            reason = "; if the comma is a decimal mark too, separate the cells with semicolons" if comma else ""
            raise InputError(f"{path}, line {line}: {len(row)} columns where {width} were expected{reason}")
    return header, tuple(map(tuple, rows)), lines, cut


def read_titles(path: Path, start: bytes, sheet: str = "") -> tuple[str, ...]:
    """Return the titles of a table's columns, lower case, by the first bytes of its file; none if it has none."""
    if is_workbook(start):
        texts = next((block.texts for block in read_lines(path, sheet=sheet)), [])
    else:
        encoding = "utf-16" if start[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE) else "utf-8-sig"
        texts = start.decode(encoding, errors="replace").split("\n")
    rows = [(line, text) for line, text in enumerate(texts, 1) if is_row(text)]
    try:
        return read_headings(path, head_of(path, rows).titles, {})[0] if rows else ()
    except InputError:
        return ()


def read_headings(
    path: str | Path, header: Sequence[str], aliases: Mapping[str, str]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return names (lower case, aliases resolved) and units of column titles written as ``name [unit]``."""
    names, column_units = [], []
    for heading in header:
        name_and_unit = split_title(heading)
        if name_and_unit is None:
            raise InputError(f"{path}: cannot read the column title '{heading}'; write 'name [unit]'")
        name = name_and_unit[0].strip().lower()
        names.append(aliases.get(name, name))
        column_units.append((name_and_unit[1] or "").strip())
    return tuple(names), tuple(column_units)


def plain_title(heading: str) -> str:
    """Return a column title as it is written, without its unit."""
    name_and_unit = split_title(heading)
    return name_and_unit[0].strip() if name_and_unit else heading


def _with_points(path: str | Path, rows: list[list[str]], lines: Sequence[int]) -> list[list[str]]:
    """Return the rows with decimal points; both marks in one file would make values a thousandfold."""
    first = {}
    for mark, form in ((",", COMMA), (".", _POINT)):
        first[mark] = next((n for row, n in zip(rows, lines) if any(map(form.fullmatch, row))), 0)
    if first[","] and first["."]:
        raise InputError(
            f"{path}: a number with a comma in line {first[',']}, one with a point in line {first['.']}; write all "
            "decimal marks alike, and no marks between thousands"
        )
    if not first[","]:
        return rows
    return [[cell.replace(",", ".") if COMMA.fullmatch(cell) else cell for cell in row] for row in rows]


def split_unit(label: str) -> tuple[str, str]:
    """Split ``"S [mmHg2]"`` into ``("S", "mmHg2")``; the unit of a label without one is empty."""
    match = re.fullmatch(r"(.*?)\s*\[(.*)\]", label)
    return (match[1], match[2]) if match else (label, "")


def spreadsheet_cell(text: str) -> str:
    """Return a text as a cell that no spreadsheet runs: with an apostrophe before what it would take for a formula."""
    return f"'{text}" if text.lstrip()[:1] in tuple("=+-@") and not is_numeric(text) else text
