"""The evidence: the integral of an unnormalized density, by bridge sampling.

Meng & Wong, Statistica Sinica 6 (1996), 831: draws from the density and from a distribution whose integral is known
meet in the iterated optimal bridge. The known one is a multivariate t, wider than the density where the two differ.
"""

import numpy as np

from vasowave.inference.ensemble import LogDensity

_FREEDOM = 5.0  # of the t distribution
_ROUNDS = 200


def log_integral(
    log_density: LogDensity, draws: np.ndarray, values: np.ndarray, rng: np.random.Generator
) -> tuple[float, float]:
    """Return the logarithm of the density's integral and its standard error if all draws were independent.

    Parameters
    ----------
    log_density : callable
    draws : array, shape (draw, unknown)
        Distributed by the density; one half shapes the known distribution, the other is compared with it.
    values : array, shape (draw,)
        `log_density` there.
    """
    from scipy.stats import multivariate_t

    even, odd = draws[::2], draws[1::2]
    shape = np.atleast_2d(np.cov(even.T)) * (_FREEDOM - 2) / _FREEDOM
    known = multivariate_t(even.mean(axis=0), shape, _FREEDOM, seed=rng)
    proposed = np.reshape(known.rvs(len(odd)), odd.shape)
    first = values[1::2] - known.logpdf(odd)
    second = log_density(proposed) - known.logpdf(proposed)
    middle = float(np.median(first))
    ours, theirs = np.exp(first - middle), np.exp(second - middle)
    ratio = 1.0
    for _ in range(_ROUNDS):
        before, ratio = ratio, _bridge(ours, theirs, ratio)
        if abs(ratio / before - 1) < 1e-10:
            break
    top, bottom = theirs / (theirs + ratio), ratio / (ours + ratio)
    error = np.sqrt(np.var(top) / np.mean(top) ** 2 / len(top) + np.var(bottom) / np.mean(bottom) ** 2 / len(bottom))
    return middle + float(np.log(ratio)), float(error)


def _bridge(ours: np.ndarray, theirs: np.ndarray, ratio: float) -> float:
    return float(np.mean(theirs / (theirs + ratio)) / np.mean(1 / (ours + ratio)))
