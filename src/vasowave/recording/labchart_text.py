"""The text export of ADInstruments LabChart: tab-separated, one header before every block."""

import math
import re
from itertools import zip_longest
from pathlib import Path

import numpy as np

from vasowave import units
from vasowave.errors import InputError
from vasowave.recording.channels import Block, Channel, Comment, read_bytes

_KEYS = (
    "Interval",
    "ExcelDateTime",
    "TimeFormat",
    "DateFormat",
    "ChannelTitle",
    "Range",
    "UnitName",
    "TopValue",
    "BottomValue",
)
_KEY = re.compile(rf"({'|'.join(_KEYS)})=")
_REMARK = re.compile(r"#(\*|\d+)\s?(.*)")
_Lines = list[tuple[int, list[str]]]
"""Line numbers of the file and their cells."""


def is_labchart_text(content: bytes) -> bool:
    """Whether a file is LabChart's text export: its first line that is not blank starts with ``Interval=``."""
    return _decode(content[:4096]).lstrip().startswith("Interval=")


def read_labchart_text(path: str | Path) -> list[Block]:
    """Read all blocks of a LabChart text export.

    Values keep the unit of the header: ``UnitName=``, or where that is ``*`` (no conversion was set) the voltage of
    ``Range=``. Empty cells and NaN are gaps. The decimal mark may be a comma.

    Raises
    ------
    InputError
        Line of: a header without interval or titles, a row of another width, a cell that is no number, both decimal
        marks in one file, times that contradict the interval.
    """
    text = _decode(read_bytes(path))
    blocks: list[tuple[dict[str, list[str]], int, _Lines]] = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip():
            continue
        cells = line.split("\t")
        key = _KEY.match(line)
        if key is None and blocks:
            blocks[-1][2].append((number, cells))
        elif key is None:
            raise InputError(f"{path}, line {number}: a LabChart text export starts with 'Interval='; export it again")
        else:
            if key[1] == "Interval":
                blocks.append(({}, number, []))
            elif not blocks:
                raise InputError(f"{path}, line {number}: '{key[1]}=' before 'Interval='; export with its header")
            blocks[-1][0][key[1]] = [line[key.end() :].split("\t")[0], *cells[1:]]
    if not blocks:
        raise InputError(f"{path}: the file is empty")
    comma = _decimal_comma(path, blocks)
    return [
        _block(f"{path}, block {n}", header, line, rows, comma)
        for n, (header, line, rows) in enumerate(blocks, 1)
        if rows
    ]


def _decode(content: bytes) -> str:
    if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return content.decode("utf-16", errors="replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace")


def _decimal_comma(path: str | Path, blocks: list[tuple[dict[str, list[str]], int, _Lines]]) -> bool:
    """Return whether numbers are written with a comma; both marks in one file would make values a thousandfold."""
    first: dict[str, int] = {}
    for header, line, rows in blocks:
        sampled = [(line, header["Interval"]), *rows]
        for number, cells in sampled:
            joined = "\t".join(cell for cell in cells if not cell.lstrip().startswith("#"))
            for mark in ",.":
                if mark in joined:
                    first.setdefault(mark, number)
    if len(first) == 2:
        raise InputError(
            f"{path}, line {max(first.values())}: numbers with a decimal comma and with a decimal point in one file; "
            "export it again with one of them"
        )
    return "," in first


