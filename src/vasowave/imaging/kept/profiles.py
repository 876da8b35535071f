"""Sections of vessels, and beside them, that are known already: far from an edit they show the same as before."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from vasowave.imaging.measure.beside import reach_beside, signal_beside
from vasowave.imaging.measure.profiles import CLEARANCE, RING, Profile, profile
from vasowave.imaging.read.volume import Volume
from vasowave.imaging.tree import Line
from vasowave.runtime.kept import digest_of


class Profiles:
    """Looks at the sections of vessels as `profile` does, and remembers what it has seen of one image.

    Parameters
    ----------
    known : tuple of pairs
        What was seen before: the digest of all that decides a value, and the value.
    """

    def __init__(self, known: tuple[tuple[str, Profile | float | None], ...] = ()) -> None:
        self._known = dict(known)
        self._used: dict[str, Profile | float | None] = {}

    def __call__(
        self, line: Line, sections: np.ndarray, radius: float, volume: Volume, others: Sequence[Line] = ()
    ) -> Profile | None:
        """Return the profile, see `profile`."""
        near = _near(line, radius + RING * volume.spacing[0], others, CLEARANCE * volume.spacing[0])
        key = digest_of("profile", line, sections, radius, near)
        return self._recalled(key, lambda: profile(line, sections, radius, volume, others))

    def beside(self, line: Line, sections: np.ndarray, radius: float, volume: Volume, vessels: Line) -> float:
        """Return the noise beside the vessel, see `signal_beside`."""
        spacing = float(volume.spacing[0])
        reach = reach_beside(radius, spacing) + float(vessels.radius.max()) + spacing
        low, high = line.points.min(axis=0) - reach, line.points.max(axis=0) + reach
        near = ((vessels.points > low) & (vessels.points < high)).all(axis=1)
        key = digest_of("beside", line, sections, radius, vessels.points[near], vessels.radius[near])
        return self._recalled(key, lambda: signal_beside(line, sections, radius, volume, vessels))

    def _recalled(self, key: str, make: Callable[[], Any]) -> Any:
        if key not in self._known:
            self._known[key] = make()
        self._used[key] = self._known[key]
        return self._known[key]

    @property
    def used(self) -> tuple[tuple[str, Profile | float | None], ...]:
        """What was asked for."""
        return tuple(self._used.items())


def _near(line: Line, outer: float, others: Sequence[Line], margin: float) -> list[Line]:
    """Return those of `others` whose tubes may come into sections of `line` that reach to `outer`."""
    low, high = line.points.min(axis=0) - outer - margin, line.points.max(axis=0) + outer + margin
    return [
        other
        for other in others
        if ((other.points + other.radius.max() > low) & (other.points - other.radius.max() < high)).all(axis=1).any()
    ]
