"""Gaps and times of recordings, by values counted by hand."""

import warnings

import numpy as np
import pytest

from vasowave.errors import InputError
from vasowave.io.textfile import Lines
from vasowave.recording import gaps, number_rows, read_raw_recording, signal
from vasowave.recording.gaps import Span

NAN = np.nan


def test_gaps_are_where_samples_are_missing_also_at_both_ends():
    values = np.array([NAN, 1.0, 2.0, NAN, np.inf, 3.0, NAN])
    assert gaps.gaps_in(values, 10.0) == (Span(0.0, 0.1), Span(0.3, 0.5), Span(0.6, 0.7))
    assert gaps.gaps_in(np.ones(5), 10.0) == ()


def test_what_is_free_lies_between_gaps_in_whatever_order_they_come():
    several = [Span(4.0, 5.0), Span(1.0, 2.0), Span(1.5, 3.0)]
    assert gaps.free_between(several, 0.0, 6.0) == [Span(0.0, 1.0), Span(3.0, 4.0), Span(5.0, 6.0)]
    assert gaps.free_between(several, 1.2, 4.5) == [Span(3.0, 4.0)]
    assert gaps.free_between([Span(0.0, 1.0)], 0.0, 1.0) == []


def test_the_longest_stretch_is_inside_in_whole_milliseconds():
    assert gaps.longest_between([Span(1.00049, 1.2), Span(3.00051, 4.0)], 0.0, 4.5) == Span(1.2, 3.0)
    assert gaps.longest_between([Span(0.0, 0.10001), Span(2.0, 9.0)], 0.0, 9.0) == Span(0.101, 2.0)
    assert gaps.longest_between([Span(0.0, 1.0)], 0.0, 1.0) == Span(0.0, 0.0)


def test_four_gaps_are_told_by_three_those_that_touch_are_one_and_a_short_rest_is_no_advice():
    five = [Span(1, 2), Span(2, 2.5), Span(4, 4.1), Span(6, 6.1), Span(8, 8.1)]
    said = gaps.describe_gaps(five, 0.0, 9.0, 1.0)
    assert said.startswith("no samples from 1 to 2.5 s, 4 to 4.1 s, 6 to 6.1 s and 1 more; the longest stretch without")
    assert "--start 4.1 --end 6;" in said
    assert "more" not in gaps.describe_gaps(five[:4], 0.0, 9.0, 1.0)
    assert "--start 4.1 --end 6;" in gaps.describe_gaps(five, 0.0, 9.0, 1.89)
    assert gaps.describe_gaps(five, 0.0, 9.0, 1.91).endswith("; no 1.91 s are without a gap")
    assert gaps.describe_gaps(five, 2.5, 4.05, 1.5).startswith("no samples from 4 to 4.1 s; the longest")


def test_times_that_leap_over_a_pause_are_closed_and_their_samples_keep_their_places():
    time = np.concatenate([np.arange(300), np.arange(350, 600)]) * 0.01
    closed, place = gaps.leaps_closed(time)
    assert closed == pytest.approx(np.arange(550) * 0.01)
    assert place.tolist() == [*range(300), *range(350, 600)]
    spread = gaps.with_gaps(np.arange(550.0), place)
    assert len(spread) == 600
    assert np.isnan(spread[300:350]).all()
    assert spread[[299, 350, 599]].tolist() == [299.0, 300.0, 549.0]


def test_times_leap_only_if_they_do_seldom_and_not_too_far():
    even = np.arange(400) * 0.01

    def leaping(count, far):
        time = even.copy()
        for at in range(1, count + 1):
            time[at * 40 :] += far * 0.01
        return gaps.leaps_closed(time)

    assert gaps.leaps_closed(even) is None
    assert leaping(1, 0.4) is None  # half a step is none
    assert leaping(1, 0.6) is not None
    assert leaping(3, 5) is not None  # of 399 steps a hundredth may leap
    assert leaping(4, 5) is None
    assert leaping(1, 7500) is not None  # 20 times the samples there are
    assert leaping(1, 7700) is None
    assert gaps.leaps_closed(np.array([1.0])) is None
    assert gaps.leaps_closed(even[::-1]) is None


