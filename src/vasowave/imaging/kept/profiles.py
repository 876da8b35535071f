"""What is known already of sections of vessels, beside them, and of junctions: far from an edit it is as before."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from vasowave.imaging.measure.profiles import CLEARANCE, RING, Profile, profile, reach_beside, signal_beside
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

    def __init__(self, known: tuple[tuple[str, Any], ...] = ()) -> None:
        self._known = dict(known)
        self._used: dict[str, Any] = {}

    def __call__(
        self, line: Line, sections: np.ndarray, radius: float, volume: Volume, others: Sequence[Line] = ()
    ) -> Profile | None:
        """Return the profile, see `profile`."""
        near = _near(line, radius + RING * volume.spacing[0], others, CLEARANCE * volume.spacing[0])
        what = ("profile", line, sections, radius, near)
        return self.recalled(what, lambda: profile(line, sections, radius, volume, others))

    def beside(self, line: Line, sections: np.ndarray, radius: float, volume: Volume, vessels: Line) -> float:
        """Return the noise beside the vessel, see `signal_beside`."""
        reach = reach_beside(radius, float(volume.spacing[0]))
        low, high = line.points.min(axis=0) - reach, line.points.max(axis=0) + reach
        wide = vessels.radius[:, None]
        near = vessels[((vessels.points + wide > low) & (vessels.points - wide < high)).all(axis=1)]
        what = ("beside", line, sections, radius, near)
        return self.recalled(what, lambda: signal_beside(line, sections, radius, volume, near))

    def recalled(self, what: tuple[Any, ...], make: Callable[[], Any]) -> Any:
        """Return what `make` returns, or returned before where `what` decides of it was the same."""
        key = digest_of(*what)
        if key not in self._known:
            self._known[key] = make()
        self._used[key] = self._known[key]
        return self._known[key]

    @property
    def used(self) -> tuple[tuple[str, Any], ...]:
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
