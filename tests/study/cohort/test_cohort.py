from dataclasses import replace
from itertools import combinations

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy import stats

from made_cohort import changed, made_results
from vasowave.base import InputError
from vasowave.pulse.examples import published_table
from vasowave.study.cohort import (
    MAX_EXACT_ANIMALS,
    cohort_table,
    contrasts,
    describe,
    estimates_of,
    exact_mann_whitney,
    hedges_g,
    holm,
    leave_one_out,
    mann_whitney,
    misfits,
    typical_animal,
)

BETA, S = "beta [mmHg]", "S [mmHg2]"


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
    x, y = rng.normal(0, 1, MAX_EXACT_ANIMALS // 2), rng.normal(0.3, 1, MAX_EXACT_ANIMALS // 2 + 1)
    assert mann_whitney(x, y) == stats.mannwhitneyu(x, y, method="asymptotic").pvalue
    assert mann_whitney(x, y) == pytest.approx(exact_mann_whitney(x, y), rel=0.01)
    assert mann_whitney(x, y[1:]) == exact_mann_whitney(x, y[1:])


def test_holm_steps_down_and_never_decreases():
    np.testing.assert_allclose(holm(np.array([0.04, 0.01, 0.03])), [0.06, 0.03, 0.06])
    assert holm(np.array([0.6, 0.7, 0.5])).tolist() == [1.0, 1.0, 1.0]


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


@pytest.mark.parametrize(("table", "words"), [
    ({"group": [*"aabb"], "x": [1.0, 2.0, -1.0, 3.0]}, "a ratio needs positive"),
    ({"group": [*"aab"], "x": [1.0, 2.0, 3.0]}, "needs two animals in each"),
])  # fmt: skip
def test_values_that_have_no_ratio_and_groups_of_one_are_refused(table, words):
    with pytest.raises(InputError, match=words):
        contrasts(pd.DataFrame(table), ["x"], "a", "b")


def test_a_quantity_has_one_unit_in_all_animals():
    results = made_results({"CTL": 2}, walls=())
    results[1].measured.quantities["mPAP"].attrs["units"] = "kPa"
    with pytest.raises(InputError, match="'mPAP' of animal 'CTL 2' is in kPa, before in mmHg"):
        cohort_table(results)


def test_an_interval_of_95_percent_tells_the_error_of_a_value_that_says_none():
    results = made_results({"CTL": 2}, walls=("linear",))
    ends = [(0.5, 2.0), (0.8, 1.25)]
    for result, (low, high) in zip(results, ends, strict=True):
        value = result.laws["linear"].quantities["stiffness"]
        value.attrs = {"interval_low": low * float(value), "interval_high": high * float(value)}
    found = estimates_of(results, "linear", "stiffness").errors
    assert found == pytest.approx([np.log(high / low) / (2 * stats.norm.ppf(0.975)) for low, high in ends], rel=1e-6)


def test_a_fit_that_leaves_less_than_the_beats_scatter_does_not_miss_its_data():
    """Of a beat whose SD is 3 and 4 mmHg in equal parts, the mean of 4 beats has an error of √(12.5 / 4) mmHg."""
    (result,) = made_results({"CTL": 1}, walls=("linear",))
    sd = np.resize([3.0, 4.0], len(result.recording["pressure"]))
    recording = result.recording.assign(pressure_sd=(result.recording["pressure"].dims, sd))
    beats = xr.Dataset({"kept": ("beat", [1, 1, 0, 1, 1])})
    error, pulse = np.sqrt(12.5 / 4), 10.0
    for left, missed in ((0.99 * error, False), (1.01 * error, True)):  # both above a tenth of the pulse
        one = changed(changed(result, "linear/calibration", RMSE=left), "measured/quantities", pPAP=pulse)
        table = misfits([replace(one, recording=recording, beats=beats)])
        assert table["error"][0] == pytest.approx(error)
        assert table["share"][0] == pytest.approx(left / pulse)
        assert table["missed"][0] == missed


def test_the_animal_that_is_shown_is_nearest_to_the_medians_in_deviations():
    rows = pd.DataFrame({
        "animal": list("abcd"), "group": "CTL", "source": "measured", "mPAP [mmHg]": [10.0, 12.0, 14.0, 40.0],
        "CO [ml/s]": [0.1, 0.4, 0.2, 0.2], "HR [beats/min]": 500.0,
    })  # fmt: skip
    values = rows[["mPAP [mmHg]", "CO [ml/s]"]].to_numpy()
    away = (((values - np.median(values, axis=0)) / values.std(axis=0)) ** 2).sum(axis=1)
    assert typical_animal(rows, "CTL") == "abcd"[int(np.argmin(away))]
