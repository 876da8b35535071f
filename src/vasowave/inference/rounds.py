"""From simulations to draws of the posterior: rounds of an emulator that learns where it is used, then exact weights.

Points are scores, in which the prior is the standard normal distribution.
"""

from dataclasses import dataclass

import numpy as np

from vasowave.errors import NumericalError
from vasowave.inference.discrepancy import Discrepancy
from vasowave.inference.emulator import Coordinates, Emulator, fit_emulator
from vasowave.inference.ensemble import Ensemble, LogDensity, sample
from vasowave.inference.evidence import log_integral
from vasowave.inference.mode import Climbed
from vasowave.inference.reweighting import Weights, smoothed
from vasowave.inference.simulations import Simulate

_ROUNDS = 7  # of simulations, at most
_GOOD = 0.5  # SD of the emulator's error of the log-likelihood at new draws, below which no round follows
_WIDER = 0.6  # power of the posterior that rounds learn: an emulator that saw the bulk alone ends the posterior there
_DRAWN = 0.8  # power of the posterior that is drawn from in the end: weights stay small where the emulator errs
_WALKERS, _STEPS, _LAST_STEPS = 200, 300, 400
_FARTHER = 1.3  # the emulator is used up to this times the farthest point it was fitted to
_TRIES = 3  # draws that cannot be trusted teach the emulator, and others are drawn


@dataclass(frozen=True, eq=False)
class Target:
    """A posterior to explore.

    Attributes
    ----------
    simulate : callable
        Maps points (point, unknown) to outputs (point, output); NaN where a point cannot be simulated.
    measured : array, shape (output,)
    noise : Discrepancy
    coordinates : callable
        In which outputs bend less.
    """

    simulate: Simulate
    measured: np.ndarray
    noise: Discrepancy
    coordinates: Coordinates

    def log_likelihood(self, outputs: np.ndarray) -> np.ndarray:
        """Return the log-likelihood of outputs, shape (point, output); -inf for those that are NaN."""
        good = np.isfinite(outputs).all(axis=1)
        likelihoods = np.full(len(outputs), -np.inf)
        likelihoods[good] = self.noise.log_likelihood(self.measured - outputs[good])
        return likelihoods


@dataclass(frozen=True, eq=False)
class Surrogate:
    """What stands for a target and costs little: emulated outputs, and the spectra that matter for them."""

    emulator: Emulator
    measured: np.ndarray
    noise: Discrepancy

    def log_likelihood(self, points: np.ndarray) -> np.ndarray:
        """Return the log-likelihood of the emulated outputs at points, shape (point, unknown)."""
        return self._log_likelihood(self.emulator.local(points))

    def log_learned(self, points: np.ndarray) -> np.ndarray:
        """Return the logarithm of the wider density that rounds learn."""
        return _WIDER * self.log_posterior(points)

    def log_drawn(self, points: np.ndarray) -> np.ndarray:
        """Return the logarithm of the wider density that is drawn from in the end."""
        return _DRAWN * self.log_posterior(points)

    def log_posterior(self, points: np.ndarray) -> np.ndarray:
        """Return the log posterior density; -inf too far from all points that were simulated."""
        local = self.emulator.local(points)
        far = (local**2).sum(axis=1) > (_FARTHER * self.emulator.reach) ** 2
        return np.where(far, -np.inf, self._log_likelihood(local) + log_prior(points))

    def _log_likelihood(self, local: np.ndarray) -> np.ndarray:
        return self.noise.log_likelihood(self.measured - self.emulator.at(local))


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
    rounds: int


def explore(target: Target, climbed: Climbed, rng: np.random.Generator, draws: int = 400) -> Explored:
    """Return draws of the posterior of points with prior N(0, 1), from the mode that was climbed.

    Raises
    ------
    NumericalError
        Most points near the mode cannot be simulated.
    """
    points, outputs, size = climbed.points, climbed.outputs, len(climbed.middle)
    walkers = climbed.middle + rng.standard_normal((_WALKERS, size)) @ climbed.root.T / np.sqrt(_WIDER)
    surrogate, log_error, rounds = None, np.inf, 0
    while rounds < _ROUNDS and log_error > _GOOD:
        rounds += 1
        fresh = walkers[rng.choice(len(walkers), 20 + 6 * size + 10 * rounds, replace=False)]
        simulated = _simulated(target, fresh)
        if surrogate is not None:
            log_error = _log_error(target, surrogate, fresh, simulated, _WIDER)
        points, outputs = _joined(points, outputs, fresh, simulated)
        surrogate = _learned(target, points, outputs, walkers, surrogate)
        walkers = _moved(surrogate.log_learned, walkers, _STEPS, rng).points[-1]
    for _ in range(_TRIES):
        assert surrogate is not None
        ensemble = _moved(surrogate.log_drawn, walkers, _LAST_STEPS, rng)
        result = _weighted(target, surrogate, ensemble, rng, draws, rounds)
        if result.weights.trusted:
            break
        points, outputs = _joined(points, outputs, result.points, target.measured - result.residuals)
        surrogate, rounds = _learned(target, points, outputs, result.points, surrogate), rounds + 1
        walkers = ensemble.points[-1]
    return result


