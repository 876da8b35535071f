"""Numbers and lists in words, on the edge of each rule: what is written so, and what just not."""

import math

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from vasowave.study.cohort import DRAWS
from vasowave.study.report import (
    ERROR_OF_DRAWS,
    friction_words,
    listed,
    number,
    p_value,
    probability,
    ratio_with_interval,
    some_of,
    table_rows,
    undecided,
    unlimited,
    value_text,
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
        (1.7e-5, 1.1e-5, 2.4e-5, "1.70 [1.10, 2.40]·10⁻⁵"),
        (0.0, -2e-7, 3e-7, "0.0 [-2.0, 3.0]·10⁻⁷"),
    ],
)
def test_an_interval_has_two_digits_of_its_nearer_end_or_of_each_number(value, low, high, written):
    assert with_interval(value, low, high) == written


@pytest.mark.parametrize(
    ("value", "low", "high", "written"),
    [
        (1.5, 1.0004, 2.2, "1.50 [1.0004, 2.20]"),
        (0.42, 0.18, 0.9996, "0.42 [0.18, 0.9996]"),
        (0.874, 0.7612, 1.004, "0.87 [0.76, 1.004]"),
        (2.17, 1.023, 4.53, "2.2 [1.02, 4.5]"),
        (2.10, 1.31, 3.37, "2.10 [1.31, 3.37]"),
        (0.558, 1e-9, 1e9, "0.558 [no limits]"),
    ],
)
def test_ends_of_ratios_show_on_which_side_of_one_they_lie(value, low, high, written):
    assert ratio_with_interval(value, low, high) == written
    assert unlimited(low, high) == ("no limits" in written)


def test_p_is_not_written_smaller_than_the_draws_can_tell():
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


@pytest.mark.parametrize(
    ("p", "said"), [(0.5, "p = 0.50"), (0.0302, "p = 0.030"), (0.0002, "p = 0.00020"), (1e-4, "p ≤ 0.0001"),
                  (0.049, "p ≈ 0.049"), (0.0451, "p = 0.045"), (0.0539, "p ≈ 0.054"), (0.055, "p = 0.055")]
)  # fmt: skip
def test_a_p_that_no_drawn_cohort_reaches_is_said_as_a_bound(p, said):
    """10 000 cohorts, the observed one among them: 0.0001 is the least that there can be."""
    assert probability(p) == said


def test_values_and_tables_are_written_with_units():
    value = xr.DataArray(2.0, attrs={"units": "mmHg2", "interval_low": 1.0, "interval_high": 3.0})
    assert value_text(value) == "2.0 [1.0, 3.0] mmHg²"
    assert value_text(xr.DataArray(2.0, attrs={"units": "1"})) == "2.00"
    assert table_rows(pd.DataFrame({"a [cm2]": [1.23456], "b": [True]})) == (("a [cm²]", "b"), [("1.235", "yes")])


@pytest.mark.parametrize(
    ("law", "settings", "words"),
    [
        ("BoundaryLayer", {"reference_radius": None}, "a boundary layer (local radius)"),
        ("BoundaryLayer", {"reference_radius": 0.047}, "a boundary layer (fixed radius 0.0470 cm)"),
        ("Poiseuille", {}, "Poiseuille flow"),
        ("PowerLaw", {"exponent": 9.0}, "a power-law profile (exponent 9.00)"),
        ("Ours", {"first_part": 2.5, "second": 3.0}, "Ours (first part 2.50, second 3.00)"),
    ],
)
def test_a_friction_is_called_by_its_law_and_its_settings(law, settings, words):
    assert friction_words(law, settings) == words
