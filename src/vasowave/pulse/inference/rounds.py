"""Rounds of an emulator that learns where it is used: around one mode of a posterior.

Points are scores, in which the prior is the standard normal distribution.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.inference.discrepancy import Discrepancy
from vasowave.pulse.inference.emulator import Coordinates, Emulator, fit_emulator
from vasowave.pulse.inference.ensemble import Ensemble, LogDensity, sample
from vasowave.pulse.inference.mode import Climbed, climb
from vasowave.pulse.inference.simulations import Simulate

_MAX_ROUNDS = 7  # of simulations, at most
_MAX_LIKELIHOOD_ERROR = 0.5
"""SD of the emulator's error of the log-likelihood at new draws, below which no round follows."""
_LEARNED_POWER = 0.6
"""Power of the posterior that rounds learn: an emulator that saw the bulk alone ends the posterior there."""
DRAWN_POWER = 0.8  # power of the posterior that is drawn from in the end: weights stay small where the emulator errs
_RIDGE_POINTS = 24  # from which the walkers of the first round start
_RIDGE_WIDTH = 0.5  # of the walkers about each, in SD of the mode
_MAX_RIDGE_NATS = 2.0  # nats for each unknown by which one of them may lie below the mode
_RIDGE_STEP = 1e-3  # of the linear model's differences, in SD of the prior
_ROUND_WALKERS, _ROUND_STEPS = 200, 150
"""Walkers and their steps: enough to spread from one round to the next; what is drawn in the end moves anew."""
_MIN_TERM_SHARE = 0.01  # of the largest term of a sum that stands for the likelihood while draws are sought
_MAX_REACH_RATIO = 1.3  # the emulator is used up to this times the farthest point it was fitted to
_MAX_MODE_ERROR_NATS = 2.0  # nats by which the emulator may miss the height of a mode that it covers


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
    linear : callable
        As `simulate`, by a model that costs little: it shows how far a mode reaches.
    """

    simulate: Simulate
    measured: np.ndarray
    noise: Discrepancy
    coordinates: Coordinates
    linear: Simulate

    def log_likelihood(self, outputs: np.ndarray) -> np.ndarray:
        """Return the log-likelihood of outputs, shape (point, output); -inf for those that are NaN."""
        good = np.isfinite(outputs).all(axis=1)
        likelihoods = np.full(len(outputs), -np.inf)
        likelihoods[good] = self.noise.log_likelihood(self.measured - outputs[good])
        return likelihoods

    def log_height(self, point: np.ndarray, output: np.ndarray) -> float:
        """Return log-likelihood and log prior of one point, (unknown,), with its output, up to a constant."""
        return float(self.log_likelihood(output[np.newaxis])[0] - 0.5 * point @ point)


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
        return _LEARNED_POWER * self.log_posterior(points)

    def log_drawn(self, points: np.ndarray) -> np.ndarray:
        """Return the logarithm of the wider density that is drawn from in the end."""
        return DRAWN_POWER * self.log_posterior(points)

    def log_posterior(self, points: np.ndarray) -> np.ndarray:
        """Return the log posterior density; -inf too far from all points that were simulated."""
        local = self.emulator.local(points)
        outside = (local**2).sum(axis=1) > (_MAX_REACH_RATIO * self.emulator.reach) ** 2
        return np.where(outside, -np.inf, self._log_likelihood(local) + log_prior(points))

    def knowing(self, points: np.ndarray, outputs: np.ndarray) -> "Surrogate":
        """Return the same, learned from more simulations without a new choice of lengths."""
        return replace(self, emulator=self.emulator.knowing(points, outputs))

    def _log_likelihood(self, local: np.ndarray) -> np.ndarray:
        return self.noise.log_likelihood(self.measured - self.emulator.at(local))


@dataclass(frozen=True, eq=False)
class Component:
    """What was learned around one mode.

    Attributes
    ----------
    surrogate : Surrogate
    points, outputs : array, shape (point, unknown), (point, output)
        Simulations it was learned from.
    walkers : array, shape (walker, unknown)
        Where the walkers stand that draw from it.
    halves : frozenset of int
        Which halves of the starts found the mode.
    rounds : int
    """

    surrogate: Surrogate
    points: np.ndarray
    outputs: np.ndarray
    walkers: np.ndarray
    halves: frozenset[int]
    rounds: int

    def covers(self, mode: Climbed, target: Target) -> bool:
        """Whether another mode lies among the walkers, and the emulator foretells its height."""
        away = mode.middle - self.walkers.mean(axis=0)
        if away @ np.linalg.solve(np.atleast_2d(np.cov(self.walkers.T)), away) > 2 * len(away):
            return False
        true = target.log_likelihood(mode.output[np.newaxis]) + log_prior(mode.middle[np.newaxis])
        return bool(abs(self.surrogate.log_posterior(mode.middle[np.newaxis]) - true)[0] < _MAX_MODE_ERROR_NATS)

    def found_by(self, halves: frozenset[int]) -> "Component":
        """Return the component as one that these halves of the starts found too."""
        return replace(self, halves=self.halves | halves)


def learn(target: Target, mode: Climbed, rng: np.random.Generator) -> Component:
    """Return what rounds of simulations teach about the posterior around a mode.

    Raises
    ------
    NumericalError
        Most points near the mode cannot be simulated.
    """
    points, outputs, size = mode.points, mode.outputs, len(mode.middle)
    walkers = _first_walkers(target, mode, rng)
    surrogate, error, rounds = None, np.inf, 0
    while surrogate is None or (rounds < _MAX_ROUNDS and error > _MAX_LIKELIHOOD_ERROR):
        rounds += 1
        fresh = walkers[rng.choice(len(walkers), 20 + 6 * size + 10 * rounds, replace=False)]
        try:
            simulated = simulated_at(target, fresh)
        except NumericalError:  # of most ends of the ridge
            if surrogate is not None or rounds > 1:
                raise
            walkers = _about(mode, [mode.middle], 1 / np.sqrt(_LEARNED_POWER), rng)
            continue
        if surrogate is not None:
            error = log_error(target, surrogate.log_likelihood(fresh), fresh, simulated, _LEARNED_POWER)
        points, outputs = _joined(points, outputs, fresh, simulated)
        surrogate = _learned(target, points, outputs, walkers, surrogate)
        walkers = moved(surrogate.log_learned, walkers, _ROUND_STEPS, rng).points[-1]
    return Component(surrogate, points, outputs, walkers, mode.halves, rounds)


def _first_walkers(target: Target, mode: Climbed, rng: np.random.Generator) -> np.ndarray:
    """Return walkers all along the ridge of a mode, which may be long and bent; where it is not seen, about its top."""
    size = len(mode.middle)
    ridge = [mode.middle, *_ridge(target, mode, rng)]
    return _about(mode, ridge, _RIDGE_WIDTH if len(ridge) > size else 1 / np.sqrt(_LEARNED_POWER), rng)


def _about(mode: Climbed, places: Sequence[np.ndarray], width: float, rng: np.random.Generator) -> np.ndarray:
    """Return walkers that scatter about places, by so many widths of a mode."""
    scatter = width * rng.standard_normal((_ROUND_WALKERS, len(mode.middle))) @ mode.root.T
    return np.array(places)[rng.integers(len(places), size=_ROUND_WALKERS)] + scatter


def _ridge(target: Target, mode: Climbed, rng: np.random.Generator) -> Iterator[np.ndarray]:
    """Yield points of the density that rounds learn, exact where outputs are linear.

    Each is the optimum for another draw of prior and errors (randomized maximum likelihood: Kitanidis, Water Resour.
    Res. 31 (1995), 2411; Oliver, Math. Geol. 28 (1996), 1). The linear model climbs, moved to what was simulated at the
    mode; ends that are hopeless under the data themselves are left out.
    """
    offset = mode.output - target.linear(mode.middle[np.newaxis])[0]
    residuals = np.tile(target.measured - mode.output, (_RIDGE_POINTS, 1))
    errors = target.noise.drawn(residuals, np.zeros_like(mode.output), rng).noise / np.sqrt(_LEARNED_POWER)
    centers = rng.standard_normal((_RIDGE_POINTS, len(mode.middle))) / np.sqrt(_LEARNED_POWER)
    lowest = target.log_height(mode.middle, mode.output) - _MAX_RIDGE_NATS * len(mode.middle)
    for error, center in zip(errors, centers, strict=True):

        def shifted(points: np.ndarray, center: np.ndarray = center) -> np.ndarray:
            return target.linear(points + center) + offset

        try:
            end = climb(shifted, target.measured + error, target.noise, 0 * center, step=_RIDGE_STEP)
        except NumericalError:  # the linear model has no answer there
            continue
        if target.log_height(end.middle + center, end.output) > lowest:
            yield end.middle + center


def taught(target: Target, component: Component, fresh: np.ndarray, simulated: np.ndarray) -> Component:
    """Return a component that knows further simulations, which lie where it is to be used."""
    points, outputs = _joined(component.points, component.outputs, fresh, simulated)
    surrogate = component.surrogate.knowing(points, outputs)
    return replace(component, surrogate=surrogate, points=points, outputs=outputs, rounds=component.rounds + 1)


def log_prior(points: np.ndarray) -> np.ndarray:
    """Return the log density of the standard normal distribution at points, shape (point, unknown)."""
    return -0.5 * ((points**2).sum(axis=1) + points.shape[1] * np.log(2 * np.pi))


def simulated_at(target: Target, points: np.ndarray) -> np.ndarray:
    """Return the simulated outputs; raises `NumericalError` where most points cannot be simulated."""
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
    residuals = target.measured - outputs[-len(around) // 2 :]
    scale = np.sqrt(target.noise.variance(residuals) + np.diag(target.noise.measured))
    lengths = None if before is None else before.emulator.lengths
    emulator = fit_emulator(points, outputs, around, scale, target.coordinates, lengths)
    return Surrogate(emulator, target.measured, target.noise.narrowed(residuals, _MIN_TERM_SHARE))


def moved(
    log_density: LogDensity, walkers: np.ndarray, steps: int, rng: np.random.Generator, groups: int = 1
) -> Ensemble:
    """Let groups of walkers move; those that the emulator cannot answer start from places of others."""
    lost = ~np.isfinite(log_density(walkers))
    begin = walkers.copy()
    begin[lost] = walkers[rng.choice(np.flatnonzero(~lost), int(lost.sum()))]
    return sample(log_density, begin, steps, rng, groups=groups)


def log_error(target: Target, foretold: np.ndarray, points: np.ndarray, outputs: np.ndarray, power: float) -> float:
    """Return the SD of the error of the foretold log-likelihood in the posterior, from draws of a power of it."""
    good = np.isfinite(outputs).all(axis=1)
    true = target.log_likelihood(outputs[good])
    missed, height = true - foretold[good], true + log_prior(points[good])
    weight = np.exp((1 - power) * (height - height.max()))
    return float(np.sqrt(np.average((missed - np.average(missed, weights=weight)) ** 2, weights=weight)))
