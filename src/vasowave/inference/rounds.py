"""From simulations to draws of the posterior: rounds of an emulator that learns where it is used, then exact weights.

Points are scores, in which the prior is the standard normal distribution.
"""

from dataclasses import dataclass

import numpy as np

from vasowave.errors import NumericalError
from vasowave.inference.discrepancy import Discrepancy
from vasowave.inference.emulator import Emulator, fit_emulator
from vasowave.inference.ensemble import Ensemble, sample
from vasowave.inference.evidence import log_integral
from vasowave.inference.reweighting import Weights, smoothed
from vasowave.inference.simulations import Simulate

_ROUNDS = 6
_GOOD = 0.4  # SD of the emulator's error of the log-likelihood at new draws, below which no round follows
_WALKERS, _STEPS, _LAST_STEPS = 240, 120, 360
_FARTHER = 1.3  # the emulator is used up to this times the farthest point it was fitted to
_NEWTON, _STEP = 4, 0.1  # steps of the search for the mode at most; differences, in SD of the prior


@dataclass(frozen=True, eq=False)
class Explored:
    """Draws of the emulator's posterior, simulated, with the weights that make them draws of the posterior.

    Attributes
    ----------
    points : array, shape (draw, unknown)
    residuals : array, shape (draw, output)
        Measured minus simulated.
    weights : Weights
    missed : array, shape (draw, output)
        Simulated minus emulated.
    log_error : float
        SD of the emulator's error of the log-likelihood.
    log_evidence, log_evidence_error : float
    emulator : Emulator
    cloud : array, shape (many, unknown)
        Draws of the emulator's posterior.
    rounds : int
    """

    points: np.ndarray
    residuals: np.ndarray
    weights: Weights
    missed: np.ndarray
    log_error: float
    log_evidence: float
    log_evidence_error: float
    emulator: Emulator
    cloud: np.ndarray
    rounds: int


def explore(
    simulate: Simulate,
    measured: np.ndarray,
    noise: Discrepancy,
    start: np.ndarray,
    rng: np.random.Generator,
    draws: int = 400,
) -> Explored:
    """Return draws of the posterior of points with prior N(0, 1).

    Raises
    ------
    NumericalError
        The start, or nearly all points near it, cannot be simulated.
    """
    points, outputs, walkers = _mode(simulate, measured, noise, start, rng)
    scale = np.sqrt(noise.variance(measured - outputs[-1:]) + np.diag(noise.measured))
    log_error, rounds = np.inf, 0
    while rounds < _ROUNDS and log_error > _GOOD:
        rounds += 1
        count = 30 + 10 * rounds + 2 * len(start)
        fresh = walkers[rng.choice(len(walkers), min(count, len(walkers)), replace=False)]
        found = simulate(fresh)
        good = np.isfinite(found).all(axis=1)
        if rounds > 1:
            log_error = _log_error(noise, measured, emulator, fresh[good], found[good])
        points, outputs = np.concatenate([points, fresh[good]]), np.concatenate([outputs, found[good]])
        if len(points) < 2 * len(start):
            raise NumericalError("nearly no model near the fit can be simulated: narrower priors keep among those")
        emulator = fit_emulator(points, outputs, walkers, scale)
        ensemble = _ensemble(noise, measured, emulator, _inside(emulator, walkers), _STEPS, rng)
        walkers = ensemble.points[-1]
    ensemble = _ensemble(noise, measured, emulator, walkers, _LAST_STEPS, rng)
    return _weighted(simulate, measured, noise, emulator, ensemble, rng, draws, rounds)


def log_posterior(noise: Discrepancy, measured: np.ndarray, emulator: Emulator, points: np.ndarray) -> np.ndarray:
    """Return the emulator's log posterior density; -inf too far from all points that were simulated."""
    far = (emulator.local(points) ** 2).sum(axis=1) > (_FARTHER * emulator.reach) ** 2
    found = noise.log_likelihood(measured - emulator(points)) + log_prior(points)
    return np.where(far, -np.inf, found)


def log_prior(points: np.ndarray) -> np.ndarray:
    """Return the log density of the standard normal distribution at points, shape (point, unknown)."""
    return -0.5 * ((points**2).sum(axis=1) + points.shape[1] * np.log(2 * np.pi))


