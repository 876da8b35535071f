"""LabChart's exports written by hand: which cell, line, block, channel and time each reading and each refusal names."""

import numpy as np
import pytest
from scipy.io import savemat

from vasowave.errors import InputError
from vasowave.recording.formats.labchart_mat import read_labchart_mat
from vasowave.recording.formats.labchart_text import _comments, _interval, _units, is_labchart_text, read_labchart_text

HEAD = "Interval=\t0.01 s\nChannelTitle=\tPAP\tFlow\nUnitName=\tmmHg\tml/s\n"


def text(tmp_path, content):
    path = tmp_path / "a.txt"
    path.write_bytes(content.encode("cp1252"))
    return path


def refused(tmp_path, content):
    with pytest.raises(InputError) as error:
        read_labchart_text(text(tmp_path, content))
    return str(error.value).partition("a.txt")[2]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", ": the file is empty"),
        ("\n \n", ": the file is empty"),
        ("\nabc\n", ", line 2: a LabChart text export starts with 'Interval='; export it again"),
        ("\nRange=\t1 V\n", ", line 2: 'Range=' before 'Interval='; export with its header"),
        ("Interval=\t0.01 s\n0\t1\t2\n", ", block 1, line 1: the header has no 'ChannelTitle='; tick channel titles"),
        (HEAD + "0\t1\t2\t3\n", ", block 1, line 4: 4 columns under 2 channel titles"),
        (HEAD + "1\n", ", block 1, line 4: 1 columns under 2 channel titles"),
        (HEAD + "0\t1\t2\n0.01\t3\n", ", block 1, line 5: 2 columns where 3 were expected; missing values: the line"),
        (HEAD + "0\t1\t2\n0.01\t3\t4\t5\n", ", block 1, line 5: 4 columns where 3 were expected; surplus values"),
        (HEAD + "0\t1\t2\n0.01\t3\tx\n", ", block 1, line 5, column 'Flow': 'x' is not a number"),
        (HEAD + "0\t1\t2\n\n" + HEAD + "0\t1\t2\n0.01\t\tx\n", ", block 2, line 10, column 'Flow': 'x' is not a"),
        (HEAD + "0\t1\t2\n0.01\t1\t2\n0.1\t1\t2\n0.11\t1\t2\n", ", block 1, line 6: time advances by 0.09 s, the"),
        (HEAD.replace("0.01 s", "0.01") + "0\t1\t2\n", ", block 1, line 1: 'Interval= 0.01' is not a sampling"),
        ("\n" + HEAD.replace("0.01 s", "0 s") + "0\t1\t2\n", ", block 1, line 2: 'Interval= 0 s' is not a sampling"),
        (HEAD + "0\t1,5\t2\n0.01\t1\t2\n", ", line 4: numbers with a decimal comma and with a decimal point in one"),
    ],
)  # fmt: skip
def test_an_export_that_contradicts_itself_is_refused_with_block_and_line(tmp_path, content, said):
    assert refused(tmp_path, content).startswith(said)


def test_times_that_are_all_a_little_long_are_refused_by_what_they_cover(tmp_path):
    """Each of 400 steps is 0.4 % long: none is a leap, but the whole lasts 4.016 s in place of 4."""
    rows = "".join(f"{0.01004 * i:.5f}\t{i % 7}\t1\n" for i in range(401))
    assert refused(tmp_path, HEAD + rows).startswith(
        ", block 1: the times cover 4.016 s, the samples 4 s; export at the full rate"
    )
    right = "".join(f"{0.010007 * i:.5f}\t{i % 7}\t1\n" for i in range(401))  # 4.003 s: within a step and a thousandth
    assert len(read_labchart_text(text(tmp_path, HEAD + right))[0].channels[0].values) == 401


def test_blocks_with_their_units_rates_gaps_and_remarks(tmp_path):
    second = 'Interval=\t20 ms\nChannelTitle=\t"P, ventricle"\tq \t\t\nUnitName=\t*\t\nRange=\t10.000 mV\t5 V\n'
    path = text(
        tmp_path,
        HEAD + "0\t1\t2\t#2 clamp\t#* all\n0.01\t3\t\n0.02\t5\tNaN\t#open\n" + "0.03\t7\t8\t\t\n"
        + second + "1\t2\n3\t4\t#1 end\n"
        + HEAD,
    )  # fmt: skip
    one, two = read_labchart_text(path)
    pressure, flow = one.channels
    assert pressure.values.tolist() == [1, 3, 5, 7]
    assert flow.values.tolist() == pytest.approx([2, np.nan, np.nan, 8], nan_ok=True)
    assert (pressure.title, pressure.unit, pressure.sampling_rate) == ("PAP", "mmHg", pytest.approx(100))
    assert flow.place.endswith("a.txt, block 1, channel 'Flow'")
    assert [(c.time, c.text, c.channel) for c in one.comments] == [(0, "clamp", 2), (0, "all", 0), (0.02, "open", 0)]
    assert [(c.title, c.unit, c.sampling_rate) for c in two.channels] == [
        ("P, ventricle", "mV", pytest.approx(50)), ("q", "V", pytest.approx(50))
    ]  # fmt: skip
    assert [c.values.tolist() for c in two.channels] == [[1, 3], [2, 4]]
    assert [(c.time, c.text, c.channel) for c in two.comments] == [(0.02, "end", 1)]
    assert (one.suspicions, two.suspicions) == ((), ())


