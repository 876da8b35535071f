"""Spectra, kernels and covariances of noise against arithmetic by hand and dense matrices, at unsymmetrical sizes."""

import numpy as np
import pytest
from scipy import stats
from scipy.linalg import toeplitz

from vasowave.errors import InputError, NumericalError
from vasowave.noise import spectrum
from vasowave.noise.arma import Arma, _burg, _coefficients, _grown, _orders, autocovariance, fit_arma
from vasowave.noise.arma import concentrated as concentrated_arma
from vasowave.noise.fitting import fit_noise
from vasowave.noise.likelihood import (
    FAMILIES,
    KERNELS,
    Independent,
    PeriodicStationary,
    concentrated,
    maximize,
    named,
    regularize,
    smallest_weight,
)
from vasowave.noise.models import CirculantNoise, DenseNoise, log_likelihood, whiten
from vasowave.noise.spectrum import (
    Beside,
    Spectra,
    falling_power,
    fourier,
    harmonics,
    known_variance,
    least_squares_covariance,
    likely_spectra,
    restricted_likelihood,
    spectral_shapes,
    spectral_sizes,
    with_points,
)

RNG = np.random.default_rng(11)


def test_harmonics_stand_in_the_order_of_cosines_then_sines():
    assert harmonics(1).tolist() == [0]
    assert harmonics(5).tolist() == [0, 1, 2, 1, 2]
    assert harmonics(6).tolist() == [0, 1, 2, 3, 1, 2]


@pytest.mark.parametrize("count", [1, 2, 5, 6])
def test_the_real_fourier_basis_is_orthonormal_cosines_and_sines(count):
    rows = []
    t = 2 * np.pi * np.arange(count) / count
    for place, k in enumerate(harmonics(count)):
        plain = k in (0, count / 2)
        wave = np.cos(k * t) if place <= count // 2 else np.sin(k * t)
        rows.append(wave / np.sqrt(count if plain else count / 2))
    values = RNG.normal(size=(count, 3))
    assert fourier(values) == pytest.approx(np.array(rows) @ values)
    assert fourier(values[:, 0]) == pytest.approx(np.array(rows) @ values[:, 0])


def test_the_power_of_an_error_is_shared_by_the_places_of_its_harmonic():
    assert known_variance(np.array([1.0, 2, 3, 4]), 6) == pytest.approx(6 * np.array([1, 1, 1.5, 4, 1, 1.5]))
    assert known_variance(np.array([1.0, 2, 3]), 5) == pytest.approx(5 * np.array([1, 1, 1.5, 1, 1.5]))


def test_spectra_fall_in_thirteen_rates_and_seven_powers_of_mean_one():
    k = harmonics(7)
    shapes, log = spectral_shapes(k)
    assert shapes.shape == (91, 7)
    assert shapes.mean(axis=1) == pytest.approx(np.ones(91))
    for row, (rate, power) in {
        45: (0.0, 0.0),
        0: (-3.6, -3.6),
        90: (3.6, 3.6),
        6: (-3.6, 3.6),
        7: (-3.0, -3.6),
    }.items():
        r, s = 0.5 * np.exp(0.5 * rate), 6.0 * np.exp(0.5 * power)
        own = (1 + r * k / s) ** (-s)
        assert shapes[row] == pytest.approx(own / own.mean())
        assert log[45] - log[row] == pytest.approx(0.5 * (rate**2 + power**2))
    assert np.exp(log).sum() == pytest.approx(1.0)
    assert with_points(shapes, np.array([-1, 0, 3]))[2] == pytest.approx([1.0, shapes[2, 0], shapes[2, 3]])


