"""Kernels, ARMA and restricted likelihood against independent implementations, and the table of one animal."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.stats import multivariate_normal
from sklearn.gaussian_process.kernels import RBF, ExpSineSquared, Matern
from statsmodels.tsa.arima.model import ARIMA
from statsmodels.tsa.arima_process import arma_acovf, arma_generate_sample

from vasowave.pulse import noise
from vasowave.pulse.noise import autocovariance, concentrated, falling_power

TIME = np.linspace(0, 0.11, 50, endpoint=False)


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        (noise.squared_exponential(TIME, 0.02), RBF(0.02)),
        (noise.matern32(TIME, 0.02), Matern(0.02, nu=1.5)),
        (noise.matern52(TIME, 0.02), Matern(0.02, nu=2.5)),
        (noise.periodic(TIME, 0.7, 0.11), ExpSineSquared(0.7, 0.11)),
    ],
    ids=["squared exponential", "Matern 3/2", "Matern 5/2", "periodic"],
)
def test_a_kernel_agrees_with_scikit_learn(ours, theirs):
    np.testing.assert_allclose(ours, theirs(TIME[:, None]), atol=1e-12)


def test_the_arcsine_kernel_is_williams_integral_done_by_hand():
    # E[erf(a + bt) erf(a + bs)] over a ~ N(0, σa²), b ~ N(0, σb²), by Gauss-Hermite quadrature; Williams (1998) shows
    # that it is (2/π) asin(2 x̃ᵀΣx̃' / √((1 + 2x̃ᵀΣx̃)(1 + 2x̃'ᵀΣx̃'))) with x̃ = (1, t), Σ = diag(σa², σb²).
    from scipy.special import erf

    nodes, weights = np.polynomial.hermite_e.hermegauss(80)
    weights = weights / weights.sum()
    t = np.array([-0.4, 0.3, 1.1])
    hidden = erf(0.7 * nodes[:, None, None] + 1.3 * nodes[None, :, None] * t)
    expected = np.einsum("a,b,abt,abs->ts", weights, weights, hidden, hidden)
    np.testing.assert_allclose(noise.neural_network(t, 0.7, 1.3), expected, atol=1e-9)


@pytest.mark.parametrize("name", noise.KERNELS)
@pytest.mark.parametrize("count", [64, 65])
def test_the_likelihoods_covariance_has_the_condition_number_that_is_aimed_at(name, count):
    kernel = noise.KERNELS[name]
    theta = [np.sqrt(lower * upper) for _, lower, upper, _ in kernel.hyperparameters]
    process = kernel.noise(count, theta)
    expected, weight = noise.regularize(kernel.matrix(np.arange(count) / count, *theta))
    np.testing.assert_allclose(process.covariance, expected, atol=1e-12)
    assert process.weight == pytest.approx(weight, abs=1e-12)


ORDERS = [([1.2, -0.5], [0.4, 0.2, 0.1]), ([0.9], []), ([], [0.7, -0.2]), ([0.5, 0.3], [-0.6]), ([], [])]


@pytest.mark.parametrize(("ar", "ma"), ORDERS)
def test_the_autocovariance_and_the_exact_likelihood_agree_with_statsmodels_and_scipy(ar, ma):
    ar, ma = np.array(ar), np.array(ma)
    theirs = arma_acovf(np.append(1, -ar), np.append(1, ma), nobs=40)
    np.testing.assert_allclose(autocovariance(ar, ma, 40), theirs, atol=1e-10)
    series = np.random.default_rng(0).normal(size=(2, 40))
    found, variance = concentrated(ar, ma, series)
    assert found == pytest.approx(multivariate_normal(cov=variance * toeplitz(theirs)).logpdf(series).sum())
    if len(ar) + len(ma):
        model = ARIMA(series[0], order=(len(ar), 0, len(ma)), trend="n")
        one, variance = concentrated(ar, ma, series[:1])
        assert one == pytest.approx(model.loglike(np.concatenate([ar, ma, [variance]])), rel=1e-6)


def test_arma_finds_the_order_and_the_optimum_that_statsmodels_finds():
    series = arma_generate_sample([1, -1.2, 0.5], [1, 0.4], 300, distrvs=np.random.default_rng(4).standard_normal)
    found = noise.fit_arma(3.0 * series[None], largest=(2, 1))
    theirs = ARIMA(3.0 * series, order=(len(found.ar), 0, len(found.ma)), trend="n").fit()
    assert (len(found.ar), len(found.ma)) == (2, 1)
    assert found.log_likelihood == pytest.approx(theirs.llf, abs=0.01)
    assert found.bic == pytest.approx(theirs.bic, abs=0.02)
    np.testing.assert_allclose([*found.ar, *found.ma, found.innovation_variance], theirs.params, rtol=0.01)
    assert found.covariance(5)[0, 0] == pytest.approx(found.innovation_variance * autocovariance(found.ar, found.ma, 1))


def test_two_series_share_one_arma_model():
    series = np.random.default_rng(1).normal(size=(2, 200)).cumsum(axis=1) * 0.98
    joint = noise.fit_arma(series, largest=(1, 0))
    apart = [noise.fit_arma(one[None], largest=(1, 0)) for one in series]
    assert joint.log_likelihood <= sum(one.log_likelihood for one in apart) + 1e-6
    assert min(one.ar[0] for one in apart) <= joint.ar[0] <= max(one.ar[0] for one in apart)


def test_the_power_of_a_matern_process_falls_from_its_corner_on():
    np.testing.assert_allclose(falling_power(np.array([0.0, 2.0, 6.0]), 2.0, 1.5), [1.0, 2.0**-1.5, 10.0**-1.5])


def test_the_coefficients_of_an_arma_model_are_numbered_from_one():
    series = np.array(
        [arma_generate_sample([1, -0.6], [1, 0.3], 300, distrvs=np.random.default_rng(s).normal) for s in (0, 1)]
    )
    found = noise.fit_noise("ARMA", series, 0.11, rng=np.random.default_rng(0)).hyperparameters
    orders = {"phi": round(found["p"]), "theta": round(found["q"])}
    assert orders["phi"] > 0
    for letter, order in orders.items():
        assert [f"{letter}{i}" in found for i in range(order + 2)] == [False, *[True] * order, False]
