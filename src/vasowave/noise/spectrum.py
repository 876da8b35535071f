"""What the residual of a fit says about the noise: a smooth spectrum, from its restricted likelihood.

A measured cycle closes, so its noise is stationary and periodic: its Fourier coefficients are independent, with a
variance that falls with the harmonic. A fit removes from the residual what its parameters can imitate, above all at low
harmonics; the restricted likelihood allows for that.
"""

from dataclasses import dataclass

import numpy as np

from vasowave.noise.gaussian import without_fit

HARMONICS = 20
"""Harmonics from which the spectrum is estimated: those that the averaged cycle of a mouse carries."""

_USUAL = np.log([1.0, 4.0, 2.5])  # the shape of the residual of a measured mouse; σ² is free
_SPREAD = np.array([np.inf, 0.7, 0.5])  # SD of the logarithms around it
_LOG_BOUNDS = np.log([(1e-9, 1e4), (0.5, 30.0), (0.5, 8.0)])
_CORNERS = (3.0, 8.0)  # starts of the corner harmonic
_STEP = 1e-2  # of the finite differences, in logarithms
_FLATTEST = 1e-2  # curvature below which a hyperparameter counts as known to its bounds only
MOST_HIDDEN = 4.0  # noise that a fit hides is at most this times as strong as at the harmonic where most is seen
FEWEST_DEGREES = 2.0  # degrees of freedom; with fewer an interval would be as good as infinite


@dataclass(frozen=True, eq=False)
class NoiseSpectrum:
    """Variance S_k = σ² (1 + (k/k0)²)^-m of the Fourier coefficients of harmonic k, and how well it is known.

    This is what a model leaves unexplained; the error of the measurement is known and comes on top of it.

    Attributes
    ----------
    logarithms : array, shape (3,)
        log σ² (mmHg²), log k0, log m.
    covariance : array, shape (3, 3)
        Of their estimates.
    """

    logarithms: np.ndarray
    covariance: np.ndarray

    def variance(self, harmonic: np.ndarray) -> np.ndarray:
        """Variance of the coefficients at these harmonics, mmHg²."""
        return _variance(self.logarithms, harmonic)


def known_variance(error_power: np.ndarray, count: int) -> np.ndarray:
    """Variance of each coefficient that `fourier` returns, mmHg², from the mean square of an error in each harmonic."""
    k = harmonics(count)
    return count * error_power[k] / np.bincount(k)[k]


