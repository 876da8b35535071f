"""EDF written byte by byte: every number of a header, a record and an annotation is known, and so is every refusal."""

import numpy as np
import pytest

from vasowave.errors import InputError
from vasowave.recording.formats.edf import _stretches, is_edf, read_edf

FLOW = ("Flow", "ml/min", -10, 60, -100, 250, 2)
PRESSURE = ("PA pressure", "mmHg", 0, 100, 0, 1000, 3)
NOTES = ("EDF Annotations", "", -1, 1, -32768, 32767, 20)


def header(signals, count, duration="0.5", size=None, number=None):
    number = len(signals) if number is None else number
    size = 256 * (len(signals) + 1) if size is None else size

    def field(value, width):
        return (value if isinstance(value, bytes) else str(value).encode()).ljust(width)[:width]

    first = [
        ("0", 8),
        ("", 80),
        ("", 80),
        ("", 8),
        ("", 8),
        (size, 8),
        ("", 44),
        (count, 8),
        (duration, 8),
        (number, 4),
    ]
    label, unit, low, high, bottom, top, samples = zip(*signals, strict=True)
    blank = [""] * len(signals)
    columns = [(label, 16), (blank, 80), (unit, 8), (low, 8), (high, 8), (bottom, 8), (top, 8), (blank, 80),
               (samples, 8), (blank, 32)]  # fmt: skip
    return b"".join([*(field(*one) for one in first), *(field(v, w) for values, w in columns for v in values)])


def lists(*entries):
    """Return the annotations of one record, 40 bytes."""
    return b"\0".join(one.encode() for one in entries).replace(b"|", b"\x14").replace(b"~", b"\x15").ljust(40, b"\0")


def numbers(*values):
    return np.array(values, "<i2").tobytes()


def written(tmp_path, content):
    path = tmp_path / "a.edf"
    path.write_bytes(content)
    return path


def refused(tmp_path, content):
    with pytest.raises(InputError) as error:
        read_edf(written(tmp_path, content))
    return str(error.value).partition("a.edf")[2]


def test_values_are_scaled_and_records_joined(tmp_path):
    """Of the flow a digital step is 70/350 = 0.2 and the digital 0 is 10; of the pressure a step is 0.1."""
    content = header([FLOW, PRESSURE], 2) + numbers(5, -100, 10, 20, 30) + numbers(250, 0, 40, 50, 1000)
    (block,) = read_edf(written(tmp_path, content))
    flow, pressure = block.channels
    assert flow.values.tolist() == pytest.approx([11, -10, 60, 10])
    assert pressure.values.tolist() == pytest.approx([1, 2, 3, 4, 5, 100])
    assert (flow.title, flow.unit, flow.sampling_rate) == ("Flow", "ml/min", 4.0)
    assert (pressure.title, pressure.unit, pressure.sampling_rate) == ("PA pressure", "mmHg", 6.0)
    assert flow.place.endswith("a.edf, channel 'Flow'")
    assert block.comments == ()


def test_a_number_of_records_that_is_not_known_is_that_of_the_file(tmp_path):
    (block,) = read_edf(written(tmp_path, header([FLOW], -1) + numbers(0, 1, 2, 3, 4, 5)))
    assert len(block.channels[0].values) == 6
    said = refused(tmp_path, header([FLOW], -1) + numbers(0, 1, 2))
    assert (
        said
        == ": the header states -1 records of 4 bytes, the file holds 1.5; it was cut off or damaged, export it again"
    )


