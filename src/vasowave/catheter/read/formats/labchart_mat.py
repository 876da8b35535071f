"""The MATLAB exports of ADInstruments LabChart: all channels of all blocks in one vector, and tables that divide it;
or, as older ones and those of Macintosh, a matrix a block."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.matlab import is_mat, read_mat, vector
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat
from vasowave.catheter.signals.channels import Block, Channel, Comment
from vasowave.catheter.signals.gaps import with_gaps
from vasowave.catheter.signals.signal import sampling

_REQUIRED_VARIABLES = ("data", "datastart", "dataend", "titles", "samplerate")
_MATRIX = "data_block"


def is_labchart_mat(path: Path, start: bytes) -> bool:
    """Whether a file is one of MATLAB and holds the variables of LabChart's export."""
    if not is_mat(path, start):
        return False
    names = set(read_mat(path))
    return {"datastart", "dataend"} <= names or any({f"{_MATRIX}{n}", f"titles_block{n}"} <= names for n in (1, 2))


def read_labchart_mat(path: str | Path) -> list[Block]:
    """Read all blocks of a LabChart MATLAB export (``.mat``, version 4 to 7).

    Rows of ``datastart`` and ``dataend`` are channels, columns are blocks; both count from 1 and both ends belong to
    the channel; -1 marks a channel that is empty in a block. 16-bit data become (data + scaleoffset) * scaleunits.

    Raises
    ------
    InputError
        A file that cannot be read, is no LabChart export, or whose tables contradict each other.
    """
    variables = read_mat(path)
    numbers = sorted(int(match[1]) for name in variables if (match := re.fullmatch(rf"{_MATRIX}(\d+)", name)))
    if numbers and "datastart" not in variables:
        return [_matrix_block(path, variables, number) for number in numbers]
    missing = [name for name in _REQUIRED_VARIABLES if name not in variables]
    if missing:
        raise InputError(
            f"{path}: not a continuous recording exported by LabChart (no {', '.join(missing)}); one averaged cycle "
            "is read with read_recording"
        )
    data = vector(variables["data"], f"{path}: data")
    tables = _Tables(path, variables)
    titles = rows_of_text(variables["titles"])
    channels, blocks = tables.shape
    if len(titles) < channels:
        raise InputError(f"{path}: {channels} channels in datastart and {len(titles)} titles; export it again")
    read = []
    for b in range(blocks):
        channels_read = [_channel(path, tables, data, titles[c], c, b) for c in range(channels)]
        read.append(Block(tuple(channel for channel in channels_read if channel), _comments(path, variables, b)))
    return read


def _matrix_block(path: str | Path, variables: Mapping[str, Any], number: int) -> Block:
    """Return a block that has a row a channel, beside times, titles, units, and comments by the number of a sample."""

    def of_block(name: str) -> Any:
        return variables.get(f"{name}_block{number}", np.empty(0))

    place = f"{path}, block {number}"
    data = np.atleast_2d(of_block("data"))
    titles, units_of = rows_of_text(of_block("titles")), rows_of_text(of_block("units"))
    times, ticks, whose = (vector(of_block(name), place) for name in ("ticktimes", "comtick", "comchan"))
    texts = rows_of_text(of_block("comtext"))
    is_commented = len(ticks) == len(whose) == len(texts) and all(1 <= tick <= len(times) for tick in ticks)
    if data.shape != (len(titles), len(times)) or data.dtype.kind not in "iuf" or len(times) < 2 or not is_commented:
        raise InputError(f"{place}: its data, titles, times and comments do not go together; export it again")
    rounding = 4 * float(np.finfo(np.float64).eps) * float(np.abs(times).max())
    rate, leaps = sampling(times, rounding, place, lambda row: f"{place}, sample {row + 1}")
    channels = tuple(
        Channel(title, unit.strip("*"), values if leaps is None else with_gaps(values, leaps), rate,
                f"{place}, channel '{title}'")
        for title, unit, values in zip(titles, [*units_of, *[""] * len(titles)], data.astype(float), strict=False)
    )  # fmt: skip
    comments = zip((float(times[int(tick) - 1] - times[0]) for tick in ticks), texts, whose, strict=True)
    return Block(channels, tuple(Comment(time, text, max(int(channel), 0)) for time, text, channel in comments))


