"""Signals in MATLAB variables, tables of numbers and single waves: every refusal with its place, every scale."""

import numpy as np
import pytest
from scipy.io import savemat

from vasowave.errors import InputError
from vasowave.io.columns import read_columns
from vasowave.recording.channels import Block, Channel
from vasowave.recording.formats.matlab_variables import read_cycle, read_variables
from vasowave.recording.formats.number_table import _rises_evenly, read_number_table
from vasowave.recording.gaps import (
    Span,
    describe_gaps,
    free_between,
    gaps_in,
    leaps_closed,
    longest_between,
    with_gaps,
)
from vasowave.recording.number_rows import DecimalMark, Lines, NumberRows
from vasowave.recording.read_raw import _at_rate, _check_lengths, _choose, _stretch
from vasowave.recording.signal import even_step, given_unit, written_to
from vasowave.recording.single_wave import single_wave


def saved(tmp_path, **variables):
    path = tmp_path / "a.mat"
    savemat(path, variables)
    return path


def said(function, *given):
    with pytest.raises(InputError) as error:
        function(*given)
    return str(error.value)


def test_vectors_of_a_file_are_channels_and_what_is_none_is_left_out(tmp_path):
    path = saved(
        tmp_path, P=np.array([[1.0, 2, 3, 4]]), P_unit="kPa", q=np.array([[5], [6], [7], [8]], "i2"), one=3.0,
        t=np.array([[0.0, 10, 20, 30]]), t_unit="ms", table=np.ones((2, 3)), short=np.ones(3), words="abc",
    )  # fmt: skip
    block = read_variables(path)
    told = [(c.title, c.unit, c.values.tolist(), c.sampling_rate) for c in block.channels]
    assert told == [("P", "kPa", [1, 2, 3, 4], pytest.approx(100)), ("q", "", [5, 6, 7, 8], pytest.approx(100))]
    assert block.channels[1].place.endswith("a.mat, variable 'q'")


def test_vectors_without_times_have_the_rate_that_is_given_or_none(tmp_path):
    path = saved(tmp_path, p=np.arange(3.0), q=np.arange(4.0))
    assert [c.sampling_rate for c in read_variables(path, 250.0).channels] == [250.0, 250.0]
    assert [len(c.values) for c in read_variables(path).channels] == [3, 4]
    assert np.isnan(read_variables(path).channels[0].sampling_rate)


def test_times_that_leap_leave_a_gap_between_the_samples(tmp_path):
    time = np.arange(201.0) + 2.0 * (np.arange(201) >= 150)
    (channel,) = read_variables(saved(tmp_path, time=1e-3 * time, p=np.arange(201.0))).channels
    assert np.flatnonzero(np.isnan(channel.values)).tolist() == [150, 151]
    assert channel.values[152:].tolist() == list(range(150, 201))
    assert channel.sampling_rate == pytest.approx(1000)


@pytest.mark.parametrize(
    ("variables", "words"),
    [
        ({"one": 3.0, "table": np.ones((2, 3))}, ": no vectors; it has: one, table"),
        ({"t": np.arange(4.0), "p": np.ones(3)}, ": no vectors; it has: t, p"),
        ({"t": np.array([0, 1, 1.5, 3, 4]), "p": np.ones(5)}, ", time(3), column 'time': uneven sampling, a step of"),
        ({"t": np.array([0, 2, 1.0]), "p": np.ones(3)}, ", time(3), column 'time': time does not increase"),
    ],
)  # fmt: skip
def test_a_file_without_signals_says_what_it_has(tmp_path, variables, words):
    assert said(read_variables, saved(tmp_path, **variables)).partition("a.mat")[2].startswith(words)