def test_a_decimal_mark_is_found_once_and_a_second_one_is_named_with_its_line():
    mark = number_rows.DecimalMark("f.csv")
    assert not mark.comma(Lines(1, ["1", "2"]))
    assert mark.comma(Lines(3, ["1,5", "2"]))
    assert mark.comma(Lines(5, ["1"]))
    with pytest.raises(InputError, match="line 8: numbers with a decimal comma and with a decimal point"):
        mark.comma(Lines(7, ["1,5", "2.5"]))
    with pytest.raises(InputError, match=r"line 8: '12:30:01\.5' is not a number; a time of day"):
        mark.comma(Lines(7, ["1,5", "12:30:01.5"]))
    assert not number_rows.DecimalMark("f.csv").comma(Lines(1, ["1.5"]))


def test_commas_are_points_in_a_block_unless_they_separate_its_cells():
    rows = number_rows.NumberRows("f.csv", ["a", "b"], ";")
    assert rows.add_block(1, ["1,5;2,5"], True)
    assert rows.add_block(2, ["3.5;4.5"], False)
    assert [rows.take(0).tolist(), rows.take(1).tolist()] == [[1.5, 3.5], [2.5, 4.5]]
    rows = number_rows.NumberRows("f.csv", ["a", "b"], ",")
    assert rows.add_block(1, ["1,5"], True)
    assert [rows.take(0).tolist(), rows.take(1).tolist()] == [[1.0], [5.0]]


def place(row):
    return f"f.csv, line {row + 2}"


def test_the_step_is_that_of_the_mean_and_unevenness_is_named_where_it_is_largest():
    assert signal.even_step(np.array([0.0, 0.1, 0.2, 0.3]), 1e-6, "f.csv", place) == pytest.approx(0.1)
    rounded = np.array([0.0, 0.1, 0.21, 0.3])  # written to a hundredth
    assert signal.even_step(rounded, 0.01, "f.csv", place) == pytest.approx(0.1)
    with pytest.raises(InputError, match=r"line 4, column 'time': uneven sampling, a step of 0.2 s .* have 0.1 s"):
        signal.even_step(np.array([0.0, 0.1, 0.3, 0.4]), 0.01, "f.csv", place)
    with pytest.raises(InputError, match="line 4, column 'time': time does not increase"):
        signal.even_step(np.array([0.0, 0.1, 0.05, 0.2]), 1e-6, "f.csv", place)
    with pytest.raises(InputError, match="line 3, column 'time': time does not increase"):
        signal.even_step(np.zeros(4), 1e-6, "f.csv", place)
    with pytest.raises(InputError, match=r"f\.csv, column 'time': written to 0\.1 s, coarser than .* \(0\.0667 s\)"):
        signal.even_step(np.array([0.0, 0.1, 0.1, 0.2]), 0.1, "f.csv", place)
    assert signal.even_step(np.arange(4) * 2.0, 10.0, "f.csv", place) == 2.0  # equal steps were not rounded
    late = 5.0 + np.array([0.0, 0.1, 0.2, 0.3])
    assert signal.even_step(late, 1e-6, "f.csv", place) == pytest.approx(0.1)
    for jitter, fine in ((0.9e-3, True), (1.2e-3, False)):  # a thousandth of a step, whatever was written
        time = np.arange(6) * 0.01 + np.array([0, 0, 0, jitter, jitter, jitter]) * 0.01 * 1.2
        if fine:
            signal.even_step(time, 0.0, "f.csv", place)
        else:
            with pytest.raises(InputError, match="line 5, column 'time': uneven"):
                signal.even_step(time, 0.0, "f.csv", place)
    with pytest.raises(InputError, match="line 4, column 'time': uneven"):  # the short step is farther from the others
        signal.even_step(np.array([0.0, 1.0, 1.2, 2.2, 3.2, 4.7]), 1e-6, "f.csv", place)


