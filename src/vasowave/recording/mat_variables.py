"""Signals that are variables of a MATLAB file, each a vector: ``pressure``, ``flow``, ``time``; ``pressure_unit``."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vasowave import units
from vasowave.errors import InputError
from vasowave.recording.channels import Block, Channel
from vasowave.recording.gaps import leaps_closed, with_gaps
from vasowave.recording.matlab import read_mat, text, vector
from vasowave.recording.plausibility import PERIODS
from vasowave.recording.signal import ALIASES, even_step


def read_variables(path: str | Path, sampling_rate: float | None = None) -> Block:
    """Return the vectors of a MATLAB file as channels; without ``time`` or a rate their rate is nan.

    Raises
    ------
    InputError
        No vectors, none as long as the times, or uneven times.
    """
    return _block(path, read_mat(path), sampling_rate)


def is_continuous(path: str | Path, variables: Mapping[str, Any]) -> bool:
    """Whether variables hold an ECG, or last longer than any heartbeat."""
    block = _block(path, variables, None)
    return block.duration > PERIODS[1] or any(channel.title in ("ecg", "ekg") for channel in block.channels)


def _block(path: str | Path, found: Mapping[str, Any], sampling_rate: float | None) -> Block:
    variables = {_plain(name): value for name, value in found.items()}
    written = {_plain(name): name for name in found}
    vectors = {
        name: vector(value, f"{path}: variable '{name}'")
        for name, value in variables.items()
        if np.asarray(value).dtype.kind in "iufb" and 1 < np.size(value) == max(np.shape(value))
    }
    stated = {name: text(variables.get(f"{name}_unit", "")) for name in vectors}
    rate, place = _rate(path, vectors.get("time"), stated.get("time", ""), sampling_rate)
    count = len(vectors["time"]) if "time" in vectors else None
    channels = tuple(
        Channel(name, stated[name], values if place is None else with_gaps(values, place), rate,
                f"{path}, variable '{written[name]}'")
        for name, values in vectors.items() if name != "time" and count in (None, len(values))
    )  # fmt: skip
    if not channels:
        raise InputError(f"{path}: no vectors; it has: {', '.join(variables) or 'nothing'}")
    return Block(channels)


def _plain(name: str) -> str:
    """Return the name of a variable as vasowave calls it: ``P_unit`` is pressure_unit."""
    stem, mark, _ = name.lower().partition("_unit")
    return ALIASES.get(stem, stem) + mark


def _rate(path: str | Path, time: np.ndarray | None, unit: str, given: float | None
          ) -> tuple[float, np.ndarray | None]:  # fmt: skip
    """Return samples per second, nan where nothing tells, and places if the times leap over gaps."""
    if time is None or len(time) < 2:
        return (np.nan if given is None else given), None
    time = time * units.factor(unit or "s", "time")
    leaps = leaps_closed(time)
    even = time if leaps is None else leaps[0]
    rounding = 4 * float(np.finfo(np.float64).eps) * float(np.abs(even).max())
    step = even_step(even, rounding, str(path), lambda row: f"{path}, time({row + 1})")
    return 1.0 / step, None if leaps is None else leaps[1]
