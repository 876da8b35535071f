"""Estimates of single animals pooled within groups, each as far as it is known: random effects on logarithms."""

from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from vasowave.base.descriptions import LEVEL
from vasowave.base.errors import InputError

Number = TypeVar("Number", float, np.ndarray)


class Interval(NamedTuple):
    """A number with the ends of its interval of 95 %; an end that nothing tells is NaN, or infinite."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class LogEstimate(Generic[Number]):
    """An estimate of a logarithm with its standard error and the degrees of freedom of that; or many."""

    value: Number
    error: Number
    freedom: Number

    @property
    def p(self) -> Number:
        """Two-sided p of each by itself."""
        from scipy.special import stdtr

        return 2 * stdtr(self.freedom, -abs(self.value) / self.error)

    def interval(self, quantile: float) -> Interval:
        """Return the interval that ends at this quantile of Student's t, and at one minus it."""
        from scipy.special import stdtrit

        reach = stdtrit(self.freedom, quantile) * self.error
        return Interval(float(self.value), float(self.value - reach), float(self.value + reach))

    def ratio(self, quantile: float) -> Interval:
        """Return an estimate of a logarithm as a ratio, as `interval`."""
        with np.errstate(over="ignore"):  # with two animals a group an interval may have no end
            return Interval(*np.exp(self.interval(quantile)).tolist())


class Mean(NamedTuple, Generic[Number]):
    """The mean of a group of animals that differ, and are each known with an error; or of many groups of one size."""

    value: Number
    error: Number
    """Its standard error, by Hartung and Knapp."""
    freedom: float
    """Degrees of freedom of that error."""
    between: Number
    """Standard deviation of the animals' true values."""


def pooled_mean(values: np.ndarray, errors: np.ndarray) -> Mean[float]:
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
    many = pooled_means(values, errors)
    return Mean(float(many.value), float(many.error), many.freedom, float(many.between))


def pooled_means(values: np.ndarray, errors: np.ndarray) -> Mean[np.ndarray]:
    """Return the `pooled_mean` of every group of `values`, shape (..., animal), whose animals have the same errors."""
    if not np.any(errors):
        spread = np.asarray(values.std(axis=-1, ddof=1))
        error = spread / np.sqrt(values.shape[-1])
        return Mean(np.asarray(values.mean(axis=-1)), error, values.shape[-1] - 1.0, spread)
    between = _between(values, errors**2)
    weights = 1 / (between[..., np.newaxis] + errors**2)
    total_weight, freedom = weights.sum(axis=-1), values.shape[-1] - 1.0
    mean = (weights * values).sum(axis=-1) / total_weight
    scatter = (weights * (values - mean[..., np.newaxis]) ** 2).sum(axis=-1) / freedom
    return Mean(mean, np.sqrt(np.maximum(1.0, scatter) / total_weight), freedom, np.sqrt(between))


def difference(first: Mean[Any], second: Mean[Any], shared: float = 0.0) -> LogEstimate[np.ndarray]:
    """Return the second mean minus the first, with Satterthwaite's degrees of freedom.

    `shared` is the standard error that no number of animals lessens.
    """
    first_variance, second_variance = np.square(first.error), np.square(second.error)
    variance = first_variance + second_variance + shared**2
    freedom = variance**2 / (first_variance**2 / first.freedom + second_variance**2 / second.freedom)
    return LogEstimate(np.asarray(second.value - first.value), np.sqrt(variance), freedom)


class Ratio(NamedTuple):
    """A ratio of two groups with its interval, from logarithms."""

    value: float
    low: float
    high: float
    error: float
    """Standard error of its logarithm."""
    reference: float
    other: float
    """The pooled geometric means of the groups, whose ratio it is; in the unit of the animals' values."""
    freedom: float
    """Degrees of freedom of its error."""


def pooled_ratio(
    reference: tuple[np.ndarray, np.ndarray],
    group: tuple[np.ndarray, np.ndarray],
    level: float = LEVEL,
    shared: float = 0.0,
) -> Ratio:
    """Return the ratio of a group over its reference, each pooled by itself; without errors, Welch's interval.

    The groups may differ in how much their animals vary, so the degrees of freedom are Satterthwaite's.

    Parameters
    ----------
    reference, group : (array, array)
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
    first, second = pooled_mean(*reference), pooled_mean(*group)
    contrast = difference(first, second, shared)
    value, low, high = contrast.ratio(0.5 + 0.5 * level)
    reference_mean, group_mean = np.exp([first.value, second.value]).tolist()
    return Ratio(value, low, high, float(contrast.error), reference_mean, group_mean, float(contrast.freedom))


_VARIANCE_RATIO, _SCORING_STEPS = 1.15, 10
"""Factor between the variances that are tried first, and the steps of Fisher scoring after that."""


def _between(values: np.ndarray, variances: np.ndarray) -> np.ndarray:
    """Return the variance of the animals of each group that maximizes the restricted likelihood."""
    scatter = values.var(axis=-1, ddof=1)
    if np.ptp(variances) == 0:  # known alike: the maximum in closed form
        return np.asarray(np.maximum(scatter - variances[0], 0.0))
    centered = values - values.mean(axis=-1, keepdims=True)
    # The likelihood may have two maxima: the higher one is found on a grid, then between its neighbors.
    smallest = 1e-9 * scatter.max() + 1e-12 * variances.max()  # as good as none
    low, high = max(1e-3 * min(scatter.min(), variances.min()), smallest), 4 * max(scatter.max(), smallest)
    grid = np.concatenate([[smallest], np.geomspace(low, high, 2 + int(np.log(high / low) / np.log(_VARIANCE_RATIO)))])
    weights = 1 / (grid[:, np.newaxis] + variances)
    total_weight = weights.sum(axis=-1)
    likelihood = np.square(centered @ (weights / np.sqrt(total_weight)[:, np.newaxis]).T)
    likelihood -= centered**2 @ weights.T
    likelihood += np.log(weights).sum(axis=-1) - np.log(total_weight)
    best = np.argmax(likelihood, axis=-1)
    lowest, highest = grid[np.maximum(best - 1, 0)], grid[np.minimum(best + 1, len(grid) - 1)]
    between = grid[best]
    for _ in range(_SCORING_STEPS):
        between = np.clip(between + _scoring(between, centered, variances), lowest, highest)
    return np.asarray(between)


def _scoring(between: np.ndarray, centered: np.ndarray, variances: np.ndarray) -> np.ndarray:
    """Return the step of Fisher scoring towards the maximum of the restricted likelihood."""
    weights = 1 / (between[..., np.newaxis] + variances)
    squares, ones = weights * weights, np.ones(variances.shape)  # products with `ones` are sums, and faster
    total_weight, square, cube = weights @ ones, squares @ ones, (squares * weights) @ ones
    mean = (weights * centered) @ ones / total_weight
    misfit = np.square(weights * (centered - mean[..., np.newaxis])) @ ones
    return np.asarray(
        (misfit - total_weight + square / total_weight)
        / (square - 2 * cube / total_weight + (square / total_weight) ** 2)
    )
