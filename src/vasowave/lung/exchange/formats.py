"""The formats of centerlines: one module each, which registers what it reads."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from vasowave.base.io.formats import Format, Registry
from vasowave.lung.exchange.section_areas import Sections


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
    sections : callable, optional
        Takes a path and the file's unit of length, cm; returns the sections that the file holds besides the lines.
    """

    ends: Literal["auto", "ball"] = "auto"
    sections: Callable[[Path, float], Sections | None] | None = None


LINES = Registry[LinesFormat]("vasowave.lung.exchange", "flat table")
"""Every format of centerlines."""
