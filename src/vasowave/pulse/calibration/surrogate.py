"""What stands for simulations while a fit searches: the linear network c, corrected by what simulations say of it, d.

c has the valleys of the objective, at some microseconds an answer. What it lacks is where exactly their floors lie, and
how a wall stiffens within the cycle. The simulations so far, values and derivatives, say that near by: d is a Gaussian
process that passes through all of them, and c + d is right to first order wherever was simulated.
"""

from dataclasses import dataclass, field

import numpy as np

from vasowave.pulse.calibration.compared import Compared
from vasowave.pulse.calibration.coordinates import Coordinates
from vasowave.pulse.calibration.descent import descend
from vasowave.pulse.calibration.linear_tree import Batch, linear_spectra
from vasowave.pulse.calibration.parameters import ParameterSpace


@dataclass(frozen=True)
class SurrogateRules:
    """How the linear network is corrected.

    Attributes
    ----------
    failed_residual : float
        Residual of what cannot be, mmHg.
    step : float
        Step of differences, in the coordinates.
    ranges : tuple of float
        Distances over which a correction may stay alike, in the coordinates; the likeliest is taken.
    trusted : float
        Distance from the next simulation up to which the correction counts, likewise.
    value_noise, slope_noise : float
        Variance of values and of derivatives of simulations while searching, over that of the correction.
    """

    failed_residual: float = 1e3
    step: float = 1e-5
    ranges: tuple[float, ...] = (0.5, 1.0, 2.0, 4.0)
    trusted: float = 1.0
    value_noise: float = 1e-9
    slope_noise: float = 1e-6


RULES = SurrogateRules()


