"""MATLAB files with a structure for each channel, as Spike2 exports them and labs save them: samples, unit and rate."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.matlab import is_mat, text, vector
from vasowave.base.io.named_arrays import read_named
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat
from vasowave.catheter.signals.channels import Block, Channel
from vasowave.catheter.signals.signal import ALIASES, MAX_RATE_DIFFERENCE, RATE_NAMES

_SAMPLES, _TIMES = ("data", "values", "samples", "signal"), ("time", "times")
_UNITS, _TITLES, _INTERVALS = ("unit", "units"), ("title", "name", "label"), ("interval", "dt")
Fields = Mapping[str, np.ndarray]


def _levels(variables: Fields) -> dict[str, dict[str, np.ndarray]]:
    """Return fields in lower case by their structure's name, those of the file itself by an empty one."""
    levels: dict[str, dict[str, np.ndarray]] = {"": {}}
    for name, value in variables.items():
        stem, _, field = name.rpartition(".")
        levels.setdefault(stem, {})[field.lower()] = value
    return levels


def _is_vector(value: np.ndarray) -> bool:
    return value.dtype.kind in "iuf" and 1 < value.size == max(value.shape)


def _channels(levels: Mapping[str, Fields]) -> list[str]:
    """Return the structures that hold samples and their unit; none where signals are variables of their own."""
    if any(_is_vector(value) and ALIASES.get(name, name) in ("pressure", "flow") for name, value in levels[""].items()):
        return []
    return [stem for stem, fields in levels.items()
            if stem and any(text(fields.get(name)) for name in _UNITS)
            and any(name in fields and _is_vector(fields[name]) for name in _SAMPLES)]  # fmt: skip


def is_structured(path: Path, start: bytes) -> bool:
    """Whether a file is one of MATLAB with structures that hold samples and their unit."""
    return is_mat(path, start) and has_structures(read_named(path))


def has_structures(variables: Fields) -> bool:
    """Whether some of the variables of a file are structures that hold samples and their unit."""
    return bool(_channels(_levels(variables)))


def read_structures(path: Path, sampling_rate: float | None = None) -> list[Block]:
    """Return the structures of a MATLAB file as channels, each with its title, unit and rate.

    Raises
    ------
    InputError
        Rates that contradict each other or the one that is given, uneven times, channels that begin apart.
    """
    levels, channels, begins = _levels(read_named(path)), [], []
    for stem in _channels(levels):
        fields = levels[stem]
        samples = next(fields[name] for name in _SAMPLES if name in fields and _is_vector(fields[name]))
        title = next((text(fields[name]) for name in _TITLES if text(fields.get(name))), stem.rpartition(".")[2])
        place = f"{path}, channel '{title}'"
        around = [levels[level] for level in _enclosing(stem) if level in levels]
        rate, begin = _rate(place, around, samples.size, sampling_rate)
        begins.append(begin)
        unit = next(text(fields[name]) for name in _UNITS if text(fields.get(name)))
        channels.append(Channel(title, unit, vector(samples, place), rate, place))
    if not channels:
        raise InputError(f"{path}: its structures hold no samples; export it again")
    if np.ptp(begins) * max(channel.sampling_rate for channel in channels) > 1:
        texts = ", ".join(f"'{c.title}' at {begin:g} s" for c, begin in zip(channels, begins, strict=True))
        raise InputError(f"{path}: its channels begin at different times ({texts}); export them from one time on")
    return [Block(tuple(channels))]


def _enclosing(stem: str) -> list[str]:
    """Return a structure, those around it, and the file: ``rec.PAP``, ``rec`` and nothing."""
    names = stem.split(".")
    return [".".join(names[:count]) for count in range(len(names), -1, -1)]


def _rate(place: str, around: Sequence[Fields], count: int, typed: float | None) -> tuple[float, float]:
    """Return the samples a second of so many, nan where neither the file nor the user says, and when they begin, s."""
    rates = [_positive(place, level[name]) for level in around for name in RATE_NAMES if name in level]
    rates += [1 / _positive(place, level[name]) for level in around for name in _INTERVALS if name in level]
    begin = _number(around[0].get("start"), 0.0)
    for times in (around[0][name] for name in _TIMES if name in around[0] and around[0][name].size == count):
        steps = np.diff(vector(times, place))
        if not np.isfinite(steps).all() or not (steps > 0).all() or np.ptp(steps) > 0.5 * steps.mean():
            raise InputError(f"{place}: its times are not even; export it without gaps, or with a rate")
        rates.append(1 / float(steps.mean()))
        begin = float(np.ravel(times)[0])
    if typed is not None and not np.isnan(typed):
        rates.append(typed)
    if not rates:
        return np.nan, begin
    if max(rates) / min(rates) - 1 > MAX_RATE_DIFFERENCE:
        texts = ", ".join(dict.fromkeys(f"{rate:g}" for rate in rates))
        raise InputError(f"{place}: different rates are said ({texts} samples/s); keep one of them")
    return rates[0], begin


def _positive(place: str, value: np.ndarray) -> float:
    number = _number(value, np.nan)
    if value.size > 1 and np.isnan(number):
        raise InputError(f"{place}: {value.size} numbers where the rate, or the interval between samples, is one")
    if not 1e-9 < number < 1e9:
        raise InputError(
            f"{place}: '{text(value) or f'{number:g}'}' is not a rate or interval between samples; write a number"
        )
    return number


def _number(value: np.ndarray | None, otherwise: float) -> float:
    is_number = value is not None and value.size == 1 and value.dtype.kind in "iuf"
    return float(np.ravel(value)[0]) if is_number else otherwise  # type: ignore[arg-type]


RECORDINGS.register(
    RecordingFormat(
        "mat structures", "MATLAB file with a structure a channel", (".mat",), is_structured,
        lambda path, rate, progress: read_structures(path, rate),
    )
)  # fmt: skip
