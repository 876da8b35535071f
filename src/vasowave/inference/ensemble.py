"""Draws from a density that costs little: an ensemble of walkers with stretch and differential moves.

Goodman & Weare, Comm. App. Math. Comp. Sci. 5 (2010), 65, and ter Braak, Stat. Comput. 16 (2006), 239: both moves suit
every affine image of a density, so that nothing has to be tuned to scales and correlations. Differential moves forget
sooner where a density is nearly normal; stretches reach along what is bent.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

LogDensity = Callable[[np.ndarray], np.ndarray]
"""Maps points, shape (point, unknown), to the logarithm of a density, shape (point,)."""

_STRETCH = 2.0  # Goodman and Weare's a
_DIFFERENCE = 2.38 / np.sqrt(2)  # ter Braak's γ of one unknown
_STRETCHED = 3  # one step of so many stretches


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Draws of all walkers, shape (step, walker, unknown), their log densities, and the share of accepted moves."""

    points: np.ndarray
    log_density: np.ndarray
    accepted: float


def sample(
    log_density: LogDensity, walkers: np.ndarray, steps: int, rng: np.random.Generator, keep_every: int = 10
) -> Ensemble:
    """Move walkers, shape (walker, unknown), an even number from 4, and return every `keep_every`-th step."""
    x, log = walkers.copy(), log_density(walkers)
    half, count = len(x) // 2, x.shape[1]
    points, logs, accepted = [], [], 0
    for step in range(1, steps + 1):
        for here, there in ((slice(0, half), slice(half, None)), (slice(half, None), slice(0, half))):
            moving, others = x[here], x[there]
            partner = rng.integers(len(others), size=len(moving))
            if step % _STRETCHED == 0:
                z = ((_STRETCH - 1) * rng.random(len(moving)) + 1) ** 2 / _STRETCH
                proposed, factor = others[partner] + z[:, np.newaxis] * (moving - others[partner]), z ** (count - 1)
            else:
                further = (partner + rng.integers(1, len(others), size=len(moving))) % len(others)  # another one
                by = _DIFFERENCE / np.sqrt(count) * (others[partner] - others[further])
                proposed, factor = moving + by, np.ones(len(moving))
            density = log_density(proposed)
            yes = np.log(rng.random(len(moving))) < np.log(factor) + density - log[here]
            x[here] = np.where(yes[:, np.newaxis], proposed, moving)
            log[here] = np.where(yes, density, log[here])
            accepted += int(yes.sum())
        if step % keep_every == 0:
            points.append(x.copy())
            logs.append(log.copy())
    return Ensemble(np.array(points), np.array(logs), accepted / (steps * len(x)))