def noise_spectrum(residual: np.ndarray, jacobian: np.ndarray, known: np.ndarray | float = 0.0) -> NoiseSpectrum:
    """Return the spectrum of the noise behind the residual of a least-squares fit.

    Parameters
    ----------
    residual : array, shape (N,)
        Measured minus simulated pressure over one period, mmHg.
    jacobian : array, shape (N, D)
        Its derivative by the parameters at the optimum.
    known : array, shape (N,), optional
        Variance of the coefficients by the error of the measurement, see `known_variance`.
    """
    from scipy.optimize import minimize

    harmonic = harmonics(len(residual))
    kept = harmonic <= min(HARMONICS, (len(residual) - 1) // 2)
    k, y, J = harmonic[kept], fourier(residual)[kept], fourier(jacobian)[kept]
    scale = max(float(np.mean(y**2)), 1e-300)
    y, floor = y / np.sqrt(scale), np.broadcast_to(known, len(harmonic))[kept] / scale
    J = np.linalg.qr(J)[0]  # any basis of what the parameters can imitate serves
    fits = [
        minimize(_objective, np.log([10.0, corner, 2.0]), (k, y, J, floor), "L-BFGS-B", bounds=_LOG_BOUNDS)
        for corner in _CORNERS
    ]
    best = min(fits, key=lambda one: one.fun).x
    curvature, axes = np.linalg.eigh(_hessian(lambda x: _objective(x, k, y, J, floor), best))
    covariance = (axes / np.maximum(curvature, _FLATTEST)) @ axes.T
    return NoiseSpectrum(best + np.array([np.log(scale), 0.0, 0.0]), covariance)


def least_squares_covariance(
    residual: np.ndarray,
    jacobian: np.ndarray,
    spectrum: NoiseSpectrum,
    ranges: np.ndarray | None = None,
    known: np.ndarray | float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Covariance of least-squares estimates under this noise, J⁺ Σ J⁺ᵀ, and the degrees of freedom of each variance.

    The noise is known from one short residual only; Satterthwaite's degrees of freedom, 2 V²/Var V, say how well, and
    the quantiles of Student's t distribution with them make intervals that cover. Parameters with a range (of the
    bounds) are nowhere less certain than it allows: a combination that the data do not see would otherwise spread its
    endless error over the others. `known` is as in `noise_spectrum`.
    """
    k = harmonics(len(residual))
    variance = np.minimum(spectrum.variance(k), MOST_HIDDEN * _largest_seen(residual)) + known
    inverse = _inverse(fourier(jacobian), variance, ranges)
    matrix = (inverse * variance) @ inverse.T
    slopes = []
    for unit in np.eye(3):
        up, down = (_variance(spectrum.logarithms + sign * _STEP * unit, k) for sign in (1, -1))
        slopes.append((inverse**2) @ (up - down) / (2 * _STEP))
    gradient = np.array(slopes)
    uncertain = np.einsum("ip,ij,jp->p", gradient, spectrum.covariance, gradient)
    with np.errstate(divide="ignore", invalid="ignore"):
        freedom = 2 * np.diag(matrix) ** 2 / uncertain
    return matrix, np.where(np.isfinite(freedom), np.maximum(freedom, FEWEST_DEGREES), np.inf)


def is_limited(residual: np.ndarray, spectrum: NoiseSpectrum) -> bool:
    """Whether the spectrum, extrapolated below what a residual shows, passes the limit of hidden noise."""
    return bool(spectrum.variance(np.zeros(1))[0] > MOST_HIDDEN * _largest_seen(residual))


def _inverse(J: np.ndarray, variance: np.ndarray, ranges: np.ndarray | None) -> np.ndarray:
    """Return the pseudo-inverse of J, its gain limited where noise would carry parameters out of their ranges."""
    left, singular, right = np.linalg.svd(J, full_matrices=False)
    with np.errstate(divide="ignore"):
        gain = 1 / singular
    if ranges is not None:
        uniform = (right**2) @ (ranges**2 / 12)  # variance along each singular direction if all is possible
        gain = np.minimum(gain, np.sqrt(uniform / (variance @ left**2)))
    return (right.T * gain) @ left.T


def _largest_seen(residual: np.ndarray) -> float:
    """Largest mean square of the residual's coefficients over its harmonics, mmHg².

    The spectrum is a law for its fall. Below the harmonics that a residual shows it would be extrapolated, for mouse C6
    to an error of the mean pressure of 6 mmHg, where no harmonic shows more than 0.2.
    """
    k = harmonics(len(residual))
    power = np.bincount(k, fourier(residual) ** 2) / np.bincount(k)
    return max(float(power[1 : HARMONICS + 1].max()), 1e-300)


def harmonics(count: int) -> np.ndarray:
    """Harmonic of each coefficient that `fourier` returns."""
    return np.concatenate([np.arange(count // 2 + 1), np.arange(1, (count - 1) // 2 + 1)])


def fourier(values: np.ndarray) -> np.ndarray:
    """Orthonormal real Fourier coefficients along the first axis: all cosines, then all sines."""
    count = len(values)
    spectrum = np.fft.rfft(values, axis=0) / np.sqrt(count)
    inner = slice(1, (count - 1) // 2 + 1)
    cosines = spectrum.real.copy()
    cosines[inner] *= np.sqrt(2)
    return np.concatenate([cosines, -np.sqrt(2) * spectrum.imag[inner]])


def _variance(logarithms: np.ndarray, harmonic: np.ndarray) -> np.ndarray:
    power, corner, slope = np.exp(logarithms)
    return power * falling_power(harmonic, corner, slope)


def falling_power(harmonic: np.ndarray, corner: float, slope: float) -> np.ndarray:
    """Power (1 + (k/k0)²)^-m of harmonic k: that of a Matérn process on the circle."""
    return (1 + (harmonic / corner) ** 2) ** -slope


def _objective(x: np.ndarray, k: np.ndarray, y: np.ndarray, J: np.ndarray, known: np.ndarray) -> float:
    """Return minus the restricted log-likelihood and minus the log-prior of the shape.

    One residual has few harmonics left after a fit; without the prior a spectrum that rises without end towards
    harmonic 0, which the parameters hide, is sometimes the likeliest.
    """
    return 0.5 * float(np.sum(((x - _USUAL) / _SPREAD) ** 2)) - restricted_likelihood(x, k, y, J, known)


def restricted_likelihood(
    x: np.ndarray, k: np.ndarray, y: np.ndarray, J: np.ndarray, known: np.ndarray | float = 0.0
) -> float:
    """Log-likelihood of what the parameters could not take from the residual, up to a constant."""
    deviation = np.sqrt(_variance(x, k) + known)
    left, information = without_fit(y / deviation, J / deviation[:, np.newaxis])
    return -0.5 * float(2 * np.log(deviation).sum() + information + left @ left)


def _hessian(function, x: np.ndarray) -> np.ndarray:  # type: ignore[no-untyped-def]
    steps = _STEP * np.eye(len(x))
    H = np.empty((len(x), len(x)))
    for i, a in enumerate(steps):
        for j, b in enumerate(steps):
            H[i, j] = function(x + a + b) - function(x + a - b) - function(x - a + b) + function(x - a - b)
    return H / (4 * _STEP**2)
