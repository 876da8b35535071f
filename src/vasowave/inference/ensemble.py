"""Draws from a density that costs little: an ensemble of walkers with stretch moves.

Goodman & Weare, Comm. App. Math. Comp. Sci. 5 (2010), 65: the moves suit every affine image of a density, so that
nothing has to be tuned to scales and correlations.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

LogDensity = Callable[[np.ndarray], np.ndarray]
"""Maps points, shape (point, unknown), to the logarithm of a density, shape (point,)."""

_STRETCH = 2.0  # the authors' a


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Draws of all walkers, shape (step, walker, unknown), their log densities, and the share of accepted moves."""

    points: np.ndarray
    log_density: np.ndarray
    accepted: float


def sample(
    log_density: LogDensity, walkers: np.ndarray, steps: int, rng: np.random.Generator, keep_every: int = 10
) -> Ensemble:
    """Move walkers, shape (walker, unknown), an even number, and return every `keep_every`-th step."""
    x, log = walkers.copy(), log_density(walkers)
    half, count = len(x) // 2, x.shape[1]
    points, logs, accepted = [], [], 0
    for step in range(1, steps + 1):
        for here, there in ((slice(0, half), slice(half, None)), (slice(half, None), slice(0, half))):
            moving, others = x[here], x[there]
            z = ((_STRETCH - 1) * rng.random(len(moving)) + 1) ** 2 / _STRETCH
            partner = others[rng.integers(len(others), size=len(moving))]
            proposed = partner + z[:, np.newaxis] * (moving - partner)
            density = log_density(proposed)
            yes = np.log(rng.random(len(moving))) < (count - 1) * np.log(z) + density - log[here]
            x[here] = np.where(yes[:, np.newaxis], proposed, moving)
            log[here] = np.where(yes, density, log[here])
            accepted += int(yes.sum())
        if step % keep_every == 0:
            points.append(x.copy())
            logs.append(log.copy())
    return Ensemble(np.array(points), np.array(logs), accepted / (steps * len(x)))
