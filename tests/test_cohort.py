import numpy as np
import pytest
from scipy import stats

from vasowave.cohort import contrasts, describe, exact_mann_whitney, holm, what_n_can_show
from vasowave.datasets import published_table
from vasowave.errors import InputError

BETA, S = "beta [mmHg]", "S [mmHg2]"


def test_the_published_stiffness_doubles_with_hypertension():
    found = contrasts(published_table("optimized_linear"), [BETA], "CTL", "HPH").iloc[0]
    assert found[["ratio", "ratio low", "ratio high"]].round(1).tolist() == [2.1, 1.6, 2.8]
    assert found["eta"] == pytest.approx(1.07, abs=0.01)


def test_the_exact_test_agrees_with_scipy_where_nothing_is_tied():
    table = published_table("optimized_linear")
    x, y = (table.loc[table.group == g, S].to_numpy() for g in ("CTL", "HPH"))
    assert exact_mann_whitney(x, y) == pytest.approx(stats.mannwhitneyu(x, y, method="exact").pvalue)


def test_holm_steps_down_and_never_decreases():
    np.testing.assert_allclose(holm(np.array([0.04, 0.01, 0.03])), [0.06, 0.03, 0.06])


def test_three_against_three_cannot_reach_five_percent():
    assert "0.1 in" in what_n_can_show(3, 3)
    assert "cannot" in what_n_can_show(3, 3)
    assert "0.035" in what_n_can_show(7, 5, 14)


def test_groups_with_any_labels_are_described():
    table = published_table("optimized_linear").replace({"CTL": "sham", "HPH": "banded"})
    found = describe(table, [BETA])
    assert found["n"].tolist() == [7, 5]
    assert found["mean"].round(1).tolist() == [56.3, 116.8]
    with pytest.raises(InputError, match="gamma"):
        describe(table, ["gamma"])
