"""WFDB records of PhysioNet: a header in text, ``.hea``, and samples beside it, ``.dat`` (its manual, header(5)).

The library wfdb was weighed: it brings pandas, aiohttp and soundfile along, for sums and shifts.
"""

import re
from collections.abc import Hashable, Sequence
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind
from vasowave.base.io.remembered import marks_of, remembered
from vasowave.base.io.textfile import read_bytes, regular_file
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat
from vasowave.catheter.read.formats.edf import whole_numbers
from vasowave.catheter.signals.channels import Block, Channel

_WHOLE, _DECIMAL = r"-?\d{1,9}", r"(?:\d{1,17}\.?\d{0,20}|\.\d{1,20})(?:[eE][+-]?\d{1,2})?"
_RECORD = re.compile(
    rf"[\w-]+(?P<several>/\d+)?\s+(?P<count>\d{{1,3}})"
    rf"(?:\s+(?P<rate>{_DECIMAL})(?:/\S*)?(?:\s+(?P<frames>\d{{1,9}})(?:\s.*)?)?)?"
)
_SIGNAL = re.compile(
    rf"(?P<file>[^\s/\\](?:[^/\\]{{0,99}}?[^\s/\\])?)\s+(?P<format>\d+)(?:x(?P<width>[1-9]\d{{0,3}}))?"
    rf"(?::(?P<skew>\d+))?(?:\+(?P<offset>\d{{1,9}}))?"
    rf"(?:\s+(?P<gain>-?{_DECIMAL})(?:\((?P<baseline>{_WHOLE})\))?(?:/(?P<unit>\S+))?"
    rf"(?:\s+\d+(?:\s+(?P<zero>{_WHOLE})(?:\s+{_WHOLE}(?:\s+(?P<sum>{_WHOLE})(?:\s+\d+(?:\s+(?P<title>.*))?)?)?)?)?)?)?"
)
CHECKSUM_DIFFERS = look_kind(
    "recording.checksum-differs",
    "the numbers of '{title}' do not add up to what the header says ({stated}, they make {sum}). {remedy}",
    "Copy the record again: its samples or its header were changed.",
)
_BITS = {"16": 16, "24": 24, "32": 32, "80": 8, "212": 12}
"""Of the numbers of the formats that are read; the lowest number stands for a missing sample."""


class _SignalLine(NamedTuple):
    """A signal as its line in the header says it."""

    file: str
    format: str
    offset: int
    width: int
    gain: float
    baseline: float
    unit: str
    title: str
    checksum: int
    """Of its numbers, in 16 bits; 0 where nobody reckoned it."""


def is_record(path: Path, start: bytes) -> bool:
    """Whether a file is the header of a record, or the samples beside one."""
    is_data = (
        path.suffix.lower() == ".dat" and (b"\0" in start or not start.isascii()) and path.with_suffix(".hea").is_file()
    )
    return is_data or path.suffix.lower() == ".hea"


def header_of(path: Path) -> Path:
    """Return the header of a record by its own name or that of its samples."""
    return path.with_suffix(".hea") if path.suffix.lower() == ".dat" else path


def files_of(path: Path) -> tuple[Path, ...]:
    """Return the header and the samples of a record, save the file that is given."""
    header = header_of(path)
    matches = map(_SIGNAL.fullmatch, _lines(header)[1:])
    names = dict.fromkeys(match["file"] for match in matches if match is not None)
    return tuple(file for file in (header, *(header.parent / name for name in names)) if file != path)


def read_record(path: Path) -> list[Block]:
    """Read all signals of a record; those with more samples a frame have their own rate.

    Raises
    ------
    InputError
        A header that says something else, a record of several segments, a format that is not known, samples that are
        missing, or fewer or more than the header says.
    """
    return _blocks(header_of(path), marks_of(files_of(header_of(path))))


def _lines(header: Path) -> list[str]:
    """Return the lines of a header that are no remarks."""
    lines = [text.strip() for text in read_bytes(header).decode("latin-1").splitlines()]
    return [text for text in lines if text and text[0] != "#"]


