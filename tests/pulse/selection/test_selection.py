import numpy as np
import pytest
from scipy.stats import multivariate_normal

from vasowave.base import InputError, NumericalError
from vasowave.pulse import noise, selection

T = np.linspace(0, 0.11, 64, endpoint=False)


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
