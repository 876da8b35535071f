"""Verdicts of a cohort at their limits, and tests of ranks and relabelings against SciPy."""

from itertools import combinations
from math import comb

import numpy as np
import pytest
import xarray as xr
from scipy import stats

from relabelings import _relabelings, family_p
from vasowave.animal.law_result import PosteriorResult
from vasowave.cohort import Variable
from vasowave.cohort.estimates import _drawn
from vasowave.cohort.primary import MOST_RELABELINGS
from vasowave.cohort.two_groups import (
    exact_mann_whitney,
    hedges_g,
    holm,
    importance_index,
    importance_interval,
    mann_whitney,
)
from vasowave.cohort.votes import DECISIVE, _difference, _price, _side
from vasowave.cohort.walls import CLEAR, Evidence
from vasowave.errors import InputError
from vasowave.inference.known_errors import SHARED
from vasowave.selection.averaging import averaged
from vasowave.selection.compare import _series
from vasowave.selection.criteria import UNDECIDED, aicc, bic, verdicts

RNG = np.random.default_rng(3)


def test_evidence_is_clear_from_its_limit_on_and_speaks_where_none_is_clearly_against_it():
    def told(*ratios):
        one = Evidence("power", dict(zip("abcdef", ratios)), [])
        return one.clear, one.side

    assert told(CLEAR, 1.0) == ((1, 0), 1)
    assert told(CLEAR * 0.999, 1.0) == ((0, 0), 0)
    assert told(1 / CLEAR, 1.0) == ((0, 1), -1)
    assert told(CLEAR**3, 1 / CLEAR) == ((1, 1), 0)
    assert told(*[CLEAR**0.5] * 6) == ((0, 0), 0)  # together clear, none by itself
    assert told(CLEAR, 0.9) == ((1, 0), 0)  # together not


def test_a_difference_of_scores_is_said_beyond_its_limit_and_its_scatter():
    assert _side(np.array([DECISIVE])) == 1
    assert _side(np.array([-DECISIVE])) == -1
    assert _side(np.array([DECISIVE * 0.999])) == 0
    assert _side(np.array([10.0, 11.0, 12.0])) == 1
    assert _side(np.array([1.0, 30.0, -3.0])) == 0
    values, price = np.array([10.0, 11.0, 12.0]), np.array([2.0, 2.0, 2.0])
    row = _difference("power", "linear", values, price)
    assert (row["n"], row["sum"], row["price"], row["mean"], row["residuals"]) == (3, 33.0, 2.0, 11.0, 9.0)
    reach = stats.t.ppf(0.975, 2) / np.sqrt(3)
    assert (row["low"], row["high"]) == pytest.approx((11 - reach, 11 + reach))
    assert (row["residuals low"], row["residuals SD"], row["speaks for"]) == (pytest.approx(9 - reach), 1.0, "linear")
    assert _difference("power", "linear", values, values)["speaks for"] == ""
    assert _difference("power", "linear", -values, np.zeros(3))["speaks for"] == "power"
    alone = _difference("power", "linear", values[:1], price[:1])
    assert np.isnan(alone["low"])
    assert np.isnan(alone["residuals SD"])
    assert _price(4, 512) == pytest.approx(8 + 40 / 507)


def test_scores_are_decided_from_their_limit_on():
    assert verdicts({"a": 0.0, "b": UNDECIDED}) == [("a", 0.0, "preferred"), ("b", UNDECIDED, "worse")]
    assert [one[2] for one in verdicts({"a": 0.0, "b": 4.999, "c": 9.0})] == ["undecided", "undecided", "worse"]
    assert verdicts({"a": 1.0}) == [("a", 0.0, "undecided")]
    assert aicc(-10.0, 2, 4) == pytest.approx(20 + 4 + 12)
    with pytest.raises(InputError, match="more than 3 samples for 2"):
        aicc(-10.0, 2, 3)
    assert bic(-10.0, 2, 4) == pytest.approx(20 + 2 * np.log(4))


@pytest.mark.parametrize(
    ("residuals", "period", "said"),
    [
        ({"a": np.ones(64)}, 0.1, "needs two models; residuals were given for 1"),
        ({"a": np.ones(64), "b": np.ones(63)}, 0.1, "have shape"),
        ({"a": np.ones(64), "b": np.zeros(64)}, 0.1, "all zero or not finite"),
        ({"a": np.ones(64), "b": np.ones(64)}, 0.0, "period 0 s is not a positive"),
        ({"a": np.ones(64), "b": np.ones(64)}, np.inf, "period inf s is not a positive"),
    ],
)
def test_residuals_that_cannot_be_compared_are_refused(residuals, period, said):
    with pytest.raises(InputError, match=said):
        _series(residuals, dict.fromkeys(residuals, 4), period)
    assert _series({"a": np.ones(64), "b": 2 * np.ones(64)}, {"b": 4, "a": 5}, 0.1).shape == (2, 64)


