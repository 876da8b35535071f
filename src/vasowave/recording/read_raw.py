"""Read a continuous recording of pressure, flow and ECG from the files a lab has."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from vasowave import units
from vasowave.columns import read_columns
from vasowave.errors import InputError, did_you_mean
from vasowave.recording.channels import Block, Channel, read_bytes
from vasowave.recording.edf import is_edf, read_edf
from vasowave.recording.labchart_mat import read_labchart_mat
from vasowave.recording.labchart_text import is_labchart_text, read_labchart_text
from vasowave.recording.raw import RawRecording
from vasowave.recording.signal import ALIASES, Signal, even_step, written_to

_QUANTITIES = {"pressure": "pressure", "flow": "flow", "ecg": "voltage"}
_WORDS = {
    "pressure": ("pressure", "press", "pap", "mpap", "ppa", "p"),
    "flow": ("flow", "flow rate", "flowrate", "q"),
    "ecg": ("ecg", "ekg"),
}
_ADICHT = (
    "LabChart's own binary file, which only LabChart opens. In LabChart: open it, select the stretch to use (nothing "
    "means all), File > Export…, 'Save as type': 'LabChart Text File (*.txt)' or 'MATLAB File (*.mat)', Save; in the "
    "dialog tick time, comments and the block header, do not downsample. Then read the exported file"
)


def read_raw_recording(
    path: str | Path,
    *,
    pressure: str | None = None,
    flow: str | None = None,
    ecg: str | None = None,
    pressure_unit: str | None = None,
    flow_unit: str | None = None,
    block: int | None = None,
    start: float | None = None,
    end: float | None = None,
    sampling_rate: float | None = None,
) -> RawRecording:
    """Read continuous pressure, flow and (if present) ECG from one file.

    Parameters
    ----------
    path : path
        A CSV, TSV or blank-separated table whose header names columns and units (``time [s]``, ``pressure [mmHg]``,
        ``flow [ml/s]``, ``ecg [mV]``), LabChart's text or MATLAB export, or EDF/EDF+.
    pressure, flow, ecg : str, optional
        Titles of the channels; needed where no title, or more than one, says what it holds.
    pressure_unit, flow_unit : str, optional
        Units of channels for which the file names none (in LabChart: for which no units conversion was set).
    block : int, optional
        Which block to read, counted from 1; by default the longest (a note says which).
    start, end : float, optional
        Stretch to read, s since the start of the block. Gaps elsewhere do not matter then.
    sampling_rate : float, optional
        Samples per second of a table without a time column.

    Raises
    ------
    InputError
        File, block, line or channel of what is wrong, and the cure; for an ``.adicht`` file, how to export it.
    """
    blocks = _blocks(path, sampling_rate)
    number, note = _choose(path, blocks, block)
    chosen = blocks[number]
    picked = {
        "pressure": _pick(path, chosen, "pressure", pressure),
        "flow": _pick(path, chosen, "flow", flow),
        "ecg": _pick(path, chosen, "ecg", ecg),
    }
    rate = max(channel.sampling_rate for channel in picked.values() if channel)
    given = {"pressure": pressure_unit, "flow": flow_unit, "ecg": None}
    signals, notes = {}, note
    for name, channel in picked.items():
        if channel is None:
            notes.append("no ECG: beats can be found from the pressure only")
            continue
        values, words = _canonical(channel, name, given[name])
        values = _stretch(channel, values, start, end)
        signals[name], more = _at_rate(values, channel, rate)
        notes += words + more
    count = min(map(len, signals.values()))
    origin = start or 0.0
    last = origin + count / rate
    comments = tuple(replace(c, time=c.time - origin) for c in chosen.comments if origin <= c.time <= last)
    return RawRecording(
        pressure=signals["pressure"][:count],
        flow=signals["flow"][:count],
        sampling_rate=rate,
        ecg=signals["ecg"][:count] if "ecg" in signals else None,
        source=str(path),
        notes=tuple(notes),
        comments=comments,
    )


def _blocks(path: str | Path, sampling_rate: float | None) -> list[Block]:
    suffix = Path(path).suffix.lower()
    if suffix in (".adicht", ".adidat", ".adibin"):
        raise InputError(f"{path}: {_ADICHT}")
    if suffix == ".mat":
        blocks = read_labchart_mat(path)
    elif suffix == ".edf" or is_edf(read_bytes(path)):
        blocks = read_edf(path)
    elif is_labchart_text(read_bytes(path)):
        blocks = read_labchart_text(path)
    else:
        blocks = [_table(path, sampling_rate)]
    if not blocks:
        raise InputError(f"{path}: headers and no samples")
    return blocks


def _table(path: str | Path, sampling_rate: float | None) -> Block:
    table = read_columns(path, ALIASES | {"ekg": "ecg"})
    if not table.names:
        raise InputError(f"{path}: no header; the first line must read: time [s],pressure [mmHg],flow [ml/s],ecg [mV]")
    column = table.find("time")
    if column is None and sampling_rate is None:
        raise InputError(f"{path}: no time column; give sampling_rate, in samples per second")
    if column is not None:
        time = table.numbers(column, "time")
        if len(time) < 2:
            raise InputError(f"{path}: one sample only; a continuous recording is needed")
        quantum = written_to([row[column] for row in table.cells]) * units.factor(table.units[column], "time")
        places = tuple(f"{path}, line {line}" for line in table.lines)
        measured = 1.0 / even_step(Signal("time", time, time, quantum, str(path), places))
        if sampling_rate is not None and abs(sampling_rate - measured) > 1e-3 * measured:
            raise InputError(f"{path}: the time column has {measured:.6g} samples/s, given are {sampling_rate:.6g}")
        sampling_rate = measured
    assert sampling_rate is not None
    channels = []
    for index, (title, unit) in enumerate(zip(table.names, table.units, strict=True)):
        if index != column:
            place = f"{path}, channel '{title}'"
            values = _floats([row[index] for row in table.cells], table.lines, place)
            channels.append(Channel(title, unit, values, sampling_rate, place, table.lines[0]))
    return Block(tuple(channels))


def _floats(cells: Sequence[str], lines: Sequence[int], place: str) -> np.ndarray:
    values = np.empty(len(cells))
    for i, text in enumerate(cells):
        try:
            values[i] = float(text) if text.strip() else np.nan
        except ValueError:
            raise InputError(f"{place}, line {lines[i]}: '{text}' is not a number") from None
    return values


def _choose(path: str | Path, blocks: list[Block], block: int | None) -> tuple[int, list[str]]:
    """Return the index of the block to read and a note if a choice was made."""
    if block is not None:
        if not 1 <= block <= len(blocks):
            raise InputError(f"{path}: no block {block}; it has {len(blocks)}")
        return block - 1, []
    longest = max(range(len(blocks)), key=lambda i: blocks[i].duration)
    if len(blocks) == 1:
        return 0, []
    lengths = ", ".join(f"{one.duration:.4g} s" for one in blocks)
    return longest, [f"block {longest + 1} of {len(blocks)} was read, the longest (blocks last {lengths})"]


def _pick(path: str | Path, block: Block, name: str, title: str | None) -> Channel | None:
    """Return the channel called `title`, or the one whose title says that it holds `name`."""
    present = ", ".join(f"'{c.title}' [{c.unit or 'no unit'}]" for c in block.channels)
    if title is not None:
        hits = [c for c in block.channels if c.title.strip().lower() == title.strip().lower()]
        hint = did_you_mean(title, [c.title for c in block.channels])
        if not hits:
            raise InputError(f"{path}: no channel '{title}'{hint}; it has: {present}")
    else:
        hits = [c for c in block.channels if c.title.strip().lower() in _WORDS[name]]
        hits = hits or [c for c in block.channels if set(c.title.lower().split()) & set(_WORDS[name])]
    if len(hits) > 1:
        raise InputError(f"{path}: {len(hits)} channels may hold {name}; name one, {name}='TITLE'; it has: {present}")
    if not hits and name != "ecg":
        raise InputError(f"{path}: no channel says that it holds {name}; name it, {name}='TITLE'; it has: {present}")
    return hits[0] if hits else None


def _canonical(channel: Channel, name: str, given: str | None) -> tuple[np.ndarray, list[str]]:
    """Return the values in the canonical unit, and what was assumed."""
    quantity = _QUANTITIES[name]
    unit = channel.unit
    if name == "ecg" and not unit:
        return channel.values, ["the ECG has no unit; only its shape is used"]
    unconverted = name != "ecg" and (not unit or unit in ("V", "mV", "µV", "μV", "uV"))
    if unconverted:
        if given is None:
            raise InputError(
                f"{channel.place}: {name} is in {unit or 'no unit'}; set the units conversion in the recording program "
                f"and export again, or, if the numbers are {name} already, give {name}_unit"
            )
        return channel.values * units.factor(given, quantity), [f"{name} was taken to be in {given}, as given"]
    try:
        scale = units.factor(unit, quantity)
    except InputError as error:
        raise InputError(f"{channel.place}: {error}") from None
    if given is not None and units.factor(given, quantity) != scale:
        raise InputError(f"{channel.place}: the file says {unit}, {name}_unit says {given}; keep one")
    return channel.values * scale, []


def _stretch(channel: Channel, values: np.ndarray, start: float | None, end: float | None) -> np.ndarray:
    """Return the samples from `start` to `end`, none of which may be a gap."""
    lasts = len(values) / channel.sampling_rate
    first = round((start or 0.0) * channel.sampling_rate)
    last = len(values) if end is None else round(end * channel.sampling_rate)
    if start is not None and end is not None and end <= start:
        raise InputError(f"{channel.place}: the stretch ends at {end:g} s and starts at {start:g} s; exchange them")
    if not 0 <= first < last <= len(values):
        raise InputError(f"{channel.place}: {start or 0:g} to {end or lasts:g} s does not lie in 0 to {lasts:.5g} s")
    gaps = np.flatnonzero(~np.isfinite(values[first:last]))
    if len(gaps):
        raise InputError(
            f"{channel.where(first + int(gaps[0]))}: a gap ({len(gaps)} samples without a value in all); "
            "choose a stretch without gaps with start and end"
        )
    return values[first:last]


def _at_rate(values: np.ndarray, channel: Channel, rate: float) -> tuple[np.ndarray, list[str]]:
    """Return the values at the rate of the fastest channel, by cubic splines."""
    if abs(channel.sampling_rate - rate) <= 1e-9 * rate:
        return values, []
    from scipy.interpolate import CubicSpline

    if len(values) < 4:
        raise InputError(f"{channel.place}: {len(values)} samples; a continuous recording is needed")
    there = np.arange(int(len(values) * rate / channel.sampling_rate)) / rate
    there = there[there <= (len(values) - 1) / channel.sampling_rate]
    spline = CubicSpline(np.arange(len(values)) / channel.sampling_rate, values)
    return spline(there), [f"'{channel.title}' was interpolated from {channel.sampling_rate:g} to {rate:g} samples/s"]
