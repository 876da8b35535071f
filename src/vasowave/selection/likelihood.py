"""Hyperparameters of noise models by maximum likelihood, from one or several series of residuals."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vasowave.errors import NumericalError
from vasowave.selection import covariance
from vasowave.selection.noise import CirculantNoise, DenseNoise, real_fourier, real_harmonics

Bounds = tuple[tuple[str, float, float, int], ...]


@dataclass(frozen=True)
class Kernel:
    """A kernel in unit time t/T with unit amplitude, and what may be fitted in it.

    Attributes
    ----------
    matrix : callable
        (t/T, *hyperparameters) to a matrix, shape (sample, sample).
    hyperparameters : tuple of (name with unit, lower, upper, power)
        Bounds in units of T; the fitted value times T**power is reported.
    """

    matrix: Callable[..., np.ndarray]
    hyperparameters: Bounds


_LENGTH = (("length [s]", 1e-3, 10.0, 1),)

KERNELS = {
    "squared exponential": Kernel(covariance.squared_exponential, _LENGTH),
    "Matern 3/2": Kernel(covariance.matern32, _LENGTH),
    "Matern 5/2": Kernel(covariance.matern52, _LENGTH),
    "neural network": Kernel(covariance.neural_network, (("offset", 1e-2, 1e2, 0), ("slope [1/s]", 1e-1, 1e4, -1))),
    "periodic": Kernel(lambda t, length: covariance.periodic(t, length, 1.0), (("length", 2e-2, 20.0, 0),)),
}
"""The paper's Gaussian-process kernels by name."""

_CIRCULANT: Bounds = (("corner harmonic", 0.1, 200.0, 0), ("slope", 0.26, 8.0, 0), ("floor", 1e-10, 1.0, 0))


def fit_kernel(
    kernel: Kernel, residuals: np.ndarray, period: float, rng: np.random.Generator, starts: int = 4
) -> tuple[np.ndarray, dict[str, float]]:
    """Maximum-likelihood covariance (unregularized), mmHg², and its hyperparameters.

    The likelihood is the joint one of all series, eq. 23 with the covariance regularized to a 2-norm condition number
    of 10⁴: smooth kernels are singular in double precision, so without that it cannot be computed. The amplitude
    is maximized in closed form, the other hyperparameters as logarithms by L-BFGS-B with an exact gradient.

    Parameters
    ----------
    kernel : Kernel
    residuals : array, shape (series, sample)
        mmHg, evenly spaced over one period.
    period : float
        T, s.
    rng : numpy.random.Generator
        Draws all starts but the first, which is the middle of the bounds.
    starts : int

    Raises
    ------
    NumericalError
        No start reached an optimum.
    """
    t = np.arange(residuals.shape[1]) / residuals.shape[1]
    theta = _maximize(lambda x: _kernel_objective(kernel.matrix, t, residuals, x), kernel.hyperparameters, rng, starts)
    matrix = kernel.matrix(t, *theta)
    white = _regularized_inverse(matrix)[0]
    amplitude = float(np.einsum("si,ij,sj->", residuals, white, residuals)) / residuals.size
    return amplitude * matrix, _named(kernel.hyperparameters, theta, period, amplitude)


