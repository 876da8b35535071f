"""A table of continuous signals: one titled column each, read block by block."""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, groupby, pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vasowave.base import units
from vasowave.base.cures import SetCells
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.base.io.cells import is_numeric, is_row, is_value, split_cells, without_thousands
from vasowave.base.io.columns import Columns, plain_title, read_columns, read_headings
from vasowave.base.io.layout import HEAD, Head, head_of, is_long, remarks_above, spread, turned
from vasowave.base.io.remembered import remembered
from vasowave.base.io.textfile import Lines, Progress, read_lines
from vasowave.base.sites import PULMONARY
from vasowave.catheter.read.choosing import TAKEN, choose, column_of, with_time
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat, Wanted
from vasowave.catheter.read.subject_rows import subject_asked_for, subject_columns
from vasowave.catheter.signals.channels import CUT_OFF, Block, Channel, Comment, rates_differ
from vasowave.catheter.signals.gaps import with_gaps
from vasowave.catheter.signals.number_rows import DecimalMark, NumberRows
from vasowave.catheter.signals.signal import (
    ALIASES,
    NAME_THE_RATE,
    RATE,
    UNIT_REPLACED,
    Signal,
    sampling,
    unit_cures,
    written_to,
)

PHASE_REPEATED = look_kind(
    "recording.phase-repeated",
    "the last row, at phase {phase:g}, is the first of the next cycle and was left out. {remedy}",
    "If phases are counted otherwise, take their column out.",
)
SECONDS = note_kind("recording.times-in-seconds", "the column 'X' was taken for times in s")
COUNT_DIFFERS = look_kind(
    "recording.count-differs",
    "the header says {stated} samples, {count} are there. {remedy}",
    "Export the file again, whole and in one segment.",
)
BELOW = note_kind("recording.below", "rows below the numbers were left out: {rows}")
_MAX_BELOW = 12  # rows below a table that are no numbers: means, remarks, an end
_PER_BEAT = re.compile(r"\b(?:mean|average|max\w*|min\w*|cyclic|start|end|duration|heart rate|hr|sd)\b", re.IGNORECASE)
"""Words of titles of numbers by beat or selection."""
_HEADER = "the first line must read: time [s],pressure [mmHg],flow [ml/s],ecg [mV]"