CYCLE = {"pressure": np.arange(4.0), "flow": np.ones(4), "time": np.array([0.0, 0.1, 0.2, 0.3])}
WANTED = {"pressure": None, "flow": None}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"pressure": np.array([1.0, 2, np.nan, 3])}, ": pressure(3) is nan (a gap); fill it before averaging"),
        ({"flow": np.array([1.0, 2, 3, np.inf])}, ": flow(4) is inf (a gap); fill it before averaging"),
        ({"time": np.array([0, np.nan, 2, 3])}, ": time(2) is nan (a gap); fill it before averaging"),
        ({"flow": np.ones(3)}, ": time has 4 samples and flow 3; leave time out and give the period if"),
        ({"P": np.ones(4)}, ": two variables hold pressure; keep one of them"),
        ({"Q": np.ones(4)}, ": two variables hold flow; keep one of them"),
        ({"T": np.ones(4)}, ": two variables hold time; keep one of them"),
        ({"flow": "abc"}, ": variable 'flow' is not a vector of real numbers"),
        ({"flow": np.ones((2, 2))}, ": variable 'flow' has size 2 × 2; it must be one row or one column"),
    ],
)
def test_a_cycle_in_variables_is_refused_with_variable_and_place(tmp_path, changes, words):
    assert said(read_cycle, saved(tmp_path, **(CYCLE | changes)), WANTED).partition("a.mat")[2].startswith(words)


def test_a_variable_that_is_not_there_is_named_with_those_that_are(tmp_path):
    words = said(read_cycle, saved(tmp_path, P=np.ones(4)), WANTED)
    assert words.endswith("a.mat: no variable 'flow'; it has: pressure")


def test_a_cycle_in_variables_has_units_times_and_their_rounding(tmp_path):
    path = saved(
        tmp_path, P=2.0 * np.ones(4), P_unit="kPa", q=60.0 * np.arange(4), t=np.arange(4, dtype="f4"), t_unit="ms"
    )
    pressure, flow = read_cycle(path, {"pressure": None, "flow": "ml/min"})
    assert pressure.values == pytest.approx(2 * 7.50062, rel=1e-5)
    assert (pressure.assumed_unit, flow.assumed_unit) == ("", "")
    assert flow.values == pytest.approx(np.arange(4))
    assert flow.time == pytest.approx([0, 1e-3, 2e-3, 3e-3])
    assert flow.quantum == pytest.approx(4 * np.finfo("f4").eps * 3e-3)
    assert flow.places[2].endswith("a.mat, flow(3)")
    (alone,) = read_cycle(saved(tmp_path, q=np.array([1, 2], "i4")), {"flow": None})
    assert (alone.assumed_unit, alone.time, alone.quantum) == ("ml/s", None, 0.0)
    (whole,) = read_cycle(saved(tmp_path, q=np.ones(3), t=np.arange(3)), {"flow": None})
    assert whole.quantum == pytest.approx(8 * np.finfo(float).eps)


def table(tmp_path, text):
    path = tmp_path / "a.csv"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("text", "rate", "words"),
    [
        ("pressure [mmHg],flow [ml/s]\n1,2\n3,4\n", None, ": no time column; say how many samples a second has"),
        ("x,flow\n0.5,2\n1.0,4\n1.5,4\n", None, ": no time column ('x' rises evenly: title it 'time [s]' if it is"),
        ("x,flow\n0.5,2\n1.0,4\n1.5,4\n", 1000.0, ": column 'x' rises evenly by 0.5, as a time does; title it 'time"),
        ("time,flow\n0.5,2\n1.0,4\n", None, ": column 'time' has no unit; write it in the header ('time [s]'), or say"),
        ("time [s],flow\n0.5,2\n", None, ": one sample only; a continuous recording is needed"),
        ("time [s],flow\n0.5,2\n,3\n1.5,4\n", None, ", line 3, column 'time': the cell is empty or no number"),
        ("time [s],flow\n0.0,2\n0.1,3\n0.2,4\n", 10.02, ": the time column has 10 samples/s, given are 10.02"),
        ("time [s],flow\n0.0,2\n0.1,3\n0.15,4\n0.3,4\n0.4,1\n", None, ", line 4, column 'time': uneven sampling, a"),
        ("time [s],zeit [s],flow\n0,0,2\n", None, ": two columns are called 'time'; keep one of them"),
        ("time [s],flow\n", None, ": a header and no data"),
        ("", None, ": the file is empty"),
        ("1,2\n3,4\n", None, ": no header; the first line must read: time [s],pressure [mmHg],flow [ml/s],ecg [mV]"),
        ("a;b\n1,5;2\n1;2.5\n", 9.0, ", line 3: numbers with a decimal comma and with a decimal point in one file"),
        ("a,b\n1,2\n3\n", 9.0, ", line 3: 1 columns where 2 were expected; missing values: the line was cut"),
        ("a,b\n1,2\n3,4,5\n", 9.0, ", line 3: 3 columns where 2 were expected; surplus values: the line was cut"),
        ("a,b\n3,4,5\n", 9.0, ", line 2: 3 columns below a header of 2; if title lines stand above"),
        ("a,b\n1,2\n\n# x\n3,q\n", 9.0, ", line 5, column 'b': 'q' is not a number"),
        ("a,b\n1,2\n3,10:00\n", 9.0, ", line 3, column 'b': '10:00' is not a number; a time of day is not read"),
    ],
)  # fmt: skip
def test_a_table_is_refused_with_line_column_and_cure(tmp_path, text, rate, words):
    assert said(read_number_table, table(tmp_path, text), rate).partition("a.csv")[2].startswith(words)