def test_a_rate_is_one_over_the_step_also_where_times_leap():
    time = np.concatenate([np.arange(200), np.arange(260, 500)]) * 0.004
    rate, places = signal.sampling(time, 1e-9, "f.csv", place)
    assert rate == pytest.approx(250.0)
    assert places[[199, 200]].tolist() == [199, 260]
    rate, places = signal.sampling(np.arange(50) * 0.002, 1e-9, "f.csv", place)
    assert (rate, places) == (pytest.approx(500.0), None)


def test_numbers_are_written_to_their_finest_digit():
    assert signal.written_to(["0.2", " 0.213", "5", "x", ""]) == pytest.approx(0.001)
    assert signal.written_to(["20", "1e3"]) == 1.0
    assert signal.written_to(["1e-4"]) == pytest.approx(1e-4)
    assert signal.written_to(["1e-999"]) == pytest.approx(1e-300)


def test_a_given_unit_counts_and_is_noted_only_where_it_says_something_else():
    factor, notes = signal.given_unit("pressure", "mmHg", None, "here")
    assert (factor, notes) == (1.0, ())
    factor, notes = signal.given_unit("pressure", "", "kPa", "here")
    assert factor == pytest.approx(7.50062, rel=1e-5)
    assert notes == ()
    factor, notes = signal.given_unit("flow", "ml/s", "ml/min", "here")
    assert factor == pytest.approx(1 / 60)
    assert [one.code for one in notes] == ["recording.unit-replaced"]
    with pytest.raises(InputError, match="here: flow has no unit; give it"):
        signal.given_unit("flow", "", None, "here")


def test_rows_that_come_in_blocks_and_one_by_one_keep_order_and_lines():
    rows = number_rows.NumberRows("f.csv", ["a", "b"], ",")
    assert rows.add_block(3, ["1,10", "2,20"], False)
    assert rows.add_block(5, [], False)
    rows.add_row(5, ["3", ""], False)
    rows.add_row(9, ["4", "inf"], False)  # a remark stood between
    assert not rows.add_block(10, ["5,x"], False)
    assert not rows.add_block(10, ["5,50", ""], False)
    assert not rows.add_block(10, ["5,50,500"], False)
    assert rows.add_block(10, ["5,50", "6,60"], False)
    assert [rows.line(row) for row in range(6)] == [3, 4, 5, 9, 10, 11]
    assert rows.count == 6
    assert rows.take(0).tolist() == [1, 2, 3, 4, 5, 6]
    b = rows.take(1)
    assert b[[0, 1, 4, 5]].tolist() == [10, 20, 50, 60]
    assert np.isnan(b[2:4]).all()
    assert len(rows.take(1)) == 0


def test_many_single_rows_are_stored_in_order():
    rows = number_rows.NumberRows("f.csv", ["a"], None)
    for line in range(9000):
        rows.add_row(line + 1, [f"{line},5"], True)
    assert rows.take(0).tolist() == [line + 0.5 for line in range(9000)]


def test_a_row_that_is_too_short_or_too_long_and_a_cell_that_is_no_number_are_named():
    rows = number_rows.NumberRows("f.csv", ["a", "b"], ",")
    with pytest.raises(InputError, match="line 2: 3 columns below a header of 2; if title lines stand above"):
        rows.add_row(2, ["1", "2", "3"], False)
    rows.add_row(2, ["1", "2"], False)
    with pytest.raises(InputError, match="line 3: 3 columns where 2 were expected; surplus values"):
        rows.add_row(3, ["1", "2", "3"], False)
    with pytest.raises(InputError, match="line 3: 1 columns where 2 were expected; missing values"):
        rows.add_row(3, ["1"], False)
    with pytest.raises(InputError, match=r"line 3, column 'b': 'x' is not a number$"):
        rows.add_row(3, ["1", "x"], False)
    with pytest.raises(InputError, match="'12:30:01' is not a number; a time of day is not read"):
        rows.add_row(3, ["1", "12:30:01"], False)
    with pytest.raises(InputError, match="'1,5' is not a number"):
        rows.add_row(3, ["1", "1,5"], False)


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