class NumberTable(NamedTuple):
    """A table as it stands in a file, before anyone says how many samples a second has."""

    path: Path
    titles: tuple[str, ...]
    names: tuple[str, ...]
    """Titles in lower case, other words for what is known by that."""
    units: tuple[str, ...]
    columns: tuple[np.ndarray, ...]
    quantum: float
    """Rounding of the times, in their unit."""
    line: Callable[[int], int]
    """Returns the line of the file on which a row stands."""
    suspicions: tuple[Finding, ...]
    remarks: tuple[tuple[int, str], ...] = ()
    """What rows remark, by their number."""
    head: Head = Head((), None, 0)

    def _of_each_clock(self) -> list["NumberTable"]:
        """Return the columns behind each of several columns of times, up to the last time, as tables."""
        clocks = [i for i, name in enumerate(self.names) if name == "time"]
        edges = [0, *clocks[1:], len(self.names)]
        tables: list[NumberTable] = []
        for clock, first, last in zip(clocks, edges, edges[1:], strict=False):
            if last - first < 2:
                raise InputError(f"{self.path}: two columns are called 'time'; keep one of them")
            count = int(np.flatnonzero(np.isfinite(self.columns[clock]))[-1:].sum()) + 1
            units_of = list(self.units)
            if self.head.program == "LabVIEW" and self.titles[clock].casefold() == "x_value":
                units_of[clock] = "s"
            tables.append(self._replace(
                titles=self.titles[first:last], names=self.names[first:last], units=tuple(units_of[first:last]),
                columns=tuple(values[:count] for values in self.columns[first:last]),
                remarks=() if tables else self.remarks,
                head=self.head._replace(rate=None) if tables else self.head,  # LabVIEW says that of the first
            ))  # fmt: skip
        return tables

    def block(self, sampling_rate: float | None) -> Block:
        """Return the columns as channels; each has the times of the column of times before it."""
        if self.names.count("time") > 1:
            return _together(self.path, [table.block(sampling_rate) for table in self._of_each_clock()])
        rate, place = self._rate(sampling_rate)
        channels = tuple(
            Channel(title, unit, values if place is None else with_gaps(values, place), rate,
                    f"{self.path}, channel '{title}'")
            for title, name, unit, values in zip(self.titles, self.names, self.units, self.columns, strict=True)
            if name != "time"
        )  # fmt: skip
        comments = (Comment(float(row if place is None else place[row]) / rate, text) for row, text in self.remarks)
        suspicions = self.suspicions + rates_differ(self.head.rate, rate)
        return Block(channels, tuple(comments), suspicions, self.head.program, self._start())

    def _start(self) -> float | None:
        """Return what the clock shows at the first row, s."""
        clock = self.head.plan.clock if self.head.plan else None
        if clock is not None or "time" not in self.names:
            return clock.start if clock else None
        column = self.names.index("time")
        return float(self.columns[column][0] * units.factor(self.units[column] or "s", "time"))

    def _timed(self) -> bool:
        """Whether a column of times says its unit."""
        return any(name == "time" and unit for name, unit in zip(self.names, self.units, strict=True))

    def _rate(self, stated_rate: float | None) -> tuple[float, np.ndarray | None]:
        """Return the samples per second by the times, checked against what was given, and places if times leap."""
        if self.head.rate and (stated_rate is None or np.isnan(stated_rate)) and not self._timed():
            stated_rate = self.head.rate
        if "time" not in self.names:
            even = next((pair for pair in zip(self.titles, self.columns, strict=True) if _rises_evenly(pair[1])), None)
            if stated_rate is None:
                hint = f" ('{even[0]}' rises evenly: title it 'time [s]' if it is that)" if even else ""
                raise InputError(f"{self.path}: no time column{hint}; {NAME_THE_RATE}", [RATE])
            if even and not np.isnan(stated_rate) and not _is_clock(even[1], stated_rate):
                step = float(np.median(np.diff(even[1])))
                raise InputError(
                    f"{self.path}: column '{even[0]}' rises evenly by {step:.6g}, as a time does; title it "
                    "'time [s]', or with its unit, so that it is compared with the rate that is given, or take it out"
                )
            return stated_rate, None
        column = self.names.index("time")
        time, unit = self.columns[column], self.units[column]
        if unit or (unit := _unit_of_epoch(time)):
            scale = units.factor(unit, "time")
        elif stated_rate is None:
            raise InputError(
                f"{self.path}: column 'time' has no unit; write it in the header ('time [s]'), or {NAME_THE_RATE}"
                f"{_offered(time)}",
                _rates(time) or [RATE],
            )
        elif np.isnan(stated_rate):  # nobody said yet: what the times are is not known
            return stated_rate, None
        else:
            steps = np.diff(time)
            rising = steps[steps > 0]
            scale = 1.0 / (stated_rate * float(np.median(rising))) if len(rising) else 1.0
        if len(time) < 2:
            raise InputError(f"{self.path}: one sample only; a continuous recording is needed")
        time = time * scale
        measured, place = sampling(
            time, self.quantum * scale, str(self.path), lambda row: f"{self.path}, line {self.line(row)}"
        )
        if stated_rate is not None and abs(stated_rate - measured) > 1e-3 * measured:
            raise InputError(f"{self.path}: the time column has {measured:.6g} samples/s, given are {stated_rate:.6g}")
        return measured, place


def _together(path: Path, blocks: Sequence[Block]) -> Block:
    """Return the channels of blocks as those of one; `InputError` where they do not begin together."""
    starts = [block.start or 0.0 for block in blocks]
    if np.ptp(starts) * max(channel.sampling_rate for block in blocks for channel in block.channels) > 1:
        texts = ", ".join(
            f"'{block.channels[0].title}' at {start:g} s" for block, start in zip(blocks, starts, strict=True)
        )
        raise InputError(f"{path}: its columns of times begin apart ({texts}); cut them to one time, or give two files")
    channels = tuple(channel for block in blocks for channel in block.channels)
    suspicions = tuple(dict.fromkeys(finding for block in blocks for finding in block.suspicions))
    return replace(blocks[0], channels=channels, suspicions=suspicions)