def _block(place: str, header: dict[str, list[str]], line: int, rows: _Lines, comma: bool) -> Block:
    interval = _interval(f"{place}, line {line}", header["Interval"], comma)
    titles = [title.strip().strip('"') for title in header.get("ChannelTitle", [""])[1:]]
    while titles and not titles[-1]:
        titles.pop()
    if not titles:
        raise InputError(f"{place}, line {line}: the header has no 'ChannelTitle='; tick channel titles in the export")
    comments = []
    for index, (_, cells) in enumerate(rows):
        remark = next((i for i, cell in enumerate(cells) if cell.lstrip().startswith("#")), None)
        if remark is not None:
            comments += _comments(cells[remark:], index * interval)
            del cells[remark:]
        while len(cells) > len(titles) and not cells[-1].strip():
            cells.pop()
    width = max(len(cells) for _, cells in rows)
    if width not in (len(titles), len(titles) + 1):
        raise InputError(f"{place}, line {rows[0][0]}: {width} columns under {len(titles)} channel titles")
    columns: list[tuple[str, ...]] = list(zip_longest(*(cells for _, cells in rows), fillvalue=""))
    if width > len(titles):
        _check_times(place, _column(place, rows, columns.pop(0), "time", comma, clock=True), interval, rows)
    channel_units = _units(header, len(titles))
    consecutive = rows[-1][0] - rows[0][0] == len(rows) - 1
    channels = []
    for title, unit, column in zip(titles, channel_units, columns, strict=True):
        values = _column(place, rows, column, title, comma)
        first_line = rows[0][0] if consecutive else 0
        channels.append(Channel(title, unit, values, 1.0 / interval, f"{place}, channel '{title}'", first_line))
    return Block(tuple(channels), tuple(comments))


def _interval(where: str, cells: list[str], comma: bool) -> float:
    written = " ".join(cells[1:]).strip()
    match = re.match(r"(\S+?)\s*([a-zµμ]+)\s*$", written.replace(",", ".") if comma else written)
    try:
        interval = float(match[1]) * units.factor(match[2], "time") if match else math.nan
    except ValueError:
        interval = math.nan
    if not (math.isfinite(interval) and interval > 0):
        raise InputError(f"{where}: 'Interval= {written}' is not a sampling interval such as 'Interval=\t0.001 s'")
    return interval


def _units(header: dict[str, list[str]], count: int) -> list[str]:
    """Return a unit per channel; ``*`` means unconverted, and then the range tells volts from millivolts."""
    named = [unit.strip() for unit in header.get("UnitName", [""])[1:]] + ["*"] * count
    ranges = [text.strip().split(" ")[-1] if " " in text.strip() else "" for text in header.get("Range", [""])[1:]]
    ranges += [""] * count
    return [ranges[i] if named[i] in ("*", "") else named[i] for i in range(count)]


def _comments(cells: list[str], time: float) -> list[Comment]:
    found = []
    for part in re.split(r"\t(?=\s*#(?:\*|\d+)\s)", "\t".join(cells)):
        match = _REMARK.match(part.strip())
        channel = int(match[1]) if match and match[1] != "*" else 0
        found.append(Comment(time, match[2].strip() if match else part.strip("# "), channel))
    return found


def _column(
    place: str, rows: _Lines, cells: tuple[str, ...], title: str, comma: bool, clock: bool = False
) -> np.ndarray:
    written = [cell.strip().replace(",", ".") if comma else cell.strip() for cell in cells]
    values = np.empty(len(written))
    for i, text in enumerate(written):
        try:
            values[i] = float(text) if text else math.nan
        except ValueError:
            if clock and ":" in text:
                return np.full(len(written), math.nan)  # time of day: the interval alone counts
            raise InputError(
                f"{place}, line {rows[i][0]}, column '{title}': '{cells[i].strip()}' is not a number"
            ) from None
    values[np.isinf(values)] = math.nan
    return values


def _check_times(place: str, time: np.ndarray, interval: float, rows: _Lines) -> None:
    """Refuse times that do not advance by the interval: samples are missing, or every tenth was exported."""
    steps = np.diff(time)
    # Times are written with few digits late in a long recording, hence the rounding allowed for.
    wrong = np.flatnonzero(np.abs(steps - interval) > 0.5 * interval + 2e-5)
    if len(wrong):
        row = int(wrong[0]) + 1
        raise InputError(
            f"{place}, line {rows[row][0]}: time advances by {steps[row - 1]:.6g} s, the header's interval is "
            f"{interval:.6g} s; export every sample, without gaps"
        )
    finite = np.flatnonzero(np.isfinite(time))
    if len(finite) > 1:
        lasts = time[finite[-1]] - time[finite[0]]
        expected = (finite[-1] - finite[0]) * interval
        if abs(lasts - expected) > 1e-3 * expected + interval:
            raise InputError(
                f"{place}: the times cover {lasts:.6g} s, the samples {expected:.6g} s; export at the full rate"
            )
