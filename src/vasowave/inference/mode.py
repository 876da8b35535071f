"""The way to the mode of a posterior, by damped Gauss-Newton steps, and the normal distribution around it."""

from dataclasses import dataclass

import numpy as np

from vasowave.errors import NumericalError
from vasowave.inference.discrepancy import Discrepancy
from vasowave.inference.simulations import Simulate

_MOST = 4  # steps: the rounds that follow need the mode only roughly
_STEP = 0.1  # of the differences, in SD of the prior
_NEAR = 0.1  # squared length of a step, in SD of the posterior, after which none follows
_SHARES = (1.0, 0.5, 0.2)  # of a step that are tried


@dataclass(frozen=True, eq=False)
class Climbed:
    """All points simulated on the way, and mean and Cholesky factor of the covariance at its end (Laplace)."""

    points: np.ndarray
    outputs: np.ndarray
    middle: np.ndarray
    root: np.ndarray


def climb(simulate: Simulate, measured: np.ndarray, noise: Discrepancy, start: np.ndarray) -> Climbed:
    """Climb from a point, shape (unknown,), with the prior N(0, 1); raises `NumericalError` where it cannot start."""
    here, y = start, simulate(start[np.newaxis])[0]
    if not np.isfinite(y).all():
        raise NumericalError("the start cannot be simulated; give a fit to start from, or other priors")
    points, outputs = [here], [y]
    for _ in range(_MOST):
        near = here + _STEP * np.eye(len(here))
        simulated = simulate(near)
        points += list(near)
        outputs += list(simulated)
        mean, root = _normal(noise, measured, here, y, np.nan_to_num((simulated - y) / _STEP).T)
        better = _better(simulate, measured, noise, here, y, mean)
        if better is None:
            break
        step = np.sum(np.linalg.solve(root, better[0] - here) ** 2)
        here, y = better
        points.append(here)
        outputs.append(y)
        if step < _NEAR:
            break
    good = np.isfinite(outputs).all(axis=1)
    return Climbed(np.array(points)[good], np.array(outputs)[good], here, root)


def _normal(
    noise: Discrepancy, measured: np.ndarray, here: np.ndarray, y: np.ndarray, J: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and Cholesky factor of the covariance of the posterior if outputs were linear around `here`."""
    total = np.diag(noise.variance((measured - y)[np.newaxis])) + noise.measured + noise.vessels @ noise.vessels.T
    gain = np.linalg.solve(total, J).T
    covariance = np.linalg.inv(gain @ J + np.eye(len(here)))
    mean = covariance @ (gain @ (measured - y + J @ here))
    return mean, np.linalg.cholesky(0.5 * (covariance + covariance.T))


def _better(
    simulate: Simulate, measured: np.ndarray, noise: Discrepancy, here: np.ndarray, y: np.ndarray, aim: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the first better point, with its outputs, on the way back from `aim`; None if none is better."""

    def height(point: np.ndarray, output: np.ndarray) -> float:
        return float(noise.log_likelihood(measured - output)) - 0.5 * float(point @ point)

    for share in _SHARES:
        point = here + share * (aim - here)
        output = simulate(point[np.newaxis])[0]
        if np.isfinite(output).all() and height(point, output) > height(here, y):
            return point, output
    return None
