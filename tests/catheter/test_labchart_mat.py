"""LabChart's MATLAB export: closed intervals counted from 1, empty channels, units by map, rates by channel."""

import numpy as np
import pytest
from scipy.io import savemat

from vasowave.base import InputError
from vasowave.catheter.read import read_raw_recording

RATE = 2000.0
TIME = np.arange(3000) / RATE
PRESSURE = 14 + 5 * np.sin(2 * np.pi * 9 * TIME)
FLOW = 12 + 12 * np.sin(2 * np.pi * 9 * TIME)
ECG = np.cos(2 * np.pi * 9 * TIME) ** 31


def export(path, **changes):
    """Two blocks: the first of 0.1 s with an empty ECG, the second whole, flow at half the rate."""
    parts = [PRESSURE[:200], FLOW[:200:2], PRESSURE, FLOW[::2], ECG / 1000]
    ends = np.cumsum([len(part) for part in parts]).astype(float)
    starts = np.append(1.0, ends[:-1] + 1)
    variables = {
        "data": np.concatenate(parts)[None, :],
        "datastart": np.array([[starts[0], starts[2]], [starts[1], starts[3]], [-1, starts[4]]]),
        "dataend": np.array([[ends[0], ends[2]], [ends[1], ends[3]], [-1, ends[4]]]),
        "titles": np.array(["PA pressure", "Flow       ", "ECG        "]),
        "samplerate": np.array([[RATE, RATE], [RATE / 2, RATE / 2], [0, RATE]]),
        "unittext": np.array(["mmHg  ", "ml/min", "V     "]),
        "unittextmap": np.array([[1.0, 1.0], [2.0, 2.0], [-1.0, 3.0]]),
        "tickrate": np.array([[RATE, RATE]]),
        "blocktimes": np.array([[737774.4, 737774.5]]),
        "com": np.array([[-1.0, 1, 20, 1, 1], [2.0, 2, 800, 1, 2]]),
        "comtext": np.array(["start       ", "probe moved "]),
    }
    savemat(path, {key: value for key, value in (variables | changes).items() if value is not None})
    return path


def test_the_longest_block_reads_back_to_the_last_sample(tmp_path):
    raw = read_raw_recording(export(tmp_path / "raw.mat"))
    np.testing.assert_allclose(raw.pressure, PRESSURE[: len(raw.pressure)], atol=1e-12)
    np.testing.assert_allclose(raw.flow[::2], FLOW[: len(raw.flow) : 2] / 60, atol=1e-12)
    np.testing.assert_allclose(raw.flow, FLOW[: len(raw.flow)] / 60, atol=1e-5)
    assert raw.ecg is not None
    np.testing.assert_allclose(raw.ecg, ECG[: len(raw.ecg)], atol=1e-12)
    assert len(raw.pressure) == 2999  # the last flow sample stands at 2998 / RATE
    assert raw.sampling_rate == RATE
    assert any("'Flow' was interpolated" in str(note) for note in raw.notes)
    assert [(c.time, c.text, c.channel) for c in raw.comments] == [(0.4, "probe moved", 2)]