def test_samples_stand_where_their_times_say_and_so_do_remarks(tmp_path):
    """Of 250 samples the time leaps once, over three that are missing after the 200th."""
    times = [i + 3 * (i >= 200) for i in range(250)]
    rows = "".join(
        f"{0.01 * at:.2f}\t{i}\t1{chr(9) + '#1 here' if i in (0, 220) else ''}\n" for i, at in enumerate(times)
    )
    (block,) = read_labchart_text(text(tmp_path, HEAD + rows))
    values = block.channels[0].values
    assert len(values) == 253
    assert np.flatnonzero(np.isnan(values)).tolist() == [200, 201, 202]
    assert values[203:].tolist() == list(range(200, 250))
    assert [c.time for c in block.comments] == pytest.approx([0.0, 2.23])


def test_times_of_day_leave_the_interval_alone_to_count(tmp_path):
    rows = "10:00:00.00\t1\t2\n10:00:07.00\t3\t4\n"
    (block,) = read_labchart_text(text(tmp_path, HEAD + rows))
    assert [c.values.tolist() for c in block.channels] == [[1, 3], [2, 4]]


def test_a_last_row_without_a_line_end_is_left_out_and_said(tmp_path):
    (block,) = read_labchart_text(text(tmp_path, HEAD + "0\t1\t2\n0.01\t3\t4"))
    assert block.channels[1].values.tolist() == [2]
    (said,) = block.suspicions
    assert "its last row was left out" in str(said)
    (alone,) = read_labchart_text(text(tmp_path, HEAD + "0\t1\t2"))  # its only one: a file need not end so
    assert alone.channels[1].values.tolist() == [2]
    assert alone.suspicions == ()


@pytest.mark.parametrize(
    ("start", "known"),
    [
        (b"Interval=\t1 s", True),
        (b" \r\n\tInterval=", True),
        (b"\xef\xbb\xbfInterval=", True),
        ("Interval=".encode("utf-16"), True),
        (b"\xfe\xff" + "Interval=".encode("utf-16-be"), True),
        (b"time\nInterval=", False),
        (b" " * 4090 + b"Interval=", False),  # beyond the 4096 bytes that are looked at
        (b" " * 4087 + b"Interval=", True),
    ],
)
def test_a_text_export_is_known_by_its_first_line(start, known):
    assert is_labchart_text(start) is known


@pytest.mark.parametrize(
    ("cells", "interval"),
    [(["", "0.5 ms"], 5e-4), (["", "2", "s"], 2.0), (["", "0,001 s"], 1e-3), (["", " 250 µs "], 2.5e-4)],
)
def test_an_interval_has_a_number_and_a_unit(cells, interval):
    assert _interval("here", cells) == pytest.approx(interval)


@pytest.mark.parametrize("written", ["-1 s", "nan s", "inf s", "1 mmhg", "s", "1.2.3 s", "1e-310 s", ""])
def test_an_interval_that_gives_no_rate_is_refused(written):
    with pytest.raises(InputError, match=f"^here: 'Interval= {written}' is not a sampling interval"):
        _interval("here", ["", written])


def test_a_channel_without_a_conversion_has_the_unit_of_its_range():
    header = {"UnitName": ["", "mmHg", "*", "", " ml/s "], "Range": ["", "10 V", "20.000 mV", "5.0 V", "2 V", "1 V"]}
    assert _units(header, 6) == ["mmHg", "mV", "V", "ml/s", "V", ""]
    assert _units({"Range": ["", "10", "3 mV"]}, 2) == ["", "mV"]


def test_remarks_of_one_row_are_told_apart_by_their_channels():
    told = [(c.time, c.text, c.channel) for c in _comments(["#* one", "goes on", " #12 two", "#three"], 2.5)]
    assert told == [(2.5, "one\tgoes on", 0), (2.5, "two\t#three", 12)]
    assert [(c.text, c.channel) for c in _comments(["# 3 flush"], 1.0)] == [("3 flush", 0)]
    assert _comments(["#1234567 x"], 0.0)[0].channel == 123456


TABLES = {
    "data": np.arange(1.0, 12.0)[None, :],
    "datastart": np.array([[1.0, 4.0], [6.0, -1.0], [8.0, 10.0]]),
    "dataend": np.array([[3.0, 5.0], [7.0, -1.0], [9.0, 11.0]]),
    "titles": np.array(["P ", "Q ", "E "]),
    "samplerate": np.array([[100.0, 200.0], [300.0, 0.0], [400.0, 500.0]]),
    "unittext": np.array(["mmHg", "*   ", "V   "]),
    "unittextmap": np.array([[1.0, 3.0], [2.0, -1.0], [4.0, 0.0]]),
    "tickrate": np.array([[10.0, 20.0]]),
    "com": np.array([[-1.0, 1, 5, 1, 2], [3.0, 2, 30, 1, 1], [2.0, 2, 40, 1, 3]]),
    "comtext": np.array(["first ", "second"]),
}


