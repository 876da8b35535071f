"""Estimates pooled over animals where some searches stopped at a bound: intervals that are open at one end."""

from typing import NamedTuple

import numpy as np

from vasowave.descriptions import TAILS

_MEANS, _SPREADS = 801, 41  # of the grid on which the likelihood is maximized
_REACH = 8.0  # of the grid beyond the outermost values, in scales of the animals and their errors


class Pooled(NamedTuple):
    """A mean over animals with its 95 % interval; an end that the animals do not tell is infinite."""

    value: float
    low: float
    high: float


def pooled_censored(values: np.ndarray, errors: np.ndarray, beyond: np.ndarray) -> Pooled:
    """Return the mean of animals that differ, are each known with an error, and lie in part beyond a bound.

    An animal whose search stopped at a bound says that its estimate lies beyond, so it adds the probability of that to
    the likelihood (Tobin 1958); leaving it out would choose animals by their outcome. Mean and variance of the
    animals, normal, maximize the likelihood. The interval holds the means whose profile likelihood is not below the
    best by more than it is at the ends of Student's interval, so that without bounds and errors it is Student's; the
    animals inside their bounds are counted for its degrees of freedom.

    Parameters
    ----------
    values, errors : array, shape (animal,)
        Estimates and their standard errors, for instance of logarithms; at a bound the bound.
    beyond : array of int, shape (animal,)
        -1 where the estimate lies at or below its value, 1 where at or above, 0 where it is the value.

    Returns
    -------
    Pooled
        NaN and an endless interval where fewer than two animals lie inside their bounds.
    """
    from scipy.special import stdtrit

    inside = int(np.sum(beyond == 0))
    if inside < 2:
        return Pooled(np.nan, -np.inf, np.inf)
    center = values[beyond == 0]
    scale = max(float(np.ptp(values)), float(np.median(errors)), 1e-9 * float(np.abs(values).max()) + 1e-12)
    means = np.linspace(values.min() - _REACH * scale, values.max() + _REACH * scale, _MEANS)
    means = np.sort(np.append(means, np.linspace(center.min() - scale, center.max() + scale, _MEANS)))
    spreads = np.append(1e-6 * scale, np.geomspace(1e-3, 10.0, _SPREADS) * scale)
    profile = _likelihood(values, errors, beyond, means, spreads).max(axis=1)
    deviance = 2 * (profile.max() - profile)
    t = float(stdtrit(inside - 1, TAILS[-1]))
    within = np.flatnonzero(deviance <= inside * np.log1p(t**2 / (inside - 1)))
    first, last = int(within[0]), int(within[-1])
    limit = inside * np.log1p(t**2 / (inside - 1))
    low = -np.inf if first == 0 else _crossing(means, deviance, first - 1, limit)
    high = np.inf if last == len(means) - 1 else _crossing(means, deviance, last, limit)
    return Pooled(float(means[profile.argmax()]), low, high)


def _likelihood(
    values: np.ndarray, errors: np.ndarray, beyond: np.ndarray, means: np.ndarray, spreads: np.ndarray
) -> np.ndarray:
    """Return the log-likelihood, shape (mean, spread)."""
    from scipy.special import log_ndtr

    total = np.zeros((len(means), len(spreads)))
    for value, error, side in zip(values, errors, beyond, strict=True):
        sd = np.hypot(spreads, error)
        z = (value - means[:, np.newaxis]) / sd
        total += log_ndtr(-side * z) if side else -0.5 * z**2 - np.log(sd)
    return total


def _crossing(means: np.ndarray, deviance: np.ndarray, before: int, limit: float) -> float:
    """Return where the deviance passes its limit between a point of the grid and the next."""
    ends = slice(before, before + 2)
    order = np.argsort(deviance[ends])
    return float(np.interp(limit, deviance[ends][order], means[ends][order]))