def test_sixteen_bit_data_take_their_scale(tmp_path):
    counts = np.rint(np.concatenate([PRESSURE, FLOW, ECG]) * 500).astype(np.int16)
    path = export(
        tmp_path / "raw.mat",
        data=counts[None, :] + np.int16(100),
        datastart=np.array([[1.0], [3001.0], [-1.0]]),
        dataend=np.array([[3000.0], [6000.0], [-1.0]]),
        samplerate=np.full((3, 1), RATE),
        unittextmap=np.array([[1.0], [2.0], [-1.0]]),
        scaleunits=np.full((3, 1), 1 / 500),
        scaleoffset=np.full((3, 1), -100.0),
        com=None,
    )
    raw = read_raw_recording(path)
    np.testing.assert_allclose(raw.pressure, PRESSURE, atol=1.1e-3)
    assert raw.ecg is None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"dataend": np.array([[200.0, 3300], [300, 4800.5], [-1, 7800]])},
            "block 2, channel 'Flow': samples .* to 4800",
        ),
        ({"dataend": np.array(["ab", "cd", "ef"])}, "dataend is not a table of numbers; export it again"),
        (
            {"samplerate": np.array([[RATE, RATE], [RATE / 2, 0], [0, RATE]])},
            "channel 'Flow': sampling rate 0",
        ),
        ({"comtext": None}, "the comments .* are damaged"),
        ({"samplerate": None}, "not a continuous recording exported by LabChart"),
        ({"dataend": np.full((3, 2), 1e6)}, "samples 1 to 1e"),
        ({"dataend": np.full((3, 2), np.inf)}, "samples 1 to inf of"),
        (
            {"samplerate": np.array([[RATE, RATE], [RATE, 5e-306], [0, RATE]])},
            r"'PA pressure' 1.5 s \(3000 samples at 2000 a second\) and 'Flow' inf s",
        ),
        ({"samplerate": np.array([[RATE, RATE], [RATE, RATE], [0, RATE]])}, r"'Flow' 0.75 s .* and 'ECG' 1.5 s"),
        ({"samplerate": np.full((2, 2), RATE)}, "samplerate has size 2 × 2, datastart 3 × 2"),
        ({"titles": np.array(["PA pressure"])}, "3 channels in datastart and 1 titles"),
        ({"com": np.ones((1, 3))}, "the comments .* are damaged"),
        ({"unittextmap": None}, "pressure has no unit; name its unit"),
    ],
)
def test_tables_that_contradict_each_other_are_refused(tmp_path, changes, message):
    with pytest.raises(InputError, match=message):
        read_raw_recording(export(tmp_path / "raw.mat", **changes))


def test_a_block_without_the_channel_says_what_it_has(tmp_path):
    with pytest.raises(InputError, match=r"no channel 'ECG'; it has: 'PA pressure' \[mmHg\]"):
        read_raw_recording(export(tmp_path / "raw.mat"), block=1, ecg="ECG")


def export_matrices(path, **changes):
    """Two blocks as the older export writes them, a matrix each: the second is the longer one."""
    variables = {
        "titles_block1": ["A"],
        "units_block1": [""],
        "data_block1": PRESSURE[None, :9],
        "ticktimes_block1": TIME[:9],
    }
    variables |= {
        "data_block2": np.array([PRESSURE, FLOW, ECG]), "ticktimes_block2": 60 + TIME[None, :],
        "titles_block2": np.array(["PA pressure", "Flow       ", "ECG        "]),
        "units_block2": np.array(["mmHg  ", "ml/min", "*     "]),
        "comtext_block2": np.array(["start       ", "probe moved "]), "comtick_block2": np.array([[1.0, 801.0]]),
        "comchan_block2": np.array([[-1.0, 2.0]]),
    }  # fmt: skip
    savemat(path, variables | changes)
    return path


def test_blocks_that_are_matrices_are_read_with_their_own_times_units_and_comments(tmp_path):
    raw = read_raw_recording(export_matrices(tmp_path / "raw.mat"))
    np.testing.assert_allclose(raw.pressure, PRESSURE, atol=1e-12)
    np.testing.assert_allclose(raw.flow, FLOW / 60, atol=1e-12)
    assert raw.sampling_rate == pytest.approx(RATE)
    assert [(c.time, c.text, c.channel) for c in raw.comments] == [
        (pytest.approx(0), "start", 0), (pytest.approx(0.4), "probe moved", 2)]  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"titles_block2": np.array(["PA pressure", "Flow       "])}, "block 2: its data, titles, times and comments"),
        ({"ticktimes_block2": TIME[:-1]}, "block 2: its data, titles, times and comments do not go together"),
        ({"comtick_block2": np.array([1.0, 9000.0])}, "block 2: its data, titles, times and comments"),
    ],
)
def test_a_matrix_whose_tables_contradict_each_other_is_refused(tmp_path, changes, words):
    with pytest.raises(InputError, match=words):
        read_raw_recording(export_matrices(tmp_path / "raw.mat", **changes))