def mat(tmp_path, **changes):
    path = tmp_path / "a.mat"
    savemat(path, {key: value for key, value in (TABLES | changes).items() if value is not None})
    return path


def test_every_channel_of_every_block_has_its_samples_unit_and_rate(tmp_path):
    one, two = read_labchart_mat(mat(tmp_path))
    told = [[(c.title, c.unit, c.sampling_rate, c.values.tolist()) for c in block.channels] for block in (one, two)]
    assert told == [
        [("P", "mmHg", 100, [1, 2, 3]), ("Q", "", 300, [6, 7]), ("E", "", 400, [8, 9])],
        [("P", "V", 200, [4, 5]), ("E", "", 500, [10, 11])],
    ]
    assert two.channels[1].place.endswith("a.mat, block 2, channel 'E'")
    assert [(c.time, c.text, c.channel) for c in one.comments] == [(0.5, "second", 0)]
    assert [(c.time, c.text, c.channel) for c in two.comments] == [(1.5, "first", 3), (2.0, "", 2)]


def test_sixteen_bits_are_shifted_then_scaled_by_the_tables_of_their_channel_and_block(tmp_path):
    offset = np.array([[1.0, 2], [3, 4], [5, 6]])
    one, two = read_labchart_mat(mat(tmp_path, scaleoffset=offset, scaleunits=10 * offset))
    assert one.channels[1].values.tolist() == [(6 + 3) * 30, (7 + 3) * 30]
    assert two.channels[1].values.tolist() == [(10 + 6) * 60, (11 + 6) * 60]
    (alone, _) = read_labchart_mat(mat(tmp_path, scaleoffset=offset))  # without units it is not of use
    assert alone.channels[1].values.tolist() == [6, 7]


def changed(name, channel, block, value):
    table = TABLES[name].copy()
    table[channel, block] = value
    return {name: table}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"datastart": None, "titles": None}, ": not a continuous recording exported by LabChart (no datastart,"),
        ({"titles": np.array(["P", "Q"])}, ": 3 channels in datastart and 2 titles; export it again"),
        (changed("dataend", 1, 0, 12), ", block 1, channel 'Q': samples 6 to 12 of 11; the file is damaged"),
        (changed("datastart", 2, 1, 0), ", block 2, channel 'E': samples 0 to 11 of 11; the file is damaged"),
        (changed("datastart", 0, 1, 6), ", block 2, channel 'P': samples 6 to 5 of 11; the file is damaged"),
        (changed("datastart", 0, 1, 4.5), ", block 2, channel 'P': samples 4.5 to 5 of 11; the file is damaged"),
        (changed("dataend", 0, 1, 4.5), ", block 2, channel 'P': samples 4 to 4.5 of 11; the file is damaged"),
        (changed("samplerate", 1, 0, 0), ", block 1, channel 'Q': sampling rate 0; export it again"),
        (changed("samplerate", 1, 0, np.inf), ", block 1, channel 'Q': sampling rate inf; export it again"),
        ({"samplerate": np.ones((3, 1))}, ": samplerate has size 3 × 1, datastart 3 × 2"),
        ({"dataend": np.array(["ab", "cd", "ef"])}, ": dataend is not a table of numbers; export it again"),
        ({"dataend": np.ones((3, 2, 2))}, ": dataend is not a table of numbers; export it again"),
        ({"com": np.ones((2, 4))}, ": the comments (com, comtext) are damaged; export it again without comments"),
        ({"com": np.array(["a"])}, ": the comments (com, comtext) are damaged; export it again without comments"),
        ({"comtext": None}, ": the comments (com, comtext) are damaged; export it again without comments"),
    ],
)  # fmt: skip
def test_tables_that_contradict_each_other_are_refused_with_their_numbers(tmp_path, changes, said):
    with pytest.raises(InputError) as error:
        read_labchart_mat(mat(tmp_path, **changes))
    assert str(error.value).partition("a.mat")[2].startswith(said)


@pytest.mark.parametrize(
    ("changes", "counts"),
    [({"com": None}, (0, 0)), ({"tickrate": None}, (0, 0)), ({"tickrate": np.array([[10.0]])}, (1, 0)),
     ({"tickrate": np.array([[0.0, 20.0]])}, (0, 2)), ({"com": np.empty((0, 5))}, (0, 0))],
)  # fmt: skip
def test_remarks_without_times_are_left_out(tmp_path, changes, counts):
    assert tuple(len(block.comments) for block in read_labchart_mat(mat(tmp_path, **changes))) == counts


def test_a_channel_may_be_a_single_sample_and_end_with_the_data(tmp_path):
    ends = changed("datastart", 2, 1, 11)
    assert read_labchart_mat(mat(tmp_path, **ends))[1].channels[1].values.tolist() == [11]
