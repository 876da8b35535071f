"""Noise models against dense matrices at unsymmetrical sizes, and what is refused."""

import numpy as np
import pytest
from scipy import stats
from scipy.linalg import toeplitz

from vasowave.base import InputError, NumericalError
from vasowave.pulse.noise import (
    FAMILIES,
    Beside,
    CirculantNoise,
    DenseNoise,
    Independent,
    PeriodicStationary,
    Spectra,
    fit_noise,
    fourier,
    least_squares_covariance,
    log_likelihood,
    maximize,
    regularize,
    whiten,
)

RNG = np.random.default_rng(11)


def test_the_covariance_of_least_squares_carries_the_noise_through_the_inverse():
    count = 7
    J = RNG.normal(size=(count, 2))
    variance = RNG.uniform(0.5, 2.0, count)
    one = Spectra(variance[np.newaxis], np.ones(1), False)
    inverse = np.linalg.pinv(fourier(J))
    assert least_squares_covariance(J, one) == pytest.approx(inverse @ np.diag(variance) @ inverse.T, rel=1e-6)
    error = np.array([[0.4, 0.1], [0.1, 0.9]])
    weight = np.array([[0.8, -0.1], [-0.1, 0.5]])
    beside = Beside(np.array([0, -1]), np.zeros(2), RNG.normal(size=(2, 2)), weight, error)
    whole = Spectra(np.append(variance, [0.7, 1.3])[np.newaxis], np.ones(1), False)
    there = weight @ np.array([[0.7, 0.1], [0.1, 1.3]]) @ weight.T
    inverse = np.linalg.pinv(np.vstack([fourier(J), weight @ beside.jacobian]))
    noise = np.zeros((count + 2, count + 2))
    noise[:count, :count], noise[count:, count:] = np.diag(variance), there
    assert least_squares_covariance(J, whole, None, beside) == pytest.approx(inverse @ noise @ inverse.T, rel=1e-6)


@pytest.mark.parametrize(
    ("sigma", "words"),
    [
        (np.ones((2, 3)), r"has shape \(2, 3\)"),
        (np.array([[1.0, np.nan], [np.nan, 1.0]]), "not finite"),
        (np.zeros((2, 2)), "no variance"),
        (np.array([[1.0, 0.2], [0.1, 1.0]]), "not symmetric"),
    ],
)
def test_what_is_no_covariance_is_refused(sigma, words):
    with pytest.raises(InputError, match=words):
        regularize(sigma)


@pytest.mark.parametrize("count", [5, 6])
def test_circulant_noise_is_its_dense_matrix(count):
    noise = PeriodicStationary().noise(count, np.array([1.5, 1.0, 0.2]))
    values = RNG.normal(size=(count, 3))
    sigma = noise.covariance
    assert noise.log_determinant == pytest.approx(np.linalg.slogdet(sigma)[1])
    for column, white in zip(values.T, noise.whiten(values).T, strict=True):
        assert white @ white == pytest.approx(column @ np.linalg.solve(sigma, column))
        assert noise.log_likelihood(column) == pytest.approx(
            stats.multivariate_normal(np.zeros(count), sigma).logpdf(column)
        )
    with pytest.raises(InputError, match=f"4 residuals, but the noise model was fitted to {count}"):
        noise.whiten(np.ones(4))
    assert Independent().noise(count, np.zeros(0)).covariance == pytest.approx(np.eye(count))


def test_dense_noise_is_whitened_by_its_root():
    sigma = toeplitz([2.0, 0.9, 0.3, 0.1])
    noise, values = DenseNoise(sigma, 0.0, {}), RNG.normal(size=4)
    expected = stats.multivariate_normal(np.zeros(4), sigma).logpdf(values)
    assert noise.log_likelihood(values) == pytest.approx(expected)
    assert log_likelihood(values, sigma) == pytest.approx(expected)
    white = noise.whiten(values)
    assert white @ white == pytest.approx(values @ np.linalg.solve(sigma, values))
    with pytest.raises(NumericalError, match="not positive definite"):
        whiten(values, -sigma)


def test_independent_noise_has_the_mean_square_of_its_residuals_and_zeros_have_no_optimum():
    noise = fit_noise("independent", np.full((2, 5), 3.0), 0.1, rng=np.random.default_rng(0))
    assert isinstance(noise, CirculantNoise)
    assert noise.power == pytest.approx([9.0, 9.0, 9.0])
    assert noise.hyperparameters == pytest.approx({"amplitude [mmHg2]": 9.0})
    with np.errstate(all="ignore"), pytest.raises(NumericalError, match="no optimum of the likelihood from 4 starts"):
        maximize(FAMILIES["independent"], np.zeros((1, 16)), np.random.default_rng(0))
