"""Likelihood of residuals, AICc, BIC, and whitening for generalized least squares."""

import numpy as np
from scipy.linalg import solve_triangular

from vasowave.errors import InputError, NumericalError


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


def aicc(log_likelihood: float, parameters: int, samples: int) -> float:
    """AICc = -2 log L + 2D + 2D(D + 1)/(N - D - 1) (eq. 21)."""
    if samples <= parameters + 1:
        raise InputError(f"AICc needs more than {parameters + 1} samples for {parameters} parameters")
    return -2 * log_likelihood + 2 * parameters + 2 * parameters * (parameters + 1) / (samples - parameters - 1)


def bic(log_likelihood: float, parameters: int, samples: int) -> float:
    """BIC = -2 log L + D log N (eq. 22)."""
    return float(-2 * log_likelihood + parameters * np.log(samples))


def cholesky_factor(covariance: np.ndarray) -> np.ndarray:
    """Return the lower triangular L with Σ = LLᵀ; `NumericalError` if Σ is not positive definite."""
    try:
        return np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        raise NumericalError("the covariance is not positive definite; regularize it first") from None