def _is_clock(values: np.ndarray, rate: float) -> bool:
    """Whether a column that rises evenly holds the times at a rate, s, ms or µs."""
    step = float(np.median(np.diff(values)))
    return any(abs(step / expected - 1) < 1e-3 for expected in (1 / rate, 1e3 / rate, 1e6 / rate))


_RATES = (20.0, 200_000.0)  # samples a second that recorders have


def _rates(time: np.ndarray) -> list[SetCells]:
    """Return the sampling rates that times without a unit have if they are seconds, or ms: those of recorders."""
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    rates = {"seconds": 1.0 / step, "ms": 1e3 / step} if step > 0 else {}
    return [
        SetCells(f"Times are in {unit}", (("sampling rate [1/s]", f"{rate:.6g}"),))
        for unit, rate in rates.items()
        if _RATES[0] < rate < _RATES[1]
    ]


def _offered(time: np.ndarray) -> str:
    """Return what the sampling rate is if times without a unit are seconds, or milliseconds."""
    offers = [f"{cure.label.lower()}, these are {rate}" for cure in _rates(time) for _, rate in cure.cells]
    return f". If its {', if its '.join(offers)}" if offers else ""


def _unit_of_epoch(time: np.ndarray) -> str:
    """Return the unit of times without one that are counted since 1970, in the years 2001 to 2100; empty for others."""
    scales = {"s": 1.0, "ms": 1e3} if len(time) else {}
    return next((unit for unit, n in scales.items() if 1e9 < time[0] / n < 4.1e9 and np.ptp(time) < 1e6 * n), "")


def _rises_evenly(values: np.ndarray) -> bool:
    """Whether a column is one of times: it rises by the same step all along, which is not a count of samples."""
    steps = np.diff(values)
    even = len(steps) > 1 and steps[0] > 0 and np.allclose(steps, np.median(steps), rtol=0.1, atol=0)
    return bool(even and not np.isclose(np.median(steps), 1.0, rtol=1e-6))


def read_number_table(
    path: Path, sampling_rate: float | None = None, progress: Progress | None = None, sheet: str = ""
) -> Block:
    """Read all columns of a table; a cell without a number is a gap.

    Parameters
    ----------
    path : Path
    sampling_rate : float, optional
        Samples per second; needed where there is no time column. With nan neither times nor titles are needed.
    progress : callable, optional
        Is called with the fraction that was read.
    sheet : str, optional
        Of a workbook.

    Raises
    ------
    InputError
        No header, no times and no rate, or line and column of: surplus or missing values, a cell that is not a number,
        both decimal marks, uneven times.
    """
    with subject_asked_for(path, sheet=sheet):
        table = _parsed(path, sheet, progress=progress)
    if not any(table.names) and (sampling_rate is None or not np.isnan(sampling_rate)):
        raise InputError(f"{path}: no header; {_HEADER}")
    return table.block(sampling_rate)


@remembered
def _parsed(path: Path, sheet: str = "", progress: Progress | None = None) -> NumberTable:
    table: _Table | None = None
    for lines in _below_each_other(path, read_lines(path, progress, sheet)):
        lines = lines._replace(texts=without_thousands(lines.texts))
        if table is None and (over := turned(lines.texts[: 2 * HEAD])):
            lines = Lines(1, over, lines.cut)
        table = table or _begin(path, lines)
        if table is not None:
            table.add(lines)
    if table is None:
        raise InputError(f"{path}: the file is empty")
    return table.finished()


def _below_each_other(path: Path, blocks: Iterator[Lines]) -> Iterable[Lines]:
    """Return blocks of lines; those of a table with a row a sample of one signal as one with a column a signal."""
    first = next(blocks, Lines(1, []))
    if not is_long(first.texts):
        return chain([first], blocks)
    written = [first, *blocks]
    unfinished = [written.pop()] if written[-1].cut else []  # a row that may lack digits
    rows = [row for block in written for row in enumerate(block.texts, block.first)]
    return [Lines(1, spread(path, rows)), *unfinished]


