"""What the residual of a fit says about the noise: the spectra that may lie behind it, each with its probability.

A measured cycle closes, so its noise is stationary and periodic: its Fourier coefficients are independent, with a
variance that falls with the harmonic. A fit removes from the residual what its parameters can imitate, above all at
low harmonics; the restricted likelihood allows for that. What a residual leaves open of the spectrum is integrated out.
"""

from typing import NamedTuple

import numpy as np

from vasowave.base.descriptions import LEVEL, NORMAL

SPECTRUM_HARMONICS = 20
"""Harmonics by which spectra are judged: those that the averaged cycle of a mouse carries."""

LOG_RATE_PRIOR = np.log(0.5), 0.5
"""Mean and SD of log r: power falls to 1/e over two harmonics, as that of the residual of measured mouse C6."""

LOG_POWER_PRIOR = np.log(6.0), 0.5
"""Mean and SD of log s."""

SIZE_PRIOR = 0.03, 0.7
"""Median of σ as a share of the pulse pressure, and SD of its logarithm: from 0.8 to 12 %. What published fits left of
twelve mice is 1 to 7 % (root of S over the 1024 samples, over the pulse pressure of their group)."""

_RATE_NODES, _POWER_NODES = np.linspace(-3.6, 3.6, 13), np.linspace(-3.6, 3.6, 7)
"""Nodes of the quadrature over log r and log s, in SD. Twice as many that reach farther move no evidence by 0.03."""
_SIZE_REACH_SD = 6.0
"""SD of the prior of log σ up to which its nodes reach, on both sides."""
_MAX_SIZE_STEP = 0.175
"""Largest step of log σ, whose likelihood is narrower than its prior: by 40 coefficients it is known within 0.11."""
_MAX_SIZE_SD = 0.5  # SD of log σ, in that of its prior, above which the prior counts as what decides
_WIDTH_TOLERANCE = 1e-10  # relative step of the half width of an interval at which it is found
_MIN_SPECTRUM_PROBABILITY = 1e-6  # probability of a spectrum below which it is left out


class Spectra(NamedTuple):
    """Spectra that may lie behind a residual.

    Attributes
    ----------
    variance : array, shape (spectrum, coefficient)
        Of each Fourier coefficient, mmHg², the error of the measurement included.
    probability : array, shape (spectrum,)
        Adding up to 1.
    assumed : bool
        Whether the residual hardly tells how strong the noise is, so that the prior of its size decides.
    """

    variance: np.ndarray
    probability: np.ndarray
    assumed: bool


def known_variance(error_power: np.ndarray, count: int) -> np.ndarray:
    """Variance of each coefficient that `fourier` returns, mmHg², from the mean square of an error in each harmonic."""
    k = harmonics(count)
    return count * error_power[k] / np.bincount(k)[k]