LACKING = [
    ([0.0, 1], [1, 1], [1, 1]),
    ([1, 1], [0.0, 1], [1, 1]),
    ([1, 1], [1, 1], [0.0, 0]),
    ([1, 1], [1, 1], [2, -1]),
]


@pytest.mark.parametrize("wrong", LACKING)
def test_an_average_needs_positive_numbers(wrong):
    with pytest.raises(InputError, match="needs positive values"):
        averaged(*wrong)


def test_an_average_over_laws_has_the_quantiles_of_their_mixture():
    found = averaged([100.0, 300.0], [0.1, 0.3], [1.0, 3.0])
    draws = np.exp(np.append(RNG.normal(np.log(100), 0.1, 100_000), RNG.normal(np.log(300), 0.3, 300_000)))
    assert found.value == pytest.approx(np.median(draws), rel=5e-3)
    assert averaged([100.0, 300.0], [0.1, 0.3], [1.0, 0.0]).value == pytest.approx(100.0)


def test_rank_sums_are_exact_up_to_their_limit_with_and_without_ties():
    x, y = np.array([1.0, 2, 3, 5, 8]), np.array([4.0, 6, 7, 9])
    assert exact_mann_whitney(x, y) == pytest.approx(stats.mannwhitneyu(x, y, method="exact").pvalue)
    tied, other = np.array([1.0, 2, 2, 3]), np.array([2.0, 4, 4])
    ranks = stats.rankdata(np.append(tied, other))
    off = abs(ranks[:4].sum() - 16)
    sums = [ranks[list(chosen)].sum() for chosen in combinations(range(7), 4)]
    assert exact_mann_whitney(tied, other) == pytest.approx(np.mean([abs(one - 16) >= off - 1e-9 for one in sums]))
    assert mann_whitney(x, y) == exact_mann_whitney(x, y)
    from vasowave.cohort.two_groups import MOST_EXACT

    many = RNG.normal(0, 1, MOST_EXACT - 20), RNG.normal(0.3, 1, 20)
    assert mann_whitney(*many) == exact_mann_whitney(*many)
    more = np.append(many[0], 0.1)
    assert mann_whitney(more, many[1]) == stats.mannwhitneyu(more, many[1], method="asymptotic").pvalue
    assert exact_mann_whitney(np.arange(5.0), np.arange(5.0, 9)) == pytest.approx(2 / comb(9, 5))
    assert holm(np.array([0.01, 0.04, 0.03, 0.5])) == pytest.approx([0.04, 0.09, 0.09, 0.5])
    assert holm(np.array([0.9, 0.8])) == pytest.approx([1.0, 1.0])


