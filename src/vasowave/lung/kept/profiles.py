"""What is known already of sections of vessels, beside them, and of junctions: far from an edit it is as before."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from vasowave.base.runtime.kept import digest_of
from vasowave.lung.measure.profiles import CLEARANCE, RING, Profile, profile, reach_beside, signal_beside
from vasowave.lung.read.volume import Volume
from vasowave.lung.tree import Line


class Profiles:
    """Looks at the sections of vessels as `profile` does, and remembers what it has seen of one image.

    Parameters
    ----------
    pairs : tuple of pairs
        What was seen before: the digest of all that decides a value, and the value.
    """

    def __init__(self, pairs: tuple[tuple[str, Any], ...] = ()) -> None:
        self._known = dict(pairs)
        self._used: dict[str, Any] = {}

    def __call__(
        self, line: Line, sections: np.ndarray, radius: float, volume: Volume, neighbors: Sequence[Line] = ()
    ) -> Profile | None:
        """Return the profile, see `profile`."""
        candidates = _near(line, radius + RING * volume.spacing[0], neighbors, CLEARANCE * volume.spacing[0])
        inputs = ("profile", line, sections, radius, candidates)
        return self.recalled(inputs, lambda: profile(line, sections, radius, volume, neighbors))

    def beside(self, line: Line, sections: np.ndarray, radius: float, volume: Volume, vessels: Line) -> float:
        """Return the noise beside the vessel, see `signal_beside`."""
        reach = reach_beside(radius, float(volume.spacing[0]))
        low, high = line.points.min(axis=0) - reach, line.points.max(axis=0) + reach
        wide = vessels.radius[:, None]
        neighbors = vessels[((vessels.points + wide > low) & (vessels.points - wide < high)).all(axis=1)]
        inputs = ("beside", line, sections, radius, neighbors)
        return self.recalled(inputs, lambda: signal_beside(line, sections, radius, volume, neighbors))

    def recalled(self, inputs: tuple[Any, ...], make: Callable[[], Any]) -> Any:
        """Return what `make` returns, or returned before where the `inputs` that decide of it were the same."""
        key = digest_of(*inputs)
        if key not in self._known:
            self._known[key] = make()
        self._used[key] = self._known[key]
        return self._known[key]

    @property
    def used(self) -> tuple[tuple[str, Any], ...]:
        """What was asked for."""
        return tuple(self._used.items())


def _near(line: Line, outer: float, neighbors: Sequence[Line], margin: float) -> list[Line]:
    """Return those of `neighbors` whose tubes may come into sections of `line` that reach to `outer`."""
    low, high = line.points.min(axis=0) - outer - margin, line.points.max(axis=0) + outer + margin
    return [
        neighbor
        for neighbor in neighbors
        if ((neighbor.points + neighbor.radius.max() > low) & (neighbor.points - neighbor.radius.max() < high))
        .all(axis=1)
        .any()
    ]
