"""The likelihood with its spectrum integrated out, against dense covariances summed node by node."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.pulse.inference import Discrepancy, Drawn
from vasowave.pulse.noise import fourier, harmonics

SAMPLES = 11


OF_MEAN = {"mean free": np.inf, "mean bounded": 0.1, "mean right": 0.0}


@pytest.fixture(params=OF_MEAN)
def noise(request):
    rng = np.random.default_rng(1)
    known, vessels = np.diag(rng.uniform(0.01, 0.1, SAMPLES)), rng.normal(0, 0.2, (SAMPLES, 4))
    return Discrepancy(SAMPLES, (0.3, 0.7), known, vessels, of_mean=OF_MEAN[request.param])


def dense(noise, finer=1, farther=1.0):
    """Return every covariance of the quadrature, its weight and σ, built from the definition."""
    ends = 3.6 * farther, 3.6 * farther, 6.0 * farther
    steps = (np.round(finer * farther * np.array([6, 3, 24]))).astype(int)
    rate, power, score = (g.ravel() for g in np.meshgrid(*map(nodes, ends, steps), indexing="ij"))
    r, s, sigma = 0.5 * np.exp(0.5 * rate), 6.0 * np.exp(0.5 * power), 0.3 * np.exp(0.7 * score)
    k = harmonics(noise.samples)
    shape = (1 + r[:, np.newaxis] * k / s[:, np.newaxis]) ** -s[:, np.newaxis]
    own = sigma[:, np.newaxis] ** 2 * shape / shape.mean(axis=1, keepdims=True)
    own[:, 0] = np.minimum(own[:, 0], noise.samples * noise.of_mean**2)
    weight = np.exp(-0.5 * (rate**2 + power**2 + score**2))
    return own[:, np.newaxis] * np.eye(noise.samples) + noise.measured + noise.vessels @ noise.vessels.T, weight, sigma


def nodes(end, steps):
    return np.linspace(-end, end, 2 * steps + 1)


def density(covariances, residual):
    """Return the normal density of a residual under each covariance."""
    square = (
        residual @ np.linalg.solve(covariances, np.broadcast_to(residual, covariances.shape[:2])[..., None])[..., 0].T
    )
    return np.exp(-0.5 * (square + np.linalg.slogdet(covariances)[1] + len(residual) * np.log(2 * np.pi)))


def test_the_likelihood_is_the_mean_over_all_spectra(noise):
    covariances, weight, _ = dense(noise)
    for residual in np.random.default_rng(2).normal(0, 0.5, (3, SAMPLES)):
        expected = weight @ density(covariances, residual) / weight.sum()
        assert noise.log_likelihood(residual) == pytest.approx(np.log(expected), abs=1e-9)


@pytest.mark.parametrize("power", [lambda k: np.exp(-k), lambda k: (k < 2) + 0.01, lambda k: 1.0 + 0 * k])
@pytest.mark.parametrize("of_mean", [pytest.param(np.inf, marks=pytest.mark.validation), 0.5])
def test_neither_nodes_nor_their_ends_decide_the_likelihood(power, of_mean):
    """Steep, cut off and white: what the prior does not expect, seen with small errors of measurement."""
    samples = 31
    k = harmonics(samples)
    noise = Discrepancy(samples, (0.3, 0.7), 0.03**2 * np.eye(samples), np.zeros((samples, 1)), of_mean=of_mean)
    covariances, weight, _ = dense(noise, 1.5, 1.5)
    variances = np.diagonal(covariances, axis1=1, axis2=2)
    for residual in np.random.default_rng(8).normal(0, 1, (5, samples)) * np.sqrt(power(k)):
        log = -0.5 * (residual**2 / variances + np.log(2 * np.pi * variances)).sum(axis=1)
        expected = np.log(weight / weight.sum() @ np.exp(log - log.max())) + log.max()
        assert noise.log_likelihood(residual) == pytest.approx(expected, abs=0.05)


def test_a_pulse_ten_times_as_high_is_served_the_same():
    rng = np.random.default_rng(9)
    known, vessels, residual = (
        np.diag(rng.uniform(0.01, 0.1, SAMPLES)),
        rng.normal(0, 0.2, (SAMPLES, 4)),
        rng.normal(0, 0.5, SAMPLES),
    )
    small = Discrepancy(SAMPLES, (0.3, 0.7), known, vessels, of_mean=0.1)
    large = Discrepancy(SAMPLES, (3.0, 0.7), 100 * known, 10 * vessels, of_mean=1.0)
    found = large.log_likelihood(10 * residual) + SAMPLES * np.log(10)
    assert found == pytest.approx(small.log_likelihood(residual), abs=1e-9)


def test_the_deviation_is_drawn_from_its_posterior(noise):
    residual = np.random.default_rng(3).normal(0, 0.5, SAMPLES)
    covariances, weight, sigma = dense(noise)
    likely = weight * density(covariances, residual)
    drawn = noise.drawn(np.tile(residual, (4000, 1)), np.zeros(SAMPLES), np.random.default_rng(4)).deviation
    assert drawn.mean() == pytest.approx(likely @ sigma / likely.sum(), abs=4 * drawn.std() / np.sqrt(4000))


@pytest.mark.parametrize(
    "noise",
    [*(pytest.param(one, marks=pytest.mark.validation) for one in ("mean free", "mean right")), "mean bounded"],
    indirect=True,
)
def test_the_zero_and_another_residual_are_drawn_from_their_own_distributions(noise):
    zero = np.eye(SAMPLES)[0] * np.sqrt(0.4 * noise.measured[0, 0])
    residual = np.random.default_rng(3).normal(0, 0.5, SAMPLES)
    covariances, weight, _ = dense(noise)
    likely = weight * density(covariances, residual)
    likely /= likely.sum()
    solved = np.linalg.solve(covariances, np.broadcast_to(zero, (len(likely), SAMPLES))[..., None])[..., 0]
    count = 20_000
    rng, rows = np.random.default_rng(4), np.tile(residual, (count // 10, 1))
    drawn = Drawn(*map(np.concatenate, zip(*[noise.drawn(rows, zero, rng) for _ in range(10)], strict=True)))
    seen = solved @ residual  # of the zero, given one covariance
    expected = likely @ seen
    assert drawn.zero.mean() == pytest.approx(expected, abs=4 / np.sqrt(count))
    left = likely @ (1 - solved @ zero) + likely @ (seen - expected) ** 2
    assert drawn.zero.var() == pytest.approx(left, rel=0.05, abs=0.02)
    of_vessels, inverse = noise.vessels @ noise.vessels.T, np.linalg.inv(covariances)
    of_each = inverse @ residual @ of_vessels  # of the vessels' errors, given one covariance
    middle = likely @ of_each
    assert drawn.vessels.mean(axis=0) == pytest.approx(middle, abs=4 * drawn.vessels.std() / np.sqrt(count))
    remaining = of_vessels - of_vessels @ np.einsum("n,nij->ij", likely, inverse) @ of_vessels
    spread = np.diag(remaining) + likely @ (of_each - middle) ** 2
    assert drawn.vessels.var(axis=0) == pytest.approx(spread, rel=0.05)
    covariance = np.einsum("n,nij->ij", likely, covariances)
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


def test_the_likelihood_of_some_coefficients_is_that_of_their_part_of_every_covariance(noise):
    left_out = harmonics(SAMPLES) == 2
    residual = np.random.default_rng(7).normal(0, 0.5, SAMPLES)
    covariances, weight, _ = dense(noise)
    seen = ~left_out
    expected = weight @ density(covariances[:, seen][:, :, seen], residual[seen]) / weight.sum()
    assert noise.without(left_out).log_likelihood(residual) == pytest.approx(np.log(expected), abs=1e-9)


HARMONICS = 15
REGRESSED = 2 * HARMONICS + 1


def regression(signal, rng, impedance=2.0):
    """Return coefficients of a flow and a pressure with errors, and the likelihood of their residuals."""
    k, own, error = harmonics(REGRESSED), 0.05, 0.3
    flow = signal * np.exp(-0.2 * k) * rng.standard_normal(REGRESSED)
    pressure = impedance * flow + own * rng.standard_normal(REGRESSED)
    seen = flow + error * rng.standard_normal(REGRESSED)
    power = np.bincount(k, seen**2)[k] * impedance**2 * np.where(k > 0, 1.0, 2.0)
    variance = np.full(REGRESSED, (impedance * error) ** 2)
    known = np.diag(variance + own**2)
    noise = Discrepancy(REGRESSED, (1e-4, 0.3), known, np.zeros((REGRESSED, 1)))
    return seen, pressure, noise.beside_flow(variance, power, pressure)


@pytest.mark.validation
@pytest.mark.parametrize("signal", [1.5, 6.0])
def test_noise_of_a_flow_that_enters_draws_no_impedance_down(signal):
    """At the truth the score has the mean zero (maximum likelihood of a regression with errors in both signals)."""
    rng, near = np.random.default_rng(12), np.log(2.0) + 1e-4 * np.array([1.0, -1.0])
    slopes, plain = [], []
    for _ in range(400):
        seen, pressure, noise = regression(signal, rng)
        residuals = pressure - np.exp(near)[:, np.newaxis] * seen
        for one, into in ((noise, slopes), (replace(noise, passed=None), plain)):
            up, down = one.log_likelihood(residuals)
            into.append((up - down) / 2e-4)
    error = np.std(slopes) / np.sqrt(len(slopes))
    assert abs(np.mean(slopes)) < 3 * error
    assert np.mean(plain) == pytest.approx(-REGRESSED, abs=4 * error)  # one for each coefficient


def test_a_residual_counts_beside_the_error_that_its_own_model_passes_on():
    """As in Deming's regression: the square over the sum of the variances of pressure and of impedance times flow."""
    seen, pressure, noise = regression(3.0, np.random.default_rng(13))
    own, error, residuals = 0.05, 0.3, pressure - np.array([[1.0], [2.0], [4.0]]) * seen
    counted = noise.passed.counted(residuals) ** 2 / np.diag(noise.measured)
    expected = residuals**2 / (own**2 + (np.array([[1.0], [2.0], [4.0]]) * error) ** 2)
    np.testing.assert_allclose(counted, expected, rtol=1e-5)


def test_the_slope_of_what_counts_is_that_of_differences():
    _, pressure, noise = regression(3.0, np.random.default_rng(14))
    residual, step = pressure - np.random.default_rng(15).standard_normal(REGRESSED), 1e-6 * np.eye(REGRESSED)
    found = [(noise.passed.counted(residual + one) - noise.passed.counted(residual - one)) / 2e-6 for one in step]
    np.testing.assert_allclose(np.transpose(found), noise.passed.slope(residual), atol=1e-7)