def _begin(path: Path, lines: Lines) -> "_Table | None":
    """Start a table at its titles, or at its first line where it has none; what stands above is left out."""
    rows = [(line, text) for line, text in enumerate(lines.texts, lines.first) if is_row(text)][: 2 * HEAD]
    if not rows:
        return None
    head = head_of(path, rows, remarks_above(lines.texts))
    line, text = rows[min(head.first, len(rows) - 1)]
    titles = head.titles or [""] * len(
        head.plan.numeric if head.plan else split_cells(path, line, text, head.separator)
    )
    return _Table(path, line - (head.first < len(rows)), titles, head)


class _Table:
    """A table while it is read."""

    def __init__(self, path: Path, line: int, header: Sequence[str], head: Head) -> None:
        self.names, self.units = read_headings(path, header, ALIASES | {"ekg": "ecg"})
        self.names = with_time(self.names, self.units)
        self.titles = tuple(map(plain_title, header))
        self.path, self.header_line, self.separator, self.head = path, line, head.separator, head
        self.rows = NumberRows(str(path), self.names, "\t" if head.plan else head.separator)
        self.remarks: list[tuple[int, str]] = []
        self.quantum = 0.0
        self.suspicions: tuple[Finding, ...] = ()
        self._marks = DecimalMark(path)
        self._below: list[tuple[str, InputError]] = []  # rows that are no numbers, and what is wrong with them

    def add(self, lines: Lines) -> None:
        """Take a block of lines, the header and what precedes it left out."""
        skipped = max(self.header_line + 1 - lines.first, 0)
        lines = Lines(lines.first + skipped, lines.texts[skipped:], lines.cut)
        if not lines.texts:
            return
        if lines.cut and self.rows.count:
            self.suspicions = (CUT_OFF(what="it"),)  # nobody knows whether its last digit was written
            return
        if self.head.plan is not None:
            self._add_planned(lines)
            return
        quick = not lines.hold("#") and not self._below
        comma = self._comma(lines) if quick else False
        if not (quick and self.rows.add_block(lines.first, lines.texts, comma)):
            self._add_slowly(lines)
        if not self.quantum and "time" in self.names and self.rows.count:
            self.quantum = self._rounding(lines.texts[:2000])

    def _add_planned(self, lines: Lines) -> None:
        """Take lines of which the plan of the head makes numbers: all that follow each other at once."""
        plan = self.head.plan
        assert plan is not None
        written = list(enumerate(lines.texts, lines.first))
        for row, run in groupby(written, lambda line: is_row(line[1])):
            if not row:
                continue
            first, texts = (block := list(run))[0][0], [text for _, text in block]
            cells = [split_cells(self.path, line, text, self.separator) for line, text in block]
            events = [(self.rows.count + i, plan.event(row_cells)) for i, row_cells in enumerate(cells)]
            self.remarks += [(i, text) for i, text in events if text]
            rows = [plan.numbers(row_cells) for row_cells in cells]
            if self._comma(Lines(first, ["\t".join(row_cells) for row_cells in rows])):
                rows = [[cell.replace(",", ".") for cell in row_cells] for row_cells in rows]
            rows = [
                [*plan.time(written_cells), *row_cells] for written_cells, row_cells in zip(cells, rows, strict=True)
            ]
            texts = ["\t".join(cell or "nan" for cell in row_cells) for row_cells in rows]
            if self._below or not self.rows.add_block(first, texts, False):
                for line, row_cells in enumerate(rows, first):
                    self._add_row(line, row_cells, False)
            if not self.quantum and "time" in self.names:
                column = self.names.index("time")
                self.quantum = written_to([row_cells[column] for row_cells in rows[:2000]])

    def _add_slowly(self, lines: Lines) -> None:
        for number, text in enumerate(lines.texts, lines.first):
            if is_row(text):
                comma = self._comma(Lines(number, [text]))
                cells = text.split() if self.separator is None else split_cells(self.path, number, text, self.separator)
                self._add_row(number, cells, comma)

    def _add_row(self, line: int, cells: list[str], comma: bool) -> None:
        """Take a row; where a word begins it, as below a table, wait whether numbers follow."""
        try:
            self.rows.add_row(line, cells, comma)
        except InputError as error:
            if not self.rows.count or not cells or is_value(cells[0]) or len(self._below) == _MAX_BELOW:
                raise
            self._below.append((cells[0], error))
        else:
            if self._below:
                raise self._below[0][1]

    def _comma(self, lines: Lines) -> bool:
        return self.separator != "," and self._marks.comma(lines)

    def _rounding(self, texts: list[str]) -> float:
        """Return the rounding of the times, in their unit."""
        column = self.names.index("time")
        cells = [text.split(self.separator) for text in texts if is_row(text)]
        return written_to([row[column].replace(",", ".") for row in cells if len(row) > column])

    def finished(self) -> NumberTable:
        if not self.rows.count:
            raise InputError(f"{self.path}: a header and no data")
        if self.head.samples not in (None, self.rows.count) and CUT_OFF(what="it") not in self.suspicions:
            self.suspicions += (COUNT_DIFFERS(stated=self.head.samples, count=self.rows.count),)
        if self._below:
            self.suspicions += (BELOW(rows=", ".join(f"'{word}'" for word, _ in self._below)),)
        columns = tuple(map(self.rows.take, range(len(self.names))))
        for values in columns:
            values.setflags(write=False)
        return NumberTable(
            self.path, self.titles, self.names, self.units, columns, self.quantum, self.rows.line, self.suspicions,
            tuple(self.remarks), self.head,
        )  # fmt: skip


