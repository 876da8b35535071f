"""The likelihood of a residual: discrepancy of the model, errors of measurement and of single vessels, one Gaussian.

What no parameters explain is a stationary process on the circle: its Fourier coefficients are independent. Their
variance is σ², the square of the standard deviation in the cycle, times one of `noise.spectrum.spectral_shapes`. σ and
the shape's r and s are unknown; the likelihood is the mean over their priors. For each shape (r, s) all other
covariances are diagonalized beside it once, so that each σ costs a sum.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vasowave.pulse.noise.spectrum import harmonics, spectral_shapes, spectral_sizes, with_points

_ROUNDING = 1e-9  # of a variance of 1: what errors that are known exactly may be below 0


class Drawn(NamedTuple):
    """What may lie behind residuals.

    Attributes
    ----------
    deviation : array, shape (draw,)
        Standard deviation σ of the discrepancy, mmHg.
    zero : array, shape (draw,)
        Error of the zero of the pressure, in its SD.
    errors : array, shape (draw, error)
        Errors of single vessels, in their SD.
    vessels : array, shape (draw, coefficient)
        What these change, mmHg.
    noise : array, shape (draw, coefficient)
        Another residual of the same kind, mmHg: discrepancy and all errors.
    """

    deviation: np.ndarray
    zero: np.ndarray
    errors: np.ndarray
    vessels: np.ndarray
    noise: np.ndarray


class Passed(NamedTuple):
    """How the error of a flow that enters a model reaches the pressure that is compared.

    A model passes on the error of the flow times its own impedance. Under one covariance for all models, those of small
    impedance leave the smaller residuals, so that harmonics of a flow that is known badly draw every impedance down
    (regression dilution). So a residual counts beside the error that its own model passes on: that is the likelihood of
    pressure and flow at the likeliest true flow (a regression with errors in both).

    Attributes
    ----------
    samples : int
        Coefficients of the pressure, an odd number.
    measured : array, shape (coefficient,)
        Of the pressure that was measured, and of further sites, mmHg.
    variance : array, shape (coefficient,)
        What the error of the flow in the same harmonic adds to the variance of each in one model, mmHg².
    power : array, shape (coefficient,)
        Sum of the squares of each and of the other one of its harmonic (the mean itself) in that model, mmHg²; any
        where the variance is 0.
    total : array, shape (coefficient,)
        Variance of each coefficient in that model by everything, mmHg².
    """

    samples: int
    measured: np.ndarray
    variance: np.ndarray
    power: np.ndarray
    total: np.ndarray

    def counted(self, residuals: np.ndarray) -> np.ndarray:
        """Return what residuals (..., coefficient) count as under the variance of the one model, mmHg."""
        return residuals * self._factor(self.measured - residuals)

    def slope(self, residual: np.ndarray) -> np.ndarray:
        """Return how what a residual counts as falls with each coefficient of its model, (coefficient, coefficient)."""
        index, simulated = np.arange(len(residual)), self.measured - residual
        factor = self._factor(simulated)
        bend = residual * factor**3 * self.variance / (self.power * self.total)
        slope = np.diag(factor + bend * simulated)
        slope[index, self._beside] += bend * simulated[self._beside]
        return slope

    def _factor(self, simulated: np.ndarray) -> np.ndarray:
        square = simulated**2
        increase = self.variance * ((square + square[..., self._beside]) / self.power - 1)
        return 1 / np.sqrt(1 + increase / self.total)

    @property
    def _beside(self) -> np.ndarray:
        """The other coefficient of the same harmonic, of a cosine the sine's; of the mean itself."""
        index, harmonics = np.arange(len(self.measured)), self.samples // 2
        index[1 : self.samples] = np.roll(index[1 : self.samples], harmonics)
        return index


