"""Estimates of single animals pooled within groups, each as far as it is known: random effects on logarithms."""

from typing import NamedTuple

import numpy as np

from vasowave.errors import InputError


class Mean(NamedTuple):
    """The mean of a group of animals that differ, and are each known with an error.

    Attributes
    ----------
    value : float
    error : float
        Its standard error, by Hartung and Knapp.
    freedom : float
        Degrees of freedom of that error.
    between : float
        Standard deviation of the animals' true values.
    """

    value: float
    error: float
    freedom: float
    between: float


def pooled_mean(values: np.ndarray, errors: np.ndarray) -> Mean:
    """Return the mean of animals whose estimates scatter by their errors and by what the animals differ.

    The animals' variance is the restricted maximum likelihood's, the weights are 1/(variance + error²), and the
    standard error is that of Hartung and Knapp (2001), which follows the scatter about the mean, but never smaller than
    the errors alone make it (Knapp and Hartung 2003). Without errors all of this is the plain mean with its usual
    standard error.

    Parameters
    ----------
    values, errors : array, shape (animal,)
        Estimates and their standard errors, for instance of logarithms; 0 where nothing is known of the error.

    Raises
    ------
    InputError
        Fewer than two animals, or no variation at all.
    """
    if len(values) < 2:
        raise InputError("pooling needs two animals")
    if not np.any(errors) and np.ptp(values) == 0:
        raise InputError("the animals do not vary and have no errors; there is nothing to pool")
    between = _between(values, errors**2)
    weights = 1 / (between + errors**2)
    mean = float(weights @ values / weights.sum())
    scatter = max(1.0, float(weights @ (values - mean) ** 2 / (len(values) - 1)))
    return Mean(mean, float(np.sqrt(scatter / weights.sum())), len(values) - 1.0, float(np.sqrt(between)))


class Ratio(NamedTuple):
    """A ratio of two groups with its interval, from logarithms.

    Attributes
    ----------
    value, low, high : float
    error : float
        Standard error of its logarithm.
    reference, other : float
        The pooled geometric means of the groups, whose ratio it is; in the unit of the animals' values.
    """

    value: float
    low: float
    high: float
    error: float
    reference: float
    other: float


def pooled_ratio(
    reference: tuple[np.ndarray, np.ndarray],
    other: tuple[np.ndarray, np.ndarray],
    level: float = 0.95,
    shared: float = 0.0,
) -> Ratio:
    """Return the ratio of a group over its reference, each pooled by itself; without errors, Welch's interval.

    The groups may differ in how much their animals vary, so the degrees of freedom are Satterthwaite's.

    Parameters
    ----------
    reference, other : (array, array)
        Logarithms of the animals' estimates, and their standard errors.
    level : float
    shared : float
        Standard error of the logarithm of the ratio from what the animals of a group have in common, an image for
        instance: no number of animals averages it away.

    Raises
    ------
    InputError
        As `pooled_mean`.
    """
    from scipy.special import stdtrit

    first, second = pooled_mean(*reference), pooled_mean(*other)
    parts = np.array([first.error**2, second.error**2])
    variance = parts.sum() + shared**2
    freedom = variance**2 / (parts**2 / [first.freedom, second.freedom]).sum()
    difference, error = second.value - first.value, float(np.sqrt(variance))
    reach = float(stdtrit(freedom, 0.5 + 0.5 * level)) * error
    value, low, high = np.exp([difference, difference - reach, difference + reach]).tolist()
    return Ratio(value, low, high, error, float(np.exp(first.value)), float(np.exp(second.value)))


def _between(values: np.ndarray, variances: np.ndarray) -> float:
    """Return the animals' variance that maximizes the restricted likelihood."""
    from scipy.optimize import minimize_scalar

    scatter = float(values.var(ddof=1))
    if not np.any(variances):
        return scatter

    def loss(variance: np.ndarray) -> np.ndarray:
        weights = 1 / (np.atleast_1d(variance)[:, np.newaxis] + variances)
        whole = weights.sum(axis=1)
        mean = weights @ values / whole
        misfit = (weights * (values - mean[:, np.newaxis]) ** 2).sum(axis=1)
        return misfit - np.log(weights).sum(axis=1) + np.log(whole)

    # The likelihood may have two maxima: the higher one is found on a grid, then between its neighbors.
    floor = 1e-9 * scatter + 1e-12 * variances.max()  # as good as none
    grid = floor + np.concatenate([[0.0], np.geomspace(1e-3, 4.0, 40) * scatter])
    best = int(np.argmin(loss(grid)))
    ends = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
    optimum = minimize_scalar(lambda x: loss(x)[0], bounds=ends, method="bounded", options={"xatol": 1e-6 * ends[1]})
    return float(optimum.x)
