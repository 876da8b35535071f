"""Noise models: what is known about the covariance of the residuals, as likelihood and as whitening."""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.linalg import solve_triangular

from vasowave.base.errors import InputError, NumericalError
from vasowave.pulse.noise.spectrum import fourier, harmonics


def whiten(values: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Return L⁻¹ values with Σ = LLᵀ, for residuals (sample,) or a Jacobian (sample, parameter)."""
    return solve_triangular(cholesky_factor(covariance), values, lower=True)


def log_likelihood(residuals: np.ndarray, covariance: np.ndarray) -> float:
    """Gaussian log-likelihood of the residuals (eq. 23).

    Raises
    ------
    NumericalError
        If the covariance is not positive definite; regularize it first.
    """
    factor = cholesky_factor(covariance)
    white = solve_triangular(factor, residuals, lower=True)
    return float(-0.5 * len(white) * np.log(2 * np.pi) - np.log(np.diag(factor)).sum() - 0.5 * white @ white)


def cholesky_factor(covariance: np.ndarray) -> np.ndarray:
    """Return the lower triangular L with Σ = LLᵀ; `NumericalError` if Σ is not positive definite."""
    try:
        return np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        raise NumericalError("the covariance is not positive definite; regularize it first") from None


class Noise(Protocol):
    """What model comparison and generalized least squares ask of a noise model."""

    @property
    def weight(self) -> float:
        """λ of the regularization; 0 where none is needed."""
        ...

    @property
    def hyperparameters(self) -> dict[str, float]:
        """Fitted values by name, with units in the names."""
        ...

    @property
    def log_determinant(self) -> float:
        """Logarithm of the determinant of the covariance."""
        ...

    def log_likelihood(self, residuals: np.ndarray) -> float:
        """Gaussian log-likelihood of residuals, shape (sample,) (eq. 23)."""
        ...

    def whiten(self, values: np.ndarray) -> np.ndarray:
        """Return residuals (sample,) or a Jacobian (sample, parameter) in coordinates where the noise is white."""
        ...


@dataclass(frozen=True, eq=False)
class DenseNoise:
    """Any covariance matrix Σ*, mmHg², shape (sample, sample), regularized with λ = `weight`."""

    covariance: np.ndarray
    weight: float
    hyperparameters: dict[str, float]

    @cached_property
    def _factor(self) -> np.ndarray:
        return cholesky_factor(self.covariance)

    @property
    def log_determinant(self) -> float:
        """Logarithm of the determinant of Σ*."""
        return 2 * float(np.log(np.diag(self._factor)).sum())

    def log_likelihood(self, residuals: np.ndarray) -> float:
        """Gaussian log-likelihood (eq. 23)."""
        return _log_likelihood(self, residuals)

    def whiten(self, values: np.ndarray) -> np.ndarray:
        """Return L⁻¹ values with Σ* = LLᵀ."""
        from scipy.linalg import solve_triangular

        return solve_triangular(self._factor, values, lower=True, check_finite=False)


@dataclass(frozen=True, eq=False)
class CirculantNoise:
    """Periodic stationary noise: its covariance is circulant, so Fourier coefficients are independent.

    Attributes
    ----------
    power : array, shape (sample//2 + 1,)
        Eigenvalues S_k of the covariance at harmonics 0 … N//2, mmHg².
    samples : int
        N.
    hyperparameters : dict
    """

    power: np.ndarray
    samples: int
    hyperparameters: dict[str, float]
    weight: float = 0.0

    @property
    def covariance(self) -> np.ndarray:
        """The circulant matrix itself, mmHg², shape (sample, sample)."""
        from scipy.linalg import circulant

        return circulant(np.fft.irfft(self.power, self.samples))

    @property
    def log_determinant(self) -> float:
        """Logarithm of the determinant of the covariance."""
        return float(np.log(self.power[harmonics(self.samples)]).sum())

    def log_likelihood(self, residuals: np.ndarray) -> float:
        """Gaussian log-likelihood (eq. 23), summed over harmonics; no matrix is formed."""
        return _log_likelihood(self, residuals)

    def whiten(self, values: np.ndarray) -> np.ndarray:
        """Return the real Fourier coefficients divided by their standard deviations; shape as `values`."""
        values = np.asarray(values, dtype=float)
        if len(values) != self.samples:
            raise InputError(f"{len(values)} residuals, but the noise model was fitted to {self.samples}")
        scale = np.sqrt(self.power[harmonics(self.samples)])
        return fourier(values) / scale.reshape(-1, *([1] * (values.ndim - 1)))


def _log_likelihood(noise: Noise, residuals: np.ndarray) -> float:
    white = noise.whiten(residuals)
    return float(-0.5 * (len(white) * np.log(2 * np.pi) + noise.log_determinant + white @ white))
