"""The first visible sheet of an Excel workbook (.xlsx, ECMA-376), row by row, in bounded memory."""

import zipfile
import zlib
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path
from xml.parsers import expat

from vasowave.errors import InputError
from vasowave.io.sheet_xml import Book, Elements, Handler, SharedStrings, Sheet, Styles

_CHUNK = 1 << 16  # bytes that are unpacked at a time
_MOST_SHEET, _MOST_OTHER = 256 << 20, 32 << 20  # bytes unpacked; a million rows of four numbers have 150 MB
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
    shared = SharedStrings()
    if "xl/sharedStrings.xml" in names:
        _parse(archive, "xl/sharedStrings.xml", shared)
    styles = Styles()
    if "xl/styles.xml" in names:
        _parse(archive, "xl/styles.xml", styles)
    reader = Sheet(Book(shared.texts, styles.dates(), epoch))
    size = max(archive.getinfo(sheet).file_size, 1)
    for read in _fed(archive, sheet, reader):
        yield from reader.taken()
        if progress:
            progress(min(read / size, 1.0))


def _first_sheet(archive: zipfile.ZipFile) -> tuple[str, datetime]:
    """Return the part that holds the first visible sheet, and the day from which the workbook counts dates."""
    book, links = Elements("sheet", "workbookPr"), Elements("Relationship")
    _parse(archive, "xl/workbook.xml", book)
    _parse(archive, "xl/_rels/workbook.xml.rels", links)
    targets = {one["Id"]: one["Target"] for _, one in links.elements}
    sheets = [one for tag, one in book.elements if tag == "sheet" and one.get("state", "visible") == "visible"]
    if not sheets:
        raise InputError(f"no visible sheet; {_AS_CSV}")
    target = targets[next(value for key, value in sheets[0].items() if key.rpartition(":")[2] == "id")]
    from_1904 = any(one.get("date1904") in ("1", "true") for tag, one in book.elements if tag == "workbookPr")
    epoch = datetime(1904, 1, 1) if from_1904 else datetime(1899, 12, 30)
    return (target.lstrip("/") if target.startswith("/") else f"xl/{target}"), epoch


def _parse(archive: zipfile.ZipFile, name: str, handler: Handler) -> None:
    for _ in _fed(archive, name, handler):
        pass


def _fed(archive: zipfile.ZipFile, name: str, handler: Handler) -> Iterator[int]:
    """Feed a part to a handler piece by piece, and yield how many bytes it has got."""

    def refuse(*_: object) -> None:
        raise InputError(f"declares XML entities, which no workbook does; {_AS_CSV}")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = lambda tag, given: handler.start(tag.rpartition(":")[2], given)
    parser.EndElementHandler = lambda tag: handler.end(tag.rpartition(":")[2])
    parser.CharacterDataHandler = handler.data
    read, part = 0, archive.getinfo(name)
    if part.file_size > (most := _MOST_SHEET if isinstance(handler, Sheet) else _MOST_OTHER):
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
