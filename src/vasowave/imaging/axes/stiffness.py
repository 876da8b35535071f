"""How stiff tubes are: an axis follows the wall that its vessel has of its own, and goes on as an arc without it.

Third differences of the nodes, which an arc has not, are penalized. Where all of a node's wall is seen its place is
known to some hundredths of a voxel and the penalty only quiets noise; where a wider sister hides the vessel nothing is
seen, and the penalty alone says how the axis goes on. One weight for both either bends axes that should be straight or
straightens axes that bend within two radii, which misplaces their junctions.
"""

from dataclasses import dataclass

import numpy as np

from vasowave.imaging.axes.feet import Feet, Tubes

FREE, HIDDEN = 0.35, 4.0
"""Weights of a changing curvature against the points of the surface, with a wall of its own all around and without."""
ROUGH = 0.18, 4
"""Where noise over contrast exceeds the first number, FREE rises with this power of their ratio."""
SWELLING, TAPER = 20.0, 0.05
"""Weights of a changing taper and of a taper."""
LONGEST = 3
"""No difference is of a higher order."""
FULL = 0.6
"""A node has all its wall if it has as many points for its size as this quantile of all nodes."""
FEWEST = 4
"""A difference weighs as much as a node has points, at least so many."""


@dataclass(frozen=True, eq=False)
class Differences:
    """What is kept small: differences along each vessel of the unknowns (nodes' coordinates, then radii).

    Attributes
    ----------
    columns : int array, shape (difference, LONGEST + 1)
        The unknowns that each difference spans; the last one again where it spans fewer.
    stencil : float array, shape (difference, LONGEST + 1)
        Their factors; 0 where an unknown stands again.
    vessel : int array, shape (difference,)
    weight : float array, shape (difference,)
        NaN for the differences of positions, whose weight depends on the wall.
    window : int array, shape (difference, 2)
        First and last place (see `Tubes`) that the difference spans.
    """

    columns: np.ndarray
    stencil: np.ndarray
    vessel: np.ndarray
    weight: np.ndarray
    window: np.ndarray

    def of(self, state: np.ndarray) -> np.ndarray:
        """Return the differences of the unknowns' values, shape (difference,)."""
        return np.asarray((self.stencil * state[self.columns]).sum(axis=1))


def differences(tubes: Tubes) -> Differences:
    """Return the differences of the unknowns of `tubes`."""
    vessel, parts = np.repeat(np.arange(len(tubes.parent)), np.diff(tubes.begins)), []
    beyond = tubes.begins[vessel + 1] - 1 - np.arange(len(vessel))  # places of its vessel beyond each
    radius = tubes.nodes.size + np.arange(len(vessel)), ((2, SWELLING), (1, TAPER))
    for unknowns, orders in (*((3 * tubes.at + k, ((3, np.nan),)) for k in range(3)), radius):
        for order, weight in orders:
            first = np.flatnonzero(beyond >= order)
            spans = first[:, None] + np.minimum(np.arange(LONGEST + 1), order)
            stencil = np.append(np.diff(np.eye(order + 1), order, axis=0)[0], np.zeros(LONGEST - order))
            about = np.tile(stencil, (len(first), 1)), vessel[first], np.full(len(first), weight)
            parts.append((unknowns[spans], *about, spans[:, [0, -1]]))
    return Differences(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def strengths(tubes: Tubes, feet: Feet, kept: Differences, roughness: float) -> np.ndarray:
    """Return the weight of each difference against points of the surface that weigh 1.

    Parameters
    ----------
    tubes, feet, kept
    roughness : float
        Noise over the contrast between wall and background.
    """
    free = min(FREE * max(roughness / ROUGH[0], 1.0) ** ROUGH[1], HIDDEN)
    seen = _own_wall(tubes, feet)
    first, last = kept.window.T
    least = np.min([seen[np.minimum(first + step, last)] for step in range(LONGEST + 1)], axis=0)
    bending = HIDDEN + (free - HIDDEN) * least
    # A difference weighs as much as a node has points, so that neither resolution nor width changes the balance.
    points = np.bincount(feet.vessel, minlength=len(tubes.parent)) / np.diff(tubes.begins)
    return np.where(np.isnan(kept.weight), bending, kept.weight) * np.maximum(points, FEWEST)[kept.vessel]


def _own_wall(tubes: Tubes, feet: Feet) -> np.ndarray:
    """Return the share of its wall that each node has for itself, shape (place,)."""
    size = tubes.radius.size
    count = np.bincount(feet.place, 1 - feet.share, size) + np.bincount(feet.place + 1, feet.share, size)
    half = tubes.lengths / 2
    length = np.bincount(tubes.pieces, half, size) + np.bincount(tubes.pieces + 1, half, size)
    density = count / np.maximum(tubes.radius * length, 1e-9)
    return np.asarray(np.clip(density / max(float(np.quantile(density, FULL)), 1e-9), 0, 1))
