"""Blocks of harmonics left out by re-weighting, against the normal problem where that has a closed form."""

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from vasowave.pulse.inference import Discrepancy, left_out
from vasowave.pulse.noise import harmonics

SAMPLES, UNKNOWNS, VARIANCE = 11, 3, 1.0
RNG = np.random.default_rng(1)
J = RNG.normal(0, 0.4, (SAMPLES, UNKNOWNS))
DATA = RNG.normal(0, 1, SAMPLES)
NOISE = Discrepancy(SAMPLES, (1e-6, 0.0), VARIANCE * np.eye(SAMPLES), np.zeros((SAMPLES, 1)))


def residuals(count):
    """Return what draws of the normal posterior leave."""
    covariance = np.linalg.inv(J.T @ J / VARIANCE + np.eye(UNKNOWNS))
    draws = RNG.multivariate_normal(covariance @ J.T @ DATA / VARIANCE, covariance, count)
    return DATA - draws @ J.T


def test_what_the_other_harmonics_say_of_a_block_is_the_conditional_density():
    found = left_out(NOISE, residuals(4000), np.full(4000, -np.log(4000)))
    whole = J @ J.T + VARIANCE * np.eye(SAMPLES)
    together = multivariate_normal(cov=whole).logpdf(DATA)
    assert list(found.index) == ["0", "1", "2", "3-4", "5"]
    for name, ends in zip(found.index, ((0, 0), (1, 1), (2, 2), (3, 4), (5, 5)), strict=True):
        others = (harmonics(SAMPLES) < ends[0]) | (harmonics(SAMPLES) > ends[1])
        rest = multivariate_normal(cov=whole[others][:, others]).logpdf(DATA[others])
        assert found.loc[name, "log_density"] == pytest.approx(together - rest, abs=0.05)
        assert found.loc[name, "k_hat"] < 0.7


def test_a_block_that_alone_fixes_an_unknown_is_not_trusted():
    sharp = np.full(SAMPLES, 10.0)
    sharp[0] = 1e-5
    noise = Discrepancy(SAMPLES, (1e-6, 0.0), np.diag(sharp), np.zeros((SAMPLES, 1)))
    covariance = np.linalg.inv((J.T / sharp) @ J + np.eye(UNKNOWNS))
    draws = RNG.multivariate_normal(covariance @ (J.T / sharp) @ DATA, covariance, 400)
    found = left_out(noise, DATA - draws @ J.T, np.full(400, -np.log(400)))
    assert found.loc["0", "k_hat"] > 0.7
    assert found.loc["5", "k_hat"] < 0.7


def test_a_block_that_the_model_misses_is_as_improbable_as_by_all_spectra():
    """What the other harmonics say of the model's error is nothing like what the missed block says of it."""
    noise, count = Discrepancy(41, (0.3, 0.7), 0.03**2 * np.eye(41), np.zeros((41, 1))), 100
    rows = np.random.default_rng(2).normal(0, 0.1, (count, 41)) * np.exp(-0.2 * noise.harmonic)
    missed = noise.harmonic == 1
    rows[:, missed] += 10.0
    found = left_out(noise, rows, np.full(count, -np.log(count)))
    given = noise.log_likelihood(rows) - noise.without(missed).log_likelihood(rows)
    assert found.loc["1", "log_density"] == pytest.approx(np.log(count) - logsumexp(-given), abs=1.0)