def fit_circulant(residuals: np.ndarray, rng: np.random.Generator, starts: int = 4) -> CirculantNoise:
    """Maximum-likelihood periodic stationary noise with S_k = σ² ((1 + (k/k0)²)^-s + floor).

    A Matérn process on the circle (s = smoothness + 1/2) over a floor of white noise. It needs no regularization.
    Parameters, errors: as `fit_kernel`.
    """
    count = residuals.shape[1]
    k = real_harmonics(count)
    energy = (np.stack([real_fourier(r) for r in residuals]) ** 2).mean(0)

    def shape(theta: np.ndarray) -> np.ndarray:
        return (1 + (np.arange(count // 2 + 1) / theta[0]) ** 2) ** -theta[1] + theta[2]

    def objective(x: np.ndarray) -> float:
        S = shape(np.exp(x))[k]
        return float(0.5 * (np.log(np.mean(energy / S)) + np.log(S).mean()))

    theta = _maximize(objective, _CIRCULANT, rng, starts, gradient=False)
    amplitude = float(np.mean(energy / shape(theta)[k]))
    return CirculantNoise(amplitude * shape(theta), count, _named(_CIRCULANT, theta, 1.0, amplitude))


def regularized(sigma: np.ndarray, hyperparameters: dict[str, float], norm: int) -> DenseNoise:
    """Return the noise model of a covariance, regularized to a condition number of 10⁴ in the given norm."""
    better, weight = covariance.regularize(sigma, norm=norm)
    return DenseNoise(better, weight, hyperparameters)


def _maximize(
    objective: Callable, bounds: Bounds, rng: np.random.Generator, starts: int, gradient: bool = True
) -> np.ndarray:
    from scipy.optimize import minimize

    low, high = (np.log([b[i] for b in bounds]) for i in (1, 2))
    found = []
    for start in range(starts):
        x = 0.5 * (low + high) if start == 0 else rng.uniform(low, high)
        found.append(minimize(objective, x, jac=gradient, method="L-BFGS-B", bounds=list(zip(low, high))))
    best = min(found, key=lambda result: result.fun if np.isfinite(result.fun) else np.inf)
    if not np.isfinite(best.fun):
        raise NumericalError(f"no optimum of the likelihood from {starts} starts; are the residuals all zero?")
    return np.exp(best.x)


def _kernel_objective(
    matrix: Callable[..., np.ndarray], t: np.ndarray, residuals: np.ndarray, x: np.ndarray
) -> tuple[float, np.ndarray]:
    """Return minus the log-likelihood per sample (without constants) and its gradient in the log-hyperparameters."""
    series, count = residuals.shape
    K = matrix(t, *np.exp(x))
    inverse, log_det, turned = _regularized_inverse(K)
    alpha = residuals @ inverse
    amplitude = float((alpha * residuals).sum()) / (series * count)
    value = 0.5 * (np.log(amplitude) + log_det / count)
    sensitivity = inverse / count - alpha.T @ alpha / (amplitude * series * count)
    slopes = np.empty(len(x))
    for i in range(len(x)):
        step = np.zeros(len(x))
        step[i] = 1e-5
        dK = (matrix(t, *np.exp(x + step)) - matrix(t, *np.exp(x - step))) / 2e-5
        slopes[i] = 0.5 * np.sum(sensitivity * turned(dK))
    return value, slopes


def _regularized_inverse(
    K: np.ndarray, largest_condition: float = 1e4
) -> tuple[np.ndarray, float, Callable[[np.ndarray], np.ndarray]]:
    """Return Σ*⁻¹, log det Σ*, and the map from a change dΣ to dΣ*."""
    w, V = np.linalg.eigh(K)
    identity, variance = np.eye(len(K)), float(np.trace(K)) / len(K)
    weight = covariance.smallest_weight(w[0], w[-1], variance, largest_condition)
    mixed = (1 - weight) * w + weight * variance

    def turned(dK: np.ndarray) -> np.ndarray:
        d_variance = float(np.trace(dK)) / len(K)
        d_weight = 0.0
        if weight > 0:
            excess = w[-1] - largest_condition * w[0]
            d_excess = V[:, -1] @ dK @ V[:, -1] - largest_condition * (V[:, 0] @ dK @ V[:, 0])
            rest = largest_condition - 1
            d_weight = rest * (variance * d_excess - excess * d_variance) / (excess + rest * variance) ** 2
        return (1 - weight) * dK + weight * d_variance * identity + d_weight * (variance * identity - K)

    return (V / mixed) @ V.T, float(np.log(mixed).sum()), turned


def _named(bounds: Bounds, theta: np.ndarray, period: float, amplitude: float) -> dict[str, float]:
    values = {name: float(value * period**power) for (name, _, _, power), value in zip(bounds, theta)}
    return {"amplitude [mmHg2]": amplitude, **values}
