"""The likelihood of a residual: discrepancy of the model, errors of measurement and of single vessels, one Gaussian.

What no parameters explain is a stationary process on the circle: its Fourier coefficients are independent, and their
variance σ² (1 + (k/k0)²)^-m falls with the harmonic k. Neither σ nor k0 nor m is known; the likelihood is the mean over
their priors. For every shape (k0, m) all other covariances are diagonalized beside it once, so that each σ costs a sum.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vasowave.noise.spectrum import falling_power, harmonics

_SHAPE = np.log([4.0, 2.5]), np.array([0.7, 0.5])
"""Prior of log k0 and log m: mean and SD, as `noise.spectrum` has them, the shape of residuals of measured mice."""

_CORNERS, _SLOPES = 5, 4  # nodes of the quadrature over k0 and m
_AMPLITUDES = 25  # and over σ, evenly spaced in its logarithm over ± 3.5 SD: the likelihood is narrower than the prior
_REACH = 3.5


@dataclass(frozen=True, eq=False)
class Discrepancy:
    """Likelihood of residuals given as orthonormal Fourier coefficients, shape (..., coefficient), mmHg.

    Attributes
    ----------
    samples : int
        Coefficients, an odd number: the mean and the cosines and sines of all harmonics.
    amplitude : (float, float)
        Median (mmHg) and SD of the logarithm of σ, the standard deviation of the discrepancy in the cycle.
    measured : array, shape (coefficient, coefficient)
        Covariance of the errors of measurement, mmHg².
    vessels : array, shape (coefficient, error)
        What one SD of each independent error of a single vessel changes, mmHg.
    """

    samples: int
    amplitude: tuple[float, float]
    measured: np.ndarray
    vessels: np.ndarray

    def log_likelihood(self, residuals: np.ndarray) -> np.ndarray:
        """Return the logarithm of the density of residuals, shape (...)."""
        log = self._by_node(np.atleast_2d(residuals))
        largest = log.max(axis=(0, 2))
        total = np.exp(log - largest[:, np.newaxis]).sum(axis=(0, 2))
        return (largest + np.log(total)).reshape(residuals.shape[:-1])

    def variance(self, residuals: np.ndarray) -> np.ndarray:
        """Return the variance of each coefficient of the discrepancy, mmHg², averaged over residuals (draw, ...)."""
        log = self._by_node(np.atleast_2d(residuals))
        log -= log.max(axis=(0, 2), keepdims=True)
        weight = np.exp(log)
        share = (weight / weight.sum(axis=(0, 2), keepdims=True)).mean(axis=1)
        return np.einsum("sa,a,sk->k", share, self._amplitudes[0] ** 2, self._shapes[0])

    def deviation(self, residuals: np.ndarray) -> np.ndarray:
        """Return the expected standard deviation σ, mmHg, of the discrepancy behind each residual, shape (...)."""
        log = self._by_node(np.atleast_2d(residuals))
        log -= log.max(axis=(0, 2), keepdims=True)
        weight = np.exp(log).sum(axis=0)
        return (weight @ self._amplitudes[0] / weight.sum(axis=1)).reshape(residuals.shape[:-1])

    def _by_node(self, rows: np.ndarray) -> np.ndarray:
        """Return log prior plus log density, shape (shape, draw, amplitude)."""
        turn, precision, constant = self._nodes
        return constant[:, np.newaxis] - 0.5 * ((rows @ turn) ** 2 @ precision)

    @cached_property
    def _nodes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """For every shape: rotation of the residual, precision there by amplitude, and what does not depend on it."""
        turn, values, logdet = self._diagonal
        sigma, log_prior = self._amplitudes
        total = values[:, :, np.newaxis] + sigma**2
        constant = -0.5 * (np.log(2 * np.pi * total).sum(axis=1) + logdet[:, np.newaxis])
        return turn, 1 / total, constant + log_prior + self._shapes[1][:, np.newaxis]

    @cached_property
    def _shapes(self) -> tuple[np.ndarray, np.ndarray]:
        """Variances for σ = 1 of every shape, (shape, coefficient), with mean 1, and log prior weights."""
        corners, weights = _normal_nodes(_CORNERS)
        slopes, others = _normal_nodes(_SLOPES)
        log_k0, log_m = _SHAPE[0][0] + _SHAPE[1][0] * corners, _SHAPE[0][1] + _SHAPE[1][1] * slopes
        k = harmonics(self.samples)
        power = np.array([falling_power(k, np.exp(a), np.exp(b)) for a in log_k0 for b in log_m])
        return power / power.mean(axis=1, keepdims=True), np.log(np.outer(weights, others)).ravel()

    @cached_property
    def _amplitudes(self) -> tuple[np.ndarray, np.ndarray]:
        """Nodes of σ, mmHg, and log prior weights."""
        median, spread = self.amplitude
        if spread == 0:
            return np.array([median]), np.zeros(1)
        score = np.linspace(-_REACH, _REACH, _AMPLITUDES)
        weight = np.exp(-0.5 * score**2)
        return median * np.exp(spread * score), np.log(weight / weight.sum())

    @cached_property
    def _diagonal(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """For every shape S: V with Vᵀ S V = 1 and Vᵀ (other covariance) V diagonal, that diagonal, and log det S."""
        other = self.measured + self.vessels @ self.vessels.T
        scale = np.sqrt(self._shapes[0])
        white = other / (scale[:, :, np.newaxis] * scale[:, np.newaxis, :])
        values, axes = np.linalg.eigh(white)
        return axes / scale[:, :, np.newaxis], np.maximum(values, 0.0), 2 * np.log(scale).sum(axis=1)


def _normal_nodes(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of the Gauss quadrature for the standard normal distribution."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(count)
    return nodes, weights / weights.sum()
