"""Many balanced studies at once, judged as `mixed` judges one: what a plan draws by thousands.

A pair is two values with one covariance: what both have in common, what each has to itself, and known errors of one
size. Animals that are recorded equally often have mean squares between and within them. The restricted likelihood is
that of the sample covariance, or of the mean squares, and Kenward and Roger correct degrees of freedom alone.
"""

import numpy as np

from vasowave.study.cohort.mixed import MIN_FREEDOM_SHARE, MIN_VARIANCE_SHARE
from vasowave.study.cohort.pooling import LogEstimate

_ALL_ONES = np.ones((2, 2))
_ANIMAL_STRUCTURE = np.eye(2), _ALL_ONES  # one animal twice
_LITTERMATE_STRUCTURE = np.diag([1.0, 0.0]), np.diag([0.0, 1.0]), _ALL_ONES
"""Littermates of two groups, each with a variance of its own."""

_MAX_SCORING_STEPS, _MAX_HALVINGS, _MIN_RELATIVE_CHANGE = 40, 12, 1e-6
"""Steps of scoring, halvings of a step, and change, by the variance, at which it ends."""


def structure_of_pairs(pairs: int, littermates: bool) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return fixed effects and variance components (`mixed.Structure`) of all first values and then all second ones."""
    basis = _LITTERMATE_STRUCTURE if littermates else _ANIMAL_STRUCTURE
    return np.kron(np.eye(2), np.ones((pairs, 1))), [np.kron(component, np.eye(pairs)) for component in basis]


def changes_of(values: np.ndarray, error: float, littermates: bool) -> LogEstimate[np.ndarray]:
    """Return the change of every study of `values`, shape (study, 2, pair), as the design's mixed model has it.

    Parameters
    ----------
    values : array, shape (study, 2, pair)
    error : float
        SD of the known error of each value.
    littermates : bool
        Whether a pair is two animals of two groups; else one animal on two occasions.
    """
    pairs = values.shape[2]
    means = values.mean(axis=2)
    away = values - means[..., np.newaxis]
    sample_covariance = away @ np.swapaxes(away, -1, -2) / (pairs - 1)
    basis = np.array(_LITTERMATE_STRUCTURE if littermates else _ANIMAL_STRUCTURE)
    variance, freedom = _judged(sample_covariance, error**2, basis, pairs)
    if error:
        freedom = np.maximum(freedom, MIN_FREEDOM_SHARE * _judged(sample_covariance, 0.0, basis, pairs)[1])
    return LogEstimate(means[:, 1] - means[:, 0], np.sqrt(variance), freedom)


def effects_of_repeated(values: np.ndarray, error: float, shared: float = 0.0) -> LogEstimate[np.ndarray]:
    """Return the difference of two groups of animals that are recorded equally often, as a design with subjects has it.

    Parameters
    ----------
    values : array, shape (study, 2, animal, occasion)
        Two occasions or more.
    error : float
        SD of the known error of each value.
    shared : float
        Standard error of the difference from what animals have in common.
    """
    means = values.mean(axis=(2, 3))
    variance, freedom = _of_repeated(values, error**2, shared)
    if error:
        freedom = np.maximum(freedom, MIN_FREEDOM_SHARE * _of_repeated(values, 0.0, shared)[1])
    return LogEstimate(means[:, 1] - means[:, 0], np.sqrt(variance), freedom)


def _of_repeated(values: np.ndarray, error_variance: float, shared: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the variance of the difference of the groups and its degrees of freedom, shape (study,) each."""
    animals, occasions = values.shape[2:]
    animal_means = values.mean(axis=3)
    between, within = occasions * animal_means.var(axis=2, ddof=1), values.var(axis=3, ddof=1).mean(axis=2)
    free = animals - 1, animals * (occasions - 1)
    pooled = (free[0] * between + free[1] * within) / sum(free)
    # Animals differ by none, or more.
    likeliest = np.maximum(np.where(between < within, pooled, between), error_variance)
    of_mean = likeliest / (animals * occasions)
    variance = of_mean.sum(axis=1) + shared**2
    return variance, variance**2 * free[0] / np.square(of_mean).sum(axis=1)


