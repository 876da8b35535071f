"""European Data Format, EDF and EDF+ (Kemp et al. 1992; Kemp & Olivan 2003), and BioSemi's BDF of 24 bits.

A header of 256 bytes, 256 more for each signal, then data records of equal length; a record holds, signal after signal,
the samples of one stretch of time. Physical value = (digital - digital minimum) · gain + physical minimum. EDF+ hides
annotations and, in the discontinuous variant (EDF+D), the start of every record in a signal of its own.
"""

import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.remembered import remembered
from vasowave.base.io.textfile import read_bytes
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat
from vasowave.catheter.signals.channels import Block, Channel, Comment

_ANNOTATIONS = ("EDF Annotations", "BDF Annotations")
_BDF = b"\xffBIOSEMI"
_FIELDS = (
    ("label", 16), ("transducer", 80), ("unit", 8), ("physical_minimum", 8), ("physical_maximum", 8),
    ("digital_minimum", 8), ("digital_maximum", 8), ("filter", 80), ("samples", 8), ("reserved", 32),
)  # fmt: skip


@dataclass(frozen=True)
class _Signal:
    label: str
    unit: str
    offset: float
    gain: float
    samples: int
    first: int
    """Samples of a record that precede this signal's."""


def is_edf(content: bytes) -> bool:
    """Return whether a file begins as EDF or BDF does."""
    return len(content) >= 256 and content[:8] in (b"0       ", _BDF)


@remembered
def read_edf(path: str | Path) -> list[Block]:
    """Read all signals of an EDF, EDF+ or BDF file; a discontinuous one (EDF+D) gives a block for every stretch.

    Annotations become comments. Channels keep their own sampling rates.

    Raises
    ------
    InputError
        A header that contradicts itself or the length of the file, with the field and the signal.
    """
    content = read_bytes(path)
    if not is_edf(content):
        raise InputError(f"{path}: not an EDF file (it does not begin with version 0)")
    size, count, duration, signals = _header(path, content)
    bytes_each = 3 if content.startswith(_BDF) else 2
    width = sum(signal.samples for signal in signals)
    stated, held = count, (len(content) - size) // (bytes_each * width)
    if stated == -1:
        count = held
    if (len(content) - size) != bytes_each * width * count:
        raise InputError(
            f"{path}: the header states {stated} records of {bytes_each * width} bytes, the file holds "
            f"{(len(content) - size) / (bytes_each * width):.5g}; it was cut off or damaged, export it again"
        )
    records = np.frombuffer(content, np.uint8, offset=size).reshape(count, width, bytes_each)
    starts, comments = _annotations(path, records, signals, duration)
    blocks = []
    for first, last in _stretches(starts, duration):
        channels = tuple(
            _channel(path, signal, records[first:last], duration)
            for signal in signals
            if signal.label not in _ANNOTATIONS
        )
        end = starts[last - 1] + duration
        inside = (c for c in comments if starts[first] <= c.time < end)
        blocks.append(Block(channels, tuple(Comment(c.time - starts[first], c.text) for c in inside)))
    return blocks


def _header(path: str | Path, content: bytes) -> tuple[int, int, float, list[_Signal]]:
    """Return the header's size, number of records (-1 if unknown), duration of a record (s) and the signals."""
    size = _whole(path, content[184:192], "number of bytes in the header")
    count = _whole(path, content[236:244], "number of data records")
    duration = _number(path, content[244:252], "duration of a data record")
    number = _whole(path, content[252:256], "number of signals")
    if number < 1 or size != 256 * (number + 1) or len(content) < size:
        raise InputError(
            f"{path}: a header of {size} bytes for {number} signals in a file of {len(content)}; "
            f"{256 * (number + 1)} are needed: the file was cut off or damaged, export it again"
        )
    if count < -1 or count == 0:
        raise InputError(f"{path}: {count} data records in the header; there is nothing to read")
    if duration < 0:
        raise InputError(f"{path}: a data record lasts {duration:g} s; export it again")
    table, offset = {}, 256
    for name, width in _FIELDS:
        table[name] = [content[offset + i * width : offset + (i + 1) * width] for i in range(number)]
        offset += number * width
    signals: list[_Signal] = []
    for i in range(number):
        first = signals[-1].first + signals[-1].samples if signals else 0
        limit = 1 << (23 if content.startswith(_BDF) else 15)
        signals.append(_signal(path, {name: column[i] for name, column in table.items()}, i, first, limit))
    if duration == 0 and any(signal.label not in _ANNOTATIONS for signal in signals):
        raise InputError(f"{path}: a data record lasts 0 s, so the sampling rate is unknown; export it again")
    return size, count, duration, signals