def test_a_rate_that_agrees_within_a_thousandth_is_that_of_the_times(tmp_path):
    path = table(tmp_path, "time [s],flow [ml/s],ekg\n0.0,2,1\n0.1,3,2\n0.2,,3\n")
    block = read_number_table(path, 10.009)
    assert [(c.title, c.unit, c.sampling_rate) for c in block.channels] == [
        ("flow", "ml/s", pytest.approx(10)), ("ekg", "", pytest.approx(10))
    ]  # fmt: skip
    assert block.channels[0].values == pytest.approx([2, 3, np.nan], nan_ok=True)
    untold = read_number_table(table(tmp_path, "time,flow\n0.5,2\n1.0,4\n1.5,4\n"), 500.0)  # whatever their unit
    assert [c.sampling_rate for c in untold.channels] == [pytest.approx(500)]
    assert np.isnan(read_number_table(table(tmp_path, "1,2\n3,4\n"), np.nan).channels[0].sampling_rate)


@pytest.mark.parametrize(
    ("values", "even"),
    [
        ([0, 0.5, 1.0], True), ([0, 0.5], False), ([0, 1, 2], False), ([1.0, 0.5, 0], False), ([0, 0.5, 1.13], False),
        ([0, 0.5, 1.09], True), ([0, 1.001, 2.002], True), ([0, 0, 0], False),
    ],
)  # fmt: skip
def test_what_rises_by_the_same_step_may_be_a_time(values, even):
    assert _rises_evenly(np.array(values, float)) is even


def test_rows_know_their_lines_whether_they_came_in_blocks_or_alone():
    rows = NumberRows("t", ["a", "b"], ",")
    assert rows.add_block(3, ["1,2", "3,4"], False)
    rows.add_row(6, ["5", " #N/A "], False)
    rows.add_row(7, ["inf", "nan"], False)
    assert rows.add_block(10, ["7,8"], False)
    assert not rows.add_block(11, ["7,8", "", "9,9"], False)
    assert not rows.add_block(11, ["7,8,9"], False)
    assert not rows.add_block(11, ["7,x"], False)
    assert rows.add_block(11, [], False)
    assert [rows.line(row) for row in range(5)] == [3, 4, 6, 7, 10]
    assert rows.count == 5
    assert rows.take(0) == pytest.approx([1, 3, 5, np.nan, 7], nan_ok=True)
    assert rows.take(1) == pytest.approx([2, 4, np.nan, np.nan, 8], nan_ok=True)
    assert NumberRows("t", ["a"], None).take(0).tolist() == []


def test_many_single_rows_are_kept_in_order(monkeypatch):
    monkeypatch.setattr("vasowave.recording.number_rows._TOGETHER", 3)
    rows = NumberRows("t", ["a"], None)
    for i in range(8):
        rows.add_row(i + 1, [f"{i},5"], True)
    assert rows.take(0).tolist() == [i + 0.5 for i in range(8)]


