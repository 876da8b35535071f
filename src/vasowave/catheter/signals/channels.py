"""Continuous channels as a file holds them, before anyone says which is pressure, flow or ECG."""

from dataclasses import dataclass, replace

import numpy as np

from vasowave.base.cures import STRETCH
from vasowave.base.findings import Finding, look_kind

CUT_OFF = look_kind(
    "recording.cut-off",
    "the last line has no line end, so the file may have been cut off; {what} was left out",
    "Export the file again.",
)
MISSING = look_kind(
    "recording.missing-codes",
    "'{title}': {count} samples are {code:g}, far from all others, as programs write a missing value; they are gaps",
    "Leave such cells empty, and choose a stretch without them.",
    STRETCH,
)
_MISSING_CODES = (-999.0, -9999.0, -99999.0)  # written by programs in place of a sample that is missing
_MIN_SLOW_SAMPLES = 4  # of a slower channel among blanks
_MIN_CODE_DISTANCE = 3.0  # times the range of all others below them


RATES_DIFFER = look_kind(
    "recording.rates-differ",
    "the file says {stated:g} samples/s, its times {measured:g}; the times were taken. {remedy}",
    "Look which is right: the heart rate tells.",
)
_MAX_STATED_DIFFERENCE = 0.01  # between a rate that is stated and that of the times, as a share


def rates_differ(stated: float | None, measured: float) -> tuple[Finding, ...]:
    """Return that a rate that a file states, if it does, is not that of its times."""
    if not stated or not abs(measured / stated - 1) > _MAX_STATED_DIFFERENCE:
        return ()
    return (RATES_DIFFER(stated=stated, measured=measured),)


@dataclass(frozen=True, eq=False)
class Channel:
    """One channel of one block: its values in the file's own unit.

    Attributes
    ----------
    title, unit : str
        As written in the file; `unit` is empty where none is stated.
    values : float array, shape (sample,)
        A gap is NaN.
    sampling_rate : float
        Samples per second.
    place : str
        What errors call the channel: ``FILE, block 2, channel 'PAP'``.
    """

    title: str
    unit: str
    values: np.ndarray
    sampling_rate: float
    place: str

    @property
    def duration(self) -> float:
        """Length of the channel, s."""
        return len(self.values) / self.sampling_rate


@dataclass(frozen=True)
class Comment:
    """A remark made during the recording.

    Attributes
    ----------
    time : float
        Since the start of the block, s.
    text : str
    channel : int
        Number of the channel it belongs to, counted from 1; 0 for all.
    """

    time: float
    text: str
    channel: int = 0


@dataclass(frozen=True, eq=False)
class Block:
    """A stretch of uninterrupted recording.

    Attributes
    ----------
    channels, comments : tuples
    suspicions : tuple of Finding
        What of the file looks as if it were not whole.
    program : str
        Whose export it is, empty if nothing tells.
    start : float, optional
        What the clock of the file shows at the first sample, s.
    sheet : str
        Of a workbook.
    """

    channels: tuple[Channel, ...]
    comments: tuple[Comment, ...] = ()
    suspicions: tuple[Finding, ...] = ()
    program: str = ""
    start: float | None = None
    sheet: str = ""

    @property
    def duration(self) -> float:
        """Length of the longest channel, s."""
        return max((channel.duration for channel in self.channels), default=0.0)


def without_codes(block: Block) -> Block:
    """Return a block in which samples that stand for a missing value, as -999 does, are gaps, and say so."""
    channels, suspicions = [], list(block.suspicions)
    for channel in block.channels:
        code = float(np.nanmin(channel.values, initial=np.inf))
        if code in _MISSING_CODES:
            missing = channel.values == code
            valid = channel.values[~missing & np.isfinite(channel.values)]
            if len(valid) and valid.min() - code > _MIN_CODE_DISTANCE * np.ptp(valid):
                suspicions.append(MISSING(title=channel.title, count=int(missing.sum()), code=code))
                channel = replace(channel, values=np.where(missing, np.nan, channel.values))
        channels.append(channel)
    return replace(block, channels=tuple(channels), suspicions=tuple(suspicions))


def at_their_rates(block: Block) -> Block:
    """Return a block in which a channel that has a sample in every so many rows, and blanks between, has its rate."""
    return replace(block, channels=tuple(map(_at_its_rate, block.channels)))


def _at_its_rate(channel: Channel) -> Channel:
    places = np.flatnonzero(np.isfinite(channel.values))
    if len(places) < _MIN_SLOW_SAMPLES or places[0] or places[1] == 1:
        return channel
    stride = int(places[1])
    if np.any(np.diff(places) != stride) or len(channel.values) - places[-1] > stride:
        return channel
    return replace(channel, values=channel.values[::stride], sampling_rate=channel.sampling_rate / stride)
