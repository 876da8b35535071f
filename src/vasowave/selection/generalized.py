"""Parameters and intervals by generalized least squares, with the noise as uncertain as the data leave it.

A fit absorbs noise along the derivatives of its parameters, and few periods of the slow noise fit into one cycle: both
make intervals from a plugged-in covariance too short. So the hyperparameters are estimated by restricted likelihood,
and the intervals average over their posterior.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from vasowave.calibration import Fit
from vasowave.calibration.generalized import Optimum, Whiten, least_squares_optimum, reoptimize
from vasowave.calibration.parameters import UNITS
from vasowave.errors import InputError, NumericalError
from vasowave.noise.likelihood import FAMILIES, Family, concentrated, maximize
from vasowave.noise.models import Noise
from vasowave.recording import resample, samples_needed
from vasowave.solver.simulate import Numerics

_DRAWS = 300
_MOST_WORSE = 2.0  # root-mean-square residual over that of least squares
_EVERY = 5  # steps of the random walk between two draws that are kept


@dataclass(frozen=True, eq=False)
class Mixture:
    """What residuals say about small shifts of the logarithms of the parameters: a mixture of normal distributions.

    Attributes
    ----------
    shift : array, shape (draw, parameter)
        Where the generalized-least-squares optimum of each draw of the hyperparameters lies.
    covariance : array, shape (draw, parameter, parameter)
        Of the parameters, given each.
    """

    shift: np.ndarray
    covariance: np.ndarray

    def interval(self, direction: np.ndarray, level: float = 0.95) -> tuple[float, float]:
        """Return the equal-tailed interval of the combination `direction` of the logarithms."""
        from scipy.optimize import brentq
        from scipy.special import ndtr

        mean = self.shift @ direction
        spread = np.sqrt(np.einsum("i,dij,j->d", direction, self.covariance, direction))
        low, high = float((mean - 12 * spread).min()), float((mean + 12 * spread).max())

        def above(x: float, tail: float) -> float:
            return float(np.mean(ndtr((x - mean) / spread))) - tail

        first, last = (brentq(above, low, high, (tail,)) for tail in (0.5 * (1 - level), 0.5 * (1 + level)))
        return float(first), float(last)

    def standard_error(self, direction: np.ndarray) -> float:
        """Return the standard deviation of that combination."""
        within = np.einsum("i,dij,j->d", direction, self.covariance, direction).mean()
        return float(np.sqrt(within + np.var(self.shift @ direction)))


def noise_posterior(
    family: Family, residual: np.ndarray, jacobian: np.ndarray, rng: np.random.Generator, draws: int = _DRAWS
) -> Mixture:
    """Return what one series of residuals says about its parameters when the hyperparameters of the noise are unknown.

    The hyperparameters get flat priors in their logarithms within their bounds, amplitude and parameters flat ones too;
    a random walk (Metropolis) draws from the restricted likelihood. The model is linearized at its optimum.

    Parameters
    ----------
    family : Family
    residual : array, shape (sample,)
        mmHg.
    jacobian : array, shape (sample, parameter)
        Its derivative by the logarithms of the parameters.
    rng : numpy.random.Generator
    draws : int

    Raises
    ------
    NumericalError
        If the data do not determine some combination of the parameters at all.
    """
    if np.linalg.matrix_rank(jacobian) < jacobian.shape[1]:
        raise NumericalError("a combination of the parameters has no influence; hold one of them")
    best = np.log(maximize(family, residual[np.newaxis], rng, jacobians=[jacobian])[0])

    def height(x: np.ndarray) -> float:
        return concentrated(family.noise(len(residual), np.exp(x)), residual[np.newaxis], [jacobian])[0]

    points = _walk(height, best, family, rng, draws)
    shifts, covariances = zip(*(_given(family, x, residual, jacobian) for x in points))
    return Mixture(np.array(shifts), np.array(covariances))


def generalized_fit(
    fit: Fit,
    covariance: str = "Matern 5/2",
    *,
    level: float = 0.95,
    rounds: int = 2,
    samples: int | None = 512,
    seed: int = 0,
    numerics: Numerics | None = None,
) -> tuple[pd.DataFrame, Optimum]:
    """Fit a model again by generalized least squares; both values of every parameter, and intervals.

    Parameters
    ----------
    fit : Fit
        From `calibrate`: ordinary least squares.
    covariance : str
        Of the noise: a name in `FAMILIES`.
    level : float
        Of the intervals.
    rounds : int
        How often the noise is estimated from the residuals, and the parameters under that noise.
    samples, numerics
        As in `compare_fits`.
    seed : int

    Returns
    -------
    table : DataFrame
        One row per free parameter, and for the tangent wall one for p1/gamma (``p1_over_gamma``): ``unit,
        least_squares, value, standard_error, lower, upper``. Intervals are linear in the logarithms; where a
        parameter is hardly determined `profile_likelihood` tells more.
    optimum : Optimum

    Raises
    ------
    InputError
        An unknown covariance.
    NumericalError
        If a combination of parameters has no influence, or the noise model explains the data away (`explained_away`).
    """
    if covariance not in FAMILIES:
        raise InputError(f"unknown noise model '{covariance}'; known: {', '.join(FAMILIES)}")
    family, rng = FAMILIES[covariance], np.random.default_rng(seed)
    N = fit.N if samples is None else min(samples, samples_needed(fit.recording.pressure))
    optimum = least_squares_optimum(fit, numerics)
    first = optimum
    for _ in range(rounds):
        residual, jacobian = resample(optimum.residual, N), resample(optimum.jacobian, N)
        theta, amplitude = maximize(family, residual[np.newaxis], rng, jacobians=[jacobian])
        noise = family.noise(N, theta)
        optimum = reoptimize(fit, _whitener(noise, amplitude, N), start=optimum.x, numerics=numerics)
    if explained_away(fit, optimum.residual):
        raise NumericalError(
            f"{covariance} noise explains the data away: at its optimum the {fit.wall} wall misses the measured "
            f"pressure by {np.sqrt(np.mean(optimum.residual**2)):.3g} mmHg (least squares: {fit.rmse:.3g}), since its "
            "spectrum gives the slow harmonics no weight. Choose another covariance, or stay with least squares"
        )
    mixture = noise_posterior(family, resample(optimum.residual, N), resample(optimum.jacobian, N), rng)
    return _table(first, optimum, mixture, level), optimum


def explained_away(fit: Fit, residual: np.ndarray) -> bool:
    """Whether a generalized-least-squares optimum misses the data by more than twice what least squares leaves.

    A spectrum that falls steeply takes errors of the mean pressure for likely and puts all weight on the smallest
    harmonics; what is found then is no calibration.
    """
    return bool(np.mean(residual**2) > (_MOST_WORSE * fit.rmse) ** 2)


def _whitener(noise: Noise, amplitude: float, N: int) -> Whiten:
    return lambda values: noise.whiten(resample(values, N)) / np.sqrt(amplitude)


def _table(first: Optimum, optimum: Optimum, mixture: Mixture, level: float) -> pd.DataFrame:
    names = optimum.space.free_names
    directions = dict(zip(names, np.eye(len(names)), strict=True))
    if {"p1", "gamma"} <= set(names):
        directions["p1_over_gamma"] = directions["p1"] - directions["gamma"]
    rows = {}
    for name, direction in directions.items():
        value, (low, high) = np.exp(optimum.x @ direction), np.exp(mixture.interval(direction, level))
        rows[name] = {
            "unit": UNITS.get(name, "mmHg"),
            "least_squares": np.exp(first.x @ direction),
            "value": value,
            "standard_error": value * mixture.standard_error(direction),
            "lower": value * low,
            "upper": value * high,
        }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("parameter")


def _walk(
    height: Callable[[np.ndarray], float], best: np.ndarray, family: Family, rng: np.random.Generator, draws: int
) -> np.ndarray:
    """Return draws of the log hyperparameters within their bounds, shape (draw, hyperparameter)."""
    if len(best) == 0:
        return np.zeros((1, 0))
    low, high = (np.log([bound[i] for bound in family.hyperparameters]) for i in (1, 2))
    values, vectors = np.linalg.eigh(-_curvature(height, best))
    widest = float(((high - low) / 4).max()) ** 2  # flat directions have no curvature
    steps = vectors * np.sqrt(2.4**2 / len(best) / np.maximum(values, 1 / widest))
    here, top, kept = best, height(best), []
    for number in range(draws * _EVERY):
        there = here + steps @ rng.standard_normal(len(best))
        if np.all((there >= low) & (there <= high)):
            reached = height(there)
            if np.log(rng.uniform()) < reached - top:
                here, top = there, reached
        if number % _EVERY == _EVERY - 1:
            kept.append(here)
    return np.array(kept)


def _curvature(height: Callable[[np.ndarray], float], x: np.ndarray, step: float = 0.05) -> np.ndarray:
    """Return the second derivatives by central differences."""
    size = len(x)
    found, moves = np.empty((size, size)), step * np.eye(size)
    for i in range(size):
        for j in range(i + 1):
            ends = [height(x + a * moves[i] + b * moves[j]) * a * b for a, b in ((1, 1), (1, -1), (-1, 1), (-1, -1))]
            found[i, j] = found[j, i] = sum(ends) / (4 * step**2)
    return found


def _given(family: Family, x: np.ndarray, residual: np.ndarray, jacobian: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return shift and covariance of the parameters, given the hyperparameters."""
    noise = family.noise(len(residual), np.exp(x))
    amplitude = concentrated(noise, residual[np.newaxis], [jacobian])[1]
    Q, R = np.linalg.qr(noise.whiten(jacobian))
    inverse = np.linalg.inv(R)
    return -inverse @ (Q.T @ noise.whiten(residual)), amplitude * inverse @ inverse.T