def test_a_file_begins_with_version_0_and_has_a_whole_header():
    whole = b"0       " + bytes(248)
    assert is_edf(whole)
    assert not is_edf(whole[:255])
    assert not is_edf(b"0      x" + bytes(248))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (header([FLOW], 2) + numbers(1, 2, 3),
         ": the header states 2 records of 4 bytes, the file holds 1.5; it was cut off or damaged"),
        (header([FLOW], 1, size=512.5), ": number of bytes in the header is 512.5, not a whole number; the header is"),
        (header([FLOW, PRESSURE], 1, size=512), ": a header of 512 bytes for 2 signals in a file of 768; 768 are"),
        (header([FLOW], 1, number=0, size=256), ": a header of 256 bytes for 0 signals in a file of 512; 256 are"),
        (header([FLOW, PRESSURE], 1)[:700], ": a header of 768 bytes for 2 signals in a file of 700; 768 are needed"),
        (header([FLOW], 0), ": 0 data records in the header; there is nothing to read"),
        (header([FLOW], -2), ": -2 data records in the header; there is nothing to read"),
        (header([FLOW], "1_0"), ": number of data records is '1_0', not a number; the header is damaged"),
        (header([FLOW], 1, "-0.25"), ": a data record lasts -0.25 s; export it again"),
        (header([FLOW], 1, 0), ": a data record lasts 0 s, so the sampling rate is unknown; export it again"),
        (header([FLOW], 1, "inf"), ": duration of a data record is 'inf', not a number"),
        (header([FLOW, (*PRESSURE[:6], 0)], 1), ", signal 2 'PA pressure': 0 samples in a record; export it again"),
        (header([(*FLOW[:5], -100, 2)], 1), ", signal 1 'Flow': digital range -100 to -100; it must be increasing"),
        (header([(*FLOW[:4], -32769, 5, 2)], 1), ", signal 1 'Flow': digital range -32769 to 5; it must"),
        (header([(*FLOW[:4], 5, 32768, 2)], 1), ", signal 1 'Flow': digital range 5 to 32768; it must"),
        (header([(*FLOW[:2], 7, 7, 0, 9, 2)], 1), ", signal 1 'Flow': physical minimum and maximum are both 7;"),
        (header([(*FLOW[:2], "low", 7, 0, 9, 2)], 1), ", signal 1 'Flow': physical minimum is 'low', not a number"),
        (header([(*FLOW[:3], "high", 0, 9, 2)], 1), ", signal 1 'Flow': physical maximum is 'high', not a number"),
        (header([(*FLOW[:4], "a", 9, 2)], 1), ", signal 1 'Flow': digital minimum is 'a', not a number"),
        (header([(*FLOW[:5], "b", 2)], 1), ", signal 1 'Flow': digital maximum is 'b', not a number"),
        (header([(*FLOW[:6], "1.5")], 1), ", signal 1 'Flow': number of samples in a record is 1.5, not a whole"),
    ],
)  # fmt: skip
def test_a_header_that_contradicts_itself_is_refused_with_its_numbers(tmp_path, content, said):
    assert refused(tmp_path, content).startswith(said)


def test_limits_of_a_header_belong_to_what_is_read(tmp_path):
    wide = ("Flow", "", "0,5", 1.5, -32768, 32767, 1)
    (block,) = read_edf(written(tmp_path, header([wide], 1) + numbers(-32768)))
    assert block.channels[0].values.tolist() == [0.5]  # a decimal comma


def test_annotations_stand_in_the_stretch_and_at_the_time_of_their_record(tmp_path):
    """Records of 0.5 s from 3, 3.5 and 9 s: two stretches, and remarks count from the start of theirs."""
    records = [
        (numbers(1, 2), lists("+3||", "+3.25|clamp|open|", "+3.75~1.5|µ|")),
        (numbers(3, 4), lists("+3.5||", "+3.5|late|")),
        (numbers(5, 6), lists("+9||", "+9.125|end|", "+9.5|beyond|")),
    ]
    content = header([FLOW, NOTES], 3) + b"".join(map(b"".join, records))
    first, second = read_edf(written(tmp_path, content))
    assert first.channels[0].values == pytest.approx([10.2, 10.4, 10.6, 10.8])
    assert second.channels[0].values == pytest.approx([11.0, 11.2])
    assert len(first.channels) == 1
    assert [(c.time, c.text, c.channel) for c in first.comments] == [
        (0.25, "clamp", 0), (0.25, "open", 0), (0.75, "µ", 0), (0.5, "late", 0)
    ]  # fmt: skip
    assert [(c.time, c.text) for c in second.comments] == [(0.125, "end")]


def test_only_the_first_list_of_the_first_channel_of_annotations_says_when_a_record_begins(tmp_path):
    def times(*of_second):
        content = header([FLOW, NOTES, NOTES], 2)
        content += numbers(1, 2) + lists("+0||", "+7||") + lists("+8||")
        content += numbers(3, 4) + lists(*of_second) + lists("+6||")
        return [block.duration for block in read_edf(written(tmp_path, content))]

    assert times("+0.5||", "+20||") == [1.0]
    assert times("+2||") == [0.5, 0.5]
    assert times("+2|x|", "+3||") == [1.0]  # a remark, so the record follows at once


@pytest.mark.parametrize("entry", ["0.5||", "+||", "+0.5", "+1234567890123||", "+1e3||"])
def test_a_damaged_annotation_is_refused_with_its_record(tmp_path, entry):
    content = header([FLOW, NOTES], 2) + numbers(1, 2) + lists("+0||") + numbers(3, 4) + lists(entry)
    assert refused(tmp_path, content) == ", data record 2: a damaged annotation; export the file again"


def test_records_that_overlap_are_refused_and_those_that_touch_are_not(tmp_path):
    def content(onset):
        return header([FLOW, NOTES], 2) + numbers(1, 2) + lists("+0||") + numbers(3, 4) + lists(f"+{onset}||")

    assert refused(tmp_path, content(0.4999)).startswith(": data records overlap in time; the file is damaged")
    assert len(read_edf(written(tmp_path, content(0.5)))) == 1
    assert len(read_edf(written(tmp_path, content(0.50004)))) == 1
    assert len(read_edf(written(tmp_path, content(0.50006)))) == 2


def test_stretches_end_where_the_next_record_is_early_or_late():
    assert _stretches(np.array([0, 2.0, 4.0, 7.0, 9.0, 12.0]), 2.0) == [(0, 3), (3, 5), (5, 6)]
