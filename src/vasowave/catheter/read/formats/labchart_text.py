"""The text export of ADInstruments LabChart: tab-separated, one header before every block."""

import math
import re
from functools import cached_property
from pathlib import Path

import numpy as np

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.io.clocks import is_date
from vasowave.base.io.remembered import remembered
from vasowave.base.io.textfile import Lines, Progress, read_lines
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat
from vasowave.catheter.signals.channels import CUT_OFF, Block, Channel, Comment
from vasowave.catheter.signals.gaps import leaps_closed, with_gaps
from vasowave.catheter.signals.number_rows import DecimalMark, NumberRows

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


def is_labchart_text(start: bytes) -> bool:
    """Whether a file is LabChart's text export: its first line that is not blank starts with ``Interval=``."""
    encoding = "utf-16" if start[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    return start[:4096].decode(encoding, errors="replace").lstrip().startswith("Interval=")


@remembered
def read_labchart_text(path: str | Path, progress: Progress | None = None) -> list[Block]:
    """Read all blocks of a LabChart text export, a megabyte at a time.

    Values keep the unit of the header: ``UnitName=``, or where that is ``*`` (no conversion was set) the voltage of
    ``Range=``. Empty cells and NaN are gaps. The decimal mark may be a comma.

    Raises
    ------
    InputError
        Line of: a header without interval or titles, a row of another width, a cell that is not a number, both decimal
        marks in one file, times that contradict the interval.
    """
    marks = DecimalMark(path)
    blocks: list[_TextBlock] = []
    for lines in read_lines(path, progress):
        if lines.cut and blocks and blocks[-1].rows is not None and not _KEY.match(lines.texts[0]):
            blocks[-1].cut = True  # nobody knows whether the row's last digit was written
            continue
        quick = not (lines.cut or lines.hold("=") or lines.hold("#") or (blocks and blocks[-1].has_clock))
        comma = marks.comma(lines) if quick else False
        if quick and blocks and blocks[-1].add_block(lines, comma):
            continue
        for number, text in enumerate(lines.texts, lines.first):
            if text.strip():
                _add_line(path, blocks, number, text, marks)
    if not blocks:
        raise InputError(f"{path}: the file is empty")
    return [block.finished() for block in blocks if block.rows is not None and block.rows.count]


def _add_line(path: str | Path, blocks: "list[_TextBlock]", number: int, text: str, marks: "DecimalMark") -> None:
    """Take one line: a key of a header, or a row of the last block."""
    key = _KEY.match(text)
    if key is None and not blocks:
        raise InputError(f"{path}, line {number}: a LabChart text export starts with 'Interval='; export it again")
    if key is None:
        cells = text.partition("#")[0].split("\t")
        numbers = "\t".join(cell for cell in cells if not is_date(cell.strip()))  # whose points are no decimal marks
        blocks[-1].add_row(number, text.split("\t"), marks.comma(Lines(number, [numbers])))
        return
    if key[1] == "Interval":
        blocks.append(_TextBlock(path, len(blocks) + 1, number))
        marks.comma(Lines(number, [text]))
    elif not blocks:
        raise InputError(f"{path}, line {number}: '{key[1]}=' before 'Interval='; export with its header")
    blocks[-1].header[key[1]] = [text[key.end() :].split("\t")[0], *text.split("\t")[1:]]


class _TextBlock:
    """One block while it is read."""

    def __init__(self, path: str | Path, number: int, line: int) -> None:
        self.place, self.line = f"{path}, block {number}", line
        self.header: dict[str, list[str]] = {}
        self.rows: NumberRows | None = None
        self._comments: list[tuple[int, list[str]]] = []
        self.has_clock = False  # the times are times of day: the interval alone counts
        self.cut = False

    def add_block(self, lines: Lines, comma: bool) -> bool:
        if self.rows is None or self.has_clock:
            return False
        return self.rows.add_block(lines.first, lines.texts, comma)

    def add_row(self, line: int, cells: list[str], comma: bool) -> None:
        titles = self.titles
        remark = next((i for i, cell in enumerate(cells) if cell.lstrip().startswith("#")), None)
        if remark is not None:
            self._comments.append((self.rows.count if self.rows else 0, cells[remark:]))
            del cells[remark:]
        while len(cells) > (len(self.rows.titles) if self.rows else len(titles)) and not cells[-1].strip():
            cells.pop()
        if not cells:
            return
        if len(cells) == len(titles) + 2 and any(map(is_date, cells[:2])):
            del cells[0 if is_date(cells[0]) else 1]
        if self.rows is None:
            if len(cells) not in (len(titles), len(titles) + 1):
                raise InputError(f"{self.place}, line {line}: {len(cells)} columns under {len(titles)} channel titles")
            times = ["time"] * (len(cells) > len(titles))
            self.rows = NumberRows(self.place, [*times, *titles], "\t")
            self.has_clock = bool(times) and ":" in cells[0]
        if self.has_clock and len(cells) == len(self.rows.titles):
            cells[0] = ""
        self.rows.add_row(line, cells, comma)

    def finished(self) -> Block:
        assert self.rows is not None
        titles, rows = self.titles, self.rows
        interval = _interval(f"{self.place}, line {self.line}", self.header["Interval"])
        timed = len(rows.titles) - len(titles)
        place = _places(self.place, rows.take(0), interval, rows) if timed else None
        channels = []
        for index, (title, unit) in enumerate(zip(titles, _units(self.header, len(titles)), strict=True)):
            values = rows.take(index + timed)
            values = values if place is None else with_gaps(values, place)
            channels.append(Channel(title, unit, values, 1.0 / interval, f"{self.place}, channel '{title}'"))
        comments = []
        for row, cells in self._comments:
            sample = row if place is None or not row else int(place[min(row, len(place) - 1)])
            comments += _comments(cells, sample * interval)
        notes = (CUT_OFF(what="its last row"),) if self.cut else ()
        return Block(tuple(channels), tuple(comments), notes)

    @cached_property
    def titles(self) -> list[str]:
        titles = [title.strip().strip('"') for title in self.header.get("ChannelTitle", [""])[1:]]
        while titles and not titles[-1]:
            titles.pop()
        if not titles:
            raise InputError(
                f"{self.place}, line {self.line}: the header has no 'ChannelTitle='; tick channel titles in the export"
            )
        return titles


def _interval(where: str, cells: list[str]) -> float:
    written = " ".join(cells[1:]).strip()
    match = re.match(r"(\S+?)\s*([a-zµμ]+)\s*$", written.replace(",", "."))
    try:
        interval = float(match[1]) * units.factor(match[2], "time") if match else math.nan
    except ValueError:
        interval = math.nan
    if not (math.isfinite(interval) and interval > 0 and math.isfinite(1.0 / interval)):
        raise InputError(f"{where}: 'Interval= {written}' is not a sampling interval such as 'Interval=\t0.001 s'")
    return interval


def _units(header: dict[str, list[str]], count: int) -> list[str]:
    """Return a unit per channel; ``*`` means unconverted, and then the range tells volts from millivolts."""
    named = [unit.strip() for unit in header.get("UnitName", [""])[1:]] + ["*"] * count
    ranges = [text.strip().split(" ")[-1] if " " in text.strip() else "" for text in header.get("Range", [""])[1:]]
    ranges += [""] * count
    return [ranges[i] if named[i] in ("*", "") else named[i] for i in range(count)]


def _comments(cells: list[str], time: float) -> list[Comment]:
    comments = []
    for entry in re.split(r"\t(?=\s*#(?:\*|\d+)\s)", "\t".join(cells)):
        match = _REMARK.match(entry.strip())
        channel = int(match[1][:6]) if match and match[1] != "*" else 0
        comments.append(Comment(time, match[2].strip() if match else entry.strip("# "), channel))
    return comments


def _places(place: str, time: np.ndarray, interval: float, rows: NumberRows) -> np.ndarray | None:
    """Return where samples stand on an even axis if the times leap over gaps, None if they do not.

    Refuses times that advance by another step than the interval: every tenth sample was exported, or rows are missing
    all over.
    """
    leaps = leaps_closed(time)
    if leaps is not None:
        time = leaps[0]
    steps = np.diff(time)
    # Times are written with few digits late in a long recording, hence the rounding allowed for.
    wrong = np.flatnonzero(np.abs(steps - interval) > 0.5 * interval + 2e-5)
    if len(wrong):
        row = int(wrong[0]) + 1
        raise InputError(
            f"{place}, line {rows.line(row)}: time advances by {steps[row - 1]:.6g} s, the header's interval is "
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
    return None if leaps is None else leaps[1]


RECORDINGS.register(
    RecordingFormat(
        "labchart text", "LabChart text export", (), lambda path, start: is_labchart_text(start),
        lambda path, rate, progress: read_labchart_text(path, progress=progress), continuous=True,
    )
)  # fmt: skip
