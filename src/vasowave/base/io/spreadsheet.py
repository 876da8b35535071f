"""The sheets of workbooks (.xlsx, .xlsm, .xlsb, .xls, .ods) as text, read by calamine in another process."""

import zipfile
from datetime import datetime, time, timedelta
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.io.apart import ReaderAnswer, read_apart
from vasowave.base.io.remembered import remembered

WORKBOOKS = (".xlsx", ".xlsm", ".xlsb", ".xls", ".ods")
"""What names of workbooks end in."""

_MAX_UNPACKED = 512 << 20  # bytes; a million rows of four numbers have 150 MB
_MAX_CELLS = 1 << 26  # of a sheet; more than a table of signals has, and as many as memory holds
_LONGEST_CELL = 1 << 16  # characters; Excel allows half of them
_ZIP, _OLE = b"PK\x03\x04", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_AS_CSV = "save the sheet as .xlsx or CSV"


class Sheet(NamedTuple):
    """A visible sheet: its name, and its rows, from the first on, as lines whose cells are separated by tabs."""

    name: str
    content: str


def is_workbook(start: bytes) -> bool:
    """Whether a file that starts like this is a spreadsheet's, of whatever program; NumPy's archives are none."""
    return start.startswith((_ZIP, _OLE)) and b".npy" not in start[30:96]


@remembered
def read_sheets(path: Path) -> tuple[Sheet, ...]:
    """Return the visible sheets that are not empty, in their order.

    Numbers come as Python writes them, formulas as their last value, dates and times as text to the millisecond, so
    that none of them is taken for a number; an error is an empty cell.

    Raises
    ------
    InputError
        No workbook, protected, damaged, without a visible sheet, or one that unpacks to more than any table needs.
    """
    path = Path(path)
    with path.open("rb") as file:
        locked = ", or protected by a password" if file.read(len(_OLE)) == _OLE else ""
    names, arrays = read_apart(sheets_of, path, f"a workbook{locked}", f"{_AS_CSV} again", _unpacked(path))
    if not names:
        raise InputError(f"{path}: no visible sheet holds anything; {_AS_CSV}")
    return tuple(Sheet(name, array.tobytes().decode()) for name, array in zip(names, arrays, strict=True))


def sheet_named(path: Path, name: str = "") -> Sheet:
    """Return a sheet by its name in any case, the first without one; `InputError` if there is none of that name."""
    sheets = read_sheets(path)
    named = [sheet for sheet in sheets if not name or sheet.name.strip().casefold() == name.strip().casefold()]
    if not named:
        names = [sheet.name for sheet in sheets]
        raise InputError(f"{path}: no visible sheet '{name}'{did_you_mean(name, names)}; it has: {', '.join(names)}")
    return named[0]


def _unpacked(path: Path) -> int:
    """Return how many bytes a workbook says to unpack to; refuse one that no table needs."""
    try:
        with zipfile.ZipFile(path) as archive:
            members = archive.infolist()
            size = sum(member.file_size for member in members)
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError, EOFError):
        return 0  # an .xls, or damaged, as the reader will say
    names = [member.filename for member in members if not member.filename.startswith("__MACOSX") and member.file_size]
    if not any(name.endswith(".xml") for name in names):  # as every workbook has some
        raise InputError(
            f"{path}: an archive that holds {', '.join(names[:4]) or 'nothing'}; unpack it, and give what it holds"
        )
    if size > _MAX_UNPACKED:
        raise InputError(f"{path}: unpacks to {size >> 20} MB, more than {_MAX_UNPACKED >> 20}; save the sheet as CSV")
    return size


def sheets_of(path: Path) -> ReaderAnswer:
    """Return names and lines of the visible sheets; any exception of calamine, or the end of the process."""
    from python_calamine import CalamineWorkbook, PasswordError, SheetTypeEnum, SheetVisibleEnum

    names, texts = list[str](), list[np.ndarray]()
    try:
        with path.open("rb") as file, CalamineWorkbook.from_filelike(file) as book:
            for about in book.sheets_metadata:
                if about.visible == SheetVisibleEnum.Visible and about.typ == SheetTypeEnum.WorkSheet:
                    sheet = book.get_sheet_by_name(about.name)
                    if sheet.total_height * sheet.total_width > _MAX_CELLS:
                        raise InputError(f"{path}: sheet '{about.name}' has more cells than any table; {_AS_CSV}")
                    text = _lines(path, sheet)
                    if text.strip():
                        names.append(about.name)
                        texts.append(np.frombuffer(text.encode(errors="replace"), np.uint8))
    except PasswordError:
        raise InputError(f"{path}: protected by a password; {_AS_CSV}, without a password") from None
    return ReaderAnswer(names, texts)


def _lines(path: Path, sheet: Any) -> str:
    """Return the rows of a sheet as lines of equally many cells."""
    if sheet.start is None:
        return ""
    rows = [[_cell(value) for value in cells] for cells in sheet.iter_rows()]
    if any(len(cell) > _LONGEST_CELL for cells in rows for cell in cells):
        raise InputError(f"{path}: a cell with more than {_LONGEST_CELL} characters is no table's")
    return "\n".join(["\t".join(cells) if any(cells) else "" for cells in rows]) + "\n"


def _cell(value: Any) -> str:
    """Return a cell as a table separated by tabs holds it."""
    if isinstance(value, bool):
        return str(value).upper()
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
    if isinstance(value, datetime | time):
        return value.isoformat(timespec="milliseconds").replace("T", " ")
    if isinstance(value, timedelta):
        hours, seconds = divmod(round(value.total_seconds(), 3), 3600)
        return f"{hours:.0f}:{seconds // 60:02.0f}:{seconds % 60:06.3f}"
    text = str(value)
    plain = " ".join(text.split()) if any(mark in text for mark in "\t\n\r") else text
    return '"' + plain.replace('"', '""') + '"' if '"' in plain else plain
