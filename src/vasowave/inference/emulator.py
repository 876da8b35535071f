"""A polynomial that stands for the simulations: ridge regression, its strength chosen by leaving points out."""

from dataclasses import dataclass
from functools import cache
from itertools import combinations_with_replacement

import numpy as np

_DEGREE = 3
_DECAYS = (0.5, 0.2, 0.08, 0.03)  # coefficients of degree d are expected to be decay^d of the first ones
_RIDGE = 1e-5  # square of an error of single simulations, as a share of what one SD of a point changes


@dataclass(frozen=True, eq=False)
class Emulator:
    """Outputs as polynomials of degree three in local coordinates, in which the points it was fitted to have SD 1.

    Attributes
    ----------
    center : array, shape (unknown,)
    to_local : array, shape (unknown, unknown)
        Local coordinates are (point - center) @ to_local.
    reach : float
        Largest distance from the center, in local coordinates, of the points it was fitted to.
    base : array, shape (output,)
    coefficients : array, shape (term, output)
        Of the difference from `base`.
    error : array, shape (output,)
        Root-mean-square error at points left out.
    """

    center: np.ndarray
    to_local: np.ndarray
    reach: float
    base: np.ndarray
    coefficients: np.ndarray
    error: np.ndarray

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """Return the outputs at points, shape (point, output)."""
        return self.base + features(self.local(points)) @ self.coefficients

    def local(self, points: np.ndarray) -> np.ndarray:
        """Return local coordinates, shape (point, unknown)."""
        return (points - self.center) @ self.to_local

    def jacobian(self, point: np.ndarray) -> np.ndarray:
        """Return the derivatives at a point, shape (output, unknown)."""
        step = 1e-4 * np.eye(len(point))
        return (self(point + step) - self(point - step)).T / 2e-4


def fit_emulator(points: np.ndarray, outputs: np.ndarray, around: np.ndarray, scale: np.ndarray) -> Emulator:
    """Return the polynomial through outputs, (point, output), that predicts left-out points best.

    Parameters
    ----------
    points, outputs : array
    around : array, shape (draw, unknown)
        Where it will be used: their mean and covariance make the local coordinates.
    scale : array, shape (output,)
        Errors of the outputs that count as equally bad.
    """
    center = around.mean(axis=0)
    to_local = np.linalg.inv(np.linalg.cholesky(np.cov(around.T) + 1e-9 * np.eye(len(center)))).T
    local, base = (points - center) @ to_local, outputs.mean(axis=0)
    terms, degree = features(local), _degrees(local.shape[1])
    target = (outputs - base) / scale
    fits = [_ridge(terms * decay**degree, target) for decay in _DECAYS]
    best = int(np.argmin([np.sum(missed**2) for _, missed in fits]))
    coefficients = _DECAYS[best] ** degree[:, np.newaxis] * fits[best][0] * scale
    reach = float(np.sqrt((local**2).sum(axis=1).max()))
    return Emulator(center, to_local, reach, base, coefficients, fits[best][1] * scale)


def _ridge(terms: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients of a ridge regression and the root-mean-square error at points left out, per output."""
    left, singular, right = np.linalg.svd(terms, full_matrices=False)
    shrink = singular**2 / (singular**2 + _RIDGE)
    weights = left.T @ target
    coefficients = right.T @ ((singular / (singular**2 + _RIDGE))[:, np.newaxis] * weights)
    leverage = np.minimum((left**2) @ shrink, 1 - 1e-9)
    missed = (target - left @ (shrink[:, np.newaxis] * weights)) / (1 - leverage)[:, np.newaxis]
    return coefficients, np.sqrt(np.mean(missed**2, axis=0))


def features(local: np.ndarray) -> np.ndarray:
    """Return all monomials up to the degree, shape (point, term)."""
    padded = np.hstack([local, np.ones((len(local), 1))])
    factors = _factors(local.shape[1])
    found = padded[:, factors[:, 0]]
    for i in range(1, _DEGREE):
        found = found * padded[:, factors[:, i]]
    return found


@cache
def _factors(count: int) -> np.ndarray:
    """Return the unknowns whose product is each monomial, shape (term, degree); `count` stands for a factor of 1."""
    terms = [term for d in range(_DEGREE + 1) for term in combinations_with_replacement(range(count), d)]
    return np.array([[*term, *[count] * (_DEGREE - len(term))] for term in terms])


def _degrees(count: int) -> np.ndarray:
    return np.asarray((_factors(count) < count).sum(axis=1))
