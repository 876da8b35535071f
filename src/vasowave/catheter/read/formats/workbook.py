"""Workbooks: the sheets that hold signals, each read as a table; the others are named and left out."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from vasowave.base import units
from vasowave.base.cures import UNKNOWN, SetCells
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.base.io.cells import is_row, is_value
from vasowave.base.io.clocks import bare
from vasowave.base.io.columns import read_headings
from vasowave.base.io.layout import HEAD, head_of, remarks_above
from vasowave.base.io.spreadsheet import WORKBOOKS, Sheet, is_workbook, read_sheets
from vasowave.base.io.textfile import Progress
from vasowave.base.sites import PULMONARY
from vasowave.catheter.read.choosing import quantity_of
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat, Wanted
from vasowave.catheter.read.formats.number_table import read_cycle, read_number_table
from vasowave.catheter.signals.channels import Block
from vasowave.catheter.signals.signal import ALIASES, Signal

SHEET_READ = look_kind(
    "recording.sheet",
    "the sheets {names} hold signals; '{sheet}' was read. {remedy}",
    "If another is meant, name it; if each is a recording, give each a row with its sheet.",
    SetCells("Name another sheet", (("sheet", UNKNOWN),)),
)
SHEET_REFUSED = look_kind(
    "recording.sheet-refused",
    "a sheet with signals cannot be read and was left out: {text}. {remedy}",
    "Correct it, or name the sheet that is meant.",
    SetCells("Name another sheet", (("sheet", UNKNOWN),)),
)
SHEETS_LEFT = note_kind("recording.sheets-left-out", "no recording, and left out: {sheets}")

_MIN_ROWS = 16  # of numbers, in a sheet that holds a signal
_MAX_TITLES = 6  # of a sheet that is none, in a sentence


class SignalSheets(NamedTuple):
    """Names of the sheets that hold signals, and descriptions of the others."""

    names: tuple[str, ...]
    left_out: tuple[str, ...]

    def findings(self, read: str) -> tuple[Finding, ...]:
        """Return what is said of the sheets when one of them is read."""
        shown = " and ".join(f"'{name}'" for name in self.names)
        several = [SHEET_READ(names=shown, sheet=read)] if len(self.names) > 1 else []
        return (*several, *([SHEETS_LEFT(sheets="; ".join(self.left_out))] if self.left_out else []))


def signal_sheets(path: Path) -> SignalSheets:
    """Return the sheets that hold pressure and flow, else those that hold one of them, else the only sheet.

    Raises
    ------
    InputError
        Several sheets and none with a signal: they are named with their titles.
    """
    sheets = read_sheets(path)
    looks = [_signals_of(path, sheet) for sheet in sheets]
    best = max(len(quantities) for quantities, _ in looks)
    if best == 0 and len(sheets) > 1:
        shown = "; ".join(_described(sheet, titles) for sheet, (_, titles) in zip(sheets, looks, strict=True))
        raise InputError(f"{path}: no sheet of this workbook holds pressure or flow over time: {shown}. Title them "
                         "pressure [mmHg] and flow [ml/s], or name a sheet",
                         [SetCells("Name the sheet", (("sheet", UNKNOWN),))])  # fmt: skip
    names = tuple(sheet.name for sheet, (quantities, _) in zip(sheets, looks, strict=True) if len(quantities) == best)
    left_out = tuple(
        _described(sheet, titles)
        for sheet, (quantities, titles) in zip(sheets, looks, strict=True)
        if len(quantities) < best
    )
    return SignalSheets(names, left_out)


def _described(sheet: Sheet, titles: Sequence[str]) -> str:
    shown = ", ".join(titles[:_MAX_TITLES]) + (", …" if len(titles) > _MAX_TITLES else "")
    return f"'{sheet.name}' ({shown or 'no titles'})"


def _signals_of(path: Path, sheet: Sheet) -> tuple[set[str], tuple[str, ...]]:
    """Return which of pressure, flow and velocity a sheet holds, and whether times, and its titles."""
    texts = sheet.content.split("\n", 3 * HEAD)[: 3 * HEAD]
    rows = [(line, text) for line, text in enumerate(texts, 1) if is_row(text)]
    try:
        titles = head_of(path, rows, remarks_above(texts)).titles
        names, column_units = read_headings(path, titles, ALIASES)
    except InputError:
        return set(), ()
    if sum(all(is_value(bare(cell)) for cell in text.split("\t")) for _, text in rows) < _MIN_ROWS:
        return set(), names
    quantities = ("pressure", "flow", "velocity")
    held = {quantity for quantity in (*quantities, "time") for name, unit in zip(names, column_units, strict=True)
            if quantity in (name, quantity_of(name)) or units.is_of(unit, quantity)}  # fmt: skip
    return held if held - {"time"} else set(), names


def read_workbook(path: Path, rate: float | None, progress: Progress | None, sheet: str = "") -> list[Block]:
    """Return a block for each sheet with signals that can be read, or for the one that is named."""
    sheets = SignalSheets((sheet,), ()) if sheet else signal_sheets(path)
    blocks, refusals = list[Block](), list[InputError]()
    for name in sheets.names:
        try:
            blocks.append(replace(read_number_table(path, rate, progress, name), sheet=name))
        except InputError as error:
            refusals.append(error)
    if not blocks:
        raise refusals[0]
    read = sheets._replace(names=tuple(block.sheet for block in blocks))
    notes = (*(SHEET_REFUSED(text=str(error)) for error in refusals), *read.findings(blocks[0].sheet))
    return [replace(blocks[0], suspicions=(*blocks[0].suspicions, *notes)), *blocks[1:]]


def read_cycle_of_workbook(
    path: Path, quantities: Wanted, site: str = PULMONARY, sheet: str = "", subject_row: str = ""
) -> list[Signal]:
    """Return the signals of one cycle from the sheet that is named, or the first with signals, or of subjects."""
    if subject_row:
        return read_cycle(path, quantities, site, sheet, subject_row)
    sheets = SignalSheets((sheet,), ()) if sheet else signal_sheets(path)
    first, *following = read_cycle(path, quantities, site, sheets.names[0])
    return [replace(first, notes=(*first.notes, *sheets.findings(sheets.names[0]))), *following]


RECORDINGS.register(
    RecordingFormat(
        "workbook", "workbook", WORKBOOKS, lambda path, start: is_workbook(start),
        read_workbook, cycle=read_cycle_of_workbook, sheets=True, subjects=True,
    )
)  # fmt: skip