def _mode(
    simulate: Simulate, measured: np.ndarray, noise: Discrepancy, start: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Climb to the mode by Gauss-Newton steps; return what was simulated and walkers of the normal approximation."""
    points, outputs = start[np.newaxis], simulate(start[np.newaxis])
    if not np.isfinite(outputs).all():
        raise NumericalError("the start cannot be simulated; give a fit to start from, or other priors")
    here, y = start, outputs[0]
    for _ in range(_NEWTON):
        near = here + _STEP * np.eye(len(here))
        found = simulate(near)
        J = np.nan_to_num((found - y) / _STEP).T
        points, outputs = np.concatenate([points, near]), np.concatenate([outputs, found])
        mean, root = _normal(noise, measured, here, y, J)
        better = _climbed(simulate, measured, noise, here, y, mean)
        if better is None:
            break
        points, outputs = np.concatenate([points, better[0][None]]), np.concatenate([outputs, better[1][None]])
        small = np.sum(np.linalg.solve(root, better[0] - here) ** 2) < 0.1
        here, y = better
        if small:
            break
    good = np.isfinite(outputs).all(axis=1)
    return points[good], outputs[good], here + rng.standard_normal((_WALKERS, len(here))) @ root.T


def _normal(
    noise: Discrepancy, measured: np.ndarray, here: np.ndarray, y: np.ndarray, J: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and Cholesky factor of the covariance of the posterior if outputs were linear around `here`."""
    total = np.diag(noise.variance((measured - y)[np.newaxis])) + noise.measured + noise.vessels @ noise.vessels.T
    gain = np.linalg.solve(total, J).T
    covariance = np.linalg.inv(gain @ J + np.eye(len(here)))
    mean = covariance @ (gain @ (measured - y + J @ here))
    return mean, np.linalg.cholesky(0.5 * (covariance + covariance.T))


def _climbed(
    simulate: Simulate, measured: np.ndarray, noise: Discrepancy, here: np.ndarray, y: np.ndarray, aim: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the first better point, with its outputs, on the way back from `aim`; None if none is better."""

    def height(point: np.ndarray, output: np.ndarray) -> float:
        return float(noise.log_likelihood(measured - output) + log_prior(point[np.newaxis])[0])

    for share in (1.0, 0.5, 0.2):
        point = here + share * (aim - here)
        output = simulate(point[np.newaxis])[0]
        if np.isfinite(output).all() and height(point, output) > height(here, y):
            return point, output
    return None


def _inside(emulator: Emulator, walkers: np.ndarray) -> np.ndarray:
    """Return the walkers with those that the emulator cannot answer drawn towards its center."""
    distance = np.sqrt((emulator.local(walkers) ** 2).sum(axis=1))
    share = np.minimum(1.0, emulator.reach / np.maximum(distance, 1e-300))
    return emulator.center + share[:, np.newaxis] * (walkers - emulator.center)


def _ensemble(
    noise: Discrepancy,
    measured: np.ndarray,
    emulator: Emulator,
    walkers: np.ndarray,
    steps: int,
    rng: np.random.Generator,
) -> Ensemble:
    return sample(lambda x: log_posterior(noise, measured, emulator, x), walkers, steps, rng)


def _log_error(
    noise: Discrepancy, measured: np.ndarray, emulator: Emulator, points: np.ndarray, outputs: np.ndarray
) -> float:
    true, emulated = noise.log_likelihood(measured - outputs), noise.log_likelihood(measured - emulator(points))
    return float(np.std(true - emulated))


def _weighted(
    simulate: Simulate,
    measured: np.ndarray,
    noise: Discrepancy,
    emulator: Emulator,
    ensemble: Ensemble,
    rng: np.random.Generator,
    draws: int,
    rounds: int,
) -> Explored:
    """Simulate draws of the emulator's posterior and weigh them by what it missed."""
    late = slice(len(ensemble.points) // 2, None)
    cloud, values = ensemble.points[late].reshape(-1, emulator.center.size), ensemble.log_density[late].ravel()
    chosen = rng.choice(len(cloud), min(draws, len(cloud)), replace=False)
    points, outputs = cloud[chosen], simulate(cloud[chosen])
    good = np.isfinite(outputs).all(axis=1)
    ratio = np.full(len(points), -np.inf)
    missed = outputs - emulator(points)
    ratio[good] = noise.log_likelihood(measured - outputs[good]) - noise.log_likelihood(
        measured - emulator(points[good])
    )
    integral, error = log_integral(lambda x: log_posterior(noise, measured, emulator, x), cloud, values, rng)
    shift = float(ratio.max() + np.log(np.mean(np.exp(ratio - ratio.max()))))
    spread = float(np.std(np.exp(ratio - shift)) / np.sqrt(len(ratio)))
    return Explored(
        points, measured - outputs, smoothed(ratio), missed, float(np.std(ratio[good])), integral + shift,
        float(np.hypot(error, spread)), emulator, cloud, rounds,
    )  # fmt: skip
