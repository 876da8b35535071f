"""The text export of Spike2: one section a channel, a value a line; its spreadsheet text is a table like any other."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind
from vasowave.base.io.cells import is_number
from vasowave.base.io.remembered import remembered
from vasowave.base.io.textfile import Progress, read_lines
from vasowave.catheter.read.formats import RECORDINGS, RecordingFormat
from vasowave.catheter.signals.channels import CUT_OFF, Block, Channel

_MAX_RATE_DIFFERENCE = 0.01  # between the summary, which is rounded, and the interval of a channel
UNEQUAL = look_kind(
    "recording.unequal-channels",
    "'{title}' has {count} samples, another channel at its rate {usual}: lines may be missing, or doubled",
    "Export the file again, all channels over one stretch.",
)
_MAX_SAMPLES = 1 << 28  # of a channel with its gaps


def is_spike2_text(start: bytes) -> bool:
    """Whether a file is such an export: its first line is ``"INFORMATION"``."""
    encoding = "utf-16" if start[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    return start[:64].decode(encoding, errors="replace").lstrip().startswith('"INFORMATION"')


@dataclass(frozen=True)
class _Section:
    """A channel while it is read: what its head says, and its stretches, each with start and interval, s."""

    number: str
    head: list[list[str]] = field(default_factory=list)
    stretches: list[tuple[float, float, list[float]]] = field(default_factory=list)


@remembered
def read_spike2_text(path: Path, progress: Progress | None = None) -> list[Block]:
    """Read the waveforms of a text export of Spike2; what is missing between stretches is a gap.

    Raises
    ------
    InputError
        Line of a value that is not a number; no waveform; a stretch without an interval.
    """
    summary: dict[str, list[str]] = {}
    sections: list[_Section] = []
    cut = False
    for lines in read_lines(path, progress):
        cut = lines.cut
        if cut:
            break  # nobody knows whether the last digit was written
        for line, text in enumerate(lines.texts, lines.first):
            cells = [cell.strip().strip('"').strip() for cell in text.split("\t")]
            if any(cells):
                _take(f"{path}, line {line}", cells, summary, sections)
    channels = [_channel(path, section, summary) for section in sections if section.stretches]
    if not channels:
        raise InputError(
            f"{path}: a text export of Spike2 without a waveform; tick the waveform channels and export it"
        )
    return [Block(tuple(channels), (), (*([CUT_OFF(what="it")] if cut else []), *_unequal(channels)), "Spike2")]


def _unequal(channels: Sequence[Channel]) -> list[Finding]:
    """Return a finding for every channel that has not as many samples as the longest at its rate."""
    longest: dict[float, int] = {}
    for channel in channels:
        rate = channel.sampling_rate
        longest[rate] = max(longest.get(rate, 0), len(channel.values))
    return [
        UNEQUAL(title=channel.title, count=len(channel.values), usual=longest[channel.sampling_rate])
        for channel in channels
        if len(channel.values) < longest[channel.sampling_rate]
    ]


def _take(place: str, cells: Sequence[str], summary: dict[str, list[str]], sections: list[_Section]) -> None:
    if cells[0] == "CHANNEL":
        sections.append(_Section(cells[1] if len(cells) > 1 else ""))
    elif not sections:
        if cells[0].isdigit() and len(cells) > 3:
            summary[cells[0]] = list(cells)
    elif cells[0] == "START":
        numbers = [_number(place, cell) for cell in cells[1:3]]
        if len(numbers) < 2 or not numbers[1] > 0:
            raise InputError(f"{place}: 'START' names no start and interval; export it again")
        sections[-1].stretches.append((numbers[0], numbers[1], []))
    elif sections[-1].stretches:
        sections[-1].stretches[-1][2].append(_number(place, cells[-1]))
    elif len(sections[-1].head) < 10:
        sections[-1].head.append(list(cells))


def _number(place: str, cell: str) -> float:
    try:
        return float(cell.replace(",", "."))
    except ValueError:
        raise InputError(f"{place}: '{cell}' is not a number") from None


def _channel(path: Path, section: _Section, summary: dict[str, list[str]]) -> Channel:
    """Return a channel; its title and unit stand in the summary, or in the fourth and fifth line of its section."""
    first, interval, _ = section.stretches[0]
    row = summary.get(section.number, ["", "", *(cells[0] for cells in section.head[2:4])])
    title, unit = (*row[2:4], "", "")[:2]
    place = f"{path}, channel '{title}'"
    stated = float(row[4]) if len(row) > 4 and is_number(row[4]) else 0.0
    if stated > 0 and abs(stated * interval - 1.0) > _MAX_RATE_DIFFERENCE:
        raise InputError(f"{place}: {1 / interval:.6g} samples/s, and the summary says {stated:.6g}; export it again")
    starts = [round((start - first) / interval) for start, _, _ in section.stretches]
    count = max(start + len(values) for start, (_, _, values) in zip(starts, section.stretches, strict=True))
    if min(starts) < 0 or not count <= _MAX_SAMPLES or any(step != interval for _, step, _ in section.stretches):
        raise InputError(f"{place}: its stretches do not follow each other at one interval; export it again")
    samples = np.full(count, np.nan)
    for start, (_, _, values) in zip(starts, section.stretches, strict=True):
        samples[start : start + len(values)] = values
    return Channel(title, unit, samples, 1.0 / interval, place)


RECORDINGS.register(
    RecordingFormat(
        "spike2 text", "Spike2 text export", (), lambda path, start: is_spike2_text(start),
        lambda path, rate, progress: read_spike2_text(path, progress=progress), continuous=True,
    )
)  # fmt: skip
