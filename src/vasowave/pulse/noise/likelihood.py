"""Noise models by maximum likelihood, from series of residuals: kernels, and their hyperparameters.

Every kernel maps times t, shape (sample,), to a matrix of shape (sample, sample), its amplitude being 1.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from vasowave.base.errors import InputError, NumericalError
from vasowave.pulse.noise.models import CirculantNoise, DenseNoise, Noise
from vasowave.pulse.noise.spectrum import falling_power

Bounds = tuple[tuple[str, float, float, int], ...]
"""(Name with unit, lower, upper, power): bounds in units of T; the fitted value times T**power is reported."""
_EXPLORED_SAMPLES = 128  # samples on which the starts of a dense covariance are explored; the best is refined on all
_MAX_CONDITION_NUMBER = 1e4  # the paper's largest condition number
_LENGTH = (("length [s]", 1e-3, 10.0, 1),)


def squared_exponential(t: np.ndarray, length: float) -> np.ndarray:
    """Squared exponential exp(-d²/2ℓ²)."""
    return np.exp(-0.5 * (_distance(t) / length) ** 2)


def matern32(t: np.ndarray, length: float) -> np.ndarray:
    """Matérn 3/2, (1 + s) exp(-s) with s = √3 d/ℓ."""
    s = np.sqrt(3.0) * _distance(t) / length
    return (1 + s) * np.exp(-s)


def matern52(t: np.ndarray, length: float) -> np.ndarray:
    """Matérn 5/2, (1 + s + s²/3) exp(-s) with s = √5 d/ℓ."""
    s = np.sqrt(5.0) * _distance(t) / length
    return (1 + s + s**2 / 3) * np.exp(-s)


def periodic(t: np.ndarray, length: float, period: float) -> np.ndarray:
    """Periodic, exp(-2 sin²(πd/T)/ℓ²)."""
    return np.exp(-2 * (np.sin(np.pi * _distance(t) / period) / length) ** 2)


def neural_network(t: np.ndarray, offset: float, slope: float) -> np.ndarray:
    """Arcsine kernel (2/π) asin(2x·x'/√((1 + 2x·x)(1 + 2x'·x'))), x·x' = offset² + slope² t t'.

    Rasmussen & Williams, eq. 4.29, with the factor 2.
    """
    inner = offset**2 + slope**2 * np.outer(t, t)
    norm = 1 + 2 * np.diag(inner)
    return 2 / np.pi * np.arcsin(2 * inner / np.sqrt(np.outer(norm, norm)))


def regularize(covariance: np.ndarray, largest_condition: float = _MAX_CONDITION_NUMBER) -> tuple[np.ndarray, float]:
    """Return Σ* = (1-λ)Σ + λσ²I with the smallest λ whose 2-norm condition number is at most the given one, and λ.

    σ² = trace(Σ)/N; λ cannot exceed N/(largest_condition - 1 + N).

    Raises
    ------
    InputError
        A matrix that is not square, symmetric and finite, or has no variance.
    """
    sigma = np.asarray(covariance, dtype=float)
    if sigma.ndim != 2 or sigma.shape[0] != sigma.shape[1] or not np.all(np.isfinite(sigma)):
        raise InputError(f"covariance has shape {sigma.shape} or is not finite; it must be a finite square matrix")
    variance = float(np.trace(sigma)) / len(sigma)
    if variance <= 0 or not np.allclose(sigma, sigma.T, atol=1e-12 * variance):
        raise InputError("covariance is not symmetric or has no variance")
    # Round-off makes the smallest eigenvalues of a smooth kernel slightly negative; they are kept as they are.
    eigenvalues = np.linalg.eigvalsh(sigma / variance)
    weight = smallest_weight(eigenvalues[0], eigenvalues[-1], 1.0, largest_condition)
    return (1 - weight) * sigma + weight * variance * np.eye(len(sigma)), weight


def smallest_weight(lowest: float, highest: float, variance: float, largest_condition: float) -> float:
    """Smallest λ that brings the 2-norm condition number down, for a covariance with these extreme eigenvalues."""
    excess = highest - largest_condition * lowest
    return excess / (excess + (largest_condition - 1) * variance) if excess > 0 else 0.0


def _distance(t: np.ndarray) -> np.ndarray:
    return np.abs(np.subtract.outer(t, t))


class NoiseFamily(Protocol):
    """Noise models of unit amplitude that differ in their hyperparameters."""

    @property
    def hyperparameters(self) -> Bounds:
        """What may be fitted."""
        ...

    @property
    def dense(self) -> bool:
        """Whether a likelihood costs N³, so that starts are explored on fewer samples."""
        ...

    def noise(self, count: int, theta: np.ndarray) -> Noise:
        """Return the noise model of `count` samples of one period."""
        ...


@dataclass(frozen=True)
class Kernel:
    """A Gaussian-process kernel in unit time t/T with unit amplitude, and what may be fitted in it.

    Attributes
    ----------
    matrix : callable
        (t/T, *hyperparameters) to a matrix, shape (sample, sample).
    hyperparameters : tuple of (name with unit, lower, upper, power)
    stationary : bool
        Whether the covariance depends on the distance alone.
    """

    matrix: Callable[..., np.ndarray]
    hyperparameters: Bounds
    stationary: bool = True
    dense: bool = True

    def noise(self, count: int, theta: np.ndarray) -> DenseNoise:
        """Return the noise regularized to a 2-norm condition number of 10⁴: smooth kernels are singular without."""
        K = self.matrix(np.arange(count) / count, *theta)
        eigenvalues, variance = self._eigenvalues(K), float(np.trace(K)) / count
        weight = smallest_weight(eigenvalues.min(), eigenvalues.max(), variance, _MAX_CONDITION_NUMBER)
        K *= 1 - weight
        K[np.diag_indices(count)] += weight * variance
        return DenseNoise(K, weight, {})

    def _eigenvalues(self, K: np.ndarray) -> np.ndarray:
        count = len(K)
        if count % 2 or not self.stationary:
            return np.linalg.eigvalsh(K)
        # The same backwards: vectors are even or odd about the middle, and both kinds are half as long.
        half, across = K[: count // 2, : count // 2], K[: count // 2, : count // 2 - 1 : -1]
        return np.linalg.eigvalsh(np.stack([half + across, half - across])).ravel()


@dataclass(frozen=True)
class PeriodicStationary:
    """A Matérn process on the circle over a floor of white noise, S_k = (1 + (k/k0)²)^-s + floor."""

    hyperparameters: Bounds = (("corner harmonic", 0.1, 200.0, 0), ("slope", 0.26, 8.0, 0), ("floor", 1e-10, 1.0, 0))
    dense: bool = False

    def noise(self, count: int, theta: np.ndarray) -> CirculantNoise:
        """Return the circulant noise; its smoothness is s - 1/2."""
        k = np.arange(count // 2 + 1)
        return CirculantNoise(falling_power(k, theta[0], theta[1]) + theta[2], count, {})


@dataclass(frozen=True)
class Independent:
    """White noise."""

    hyperparameters: Bounds = ()
    dense: bool = False

    def noise(self, count: int, theta: np.ndarray) -> CirculantNoise:
        """Return noise of unit variance."""
        return CirculantNoise(np.ones(count // 2 + 1), count, {})


KERNELS = {
    "squared exponential": Kernel(squared_exponential, _LENGTH),
    "Matern 3/2": Kernel(matern32, _LENGTH),
    "Matern 5/2": Kernel(matern52, _LENGTH),
    "neural network": Kernel(neural_network, (("offset", 1e-2, 1e2, 0), ("slope [1/s]", 1e-1, 1e4, -1)), False),
    "periodic": Kernel(lambda t, length: periodic(t, length, 1.0), (("length", 2e-2, 20.0, 0),)),
}
"""The paper's Gaussian-process kernels by name."""

FAMILIES: dict[str, NoiseFamily] = {**KERNELS, "circulant": PeriodicStationary(), "independent": Independent()}
"""Everything but ARMA, whose orders are fitted too."""


def fit_kernel(
    kernel: Kernel, residuals: np.ndarray, period: float, rng: np.random.Generator, starts: int = 4
) -> tuple[np.ndarray, dict[str, float]]:
    """Maximum-likelihood covariance (unregularized), mmHg², and its hyperparameters.

    The likelihood is the joint one of all series, eq. 23 with the covariance regularized to a 2-norm condition number
    of 10⁴. The amplitude is maximized in closed form, the other hyperparameters as logarithms by L-BFGS-B.

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
    theta, amplitude = maximize(kernel, residuals, rng, starts)
    t = np.arange(residuals.shape[1]) / residuals.shape[1]
    return amplitude * kernel.matrix(t, *theta), named(kernel, theta, period, amplitude)


def regularized(sigma: np.ndarray, hyperparameters: dict[str, float]) -> DenseNoise:
    """Return the noise model of a covariance, regularized to a condition number of 10⁴."""
    better, weight = regularize(sigma)
    return DenseNoise(better, weight, hyperparameters)


def concentrated(noise: Noise, residuals: np.ndarray) -> tuple[float, float]:
    """Log-likelihood of all series, (series, sample), maximized over the amplitude of the noise, and that amplitude.

    The noise is given with unit amplitude.
    """
    white = noise.whiten(residuals.T)
    log_det, count = len(residuals) * noise.log_determinant, residuals.size
    amplitude = float(np.sum(white**2)) / count
    return -0.5 * (count * (np.log(2 * np.pi * amplitude) + 1) + log_det), amplitude


def maximize(
    family: NoiseFamily, residuals: np.ndarray, rng: np.random.Generator, starts: int = 4
) -> tuple[np.ndarray, float]:
    """Return the hyperparameters of the greatest likelihood (units of T) and the amplitude; see `concentrated`."""
    count = residuals.shape[1]
    low, high = _log_bounds(family)
    begin = [0.5 * (low + high), *(rng.uniform(low, high) for _ in range(starts - 1))] if len(low) else []
    step = max(1, count // _EXPLORED_SAMPLES) if family.dense else 1
    ends = [_climb(family, residuals[:, ::step], x) for x in begin]
    if ends and step > 1:
        ends = [_climb(family, residuals, min(ends, key=lambda end: end[1])[0])]
    x = min(ends, key=lambda end: end[1])[0] if ends else low
    value, amplitude = concentrated(family.noise(count, np.exp(x)), residuals)
    if not (np.isfinite(value) and amplitude > 0):
        raise NumericalError(f"no optimum of the likelihood from {starts} starts; are the residuals all zero?")
    return np.exp(x), amplitude


def named(family: NoiseFamily, theta: np.ndarray, period: float, amplitude: float) -> dict[str, float]:
    """Return amplitude and hyperparameters by name, in the units of their names."""
    values = {name: float(v * period**power) for (name, _, _, power), v in zip(family.hyperparameters, theta)}
    return {"amplitude [mmHg2]": amplitude, **values}


def _log_bounds(family: NoiseFamily) -> tuple[np.ndarray, np.ndarray]:
    low, high = (np.log([bound[i] for bound in family.hyperparameters]) for i in (1, 2))
    return low, high


def _climb(family: NoiseFamily, residuals: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the top of the likelihood near x, and minus its height per sample."""
    from scipy.optimize import minimize

    low, high = _log_bounds(family)
    level = float(np.log(np.mean(residuals**2)))  # without it the unit of pressure would enter the tolerances

    def objective(x: np.ndarray) -> float:
        value = concentrated(family.noise(residuals.shape[1], np.exp(x)), residuals)[0] / residuals.size
        return -value - 0.5 * level if np.isfinite(value) else 1e3

    options = {"ftol": 1e-10, "gtol": 1e-7, "eps": 1e-6, "maxiter": 60}
    end = minimize(objective, x, method="L-BFGS-B", bounds=list(zip(low, high)), options=options)
    return end.x, float(end.fun)