def test_relabelings_are_all_while_they_are_few():
    all_ = _relabelings(6, 2, None)
    assert {tuple(np.flatnonzero(row)) for row in all_} == set(combinations(range(6), 2))
    count = next(n for n in range(8, 40) if comb(n, n // 2) > MOST_RELABELINGS)
    drawn = _relabelings(count, count // 2, None)
    assert drawn.shape == (MOST_RELABELINGS, count)
    assert (drawn.sum(axis=1) == count // 2).all()
    assert drawn[0].tolist() == [True] * (count // 2) + [False] * (count - count // 2)


def test_p_of_a_family_of_one_is_that_of_all_relabelings_by_students_t():
    values, other = RNG.normal(0, 1, (7, 1)), np.array([False] * 4 + [True] * 3)
    values[other] += 1.0

    def t(chosen):
        others = np.delete(values, chosen)
        return abs(stats.ttest_ind(others, values[chosen, 0]).statistic)

    every = np.array([t(list(chosen)) for chosen in combinations(range(7), 3)])
    own = t(np.flatnonzero(other))
    assert family_p(values, other)[0] == pytest.approx(np.mean(every >= own * (1 - 1e-9)))
    for wrong in (np.zeros(7, bool), np.ones(7, bool)):
        with pytest.raises(InputError, match="needs two groups and three animals"):
            family_p(values, wrong)
    with pytest.raises(InputError, match="there are 1 and 1"):
        family_p(values[:2], np.array([True, False]))
    with pytest.raises(InputError, match="the same value in every animal"):
        family_p(np.ones((7, 1)), other)


def test_effects_of_fewer_than_two_or_without_scatter_are_not_known():
    one, two = np.array([1.0]), np.array([1.0, 2.0])
    for pair in ((one, two), (two, one)):
        assert np.isnan(importance_interval(*pair)).all()
        with pytest.raises(InputError, match="two values in each group"):
            hedges_g(*pair)
    assert np.isfinite(importance_interval(two + 50, two + 60)).all()
    assert np.isnan(importance_interval(np.ones(2), np.ones(2))).all()
    assert np.isnan(importance_interval(np.array([-1.0, 1.1]), two)).all()  # a mean that may be zero
    with pytest.raises(InputError, match="needs variation"):
        hedges_g(np.ones(3), np.full(3, 2.0))
    g, low, high = hedges_g(np.array([1.0, 2, 3]), np.array([2.0, 3, 4]))
    assert g == pytest.approx(1 * (1 - 3 / (4 * 4 - 1)), rel=0.02)  # the usual approximation of the correction
    assert low < g < high


def test_columns_are_numbers_or_dates_if_most_of_their_cells_are():
    assert Variable.of("x", {"a": "1", "b": "two"}).kind == "category"  # half of them
    with pytest.raises(InputError, match="'two' of c is not a number, as the others are"):
        Variable.of("x", {"a": "1", "b": "2", "c": "two"})
    with pytest.raises(InputError, match="'two' of a is not a number"):
        Variable.of("x [g]", {"a": "two"})
    with pytest.raises(InputError, match="'soon' of c is not a date"):
        Variable.of("x", {"a": "2024-01-02", "b": "2024-01-05", "c": "soon"})
    days = Variable.of("day", {"a": "2024-01-05", "b": "2024-01-02"})
    assert (days.kind, days.numbers, days.order) == ("date", {"a": 3.0, "b": 0.0}, ["2024-01-02", "2024-01-05"])
    assert Variable.of("x", {"a": "10", "b": "9"}).order == ["9", "10"]
    assert Variable.of("x", {"a": "after", "b": "before"}).order == ["before", "after"]


def codes(column, count=None):
    animals = dict.fromkeys(column.values if count is None else map(str, range(count)), "CTL")
    return [one.code.rpartition(".")[2] for one in column.slips(animals)]


def test_slips_of_the_pen_are_told_at_their_limits():
    def of(cells, title="x"):
        return Variable.of(title, {str(place): cell for place, cell in enumerate(cells)})

    constant, lone = codes(of(["f", "f"])), codes(of(["f"]))
    assert (len(constant), lone) == (1, [])
    assert len(codes(of(["f", "m", "f", "m"]), 5)) == 1  # one cell is empty
    numbers = ["20", "21", "22", "23", "230"]
    assert len(codes(of(numbers))) == 1
    assert codes(of(numbers[2:])) == []  # three values tell no spread
    assert codes(of([*numbers[:4], "0"])) == []
    assert codes(of([*numbers, "-1"])) == []
    words = ["saline", "saline", "vehicle", "vehicle", "salin"]
    assert len(codes(of(words))) == 1
    assert codes(of(["a1", "b2", "c3", "c3"])) == []  # more than half stand alone: names


def test_draws_tell_mean_and_scatter_of_logarithms_and_no_share_where_none_is_stored():
    draws = np.exp(RNG.normal(2.0, 0.3, (2, 50)))
    table = xr.Dataset({"share_image": ("quantity", [0.4])}, coords={"quantity": ["R_T"]})
    one = PosteriorResult(table.assign_attrs(trusted=1), {"posterior": xr.Dataset({"R_T": (("chain", "draw"), draws)})})
    mean, sd, shares = _drawn(one, "R_T")
    logs = np.log(draws).ravel()
    assert (mean, sd) == pytest.approx((logs.mean(), np.sqrt(((logs - logs.mean()) ** 2).sum() / 99)))
    assert shares == [0.4 if column == "image" else 0.0 for column in SHARED]


def test_the_importance_of_a_quantity_is_its_relative_change_with_fiellers_interval():
    """η = mean over mean, less one; at the ends of its interval the two groups' weighted difference has t of Welch."""
    x, y = np.array([10.0, 11, 12, 9]), np.array([14.0, 17, 15])
    assert importance_index(10.0, 14.0) == pytest.approx(0.4)
    low, high = importance_interval(x, y)
    eta = y.mean() / x.mean() - 1
    assert low < eta < high
    variances = x.var(ddof=1) / 4, y.var(ddof=1) / 3
    parts = ((1 + eta) ** 2 * variances[0], variances[1])
    freedom = sum(parts) ** 2 / (parts[0] ** 2 / 3 + parts[1] ** 2 / 2)
    for end in (low, high):
        t = abs(y.mean() - (1 + end) * x.mean()) / np.sqrt(variances[1] + (1 + end) ** 2 * variances[0])
        assert t == pytest.approx(stats.t.ppf(0.975, freedom))
