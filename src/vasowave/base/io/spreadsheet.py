"""The first visible sheet of an Excel workbook (.xlsx, ECMA-376), row by row, in bounded memory."""

import math
import re
import zipfile
import zlib
from collections.abc import Callable, Iterator, Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, ParseError, XMLPullParser

from vasowave.base.errors import InputError

_CHUNK = 1 << 14  # bytes that are unpacked at a time
_MOST_SHEET, _MOST_OTHER = 256 << 20, 32 << 20  # bytes unpacked; a million rows of four numbers have 150 MB
_MOST_ROWS, _MOST_COLUMNS, _LONGEST_CELL = 1 << 20, 1 << 14, 1 << 16  # Excel's own limits, or above them
_PLACE = re.compile(r"([A-Z]{1,3})(\d{1,7})")
_DATES = {*range(14, 23), *range(27, 37), *range(45, 48), *range(50, 59)}  # built-in formats of dates and times
_NOT_SHOWN = re.compile(r'"[^"]*"|\\.|_.|\*.|\[(?![hms]+\])[^\]]*\]', re.IGNORECASE)  # of a format: literals, colors
_ZIP, _OLE = b"PK\x03\x04", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_AS_CSV = "save the sheet as .xlsx or CSV"

Progress = Callable[[float], None]


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
            file.seek(0)
            with zipfile.ZipFile(file) as archive:
                yield from _rows(archive, progress)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError) as error:
        raise InputError(f"{path}: a damaged, truncated or protected workbook ({error}); {_AS_CSV} again") from None
    except (ParseError, LookupError, ValueError, OverflowError, StopIteration) as error:
        raise InputError(f"{path}: a damaged workbook ({error}); {_AS_CSV} again") from None


def _rows(archive: zipfile.ZipFile, progress: Progress | None) -> Iterator[tuple[int, list[str]]]:
    names = set(archive.namelist())
    if "xl/workbook.xml" not in names:
        raise InputError(f"not a workbook of Excel; {_AS_CSV}")
    sheet, epoch = _first_sheet(archive)
    strings, styles = ("xl/sharedStrings.xml", "xl/styles.xml")
    shared = [_text(element) for element in _elements(archive, strings, "si")] if strings in names else []
    dates = _dates(archive, styles) if styles in names else []
    before = 0
    for row in _elements(archive, sheet, "row", max_bytes=_MOST_SHEET, progress=progress):
        number = int(row.get("r", before + 1))
        if not before < number <= _MOST_ROWS:
            raise InputError(f"row {number} follows row {before}; save the sheet again")
        before, cells = number, dict[int, str]()
        for cell in row:
            if _name(cell.tag) == "c":
                column = _column(cell.get("r"), max(cells, default=0), number)
                cells[column] = _value(cell, shared, dates, epoch)
        if any(cells.values()):
            yield number, [cells.get(i, "") for i in range(1, max(i for i in cells if cells[i]) + 1)]


def _first_sheet(archive: zipfile.ZipFile) -> tuple[str, datetime]:
    """Return the part that holds the first visible sheet, and the day from which the workbook counts dates."""
    book = list(_elements(archive, "xl/workbook.xml", "sheet", "workbookPr"))
    targets = {element.attrib["Id"]: element.attrib["Target"]
               for element in _elements(archive, "xl/_rels/workbook.xml.rels", "Relationship")}  # fmt: skip
    sheets = [
        element for element in book if _name(element.tag) == "sheet" and element.get("state", "visible") == "visible"
    ]
    if not sheets:
        raise InputError(f"no visible sheet; {_AS_CSV}")
    target = targets[next(value for key, value in sheets[0].items() if _name(key) == "id")]
    from_1904 = any(element.get("date1904") in ("1", "true") for element in book if _name(element.tag) == "workbookPr")
    epoch = datetime(1904, 1, 1) if from_1904 else datetime(1899, 12, 30)
    return (target.lstrip("/") if target.startswith("/") else f"xl/{target}"), epoch