@dataclass(frozen=True, eq=False)
class Discrepancy:
    """Likelihood of residuals given as orthonormal Fourier coefficients, shape (..., coefficient), mmHg.

    Attributes
    ----------
    samples : int
        Coefficients of the pressure, an odd number: the mean and the cosines and sines of all harmonics.
    amplitude : (float, float)
        Median (mmHg) and SD of the logarithm of σ, the standard deviation of the discrepancy in the cycle.
    measured : array, shape (coefficient, coefficient)
        Covariance of the errors of measurement, mmHg².
    vessels : array, shape (coefficient, error)
        What one SD of each independent error of a single vessel changes, mmHg.
    selected : (bool array, bool array), optional
        Shapes and amplitudes that are summed over; all, if not given.
    left_out : bool array, shape (coefficient,), optional
        Coefficients of a residual that do not count.
    of_mean : float
        Largest standard deviation that the mean of the discrepancy can have, mmHg.
    site_harmonics : int array, shape (coefficient of others,), optional
        Harmonics of the coefficients of further sites, which follow those of the pressure; see `calibration.sites`.
    passed : Passed, optional
        How the error of the flow that enters reaches the pressure; part of `measured`.
    """

    samples: int
    amplitude: tuple[float, float]
    measured: np.ndarray
    vessels: np.ndarray
    selected: tuple[np.ndarray, np.ndarray] | None = None
    left_out: np.ndarray | None = None
    of_mean: float = np.inf
    site_harmonics: np.ndarray | None = None
    passed: Passed | None = None

    def beside_flow(self, variance: np.ndarray, power: np.ndarray, observed: np.ndarray) -> "Discrepancy":
        """Return the likelihood where the error of the flow reaches the pressure that was `observed`; see `Passed`."""
        shapes, weight = self._shapes
        usual = self.amplitude[0] ** 2 * np.average(shapes, axis=0, weights=np.exp(weight))
        return replace(self, passed=Passed(self.samples, observed, variance, power, usual + self._known))

    def near(self, residual: np.ndarray) -> "Discrepancy":
        """Return the same for models whose residuals are like this one, shape (coefficient,)."""
        if self.passed is None:
            return self
        total = self.variance(residual[np.newaxis]) + self._known
        return replace(self, passed=self.passed._replace(total=total))._diagonal_as(*self._diagonal)

    @property
    def _known(self) -> np.ndarray:
        """Variance of each coefficient by errors of measurement and of single vessels, mmHg²."""
        return np.diag(self.measured) + (self.vessels**2).sum(axis=1)

    def without(self, left_out: np.ndarray) -> "Discrepancy":
        """Return the likelihood of residuals of which some coefficients, bool (coefficient,), are not known."""
        return replace(self, left_out=left_out)

    def narrowed(self, residuals: np.ndarray, min_share: float) -> "Discrepancy":
        """Return the sum over only those spectra that matter for one of the residuals, (draw, coefficient).

        They have at least this share of the largest term of the sum.
        """
        complete = self if self.selected is None else replace(self, selected=None)
        log = complete._by_node(residuals)
        share = np.exp(log - log.max(axis=(0, 2), keepdims=True)).max(axis=1)
        shapes, sizes = share.max(axis=1) > min_share, share.max(axis=0) > min_share
        turn, values, logdet = complete._diagonal
        return replace(complete, selected=(shapes, sizes))._diagonal_as(turn[shapes], values[shapes], logdet[shapes])

    def widened(self, missed: float) -> "Discrepancy":
        """Return the likelihood of residuals of a model that misses by so much more, mmHg, root mean square."""
        median, spread = self.amplitude
        return replace(self, amplitude=(float(np.hypot(median, missed)), spread))._diagonal_as(*self._diagonal)

    def _diagonal_as(self, *diagonal: np.ndarray) -> "Discrepancy":
        """Take `_diagonal` from a likelihood of the same covariances: nothing else here costs as much."""
        vars(self)["_diagonal"] = diagonal
        return self

    def log_likelihood(self, residuals: np.ndarray) -> np.ndarray:
        """Return the logarithm of the density of residuals, shape (...)."""
        log = self._by_node(np.atleast_2d(residuals))
        largest = log.max(axis=(0, 2))
        total = np.exp(log - largest[:, np.newaxis]).sum(axis=(0, 2))
        return (largest + np.log(total)).reshape(residuals.shape[:-1])

    def variance(self, residuals: np.ndarray) -> np.ndarray:
        """Return the variance of each coefficient of the discrepancy, mmHg², averaged over residuals (draw, ...)."""
        log = self._by_node(np.atleast_2d(residuals))
        weight = np.exp(log - log.max(axis=(0, 2), keepdims=True))
        share = (weight / weight.sum(axis=(0, 2), keepdims=True)).mean(axis=1)
        variance = np.einsum("sa,a,sk->k", share, self._amplitudes[0] ** 2, self._shapes[0])
        variance[0] -= np.sum(share * self._beyond)
        return variance

    def drawn(self, residuals: np.ndarray, zero: np.ndarray, rng: np.random.Generator) -> Drawn:
        """Return a draw of what lies behind each residual, shape (draw, coefficient).

        Parameters
        ----------
        residuals : array, shape (draw, coefficient)
        zero : array, shape (coefficient,)
            What one SD of the zero of the pressure changes; part of the errors of measurement.
        rng : numpy.random.Generator
        """
        log = self._by_node(residuals).transpose(1, 0, 2).reshape(len(residuals), -1)
        share = np.cumsum(np.exp(log - log.max(axis=1, keepdims=True)), axis=1)
        node = (share < share[:, -1:] * rng.random((len(residuals), 1))).sum(axis=1)
        residuals = residuals if self.passed is None else self.passed.counted(residuals)
        places = list(zip(*np.divmod(node, self._nodes[1].shape[2]), strict=True))
        errors = np.vstack([zero, self.vessels.T])
        scores = np.array([self._scores(errors, *pair, rng) for pair in zip(residuals, places, strict=True)])
        again = np.array([self._noise_at(place, rng) for place in places])
        deviation = self._amplitudes[0][np.array(places)[:, 1]]
        return Drawn(deviation, scores[:, 0], scores[:, 1:], scores[:, 1:] @ self.vessels.T, again)

    def _scores(
        self, errors: np.ndarray, residual: np.ndarray, place: tuple[int, int], rng: np.random.Generator
    ) -> np.ndarray:
        """Return a draw of independent errors behind a residual at a node, in their SD, from what an SD changes."""
        (turn, precision, _), (shape, size) = self._nodes, place
        directions, weights = errors @ turn[shape], precision[shape, :, size]
        of_mean = np.outer(directions @ (turn[shape, 0] * weights), turn[shape, 0])
        gain = (directions + self._gain[shape, size] * of_mean) * weights
        root = np.linalg.cholesky((1 + _ROUNDING) * np.eye(len(errors)) - gain @ directions.T)
        return np.asarray(gain @ (residual @ turn[shape]) + root @ rng.standard_normal(len(errors)))

    def _noise_at(self, place: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
        """Return a draw of discrepancy and all errors at a node, shape (coefficient,), mmHg."""
        (turn, precision, _), (shape, size) = self._nodes, place
        weights = precision[shape, :, size]
        white = rng.standard_normal(len(weights)) / np.sqrt(weights)
        noise = np.array(self._shapes[0][shape] * (turn[shape] @ white))  # inverse of the turn, transposed
        noise[0] -= self._taken[shape, size] * (turn[shape, 0] * weights @ white)
        return noise

    def _by_node(self, rows: np.ndarray) -> np.ndarray:
        """Return log prior plus log density, shape (shape, draw, amplitude)."""
        turn, precision, constant = self._nodes
        rows = rows if self.passed is None else self.passed.counted(rows)
        turned = rows[:, self._counted] @ turn
        log = constant[:, np.newaxis] - 0.5 * (turned**2 @ precision)
        if self._beyond.any():
            log -= 0.5 * self._gain[:, np.newaxis] * ((turned * turn[:, :1]) @ precision) ** 2
        return log

    @cached_property
    def _gain(self) -> np.ndarray:
        """What V⁻¹e (eᵀV⁻¹) is multiplied by in the inverse of V - δ e eᵀ, e being the mean's row and δ `_beyond`."""
        return self._beyond / (1 - self._beyond * self._precision_of_mean)

    @cached_property
    def _taken(self) -> np.ndarray:
        """How much of eᵀV⁻¹x is taken from the mean of a draw x of V, to make it one of V - δ e eᵀ."""
        precision = self._precision_of_mean
        return (1 - np.sqrt(1 - self._beyond * precision)) / precision

    @cached_property
    def _beyond(self) -> np.ndarray:
        """What the variance of the mean exceeds its limit by, mmHg², shape (shape, amplitude)."""
        counted = self.left_out is None or not self.left_out[0]
        of_mean = self._shapes[0][:, :1] * self._amplitudes[0] ** 2
        return np.maximum(of_mean - self.samples * self.of_mean**2, 0.0) * counted

    @cached_property
    def _precision_of_mean(self) -> np.ndarray:
        """Diagonal term of the mean in the inverse of the covariance without limit, shape (shape, amplitude)."""
        turn, values, _ = self._diagonal
        total = values[:, :, np.newaxis] + self._amplitudes[0] ** 2
        return np.einsum("sk,ska->sa", turn[:, 0] ** 2, 1 / total)

    @cached_property
    def _nodes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """For every shape: rotation of the residual, precision there by amplitude, and what does not depend on it."""
        turn, values, logdet = self._diagonal
        sigma, log_prior = self._amplitudes
        total = values[:, :, np.newaxis] + sigma**2
        constant = -0.5 * (np.log(2 * np.pi * total).sum(axis=1) + logdet[:, np.newaxis])
        constant -= 0.5 * np.log1p(-self._beyond * self._precision_of_mean)
        return turn, 1 / total, constant + log_prior + self._shapes[1][:, np.newaxis]

    @cached_property
    def _shapes(self) -> tuple[np.ndarray, np.ndarray]:
        """Variances for σ = 1 of every shape, (shape, coefficient that counts), and log prior weights.

        The mean over all coefficients of the pressure is 1.
        """
        shapes, weight = spectral_shapes(harmonics(self.samples))
        if self.site_harmonics is not None:
            shapes = np.concatenate([shapes, with_points(shapes, self.site_harmonics)], axis=1)
        shown = slice(None) if self.selected is None else self.selected[0]
        return shapes[shown][:, self._counted], weight[shown]

    @property
    def harmonic(self) -> np.ndarray:
        """Harmonic of each coefficient; negative for a single value of the cycle of a further site."""
        at_inlet = harmonics(self.samples)
        return at_inlet if self.site_harmonics is None else np.append(at_inlet, self.site_harmonics)

    @property
    def _counted(self) -> np.ndarray | slice:
        """Which coefficients count."""
        return slice(None) if self.left_out is None else ~self.left_out

    @cached_property
    def _amplitudes(self) -> tuple[np.ndarray, np.ndarray]:
        """Nodes of σ, mmHg, and log prior weights."""
        sigma, weight = spectral_sizes(*self.amplitude)
        shown = slice(None) if self.selected is None else self.selected[1]
        return sigma[shown], weight[shown]

    @cached_property
    def _diagonal(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """For every shape S: V with Vᵀ S V = 1 and Vᵀ (other covariance) V diagonal, that diagonal, and log det S."""
        covariance = (self.measured + self.vessels @ self.vessels.T)[self._counted][:, self._counted]
        scale = np.sqrt(self._shapes[0])
        white = covariance / (scale[:, :, np.newaxis] * scale[:, np.newaxis, :])
        values, axes = np.linalg.eigh(white)
        return axes / scale[:, :, np.newaxis], np.maximum(values, 0.0), 2 * np.log(scale).sum(axis=1)
