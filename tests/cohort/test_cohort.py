from itertools import combinations
from math import comb

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy import stats

import relabelings
from vasowave.cohort import contrasts, describe, leave_one_out, pairwise_contrasts
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.comparison import compare
from vasowave.cohort.estimates import _log_error
from vasowave.cohort.two_groups import MOST_EXACT, exact_mann_whitney, hedges_g, holm, mann_whitney
from vasowave.datasets import published_table
from vasowave.errors import InputError

AS_MEASURED = {"beta [mmHg]": "HR [1]", "S [mmHg2]": "CO [1]"}
BETA, S = "beta [mmHg]", "S [mmHg2]"


def _third():
    """Return a group that lies beyond the others."""
    third = published_table("optimized_linear").query("group == 'HPH'")
    return third.assign(group="c", **{BETA: 1.5 * third[BETA], S: 0.7 * third[S]})


def test_the_published_stiffness_doubles_with_hypertension():
    found = contrasts(published_table("optimized_linear"), [BETA], "CTL", "HPH").iloc[0]
    assert found[["ratio", "ratio low", "ratio high"]].round(1).tolist() == [2.1, 1.6, 2.8]
    assert found["eta"] == pytest.approx(1.07, abs=0.01)


def test_the_exact_test_agrees_with_scipy_where_nothing_is_tied():
    table = published_table("optimized_linear")
    x, y = (table.loc[table.group == g, S].to_numpy() for g in ("CTL", "HPH"))
    assert exact_mann_whitney(x, y) == pytest.approx(stats.mannwhitneyu(x, y, method="exact").pvalue)


@pytest.mark.parametrize("sizes", [(2, 3), (4, 3), (3, 6)])
def test_the_exact_test_of_ties_counts_every_relabeling(sizes):
    rng = np.random.default_rng(5)
    x, y = (rng.integers(1, 5, size).astype(float) for size in sizes)
    ranks = stats.rankdata([*x, *y])
    sums = np.array([ranks[list(chosen)].sum() for chosen in combinations(range(len(ranks)), len(x))])
    away = np.abs(sums - sums.mean())
    assert exact_mann_whitney(x, y) == pytest.approx(np.mean(away >= away[0] - 1e-9))


