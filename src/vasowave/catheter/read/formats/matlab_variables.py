"""Signals that are variables of a MATLAB file, each a vector: ``pressure``, ``flow``, ``time``; ``pressure_unit``."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import zip_longest
from pathlib import Path

import numpy as np

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.io.headings import split_title
from vasowave.base.io.matlab import is_mat, text, vector
from vasowave.base.io.named_arrays import read_named
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat
from vasowave.catheter.read.formats.labchart_mat import is_labchart_mat, rows_of_text
from vasowave.catheter.read.formats.matlab_structures import is_structured
from vasowave.catheter.signals.channels import Block, Channel, rates_differ
from vasowave.catheter.signals.gaps import with_gaps
from vasowave.catheter.signals.signal import ALIASES, MAX_RATE_DIFFERENCE, RATE_NAMES, sampling

_UNIT_BY_NAME = re.compile(r"(?:.*\.)?units?\.([^.]+)", re.IGNORECASE)


def _sniff(path: Path, start: bytes) -> bool:
    sniffers = (is_labchart_mat, is_structured)
    return is_mat(path, start) and not any(sniff(path, start) for sniff in sniffers)


def read_variables(path: str | Path, sampling_rate: float | None = None) -> Block:
    """Return the vectors of a MATLAB file as channels of their own names; without ``time`` or a rate their rate is nan.

    Raises
    ------
    InputError
        No vectors, none as long as the times, or uneven times.
    """
    variables = _with_columns(_with_units(read_named(Path(path))))
    plain = {_plain(name): value for name, value in variables.items()}
    vectors = {
        name: vector(value, f"{path}: variable '{name}'")
        for name, value in variables.items()
        if np.asarray(value).dtype.kind in "iufb" and 1 < np.size(value) == max(np.shape(value))
    }
    longest = max((len(values) for values in vectors.values()), default=0)  # times of events are fewer
    clocks = [name for name, values in vectors.items() if _plain(name) == "time" and len(values) == longest]
    if not clocks and (odd := next((name for name in vectors if "." not in name and _plain(name) == "time"), "")):
        raise InputError(f"{path}: variable '{odd}' has {len(vectors[odd])} values, the signals have up to {longest}; "
                         "save one time for each sample, or none beside the rate")  # fmt: skip
    times = [vectors[name] for name in _shallowest(clocks)]
    time = times[0] if times else None
    level = min((name.count(".") for name in vectors), default=0)  # deeper, structures speak of themselves
    numbers = {name: _single_number(value) for name, value in variables.items()
               if _plain(name) in RATE_NAMES and name.count(".") <= level}  # fmt: skip
    rates = {numbers[name] for name in _shallowest(name for name, number in numbers.items() if number)}
    if len(rates) > 1 or not all(np.array_equal(times[0], further) for further in times[1:]):
        raise InputError(f"{path}: its structures have different rates or times; keep one of them")
    told_rate = next(iter(rates), None)
    if sampling_rate is None or np.isnan(sampling_rate):
        sampling_rate = told_rate or sampling_rate
    elif told_rate and abs(sampling_rate / told_rate - 1) > MAX_RATE_DIFFERENCE:
        raise InputError(f"{path}: it says {told_rate:g} samples/s, given are {sampling_rate:g}; leave the rate out")
    time_unit = text(plain.get("time_unit", "")) or next((_split(name)[1] for name in _shallowest(clocks)), "")
    rate, place = _rate(path, time, time_unit, sampling_rate)
    channels = tuple(
        Channel(name, text(variables.get(f"{name}_unit", plain.get(f"{_plain(name)}_unit", ""))) or _split(name)[1],
                values if place is None else with_gaps(values, place), rate, f"{path}, variable '{name}'")
        for name, values in vectors.items() if _plain(name) != "time" and (time is None or len(time) == len(values))
    )  # fmt: skip
    if not channels:
        raise InputError(
            f"{path}: no vectors; save columns of a matrix as time, pressure and flow, or labels beside it; it has: "
            f"{', '.join(variables) or 'nothing'}"
        )
    return Block(channels, suspicions=rates_differ(told_rate, rate) if time is not None else ())


def _with_units(variables: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return variables, with the units that a structure ``units`` names, and the rate by AcqKnowledge's interval."""
    united = {match[1]: value for name, value in variables.items()
              if (match := _UNIT_BY_NAME.fullmatch(name)) and text(value)}  # fmt: skip
    signals = {name: value for name, value in variables.items() if not (_UNIT_BY_NAME.fullmatch(name) and text(value))}
    named = {f"{name}_unit": united[stem] for name in signals if (stem := name.rpartition(".")[2]) in united}
    if step := _single_number(variables.get("isi", np.empty(0))):
        named["fs"] = np.array(1 / (step * units.factor(text(variables.get("isi_units", "")) or "ms", "time")))
    return signals | named


