"""Profiles of vessels that are known already: a vessel far from an edit shows the same sections as before."""

from collections.abc import Sequence

import numpy as np

from vasowave.imaging.measure.profiles import CLEARANCE, RING, Profile, profile
from vasowave.imaging.read.volume import Volume
from vasowave.imaging.tree import Line
from vasowave.runtime.kept import digest_of


class Profiles:
    """Looks at the sections of vessels as `profile` does, and remembers what it has seen of one image.

    Parameters
    ----------
    known : tuple of pairs
        What was seen before: the digest of all that decides a profile, and the profile.
    """

    def __init__(self, known: tuple[tuple[str, Profile | None], ...] = ()) -> None:
        self._known = dict(known)
        self._used: dict[str, Profile | None] = {}

    def __call__(
        self, line: Line, sections: np.ndarray, radius: float, volume: Volume, others: Sequence[Line] = ()
    ) -> Profile | None:
        """Return the profile, see `profile`."""
        near = _near(line, radius + RING * volume.spacing[0], others, CLEARANCE * volume.spacing[0])
        key = digest_of("profile", line, sections, radius, near)
        if key not in self._known:
            self._known[key] = profile(line, sections, radius, volume, others)
        self._used[key] = self._known[key]
        return self._known[key]

    @property
    def used(self) -> tuple[tuple[str, Profile | None], ...]:
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
