"""Autoregressive moving-average noise, ARMA(p,q): exact likelihood, orders by BIC, and the covariance that follows."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.noise.arma_likelihood import (
    first_autocovariances,
    height_and_slope,
    levinson,
    squares_and_log_determinant,
)

MAX_ORDERS = (4, 3)
"""Largest p and q that are tried by default."""

_MAX_ARCTANH = 7.0  # largest |atanh| of a partial autocorrelation: nearer than 2·10⁻⁶ to 1 nothing can be told apart


@dataclass(frozen=True, eq=False)
class Arma:
    """x_t = Σ φ_i x_{t-i} + e_t + Σ θ_j e_{t-j}, stationary and invertible.

    Attributes
    ----------
    ar, ma : array, shape (p,), (q,)
        φ and θ.
    innovation_variance : float
        Variance of e, mmHg².
    log_likelihood : float
        Exact, of all series it was fitted to.
    bic : float
        By which the orders are chosen; the innovation variance counts as a parameter.
    """

    ar: np.ndarray
    ma: np.ndarray
    innovation_variance: float
    log_likelihood: float
    bic: float

    def covariance(self, count: int) -> np.ndarray:
        """Covariance of `count` successive samples, mmHg², shape (sample, sample) (Box & Jenkins)."""
        from scipy.linalg import toeplitz

        return toeplitz(self.innovation_variance * autocovariance(self.ar, self.ma, count))


def fit_arma(series: np.ndarray, largest: tuple[int, int] = MAX_ORDERS) -> Arma:
    """Maximum-likelihood ARMA(p,q) of independent series, shape (series, sample), with the orders of the least BIC.

    The likelihood is exact. Every order starts from the optima of the two orders it contains, so that a larger model is
    never less likely than a smaller one.

    Raises
    ------
    NumericalError
        If no order has a finite likelihood.
    """
    scale = float(np.sqrt(np.mean(series**2)))
    unit = series / scale
    candidates: dict[tuple[int, int], tuple[np.ndarray, Arma]] = {}
    for p, q in _orders(largest):
        smaller = [(key, candidates[key][0]) for key in ((p - 1, q), (p, q - 1)) if key in candidates]
        starts = [_grown(x, key, (p, q)) for key, x in smaller]
        starts += [_burg(unit, p)] if q == 0 else []
        candidates[p, q] = _fit_order(unit, p, q, starts)
    best = min((candidate for _, candidate in candidates.values()), key=lambda candidate: candidate.bic)
    if not np.isfinite(best.bic):
        raise NumericalError("no ARMA model has a finite likelihood; are the residuals constant?")
    shift = unit.size * np.log(scale)
    return Arma(
        best.ar, best.ma, best.innovation_variance * scale**2, best.log_likelihood - shift, best.bic + 2 * shift
    )


def compile_kernels() -> None:
    """Compile the likelihood, or load it where another process has compiled it: by the smallest fit there is."""
    fit_arma(np.cos(np.arange(16.0))[np.newaxis] ** 3, (1, 1))


def autocovariance(ar: np.ndarray, ma: np.ndarray, count: int) -> np.ndarray:
    """Autocovariance of lags 0 … count-1 for unit innovations (Brockwell & Davis, third method)."""
    from scipy.signal import lfilter, lfiltic

    p, moving = len(ar), np.append(1.0, ma)
    first = first_autocovariances(ar, moving)
    order, polynomial = len(first), np.append(1.0, -ar)
    if count <= order:
        return first[:count]
    if p == 0:
        return np.append(first, np.zeros(count - order))
    state = lfiltic([1.0], polynomial, first[::-1][:p])
    return np.append(first, lfilter([1.0], polynomial, np.zeros(count - order), zi=state)[0])


def concentrated(ar: np.ndarray, ma: np.ndarray, series: np.ndarray) -> tuple[float, float]:
    """Log-likelihood maximized over the innovation variance, and that variance; -inf where it cannot be computed."""
    squares, log_det = squares_and_log_determinant(ar, ma, series)
    variance = squares / series.size
    if not (np.isfinite(variance) and variance > 0):
        return -np.inf, np.nan
    return -0.5 * (series.size * (np.log(2 * np.pi * variance) + 1) + len(series) * log_det), variance


def _fit_order(unit: np.ndarray, p: int, q: int, starts: list[np.ndarray]) -> tuple[np.ndarray, Arma]:
    from scipy.optimize import minimize

    def objective(x: np.ndarray) -> tuple[float, np.ndarray]:
        height, slope = height_and_slope(x, p, unit)
        return (height, slope) if np.all(np.isfinite([height, *slope])) else (1e3, np.zeros(len(x)))

    x, bounds = np.zeros(0), [(-_MAX_ARCTANH, _MAX_ARCTANH)] * (p + q)
    if p + q:
        options = {"ftol": 1e-11, "gtol": 1e-7, "maxiter": 200}
        ends = [
            minimize(objective, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options) for start in starts
        ]
        x = min(ends, key=lambda end: end.fun).x
    ar, ma = _coefficients(x, p)
    log_likelihood, variance = concentrated(ar, ma, unit)
    bic = -2 * log_likelihood + (p + q + 1) * np.log(unit.size)
    return x, Arma(ar, ma, variance, log_likelihood, float(bic))


def _orders(largest: tuple[int, int]) -> Iterator[tuple[int, int]]:
    for p in range(largest[0] + 1):
        for q in range(largest[1] + 1):
            yield p, q


def _coefficients(x: np.ndarray, p: int) -> tuple[np.ndarray, np.ndarray]:
    """φ and θ of unbounded numbers: tanh of each is a partial autocorrelation, so every model is stationary."""
    return levinson(np.tanh(x[:p])), -levinson(np.tanh(x[p:]))


def _grown(x: np.ndarray, orders: tuple[int, int], to: tuple[int, int]) -> np.ndarray:
    """Return the optimum of a smaller model as a start of a larger one, a little off the saddle at zero."""
    return np.insert(x, orders[0], 0.02) if to[0] > orders[0] else np.append(x, 0.02)


def _burg(unit: np.ndarray, p: int) -> np.ndarray:
    """Return the start of an AR(p) by Burg's recursion."""
    forward, backward = unit[:, 1:].copy(), unit[:, :-1].copy()
    partial = np.zeros(p)
    for i in range(p):
        partial[i] = 2 * np.sum(forward * backward) / np.sum(forward**2 + backward**2)
        forward, backward = (
            (forward - partial[i] * backward)[:, 1:],
            (backward - partial[i] * forward)[:, :-1],
        )
    return np.clip(np.arctanh(np.clip(partial, -1 + 1e-12, 1 - 1e-12)), -_MAX_ARCTANH, _MAX_ARCTANH)