class _Tables:
    """The tables of one number per channel and block."""

    def __init__(self, path: str | Path, variables: Mapping[str, Any]) -> None:
        self._path, self._variables = path, variables
        self.units = rows_of_text(variables.get("unittext", ""))
        self.shape: tuple[int, int] = np.atleast_2d(variables["datastart"]).shape[:2]

    def __contains__(self, name: str) -> bool:
        return name in self._variables

    def at(self, name: str, channel: int, block: int) -> float:
        table = np.atleast_2d(self._variables[name])
        if table.dtype.kind not in "iufb" or table.ndim != 2:
            raise InputError(f"{self._path}: {name} is not a table of numbers; export it again")
        if table.shape != self.shape:
            sizes = " × ".join(map(str, table.shape))
            raise InputError(f"{self._path}: {name} has size {sizes}, datastart {self.shape[0]} × {self.shape[1]}")
        return float(table[channel, block])


def _channel(
    path: str | Path, tables: _Tables, data: np.ndarray, title: str, channel: int, block: int
) -> Channel | None:
    """Return one channel of one block, None if it is empty there."""
    place = f"{path}, block {block + 1}, channel '{title}'"
    start, end = (tables.at(name, channel, block) for name in ("datastart", "dataend"))
    if start == -1 or end == -1:
        return None
    rate = tables.at("samplerate", channel, block)
    if not (1 <= start <= end <= len(data) and start == int(start) and end == int(end)):
        raise InputError(f"{place}: samples {start:g} to {end:g} of {len(data)}; the file is damaged, export it again")
    if not (np.isfinite(rate) and rate > 0):
        raise InputError(f"{place}: sampling rate {rate:g}; export it again")
    values = data[int(start) - 1 : int(end)]
    if "scaleunits" in tables and "scaleoffset" in tables:
        values = (values + tables.at("scaleoffset", channel, block)) * tables.at("scaleunits", channel, block)
    index = tables.at("unittextmap", channel, block) if "unittextmap" in tables else -1
    unit = tables.units[int(index) - 1] if 1 <= index <= len(tables.units) else ""
    return Channel(title, "" if unit == "*" else unit, values, rate, place)


def _comments(path: str | Path, variables: Mapping[str, Any], block: int) -> tuple[Comment, ...]:
    """Return the comments of one block; ``com`` holds channel (-1 for all), block, tick, kind, number of text."""
    table = np.atleast_2d(variables.get("com", np.empty((0, 5))))
    if table.size == 0:
        return ()
    if table.dtype.kind not in "iuf" or table.shape[1] != 5 or "comtext" not in variables:
        raise InputError(f"{path}: the comments (com, comtext) are damaged; export it again without comments")
    texts = rows_of_text(variables["comtext"])
    rates = vector(variables.get("tickrate", np.empty(0)), f"{path}: tickrate")
    comments = []
    for channel, at_block, tick, _, number in table:
        if at_block - 1 == block and block < len(rates) and rates[block] > 0:
            text = texts[int(number) - 1] if 1 <= number <= len(texts) else ""
            comments.append(Comment(float(tick / rates[block]), text, max(int(channel), 0)))
    return tuple(comments)


def rows_of_text(value: Any) -> list[str]:
    """Return the rows of a MATLAB character matrix, without the blanks that pad them."""
    array = np.atleast_1d(np.asarray(value))
    return [str(row).strip().strip("\0") for row in array.ravel()] if array.dtype.kind == "U" else []


RECORDINGS.register(
    RecordingFormat(
        "labchart mat", "LabChart MATLAB export", (), is_labchart_mat,
        lambda path, rate, progress: read_labchart_mat(path), continuous=True,
    )
)  # fmt: skip