def _signal(path: str | Path, raw: dict[str, bytes], index: int, first: int, limit: int) -> _Signal:
    label = _text(raw["label"])
    place = f"{path}, signal {index + 1} '{label}'"
    low, high = (_number(place, raw[f"physical_{end}"], f"physical {end}") for end in ("minimum", "maximum"))
    bottom, top = (_whole(place, raw[f"digital_{end}"], f"digital {end}") for end in ("minimum", "maximum"))
    samples = _whole(place, raw["samples"], "number of samples in a record")
    if samples < 1:
        raise InputError(f"{place}: {samples} samples in a record; export it again")
    if not -limit <= bottom < top < limit:
        raise InputError(f"{place}: digital range {bottom} to {top}; it must increase from {-limit} to {limit - 1}")
    if low == high:
        raise InputError(f"{place}: physical minimum and maximum are both {low:g}; calibrate the channel, export again")
    gain = (high - low) / (top - bottom)
    return _Signal(label, _text(raw["unit"]), low - gain * bottom, gain, samples, first)


def _channel(path: str | Path, signal: _Signal, records: np.ndarray, duration: float) -> Channel:
    digital = whole_numbers(records[:, signal.first : signal.first + signal.samples])
    place = f"{path}, channel '{signal.label}'"
    return Channel(signal.label, signal.unit, digital * signal.gain + signal.offset, signal.samples / duration, place)


def whole_numbers(content: np.ndarray) -> np.ndarray:
    """Return the signed numbers of 1 to 4 bytes each, low byte first, shape (..., bytes), that raw bytes hold, flat."""
    padded = np.zeros((content[..., 0].size, 4), np.uint8)
    padded[:, 4 - content.shape[-1] :] = content.reshape(-1, content.shape[-1])  # the sign bit on top
    return padded.view("<i4").ravel() >> (8 * (4 - content.shape[-1]))


def _annotations(
    path: str | Path, records: np.ndarray, signals: list[_Signal], duration: float
) -> tuple[np.ndarray, list[Comment]]:
    """Return the start of every record (s since the first) and all remarks."""
    starts = np.arange(len(records)) * duration
    channels = [signal for signal in signals if signal.label in _ANNOTATIONS]
    remarks: list[tuple[float, str]] = []
    for number, record in enumerate(records):
        for index, signal in enumerate(channels):
            lists = record[signal.first : signal.first + signal.samples].tobytes().split(b"\0")
            for position, entry in enumerate(annotation for annotation in lists if annotation):
                onset, texts = _entry(path, entry, number)
                if index == 0 and position == 0 and not texts[0]:
                    starts[number], texts = onset, texts[1:]
                remarks += [(onset, text) for text in texts if text]
    if np.any(np.diff(starts) < duration * (1 - 1e-6)):
        raise InputError(f"{path}: data records overlap in time; the file is damaged, export it again")
    return starts - starts[0], [Comment(onset - starts[0], text) for onset, text in remarks]


def _entry(path: str | Path, entry: bytes, record: int) -> tuple[float, list[str]]:
    """Return onset and texts of one time-stamped list: ``+onset[\\x15duration]\\x14text\\x14``."""
    head, *texts = entry.split(b"\x14")
    onset = head.split(b"\x15")[0]
    if not texts or not re.fullmatch(rb"[+-]\d{1,12}(\.\d*)?", onset):
        raise InputError(f"{path}, data record {record + 1}: a damaged annotation; export the file again")
    return float(onset), [text.decode("utf-8", errors="replace").strip() for text in texts]


def _stretches(starts: np.ndarray, duration: float) -> list[tuple[int, int]]:
    """Return first and last (exclusive) record of every uninterrupted stretch."""
    gaps = np.flatnonzero(np.abs(np.diff(starts) - duration) > 1e-4 * duration) + 1
    edges = [0, *gaps.tolist(), len(starts)]
    return list(pairwise(edges))


def _text(raw: bytes) -> str:
    return raw.decode("latin-1").strip(" \0")


def _number(place: str | Path, raw: bytes, field: str) -> float:
    text = _text(raw)
    try:
        value = float(text.replace(",", ".")) if "_" not in text else np.nan
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise InputError(f"{place}: {field} is '{text}', not a number; the header is damaged, export it again")
    return value


def _whole(place: str | Path, raw: bytes, field: str) -> int:
    value = _number(place, raw, field)
    if value != int(value):
        raise InputError(f"{place}: {field} is {value:g}, not a whole number; the header is damaged, export it again")
    return int(value)


RECORDINGS.register(
    RecordingFormat(
        "edf", "EDF", (".edf", ".rec", ".bdf"), lambda path, start: is_edf(start),
        lambda path, rate, progress: read_edf(path), continuous=True,
    )
)  # fmt: skip
