"""Intervals from the residual of one fit must hold the truth as often as they say."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from vasowave.pulse.noise import (
    Spectra,
    fourier,
    harmonics,
    least_squares_covariance,
    likely_spectra,
    restricted_likelihood,
)

N, PULSE = 256, 15.0


def _jacobian():
    """Return four smooth columns like those of a fit: a level, a slow decay and two shapes of ejection, mmHg."""
    t = np.arange(N) / N
    decay = np.exp(-t / 0.9) - np.mean(np.exp(-t / 0.9))
    pulse = np.exp(-0.5 * ((t - 0.25) / 0.08) ** 2)
    return np.stack([13 + 0 * t, 6 * decay, 8 * (pulse - pulse.mean()), 1.5 * np.gradient(pulse) * N / 20], axis=1)


def _noise(rng, power):
    return fourier(np.eye(N)).T @ (np.sqrt(power(harmonics(N))) * rng.standard_normal(N))


def test_the_coefficients_are_orthonormal():
    F = fourier(np.eye(N))
    np.testing.assert_allclose(F @ F.T, np.eye(N), atol=1e-12)


def test_the_restricted_likelihood_is_that_of_what_no_parameter_can_imitate():
    rng = np.random.default_rng(1)
    k, J, y = harmonics(32), np.linalg.qr(rng.standard_normal((32, 3)))[0], rng.standard_normal(32)
    free = np.linalg.svd(J, full_matrices=True)[0][:, 3:]  # error contrasts: a basis orthogonal to J

    def direct(variance):
        return multivariate_normal(np.zeros(29), free.T @ np.diag(variance) @ free).logpdf(free.T @ y)

    spectra = np.array([2 * (1 + (k / 3) ** 2) ** -2.0, 0.5 * (1 + (k / 6) ** 2) ** -1.2])
    one, other = restricted_likelihood(spectra, y, J)
    assert one - other == pytest.approx(direct(spectra[0]) - direct(spectra[1]))


def test_the_interval_of_a_mixture_is_the_one_that_draws_of_it_show():
    rng = np.random.default_rng(5)
    J = np.linalg.qr(rng.standard_normal((32, 2)))[0]
    variance = np.stack([np.full(32, 0.1), np.full(32, 1.0), np.full(32, 25.0)])
    share = np.array([0.5, 0.4, 0.1])
    errors = np.sqrt(np.diag(least_squares_covariance(J, Spectra(variance, share, False))))
    drawn = rng.standard_normal(200_000) * np.sqrt(variance[rng.choice(3, 200_000, p=share), 0])
    assert 1.959964 * errors == pytest.approx([np.quantile(np.abs(drawn), 0.95)] * 2, rel=0.02)


@pytest.mark.validation
@pytest.mark.parametrize(
    ("power", "fewest"),
    [
        # Of 60 intervals 52 or fewer hold the truth in one of 90 times if 95 % do.
        pytest.param(lambda k: 12 * (1 + k / 12) ** -6.0, 53, id="of the family that is considered"),
        pytest.param(lambda k: 12 * np.exp(-k / 2), 53, id="of a family near it"),
        # Flat below a corner: harmonics 2 to 4 hold more than any spectrum of the family that falls as steeply later.
        pytest.param(lambda k: 12 * (1 + (k / 3) ** 2) ** -2.5, 45, id="of a family unlike it"),
    ],
)
def test_ninety_five_percent_intervals_hold_the_truth_as_often_as_they_say(power, fewest):
    rng = np.random.default_rng(2)
    J = _jacobian()
    held, naive = [], []
    for _ in range(60):
        e = _noise(rng, lambda k: power(k) + 1e-4)
        error = np.linalg.lstsq(J, e, rcond=None)[0]
        residual = e - J @ error
        matrix = least_squares_covariance(J, likely_spectra(residual, J, PULSE))
        held.append(np.abs(error) < 1.96 * np.sqrt(np.diag(matrix)))
        white = residual @ residual / (N - 4) * np.linalg.inv(J.T @ J)
        naive.append(np.abs(error) < 1.96 * np.sqrt(np.diag(white)))
    assert np.sum(held, axis=0).min() >= fewest
    assert np.sum(naive) < 0.75 * 60 * 4, "independent noise would give far too narrow intervals"


def test_intervals_do_not_shrink_because_the_same_cycle_is_sampled_more_finely():
    rng = np.random.default_rng(3)
    J = _jacobian()
    e = _noise(rng, lambda k: np.exp(-k / 2) * (k < 40))
    coarse = e - J @ np.linalg.lstsq(J, e, rcond=None)[0]
    errors = []
    for step in (1, 2):
        matrix = least_squares_covariance(J[::step], likely_spectra(coarse[::step], J[::step], PULSE))
        errors.append(np.sqrt(np.diag(matrix)))
    np.testing.assert_allclose(errors[0], errors[1], rtol=0.02)


def test_a_combination_that_the_data_do_not_see_is_as_uncertain_as_the_bounds_and_leaves_the_others_alone():
    rng = np.random.default_rng(4)
    J = _jacobian()
    e = _noise(rng, lambda k: (1 + (k / 3) ** 2) ** -2.5)
    residual = e - J @ np.linalg.lstsq(J, e, rcond=None)[0]
    spectra = likely_spectra(residual, J, PULSE)
    alone = least_squares_covariance(J, spectra)
    blind = np.column_stack([J, J[:, 3] + 1e-7 * J[:, 0]])  # a fifth parameter that does what the fourth does
    ranges = np.full(5, 4.0)
    free = least_squares_covariance(blind, spectra)
    held = least_squares_covariance(blind, spectra, ranges)
    assert free[0, 0] > 100 * alone[0, 0]
    assert held[0, 0] == pytest.approx(alone[0, 0], rel=1e-3)
    difference = np.array([0, 0, 0, 1, -1]) / np.sqrt(2)
    assert difference @ held @ difference == pytest.approx(4.0**2 / 12, rel=1e-3)


def test_where_a_fit_leaves_little_to_see_the_size_of_the_noise_is_said_to_be_assumed():
    rng = np.random.default_rng(6)
    k = harmonics(17)
    few = np.column_stack([fourier(np.eye(17)).T[:, k <= 4], rng.standard_normal(17)])  # harmonics 0 to 4 are imitated
    e = fourier(np.eye(17)).T @ (np.exp(-k / 2) * rng.standard_normal(17))
    residual = e - few @ np.linalg.lstsq(few, e, rcond=None)[0]
    assert likely_spectra(residual, few, PULSE).assumed
    e = _noise(rng, lambda k: np.exp(-k / 2) + 1e-4)
    J = _jacobian()
    assert not likely_spectra(e - J @ np.linalg.lstsq(J, e, rcond=None)[0], J, PULSE).assumed


def test_a_pulse_ten_times_as_high_has_the_same_intervals():
    rng, J = np.random.default_rng(7), _jacobian()
    e = _noise(rng, lambda k: np.exp(-k / 2) + 1e-4)
    residual = e - J @ np.linalg.lstsq(J, e, rcond=None)[0]
    mouse, pig = (least_squares_covariance(f * J, likely_spectra(f * residual, f * J, f * PULSE)) for f in (1, 10))
    np.testing.assert_allclose(mouse, pig, rtol=1e-6)