def _judged(
    sample_covariance: np.ndarray, error_variance: float, basis: np.ndarray, pairs: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the variance of the mean change and its degrees of freedom, shape (study,) each."""
    covariance = _maximized(sample_covariance, error_variance, basis, pairs)
    change = np.array([-1.0, 1.0])
    variance = covariance @ change @ change / pairs
    slopes = basis @ change @ change / pairs
    information = 0.5 * (pairs - 1) * _products(np.linalg.inv(covariance), basis)
    moved = np.linalg.solve(information, slopes) @ slopes
    return variance, 2 * variance**2 / moved


def _maximized(sample_covariance: np.ndarray, error_variance: float, basis: np.ndarray, pairs: int) -> np.ndarray:
    """Return the covariances of pairs that maximize the restricted likelihood, by Fisher scoring within limits."""
    scale = np.trace(sample_covariance, axis1=1, axis2=2)[:, np.newaxis] / 2
    alone = np.array([not matrix[0, 1] for matrix in basis])
    lower_bounds = np.where(alone, MIN_VARIANCE_SHARE, 0.0) * scale
    flat = basis.reshape(len(basis), 4)
    unexplained = (sample_covariance - error_variance * np.eye(2)).reshape(-1, 4)
    components = np.maximum(unexplained @ np.linalg.pinv(flat), lower_bounds)  # most are there
    covariance = _covariance(components, error_variance, basis)
    height = _height(sample_covariance, covariance)
    running = np.arange(len(sample_covariance))
    for _ in range(_MAX_SCORING_STEPS):
        step = _step(sample_covariance[running], covariance[running], basis, components[running], lower_bounds[running])
        updated, pending = components[running].copy(), np.ones(len(running), dtype=bool)
        for halved in range(_MAX_HALVINGS):
            tried = np.maximum(components[running] + step * 0.5**halved, lower_bounds[running])
            tall = _height(sample_covariance[running], _covariance(tried, error_variance, basis))
            better = pending & (tall >= height[running])
            updated[better], pending = tried[better], pending & ~better
            if not pending.any():
                break
        moved = np.abs(updated - components[running]).max(axis=1)
        components[running] = updated
        covariance[running] = _covariance(updated, error_variance, basis)
        height[running] = _height(sample_covariance[running], covariance[running])
        running = running[moved > _MIN_RELATIVE_CHANGE * scale[running, 0]]
        if not len(running):
            break
    return covariance


def _step(
    sample_covariance: np.ndarray,
    covariance: np.ndarray,
    basis: np.ndarray,
    components: np.ndarray,
    lower_bounds: np.ndarray,
) -> np.ndarray:
    """Return the step of scoring, (study, component), by the components that are not held at their limits."""
    inverse = np.linalg.inv(covariance)
    pull = inverse @ sample_covariance @ inverse - inverse
    score = np.einsum("sij,kji->sk", pull, basis)
    free = (components > lower_bounds) | (score > 0)
    information = _products(inverse, basis) * (free[:, :, np.newaxis] & free[:, np.newaxis, :])
    information += np.eye(len(basis)) * ~free[:, np.newaxis, :]
    return np.asarray(np.linalg.solve(information, (score * free)[..., np.newaxis])[..., 0])


def _products(inverse: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Return tr(V⁻¹ B V⁻¹ B') of every two components, shape (study, component, component)."""
    turned = inverse[:, np.newaxis] @ basis
    return np.einsum("skij,slji->skl", turned, turned)


def _covariance(components: np.ndarray, error_variance: float, basis: np.ndarray) -> np.ndarray:
    return error_variance * np.eye(2) + np.tensordot(components, basis, axes=1)


def _height(sample_covariance: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Return the restricted log-likelihood of one degree of freedom, up to a constant."""
    spread = np.einsum("sij,sji->s", np.linalg.inv(covariance), sample_covariance)
    return np.asarray(-0.5 * (np.log(np.linalg.det(covariance)) + spread))
