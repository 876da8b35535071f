"""One linear mixed model with known errors: restricted maximum likelihood, and inference after Kenward and Roger."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vasowave.study.cohort.pooling import LogEstimate

_MAX_SCORING_STEPS, _MAX_HALVINGS = 60, 25  # steps of scoring, and halvings of a step
MIN_VARIANCE_SHARE = 1e-6  # of the residuals' variance: a component that is smaller is none
_MIN_RELATIVE_CHANGE = 1e-7  # change of a component, by the residuals' variance, at which scoring ends
MIN_FREEDOM_SHARE = 1.0  # share of the degrees of freedom without known errors


class Structure(NamedTuple):
    """What is known of some values before they are looked at."""

    fixed: np.ndarray
    """Columns of the fixed effects, independent of each other. Shape (row, coefficient)."""
    random: Sequence[np.ndarray]
    """For each variance component, the covariance that a variance of 1 gives. Shape (row, row)."""
    error_covariance: np.ndarray
    """Covariance of the known errors; rows that share an error are correlated by it. Shape (row, row)."""


class MixedFit(NamedTuple):
    """A fitted model."""

    coefficients: np.ndarray
    """Shape (coefficient,)."""
    components: np.ndarray
    """Variances. Shape (component,)."""
    adjusted: np.ndarray
    plain: np.ndarray
    """Covariance of the coefficients, with Kenward and Roger's correction for the components being estimates, and
    without. Shape (coefficient, coefficient)."""
    slopes: np.ndarray
    """Derivative of `plain` with each component. Shape (component, coefficient, coefficient)."""
    uncertainty: np.ndarray
    """Covariance of the components. Shape (component, component)."""
    root: np.ndarray
    """Lower triangle whose product with itself is the covariance of the rows. Shape (row, row)."""
    weights: np.ndarray
    """What takes values to coefficients. Shape (coefficient, row)."""
    residuals: np.ndarray
    """Of the values from the fixed effects, decorrelated and of variance 1. Shape (row,)."""
    likelihood: float
    """The restricted logarithmic one, up to a constant."""
    ignorant: "MixedFit | None" = None
    """The same without the known errors, where there are any."""

    def effect(self, contrast: np.ndarray) -> LogEstimate[float]:
        """Return a contrast of the coefficients; its t squared is Kenward and Roger's F.

        Known errors make a component near 0 count for little, and a few well known rows for much: Satterthwaite's
        degrees of freedom then fall below 1, as if nothing were known. What is known takes none away: they are not less
        than those without known errors.
        """
        variance, plain = float(contrast @ self.adjusted @ contrast), float(contrast @ self.plain @ contrast)
        slope = self.slopes @ contrast @ contrast
        moved = float(slope @ self.uncertainty @ slope)
        freedom = 2 * plain**2 / moved if moved > 0 else np.inf
        if self.ignorant is not None:
            freedom = max(freedom, MIN_FREEDOM_SHARE * self.ignorant.effect(contrast).freedom)
        return LogEstimate(float(contrast @ self.coefficients), float(np.sqrt(variance)), freedom)


def fit_mixed(values: np.ndarray, structure: Structure) -> MixedFit:
    """Fit ``values = fixed effects + random effects + known errors`` by restricted maximum likelihood.

    The components are those of the highest of the maxima that scoring finds from two starts. The covariance of the
    coefficients and the degrees of freedom of their contrasts are those of Kenward and Roger (1997). Two groups with a
    variance each and no known errors give Welch's test.

    Parameters
    ----------
    values : array, shape (row,)
    structure : Structure
        Of more rows than coefficients, with a component at least that belongs to every row alone.
    """
    fixed, error_covariance = structure.fixed, structure.error_covariance
    random = np.array(structure.random)
    residuals = values - fixed @ np.linalg.lstsq(fixed, values, rcond=None)[0]
    scale = max(float(residuals @ residuals) / (len(values) - fixed.shape[1]), 1e-300)
    alone = np.array([is_diagonal(component) for component in random])
    lower_bounds = np.where(alone, MIN_VARIANCE_SHARE, 0.0) * scale
    starts = [np.where(alone, 0.7, 0.3) * scale, np.where(alone, 0.1, 0.02) * scale]
    maxima = [_climbed(values, fixed, random, error_covariance, start, lower_bounds, scale) for start in starts]
    components, state = max(maxima, key=lambda maximum: maximum[1].likelihood)
    fit = _inferred(values, fixed, random, components, state)
    if not error_covariance.any():
        return fit
    return fit._replace(
        ignorant=fit_mixed(values, structure._replace(error_covariance=np.zeros_like(error_covariance)))
    )


def is_diagonal(component: np.ndarray) -> bool:
    """Whether a component correlates no rows."""
    return bool(np.all(component == np.diag(np.diag(component))))


class _State(NamedTuple):
    likelihood: float
    root: np.ndarray
    inverse: np.ndarray  # of the covariance of the rows
    plain: np.ndarray  # covariance of the coefficients
    projection: np.ndarray  # the rows' inverse covariance without what the fixed effects explain


def _state(
    values: np.ndarray, fixed: np.ndarray, random: np.ndarray, error_covariance: np.ndarray, components: np.ndarray
) -> _State:
    covariance = error_covariance + np.tensordot(components, random, axes=1)
    root = np.linalg.cholesky(covariance)
    inner = np.linalg.inv(root)
    inverse = inner.T @ inner
    weighted = inverse @ fixed
    information = fixed.T @ weighted
    plain = np.linalg.inv(information)
    projection = inverse - weighted @ plain @ weighted.T
    size = 2 * np.log(np.diag(root)).sum() + np.linalg.slogdet(information)[1]
    return _State(-0.5 * float(size + values @ projection @ values), root, inverse, plain, projection)


def _climbed(
    values: np.ndarray, fixed: np.ndarray, random: np.ndarray, error_covariance: np.ndarray, start: np.ndarray,
    lower_bounds: np.ndarray, scale: float,
) -> tuple[np.ndarray, _State]:  # fmt: skip
    """Return the components at a maximum of the restricted likelihood, by Fisher scoring within their limits."""
    components, state = start, _state(values, fixed, random, error_covariance, start)
    for _ in range(_MAX_SCORING_STEPS):
        projected = random @ state.projection  # (component, row, row)
        explained = state.projection @ values
        score = 0.5 * (explained @ random @ explained - np.trace(projected, axis1=1, axis2=2))
        information = 0.5 * np.einsum("kij,lji->kl", projected, projected)
        free = (components > lower_bounds) | (score > 0)
        step = np.zeros_like(components)
        step[free] = np.linalg.lstsq(information[np.ix_(free, free)], score[free], rcond=None)[0]
        for halved in range(_MAX_HALVINGS):
            updated = np.maximum(components + step * 0.5**halved, lower_bounds)
            try:
                next_state = _state(values, fixed, random, error_covariance, updated)
            except np.linalg.LinAlgError:
                continue
            if next_state.likelihood >= state.likelihood:
                break
        else:
            break
        moved, components, state = float(np.abs(updated - components).max()), updated, next_state
        if moved < _MIN_RELATIVE_CHANGE * scale:
            break
    return components, state


def _inferred(
    values: np.ndarray, fixed: np.ndarray, random: np.ndarray, components: np.ndarray, state: _State
) -> MixedFit:
    """Return what Kenward and Roger infer at the maximum (their eqs. for covariances linear in the components)."""
    inverse, plain = state.inverse, state.plain
    weighted = inverse @ fixed
    once = -np.einsum("ia,kij,jb->kab", weighted, random, weighted)  # P
    twice = np.einsum("ia,kij,jm,lmn,nb->klab", weighted, random, inverse, random, weighted, optimize=True)  # Q
    traces = np.einsum("kij,lji->kl", random @ inverse, random @ inverse)
    through = once @ plain
    information = 0.5 * (
        traces - 2 * np.einsum("ab,klba->kl", plain, twice) + np.einsum("kab,lba->kl", through, through)
    )
    uncertainty = np.linalg.pinv(information, hermitian=True)
    correction = np.einsum("kl,klab->ab", uncertainty, twice - np.einsum("kab,bc,lcd->klad", once, plain, once))
    adjusted = plain + 2 * plain @ correction @ plain
    weights = plain @ weighted.T
    coefficients = weights @ values
    residuals = np.linalg.solve(state.root, values - fixed @ coefficients)
    slopes = -plain @ once @ plain
    return MixedFit(coefficients, components, adjusted, plain, slopes, uncertainty, state.root, weights, residuals,
                    state.likelihood)  # fmt: skip
