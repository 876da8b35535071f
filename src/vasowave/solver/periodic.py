"""The periodic state: the fixed point of the map from the state at the start of a cycle to the state at its end."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

MEMORY = 3  # earlier cycles that the acceleration combines; more gains nothing and risks a poor least-squares problem


@dataclass(frozen=True)
class Convergence:
    """How the fixed point was approached.

    Attributes
    ----------
    changes : tuple of float
        Largest change of any variable over each cycle, mmHg.
    converged : bool
    """

    changes: tuple[float, ...]
    converged: bool


def fixed_point(
    cycle: Callable[[np.ndarray], np.ndarray],
    start: np.ndarray,
    tolerance: float,
    most: int,
    allowed: Callable[[np.ndarray], bool],
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
    for _ in range(most):
        end = cycle(x)
        change = end - x
        sizes.append(float(np.max(np.abs(change))))
        if sizes[-1] <= tolerance:
            return end, Convergence(tuple(sizes), True)
        ends, changes = [*ends[-MEMORY:], end], [*changes[-MEMORY:], change]
        x = _combine(ends, changes)
        if not allowed(x):
            x, ends, changes = end, [end], [change]
    return end, Convergence(tuple(sizes), False)


def _combine(ends: list[np.ndarray], changes: list[np.ndarray]) -> np.ndarray:
    if len(ends) == 1:
        return ends[0]
    steps = np.diff(np.array(changes), axis=0).T
    weights = np.linalg.lstsq(steps, changes[-1], rcond=1e-12)[0]
    return ends[-1] - np.diff(np.array(ends), axis=0).T @ weights
