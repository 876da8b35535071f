"""A flow that a scanner gated, one cycle of some phases, beside a continuous pressure: put onto each of its beats."""

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind
from vasowave.base.io.textfile import read_lines
from vasowave.catheter.beats.beats import find_beats
from vasowave.catheter.read.formats import read_signals
from vasowave.catheter.signals.channels import Channel
from vasowave.catheter.signals.raw import RawRecording
from vasowave.pulse.cycle.cycle import resample
from vasowave.pulse.cycle.waveform import advance, cycle_foot

GATED = look_kind(
    "recording.gated-flow",
    "the flow is one cycle of {count} phases{measured}; it was put onto every beat of the pressure ({rate:.4g} "
    "beats/min) by its foot, which the phases place to {error:.2g} ms ({percent:.2g} % of a beat, one SD); its mean "
    "was kept. {remedy}",
    "Intervals of fits allow for that. How the flow differs from beat to beat is not known: say the error of its gain "
    "(`flow_gain_sd`), and trust no "
    "more harmonics than half of the phases.",
)
MIN_PHASES, MAX_PHASES = 16, 64
"""Samples of a cycle: fewer carry less than seven harmonics, more are no scanner's."""

_MAX_SHARE = 0.1  # of the rows of a continuous recording, that a gated cycle beside it fills
_RATES = (25.0, 900.0)  # beats/min, where nothing tells the flow's own
_OWN_RANGE = 0.65, 1.5  # of the flow's own heart rate, in which that of the pressure lies
_FINE = 1024  # samples of a cycle from which those of a beat are taken
_HEART_RATE = re.compile(
    r"(?:heart\s*rate|\bHR)\b\s*(?:[\[(][^\])]*[\])])?\s*(?:[:=,;\t]|\bis\b|\bof\b|\bwas\b)?\s*(\d+(?:[.,]\d+)?)(?!\s*/)",
    re.IGNORECASE,
)
_PHASE_TIMES = re.compile(r"phase|trigger|frame|delay|time", re.IGNORECASE)


class GatedCycle(NamedTuple):
    """Samples of one cycle, in `unit`, and the heart rate, beats/min, at which it was measured, if that is told."""

    values: np.ndarray
    unit: str
    heart_rate: float | None


def gated_file(path: Path, unit: str | None, site: str, sheet: str, length: int) -> GatedCycle | None:
    """Return the cycle of a file of flow whose longest channel has `length` samples; None if these are too many."""
    if length > MAX_PHASES:
        return None
    (signal,) = read_signals(path, {"flow": unit}, site, sheet)
    lasts = None if signal.time is None else float(np.mean(np.diff(signal.time))) * len(signal.values)
    return _checked(path, signal.values, "ml/s", 60.0 / lasts if lasts else _told_rate(path))


def gated_channel(path: Path, flow: Channel, channels: Sequence[Channel]) -> GatedCycle | None:
    """Return the cycle in the first rows of a channel of a continuous table; None if it is no such channel."""
    count = int(np.isfinite(flow.values).sum())
    if not MIN_PHASES <= count <= min(MAX_PHASES, _MAX_SHARE * len(flow.values)):
        return None
    if not np.isfinite(flow.values[:count]).all():
        return None
    timed = [channel for channel in channels if _PHASE_TIMES.search(channel.title)
              and np.isfinite(channel.values).sum() == count and units.is_of(channel.unit, "time")]  # fmt: skip
    heart_rate = _told_rate(path)
    if timed:
        steps = np.diff(timed[0].values[:count]) * units.factor(timed[0].unit, "time")
        heart_rate = 60.0 / (float(steps.mean()) * count) if steps.min() > 0 else heart_rate
    return _checked(path, flow.values[:count], flow.unit, heart_rate)


def _checked(path: Path, values: np.ndarray, unit: str, heart_rate: float | None) -> GatedCycle:
    if len(values) < MIN_PHASES:
        raise InputError(f"{path}: {len(values)} phases of flow; at least {MIN_PHASES} a cycle are needed")
    return GatedCycle(values, unit, heart_rate if heart_rate and math.isfinite(heart_rate) else None)


def _told_rate(path: Path) -> float | None:
    """Return the heart rate, beats/min, that a line of words says."""
    lines = next(iter(read_lines(path))).texts[: 2 * MAX_PHASES]
    match = next((match for text in lines if (match := _HEART_RATE.search(text))), None)
    rate = float(match[1].replace(",", ".")) if match else math.nan
    return rate if _RATES[0] <= rate <= _RATES[1] else None


def place_error(count: int) -> float:
    """Return the SD of the place of a cycle of so many phases in the beat, as a share of it: one phase, evenly."""
    return 1.0 / (count * math.sqrt(12.0))


def on_beats(path: Path, pressure: Channel, cycle: GatedCycle) -> tuple[Channel, Finding, float]:
    """Return a flow that has a cycle in every beat of the pressure, foot upon foot, what is to be known of it, and the
    SD of its place, s.

    Raises
    ------
    InputError, NumericalError
        A gap in the pressure, or no beats in it.
    """
    rate = pressure.sampling_rate
    own_rate = cycle.heart_rate
    rates = _RATES if own_rate is None else (own_rate * _OWN_RANGE[0], own_rate * _OWN_RANGE[1])
    alone = RawRecording(pressure.values, np.zeros(len(pressure.values)), rate, source=str(path))
    beats = find_beats(alone, "pressure", rates)
    lasts = 60.0 / beats.heart_rate
    starts = np.concatenate([
        np.arange(beats.times[0] - lasts, -lasts, -lasts)[::-1], beats.times,
        np.arange(beats.times[-1] + lasts, alone.duration + 2 * lasts, lasts),
    ])  # fmt: skip
    beat = np.searchsorted(starts, alone.time, side="right") - 1
    phase = (alone.time - starts[beat]) / np.diff(starts)[beat]
    fine = resample(cycle.values, _FINE)
    fine = advance(fine, cycle_foot(cycle.values))
    values = np.interp(phase, np.arange(_FINE + 1) / _FINE, np.append(fine, fine[0]))
    count = len(cycle.values)
    error = place_error(count)
    finding = GATED(count=count, measured="" if own_rate is None else f", measured at {own_rate:.4g} beats/min",
                    rate=beats.heart_rate, error=1e3 * error * lasts, percent=100 * error)  # fmt: skip
    flow = replace(pressure, title="gated flow", unit=cycle.unit, values=values, place=f"{path}, gated flow")
    return flow, finding, error * lasts
