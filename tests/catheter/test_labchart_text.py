"""LabChart's text export: blocks, gaps and remarks, and which line and column each refusal names."""

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.catheter.read.formats.labchart_text import read_labchart_text

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
        (HEAD.replace("0.01 s", "nan s") + "0\t1\t2\n", ", block 1, line 1: 'Interval= nan s' is not a sampling"),
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
