"""Gaussian likelihood of residuals under a covariance, and the coordinates in which their noise is white."""

import numpy as np
from scipy.linalg import solve_triangular

from vasowave.errors import NumericalError


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