def _with_columns(variables: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return variables, and the columns or rows of matrices beside which as many labels stand, perhaps with units.

    Where a name would stand twice, as of two matrices beside the same labels, that of the matrix is before each.
    """
    columns = [column for name, value in variables.items() for column in _columns_of(variables, name, value)]
    counts = Counter([stem + label for stem, _, label, *_ in columns] + list(variables))
    is_double = any(counts[stem + label] > 1 for stem, _, label, *_ in columns)
    spread = dict(variables)
    for stem, matrix, label, column, unit in columns:
        title = stem + (f"{matrix} {label}" if is_double else label)
        spread |= {title: column} | ({f"{title}_unit": np.array(unit)} if unit is not None else {})
    return spread


def _columns_of(
    variables: Mapping[str, np.ndarray], name: str, matrix: np.ndarray
) -> Iterator[tuple[str, str, str, np.ndarray, str | None]]:
    """Go through the columns of a matrix that labels name: what stands before its name, that, label, values, unit."""
    if matrix.dtype.kind not in "iuf" or matrix.ndim != 2:
        return
    stem = name[: name.rfind(".") + 1]
    neighbors = [value for key, value in variables.items() if key[: key.rfind(".") + 1] == stem]
    for across in (matrix, matrix.T):
        labels, units_of = _labels(neighbors, across.shape[1])
        if labels and len(across) > len(labels):
            for label, column, unit in zip_longest(labels, across.T, units_of):
                yield stem, name[len(stem) :], label, column, unit


def _labels(neighbors: Iterable[np.ndarray], count: int) -> tuple[list[str], list[str]]:
    """Return the only texts of so many columns that name them, and those that are their units."""
    texts = [
        [row.replace(".", " ").strip() for row in rows] for rows in map(rows_of_text, neighbors) if len(rows) == count
    ]
    named = [rows for rows in texts if all(rows) and len(set(rows)) == count and not all(map(units.is_unit, rows))]
    united = [rows for rows in texts if all(units.is_unit(row) for row in rows if row) and any(rows)]
    return (named[0] if len(named) == 1 and count > 1 else []), (united[0] if len(united) == 1 else [])


def _shallowest(names: Iterable[str]) -> list[str]:
    """Return the names of the fewest levels: what structures within hold is about themselves."""
    listed = list(names)
    level = min((name.count(".") for name in listed), default=0)
    return [name for name in listed if name.count(".") == level]


def _single_number(value: np.ndarray) -> float | None:
    """Return the one positive number of a variable, None if it holds something else."""
    number = float(value.ravel()[0]) if value.size == 1 and value.dtype.kind in "iuf" else np.nan
    return number if np.isfinite(number) and number > 0 else None


def _plain(name: str) -> str:
    """Return the name of a variable, or of a structure's field, as vasowave calls it: ``P_unit`` is pressure_unit, and
    ``P_mmHg`` pressure."""
    stem, mark, _ = _split(name)[0].lower().partition("_unit")
    return ALIASES.get(stem, stem) + mark


def _split(name: str) -> tuple[str, str]:
    """Return the name of a variable or field without the unit that it ends in, and that unit."""
    stem, unit = split_title(name.rpartition(".")[2]) or (name, "")
    return stem, unit or ""


def _rate(path: str | Path, time: np.ndarray | None, unit: str, stated_rate: float | None
          ) -> tuple[float, np.ndarray | None]:  # fmt: skip
    """Return samples per second, nan where nothing tells, and places if the times leap over gaps."""
    if time is None or len(time) < 2:
        return (np.nan if stated_rate is None else stated_rate), None
    time = time * units.factor(unit or "s", "time")
    written = np.float32 if np.array_equal(time, time.astype(np.float32)) else np.float64
    rounding = 4 * float(np.finfo(written).eps) * float(np.abs(time).max())
    return sampling(time, rounding, str(path), lambda row: f"{path}, time({row + 1})")


RECORDINGS.register(
    RecordingFormat(
        "mat", "MATLAB file", (".mat",), _sniff, lambda path, rate, progress: [read_variables(path, rate)],
        unit_assumed=True,
    )
)  # fmt: skip