def log_prior(points: np.ndarray) -> np.ndarray:
    """Return the log density of the standard normal distribution at points, shape (point, unknown)."""
    return -0.5 * ((points**2).sum(axis=1) + points.shape[1] * np.log(2 * np.pi))


def _simulated(target: Target, points: np.ndarray) -> np.ndarray:
    outputs = target.simulate(points)
    if np.mean(np.isfinite(outputs).all(axis=1)) < 0.5:
        raise NumericalError("most models near the mode cannot be simulated; give narrower priors, or other numerics")
    return outputs


def _joined(
    points: np.ndarray, outputs: np.ndarray, fresh: np.ndarray, simulated: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    good = np.isfinite(simulated).all(axis=1)
    return np.concatenate([points, fresh[good]]), np.concatenate([outputs, simulated[good]])


def _learned(
    target: Target, points: np.ndarray, outputs: np.ndarray, around: np.ndarray, before: Surrogate | None
) -> Surrogate:
    near = target.measured - outputs[-len(around) // 2 :]
    scale = np.sqrt(target.noise.variance(near) + np.diag(target.noise.measured))
    lengths = None if before is None else before.emulator.lengths
    emulator = fit_emulator(points, outputs, around, scale, target.coordinates, lengths)
    return Surrogate(emulator, target.measured, target.noise.narrowed(near))


def _moved(log_density: LogDensity, walkers: np.ndarray, steps: int, rng: np.random.Generator) -> Ensemble:
    """Let the walkers move; those that the emulator cannot answer start from places of others."""
    lost = ~np.isfinite(log_density(walkers))
    begin = walkers.copy()
    begin[lost] = walkers[rng.choice(np.flatnonzero(~lost), int(lost.sum()))]
    return sample(log_density, begin, steps, rng)


def _log_error(target: Target, surrogate: Surrogate, points: np.ndarray, outputs: np.ndarray, power: float) -> float:
    """Return the SD of the error of the log-likelihood in the posterior, from draws of a power of it."""
    good = np.isfinite(outputs).all(axis=1)
    true = target.log_likelihood(outputs[good])
    missed, height = true - surrogate.log_likelihood(points[good]), true + log_prior(points[good])
    weight = np.exp((1 - power) * (height - height.max()))
    return float(np.sqrt(np.average((missed - np.average(missed, weights=weight)) ** 2, weights=weight)))


def _weighted(
    target: Target, surrogate: Surrogate, ensemble: Ensemble, rng: np.random.Generator, draws: int, rounds: int
) -> Explored:
    """Simulate draws of the surrogate's posterior and weigh them by what it missed."""
    late = slice(len(ensemble.points) // 2, None)
    cloud, values = ensemble.points[late].reshape(-1, ensemble.points.shape[2]), ensemble.log_density[late].ravel()
    chosen = rng.choice(len(cloud), min(draws, len(cloud)), replace=False)
    points, outputs = cloud[chosen], _simulated(target, cloud[chosen])
    ratio = target.log_likelihood(outputs) + log_prior(points) - surrogate.log_drawn(points)
    integral, error = log_integral(surrogate.log_drawn, cloud, values, rng)
    shift = float(ratio.max() + np.log(np.mean(np.exp(ratio - ratio.max()))))
    spread = float(np.std(np.exp(ratio - shift)) / np.sqrt(len(ratio)))
    return Explored(
        points, target.measured - outputs, smoothed(ratio), outputs - surrogate.emulator(points),
        _log_error(target, surrogate, points, outputs, _DRAWN), integral + shift, float(np.hypot(error, spread)),
        surrogate.emulator, rounds,
    )  # fmt: skip
