"""A table with a row a subject: the cycle of one of them, its samples below each other."""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from vasowave.base import units
from vasowave.base.cures import UNKNOWN, SetCells
from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.io.cells import is_value
from vasowave.base.io.columns import Columns, plain_title, read_columns
from vasowave.base.io.headings import split_title
from vasowave.catheter.read.choosing import owner
from vasowave.catheter.signals.signal import ALIASES

_NUMBERED = re.compile(r"(?P<stem>.*?[^\W\d_])[\W_]*(?P<number>\d+)[\W_]*")
_CHANNELS = 64  # more than a recorder has
_MAX_BYTES = 1 << 26  # of a table of subjects
_FEWEST = 8  # numbered columns that are samples of a signal, and not visits or vessels
_RATES = ("heart rate", "heart rate bpm", "hr", "hr bpm", "heart frequency", "herzfrequenz", "fréquence cardiaque")
_PER_MINUTE = re.compile(r"|[bl]pm|\w* ?(/|per|pro) ?min(\.|s|utes?)?|(beats ?)?min\W*[1¹]", re.IGNORECASE)
_PER_SECOND = re.compile(r"hz|(1|beats)? ?(/|per) ?s(ec|econd)?|s\W*[1¹]", re.IGNORECASE)
_PERIODS = ("period", "rr", "rr interval", "cycle length")
SUBJECT = SetCells("Name the subject whose row is read", (("subject row", UNKNOWN),))


@contextmanager
def subject_asked_for(path: Path, subject: str = "", sheet: str = "") -> Iterator[None]:
    """Turn what is wrong with a table into the question whose row to read, where it has a row a subject."""
    try:
        yield
    except InputError as error:
        if (table := _small_table(path, sheet)) is None or subject:
            raise
        if names := list(_pairs(table)):
            raise InputError(
                f"{path}: its columns are of {', '.join(names[:_FEWEST])}; name the subject whose columns to read",
                [SUBJECT],
            ) from error
        first, *_, last = _sample_titles(table)
        if not last:
            raise
        raise InputError(
            f"{path}: its columns {first} to {last} are samples of a row a subject; name the subject whose row to "
            "read, or write its samples below each other, pressure in one column and flow in another",
            [SUBJECT],
        ) from error


def _small_table(path: Path, sheet: str) -> Columns | None:
    """Return a table that may be one of subjects, None for what is none."""
    try:
        return read_columns(path, sheet=sheet) if path.stat().st_size < _MAX_BYTES else None
    except InputError:
        return None


def _pairs(table: Columns) -> Mapping[str, Mapping[str, Sequence[int]]]:
    """Return the columns of pressure and flow of each subject, where several have such a pair beside each other."""
    pairs: dict[str, dict[str, list[int]]] = {}
    for column, (title, unit) in enumerate(zip(map(plain_title, table.titles), table.units, strict=True)):
        quantities = [quantity for quantity in ("pressure", "flow") if units.is_of(unit, quantity)]
        if quantities and (whose := owner(title)):
            pairs.setdefault(whose, {}).setdefault(quantities[0], []).append(column)
    complete = {whose: pair for whose, pair in pairs.items() if len(pair) == 2}
    return complete if len(complete) > 1 else {}


def _columns_of_pair(table: Columns, subject: str) -> Columns:
    """Return the columns of one of the subjects beside each other, and those that are nobody's."""
    pairs = _pairs(table)
    if (name := subject.strip().casefold()) not in pairs:
        hint = did_you_mean(name, pairs) or f"; it has: {', '.join([*pairs][:_FEWEST])}"
        raise InputError(f"{table.source}: no columns of '{subject}'{hint}", [SUBJECT])
    for quantity, columns in pairs[name].items():
        if len(columns) > 1:
            titles = " and ".join(f"'{table.titles[i].strip()}'" for i in columns)
            raise InputError(f"{table.source}: {titles} are each a {quantity} of '{subject}'; leave in one of them")
    places = {columns[0]: quantity for quantity, columns in pairs[name].items()}
    rows = [n for n, row in enumerate(table.cells) if any(row[i].strip() for i in places)]
    time = _time_of(table, name, max(places))
    nobodys = {
        table.names[i]: i
        for i, unit in enumerate(table.units)
        if i < max(places)
        and not (_is_time(table.names[i]) or any(units.is_of(unit, quantity) for quantity in pairs[name]))
    }
    places |= {} if time is None else {time: "time"}
    taken = sorted({*nobodys.values(), *places})
    return replace(
        table, names=tuple(places.get(i, ALIASES.get(table.names[i], table.names[i])) for i in taken),
        units=tuple(table.units[i] for i in taken), titles=tuple(table.titles[i] for i in taken),
        cells=tuple(tuple(table.cells[n][i] for i in taken) for n in rows), lines=tuple(table.lines[n] for n in rows),
    )  # fmt: skip


