"""Gaps in recordings and times that leap over them, and values that stand for none."""

import warnings

import numpy as np
import pytest

from vasowave.base import InputError, stretch
from vasowave.catheter.read import read_raw_recording
from vasowave.catheter.signals import Span, even_step, gaps


def test_four_gaps_are_told_by_three_those_that_touch_are_one_and_a_short_rest_is_no_advice():
    five = [Span(1, 2), Span(2, 2.5), Span(4, 4.1), Span(6, 6.1), Span(8, 8.1)]
    said, cures = gaps.describe_gaps(five, 0.0, 9.0, 1.0)
    assert said.startswith("no samples from 1 to 2.5 s, 4 to 4.1 s, 6 to 6.1 s and 1 more; the longest stretch without")
    assert cures == [stretch("4.1", "6")]
    assert "more" not in gaps.describe_gaps(five[:4], 0.0, 9.0, 1.0)[0]
    assert gaps.describe_gaps(five, 0.0, 9.0, 1.91)[0].endswith("; no 1.91 s are without a gap")


@pytest.mark.parametrize(
    ("count", "far", "taken"),
    [
        (0, 0, False),
        (1, 0.4, False),  # half a step is none
        (1, 0.6, True),
        (3, 5, True),  # of 399 steps a hundredth may leap
        (4, 5, False),
        (1, 7500, True),  # 20 times the samples there are
        (1, 7700, False),
    ],
)
def test_times_leap_only_if_they_do_seldom_and_not_too_far(count, far, taken):
    time = np.arange(400) * 0.01
    for at in range(1, count + 1):
        time[at * 40 :] += far * 0.01
    assert (gaps.leaps_closed(time) is not None) is taken


def place(row):
    return f"f.csv, line {row + 2}"


@pytest.mark.parametrize(
    ("time", "quantum", "said"),
    [
        ([0.0, 0.1, 0.3, 0.4], 0.01, r"line 4, column 'time': uneven sampling, a step of 0.2 s .* have 0.1 s"),
        ([0.0, 1.0, 1.2, 2.2, 3.2, 4.7], 1e-6, "line 4, column 'time': uneven"),  # a short step is the farthest off
        ([0.0, 0.1, 0.05, 0.2], 1e-6, "line 4, column 'time': time does not increase"),
        ([0.0, 0.0, 0.0, 0.0], 1e-6, "line 3, column 'time': time does not increase"),
        ([0.0, 0.1, 0.1, 0.2], 0.1, r"f\.csv, column 'time': written to 0\.1 s, coarser than .* \(0\.0667 s\)"),
    ],
)
def test_times_that_are_uneven_are_named_where_they_are_most(time, quantum, said):
    with pytest.raises(InputError, match=said):
        even_step(np.array(time), quantum, "f.csv", place)


@pytest.mark.parametrize(("code", "unit", "missing"), [(-999, "mmHg", True), (-9999, "kPa", True), (-999, "Pa", False)])
def test_a_code_far_from_all_others_is_a_missing_value_and_one_among_them_a_number(tmp_path, code, unit, missing):
    rows = [
        f"{i / 500:.3f},{code if i == 100 else i % 50 + (-980 if unit == 'Pa' else 0)},{i % 7}" for i in range(2000)
    ]
    path = tmp_path / "a.csv"
    path.write_text("\n".join([f"time [s],pressure [{unit}],flow [ml/s]", *rows, ""]), encoding="utf-8")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        if missing:
            with pytest.raises(InputError, match=r"'pressure': no samples from 0.2 to 0.202 s"):
                read_raw_recording(path)
            assert f"'pressure': 1 samples are {code}, far from all others" in str(caught[0].message)
        else:
            assert read_raw_recording(path).pressure.min() == pytest.approx(-999 * 760 / 101325, rel=1e-5)
            assert not caught
