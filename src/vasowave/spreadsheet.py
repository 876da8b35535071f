"""The first visible sheet of an Excel workbook (.xlsx, ECMA-376), row by row, in bounded memory."""

import math
import re
import zipfile
import zlib
from collections.abc import Callable, Iterator
from datetime import datetime, timedelta
from pathlib import Path
from typing import NamedTuple
from xml.parsers import expat

from vasowave.errors import InputError

_CHUNK = 1 << 16
_MOST_SHEET, _MOST_OTHER = 256 << 20, 32 << 20  # bytes unpacked; a million rows of four numbers have 150 MB
_MOST_ROWS, _MOST_COLUMNS, _LONGEST_CELL = 1 << 20, 1 << 14, 1 << 16  # Excel's own limits, or above them
_PLACE = re.compile(r"([A-Z]{1,3})(\d{1,7})")
_DATES = {*range(14, 23), *range(27, 37), *range(45, 48), *range(50, 59)}  # built-in formats of dates and times
_NOT_SHOWN = re.compile(r'"[^"]*"|\\.|_.|\*.|\[(?![hms]+\])[^\]]*\]', re.IGNORECASE)  # of a format: literals, colors
_ZIP, _OLE = b"PK\x03\x04", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_AS_CSV = "save the sheet as .xlsx or CSV"

Progress = Callable[[float], None]


class _Part(NamedTuple):
    """What is known of the workbook before its sheet is read."""

    shared: list[str]
    dates: list[bool]  # by style
    epoch: datetime


def is_workbook(start: bytes) -> bool:
    """Whether a file that starts like this is a spreadsheet's, of whatever program."""
    return start.startswith((_ZIP, _OLE))


def read_sheet(path: Path, progress: Progress | None = None) -> Iterator[tuple[int, list[str]]]:
    """Yield number and cells of every row of the first visible sheet that is not empty.

    Numbers come as Python writes them, formulas as their last value, dates and times as text, so that none of them is
    taken for a number.

    Raises
    ------
    InputError
        No .xlsx (another program's, protected, damaged), or one that unpacks to more than any table needs.
    """
    try:
        with path.open("rb") as file:
            if file.read(len(_OLE)) == _OLE:
                raise InputError(f"an .xls file, or protected by a password; {_AS_CSV}, without a password")
        with zipfile.ZipFile(path) as archive:
            yield from _rows(archive, progress)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError) as error:
        raise InputError(f"{path}: a damaged, truncated or protected workbook ({error}); {_AS_CSV} again") from None
    except (expat.ExpatError, LookupError, ValueError, OverflowError, StopIteration) as error:
        raise InputError(f"{path}: a damaged workbook ({error}); {_AS_CSV} again") from None


def _rows(archive: zipfile.ZipFile, progress: Progress | None) -> Iterator[tuple[int, list[str]]]:
    names = set(archive.namelist())
    if "xl/workbook.xml" not in names:
        raise InputError(f"not a workbook of Excel; {_AS_CSV}")
    sheet, epoch = _first_sheet(archive)
    shared = _SharedStrings()
    if "xl/sharedStrings.xml" in names:
        _parse(archive, "xl/sharedStrings.xml", shared)
    styles = _Styles()
    if "xl/styles.xml" in names:
        _parse(archive, "xl/styles.xml", styles)
    reader = _Sheet(_Part(shared.found, styles.dates(), epoch))
    size = max(archive.getinfo(sheet).file_size, 1)
    for read in _fed(archive, sheet, reader):
        yield from reader.taken()
        if progress:
            progress(min(read / size, 1.0))


def _first_sheet(archive: zipfile.ZipFile) -> tuple[str, datetime]:
    """Return the part that holds the first visible sheet, and the day from which the workbook counts dates."""
    book, links = _Elements("sheet", "workbookPr"), _Elements("Relationship")
    _parse(archive, "xl/workbook.xml", book)
    _parse(archive, "xl/_rels/workbook.xml.rels", links)
    targets = {one["Id"]: one["Target"] for _, one in links.found}
    sheets = [one for tag, one in book.found if tag == "sheet" and one.get("state", "visible") == "visible"]
    if not sheets:
        raise InputError(f"no visible sheet; {_AS_CSV}")
    target = targets[next(value for key, value in sheets[0].items() if key.rpartition(":")[2] == "id")]
    from_1904 = any(one.get("date1904") in ("1", "true") for tag, one in book.found if tag == "workbookPr")
    epoch = datetime(1904, 1, 1) if from_1904 else datetime(1899, 12, 30)
    return (target.lstrip("/") if target.startswith("/") else f"xl/{target}"), epoch


def _parse(archive: zipfile.ZipFile, name: str, handler: "_Handler") -> None:
    for _ in _fed(archive, name, handler):
        pass