def _time_of(table: Columns, subject: str, end: int) -> int | None:
    """Return the column of a subject's times: its own, else nobody's last before the `end` of its pair, or behind."""
    named = [i for i, name in enumerate(table.names) if _is_time(name, subject)]
    times = [i for i, name in enumerate(table.names) if _is_time(name)]
    times = named[:1] or [i for i in times if i < end][-2:] or times[:1]
    if len(times) > 1 and times[1] == times[0] + 1:
        titles = " and ".join(f"'{table.titles[i].strip()}'" for i in times)
        raise InputError(f"{table.source}: {titles} may both be times of '{subject}'; write '{subject} time [s]'")
    return times[-1] if times else None


def _is_time(name: str, subject: str = "") -> bool:
    """Whether a column is called time, perhaps with a number, and after a subject, if one is given."""
    words, whose = re.split(r"[\W_]+", name), subject.split()
    title = re.sub(r"\d+", "", " ".join(word for word in words if word not in whose)).strip()
    return set(whose) <= set(words) and ALIASES.get(title, title) == "time"


def subjects_of(path: Path, sheet: str = "") -> list[str]:
    """Return the names of all subjects of a table; none where no column names each unlike the others."""
    table = read_columns(path, sheet=sheet)
    samples = {column for columns in sample_columns(table).values() for column in columns}
    labels = [[row[i].strip() for row in table.cells] for i in range(len(table.names)) if i not in samples]
    unlike = (names for names in labels if all(names) and len(set(names)) == len(names))
    return list(_pairs(table)) or next(unlike, [])


def _sample_titles(table: Columns) -> list[str]:
    """Return the titles of the samples in a table with a row a subject, whom a word names, or of so many that none is
    a channel; else two blanks.
    """
    columns = [column for signal in sample_columns(table).values() for column in signal]
    if not columns:
        return ["", ""]
    labels = [[cell.strip() for i, cell in enumerate(row) if i not in columns] for row in table.cells]
    is_named = all(any(not is_value(cell) for cell in row) for row in labels)
    return [table.titles[column].strip() for column in columns] if is_named or len(columns) > _CHANNELS else ["", ""]


def subject_columns(path: Path, subject: str, sheet: str = "") -> Columns:
    """Return the samples of one subject as a table with a column a signal.

    Raises
    ------
    InputError
        No numbered columns; no such subject, or several; samples that are missing.
    """
    if _pairs(table := read_columns(path, sheet=sheet)):
        return _columns_of_pair(table, subject)
    table, row = _row_of(path, subject, sheet)
    signals = sample_columns(table)
    lengths = {len(columns) for columns in signals.values()}
    if len(lengths) > 1:
        counts = ", ".join(f"{len(columns)} of '{name}'" for name, columns in signals.items())
        raise InputError(f"{path}: its signals have unlike numbers of samples ({counts}); give a file of each")
    cells = tuple(tuple(table.cells[row][column] for column in sample) for sample in zip(*signals.values()))
    first = [columns[0] for columns in signals.values()]
    pairs = [split_title(name) or (name, None) for name in signals]
    names = tuple(ALIASES.get(name, name) for name, _ in pairs)
    stated = tuple(table.units[column] or unit or "" for column, (_, unit) in zip(first, pairs, strict=True))
    lines = (table.lines[row],) * len(cells)
    titles = tuple(f"{table.titles[columns[0]]} to {table.titles[columns[-1]]}" for columns in signals.values())
    return replace(table, names=names, units=stated, cells=cells, lines=lines, titles=titles)


def period_of_subject(path: Path, subject: str, sheet: str = "") -> float | None:
    """Return the period of a subject's cycle, s, by its heart rate or its length; None where no column says it.

    Raises
    ------
    InputError
        No such subject; a heart rate in a unit that is none of rates.
    """
    if _pairs(read_columns(path, sheet=sheet)):
        return None
    table, row = _row_of(path, subject, sheet)
    for column, (name, unit) in enumerate(zip(table.names, table.units, strict=True)):
        title = " ".join(re.sub(r"[\W_]+", " ", name).split())
        if title in _RATES:
            minute, rate = _rate_unit(table, column), _value(table, row, column)
            return minute / rate if rate > 0 else None
        if title in _PERIODS and units.is_of(unit, "time"):  # RR is a rate of breaths, too
            return _value(table, row, column) * units.factor(unit, "time")
    return None


