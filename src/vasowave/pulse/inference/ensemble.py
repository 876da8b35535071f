"""Draws from a density that costs little, by an ensemble of walkers with stretch and differential moves; its integral.

Goodman & Weare, Comm. App. Math. Comp. Sci. 5 (2010), 65, and ter Braak, Stat. Comput. 16 (2006), 239: both moves suit
every affine image of a density, so that nothing has to be tuned to scales and correlations. Differential moves forget
sooner where a density is nearly normal; stretches reach along what is bent.

The integral of an unnormalized density, the evidence, comes by bridge sampling (Meng & Wong, Statistica Sinica 6
(1996), 831): draws from the density and from a distribution whose integral is known meet in the iterated optimal
bridge. The known one is a multivariate t, wider than the density where the two differ.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import gammaln

LogDensity = Callable[[np.ndarray], np.ndarray]
"""Maps points, shape (point, unknown), to the logarithm of a density, shape (point,)."""

_STRETCH_SCALE = 2.0  # Goodman and Weare's a
_DIFFERENCE_SCALE = 2.38 / np.sqrt(2)  # ter Braak's γ of one unknown
_STRETCH_PERIOD = 3  # one step of so many stretches
_T_FREEDOM = 5.0  # of the t distribution
_MAX_ROUNDS = 200  # of the fixed-point equation, at most


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Draws of all walkers, shape (step, walker, unknown), their log densities, and the share of accepted moves."""

    points: np.ndarray
    log_density: np.ndarray
    accepted: float


def sample(
    log_density: LogDensity,
    walkers: np.ndarray,
    steps: int,
    rng: np.random.Generator,
    keep_every: int = 10,
    groups: int = 1,
) -> Ensemble:
    """Move walkers, shape (walker, unknown), and return every `keep_every`-th step.

    Walker i belongs to the group i modulo `groups`, and no group knows of another; each has an even number from 4.
    """
    x, log = walkers.copy(), log_density(walkers)
    half, count = len(x) // 2, x.shape[1]
    points, logs, accepted = [], [], 0
    for step in range(1, steps + 1):
        for moved_half, other_half in ((slice(0, half), slice(half, None)), (slice(half, None), slice(0, half))):
            moving, partners = x[moved_half], x[other_half]
            group, members = np.arange(len(moving)) % groups, len(partners) // groups
            partner = groups * rng.integers(members, size=len(moving)) + group
            if step % _STRETCH_PERIOD == 0:
                z = ((_STRETCH_SCALE - 1) * rng.random(len(moving)) + 1) ** 2 / _STRETCH_SCALE
                proposed, factor = partners[partner] + z[:, np.newaxis] * (moving - partners[partner]), z ** (count - 1)
            else:
                onward = groups * rng.integers(1, members, size=len(moving))  # to another one
                further = (partner + onward) % len(partners)
                by = _DIFFERENCE_SCALE / np.sqrt(count) * (partners[partner] - partners[further])
                proposed, factor = moving + by, np.ones(len(moving))
            density = log_density(proposed)
            yes = np.log(rng.random(len(moving))) < np.log(factor) + density - log[moved_half]
            x[moved_half] = np.where(yes[:, np.newaxis], proposed, moving)
            log[moved_half] = np.where(yes, density, log[moved_half])
            accepted += int(yes.sum())
        if step % keep_every == 0:
            points.append(x.copy())
            logs.append(log.copy())
    return Ensemble(np.array(points), np.array(logs), accepted / (steps * len(x)))


def log_integral(
    log_density: LogDensity, draws: np.ndarray, values: np.ndarray, rng: np.random.Generator
) -> tuple[float, float]:
    """Return the logarithm of the density's integral and its standard error if all draws were independent.

    Parameters
    ----------
    log_density : callable
    draws : array, shape (draw, unknown)
        Distributed by the density; one half shapes the known distribution, the other is compared with it.
    values : array, shape (draw,)
        `log_density` there.
    """
    even, odd = draws[::2], draws[1::2]
    shape = np.atleast_2d(np.cov(even.T)) * (_T_FREEDOM - 2) / _T_FREEDOM
    reference = _StudentT(even.mean(axis=0), np.linalg.cholesky(shape))
    proposed = reference.draw(len(odd), rng)
    first = values[1::2] - reference.log_density(odd)
    second = log_density(proposed) - reference.log_density(proposed)
    middle = float(np.median(first))
    ours, theirs = np.exp(first - middle), np.exp(second - middle)
    ratio = 1.0
    for _ in range(_MAX_ROUNDS):
        before, ratio = ratio, _bridge(ours, theirs, ratio)
        if abs(ratio / before - 1) < 1e-10:
            break
    top, bottom = theirs / (theirs + ratio), ratio / (ours + ratio)
    error = np.sqrt(np.var(top) / np.mean(top) ** 2 / len(top) + np.var(bottom) / np.mean(bottom) ** 2 / len(bottom))
    return middle + float(np.log(ratio)), float(error)


class _StudentT(NamedTuple):
    """A multivariate t distribution; `scipy.stats`, which has one, takes a second or two to import."""

    center: np.ndarray
    root: np.ndarray  # Cholesky factor of its shape

    def draw(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Return draws, shape (count, unknown)."""
        wide = np.sqrt(_T_FREEDOM / rng.chisquare(_T_FREEDOM, (count, 1)))
        return self.center + wide * (rng.standard_normal((count, len(self.center))) @ self.root.T)

    def log_density(self, points: np.ndarray) -> np.ndarray:
        """Return the logarithm of the density at points, shape (point, unknown)."""
        d = len(self.center)
        square = (solve_triangular(self.root, (points - self.center).T, lower=True) ** 2).sum(axis=0)
        constant = gammaln(0.5 * (_T_FREEDOM + d)) - gammaln(0.5 * _T_FREEDOM) - 0.5 * d * np.log(_T_FREEDOM * np.pi)
        falls = 0.5 * (_T_FREEDOM + d) * np.log1p(square / _T_FREEDOM)
        return np.asarray(constant - np.log(np.diag(self.root)).sum() - falls)


def _bridge(ours: np.ndarray, theirs: np.ndarray, ratio: float) -> float:
    return float(np.mean(theirs / (theirs + ratio)) / np.mean(1 / (ours + ratio)))