class ColumnTitle(NamedTuple):
    """A column of a table, its title and its unit."""

    place: int
    title: str
    unit: str


def read_cycle(
    path: Path, quantities: Wanted, site: str = PULMONARY, sheet: str = "", subject_row: str = ""
) -> list[Signal]:
    """Return the columns that hold the quantities wanted of one cycle; other columns may hold anything."""
    table = subject_columns(path, subject_row, sheet) if subject_row else read_columns(path, ALIASES, sheet)
    table.warn()
    alone = len(quantities) == 1
    with subject_asked_for(path, subject_row, sheet):
        return [_from_table(table, quantity, unit, alone, site) for quantity, unit in quantities.items()]


def _from_table(table: Columns, quantity: str, unit: str | None, alone: bool, site: str) -> Signal:
    width = len(table.cells[0])
    if not table.names and not (alone and (width == 1 or (width == 2 and _times_first(table)))):
        raise InputError(f"{table.source}: {_headerless(table)}")
    if not table.names and width == 2:
        table = replace(table, names=("time", quantity), units=("s", ""), titles=("time", quantity))
        timed = _from_table(table, quantity, unit or units.CANONICAL[quantity], alone, site)
        assumed = "s" if unit else f"{units.CANONICAL[quantity]}, its times in s"
        return replace(timed, assumed_unit=assumed)
    column, notes = _column(table, quantity, site) if table.names else (0, ())
    clock, table = _timed(table, column)
    stated = table.units[column] if table.units else ""
    assumed = "" if table.names or unit else units.CANONICAL[quantity]
    if not (stated or unit or assumed):
        title = table.titles[column].strip()
        example = f"{title.split(' to ')[0]} [{units.CANONICAL[quantity]}]"
        raise InputError(f"{table.source}: '{title}' has no unit; write it in the header, '{example}', or name it",
                         unit_cures(column_of(quantity), quantity))  # fmt: skip
    places = tuple(f"{table.source}, line {line}" for line in table.lines)
    values = table.numbers(column, quantity, unit or assumed)
    if stated and unit and (ratio := units.factor(unit, quantity) / units.factor(stated, quantity)) != 1.0:
        values, notes = values * ratio, (*notes, UNIT_REPLACED(name=quantity, unit=unit, stated=stated))
    if clock is None:
        count, repeated = _phases(table)
        return Signal(quantity, values[:count], None, 0.0, table.source, places[:count], assumed, (*notes, *repeated))
    if table.titles[clock].strip().casefold() == "x_value" and not table.units[clock]:  # of a plot, or LabVIEW's
        table, notes = replace(table, units=("s",) * len(table.units)), (*notes, SECONDS())
    time = table.numbers(clock, "time")
    quantum = written_to([row[clock] for row in table.cells]) * units.factor(table.units[clock], "time")
    return Signal(quantity, values, time, quantum, table.source, places, assumed, notes)