def _rate_unit(table: Columns, column: int) -> float:
    """Return how long the beats are counted that a heart rate says, s: a minute, or a second."""
    title, unit = table.titles[column].strip(), table.units[column].strip()
    per = f"/{unit}" if re.search(rf"/\s*{re.escape(unit)}$", title) else unit  # 'HR/min' is split at its stroke
    for wording, duration in ((_PER_MINUTE, 60.0), (_PER_SECOND, 1.0)):
        if wording.fullmatch(per) and not units.is_unit(per):  # as ml/min is one of flow
            return duration
    raise InputError(
        f"{table.source}: column '{title}': '{unit}' is not a unit of a rate; write 1/min or Hz, or call it 'period'"
    )


def _value(table: Columns, row: int, column: int) -> float:
    """Return a number of a row, in whatever unit."""
    units_left_out = ("s",) * len(table.units)
    cells = replace(table, cells=(table.cells[row],), lines=(table.lines[row],), units=units_left_out)
    return float(cells.numbers(column, "time")[0])


def subject_as_written(path: Path, subject: str, sheet: str = "") -> str:
    """Return the name of a subject as its table spells it."""
    if _pairs(table := read_columns(path, sheet=sheet)):
        _columns_of_pair(table, subject)
        return subject.strip()
    table, row = _row_of(path, subject, sheet)
    cells = (cell.strip() for cell in table.cells[row])
    return next(cell for cell in cells if cell.casefold() == subject.strip().casefold())


def _row_of(path: Path, subject: str, sheet: str) -> tuple[Columns, int]:
    """Return a table, and which of its rows is that of a subject."""
    table = read_columns(path, sheet=sheet)
    _check_numbers(table)
    samples = {column for columns in sample_columns(table).values() for column in columns}
    if not samples:
        raise InputError(
            f"{path}: no columns that number the samples of a signal, as p_0, p_1 …; a row of it holds no cycle. What "
            "the numbers of a right-heart catheter tell: vasowave right-heart FILE"
        )
    labels = [[cell.strip() for i, cell in enumerate(row) if i not in samples] for row in table.cells]
    rows = [i for i, row in enumerate(labels) if subject.strip().casefold() in map(str.casefold, row)]
    if len(rows) == 1:
        return table, rows[0]
    names = [next(iter(row), "") for row in labels]
    if rows:
        lines = ", ".join(str(table.lines[row]) for row in rows)
        raise InputError(f"{path}: lines {lines} are rows of '{subject}'; name one that stands once", [SUBJECT])
    hint = did_you_mean(subject, names) or f"; it has: {', '.join(names[:_FEWEST])}"
    raise InputError(f"{path}: no row of '{subject}'{hint}", [SUBJECT])


def sample_columns(table: Columns) -> Mapping[str, Sequence[int]]:
    """Return the columns of each signal, in the order of their numbers, by what stands before these."""
    return {stem: [numbered[number] for number in sorted(numbered)]
            for stem, numbered in _numbered(table).items() if not _lacking(numbered)}  # fmt: skip


def _check_numbers(table: Columns) -> None:
    """Raise `InputError` for a signal that lacks samples, but fewer than it has."""
    for stem, numbered in _numbered(table).items():
        if 0 < (lacking := _lacking(numbered)) < len(numbered):
            first = next(number for number in range(min(numbered), max(numbered)) if number not in numbered)
            surplus = f" and {lacking - 1} more" if lacking > 1 else ""
            raise InputError(f"{table.source}: the columns of '{stem}' are numbered from {min(numbered)} to "
                             f"{max(numbered)} and lack {first}{surplus}; put the samples in")  # fmt: skip


def _lacking(numbered: Mapping[int, int]) -> int:
    """Return how many numbers are left out between the first and the last."""
    return max(numbered) - min(numbered) + 1 - len(numbered)


def _numbered(table: Columns) -> Mapping[str, Mapping[int, int]]:
    """Return column by number of each signal, or what else is numbered as often, by what stands before the numbers."""
    signals: dict[str, dict[int, int]] = {}
    for column, name in enumerate(table.names):
        if match := _NUMBERED.fullmatch(name):
            signals.setdefault(match["stem"], {})[int(match["number"])] = column
    return {stem: numbered for stem, numbered in signals.items() if len(numbered) >= _FEWEST}