def test_the_first_decimal_mark_counts_and_a_second_is_refused_with_its_line():
    marks = DecimalMark("f")
    assert marks.comma(Lines(1, ["1;2"])) is False
    assert marks.comma(Lines(2, ["1,5;2"])) is True
    assert marks.comma(Lines(3, ["1;2"])) is True
    assert said(marks.comma, Lines(4, ["1;2", "3;4", "3.5;4"])).startswith("f, line 6: numbers with a decimal comma")
    clock = DecimalMark("f")
    clock.comma(Lines(1, ["1.5"]))
    assert said(clock.comma, Lines(7, ["10:01:02,5"])).startswith("f, line 7: '10:01:02,5' is not a number; a time of")


def test_gaps_are_spans_and_what_is_free_between_them():
    values = np.array([np.nan, 1, 2, np.nan, np.inf, 3, np.nan])
    assert gaps_in(values, 2.0) == (Span(0, 0.5), Span(1.5, 2.5), Span(3, 3.5))
    assert gaps_in(np.ones(3), 2.0) == ()
    gaps = [Span(4, 5), Span(1, 2), Span(1.5, 3)]
    assert free_between(gaps, 0, 9) == [Span(0, 1), Span(3, 4), Span(5, 9)]
    assert free_between(gaps, 1, 4) == [Span(3, 4)]
    assert free_between(gaps, 2.5, 4.5) == [Span(3, 4)]
    assert free_between([], 1, 2) == [Span(1, 2)]
    assert longest_between(gaps, 0, 8.9996) == Span(5, 8.999)
    assert longest_between([Span(0, 0.0004)], 0, 1) == Span(0.001, 1)
    assert longest_between([Span(0, 9)], 1, 2) == Span(1, 1)
    assert str(longest_between([], -0.0, 1).start) == "0.0"


def test_gaps_are_described_by_the_first_three_and_the_longest_stretch_without():
    gaps = [Span(9.5, 9.75), Span(2, 3), Span(3, 3.5), Span(5, 5.25), Span(8, 8.5), Span(0, 1)]
    told = describe_gaps(gaps, 1.0, 11, 1.0)
    assert told.startswith(
        "no samples from 2 to 3.5 s, 5 to 5.25 s, 8 to 8.5 s and 1 more; the longest stretch without"
    )
    assert "a gap is 5.25 to 8 s. Take it: vasowave add and fit: --start 5.25 --end 8; a study's table: 5.25 in" in told
    assert describe_gaps(gaps[3:4], 5, 6, 2.0) == "no samples from 5 to 5.25 s; no 2 s are without a gap"
    assert "--start 2.5 --end 4.5" in describe_gaps([Span(2, 2.5), Span(2.2, 2.4)], 2, 4.5, 2.0)
    assert "and 1 more" not in describe_gaps(gaps[:4], 0, 11, 1.0)


def test_leaps_of_the_time_are_seldom_and_not_too_far():
    steps = np.ones(201)
    steps[[50, 120]] = 3.0, 1.6
    time = np.append(0.0, np.cumsum(steps))
    closed, place = leaps_closed(time)
    assert closed == pytest.approx(np.arange(202))
    assert (place[50], place[51], place[121], place[-1]) == (50, 53, 124, 204)
    assert with_gaps(np.arange(202.0), place)[[50, 53]].tolist() == [50, 51]
    assert np.isnan(with_gaps(np.arange(202.0), place)[[51, 52, 123]]).all()
    assert leaps_closed(np.arange(9.0)) is None
    assert leaps_closed(np.arange(9.0)[::-1]) is None
    assert leaps_closed(np.ones(1)) is None
    assert leaps_closed(np.append(0.0, np.cumsum(np.r_[steps[:199], 2.0]))) is None  # three of 200 are not seldom
    far = np.ones(200)
    far[7] = 20 * 201 - 199
    assert leaps_closed(np.append(0.0, np.cumsum(far)))[1][-1] == 20 * 201
    far[7] += 1
    assert leaps_closed(np.append(0.0, np.cumsum(far))) is None


