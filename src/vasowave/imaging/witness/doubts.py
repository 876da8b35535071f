"""A doubt about an answer: what contradicts it, where, and which vessels it concerns."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from vasowave.findings import Finding

About = Literal["topology", "length", "radius", "loop"]


@dataclass(frozen=True, eq=False)
class Doubt:
    """One thing in the image that the answer does not explain, or one number that it does not settle.

    Attributes
    ----------
    about : "topology", "length", "radius" or "loop"
        What may be wrong; "loop": whatever depends on where a ring of the lumen is cut.
    finding : Finding
        What was seen and what to do.
    vessels : tuple of str
        Names of the vessels that may be wrong.
    places : float array, shape (place, 3)
        Where, z, y, x, cm; may be empty.
    """

    about: About
    finding: Finding
    vessels: tuple[str, ...] = ()
    places: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))

    @property
    def text(self) -> str:
        """The finding in words."""
        return str(self.finding)
