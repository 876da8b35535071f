"""EDF and EDF+: files of an independent writer read back, and damaged ones are refused in words."""

import numpy as np
import pytest
from edfio import Edf, EdfAnnotation, EdfSignal
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vasowave.base import InputError
from vasowave.catheter.read import read_raw_recording
from vasowave.catheter.read.formats.edf import read_edf

RATE, SECONDS = 1000, 4
TIME = np.arange(RATE * SECONDS) / RATE
PRESSURE = 14 + 5 * np.sin(2 * np.pi * 9 * TIME)
FLOW = 12 + 12 * np.sin(2 * np.pi * 9 * TIME[::2])
ECG = 1e3 * np.cos(2 * np.pi * 9 * TIME) ** 31


def signals(pressure_unit="mmHg"):
    return [
        EdfSignal(PRESSURE, RATE, label="PA pressure", physical_dimension=pressure_unit, physical_range=(-10, 60)),
        EdfSignal(FLOW, RATE / 2, label="Flow", physical_dimension="ml/min", physical_range=(-50, 50)),
        EdfSignal(ECG, RATE, label="ECG II", physical_dimension="uV", physical_range=(-2000, 2000)),
    ]


def written(path, annotations=(), **options):
    Edf(signals(**options), annotations=annotations, data_record_duration=0.5).write(path)
    return path


def test_signals_of_several_rates_read_back_within_a_digital_step(tmp_path):
    raw = read_raw_recording(written(tmp_path / "raw.edf"))
    count = len(raw.pressure)
    assert raw.sampling_rate == RATE
    assert count == 2 * len(FLOW) - 1  # the last flow sample stands one sample before the end
    np.testing.assert_allclose(raw.pressure, PRESSURE[:count], atol=0.51 * 70 / 65535)
    np.testing.assert_allclose(60 * raw.flow[::2], FLOW, atol=0.51 * 100 / 65535)
    np.testing.assert_allclose(1e3 * raw.ecg, ECG[:count], atol=0.51 * 4000 / 65535)


def test_annotations_become_comments_at_their_times(tmp_path):
    remarks = [EdfAnnotation(0.25, None, "ventilator off"), EdfAnnotation(2.0, 0.5, "µ-probe moved")]
    block = read_edf(written(tmp_path / "raw.edf", remarks))[0]
    assert [channel.title for channel in block.channels] == ["PA pressure", "Flow", "ECG II"]
    assert [(c.time, c.text) for c in block.comments] == [(0.25, "ventilator off"), (2.0, "µ-probe moved")]
    raw = read_raw_recording(tmp_path / "raw.edf", start=1.0)
    assert [(c.time, c.text) for c in raw.comments] == [(2.0, "µ-probe moved")]  # those of the file


def test_an_edf_file_is_known_by_its_content_whatever_it_is_called(tmp_path):
    assert len(read_raw_recording(written(tmp_path / "raw.rec")).pressure) == 3999


def begun_later(path, later):
    """Let records of half a second begin so much later as `later` says of their onsets, which must be as long."""
    content = path.read_bytes()
    for onset, by in later.items():
        old, new = (f"+{at:g}\x14\x14\0".encode() for at in (onset, onset + by))
        assert content.count(old) == 1
        assert len(new) == len(old)
        content = content.replace(old, new)
    path.write_bytes(content)
    return path


def test_a_discontinuous_file_gives_a_block_for_every_stretch_with_its_remarks(tmp_path):
    remarks = [EdfAnnotation(0.25, None, "ventilator off"), EdfAnnotation(8.125, None, "end")]
    path = begun_later(written(tmp_path / "raw.edf", remarks), dict.fromkeys((2, 2.5, 3, 3.5), 6))
    first, second = read_edf(path)
    assert (first.duration, second.duration) == (2.0, 2.0)
    np.testing.assert_allclose(second.channels[0].values, PRESSURE[2000:], atol=0.51 * 70 / 65535)
    assert [(c.time, c.text) for c in first.comments] == [(0.25, "ventilator off")]
    assert [(c.time, c.text) for c in second.comments] == [(0.125, "end")]


def test_records_that_overlap_are_refused(tmp_path):
    path = begun_later(written(tmp_path / "raw.edf"), {2.5: -0.1})
    with pytest.raises(InputError, match="data records overlap in time; the file is damaged"):
        read_edf(path)


