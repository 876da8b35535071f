"""The periodic state: the fixed point of the map from the state at the start of a cycle to the state at its end."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

MEMORY = 3  # earlier cycles that the acceleration combines; more gains nothing and risks a poor least-squares problem

Secants = tuple[np.ndarray, np.ndarray]
"""How the change over a cycle, and its end, differ from one cycle to the next; shapes (cycle, variable)."""


@dataclass(frozen=True, eq=False)
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
    max_cycles: int,
    allowed: Callable[[np.ndarray], bool],
    to_come: Callable[[np.ndarray], np.ndarray],
    learned: Secants | None = None,
) -> tuple[np.ndarray, Convergence]:
    """Find x = cycle(x) by Anderson acceleration.

    The next start is the combination of the last few ends of cycle whose changes cancel best, and what the slow decay
    with the Windkessels' time constant, which plain repetition follows, would make of the change that is left.

    Parameters
    ----------
    cycle : callable
        One cycle of the simulation, on states scaled to mmHg.
    start : array
    tolerance : float
        Largest change over the cycle that counts as periodic, mmHg.
    max_cycles : int
        Largest number of cycles.
    allowed : callable
        Says whether a state is physical; where it is not, the plain end of the cycle is taken instead.
    to_come : callable
        Linear: for the change over a cycle, what all cycles to come add to it.
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
    for _ in range(max_cycles):
        end = cycle(x)
        change = end - x
        sizes.append(float(np.max(np.abs(change))))
        ends, changes = [*ends[-MEMORY:], end], [*changes[-MEMORY:], change]
        current = np.diff(np.array(changes), axis=0), np.diff(np.array(ends), axis=0)
        if sizes[-1] <= tolerance:
            return end, Convergence(tuple(sizes), True, current if len(current[0]) > 1 else secants)
        combined = np.vstack([secants[0], current[0]]), np.vstack([secants[1], current[1]])
        weights = np.linalg.lstsq(combined[0].T, change, rcond=1e-12)[0] if len(combined[0]) else np.zeros(0)
        x = end - weights @ combined[1] + to_come(change - weights @ combined[0])
        if not allowed(x):
            x, ends, changes, secants = end, [end], [change], none
    return end, Convergence(tuple(sizes), False)


def affine_fixed_point(
    cycle: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    start: np.ndarray,
    tolerance: float,
    max_cycles: int,
    learned: Secants | None = None,
) -> np.ndarray | None:
    """Find the outputs at the fixed points of maps that share one linear part, x = M x + b with a b for each row of x.

    Every cycle tells what M does to as many vectors as there are rows, and all rows use all of them. As the outputs are
    linear too, those of the fixed points are combined from those of the cycles, and no last cycle is needed.

    Parameters
    ----------
    cycle : callable
        Returns the rows' ends and outputs.
    start : array, shape (row, variable)
    tolerance : float
        Change over a cycle that counts as none, as a share of the row's largest value.
    max_cycles : int
        Largest number of cycles.
    learned : Secants, optional
        Of a map whose linear part is nearly M.

    Returns
    -------
    array, shape (row, output), or None if the tolerance was not met.
    """
    x = start
    history: list[tuple[np.ndarray, ...]] = []
    for _ in range(max_cycles):
        end, output = cycle(x)
        change = end - x
        if not np.all(np.isfinite(change)):  # of which LAPACK complains on the terminal
            return None
        history.append((change, end, output))
        current = [_differences(of_all_cycles) for of_all_cycles in zip(*history, strict=True)]
        weights = _cancelling(current[0], change)
        remainder = np.max(np.abs(change - weights @ current[0]), axis=1)
        if np.all(remainder <= tolerance * np.max(np.abs(end), axis=1)):
            return output - weights @ current[2]
        combined = (
            current[:2] if learned is None else [np.vstack(pair) for pair in zip(learned, current[:2], strict=True)]
        )
        x = end - _cancelling(combined[0], change) @ combined[1]
    return None


def _differences(of_all_cycles: Sequence[np.ndarray]) -> np.ndarray:
    """Return by how much the rows differ from one cycle to the next, all below each other; first a zero for each."""
    return np.concatenate(np.diff(np.array(of_all_cycles), axis=0, prepend=of_all_cycles[:1]))


def _cancelling(secants: np.ndarray, changes: np.ndarray) -> np.ndarray:
    """Return the amounts of the secants whose sum is nearest to each change, shape (row, secant)."""
    size = np.max(np.abs(secants), axis=1, initial=1e-300, keepdims=True)
    return np.linalg.lstsq((secants / size).T, changes.T, rcond=1e-13)[0].T / size.T