@remembered
def _blocks(header: Path, samples: Hashable) -> list[Block]:
    """Return what `read_record` does; `samples` changes with the files of samples."""
    lines = _lines(header)
    record = _RECORD.fullmatch(re.sub(rf"^{re.escape(header.stem)}(?=[ /])", "r", lines[0])) if lines else None
    if record is None or record["several"] or not 0 < int(record["count"]) < len(lines):
        several = (
            "a record of several segments; read one of them" if record and record["several"] else "no sound header"
        )
        raise InputError(f"{header}: {several} (name, number of signals, rate, then a line a signal)")
    rate = float(record["rate"] or 250)  # which the format takes where the header says none
    signals = [_signal(header, text) for text in lines[1 : int(record["count"]) + 1]]
    of_files = groupby(signals, key=lambda signal: signal.file)
    oddities: list[Finding] = []
    frames = int(record["frames"] or 0)
    channels = [channel for file, group in of_files
                for channel in _channels(header, file, list(group), rate, frames, oddities)]  # fmt: skip
    if not rate:
        raise InputError(f"{header}: a sampling rate of 0; copy the header again")
    return [Block(tuple(channels), (), tuple(oddities), "WFDB")]


def _signal(header: Path, text: str) -> _SignalLine:
    """Return the signal of a line; a unit that is not said is left empty, though the manual takes mV for it."""
    match = _SIGNAL.fullmatch(text)
    if match is None or match["format"] not in _BITS:
        raise InputError(f"{header}: '{text[:80]}' is not of a format that is read ({', '.join(_BITS)}); convert "
                         "the record with WFDB's xform, or export it as CSV with rdsamp -c -p -v")  # fmt: skip
    if int(match["skew"] or 0):
        raise InputError(f"{header}: '{text[:80]}' is skewed, {match['skew']} frames late; write the record again with "
                         "WFDB's xform, which takes that off")  # fmt: skip
    gain = float(match["gain"] or 0)
    unit = (match["unit"] or "") if gain else "counts"  # of a signal that nobody calibrated
    baseline, title = float(match["baseline"] or match["zero"] or 0), (match["title"] or "signal").strip()
    counts = int(match["offset"] or 0), int(match["width"] or 1)
    checksum = int(match["sum"] or 0)
    return _SignalLine(match["file"], match["format"], *counts, gain or 1.0, baseline, unit, title, checksum)


def _channels(
    header: Path, file: str, signals: Sequence[_SignalLine], rate: float, frames: int, oddities: list[Finding]
) -> list[Channel]:
    """Return the signals that share a file of samples, frame by frame; `oddities` gets what is odd about them."""
    form, offset = signals[0].format, signals[0].offset
    if any((signal.format, signal.offset) != (form, offset) for signal in signals):
        raise InputError(f"{header}: signals of {file} differ in format; copy the record again")
    numbers = _numbers(form, np.frombuffer(read_bytes(regular_file(header.parent / file)), np.uint8)[offset:])
    edges = np.cumsum([0, *(signal.width for signal in signals)])
    frames = frames or len(numbers) // int(edges[-1])
    if frames < 1 or not 0 <= len(numbers) - frames * edges[-1] <= (form == "212"):
        raise InputError(f"{header}: {file} has {len(numbers)} numbers where {frames} frames of {edges[-1]} are said; "
                         "copy it again")  # fmt: skip
    table, missing = numbers[: frames * edges[-1]].reshape(frames, -1), -(1 << (_BITS[form] - 1))
    channels = []
    for signal, first, last in zip(signals, edges, edges[1:], strict=False):
        digital = table[:, first:last].ravel()
        values = np.where(digital == missing, np.nan, (digital - signal.baseline) / signal.gain)
        place = f"{header}, signal '{signal.title}'"
        total = (int(digital.sum()) + (1 << 15)) % (1 << 16) - (1 << 15)
        if signal.checksum and (total - signal.checksum) % (1 << 16):
            oddities.append(CHECKSUM_DIFFERS(title=signal.title, stated=signal.checksum, sum=total))
        channels.append(Channel(signal.title, signal.unit, values, rate * signal.width, place))
    return channels


def _numbers(form: str, content: np.ndarray) -> np.ndarray:
    """Return the numbers in bytes: of two bytes and more, of one from -128 on, or pairs of 12 bits in three bytes."""
    if form == "80":
        return content.astype(np.int32) - 128
    count = 3 if form == "212" else _BITS[form] // 8
    is_odd = form == "212" and len(content) % 3 == 2  # a number stands alone at the end
    if is_odd:
        content = np.append(content, np.uint8(0))
    rows = content[: len(content) // count * count].reshape(-1, count)
    if form != "212":
        return whole_numbers(rows)
    low, shared, high = rows.astype(np.int32).T
    numbers = np.column_stack([low | (shared & 0x0F) << 8, high | (shared & 0xF0) << 4]).ravel()
    return (numbers - ((numbers & 0x800) << 1))[: len(numbers) - is_odd]


RECORDINGS.register(
    RecordingFormat(
        "wfdb", "WFDB record", (".hea",), is_record, lambda path, rate, progress: read_record(path), continuous=True,
        companions=files_of,
    )
)  # fmt: skip
