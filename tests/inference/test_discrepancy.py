"""The likelihood with its spectrum integrated out, against dense covariances summed node by node."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from vasowave.inference.discrepancy import Discrepancy
from vasowave.noise.spectrum import fourier, harmonics

SAMPLES = 11


@pytest.fixture(params=[np.inf, 0.1, 0.0], ids=["mean free", "mean bounded", "mean right"])
def noise(request):
    rng = np.random.default_rng(1)
    known, vessels = np.diag(rng.uniform(0.01, 0.1, SAMPLES)), rng.normal(0, 0.2, (SAMPLES, 4))
    return Discrepancy(SAMPLES, (0.3, 0.7), known, vessels, of_mean=request.param)


def dense(noise):
    """Every covariance of the quadrature, with its weight, built from the definition."""
    other = noise.measured + noise.vessels @ noise.vessels.T
    for corner in (-1.5, -0.75, 0.0, 0.75, 1.5):
        for slope in (-1.2, 0.0, 1.2):
            r, s = 0.5 * np.exp(0.5 * corner), 6.0 * np.exp(0.5 * slope)
            power = (1 + r * harmonics(SAMPLES) / s) ** -s
            for score in np.linspace(-2.5, 2.5, 21):
                sigma = 0.3 * np.exp(0.7 * score)
                weight = np.exp(-0.5 * (corner**2 + slope**2 + score**2))
                own = sigma**2 * power / power.mean()
                own[0] = min(own[0], SAMPLES * noise.of_mean**2)
                yield np.diag(own) + other, weight, sigma


def test_the_likelihood_is_the_mean_over_all_spectra(noise):
    residuals = np.random.default_rng(2).normal(0, 0.5, (3, SAMPLES))
    nodes = list(dense(noise))
    total = sum(weight for _, weight, _ in nodes)
    expected = sum(w / total * multivariate_normal(cov=S).pdf(residuals) for S, w, _ in nodes)
    assert noise.log_likelihood(residuals) == pytest.approx(np.log(expected), abs=1e-9)


def test_the_deviation_is_drawn_from_its_posterior(noise):
    residual = np.random.default_rng(3).normal(0, 0.5, SAMPLES)
    likely = [(w * multivariate_normal(cov=S).pdf(residual), sigma) for S, w, sigma in dense(noise)]
    expected = sum(p * sigma for p, sigma in likely) / sum(p for p, _ in likely)
    drawn = noise.drawn(np.tile(residual, (4000, 1)), np.zeros(SAMPLES), np.random.default_rng(4)).deviation
    assert drawn.mean() == pytest.approx(expected, abs=4 * drawn.std() / np.sqrt(4000))


def test_the_zero_and_another_residual_are_drawn_from_their_own_distributions(noise):
    zero = np.eye(SAMPLES)[0] * np.sqrt(0.4 * noise.measured[0, 0])
    residual = np.random.default_rng(3).normal(0, 0.5, SAMPLES)
    likely = [(w * multivariate_normal(cov=S).pdf(residual), S) for S, w, _ in dense(noise)]
    whole = sum(p for p, _ in likely)
    expected = sum(p * zero @ np.linalg.solve(S, residual) for p, S in likely) / whole
    left = sum(p * (1 - zero @ np.linalg.solve(S, zero)) for p, S in likely) / whole
    count = 20_000
    drawn = noise.drawn(np.tile(residual, (count, 1)), zero, np.random.default_rng(4))
    assert drawn.zero.mean() == pytest.approx(expected, abs=4 / np.sqrt(count))
    assert drawn.zero.var() == pytest.approx(left, rel=0.05, abs=0.02)
    covariance = sum(p * S for p, S in likely) / whole
    scale = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(
        np.cov(drawn.noise.T) / np.outer(scale, scale), covariance / np.outer(scale, scale), atol=0.06
    )  # six standard errors of a correlation, with the tails of a mixture


def test_the_deviation_is_that_of_the_cycle():
    noise = Discrepancy(201, (0.4, 0.0), 1e-12 * np.eye(201), np.zeros((201, 1)))
    variance = noise.variance(np.zeros((1, 201)))
    wave = np.random.default_rng(5).normal(0, 1, (201, 5000)) * np.sqrt(variance)[:, np.newaxis]
    assert np.mean(wave**2) == pytest.approx(0.16, rel=0.05)  # orthonormal: mean square of coefficients and samples
    assert np.mean(fourier(np.ones(201)) ** 2) == pytest.approx(1.0)


def test_strong_noise_makes_the_likelihood_flat():
    noise = Discrepancy(SAMPLES, (0.3, 0.7), 1e8 * np.eye(SAMPLES), np.zeros((SAMPLES, 1)))
    found = noise.log_likelihood(np.random.default_rng(6).normal(0, 5, (20, SAMPLES)))
    assert np.ptp(found) < 1e-4


def test_the_likelihood_of_some_coefficients_is_that_of_their_part_of_every_covariance(noise):
    left_out = harmonics(SAMPLES) == 2
    residual = np.random.default_rng(7).normal(0, 0.5, SAMPLES)
    nodes = list(dense(noise))
    total = sum(weight for _, weight, _ in nodes)
    seen = ~left_out
    expected = sum(w / total * multivariate_normal(cov=S[seen][:, seen]).pdf(residual[seen]) for S, w, _ in nodes)
    assert noise.without(left_out).log_likelihood(residual) == pytest.approx(np.log(expected), abs=1e-9)
