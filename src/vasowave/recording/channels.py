"""Continuous channels as a file holds them, before anyone says which is pressure, flow or ECG."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vasowave.errors import InputError


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
    first_line : int
        Line of the file with the first sample, 0 where the file has no lines.
    """

    title: str
    unit: str
    values: np.ndarray
    sampling_rate: float
    place: str
    first_line: int = 0

    def where(self, sample: int) -> str:
        """Return the words that lead a reader to one sample."""
        if self.first_line:
            return f"{self.place}, line {self.first_line + sample}"
        return f"{self.place}, {sample / self.sampling_rate:.4f} s after the start of the block"


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


@dataclass(frozen=True)
class Block:
    """A stretch of uninterrupted recording."""

    channels: tuple[Channel, ...]
    comments: tuple[Comment, ...] = ()

    @property
    def duration(self) -> float:
        """Length of the longest channel, s."""
        return max((len(c.values) / c.sampling_rate for c in self.channels), default=0.0)


def read_bytes(path: str | Path) -> bytes:
    """Return the content of a file; `InputError` if it cannot be read."""
    path = Path(path)
    try:
        return path.read_bytes()
    except OSError as error:
        reason = "is a folder" if path.is_dir() else (error.strerror or "cannot be read").lower()
        raise InputError(f"{path}: {reason}") from None