def test_the_rank_test_of_many_animals_is_the_normal_one_and_near_the_exact_one():
    rng = np.random.default_rng(2)
    x, y = rng.normal(0, 1, MOST_EXACT // 2), rng.normal(0.3, 1, MOST_EXACT // 2 + 1)
    assert mann_whitney(x, y) == stats.mannwhitneyu(x, y, method="asymptotic").pvalue
    assert mann_whitney(x, y) == pytest.approx(exact_mann_whitney(x, y), rel=0.01)
    assert mann_whitney(x, y[1:]) == exact_mann_whitney(x, y[1:])


def test_contrasts_of_every_pair_stand_pair_by_pair_and_holm_counts_them_all():
    table = pd.concat([published_table("optimized_linear").replace({"HPH": "b"}), _third()], ignore_index=True)
    cohort = Cohort({}, {}, table.assign(source="measured", animal=table.index).rename(columns=AS_MEASURED))
    found = compare(cohort, "measured").contrasts
    pd.testing.assert_frame_equal(found, pairwise_contrasts(cohort.table, list(AS_MEASURED.values())))


def test_holm_steps_down_and_never_decreases():
    np.testing.assert_allclose(holm(np.array([0.04, 0.01, 0.03])), [0.06, 0.03, 0.06])


@pytest.mark.parametrize(("n", "m"), [(3, 3), (7, 5), (2, 6)])
def test_groups_that_do_not_overlap_have_the_smallest_p(n, m):
    assert exact_mann_whitney(np.arange(n), np.arange(m) + 10.0) == pytest.approx(2 / comb(n + m, n))


def test_groups_with_any_labels_are_described():
    table = published_table("optimized_linear").replace({"CTL": "sham", "HPH": "banded"})
    found = describe(table, [BETA])
    assert found["n"].tolist() == [7, 5]
    assert found["mean"].round(1).tolist() == [56.3, 116.8]
    with pytest.raises(InputError, match="gamma"):
        describe(table, ["gamma"])


def test_the_interval_of_hedges_g_holds_the_truth_as_often_as_it_says():
    rng = np.random.default_rng(0)
    inside = 0
    for _ in range(500):
        _, low, high = hedges_g(rng.normal(0, 2, 7), rng.normal(3, 2, 5))
        inside += low <= 1.5 * (1 - 3 / 39) <= high
    # Binomial standard error of 95 % in 500: 1 %.
    assert 0.92 < inside / 500 < 0.98


def test_hedges_g_is_the_t_statistic_scaled_and_its_interval_touches_zero_at_the_t_test():
    x, y = np.array([3.0, 4.5, 5.0, 2.0, 4.0]), np.array([6.0, 5.5, 4.9, 7.5])
    test = stats.ttest_ind(y, x)
    g, _, _ = hedges_g(x, y)
    assert g == pytest.approx(test.statistic * np.sqrt(1 / 5 + 1 / 4) * (1 - 3 / (4 * 9 - 9)))
    assert hedges_g(x, y, level=1 - test.pvalue)[1] == pytest.approx(0, abs=1e-4)
    low, high = (bound / ((1 - 3 / 27) * np.sqrt(9 / 20)) for bound in hedges_g(x, y)[1:])
    assert stats.nct.cdf(test.statistic, 7, [low, high]) == pytest.approx([0.975, 0.025], abs=2e-5)
    with pytest.raises(InputError, match="variation"):
        hedges_g(np.ones(3), np.ones(3))


def test_one_animal_that_carries_the_result_is_found_out():
    rng = np.random.default_rng(3)
    values = np.concatenate([rng.uniform(1, 2, 7), rng.uniform(2.1, 3, 4), [1.0]])
    table = pd.DataFrame({"group": ["a"] * 7 + ["b"] * 5, "x": values}, index=[f"m{i}" for i in range(12)])
    found = leave_one_out(table, ["x"], "a", "b").set_index("left out")
    assert len(found) == 12
    assert found["ratio shift"].idxmax() == "m11"
    apart = contrasts(table.drop("m11"), ["x"], "a", "b")["ratio"][0]
    assert found.loc["m11", "ratio"] == pytest.approx(apart)
    assert found.loc["m11", "ratio shift"] == pytest.approx(apart / contrasts(table, ["x"], "a", "b")["ratio"][0])
    with pytest.raises(InputError, match="three animals"):
        leave_one_out(table.iloc[5:9], ["x"], "a", "b")


def three_groups():
    table = published_table("optimized_linear")
    table = table.assign(group=["sham", "early", "late"] * 4)
    table.loc[table["group"] == "late", BETA] *= 3
    return table


def test_three_groups_are_compared_two_by_two_with_holm_over_all():
    found = pairwise_contrasts(three_groups(), [BETA, S])
    assert (
        list(zip(found["reference"], found["other"]))
        == [("sham", "early")] * 2 + [("sham", "late")] * 2 + [("early", "late")] * 2
    )
    np.testing.assert_allclose(found["p Holm"], holm(found["p"].to_numpy()))


def test_many_relabelings_are_drawn_and_the_labels_as_they_are_are_one_of_them(monkeypatch):
    monkeypatch.setattr(relabelings, "MOST_RELABELINGS", 50)
    few = relabelings._relabelings(5, 2, None)
    assert sorted(map(tuple, few.tolist())) == sorted(map(tuple, np.unique(few, axis=0).tolist()))
    assert few.shape == (10, 5)  # all
    many = relabelings._relabelings(12, 4, None)
    assert many.shape == (50, 12)
    assert many[0].tolist() == [True] * 4 + [False] * 8
    assert (many.sum(axis=1) == 4).all()


def test_the_exact_rank_test_counts_ties_as_all_relabelings_do():
    rng = np.random.default_rng(0)
    for _ in range(60):
        k, values = int(rng.integers(2, 5)), rng.integers(0, 4, int(rng.integers(6, 9))).astype(float)
        ranks = stats.rankdata(values)
        sums = np.array([ranks[list(chosen)].sum() for chosen in combinations(range(len(ranks)), k)])
        away = np.abs(sums - sums.mean())
        expected = np.mean(away >= abs(ranks[:k].sum() - sums.mean()) - 1e-9)
        assert exact_mann_whitney(values[:k], values[k:]) == pytest.approx(expected)


def test_no_adjusted_p_exceeds_one():
    assert holm(np.array([0.6, 0.7, 0.5])).tolist() == [1.0, 1.0, 1.0]


def test_an_error_of_a_logarithm_is_what_a_value_says_of_itself_or_its_interval_of_it():
    value = xr.DataArray(2.0, attrs={"standard_error": 0.1, "interval_low": 1.0, "interval_high": 4.0})
    assert _log_error(value) == pytest.approx(0.05)
    del value.attrs["standard_error"]
    assert _log_error(value) == pytest.approx(np.log(4.0) / (2 * 1.959964))  # 95 % of a normal distribution
    assert np.isnan(_log_error(xr.DataArray(2.0)))
