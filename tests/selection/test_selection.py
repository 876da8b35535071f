import numpy as np
import pytest
from scipy.special import gamma, kv
from scipy.stats import multivariate_normal

from vasowave import noise, selection
from vasowave.errors import InputError, NumericalError

T = np.linspace(0, 0.11, 64, endpoint=False)


@pytest.mark.parametrize(("kernel", "nu"), [(noise.matern32, 1.5), (noise.matern52, 2.5)])
def test_matern_kernels_are_the_bessel_form(kernel, nu):
    s = np.sqrt(2 * nu) * np.abs(np.subtract.outer(T, T))[0, 1:] / 0.02
    expected = 2 ** (1 - nu) / gamma(nu) * s**nu * kv(nu, s)
    np.testing.assert_allclose(kernel(T, 0.02)[0, 1:], expected, rtol=1e-10)


def test_the_neural_network_kernel_is_the_mean_product_of_random_error_functions():
    from scipy.special import erf

    rng = np.random.default_rng(1)
    a, b = 0.7 * rng.standard_normal((400_000, 1)), 1.5 * rng.standard_normal((400_000, 1))
    t = np.array([-0.5, 0.2, 1.0])
    hidden = erf(a + b * t)
    # Standard error of the mean of products below 1 is under 1/√400000 = 0.0016; four of them.
    np.testing.assert_allclose(noise.neural_network(t, 0.7, 1.5), hidden.T @ hidden / len(hidden), atol=0.0064)


def test_the_likelihood_agrees_with_scipy_and_with_whitening():
    sigma = 2.5 * noise.matern32(T, 0.01)
    r = np.random.default_rng(0).standard_normal(64)
    assert noise.log_likelihood(r, sigma) == pytest.approx(multivariate_normal(cov=sigma).logpdf(r))
    assert (noise.whiten(r, sigma) ** 2).sum() == pytest.approx(r @ np.linalg.solve(sigma, r))
    with pytest.raises(NumericalError, match="regularize"):
        noise.log_likelihood(r, -sigma)


def test_aicc_needs_two_samples_more_than_parameters_and_no_more():
    # Eq. 21 by hand: 2·10 + 2·3 + 2·3·4/(5 - 3 - 1).
    assert selection.aicc(-10, 3, 5) == pytest.approx(20 + 6 + 24, rel=1e-12)
    with pytest.raises(InputError, match="more than 4 samples for 3 parameters"):
        selection.aicc(-10, 3, 4)


def test_the_published_differences_of_aicc_and_bic_follow_from_512_samples():
    for parameters, published in ((4, -16.9), (5, -21.1)):
        difference = selection.aicc(0, parameters, 512) - selection.bic(0, parameters, 512)
        assert difference == pytest.approx(published, abs=0.05)
