"""Pareto-smoothed weights: the shape of their tail, and what they do to weighted means."""

import numpy as np
import pytest
from scipy.stats import genpareto

from vasowave.pulse.inference import smoothed


@pytest.mark.parametrize("k", [0.2, 0.5, 0.9])
def test_the_tail_of_pareto_weights_has_their_shape(k):
    rng = np.random.default_rng(1)
    ratios = [np.log((1 - rng.random(4000)) ** -k) for _ in range(20)]  # exact Pareto tail with this shape
    found = [smoothed(one).k_hat for one in ratios]
    assert np.mean(found) == pytest.approx(k, abs=0.06)  # 20 fits to 190 weights each: standard error below 0.03


def test_the_tail_has_the_quantiles_of_the_pareto_distribution_above_the_largest_weight_below_it():
    log = np.random.default_rng(7).normal(0, 1.2, 400)
    weights = smoothed(log)
    size = 60  # 3 √400, which is less than a fifth
    *_, cut = np.sort(log)[:-size]
    rank = np.argsort(log)[-size:]
    scaled = np.exp(weights.log_weight[rank] - weights.log_weight[log == cut])
    expected = genpareto.ppf((np.arange(size) + 0.5) / size, weights.k_hat)
    below_the_cap = slice(0, size // 2)
    np.testing.assert_allclose((scaled - 1)[below_the_cap] / (scaled[0] - 1), expected[below_the_cap] / expected[0])


def test_weights_add_up_to_one_and_keep_their_order():
    log = np.random.default_rng(2).normal(0, 1.5, 500)
    weights = smoothed(log)
    assert np.exp(weights.log_weight).sum() == pytest.approx(1.0)
    assert np.all(np.diff(weights.log_weight[np.argsort(log)]) >= -1e-9)


def test_smoothing_brings_a_weighted_mean_nearer_to_the_truth():
    rng, plain, smooth = np.random.default_rng(3), [], []
    for _ in range(300):
        x = rng.standard_normal(300)  # from N(0, 1), weighted to N(0, 1.6²), whose mean square is 2.56
        log = -0.5 * (x / 1.6) ** 2 + 0.5 * x**2
        raw = np.exp(log - log.max())
        plain.append(raw @ x**2 / raw.sum())
        smooth.append(np.exp(smoothed(log).log_weight) @ x**2)
    error = [np.sqrt(np.mean((np.array(one) - 2.56) ** 2)) for one in (plain, smooth)]
    assert error[1] < error[0]


def test_one_weight_that_carries_everything_is_not_trusted():
    log = np.random.default_rng(4).normal(0, 3.0, 400)
    log[7] = 30.0
    weights = smoothed(log)
    assert not weights.trusted
    assert weights.effective < 20


def test_a_draw_that_cannot_be_simulated_has_no_weight():
    log = np.random.default_rng(5).normal(0, 0.3, 100)
    log[3] = -np.inf
    assert np.exp(smoothed(log).log_weight)[3] == 0.0
