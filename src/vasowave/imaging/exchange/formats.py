"""The formats of centerlines: one module each, which registers what it reads."""

from dataclasses import dataclass
from typing import Literal

from vasowave.io.formats import Format, Registry


@dataclass(frozen=True)
class LinesFormat(Format):
    """How centerlines of one kind are known and read.

    Attributes
    ----------
    read : callable
        Takes a path, the file's unit of length, cm, and where lines part (``tube`` or ``identical``, see `merged`).
        Returns a `Skeleton`.
    ends : "auto" or "ball"
        How its lines end, see `as_extracted`.
    """

    ends: Literal["auto", "ball"] = "auto"


LINES = Registry[LinesFormat]("vasowave.imaging.exchange", "flat table")
"""Every format of centerlines."""