@pytest.mark.parametrize("entry", [b"0.5\x14\x14", b"+\x14\x14", b"+1e3\x14\x14"])
def test_a_damaged_annotation_is_refused_with_its_record(tmp_path, entry):
    path = written(tmp_path / "raw.edf")
    path.write_bytes(path.read_bytes().replace(b"+0.5\x14\x14\0", entry.ljust(7, b"\0")))
    with pytest.raises(InputError, match="data record 2: a damaged annotation; export the file again"):
        read_edf(path)


def test_a_number_of_records_that_is_not_known_is_that_of_the_file(tmp_path):
    path = written(tmp_path / "raw.edf")
    content = bytearray(path.read_bytes())
    content[236:244] = b"-1".ljust(8)
    path.write_bytes(content)
    assert len(read_edf(path)[0].channels[0].values) == len(PRESSURE)


@pytest.mark.parametrize(
    ("offset", "field", "message"),
    [
        (0, b"1", "not an EDF file"),
        (184, b"512     ", "a header of 512 bytes for 4 signals"),
        (236, b"9       ", "states 9 records .* the file holds 8;"),
        (236, b"0       ", "0 data records in the header; there is nothing to read"),
        (236, b"1_0     ", "number of data records is '1_0', not a number"),
        (244, b"-0.25   ", "a data record lasts -0.25 s"),
        (244, b"half    ", "duration of a data record is 'half'"),
        (244, b"0       ", "a data record lasts 0 s"),
        (252, b"1e9 ", "a header of"),
        (252, b"\xff\xfe  ", "number of signals is"),
    ],
)
def test_a_damaged_header_is_refused_with_its_field(tmp_path, offset, field, message):
    path = written(tmp_path / "raw.edf", [EdfAnnotation(0.25, None, "x")])
    content = bytearray(path.read_bytes())
    content[offset : offset + len(field)] = field
    path.write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_raw_recording(path)


@pytest.mark.parametrize(
    ("field", "index", "value", "message"),
    [
        (104, 0, b"60      ", r"signal 1 'PA pressure': physical minimum and maximum are both 60"),
        (120, 1, b"40000   ", r"signal 2 'Flow': digital range 40000 to 32767"),
        (120, 1, b"32767   ", r"signal 2 'Flow': digital range 32767 to 32767"),
        (120, 0, b"-32769  ", r"signal 1 'PA pressure': digital range -32769 to 32767"),
        (128, 0, b"32768   ", r"signal 1 'PA pressure': digital range -32768 to 32768"),
        (104, 0, b"low     ", r"signal 1 'PA pressure': physical minimum is 'low', not a number"),
        (216, 1, b"1.5     ", r"signal 2 'Flow': number of samples in a record is 1\.5, not a whole"),
        (216, 2, b"0       ", r"signal 3 'ECG II': 0 samples in a record"),
    ],
)
def test_a_signal_that_cannot_be_scaled_is_named(tmp_path, field, index, value, message):
    path = written(tmp_path / "raw.edf")
    content, count = bytearray(path.read_bytes()), 4  # the writer adds one for annotations
    at = 256 + field * count + 8 * index
    content[at : at + 8] = value
    path.write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_raw_recording(path)


def test_a_truncated_file_is_refused_with_what_it_holds(tmp_path):
    path = written(tmp_path / "raw.edf")
    path.write_bytes(path.read_bytes()[:-1000])
    with pytest.raises(InputError, match=r"states 8 records of 2508 bytes, the file holds 7.6013; it was cut off"):
        read_raw_recording(path)


def test_a_pressure_in_volts_is_refused_until_its_unit_is_given(tmp_path):
    path = written(tmp_path / "raw.edf", pressure_unit="mV")
    with pytest.raises(InputError, match="pressure is in mV"):
        read_raw_recording(path)
    assert read_raw_recording(path, pressure_unit="mmHg").pressure.max() == pytest.approx(19, abs=0.01)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_corrupt_file_is_read_or_refused_in_words(tmp_path, data):
    sound = tmp_path / "sound.edf"
    if not sound.exists():
        written(sound, [EdfAnnotation(0.25, None, "ventilator off")])
    content = bytearray(sound.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, 1400) | st.integers(0, len(content) - 1))
        junk = data.draw(st.binary(min_size=1, max_size=9))
        content[at : at + len(junk)] = junk
    cut = data.draw(st.integers(0, 3) | st.integers(0, len(content)))
    (tmp_path / "damaged.edf").write_bytes(content[: len(content) - cut])
    try:
        raw = read_raw_recording(tmp_path / "damaged.edf")
    except InputError:
        return
    assert np.isfinite(raw.pressure).all()
    assert np.isfinite(raw.sampling_rate)