def test_even_steps_within_their_rounding():
    def place(row):
        return f"row {row}"

    assert even_step(np.array([1.0, 1.5, 2.0]), 0.0, "f", place) == 0.5
    assert even_step(np.array([0, 0.11, 0.2]), 0.02, "f", place) == pytest.approx(0.1)
    assert said(even_step, np.array([0, 1, 1, 0.5]), 0.0, "f", place).startswith("row 3, column 'time': time does not")
    assert said(even_step, np.array([1.0, 1, 1]), 0.0, "f", place).startswith("row 1, column 'time': time does not")
    words = said(even_step, np.array([0, 0.1, 0.2, 0.2]), 0.1, "f", place)
    assert words.startswith("f, column 'time': written to 0.1 s, coarser than the sampling interval (0.0667 s); write")
    assert even_step(np.array([0, 0.1, 0.2]), 0.1, "f", place) == pytest.approx(0.1)  # exact steps were not rounded
    words = said(even_step, np.array([0, 1, 2, 2.9, 4]), 0.01, "f", place)
    assert words.startswith(
        "row 3, column 'time': uneven sampling, a step of 0.9 s where the others have 1 s; resample"
    )


def test_the_last_digit_that_is_written_is_the_finest():
    assert written_to(["0.2", " 0.213 ", "x", "5"]) == pytest.approx(1e-3)
    assert written_to(["5", "200", "1e3"]) == 1.0
    assert written_to(["2.5e-3"]) == pytest.approx(1e-4)
    assert written_to(["nan", "inf", ""]) == 1.0
    assert written_to(["1e-400"]) == pytest.approx(1e-300)


def test_a_unit_that_is_given_replaces_the_one_that_is_stated_and_is_noted():
    assert given_unit("flow", "ml/min", None, "f") == (pytest.approx(1 / 60), ())
    assert given_unit("flow", "", "ml/min", "f") == (pytest.approx(1 / 60), ())
    factor, (note,) = given_unit("flow", "ml/min", "l/min", "f")
    assert factor == pytest.approx(1000 / 60)
    assert str(note).startswith("flow was taken to be in l/min, as given, although the file says ml/min")
    assert given_unit("flow", "ml/s", "ml/s", "f")[1] == ()
    assert said(given_unit, "pressure", "", None, "f") == "f: pressure has no unit; give it (pressure_unit='mmHg')"


@pytest.mark.parametrize(
    ("text", "values", "step"),
    [
        ("time [ms],flow [ml/min]\n0,60\n2,120\n4,0\n", [1, 2, 0], 2e-3),
        ("flow [ml/s]\n3\n4\n", [3, 4], None),
        ("something\n3\n4\n", [3, 4], None),
        ("zeit [s],x\n0,60\n2,120\n", [60, 120], 2.0),
        ("x,zeit [s]\n60,0\n120,2\n", [60, 120], 2.0),
        ("zeit [s],x [ml/min],y [mmHg]\n0,60,9\n2,120,8\n", [1, 2], 2.0),
        ("0,60\n2,120\n", [60, 120], 2.0),
        ("7\n8\n", [7, 8], None),
    ],
)
def test_the_only_signal_of_a_table_is_found_by_title_or_unit(tmp_path, text, values, step):
    found = single_wave(read_columns(table(tmp_path, text)), "flow", "flow", "ml/s")
    assert found.values == pytest.approx(values)
    assert found.step == (None if step is None else pytest.approx(step))
    cycle, lasts = found.cycle()
    assert len(cycle) == len(values)
    assert lasts == (None if step is None else pytest.approx(step * len(values)))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1,2,3\n1,2,3\n", ": 3 columns without titles; give time and flow, or titles with units"),
        ("a,b\n1,2\n", ": no column of time; the header has: a, b. Write the unit into its title, as in 'time [s]'"),
        ("time [s],a,b\n1,2,3\n", ": no column says that it is the flow, and not one alone has a unit of flow; the"),
        ("time [s],a [ml/s],b [ml/s]\n1,2,3\n", ": no column says that it is the flow, and not one alone"),
    ],
)
def test_a_table_of_one_signal_that_has_none_is_refused(tmp_path, text, words):
    path = table(tmp_path, text)
    assert said(single_wave, read_columns(path), "flow", "flow", "ml/s").partition("a.csv")[2].startswith(words)


