"""The periodic state: the fixed point of the map from the state at the start of a cycle to the state at its end."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

MEMORY = 3  # earlier cycles that the acceleration combines; more gains nothing and risks a poor least-squares problem

Secants = tuple[np.ndarray, np.ndarray]
"""How the change over a cycle, and its end, differ from one cycle to the next; shapes (cycle, variable)."""


@dataclass(frozen=True)
class Convergence:
    """How the fixed point was approached.

    Attributes
    ----------
    changes : tuple of float
        Largest change of any variable over each cycle, mmHg.
    converged : bool
    secants : Secants, optional
        What the last cycles taught about the cycle map, for the search near by.
    """

    changes: tuple[float, ...]
    converged: bool
    secants: Secants | None = None


def fixed_point(
    cycle: Callable[[np.ndarray], np.ndarray],
    start: np.ndarray,
    tolerance: float,
    most: int,
    allowed: Callable[[np.ndarray], bool],
    learned: Secants | None = None,
) -> tuple[np.ndarray, Convergence]:
    """Find x = cycle(x) by Anderson acceleration.

    The next start is the combination of the last few ends of cycle whose changes cancel best, which removes the slow
    decay with the Windkessels' time constant that plain repetition follows.

    Parameters
    ----------
    cycle : callable
        One cycle of the simulation, on states scaled to mmHg.
    start : array
    tolerance : float
        Largest change over the cycle that counts as periodic, mmHg.
    most : int
        Largest number of cycles.
    allowed : callable
        Says whether a state is physical; where it is not, the plain end of the cycle is taken instead.
    learned : Secants, optional
        From the fixed point of a neighbouring map, whose slow directions are nearly the same.

    Returns
    -------
    end : array
        State at the end of the last cycle.
    convergence : Convergence
    """
    x = start
    ends: list[np.ndarray] = []
    changes: list[np.ndarray] = []
    sizes: list[float] = []
    none = (np.empty((0, len(start))), np.empty((0, len(start))))
    secants = learned if learned is not None and learned[0].shape[1] == len(start) else none
    for _ in range(most):
        end = cycle(x)
        change = end - x
        sizes.append(float(np.max(np.abs(change))))
        ends, changes = [*ends[-MEMORY:], end], [*changes[-MEMORY:], change]
        own = np.diff(np.array(changes), axis=0), np.diff(np.array(ends), axis=0)
        if sizes[-1] <= tolerance:
            return end, Convergence(tuple(sizes), True, own if len(own[0]) > 1 else secants)
        x = _combine(end, change, np.vstack([secants[0], own[0]]), np.vstack([secants[1], own[1]]))
        if not allowed(x):
            x, ends, changes, secants = end, [end], [change], none
    return end, Convergence(tuple(sizes), False)


def _combine(end: np.ndarray, change: np.ndarray, changes: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Go from `end` along the secants by the amounts that cancel `change` best."""
    if not len(changes):
        return end
    weights = np.linalg.lstsq(changes.T, change, rcond=1e-12)[0]
    return end - ends.T @ weights
