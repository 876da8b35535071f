"""Gaussian-process kernels with unit amplitude, and the regularization of a covariance matrix.

Every kernel maps times t, shape (sample,), to a matrix of shape (sample, sample).
"""

import numpy as np

from vasowave.errors import InputError


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


def regularize(covariance: np.ndarray, largest_condition: float = 1e4) -> tuple[np.ndarray, float]:
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
