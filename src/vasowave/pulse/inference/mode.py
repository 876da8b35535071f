"""The way to a mode of a posterior, by damped Gauss-Newton steps, and the normal distribution around it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.inference.discrepancy import Discrepancy
from vasowave.pulse.inference.simulations import Simulate


@dataclass(frozen=True)
class AscentRules:
    """How a mode is climbed to.

    Attributes
    ----------
    max_steps : int
        Steps of a climb.
    difference_step : float
        Step of the differences, in SD of the prior.
    min_step_square : float
        Squared length of a step, in SD of the posterior, after which none follows.
    min_gain : float
        Nats gained by a step, after which none follows.
    step_shares : tuple of float
        Shares of a step that are tried.
    learned_steps : int
        Steps whose points the emulator learns from: those before are far away.
    max_bend : float
        Nats by which a point in the bowl of a mode may lie lower than the normal distribution says.
    """

    max_steps: int = 15
    difference_step: float = 0.1
    min_step_square: float = 0.1
    min_gain: float = 0.05
    step_shares: tuple[float, ...] = (1.0, 0.5, 0.2, 0.05)
    learned_steps: int = 2
    max_bend: float = 3.0


RULES = AscentRules()


@dataclass(frozen=True, eq=False)
class Climbed:
    """Where a climb ended, and the normal distribution there (Laplace).

    Attributes
    ----------
    points, outputs : array, shape (point, unknown), (point, output)
        Simulated in the last steps.
    middle : array, shape (unknown,)
    output : array, shape (output,)
        Simulated there.
    root : array, shape (unknown, unknown)
        Cholesky factor of the covariance.
    height : float
        Log-likelihood and log prior at the middle, up to a constant.
    halves : frozenset of int
        Which halves of the starts, 0 and 1, led here.
    """

    points: np.ndarray
    outputs: np.ndarray
    middle: np.ndarray
    output: np.ndarray
    root: np.ndarray
    height: float
    halves: frozenset[int] = frozenset((0, 1))

    def holds(self, point: np.ndarray, height: float) -> bool:
        """Whether a point of some height lies in the bowl of this mode."""
        square = float(np.sum(np.linalg.solve(self.root, point - self.middle) ** 2))
        return square < 2 * len(point) and height > self.height - 0.5 * square - RULES.max_bend

    def log_evidence(self, noise: Discrepancy, measured: np.ndarray) -> float:
        """Return the logarithm of the integral of likelihood and prior around the mode, as of a normal density."""
        return _height(noise, measured, self.middle, self.output) + float(np.log(np.diag(self.root)).sum())


def climb(
    simulate: Simulate,
    measured: np.ndarray,
    noise: Discrepancy,
    start: np.ndarray,
    modes: Sequence[Climbed] = (),
    step: float = RULES.difference_step,
    sloping: Simulate | None = None,
) -> Climbed:
    """Climb from a point, shape (unknown,), with the prior N(0, 1), to the mode or into the bowl of a known one.

    Derivatives are those of `sloping`, which costs less, if given.

    Raises
    ------
    NumericalError
        The start cannot be simulated.
    """
    point, y = start, simulate(start[np.newaxis])[0]
    if not np.isfinite(y).all():
        raise NumericalError("the start cannot be simulated; give a fit to start from, or other priors")
    height, history = _height(noise, measured, point, y), [(start[np.newaxis], y[np.newaxis])]
    for _ in range(RULES.max_steps):
        neighbors = point + step * np.eye(len(point))
        if sloping is None:
            base, changed = y, simulate(neighbors)
            history.append((neighbors, changed))
        else:
            base, changed = np.split(sloping(np.vstack([point, neighbors])), [1])
        mean, root = _normal(noise, measured, point, y, np.nan_to_num((changed - base) / step).T)
        better = _better(simulate, measured, noise, point, height, mean)
        if better is None:
            break
        gain, square = better[2] - height, np.sum(np.linalg.solve(root, better[0] - point) ** 2)
        point, y, height = better
        history.append((point[np.newaxis], y[np.newaxis]))
        if square < RULES.min_step_square or gain < RULES.min_gain or any(mode.holds(point, height) for mode in modes):
            break
    points, outputs = (np.concatenate(arrays) for arrays in zip(*history[-2 * RULES.learned_steps :], strict=True))
    good = np.isfinite(outputs).all(axis=1)
    return Climbed(points[good], outputs[good], point, y, root, height)


def _height(noise: Discrepancy, measured: np.ndarray, point: np.ndarray, output: np.ndarray) -> float:
    return float(noise.log_likelihood(measured - output)) - 0.5 * float(point @ point)


def _normal(
    noise: Discrepancy, measured: np.ndarray, point: np.ndarray, y: np.ndarray, J: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and Cholesky factor of the covariance of the posterior if outputs were linear around `point`."""
    residual = measured - y
    total = np.diag(noise.variance(residual[np.newaxis])) + noise.measured + noise.vessels @ noise.vessels.T
    if noise.passed is not None:
        residual, J = noise.passed.counted(residual), noise.passed.slope(residual) @ J
    gain = np.linalg.solve(total, J).T
    covariance = np.linalg.inv(gain @ J + np.eye(len(point)))
    mean = covariance @ (gain @ (residual + J @ point))
    return mean, np.linalg.cholesky(0.5 * (covariance + covariance.T))


def _better(
    simulate: Simulate, measured: np.ndarray, noise: Discrepancy, start: np.ndarray, height: float, aim: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Return the first better point on the way back from `aim`, its outputs and height; None if none is better."""
    for share in RULES.step_shares:
        point = start + share * (aim - start)
        output = simulate(point[np.newaxis])[0]
        if np.isfinite(output).all():
            reached = _height(noise, measured, point, output)
            if reached > height:
                return point, output, reached
    return None
