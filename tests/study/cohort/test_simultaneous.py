"""Intervals and p for a whole family at once: against SciPy where it knows the answer, and against false positives."""

import numpy as np
import pytest
from scipy import stats

from vasowave.study.cohort import LEVEL, ComparedQuantity, pooled_ratio, simultaneous

DRAWS = 4_999
ERROR = 4 * np.sqrt(0.25 / DRAWS)  # four standard errors of a share, at its worst


def rows_of(logs, other, errors=0.0, shared=0.0):
    """Return a row for each quantity; an animal counts where it has a value."""
    rows = []
    for quantity, own in enumerate(logs.T):
        known = np.flatnonzero(np.isfinite(own))
        rows.append(ComparedQuantity(quantity, known, other[known], own[known], np.full(len(known), errors), shared))
    return rows


def cohort(rng, sizes, ratio=1.0, correlation=0.6, count=9):
    other = np.arange(sum(sizes)) >= sizes[0]
    mixed = np.linalg.cholesky(correlation + (1 - correlation) * np.eye(count))
    return rng.standard_normal((len(other), count)) @ mixed.T * np.where(other, ratio, 1.0)[:, np.newaxis], other


def excluded(row, critical):
    groups = [(row.logs[own], row.errors[own]) for own in (~row.in_second, row.in_second)]
    ratio = pooled_ratio(*groups, level=1 - critical, shared=row.shared)
    return not ratio.low <= 1 <= ratio.high


def test_one_row_has_welchs_p():
    logs, other = cohort(np.random.default_rng(1), (12, 9), ratio=1.7, count=1)
    found = simultaneous(rows_of(logs + 0.9 * other[:, np.newaxis], other), DRAWS)
    x, y = logs[~other, 0], logs[other, 0] + 0.9
    assert found.p[0] == pytest.approx(stats.ttest_ind(y, x, equal_var=False).pvalue, abs=ERROR / 2)
    assert found.critical == pytest.approx(LEVEL, abs=ERROR / 2)
    assert found.rate == pytest.approx(LEVEL, abs=ERROR / 2)


def test_rows_that_are_one_cost_nothing_and_rows_without_correlation_cost_what_sidak_says():
    rng = np.random.default_rng(2)
    logs, other = cohort(rng, (40, 40), correlation=0.0)
    logs = logs + 0.6 * other[:, np.newaxis]
    alone = stats.ttest_ind(logs[other], logs[~other], equal_var=False).pvalue
    apart = simultaneous(rows_of(logs, other), DRAWS)
    np.testing.assert_allclose(apart.p, 1 - (1 - alone) ** 9, atol=ERROR)
    same = simultaneous(rows_of(np.repeat(logs[:, :1], 9, axis=1), other), DRAWS)
    np.testing.assert_allclose(same.p, alone[0], atol=ERROR)


def test_several_groups_against_one_are_dunnetts_test():
    rng = np.random.default_rng(3)
    groups = [0.5 * place + rng.standard_normal(25) for place in range(3)]
    rows = [
        ComparedQuantity(0, np.concatenate([np.arange(25), 25 * place + np.arange(25)]), np.arange(50) >= 25,
            np.concatenate([groups[0], groups[place]]), np.zeros(50), 0.0)
        for place in (1, 2)
    ]  # fmt: skip
    expected = stats.dunnett(*groups[1:], control=groups[0], rng=np.random.default_rng(0)).pvalue
    np.testing.assert_allclose(simultaneous(rows, DRAWS).p, expected, atol=ERROR / 2)


@pytest.mark.parametrize("count", [200, pytest.param(5_000, marks=pytest.mark.weekly)])
def test_an_interval_excludes_one_exactly_if_p_is_below_its_level(count):
    """Cohorts of many kinds: sizes, spreads, gaps, known errors, shared ones, effects near the edge."""
    rng, shown = np.random.default_rng(4), 0
    for number in range(count):
        sizes = tuple(rng.integers(3, 9, 2))
        logs, other = cohort(rng, sizes, ratio=rng.choice([0.3, 1.0, 3.0]), count=4)
        logs = 0.2 * logs + rng.exponential(0.4) * other[:, np.newaxis]
        logs[2 : sizes[0]] = np.where(rng.random((sizes[0] - 2, 4)) < 0.1, np.nan, logs[2 : sizes[0]])
        rows = rows_of(logs, other, errors=rng.choice([0.0, 0.0, 0.0, 0.15]), shared=rng.choice([0.0, 0.1]))
        found = simultaneous(rows, draws=59, seed=number)
        below = [bool(p < LEVEL) for p in found.p]
        assert below == [excluded(row, found.critical) for row in rows], number
        shown += sum(below)
    assert 0.2 < shown / count < 3.5  # of four rows; both answers were asked for


def test_where_the_smaller_group_varies_more_a_family_is_wrong_no_more_often_than_it_says():
    """12 + 4 animals, the four with twice the SD: tests that take spreads as equal find something in a quarter."""
    rng, wrong = np.random.default_rng(5), 0
    for number in range(150):
        logs, other = cohort(rng, (12, 4), ratio=2.0)
        wrong += simultaneous(rows_of(logs, other), draws=99, seed=number).p.min() < LEVEL
    # Binomial standard error of 5 % in 150: 1.8 %; three of them.
    assert wrong / 150 < 0.104


def test_an_image_that_a_group_shares_makes_no_false_positives():
    """Animals differ by 10 %, one image for each group is wrong by 10 %: unaware tests find something in a third."""
    rng, wrong = np.random.default_rng(6), {0.0: 0, np.sqrt(2) * 0.1: 0}
    for number in range(150):
        logs, other = cohort(rng, (7, 5), count=4)
        logs = 0.1 * logs + 0.1 * rng.standard_normal(2)[other.astype(int), np.newaxis]
        for shared in wrong:
            wrong[shared] += simultaneous(rows_of(logs, other, shared=shared), draws=99, seed=number).p.min() < LEVEL
    aware, unaware = wrong[np.sqrt(2) * 0.1] / 150, wrong[0.0] / 150
    assert aware < 0.104  # three binomial standard errors above 5 %
    assert unaware > 0.2


def test_known_errors_of_animals_count_in_the_reference_distribution():
    """Animals that differ by nothing but their errors: the p of the family follows that of a normal deviate."""
    other = np.arange(14) >= 7
    logs = np.outer(np.where(other, 0.35, 0.0), [1.0]) + 0.01 * np.random.default_rng(7).standard_normal((14, 1))
    found = simultaneous(rows_of(logs, other, errors=0.3), DRAWS)
    drawn = np.random.default_rng(8).normal(0, 0.3, (DRAWS, 14))
    rows = [(one[~other], one[other]) for one in drawn[:400]]
    alone = [abs(np.log(pooled_ratio(*((x, np.full(7, 0.3)) for x in row)).value)) for row in rows]
    # Two-sided, of what chance alone does to 400 such cohorts; four standard errors of that share.
    assert found.p[0] == pytest.approx(np.mean(np.array(alone) >= 0.35), abs=0.06)


def test_the_same_cohort_has_the_same_p():
    logs, other = cohort(np.random.default_rng(9), (6, 5))
    first, again = (simultaneous(rows_of(logs, other), draws=199) for _ in range(2))
    np.testing.assert_array_equal(first.p, again.p)
    assert first[1:] == again[1:]