def spectral_shapes(harmonic: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return variances (1 + rk/s)^-s of harmonics k, up to a factor that makes their mean 1, and log prior weights.

    The power falls with the harmonic by the rate r at first and as k^-s at last. It rises to the very mean: parameters
    take the lowest harmonics from every residual, so that a spectrum which became flat there would promise what no
    residual can show.

    Parameters
    ----------
    harmonic : array, shape (coefficient,)

    Returns
    -------
    shapes : array, shape (shape, coefficient)
        Of all pairs of nodes of log r and log s.
    log_weight : array, shape (shape,)
        Adding up to 1.
    """
    r, s = (
        np.exp(LOG_RATE_PRIOR[0] + LOG_RATE_PRIOR[1] * _RATE_NODES),
        np.exp(LOG_POWER_PRIOR[0] + LOG_POWER_PRIOR[1] * _POWER_NODES),
    )
    shapes = np.array([(1 + rate * harmonic / power) ** -power for rate in r for power in s])
    return shapes / shapes.mean(axis=1, keepdims=True), _log_normal(
        np.add.outer(_RATE_NODES**2, _POWER_NODES**2).ravel()
    )


def with_points(shapes: np.ndarray, harmonic: np.ndarray) -> np.ndarray:
    """Return the variances of other coefficients by their harmonics, (shape, coefficient), from `spectral_shapes`.

    A single value of the cycle (negative) has the mean of all variances, 1.
    """
    return np.where(harmonic < 0, 1.0, shapes[:, np.maximum(harmonic, 0)])


def spectral_sizes(median: float, spread: float) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes of σ, whose logarithm is normal with an SD of `spread`, and their log prior weights, (size,)."""
    if spread == 0:
        return np.array([median]), np.zeros(1)
    half = int(np.ceil(_SIZE_REACH_SD * max(4.0, spread / _MAX_SIZE_STEP)))  # nodes on either side
    score = np.linspace(-_SIZE_REACH_SD, _SIZE_REACH_SD, 2 * half + 1)
    return median * np.exp(spread * score), _log_normal(score**2)


def _log_normal(square: np.ndarray) -> np.ndarray:
    """Return log weights, adding up to 1, of nodes at these squared distances (in SD) from the center."""
    return np.asarray(-0.5 * square - np.log(np.exp(-0.5 * square).sum()))


class Beside(NamedTuple):
    """Coefficients of other signals, scaled so that the model's error has the same spectrum in all.

    Attributes
    ----------
    harmonic : array, shape (coefficient,)
        Negative for a single value of the cycle, to which all harmonics add.
    residual : array, shape (coefficient,)
    jacobian : array, shape (coefficient, D)
    weight : array, shape (coefficient, coefficient)
        What residuals were multiplied by in the least squares.
    error : array, shape (coefficient, coefficient)
        Covariance of the errors of measurement.
    """

    harmonic: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray
    weight: np.ndarray
    error: np.ndarray


def likely_spectra(
    residual: np.ndarray,
    jacobian: np.ndarray,
    pulse: float,
    error_variance: np.ndarray | float = 0.0,
    of_mean: float = np.inf,
    signals: Beside | None = None,
) -> Spectra:
    """Return the spectra that may lie behind the residual of a least-squares fit.

    Their prior is that of a posterior: `spectral_shapes`, and a standard deviation σ in the cycle around a share of the
    pulse pressure (`SIZE_PRIOR`). Without a prior of σ a steep spectrum could hide an error of the mean pressure many
    times larger than anything that the residual shows.

    Parameters
    ----------
    residual : array, shape (N,)
        Measured minus simulated pressure over one period, mmHg.
    jacobian : array, shape (N, D)
        Its derivative by the parameters at the optimum.
    pulse : float
        Pulse pressure of the measured cycle, mmHg.
    error_variance : array, shape (N,), optional
        Variance of the coefficients by the error of the measurement, see `known_variance`.
    of_mean : float
        Largest standard deviation that the mean of the discrepancy can have, mmHg.
    signals : Beside, optional
        What other signals say of the same parameters.
    """
    k, y, J = harmonics(len(residual)), fourier(residual), fourier(jacobian)
    (shapes, log_shape), (sigma, log_size) = spectral_shapes(k), spectral_sizes(SIZE_PRIOR[0] * pulse, SIZE_PRIOR[1])
    variance_limit = np.where(k == 0, len(k) * of_mean**2, np.inf)
    variance = np.minimum(sigma[:, np.newaxis] ** 2 * shapes[:, np.newaxis], variance_limit) + error_variance
    if signals is not None:
        signal_variance = sigma[:, np.newaxis] ** 2 * with_points(shapes, signals.harmonic)[:, np.newaxis]
        variance = np.concatenate([variance, signal_variance + np.diag(signals.error)], axis=-1)
        k, y, J = np.append(k, signals.harmonic), np.append(y, signals.residual), np.vstack([J, signals.jacobian])
    variance = variance.reshape(-1, len(k))
    basis = np.linalg.qr(J)[0]  # of what the parameters can imitate
    fitted = k <= SPECTRUM_HARMONICS
    log = np.add.outer(log_shape, log_size).ravel() + restricted_likelihood(
        variance[:, fitted], y[fitted], basis[fitted]
    )
    probability = np.exp(log - log.max())
    probability /= probability.sum()
    size, scores = probability.reshape(-1, len(sigma)).sum(axis=0), np.log(sigma) / SIZE_PRIOR[1]
    loose = np.sqrt(size @ scores**2 - (size @ scores) ** 2) > _MAX_SIZE_SD
    return Spectra(variance, probability, bool(loose))


def restricted_likelihood(variance: np.ndarray, y: np.ndarray, J: np.ndarray) -> np.ndarray:
    """Return the log-likelihood of what the parameters could not take from a residual, up to a constant.

    Variances are (spectrum, coefficient), the residual's coefficients `y` (coefficient,), `J` (coefficient, D).
    """
    basis = np.linalg.qr(J)[0]  # any basis of what the parameters can imitate serves
    information = np.einsum("nk,ki,kj->nij", 1 / variance, basis, basis, optimize=True)
    projection = (y / variance) @ basis
    taken = np.einsum("ni,ni->n", projection, np.linalg.solve(information, projection[:, :, np.newaxis])[:, :, 0])
    return -0.5 * (np.log(variance).sum(axis=1) + np.linalg.slogdet(information)[1] + (1 / variance) @ y**2 - taken)


def least_squares_covariance(
    jacobian: np.ndarray, spectra: Spectra, ranges: np.ndarray | None = None, signals: Beside | None = None
) -> np.ndarray:
    """Covariance of least-squares estimates, J⁺ Σ J⁺ᵀ, whose normal 95 % intervals allow for all spectra together.

    Under one spectrum a coefficient is normal, under all of them it has a mixture of normal distributions. In Σ stands
    the variance of the normal distribution that has the mixture's 95 % interval.
    Parameters with a range (of the bounds) are nowhere less certain than it allows: a combination that the data do not
    see would otherwise spread its endless error over the others.

    Parameters
    ----------
    jacobian : array, shape (N, D)
    spectra : Spectra
    ranges : array, shape (D,), optional
    signals : Beside, optional
        As of the spectra.
    """
    variance = (_reach(np.sqrt(spectra.variance.T), spectra.probability) / NORMAL) ** 2
    if signals is None:
        inverse = _inverse(fourier(jacobian), variance, ranges)
        return np.asarray((inverse * variance) @ inverse.T)
    count = len(jacobian)
    shared = signals.error - np.diag(np.diag(signals.error))  # what errors coefficients share: of zeros and gains
    covariance = signals.weight @ (np.diag(variance[count:]) + shared) @ signals.weight.T
    J = np.vstack([fourier(jacobian), signals.weight @ signals.jacobian])
    inverse = _inverse(J, np.append(variance[:count], np.diag(covariance)), ranges)
    at_inlet, elsewhere = inverse[:, :count], inverse[:, count:]
    return np.asarray((at_inlet * variance[:count]) @ at_inlet.T + elsewhere @ covariance @ elsewhere.T)


def _reach(deviations: np.ndarray, probability: np.ndarray) -> np.ndarray:
    """Return half widths of the 95 % intervals of mixtures of centered normals, (mixture, part), by Newton's method.

    Coverage is a concave function of width and of precision: that of the mean precision lies below, and steps from
    below never pass the solution.
    """
    from scipy.special import ndtr

    matter = probability > _MIN_SPECTRUM_PROBABILITY
    share, precision = probability[matter] / probability[matter].sum(), 1 / np.maximum(deviations[:, matter], 1e-100)
    width, step = NORMAL / (precision @ share), np.inf
    while np.any(step > _WIDTH_TOLERANCE * width):
        z = width[:, np.newaxis] * precision
        density = (np.exp(-0.5 * z**2) * precision) @ share * np.sqrt(2 / np.pi)
        step = (LEVEL + 1 - 2 * ndtr(z) @ share) / density
        width = width + step
    return width


def _inverse(J: np.ndarray, variance: np.ndarray, ranges: np.ndarray | None) -> np.ndarray:
    """Return the pseudo-inverse of J, its gain limited where noise would carry parameters out of their ranges."""
    vectors, singular, right = np.linalg.svd(J, full_matrices=False)
    with np.errstate(divide="ignore"):
        gain = 1 / singular
    if ranges is not None:
        uniform = (right**2) @ (ranges**2 / 12)  # variance along each singular direction if all is possible
        gain = np.minimum(gain, np.sqrt(uniform / (variance @ vectors**2)))
    return (right.T * gain) @ vectors.T


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


def falling_power(harmonic: np.ndarray, corner: float, slope: float) -> np.ndarray:
    """Power (1 + (k/k0)²)^-m of harmonic k: that of a Matérn process on the circle."""
    return (1 + (harmonic / corner) ** 2) ** -slope
