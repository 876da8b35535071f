"""What the residual of a fit says about the noise: the spectra that may lie behind it, each with its probability.

A measured cycle closes, so its noise is stationary and periodic: its Fourier coefficients are independent, with a
variance that falls with the harmonic. A fit removes from the residual what its parameters can imitate, above all at
low harmonics; the restricted likelihood allows for that. What a residual leaves open of the spectrum is integrated out.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vasowave.descriptions import LEVEL, NORMAL

HARMONICS = 20
"""Harmonics by which spectra are judged: those that the averaged cycle of a mouse carries."""

RATE = np.log(0.5), 0.5
"""Mean and SD of log r: power falls to 1/e over two harmonics, as that of the residual of measured mouse C6."""

POWER = np.log(6.0), 0.5
"""Mean and SD of log s."""

SIZE = 0.7
"""SD of the prior of log σ above its median: at most four times larger. Below, all sizes are alike."""

# Nodes in SD. Ends of 5 SD for r in place of 3.5 move no interval of mouse C6 by 2 %.
_RATES, _POWERS, _SIZES = np.linspace(-3.5, 3.5, 15), np.linspace(-2.0, 2.0, 5), np.linspace(-5.0, 3.0, 33)
_LOOSE = 0.5  # SD of log σ, in that of its prior, above which the prior counts as what decides
_EXACT = 1e-9  # mmHg: no residual is smaller
_HALVINGS = 40  # of an interval around the likeliest size, to rounding
_MATTERS = 1e-6  # probability of a spectrum below which it is left out


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


def spectral_shapes(
    harmonic: np.ndarray, rates: Sequence[float] | np.ndarray, powers: Sequence[float] | np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return variances (1 + rk/s)^-s of harmonics k, up to a factor that makes their mean 1, and log prior weights.

    The power falls with the harmonic by the rate r at first and as k^-s at last. It rises to the very mean: parameters
    take the lowest harmonics from every residual, so that a spectrum which became flat there would promise what no
    residual can show.

    Parameters
    ----------
    harmonic : array, shape (coefficient,)
    rates, powers : sequence of float
        Nodes of log r and log s, in SD of their normal priors.

    Returns
    -------
    shapes : array, shape (rate · power, coefficient)
    log_weight : array, shape (rate · power,)
        Adding up to 1.
    """
    rate, last = np.asarray(rates), np.asarray(powers)
    r, s = np.exp(RATE[0] + RATE[1] * rate), np.exp(POWER[0] + POWER[1] * last)
    shapes = np.array([(1 + one * harmonic / other) ** -other for one in r for other in s])
    return shapes / shapes.mean(axis=1, keepdims=True), log_normal(np.add.outer(rate**2, last**2).ravel())


def log_normal(square: np.ndarray) -> np.ndarray:
    """Return log weights, adding up to 1, of nodes at these squared distances (in SD) from the center."""
    return np.asarray(-0.5 * square - np.log(np.exp(-0.5 * square).sum()))


