"""What stands for the simulations: a Gaussian process, a polynomial of degree three and a smooth rest.

All outputs share one covariance between points, so that one factorization serves them. Its scales are chosen by the
errors at points left out, which have a closed form.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import combinations_with_replacement, product

import numpy as np

Coordinates = Callable[[np.ndarray], np.ndarray]
"""Maps points, shape (point, unknown), to as many coordinates in which outputs bend less."""


@dataclass(frozen=True)
class EmulatorRules:
    """Shape of the emulator; lengths and errors in SD of the points where it will be used.

    Attributes
    ----------
    degree : int
        Degree of the polynomial that carries the trend.
    constant_sd : float
        SD of the constant, in units of the errors that matter; a coefficient of degree d has decay^d of it.
    decays : tuple of float
        Decay of the coefficients with their degree; the one that foretells better is taken.
    initial_length : float
        Length of the smooth rest along each unknown, where none is known.
    min_length : float
        Lower limit of a length.
    max_length : float
        Upper limit of a length.
    length_factors : tuple of float
        Factors by which a length is tried.
    max_error_ratio : float
        Ratio of the errors below which another length is worth it.
    length_simulations : int
        Simulations by which lengths are chosen.
    nugget : float
        Variance of single simulations, in units of the errors that matter.
    """

    degree: int = 3
    constant_sd: float = 30.0
    decays: tuple[float, float] = (0.3, 0.1)
    initial_length: float = 2.5
    min_length: float = 0.8
    max_length: float = 30.0
    length_factors: tuple[float, float] = (0.6, 1.7)
    max_error_ratio: float = 0.995
    length_simulations: int = 500
    nugget: float = 1e-4


RULES = EmulatorRules()


@dataclass(frozen=True, eq=False)
class Emulator:
    """Outputs as smooth functions of the points, learned from simulations.

    Attributes
    ----------
    coordinates : callable
    center : array, shape (unknown,)
    to_local : array, shape (unknown, unknown)
        Local coordinates are (coordinates - center) @ to_local.
    local_points : array, shape (simulation, unknown)
        Local coordinates of the simulations.
    base : array, shape (output,)
    weights : array, shape (simulation, output)
    coefficients : array, shape (term, output)
    lengths : array, shape (unknown,)
        Of the smooth rest, in local coordinates.
    error : array, shape (output,)
        Root-mean-square error at points left out.
    scale : array, shape (output,)
        Errors of the outputs that count as equally bad.
    """

    coordinates: Coordinates
    center: np.ndarray
    to_local: np.ndarray
    local_points: np.ndarray
    base: np.ndarray
    weights: np.ndarray
    coefficients: np.ndarray
    lengths: np.ndarray
    error: np.ndarray
    scale: np.ndarray

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """Return the outputs at points, shape (point, output)."""
        return self.at(self.local(points))

    def at(self, local: np.ndarray) -> np.ndarray:
        """Return the outputs at points given by local coordinates."""
        return (
            self.base
            + features(local) @ self.coefficients
            + _near(local, self.local_points, self.lengths) @ self.weights
        )

    def local(self, points: np.ndarray) -> np.ndarray:
        """Return local coordinates, shape (point, unknown)."""
        return (self.coordinates(points) - self.center) @ self.to_local

    def knowing(self, points: np.ndarray, outputs: np.ndarray) -> "Emulator":
        """Return an emulator of the same lengths that was learned from other simulations."""
        local, base = self.local(points), outputs.mean(axis=0)
        weights, coefficients, error = _fitted(local, (outputs - base) / self.scale, self.lengths, self.scale)
        return replace(self, local_points=local, base=base, weights=weights, coefficients=coefficients, error=error)

    @cached_property
    def reach(self) -> float:
        """Largest distance of a simulation from the center, in local coordinates."""
        return float(np.sqrt((self.local_points**2).sum(axis=1).max()))

    def jacobian(self, point: np.ndarray) -> np.ndarray:
        """Return the derivatives at a point, shape (output, unknown)."""
        step = 1e-3 * np.eye(len(point))
        return (self(point + step) - self(point - step)).T / 2e-3


def fit_emulator(
    points: np.ndarray,
    outputs: np.ndarray,
    around: np.ndarray,
    scale: np.ndarray,
    coordinates: Coordinates,
    lengths: np.ndarray | None = None,
) -> Emulator:
    """Return what predicts left-out points best.

    Parameters
    ----------
    points, outputs : array, shape (simulation, unknown), (simulation, output)
    around : array, shape (draw, unknown)
        Where it will be used: their mean and covariance make the local coordinates.
    scale : array, shape (output,)
        Errors of the outputs that count as equally bad.
    coordinates : callable
    lengths : array, shape (unknown,), optional
        Those of an emulator that knew less, from which the choice begins.
    """
    positions = coordinates(around)
    center, spread = positions.mean(axis=0), np.atleast_2d(np.cov(positions.T))
    to_local = np.linalg.inv(np.linalg.cholesky(spread + 1e-9 * np.diag(np.diag(spread)))).T
    local, base = (coordinates(points) - center) @ to_local, outputs.mean(axis=0)
    begin = np.full(points.shape[1], RULES.initial_length) if lengths is None else lengths
    latest = slice(-RULES.length_simulations, None)
    chosen = _chosen(local[latest], (outputs[latest] - base) / scale, begin)
    weights, coefficients, missed = _fitted(local, (outputs - base) / scale, chosen, scale)
    return Emulator(coordinates, center, to_local, local, base, weights, coefficients, chosen, missed, scale)


def _fitted(
    local: np.ndarray, target: np.ndarray, lengths: np.ndarray, scale: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return weights, coefficients and errors of the outputs, of the decay that foretells better."""
    fits = [_regression(local, target, decay, lengths) for decay in RULES.decays]
    weights, coefficients, missed = min(fits, key=lambda fit: float(np.sum(fit[2] ** 2)))
    return weights * scale, coefficients * scale, missed * scale