def _dates(archive: zipfile.ZipFile, styles: str) -> list[bool]:
    """Return for each style whether it shows a number as a date or a time."""
    shown, used = dict[int, str](), list[int]()
    for element in _elements(archive, styles, "numFmt", "cellXfs"):
        if _name(element.tag) == "numFmt":
            shown[int(element.attrib["numFmtId"])] = _NOT_SHOWN.sub("", element.attrib["formatCode"])
        else:
            used += [int(style.get("numFmtId", 0)) for style in element if _name(style.tag) == "xf"]
    dated = {number for number, code in shown.items() if re.search("[dmyhs]", code, re.IGNORECASE)}
    return [number in dated or (number in _DATES and number not in shown) for number in used]


def _column(place: str | None, before: int, row: int) -> int:
    """Return the column of a cell, counted from 1."""
    match, column = _PLACE.fullmatch(place or ""), before + 1
    if match:
        column = 0
        for letter in match[1]:
            column = 26 * column + ord(letter) - 64
    if not before < column <= _MOST_COLUMNS:
        raise InputError(f"row {row}: cell {place} is out of place; save the sheet again")
    return column


def _value(cell: Element, shared: Sequence[str], dates: Sequence[bool], epoch: datetime) -> str:
    """Return the text that stands for a cell."""
    kind, style, text = cell.get("t", "n"), int(cell.get("s", 0)), _text(cell)
    if not text:
        return ""
    if kind == "s":
        return shared[int(text)] if int(text) >= 0 else ""
    if kind == "b":
        return "TRUE" if text == "1" else "FALSE"
    if kind == "e":  # '#DIV/0!' at the start of a row would make a remark of it
        return f"error {text.strip('#')}"
    if kind != "n":
        return text
    value = math.nan if "_" in text else float(text)
    if style < len(dates) and dates[style]:
        return str(epoch + timedelta(days=value))
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def _text(element: Element) -> str:
    """Return the text of an element; how a word is pronounced (rPh), and a formula, are no part of it."""
    inside = ((child, _name(child.tag)) for child in element)
    texts = [
        child.text or "" if name in ("t", "v") else _text(child) for child, name in inside if name not in ("rPh", "f")
    ]
    if sum(map(len, texts)) > _LONGEST_CELL:
        raise InputError(f"a cell with more than {_LONGEST_CELL} characters is no table's")
    return "".join(texts)


def _name(tag: str) -> str:
    return tag.rpartition("}")[2]


def _elements(
    archive: zipfile.ZipFile, member: str, *names: str, max_bytes: int = _MOST_OTHER, progress: Progress | None = None
) -> Iterator[Element]:
    """Yield the elements of some names as they end; they are forgotten when the next is asked for."""
    about = archive.getinfo(member)
    if about.file_size > max_bytes:
        raise InputError(
            f"{member} unpacks to {about.file_size >> 20} MB, more than {max_bytes >> 20}; save the sheet as CSV"
        )
    if about.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise InputError(f"packed as no workbook is; {_AS_CSV}")
    parser: Any = XMLPullParser(("start", "end"))
    above, read, end = list[Element](), 0, b""
    with archive.open(about) as stream:  # which ends at the size that was declared
        while piece := stream.read(_CHUNK):
            if b"\0" in piece or b"<!DOCTYPE" in end + piece:
                raise InputError(f"declares XML entities, or is not in UTF-8, which no workbook does; {_AS_CSV}")
            end = piece[-8:]
            parser.feed(piece)
            for event, element in parser.read_events():
                if event == "start":
                    above.append(element)
                    continue
                above.pop()
                if _name(element.tag) in names:
                    yield element
                    if above:
                        above[-1].clear()
            read += len(piece)
            if progress:
                progress(min(read / max(about.file_size, 1), 1.0))
    parser.close()