@pytest.mark.parametrize(("spread", "count"), [(0.7, 49), (0.1, 49), (0.71, 51), (1.4, 97)])
def test_sizes_are_log_normal_to_six_deviations_in_steps_that_are_fine_enough(spread, count):
    sizes, log = spectral_sizes(0.3, spread)
    assert len(sizes) == count
    assert sizes[[0, count // 2, -1]] == pytest.approx(0.3 * np.exp(spread * np.array([-6, 0, 6])))
    assert np.exp(log).sum() == pytest.approx(1.0)
    assert log[count // 2] - log[0] == pytest.approx(18.0)


def test_a_size_without_spread_is_its_median():
    sizes, log = spectral_sizes(0.3, 0.0)
    assert (sizes.tolist(), log.tolist()) == ([0.3], [0.0])


def test_the_restricted_likelihood_is_that_of_dense_matrices():
    y, J = RNG.normal(size=7), RNG.normal(size=(7, 2)) * [1.0, 30.0]
    variance = RNG.uniform(0.5, 3.0, size=(4, 7))
    basis = np.linalg.qr(J)[0]
    for row, got in zip(variance, restricted_likelihood(variance, y, J), strict=True):
        inverse = np.diag(1 / row)
        inner = basis.T @ inverse @ basis
        projected = inverse - inverse @ basis @ np.linalg.inv(inner) @ basis.T @ inverse
        expected = -0.5 * (np.log(row).sum() + np.log(np.linalg.det(inner)) + y @ projected @ y)
        assert got == pytest.approx(expected)


def test_the_spectra_of_a_residual_have_the_probabilities_of_their_densities_and_a_mean_that_is_limited():
    count, pulse = 41, 12.0
    y, J = RNG.normal(size=count), RNG.normal(size=(count, 2))
    found = likely_spectra(y, J, pulse, 0.25, 0.2)
    k = harmonics(count)
    shapes, of_shape = spectral_shapes(k)
    sizes, of_size = spectral_sizes(0.03 * pulse, 0.7)
    variance = sizes[:, np.newaxis] ** 2 * shapes[:, np.newaxis]
    variance[:, :, 0] = np.minimum(variance[:, :, 0], count * 0.2**2)
    variance = variance.reshape(-1, count) + 0.25
    assert found.variance == pytest.approx(variance)
    kept = k <= 20
    basis = np.linalg.qr(fourier(J))[0]
    log = np.add.outer(of_shape, of_size).ravel()
    log = log + restricted_likelihood(variance[:, kept], fourier(y)[kept], basis[kept])
    probability = np.exp(log - log.max())
    assert found.probability == pytest.approx(probability / probability.sum())
    wide = likely_spectra(np.append(y, y), np.vstack([J, J]), pulse, 0.25)  # 82 samples: 41 harmonics, 20 of them used
    assert wide.variance.shape == (91 * 49, 82)
    assert wide.probability.sum() == pytest.approx(1.0)
    by_size = found.probability.reshape(91, 49).sum(axis=0)
    score = np.linspace(-6, 6, 49) + np.log(0.03 * pulse) / 0.7
    assert found.assumed == bool(np.sqrt(by_size @ score**2 - (by_size @ score) ** 2) > 0.5)


def test_places_beside_the_inlet_join_the_likelihood_with_their_own_errors():
    count = 9
    y, J = RNG.normal(size=count), RNG.normal(size=(count, 2))
    beside = Beside(
        np.array([0, 2, -1]), RNG.normal(size=3), RNG.normal(size=(3, 2)), np.eye(3), np.diag([0.1, 0.2, 0.3])
    )
    found = likely_spectra(y, J, 10.0, 0.0, np.inf, beside)
    k = harmonics(count)
    shapes, of_shape = spectral_shapes(k)
    sizes, of_size = spectral_sizes(0.3, 0.7)
    at_points = np.column_stack([shapes[:, 0], shapes[:, 2], np.ones(91)])
    both = np.hstack([shapes, at_points])[:, np.newaxis]
    variance = (sizes[:, np.newaxis] ** 2 * both).reshape(-1, count + 3)
    variance[:, count:] += [0.1, 0.2, 0.3]
    assert found.variance == pytest.approx(variance)
    basis = np.linalg.qr(np.vstack([fourier(J), beside.jacobian]))[0]
    log = np.add.outer(of_shape, of_size).ravel()
    log = log + restricted_likelihood(variance, np.append(fourier(y), beside.residual), basis)
    probability = np.exp(log - log.max())
    assert found.probability == pytest.approx(probability / probability.sum())


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


def test_what_the_data_do_not_see_is_as_wide_as_a_uniform_prior():
    J = np.column_stack([np.ones(5), np.zeros(5)])
    one = Spectra(np.ones((1, 5)), np.ones(1), False)
    ranges = np.array([4.0, 6.0])
    found = least_squares_covariance(J, one, ranges)
    assert found == pytest.approx(np.diag([1 / 5, 36 / 12]), rel=1e-6)
    narrow = least_squares_covariance(J, one, np.array([0.6, 6.0]))
    assert narrow[0, 0] == pytest.approx(0.36 / 12, rel=1e-6)


def test_half_an_interval_of_a_mixture_holds_95_per_cent_of_it():
    sd, share = np.array([[0.5, 1.0, 4.0], [2.0, 2.0, 2.0]]), np.array([0.5, 0.3, 0.2])
    reach = spectrum._reach(sd, share)
    for row, one in zip(sd, reach, strict=True):
        assert (2 * stats.norm.cdf(one / row) - 1) @ share == pytest.approx(0.95, abs=1e-9)
    assert reach[1] == pytest.approx(2 * 1.959964, rel=1e-6)
    rare = spectrum._reach(np.array([[1.0, 1e6]]), np.array([1 - 5e-7, 5e-7]))
    assert rare[0] == pytest.approx(1.959964, rel=1e-6)
    counted = spectrum._reach(np.array([[1.0, 1e6]]), np.array([0.94, 0.06]))
    assert counted[0] > 1e5


def test_a_falling_power_is_half_at_the_corner_of_slope_one():
    assert falling_power(np.array([0.0, 3.0, 6.0]), 3.0, 1.0) == pytest.approx([1.0, 0.5, 0.2])
    assert falling_power(np.array([6.0]), 3.0, 2.0) == pytest.approx([0.04])


def test_the_weight_that_is_needed_leads_to_the_condition_that_is_asked():
    low, high, variance, most = 0.001, 80.0, 2.0, 500.0
    weight = smallest_weight(low, high, variance, most)
    ends = [(1 - weight) * one + weight * variance for one in (low, high)]
    assert ends[1] / ends[0] == pytest.approx(most)
    assert smallest_weight(1.0, 500.0, 2.0, 500.0) == 0.0
    assert smallest_weight(0.999, 500.0, 2.0, 500.0) > 0


@pytest.mark.parametrize(
    ("sigma", "words"),
    [
        (np.ones(3), r"has shape \(3,\)"),
        (np.ones((2, 3)), r"has shape \(2, 3\)"),
        (np.array([[1.0, np.nan], [np.nan, 1.0]]), "not finite"),
        (np.zeros((2, 2)), "no variance"),
        (np.array([[1.0, 0.2], [0.1, 1.0]]), "not symmetric"),
    ],
)
def test_what_is_no_covariance_is_refused(sigma, words):
    with pytest.raises(InputError, match=words):
        regularize(sigma)


@pytest.mark.parametrize("count", [8, 9])
@pytest.mark.parametrize("name", list(KERNELS))
def test_kernels_hold_their_condition_and_their_eigenvalues_are_those_of_the_whole_matrix(name, count):
    kernel = KERNELS[name]
    theta = [float(np.sqrt(low * high)) for _, low, high, _ in kernel.hyperparameters]
    K = kernel.matrix(np.arange(count) / count, *theta)
    assert np.sort(kernel._eigenvalues(K)) == pytest.approx(np.linalg.eigvalsh(K), abs=1e-12)
    noise = kernel.noise(count, np.array(theta))
    mean = np.trace(K) / count
    assert noise.covariance == pytest.approx((1 - noise.weight) * K + noise.weight * mean * np.eye(count))
    assert np.linalg.cond(noise.covariance) <= 1e4 * (1 + 1e-6)


def test_kernels_of_given_lengths_have_the_values_of_their_formulas():
    t = np.array([0.0, 0.2, 0.7])
    assert KERNELS["squared exponential"].matrix(t, 0.5)[0] == pytest.approx(np.exp(-0.5 * (t / 0.5) ** 2))
    s = np.sqrt(3) * t / 0.5
    assert KERNELS["Matern 3/2"].matrix(t, 0.5)[0] == pytest.approx((1 + s) * np.exp(-s))
    s = np.sqrt(5) * t / 0.5
    assert KERNELS["Matern 5/2"].matrix(t, 0.5)[0] == pytest.approx((1 + s + s * s / 3) * np.exp(-s))
    assert KERNELS["periodic"].matrix(t, 0.5)[0] == pytest.approx(np.exp(-2 * (np.sin(np.pi * t) / 0.5) ** 2))
    a, b = 0.3, 2.0
    inner = [[a * a + b * b * x * y for y in t] for x in t]
    expected = 2 / np.pi * np.arcsin(2 * inner[1][2] / np.sqrt((1 + 2 * inner[1][1]) * (1 + 2 * inner[2][2])))
    assert KERNELS["neural network"].matrix(t, a, b)[1, 2] == pytest.approx(expected)


def test_hyperparameters_are_named_in_seconds_of_the_period():
    assert named(KERNELS["Matern 3/2"], np.array([0.5]), 0.1, 3.0) == pytest.approx(
        {"amplitude [mmHg2]": 3.0, "length [s]": 0.05}
    )
    assert named(KERNELS["neural network"], np.array([0.5, 2.0]), 0.1, 3.0) == pytest.approx(
        {"amplitude [mmHg2]": 3.0, "offset": 0.5, "slope [1/s]": 20.0}
    )
    assert named(FAMILIES["circulant"], np.array([2.0, 3, 0.1]), 0.1, 1.0)["corner harmonic"] == 2.0


@pytest.mark.parametrize("count", [5, 6])
def test_circulant_noise_is_its_dense_matrix(count):
    noise = PeriodicStationary().noise(count, np.array([1.5, 1.0, 0.2]))
    assert noise.power == pytest.approx(falling_power(np.arange(count // 2 + 1), 1.5, 1.0) + 0.2)
    values = RNG.normal(size=(count, 3))
    sigma = noise.covariance
    assert noise.log_determinant == pytest.approx(np.linalg.slogdet(sigma)[1])
    for column, white in zip(values.T, noise.whiten(values).T, strict=True):
        assert white @ white == pytest.approx(column @ np.linalg.solve(sigma, column))
        assert noise.log_likelihood(column) == pytest.approx(
            stats.multivariate_normal(np.zeros(count), sigma).logpdf(column)
        )
    assert noise.whiten(values[:, 0]).shape == (count,)
    with pytest.raises(InputError, match=f"4 residuals, but the noise model was fitted to {count}"):
        noise.whiten(np.ones(4))
    assert Independent().noise(count, np.zeros(0)).covariance == pytest.approx(np.eye(count))


def test_dense_noise_is_whitened_by_its_root():
    sigma = toeplitz([2.0, 0.9, 0.3, 0.1])
    noise, values = DenseNoise(sigma, 0.0, {}), RNG.normal(size=4)
    expected = stats.multivariate_normal(np.zeros(4), sigma).logpdf(values)
    assert noise.log_likelihood(values) == pytest.approx(expected)
    assert log_likelihood(values, sigma) == pytest.approx(expected)
    white = whiten(values, sigma)
    assert noise.whiten(values) == pytest.approx(white)
    assert white @ white == pytest.approx(values @ np.linalg.solve(sigma, values))
    with pytest.raises(NumericalError, match="not positive definite"):
        whiten(values, -sigma)


def test_the_likelihood_without_its_amplitude_is_that_at_the_best_amplitude():
    sigma, residuals = toeplitz([1.0, 0.5, 0.2]), RNG.normal(size=(2, 3))
    value, amplitude = concentrated(DenseNoise(sigma, 0.0, {}), residuals)
    squares = sum(row @ np.linalg.solve(sigma, row) for row in residuals)
    assert amplitude == pytest.approx(squares / 6)
    whole = stats.multivariate_normal(np.zeros(3), amplitude * sigma)
    assert value == pytest.approx(sum(whole.logpdf(row) for row in residuals))


def test_residuals_of_zero_have_no_optimum():
    with np.errstate(all="ignore"), pytest.raises(NumericalError, match="no optimum of the likelihood from 4 starts"):
        maximize(FAMILIES["independent"], np.zeros((1, 16)), np.random.default_rng(0))
    theta, amplitude = maximize(FAMILIES["independent"], np.full((2, 4), 3.0), np.random.default_rng(0))
    assert (theta.tolist(), amplitude) == ([], pytest.approx(9.0))
    noise = fit_noise("independent", np.full((2, 5), 3.0), 0.1, rng=np.random.default_rng(0))
    assert isinstance(noise, CirculantNoise)
    assert noise.power == pytest.approx([9.0, 9.0, 9.0])
    assert noise.hyperparameters == pytest.approx({"amplitude [mmHg2]": 9.0})


def test_autocovariances_of_short_models_are_known():
    assert autocovariance(np.array([0.6]), np.zeros(0), 5) == pytest.approx(0.6 ** np.arange(5) / (1 - 0.36))
    moving = autocovariance(np.zeros(0), np.array([0.5, -0.2]), 5)
    assert moving == pytest.approx([1 + 0.25 + 0.04, 0.5 - 0.1, -0.2, 0, 0])
    assert autocovariance(np.array([0.6]), np.array([0.3]), 1) == pytest.approx([(1 + 0.09 + 2 * 0.6 * 0.3) / 0.64])
    both = autocovariance(np.array([0.6]), np.array([0.3]), 4)
    assert both[2:] == pytest.approx(0.6 * both[1:3])
    assert len(autocovariance(np.array([0.5, 0.1]), np.zeros(0), 2)) == 2
    model = Arma(np.array([0.6]), np.zeros(0), 2.0, 0.0, 0.0)
    assert model.covariance(3) == pytest.approx(2 / 0.64 * toeplitz([1, 0.6, 0.36]))


def test_the_likelihood_of_an_arma_model_without_its_variance_is_that_of_its_covariance():
    series, ar, ma = RNG.normal(size=(2, 6)), np.array([0.4]), np.array([0.2])
    value, variance = concentrated_arma(ar, ma, series)
    sigma = toeplitz(autocovariance(ar, ma, 6))
    assert variance == pytest.approx(sum(row @ np.linalg.solve(sigma, row) for row in series) / 12)
    whole = stats.multivariate_normal(np.zeros(6), variance * sigma)
    assert value == pytest.approx(sum(whole.logpdf(row) for row in series))
    assert concentrated_arma(ar, ma, np.zeros((1, 6)))[0] == -np.inf


def test_orders_grow_one_by_one_from_those_that_are_known():
    assert list(_orders((1, 2))) == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)]
    x = np.array([1.0, 2.0, 3.0])  # two of the past, one of the noise
    assert _grown(x, (2, 1), (3, 1)).tolist() == [1.0, 2.0, 0.02, 3.0]
    assert _grown(x, (2, 1), (2, 2)).tolist() == [1.0, 2.0, 3.0, 0.02]
    ar, ma = _coefficients(np.array([0.3, 0.2]), 1)
    assert (ar.tolist(), ma.tolist()) == ([pytest.approx(np.tanh(0.3))], [pytest.approx(-np.tanh(0.2))])


def test_burgs_recursion_by_hand():
    unit = np.array([[1.0, 2.0, 0.5, -1.0], [0.3, -0.4, 0.6, 1.5]])
    f, b = unit[:, 1:], unit[:, :-1]
    first = 2 * (f * b).sum() / (f**2 + b**2).sum()
    f2, b2 = (f - first * b)[:, 1:], (b - first * f)[:, :-1]
    second = 2 * (f2 * b2).sum() / (f2**2 + b2**2).sum()
    assert np.tanh(_burg(unit, 2)) == pytest.approx([first, second])
    assert _burg(np.ones((1, 8)), 1) == pytest.approx([7.0])  # at the edge


def test_an_arma_fit_scales_with_its_series():
    series = RNG.normal(size=(2, 40)) + 0.3
    one, ten = fit_arma(series, (1, 1)), fit_arma(10 * series, (1, 1))
    assert ten.innovation_variance == pytest.approx(100 * one.innovation_variance, rel=1e-5)
    assert ten.log_likelihood == pytest.approx(one.log_likelihood - 80 * np.log(10))
    assert ten.bic == pytest.approx(one.bic + 160 * np.log(10))
    p, q = len(one.ar), len(one.ma)
    assert one.bic == pytest.approx(-2 * one.log_likelihood + (p + q + 1) * np.log(80))
    assert one.log_likelihood == pytest.approx(concentrated_arma(one.ar, one.ma, series)[0])
    assert one.innovation_variance == pytest.approx(concentrated_arma(one.ar, one.ma, series)[1])
    noise = fit_noise("ARMA", series, 0.1, rng=np.random.default_rng(0))
    best = fit_arma(series)
    assert noise.hyperparameters["p"] == len(best.ar)
    assert noise.hyperparameters["q"] == len(best.ma)
    assert {f"phi{i}" for i in range(1, len(best.ar) + 1)} <= set(noise.hyperparameters)
    assert noise.hyperparameters["amplitude [mmHg2]"] == pytest.approx(best.covariance(40)[0, 0])