def test_a_last_sample_that_is_the_first_again_is_left_out_where_the_wave_moves(tmp_path):
    rows = "".join(f"{i},{10 + 5 * np.sin(2 * np.pi * i / 200):.6f}\n" for i in range(201))
    values, lasts = single_wave(read_columns(table(tmp_path, "time [s],q\n" + rows)), "flow", "flow", "ml/s").cycle()
    assert (len(values), lasts) == (200, pytest.approx(200.0))


def channel(count, rate=1000.0, title="P"):
    return Channel(title, "mmHg", np.arange(float(count)), rate, f"f, channel '{title}'")


def test_channels_of_a_block_last_alike_within_a_hundredth_and_two_samples():
    _check_lengths([channel(1000), channel(1012, title="Q")])
    words = said(_check_lengths, [channel(1000), channel(1013, title="Q"), channel(1005)])
    assert words.startswith(
        "f, channel 'P': channels of one block last equally long, but 'P' 1 s (1000 samples at 1000 "
    )
    assert "and 'Q' 1.013 s (1013 samples at 1000 a second); export it again" in words
    _check_lengths([channel(100, 100.0), channel(1030)])
    assert "1.031 s" in said(_check_lengths, [channel(100, 100.0), channel(1031)])


def test_a_stretch_has_its_samples_and_lies_within():
    one = channel(100, 100.0)
    assert _stretch(one, one.values, 0.1, 0.153).tolist() == list(range(10, 15))
    assert _stretch(one, one.values, None, None).tolist() == list(range(100))
    assert _stretch(one, one.values, 0.99, None).tolist() == [99]
    assert said(_stretch, one, one.values, 0.5, 0.5).endswith(
        "the stretch ends at 0.5 s and starts at 0.5 s; exchange them"
    )
    assert said(_stretch, one, one.values, 0.5, 1.02).endswith("'P': 0.5 to 1.02 s does not lie in 0 to 1 s")
    assert said(_stretch, one, one.values, None, 1.2).endswith("0 to 1.2 s does not lie in 0 to 1 s")
    assert said(_stretch, one, one.values, 1.0, None).endswith("1 to 1 s does not lie in 0 to 1 s")
    assert said(_stretch, one, one.values, -0.02, None).endswith("-0.02 to 1 s does not lie in 0 to 1 s")


def test_slower_channels_are_interpolated_between_their_samples():
    slow = Channel("Q", "", np.arange(6.0) ** 2, 100.0, "f, Q")
    values, (note,) = _at_rate(slow.values, slow, 400.0)
    assert values == pytest.approx((np.arange(21) / 4) ** 2)
    assert str(note) == "'Q' was interpolated from 100 to 400 samples/s"
    assert _at_rate(slow.values, slow, 100.0 * (1 + 1e-10)) == (slow.values, [])
    assert len(_at_rate(slow.values[:4], slow, 400.0)[0]) == 13
    assert said(_at_rate, slow.values[:3], slow, 400.0) == "f, Q: 3 samples; a continuous recording is needed"


def test_of_several_blocks_the_longest_is_taken_and_told_with_all_lengths():
    blocks = [Block((channel(100),)), Block((channel(300),)), Block((channel(200),))]
    number, (note,) = _choose("f", blocks, None)
    assert (number, str(note)) == (1, "block 2 of 3 was read, the longest (blocks last 0.1 s, 0.3 s, 0.2 s)")
    assert _choose("f", blocks, 3) == (2, [])
    assert _choose("f", blocks, 1) == (0, [])
    assert _choose("f", blocks[:1], None) == (0, [])
    assert said(_choose, "f", blocks, 4) == "f: no block 4; it has 3"
    assert said(_choose, "f", blocks, 0) == "f: no block 0; it has 3"