def likely_spectra(
    residual: np.ndarray, jacobian: np.ndarray, known: np.ndarray | float = 0.0, of_mean: float = np.inf
) -> Spectra:
    """Return the spectra that may lie behind the residual of a least-squares fit.

    Their shapes have the prior of `spectral_shapes`. Their standard deviation σ in the cycle is before expected to be
    that of the residual, made up for what a fit takes from noise of the usual shape. Any smaller one is as likely, for
    the error of the measurement may explain all; larger ones have the log-normal spread of the posterior's prior of a
    discrepancy. Without it a steep spectrum could hide an error of the mean pressure many times larger than anything
    that the residual shows.

    Parameters
    ----------
    residual : array, shape (N,)
        Measured minus simulated pressure over one period, mmHg.
    jacobian : array, shape (N, D)
        Its derivative by the parameters at the optimum.
    known : array, shape (N,), optional
        Variance of the coefficients by the error of the measurement, see `known_variance`.
    of_mean : float
        Largest standard deviation that the mean of the discrepancy can have, mmHg.
    """
    k, y = harmonics(len(residual)), fourier(residual)
    shapes, log_prior = spectral_shapes(k, _RATES, _POWERS)
    basis = np.linalg.qr(fourier(jacobian))[0]  # of what the parameters can imitate
    sigma = max(float(np.sqrt(np.mean(y**2))), _EXACT) * _usual_ratio(k, basis) * np.exp(SIZE * _SIZES)
    most = np.where(k == 0, len(k) * of_mean**2, np.inf)
    variance = (np.minimum(sigma[:, np.newaxis] ** 2 * shapes[:, np.newaxis], most) + known).reshape(-1, len(k))
    kept = k <= HARMONICS
    log = np.add.outer(log_prior, log_normal(np.maximum(_SIZES, 0.0) ** 2)).ravel()
    log += restricted_likelihood(variance[:, kept], y[kept], basis[kept])
    probability = np.exp(log - log.max())
    probability /= probability.sum()
    size = probability.reshape(-1, len(sigma)).sum(axis=0)
    loose = np.sqrt(size @ _SIZES**2 - (size @ _SIZES) ** 2) > _LOOSE
    return Spectra(variance, probability, bool(loose))


def _usual_ratio(harmonic: np.ndarray, basis: np.ndarray) -> float:
    """Return the standard deviation of noise of the usual shape over that of what a fit leaves of it."""
    usual = spectral_shapes(harmonic, [0.0], [0.0])[0][0]
    left = usual.sum() - np.sum(usual @ basis**2)
    return float(np.sqrt(usual.sum() / left))


def restricted_likelihood(variance: np.ndarray, y: np.ndarray, J: np.ndarray) -> np.ndarray:
    """Return the log-likelihood of what the parameters could not take from a residual, up to a constant.

    Parameters
    ----------
    variance : array, shape (spectrum, coefficient)
    y : array, shape (coefficient,)
        Coefficients of the residual.
    J : array, shape (coefficient, D)
    """
    basis = np.linalg.qr(J)[0]  # any basis of what the parameters can imitate serves
    information = np.einsum("nk,ki,kj->nij", 1 / variance, basis, basis, optimize=True)
    seen = (y / variance) @ basis
    taken = np.einsum("ni,ni->n", seen, np.linalg.solve(information, seen[:, :, np.newaxis])[:, :, 0])
    return -0.5 * (np.log(variance).sum(axis=1) + np.linalg.slogdet(information)[1] + (1 / variance) @ y**2 - taken)


def least_squares_covariance(jacobian: np.ndarray, spectra: Spectra, ranges: np.ndarray | None = None) -> np.ndarray:
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
    """
    variance = (_reach(np.sqrt(spectra.variance.T), spectra.probability) / NORMAL) ** 2
    inverse = _inverse(fourier(jacobian), variance, ranges)
    return np.asarray((inverse * variance) @ inverse.T)


def _reach(deviations: np.ndarray, probability: np.ndarray) -> np.ndarray:
    """Return half widths of the 95 % intervals of mixtures of centered normals, (mixture, part), by bisection."""
    from scipy.special import ndtr

    matter = probability > _MATTERS
    share, parts = probability[matter] / probability[matter].sum(), np.maximum(deviations[:, matter], 1e-300)
    low, high = np.zeros(len(parts)), 10 * parts.max(axis=1)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        short = ndtr(middle[:, np.newaxis] / parts) @ share < 0.5 + 0.5 * LEVEL
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    return high


def _inverse(J: np.ndarray, variance: np.ndarray, ranges: np.ndarray | None) -> np.ndarray:
    """Return the pseudo-inverse of J, its gain limited where noise would carry parameters out of their ranges."""
    left, singular, right = np.linalg.svd(J, full_matrices=False)
    with np.errstate(divide="ignore"):
        gain = 1 / singular
    if ranges is not None:
        uniform = (right**2) @ (ranges**2 / 12)  # variance along each singular direction if all is possible
        gain = np.minimum(gain, np.sqrt(uniform / (variance @ left**2)))
    return (right.T * gain) @ left.T


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