def _fed(archive: zipfile.ZipFile, name: str, handler: "_Handler") -> Iterator[int]:
    """Feed a part to a handler piece by piece, and yield how many bytes it has got."""

    def refuse(*_: object) -> None:
        raise InputError(f"declares XML entities, which no workbook does; {_AS_CSV}")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = lambda tag, given: handler.start(tag.rpartition(":")[2], given)
    parser.EndElementHandler = lambda tag: handler.end(tag.rpartition(":")[2])
    parser.CharacterDataHandler = handler.data
    read, part = 0, archive.getinfo(name)
    if part.file_size > (most := _MOST_SHEET if isinstance(handler, _Sheet) else _MOST_OTHER):
        raise InputError(f"{name} unpacks to {part.file_size >> 20} MB, more than {most >> 20}; save the sheet as CSV")
    if part.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise InputError(f"packed as no workbook is; {_AS_CSV}")
    with archive.open(part) as stream:  # which ends at the size that was declared
        while piece := stream.read(_CHUNK):
            parser.Parse(piece, False)
            read += len(piece)
            yield read
        parser.Parse(b"", True)
    yield read


class _Handler:
    """What is done with the elements of a part, as they come; nothing is kept that is not asked for."""

    def start(self, tag: str, given: dict[str, str]) -> None: ...

    def end(self, tag: str) -> None: ...

    def data(self, text: str) -> None: ...


class _Elements(_Handler):
    """The attributes of the elements of some names."""

    def __init__(self, *tags: str) -> None:
        self._tags, self.found = tags, list[tuple[str, dict[str, str]]]()

    def start(self, tag: str, given: dict[str, str]) -> None:
        if tag in self._tags:
            self.found.append((tag, given))


class _Text(_Handler):
    """The text of elements, gathered where it is wanted."""

    def __init__(self) -> None:
        self._parts: list[str] = []
        self._wanted, self._length = False, 0

    def begin(self) -> None:
        self._parts, self._length = [], 0

    def data(self, text: str) -> None:
        if self._wanted:
            self._length += len(text)
            if self._length > _LONGEST_CELL:
                raise InputError(f"a cell with more than {_LONGEST_CELL} characters is no table's")
            self._parts.append(text)

    @property
    def text(self) -> str:
        return "".join(self._parts)


class _SharedStrings(_Text):
    """The texts that cells refer to by number; how a word is pronounced (rPh) is no part of it."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self._aside = False

    def start(self, tag: str, given: dict[str, str]) -> None:
        if tag == "si":
            self.begin()
        self._aside = self._aside or tag == "rPh"
        self._wanted = tag == "t" and not self._aside

    def end(self, tag: str) -> None:
        self._wanted = False
        self._aside = self._aside and tag != "rPh"
        if tag == "si":
            self.found.append(self.text)


class _Styles(_Handler):
    """Which styles show a number as a date or a time."""

    def __init__(self) -> None:
        self._formats: dict[int, str] = {}
        self._used: list[int] = []
        self._inside = False

    def start(self, tag: str, given: dict[str, str]) -> None:
        self._inside = self._inside or tag == "cellXfs"
        if tag == "numFmt":
            self._formats[int(given["numFmtId"])] = given["formatCode"]
        elif tag == "xf" and self._inside:
            self._used.append(int(given.get("numFmtId", 0)))

    def end(self, tag: str) -> None:
        self._inside = self._inside and tag != "cellXfs"

    def dates(self) -> list[bool]:
        shown = {number: _NOT_SHOWN.sub("", code) for number, code in self._formats.items()}
        dated = {number for number, code in shown.items() if re.search("[dmyhs]", code, re.IGNORECASE)}
        return [number in dated or (number in _DATES and number not in shown) for number in self._used]


class _Sheet(_Text):
    """The rows of a sheet."""

    def __init__(self, book: _Part) -> None:
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
        if tag == "row":
            self._start_row(int(given.get("r", self._row + 1)))
        elif tag == "c":
            self._column = self._column_of(given.get("r"))
            self._kind, self._style = given.get("t", "n"), int(given.get("s", 0))
            self.begin()
        self._wanted = tag in ("v", "t")

    def end(self, tag: str) -> None:
        self._wanted = False
        if tag == "c" and self.text:
            self._cells[self._column] = self._value()
        elif tag == "row" and any(self._cells.values()):
            self._rows.append((self._row, [self._cells.get(i, "") for i in range(1, max(self._cells) + 1)]))

    def _start_row(self, number: int) -> None:
        if not self._row < number <= _MOST_ROWS:
            raise InputError(f"row {number} follows row {self._row}; {_AS_CSV} again")
        self._row, self._column, self._cells = number, 0, {}

    def _column_of(self, place: str | None) -> int:
        match = _PLACE.fullmatch(place or "")
        found = self._column + 1
        if match:
            found = 0
            for letter in match[1]:
                found = 26 * found + ord(letter) - 64
        if not self._column < found <= _MOST_COLUMNS:
            raise InputError(f"row {self._row}: cell {place} is out of place; {_AS_CSV} again")
        return found

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
