"""Means of groups with their intervals, against formulas of textbooks and simulations."""

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import brentq

from vasowave.study.cohort import Estimates, importance_index, importance_interval, pooled


def known(logs, errors=0.0, shared=0.0):
    n = len(logs)
    return Estimates(
        np.asarray(logs), np.full(n, errors), np.full((1, n), shared), np.zeros((1, n), int), "fit", True, np.zeros(n)
    )


def test_without_errors_it_is_the_geometric_mean_with_students_interval():
    logs = np.log([50.0, 61.0, 44.0, 70.0, 58.0])
    low, high = stats.t.interval(0.95, 4, logs.mean(), stats.sem(logs))
    np.testing.assert_allclose(pooled(known(logs)), np.exp([logs.mean(), low, high]), rtol=1e-5)


def test_an_error_that_all_share_is_not_averaged_away():
    logs = np.random.default_rng(3).normal(4.0, 1e-3, 40)
    one = pooled(known(logs, shared=0.1))
    assert np.log(one.high / one.low) / 2 == pytest.approx(1.96 * 0.1, rel=1e-2)


def test_recordings_of_one_animal_are_averaged_before_animals_are_compared():
    """By hand: the means of three mice, Student's interval of three; an own error falls, a shared one does not."""
    logs = np.log([50.0, 61.0, 44.0, 70.0, 58.0, 52.0])
    found = known(logs, errors=0.02, shared=0.1).by_animal(["a", "b", "a", "b", "c", "c"])
    means = np.array([logs[[0, 2]].mean(), logs[[1, 3]].mean(), logs[[4, 5]].mean()])
    np.testing.assert_allclose(found.logs, means)
    np.testing.assert_allclose(found.errors, 0.02 / np.sqrt(2))
    np.testing.assert_allclose(found.shared, [[0.1, 0.1, 0.1]])
    plain = pooled(known(logs).by_animal(["a", "b", "a", "b", "c", "c"]))
    low, high = stats.t.interval(0.95, 2, means.mean(), stats.sem(means))
    np.testing.assert_allclose(plain, np.exp([means.mean(), low, high]), rtol=1e-5)


def test_of_one_animal_and_of_equal_ones_there_is_a_mean_without_an_interval():
    for logs in ([4.0], [4.0, 4.0, 4.0]):
        value, *ends = pooled(known(logs))
        assert value == pytest.approx(np.exp(4.0))
        assert np.isnan(ends).all()


def test_the_ends_of_the_importance_interval_are_where_welchs_t_of_the_ratio_is_at_its_limit():
    x, y = np.array([20.0, 23.0, 18.0, 25.0, 21.0]), np.array([31.0, 40.0, 36.0])
    low, high = importance_interval(x, y)
    va, vb, ratio = x.var(ddof=1) / 5, y.var(ddof=1) / 3, y.mean() / x.mean()
    freedom = (ratio**2 * va + vb) ** 2 / ((ratio**2 * va) ** 2 / 4 + vb**2 / 2)
    limit = stats.t.ppf(0.975, freedom)

    def beyond(eta):
        rho = 1 + eta
        return abs(y.mean() - rho * x.mean()) / np.sqrt(vb + rho**2 * va) - limit

    eta = importance_index(x.mean(), y.mean())
    assert low == pytest.approx(brentq(beyond, eta - 1.5, eta), rel=1e-9)
    assert high == pytest.approx(brentq(beyond, eta, eta + 5), rel=1e-9)


def test_the_importance_interval_holds_the_truth_in_95_of_100_cohorts():
    rng, true, held = np.random.default_rng(5), 0.5, 0
    for _ in range(2000):
        low, high = importance_interval(rng.normal(20, 3, 7), rng.normal(30, 6, 5))
        held += low <= true <= high
    assert held / 2000 == pytest.approx(0.95, abs=0.015)  # three standard errors of the count


def test_no_importance_interval_where_nothing_tells_it():
    for x, y in (([1.0], [2.0, 3.0]), ([1.0, 1.0], [2.0, 2.0]), ([-4.0, 5.0, 1.0], [2.0, 3.0])):
        assert np.isnan(importance_interval(np.array(x), np.array(y))).all()
