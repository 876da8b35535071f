"""Numbers and lists in words, on the edge of each rule: what is written so, and what just not."""

import math

import numpy as np
import pytest

from vasowave.report.answer.design import _weights
from vasowave.report.answer.walls import _MOST_RATIOS, _range, _ratio, _times
from vasowave.report.wording import (
    ERROR_OF_DRAWS,
    listed,
    number,
    p_value,
    ratio_with_interval,
    some_of,
    undecided,
    unlimited,
    with_error,
    with_interval,
)


@pytest.mark.parametrize(
    ("value", "written"),
    [
        (0.0, "0"), (1e-4, "0.000100"), (9.99e-5, "9.99·10⁻⁵"), (99999.0, "99999"), (1e5, "1.00·10⁵"),
        (-2.5e-7, "-2.50·10⁻⁷"),
        (True, "yes"), (np.bool_(False), "no"), (3, "3"), (np.int64(4), "4"), (None, ""), ("x", "x"), (math.nan, "–"),
        (1234.5, "1234"), (0.9996, "1.000"), (-12.34, "-12.3"),
    ],
)  # fmt: skip
def test_numbers_are_written_as_people_do(value, written):
    assert number(value) == written


@pytest.mark.parametrize(
    ("value", "error", "written"),
    [
        (0.18, 0.03, "0.180 ± 0.030"), (77.0, 21.0, "77 ± 21"), (0.5, 0.0996, "0.50 ± 0.10"),
        (0.5, 0.0994, "0.500 ± 0.099"), (0.0, 3e-7, "(0.0 ± 3.0)·10⁻⁷"), (1e-9, 0.5, "0.00 ± 0.50"),
        (1.0, 1e-12, "1.00"), (1.0, math.nan, "1.00"), (2e5, 3e4, "(2.00 ± 0.30)·10⁵"), (0.0, 0.5, "0.00 ± 0.50"),
        (1e-4, 1e-5, "0.000100 ± 0.000010"), (99999.0, 10.0, "99999 ± 10"),
    ],
)  # fmt: skip
def test_an_error_has_two_digits_and_its_value_as_many_places(value, error, written):
    assert with_error(value, error) == written


@pytest.mark.parametrize(
    ("value", "low", "high", "written"),
    [
        (2.86, 1.76, 3.93, "2.9 [1.8, 3.9]"),
        (0.22, 0.0032, 15.0, "0.22 [0.0032, 15]"),
        (2.0, 1.0, 10.0, "2.0 [1.0, 10.0]"),  # a factor of ten itself
        (2.0, 1.0, 10.001, "2.0 [1.0, 10]"),
        (2.0, 2.0, 2.0, "2.00"),
        (2.0, 2.0, 3.0, "2.00 [2.00, 3.00]"),
        (2.0, -math.inf, 3.0, "2.00"),
        (2e6, 1e6, 3e6, "2.0 [1.0, 3.0]·10⁶"),
        (-1.0, -2.0, 4.0, "-1.0 [-2.0, 4.0]"),
        (0.0, -1.0, 1.0, "0.0 [-1.0, 1.0]"),
        (1e-9, -1.0, 1.0, "0.0 [-1.0, 1.0]"),
        (0.0, -2e-7, 3e-7, "0.0 [-2.0, 3.0]·10⁻⁷"),
    ],
)
def test_an_interval_has_two_digits_of_its_nearer_end_or_of_each_number(value, low, high, written):
    assert with_interval(value, low, high) == written


def test_ends_of_ratios_show_on_which_side_of_one_they_lie():
    assert ratio_with_interval(1.5, 1.0004, 2.2) == "1.50 [1.0004, 2.20]"
    assert ratio_with_interval(0.7, 0.5, 0.9996) == "0.70 [0.50, 0.9996]"
    assert ratio_with_interval(2.0, 1e-3, 1e4).endswith("[no limits]")
    assert not unlimited(1e-3, 1e3)
    assert unlimited(1e-3, 1.0001e3)


def test_p_is_not_written_smaller_than_the_draws_can_tell():
    from vasowave.report.wording import DRAWS

    least = 1 / (DRAWS + 1)
    assert p_value(1.49 * least) == f"≤ {least:.4f}"
    assert p_value(1.5 * least) == number(1.5 * least, 2)
    assert ERROR_OF_DRAWS == pytest.approx(math.sqrt(0.05 * 0.95 / DRAWS))
    reach = 2 * ERROR_OF_DRAWS
    assert undecided(0.05 + 0.99 * reach)
    assert not undecided(0.05 + 1.01 * reach)
    assert not undecided(0.05 - 1.01 * reach)
    assert p_value(0.05).startswith("≈ ")


def test_lists_in_words():
    assert listed(["a"]) == "a"
    assert listed(["a", "b", "c"]) == "a, b and c"
    assert some_of(["a", "b"], 2) == "a and b"
    assert some_of(["a", "b", "c"], 2) == "a, b and c"
    assert some_of(["a", "b", "c", "d"], 2) == "a, b and 2 more"


def test_ratios_of_evidence_are_counted_to_a_thousand():
    assert [_ratio(one) for one in (1000.0, 1000.1, 1e-3, 0.99e-3)] == ["1000", "over 1000", "0.0010", "under 0.001"]
    few, many = np.full(_MOST_RATIOS, 2.0), np.arange(1.0, _MOST_RATIOS + 2)
    assert _times(few) == f"{listed(['2.0'] * _MOST_RATIOS)} times"
    assert _times(many).endswith(f"times (median; 1.0 to {_ratio(many.max())})")


def test_the_range_of_an_exponent_says_which_end_is_known():
    from vasowave.cohort.walls import Exponent

    def said(low, high):
        return _range(Exponent("m", 1.0, 2.0, low, high, 1, 0, 0, False))

    assert said(1.0, 3.0) == "m = 2.0 [1.0, 3.0]"
    assert said(0.0, 3.0) == "m is at most 3.0 (95 %)"
    assert said(1.0, math.inf) == "m is at least 1.0 (95 %)"
    assert said(0.0, math.inf) == "m is not determined"
    assert Exponent("m", 1.0, 2.0, 1.0, 3.0, 1, 0, 0, False).side == 0
    assert Exponent("m", 1.0, 2.0, 1.001, 3.0, 1, 0, 0, False).side == 1
    assert Exponent("m", 1.0, 0.5, 0.1, 1.0, 1, 0, 0, False).side == 0
    assert Exponent("m", 1.0, 0.5, 0.1, 0.999, 1, 0, 0, False).side == -1


def test_a_contrast_is_written_as_a_sum_that_begins_with_what_counts_up():
    assert _weights({"a": -1.0, "b": 1.0}) == "'b' − 'a'"
    assert _weights({"a": -0.5, "b": 1.0, "c": -0.5, "d": 0.0}) == "'b' − 0.5 · 'a' − 0.5 · 'c'"
    assert _weights({"a": -1.0, "b": -1.0}) == "− 'a' − 'b'"