def _chosen(local: np.ndarray, target: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return lengths changed one after the other, each as long as points left out are predicted better.

    Outputs bend along few unknowns; along the others a long smooth rest learns from far away.
    """

    def missed(tried: np.ndarray) -> float:
        return float(np.sum(_regression(local, target, RULES.decays[-1], tried)[2] ** 2))

    best = missed(lengths)
    for axis, factor in product(range(len(lengths)), RULES.length_factors):
        while True:
            tried = lengths * np.where(np.arange(len(lengths)) == axis, factor, 1.0)
            error = missed(tried) if RULES.min_length <= tried[axis] <= RULES.max_length else np.inf
            if error > RULES.max_error_ratio * best:
                break
            lengths, best = tried, error
    return lengths


def _regression(
    local: np.ndarray, target: np.ndarray, decay: float, lengths: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return weights, coefficients of the monomials, and the error at points left out, per output."""
    size = RULES.constant_sd * decay ** _degrees(local.shape[1])
    terms = features(local) * size
    covariance = terms @ terms.T + _near(local, local, lengths) + RULES.nugget * np.eye(len(local))
    inverse = np.linalg.inv(covariance)
    weights = inverse @ target
    missed = weights / np.diag(inverse)[:, np.newaxis]
    return weights, size[:, np.newaxis] * (terms.T @ weights), np.sqrt(np.mean(missed**2, axis=0))


def _near(points: np.ndarray, centers: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Squared-exponential covariance of points, with variance 1."""
    points, centers = points / lengths, centers / lengths
    square = (points**2).sum(axis=1)[:, np.newaxis] + (centers**2).sum(axis=1) - 2 * points @ centers.T
    return np.exp(-0.5 * square)


def features(local: np.ndarray) -> np.ndarray:
    """Return all monomials up to the degree, shape (point, term)."""
    padded = np.hstack([local, np.ones((len(local), 1))])
    factors = _factors(local.shape[1])
    products = padded[:, factors[:, 0]]
    for i in range(1, RULES.degree):
        products = products * padded[:, factors[:, i]]
    return products


@cache
def _factors(count: int) -> np.ndarray:
    """Return the unknowns whose product is each monomial, shape (term, degree); `count` stands for a factor of 1."""
    terms = [term for d in range(RULES.degree + 1) for term in combinations_with_replacement(range(count), d)]
    return np.array([[*term, *[count] * (RULES.degree - len(term))] for term in terms])


def _degrees(count: int) -> np.ndarray:
    return np.asarray((_factors(count) < count).sum(axis=1))