def _timed(table: Columns, column: int) -> tuple[int | None, Columns]:
    """Return the column of the times of another, and the table, of several such columns the rows that have both."""
    clocks = [i for i, name in enumerate(with_time(table.names, table.units)) if name == "time"]
    clock = max((i for i in clocks if i < column), default=clocks[0] if clocks else None)
    if clock is None or len(clocks) < 2:
        return clock, table
    if any(later - earlier < 2 for earlier, later in pairwise([*clocks, len(table.names)])):
        raise InputError(f"{table.source}: a column of times has no signal behind it; put times before their signals")
    count = max((i + 1 for i, row in enumerate(table.cells) if row[clock].strip() or row[column].strip()), default=0)
    return clock, replace(table, cells=table.cells[:count], lines=table.lines[:count])


def _phases(table: Columns) -> tuple[int, tuple[Finding, ...]]:
    """Return how many rows are of one cycle by a column that counts its phases, all without one, and a finding.

    Raises
    ------
    InputError
        Line of a phase that does not follow the one before by the step of the others.
    """
    column = next((i for i, name in enumerate(table.names) if re.match(r"phase|frame", name, re.IGNORECASE)), None)
    if column is None or not all(is_numeric(row[column]) for row in table.cells):
        return len(table.cells), ()
    phase = np.array([float(row[column].replace(",", ".")) for row in table.cells])
    steps = np.diff(phase)
    step = float(np.median(steps)) if len(steps) else 0.0
    rounding = min(written_to([row[column] for row in table.cells]), 0.5 * abs(step))
    uneven = np.flatnonzero(np.abs(steps - step) > rounding * (1.0 + 1e-6))
    if step and len(uneven):
        row = int(uneven[0]) + 1
        raise InputError(
            f"{table.source}, line {table.lines[row]}, column '{table.names[column]}': {phase[row]:g} follows "
            f"{phase[row - 1]:g}, where the others follow by {step:g}; fill in what is missing, or take the column out "
            "if it does not count the phases of the cycle"
        )
    if phase[0] == 0 and any(np.isclose(phase[-1], cycle) for cycle in (1.0, 100.0, 360.0)):
        return len(phase) - 1, (PHASE_REPEATED(phase=float(phase[-1])),)
    return len(phase), ()


def _times_first(table: Columns) -> bool:
    """Whether the first of the columns rises from row to row by one step, as times do."""
    cells = [row[0] for row in table.cells]
    if len(cells) < 3 or not all(map(is_numeric, cells)):
        return False
    steps = np.diff([float(cell.replace(",", ".")) for cell in cells])
    return bool(steps.min() > 0 and np.ptp(steps) <= 0.1 * np.median(steps) + written_to(cells))


def _column(table: Columns, quantity: str, site: str) -> tuple[int, tuple[Finding, ...]]:
    """Return the column of a quantity: the one called so, else the one that its title or unit leaves alone, noted."""
    if table.find(quantity) is None:
        columns = [ColumnTitle(i, *pair) for i, pair in enumerate(zip(table.names, table.units, strict=True))]
        choice = choose(columns, {"pressure": None, quantity: None}, site)
        if quantity in choice.picked:
            column, reason = choice.picked[quantity], choice.guessed.get(quantity, "")
            return column.place, (TAKEN(title=column.title, name=quantity, why=reason),) if reason else ()
    if 2 * sum(map(bool, map(_PER_BEAT.search, table.names))) > len(table.names):
        raise InputError(
            f"{table.source}: numbers by beat or selection ({', '.join(table.names[:4])} …), as LabChart's Data Pad "
            "holds them, and no signals; export the signals of pressure and flow themselves, with their times"
        )
    return table.require(quantity, titles="time [s], pressure [mmHg] and flow [ml/s]"), ()


def _headerless(table: Columns) -> str:
    """Say what a table without a header lacks, by what stands in it."""
    width = len(table.cells[0])
    if width == 1:
        return "one column without a header; give the file of the flow too, after that of the pressure"
    comma = "; if the comma is a decimal one, write a point" if width == 2 else ""
    return f"{width} columns without a header{comma}; the first line must read: time [s],pressure [mmHg],flow [ml/s]"


RECORDINGS.register(
    RecordingFormat(
        "table", "table", (".csv", ".tsv", ".txt", ".dat", ".asc", ".prn", ".tab", ".lvm"), None,
        lambda path, rate, progress: [read_number_table(path, rate, progress)], cycle=read_cycle,
        subjects=True,
    )
)  # fmt: skip
