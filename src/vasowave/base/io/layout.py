"""The grammar of tables: what the first rows say of titles, clocks and marks before the numbers begin."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, zip_longest
from pathlib import Path
from typing import NamedTuple

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.io.cells import is_numeric, is_row, is_value, separator_of, split_cells
from vasowave.base.io.clocks import Clock, bare, decimals, is_clock, is_date
from vasowave.base.io.headings import (
    csv_cells,
    has_unit,
    is_titled_in,
    keyed_titles,
    listed_titles,
    remarked_titles,
    split_title,
    split_titles,
    with_unit_labels,
    with_unit_row,
)

HEAD = 100
"""Rows among which the titles of a table are looked for."""
_MAX_TURNED, _MIN_TURNED = 64, 50  # rows, and cells in each, of a table with a row a signal
_ROW_NAMES = "row_names"
_EVENT = re.compile(
    r"[eé]v[eéè]n[et]|comment|marks?$|marker|marca|remar[kq]|note|ann?ot|kommentar|bemerk|opmerk|observ|ereign",
    re.IGNORECASE,
)
_RATE = re.compile(
    r"(?:sampl\w*|abtast\w*|mess(?=rate|freq)|acquisition|[eé]chantillon\w*)[ _-]*(?:rate|freq\w*)?(?: per channel)?"
    r"\W*?(?P<rate>\d+(?:[.,]\d+)?)\s*(?P<k>k?)hz"
    r"|\bfs\s*[=:]?\s*(?P<fs>\d+(?:[.,]\d+)?)\s*(?P<kilo>k?)hz"
    r"|\"sampling rate\": ?(?P<json>\d+(?:\.\d+)?)"
    r"|(?:sampl\w*|acquisition)[ _-]*(?:rate|freq\w*)\W*(?P<same>\d+(?:\.\d+)?)(?:,(?P=same))+$"  # of every trace
    r"|(?:sampl\w*|acquisition)[ _-]*(?:rate|freq\w*)\W*(?P<plain>\d+(?:\.\d+|,\d+(?!\.))?)"
    r"\s*(?:/ ?s\w*|samples.*)?$",
    re.IGNORECASE,
)
_DELTA_X = re.compile(r"delta_x\s+([\d.,eE+-]+)(?:\s|$)", re.IGNORECASE)  # LabVIEW, s
_TIMELESS = re.compile(r"x_columns\s+no\b|\"tracename", re.I)  # LabVIEW, Yokogawa: the first cell of rows is empty
_MAX_CAPTIONS = 4  # rows above the titles of a table without clocks and units
_TIMES = ("time", "t", "zeit", "temps", "tiempo", "elapsed time")
_NOTES = ("comment", "comments")
"""Titles of a last column that rows without a remark lack, as LabVIEW writes it."""
_KEYS = ("signal", "variable", "channel", "parameter", "quantity", "measurement", "measure", "name", "key", "trace")
_VALUES = ("value", "values", "val", "amplitude", "reading", "wert", "messwert", "valeur", "valor")
_UNITS = ("unit", "units", "einheit", "unité", "unidad")
_SUBJECTS = ("animal", "subject", "id", "animal_id", "subject_id", "mouse", "rat", "pig", "patient", "tier")
"""Titles of a table with a row a sample of one signal, as R and pandas write it: its signal, value, unit, and whose."""
_FEWEST_SAMPLES = 8  # of a signal; a table of numbers has one of each
_SAMPLES = re.compile(r"(?:Samples\t|\"BlockSize\",)(\d{1,9})\b")  # LabVIEW, Yokogawa
_PER_SAMPLE = re.compile(r"(\d+(?:[.,]\d+)?)\s*(usec|msec|sec|min)/sample", re.IGNORECASE)
_PROGRAMS = {
    "emka technologies": "emka IOX", "iox version": "emka IOX", "notocord": "Notocord-hem", "ponemah": "Ponemah",
    "/sample": "AcqKnowledge", "labview measurement": "LabVIEW", "labchart": "LabChart",
}  # fmt: skip
"""What recorders write above their tables, lower case, and their names."""


class Head(NamedTuple):
    """What the first rows of a table say.

    Attributes
    ----------
    titles : tuple of str
        None where it has none.
    separator : str, optional
        Of its cells; None for blanks.
    first : int
        Which of the rows holds the first data.
    plan : RowLayout, optional
        How rows become numbers, where clocks, remarks or blanks stand among them.
    rate : float, optional
        Samples per second, if a line above the titles says them.
    samples : int, optional
        How many rows LabVIEW says that there are.
    program : str
        Whose table it is, empty if nothing tells.
    """

    titles: tuple[str, ...]
    separator: str | None
    first: int
    plan: "RowLayout | None" = None
    rate: float | None = None
    program: str = ""
    samples: int | None = None


@dataclass(frozen=True)
class RowLayout:
    """How the rows of a table become rows of numbers: seconds of its clock first, then the columns of numbers."""

    width: int
    numeric: tuple[int, ...]
    events: tuple[int, ...] = ()
    clock: Clock | None = None

    def numbers(self, cells: Sequence[str]) -> list[str]:
        """Return the cells of a row that are numbers, as written; what is missing at its end is empty."""
        padded = [*cells, *[""] * (self.width - len(cells))]
        surplus = [cell for cell in padded[self.width :] if cell.strip()]
        return [*(bare(padded[i]) for i in self.numeric), *surplus]

    def event(self, cells: Sequence[str]) -> str:
        """Return what a row remarks."""
        return "; ".join(bare(cells[i]) for i in self.events if i < len(cells) and bare(cells[i]))

    def time(self, cells: Sequence[str]) -> list[str]:
        """Return the seconds of a row, nothing where there is no clock."""
        return [] if self.clock is None else [self.clock.seconds(cells)]


def head_of(path: Path, rows: Sequence[tuple[int, str]], remarks: Sequence[str] = ()) -> Head:
    """Return the head of a table by its first rows, one at least, each with the number of its line.

    `remarks` are the lines above that begin with ``#``.
    """
    texts = [text for _, text in rows]
    above = " ".join([*remarks, *texts[:HEAD]][:40]).lower()
    program = next((name for words, name in _PROGRAMS.items() if words in above), "")
    data = _data_among(texts[: HEAD + 1], any(map(_TIMELESS.match, texts[:HEAD])))
    if data is not None:
        texts = _with_rows_named(_with_index_named(texts, data), data)
    if data is None:
        return _plain_head(path, rows, _below_caption(texts))._replace(program=program)
    titles, named = _titles_above(texts, data, remarks)
    if not named and data:
        return _plain_head(path, rows, _below_caption(texts))._replace(program=program)
    separator = separator_of(texts[data])
    body = [split_cells(path, *row, separator) for row in rows[data : data + HEAD]]
    titles = _timed_by_clock(titles, body)
    plan = _plan(titles, body)
    if plan is not None:
        titles = ["time [s]"] * (plan.clock is not None) + [titles[i] if titles else "" for i in plan.numeric]
        titles = titles if any(titles) else []
    counts = [int(match[1]) for text in texts[:data] if (match := _SAMPLES.match(text))]
    return Head(tuple(titles), separator, data, plan, _rate(remarks, texts[:data]), program, *counts[:1])


def _plain_head(path: Path, rows: Sequence[tuple[int, str]], index: int) -> Head:
    """Return the head of a table of which one row holds the titles, or already data, whatever its cells are."""
    texts = [text for _, text in rows]
    separator = separator_of(texts[index])
    cells = split_cells(path, *rows[index], separator)
    if all(map(is_numeric, cells)):
        return Head((), separator, index)
    titles, first = split_titles(texts[index]) if separator is None else cells, index + 1
    if texts[first:] and (merged := with_unit_row(titles, texts[first], separator)):
        titles, first = merged, first + 1
    if separator is None and texts[first:] and len(texts[first].split()) == 1:
        titles = cells  # the one title has blanks in it
    return Head(tuple(titles), separator, first)


def _below_caption(texts: Sequence[str]) -> int:
    """Return the row of the titles: the first, or below captions, which have one cell, the first of three titles."""
    for index, text in enumerate(texts[: _MAX_CAPTIONS + 1]):
        separator = separator_of(text)
        cells = [cell for cell in map(bare, text.split(separator)) if cell]
        below = texts[index + 1].split(separator) if index + 1 < len(texts) else []
        if separator and len(cells) > 2 and len(below) == len(text.split(separator)):
            widths = [sum(bool(bare(cell)) for cell in above.split(separator)) for above in texts[:index]]
            is_caption = all(width <= 1 for width in widths) and not any(map(is_numeric, cells))
            return index if is_caption else 0
    return 0


def _data_among(rows: Sequence[str], timeless: bool = False) -> int | None:
    """Return the first row of numbers, clocks and blanks, at least one number and two cells, and none without its
    first cell, unless they are `timeless`, the last one perhaps a remark; None if there is none.
    """
    for index, row in enumerate(rows):
        cells = list(map(bare, row.split(separator_of(row))))
        count = sum(map(is_numeric, cells)) + is_clock(cells[0])
        sound = all(map(is_value, cells)) or (count > 2 and all(map(is_value, cells[:-1])))
        if len(cells) > 1 and (cells[0] or timeless) and any(map(is_numeric, cells)) and sound:
            following = rows[index + 1].split(separator_of(row)) if index + 1 < len(rows) else cells
            if len(following) == len(cells) or index + 2 >= len(rows):
                return index
    return None


def _titles_above(texts: Sequence[str], data: int, remarks: Sequence[str]) -> tuple[list[str], bool]:
    """Return the titles of the numbers that begin at a row, none if there are none, and whether that is certain."""
    separator = separator_of(texts[data])
    cells = texts[data].split(separator)
    widths = {len(cells), len(list(_stripped(cells)))}

    def fitting(index: int) -> list[str]:
        if index < 0:
            return []
        row = split_titles(texts[index]) if separator is None else csv_cells(texts[index], separator)
        row = [title.strip().strip("'\"").strip() for title in row]
        if separator is None and len(row) + 1 in widths and units.is_of(texts[index + 1].split()[0], "time"):
            row = ["time", *row]  # nothing stands above the unit of the times
        is_wide = bool(row) and row[-1].casefold() in _NOTES and len(row) - 1 in widths
        return row if (is_wide or len(row) in widths) and not all(map(is_value, row)) else []

    nearest = next((i for i in range(data - 1, -1, -1) if not _is_count(texts[i], separator)), -1)
    titles, upper = fitting(nearest), fitting(nearest - 1)
    if listed := listed_titles(texts[:data], titles, len(list(_stripped(cells)))):
        return listed, True
    lowest = nearest - 1 if any(map(has_unit, titles)) else nearest - 3  # remarks may follow units
    below = (i for i in range(nearest, max(lowest, 0), -1) if fitting(i - 1))
    merged = next(filter(None, (with_unit_row(fitting(i - 1), texts[i], separator) for i in below)), None)
    if upper and [title.casefold() for title in titles] == ["x", "y"] * (len(titles) // 2):  # of digitizers
        titles = [upper[i - 1] or upper[i] if i % 2 else "X_Value" for i in range(len(titles))]
    elif titles and merged:
        titles = merged
    elif any(is_numeric(title) or is_clock(title) or is_date(title) for title in titles):
        titles = []
    titles = with_unit_labels(titles, texts[:data], separator)
    titles = _under_groups(titles, fitting(nearest - 1 - bool(merged)))
    titles = titles or keyed_titles(texts[:data], separator, len(cells))
    titles = titles or remarked_titles(remarks, separator, len(cells))
    return titles, bool(titles)


def _under_groups(titles: list[str], above: list[str]) -> list[str]:
    """Return titles that occur more than once with those above them, each of which heads all columns up to the next."""
    groups = [next(filter(None, above[i::-1]), "") for i in range(len(above))]
    if len(groups) != len(titles) or len({*zip(groups, titles, strict=True)}) < len(titles):
        return titles
    clocks = ("x_value", *_TIMES)
    named = list[str]()
    for group, title in zip(groups, titles, strict=True):
        is_repeated = titles.count(title) > 1 and title.casefold() not in clocks
        named.append(
            f"{group} {title}".strip() if is_repeated else f"{group} [{title}]" if units.is_unit(title) else title
        )
    return named


def _with_index_named(texts: Sequence[str], data: int) -> list[str]:
    """Return the rows of a table with titles on several levels, as pandas writes them, with those of others.

    The first cells of the levels name these, and a row below them, above the data, names nothing but the index.
    """
    separator = separator_of(texts[data])
    cells = [[bare(cell) for cell in text.split(separator)] for text in texts[: data + 1]]
    first = next((i + 1 for i in range(data - 2, -1, -1) if len(cells[i]) != len(cells[data])), 0)
    index = cells[data - 1] if data else []
    if separator is None or data - first < 2 or len(index) != len(cells[data]) or not index[0] or any(index[1:]):
        return list(texts)
    names = [index[0], *[""] * (data - first - 2)]
    levels = [separator.join([name, *row[1:]]) for name, row in zip(names, cells[first : data - 1], strict=True)]
    return [*texts[:first], separator.join([""] * len(cells[data])), *levels, *texts[data:]]


def _with_rows_named(texts: Sequence[str], data: int) -> list[str]:
    """Return the rows of a table, the cell that R writes before its numbered rows with a title."""
    separator = separator_of(texts[data])
    rows = [[bare(cell) for cell in text.split(separator)] for text in texts[max(data - 1, 0) : data + 2]]
    is_numbered = len(rows) == 3 and [row[0] for row in rows[1:]] == ["1", "2"]
    if not is_numbered or len(rows[0]) + 1 != len(rows[1]) or any(map(is_numeric, rows[0])):
        return list(texts)
    return [*texts[: data - 1], f"{_ROW_NAMES}{separator or ' '}{texts[data - 1].lstrip()}", *texts[data:]]


def _is_count(text: str, separator: str | None) -> bool:
    """Whether a line holds numbers of samples: an empty cell under the times, then whole numbers."""
    cells = list(map(bare, text.split(separator)))
    return len(cells) > 1 and not cells[0] and all(cell.isdigit() or not cell for cell in cells)


def _rate(remarks: Sequence[str], above: Sequence[str]) -> float | None:
    """Return how many samples a second the lines above a table say."""
    scale = {"usec": 1e6, "msec": 1e3, "sec": 1.0, "min": 1 / 60}
    for text in (*remarks, *above):
        line = re.sub(r"[\t;]", " ", text)
        if match := _PER_SAMPLE.search(line):
            return scale[match[2].lower()] / max(float(match[1].replace(",", ".")), 1e-9)
        if (match := _DELTA_X.match(line)) and is_numeric(match[1]):
            return 1.0 / max(float(match[1].replace(",", ".")), 1e-9)
        if match := _RATE.search(line):
            number = match["rate"] or match["fs"] or match["json"] or match["same"] or match["plain"]
            return float(number.replace(",", ".")) * (1e3 if match["k"] or match["kilo"] else 1.0) or None
    return None


def _plan(titles: Sequence[str], body: Sequence[Sequence[str]]) -> RowLayout | None:
    """Return how rows become numbers; None where they are already."""
    width = max(len(titles), len(body[0]))
    columns = [[bare(row[i]) if i < len(row) else "" for row in body] for i in range(width)]
    filled = [[cell for cell in column if cell] for column in columns]
    names = [*titles, *[""] * (width - len(titles))]
    clocks = [i for i, cells in enumerate(filled) if _tells_time(cells) and not has_unit(names[i])]
    timed = any(is_titled_in(names[i], "time") for i in range(width) if i not in clocks)
    omitted = {i for i in range(width) if not filled[i] and names[i].strip().lower() in ("", "x_value")}
    dates, events = list[int](), list[int]()
    if clocks or timed or 0 in omitted or names[-1].casefold() in _NOTES:
        dates = [i for i, cells in enumerate(filled) if cells and all(map(is_date, cells))]
        events = [i for i, cells in enumerate(filled) if _EVENT.search(names[i]) and not all(map(is_numeric, cells))]
        events += [i for i, cells in enumerate(filled) if _EVENT.search(names[i]) and not cells]
    omitted |= {*clocks, *dates, *events, *([0] if names[0] == _ROW_NAMES else [])}
    numeric = tuple(i for i in range(width) if i not in omitted)
    quoted = any(cell.strip().startswith("'") for cell in body[0])
    if not (omitted or quoted) or not numeric:
        return None
    clock = None
    if clocks and not timed:
        clock = Clock(clocks[0], dates[0] if dates else None, decimals(columns[clocks[0]]))
    return RowLayout(width, numeric, tuple(events), clock)


def _timed_by_clock(titles: list[str], body: Sequence[Sequence[str]]) -> list[str]:
    """Return titles with the unit of times that say none, where a clock beside them runs as fast."""
    rows = [[bare(cell) for cell in row] for row in body if len(row) >= len(titles)]
    clock = next((i for i in range(len(titles)) if all(is_clock(row[i]) for row in rows)), None)
    timed = next((i for i, title in enumerate(titles) if title.strip().casefold() in _TIMES), None)
    if clock is None or timed is None or clock == timed or len(rows) < 2:
        return titles
    watch = Clock(clock, None, max(decimals([row[clock] for row in rows]), 1))
    passed = [float(watch.seconds(row)) for row in rows][-1]
    ends = [row[timed].replace(",", ".") for row in (rows[0], rows[-1])]
    counted = float(ends[1]) - float(ends[0]) if all(map(is_numeric, ends)) else 0.0
    scales = {"s": 1.0, "ms": 1e-3}
    unit = next((name for name, scale in scales.items() if abs(counted * scale - passed) < 0.1 * passed), "")
    return [f"{title} [{unit}]" if i == timed and unit else title for i, title in enumerate(titles)]


def _tells_time(cells: Sequence[str]) -> bool:
    """Whether cells are times of day; midnight may be a date alone."""
    return any(map(is_clock, cells)) and all(is_clock(cell) or is_date(cell) for cell in cells)


def _stripped(cells: Sequence[str]) -> Iterator[str]:
    """Yield cells without the empty ones at the end."""
    last = max((i for i, cell in enumerate(cells) if cell.strip()), default=-1)
    yield from cells[: last + 1]


def turned(texts: Sequence[str]) -> list[str] | None:
    """Return the rows of a table with a row a signal as rows of a table with a column a signal; None if it is none.

    Every row of such a table begins with a title, perhaps with a unit in the next cell, and many numbers follow.
    """
    rows = [text for text in texts if is_row(text)]
    if not 2 <= len(rows) <= _MAX_TURNED or (separator := separator_of(rows[0])) is None:
        return None
    cells = [[bare(cell) for cell in row.split(separator)] for row in rows]
    width = len(cells[0])
    first = next((i for i, cell in enumerate(cells[0]) if is_numeric(cell)), width)
    if width < _MIN_TURNED or first not in (1, 2) or any(len(row) != width for row in cells):
        return None
    if not all(map(is_numeric, cells[0][first:])) or any(is_numeric(row[0]) for row in cells):
        return None
    titles = [row[0] if first == 1 else f"{row[0]} [{row[1]}]" for row in cells]
    mark = "\t" if separator == "," else separator
    return [mark.join(titles), *(mark.join(column) for column in zip(*(row[first:] for row in cells), strict=True))]


def is_long(texts: Sequence[str]) -> bool:
    """Whether a table has a row a sample of one signal, with the signal in one column and the value in another, or a
    row a sample of all signals of an animal, which a column names."""
    header, *rows = filter(is_row, texts[: 1 << 16]) if any(map(is_row, texts)) else [""]
    names = _long_names(header)
    key = next(i for i, name in enumerate(names) if name in _KEYS) if _says_values(names) else _whose(names)
    cells_of = (row.split(separator_of(header)) for row in rows) if key >= 0 else ()
    keys = {cells[key] for cells in cells_of if len(cells) == len(names)}
    return 0 < len(keys) <= len(rows) / _FEWEST_SAMPLES


def _says_values(names: Sequence[str]) -> bool:
    """Whether one of the titles is that of what is measured, and one that of its values."""
    return any(name in _KEYS for name in names) and any(name in _VALUES for name in names)


def _whose(names: Sequence[str]) -> int:
    """Return the column of those whose signals and times stand beside it, -1 without one; ``id`` may count packets."""
    is_timed = any(name in _TIMES for name in names) and len(names) > 2
    return next((i for i, name in enumerate(names) if name in _SUBJECTS and name != "id"), -1) if is_timed else -1


def _long_names(header: str) -> list[str]:
    titles = [bare(title) for title in csv_cells(header, separator_of(header) or "\t")]
    return [(split_title(title) or (title,))[0].casefold() for title in titles]


def spread(path: Path, numbered: Sequence[tuple[int, str]]) -> list[str]:
    """Return the rows of a table that `is_long` as rows with a column a signal, of each animal where there are several,
    and the times once, or before each signal where they differ; `InputError` for a row of another length."""
    (_, header), *rows = [(line, text) for line, text in numbered if is_row(text)]
    separator, names = separator_of(header) or "\t", _long_names(header)
    cells = [[bare(cell) for cell in split_cells(path, *row, separator)] for row in rows]
    for (line, _), row in zip(rows, cells, strict=True):
        if len(row) != len(names):
            raise InputError(f"{path}, line {line}: {len(row)} columns where {len(names)} were expected")
    if not _says_values(names):
        header, cells = _melted(csv_cells(header, separator), names, cells)
        separator, names = "\t", _long_names(header)
    key, value, unit, clock = (next((i for i, name in enumerate(names) if name in words), -1)
                               for words in (_KEYS, _VALUES, _UNITS, _TIMES))  # fmt: skip
    labels = _labels(names, cells, (key, value, unit, clock))
    heads = {i: f"{names[i]} " if all(row[i].isdigit() for row in cells) else "" for i in labels}
    signals: dict[str, list[list[str]]] = {}
    for row in cells:
        title = " ".join([*(heads[i] + row[i] for i in labels), row[key]]) + (f" [{row[unit]}]" if unit >= 0 else "")
        signals.setdefault(title, []).append(row)
    times = [[row[clock] for row in group] if clock >= 0 else [] for group in signals.values()]
    time = csv_cells(header, separator)[clock].strip('" ')
    columns = list[list[str]]()
    for index, (title, group) in enumerate(signals.items()):
        columns += [[time, *times[index]]] if clock >= 0 and (index == 0 or times[index] != times[0]) else []
        columns.append([title, *(row[value] for row in group)])
    return ["\t".join(row) for row in zip_longest(*columns, fillvalue="")]


def _melted(titles: Sequence[str], names: Sequence[str], cells: Sequence[Sequence[str]]) -> tuple[str, list[list[str]]]:
    """Return header and cells of a table with the signals of several animals as those with a row a sample of one."""
    clock = next(i for i, name in enumerate(names) if name in _TIMES)
    labels = [i for i, name in enumerate(names) if i == _whose(names) or not any(is_value(row[i]) for row in cells)]
    signals = [(i, bare(title)) for i, title in enumerate(titles) if i not in (clock, *labels)]
    header = "\t".join([bare(titles[clock]), *(names[i] for i in labels), "signal", "value"])
    return header, [[row[clock], *(row[i] for i in labels), title, row[i]] for row in cells for i, title in signals]


def _labels(names: Sequence[str], cells: Sequence[Sequence[str]], taken: Sequence[int]) -> list[int]:
    """Return the columns that say whose a sample is: by title, in words, or by numbers, each in many rows, where
    without them a signal has a time twice; or none, and then these rows follow each other."""
    key, *_, clock = taken
    free = [i for i in range(len(names)) if i not in taken and len({row[i] for row in cells}) > 1]
    labels = [i for i in free if names[i] in _SUBJECTS or not any(is_value(row[i]) for row in cells)]

    def count(columns: Sequence[int]) -> int:
        return len({tuple(row[i] for i in columns) for row in cells})

    for i in free:
        is_joined = clock < 0 or count([key, *labels, clock]) < len(cells)
        groups = sum(1 for _ in groupby(row[i] for row in cells)) if clock < 0 else count([key, *labels, i])
        if is_joined and count([key, *labels]) < count([key, *labels, i]) and groups <= len(cells) / _FEWEST_SAMPLES:
            labels += [i] if all(row[i].isdigit() for row in cells) else []
    return labels


def remarks_above(texts: Sequence[str]) -> list[str]:
    """Return the lines that begin with ``#`` above the first row of a table."""
    first = next((i for i, text in enumerate(texts) if is_row(text)), len(texts))
    return [text for text in texts[:first] if text.strip()]