@dataclass(eq=False)
class CorrectedNetwork:
    """c + d of one fit, at coordinates z.

    Attributes
    ----------
    coordinates : Coordinates
    linear : callable
        c at logarithms.
    strictness : float
        What c + d leaves more for each unit that a place is farther from all simulations than may be, mmHg.
    z : list of array, shape (free,)
        Where was simulated,
    spectra, slopes : list of array, shapes (row,) and (row, free)
        what was left there, and its derivatives by z.
    """

    coordinates: Coordinates
    linear: Batch
    strictness: float
    z: list[np.ndarray] = field(default_factory=list)
    spectra: list[np.ndarray] = field(default_factory=list)
    slopes: list[np.ndarray] = field(default_factory=list)
    _differences: list[np.ndarray] = field(default_factory=list)
    _range: float = 1.0
    _mean: np.ndarray | None = None
    _weights: np.ndarray | None = None
    _covariance: np.ndarray | None = None
    _variance: float = 0.0

    def residuals(self, z: np.ndarray, x: np.ndarray | None = None) -> np.ndarray:
        """Return what c + d leaves at coordinates z, logarithms x; shape (point, free) to (point, row).

        Too much where nothing can be.
        """
        x = self.coordinates.logarithms(z) if x is None else x
        values = self.linear(x)
        if self._mean is not None and self._weights is not None:
            values = values + self._mean + self._covariances(z) @ self._weights
            away = np.sqrt(((z[:, np.newaxis] - np.array(self.z)) ** 2).sum(axis=2)).min(axis=1)
            beyond = self.strictness * np.clip(away - RULES.trusted, 0.0, None)
            values = np.column_stack([values, beyond])
        return np.where(np.isfinite(values).all(axis=1, keepdims=True), values, RULES.failed_residual)

    def learn(self, z: np.ndarray, spectrum: np.ndarray, slopes: np.ndarray) -> None:
        """Take in one simulation: what it leaves, and its derivatives by z, shape (row, free)."""
        steps = np.vstack([np.zeros_like(z), RULES.step * np.eye(len(z)), -RULES.step * np.eye(len(z))])
        base, *sides = self.linear(self.coordinates.logarithms(z + steps))
        up, down = np.split(np.array(sides), 2)
        linear_slopes = (up - down).T / (2 * RULES.step)
        if not (np.isfinite(base).all() and np.isfinite(linear_slopes).all()):
            base, linear_slopes = np.zeros_like(spectrum), np.zeros_like(slopes)
        self.z.append(z)
        self.spectra.append(spectrum)
        self.slopes.append(slopes)
        self._differences.append(np.vstack([spectrum - base, (slopes - linear_slopes).T]))
        self._fit()

    def _fit(self) -> None:
        """Fit d, by NumPy's solver: threads of SciPy's Cholesky solver wait for each other longer than they compute."""
        n, free = len(self.z), len(self.z[0])
        y = np.concatenate([[d[0] for d in self._differences], np.concatenate([d[1:] for d in self._differences])])
        levels = np.append(np.ones(n), np.zeros(n * free))
        likeliest = np.inf
        for reach in RULES.ranges:
            noise = np.append(np.full(n, RULES.value_noise), np.full(n * free, RULES.slope_noise / reach**2))
            covariance = _covariance(np.array(self.z), reach) + np.diag(noise)
            solved, by_values = np.split(np.linalg.solve(covariance, np.column_stack([levels, y])), [1], axis=1)
            mean = solved[:, 0] @ y / (solved[:, 0] @ levels)
            weights = by_values - solved * mean
            powers = np.sum((y - np.outer(levels, mean)) * weights, axis=0) / len(y)
            total = float(powers.sum()) + 1e-300
            score = len(y) * np.log(total) + np.linalg.slogdet(covariance)[1]
            if score < likeliest:
                likeliest = score
                self._range, self._mean, self._weights = reach, mean, weights
                self._covariance, self._variance = covariance, total

    def _covariances(self, z: np.ndarray) -> np.ndarray:
        """Return the covariances of values at z with all that is known, shape (point, known)."""
        offset = z[:, np.newaxis] - np.array(self.z)
        alike = np.exp(-0.5 * np.sum(offset**2, axis=2) / self._range**2)
        slopes = alike[..., np.newaxis] * offset / self._range**2
        return np.concatenate([alike, slopes.reshape(len(z), len(self.z) * z.shape[1])], axis=1)

    def deviation(self, z: np.ndarray) -> np.ndarray:
        """Return the SD of the root of S/N that d leaves open at coordinates, mmHg, shape (point,)."""
        if self._covariance is None:
            return np.full(len(z), np.inf)
        covariances = self._covariances(z)
        explained = np.sum(covariances * np.linalg.solve(self._covariance, covariances.T).T, axis=1)
        return np.sqrt(self._variance * np.clip(1.0 - explained, 0.0, None))


def _covariance(z: np.ndarray, reach: float) -> np.ndarray:
    """Return the covariance of values and derivatives at z, of a process whose variance is 1."""
    n, free = z.shape
    offset = z[:, np.newaxis] - z
    alike = np.exp(-0.5 * np.sum(offset**2, axis=2) / reach**2)
    across = (alike[..., np.newaxis] * offset / reach**2).reshape(n, n * free)
    curved = np.eye(free) / reach**2 - offset[..., np.newaxis] * offset[:, :, np.newaxis] / reach**4
    slopes = (alike[..., np.newaxis, np.newaxis] * curved).transpose(0, 2, 1, 3).reshape(n * free, n * free)
    return np.block([[alike, across], [across.T, slopes]])


def linear_optimum(space: ParameterSpace, compared: Compared) -> np.ndarray:
    """Return the logarithms of the free parameters to which the linear network alone leads the nominal ones."""
    nominal = np.log(space.nominal[space.free])
    coordinates, linear = Coordinates(space, compared.recording.mean_pressure), linear_spectra(space, compared)
    floors = descend(
        CorrectedNetwork(coordinates, linear, 0.0).residuals, coordinates, nominal[np.newaxis], RULES.failed_residual**2
    )
    return floors.x[0] if len(floors.x) else nominal
