"""Files of recordings: only files are read, in bounded memory, and what they hold is said before anyone says it."""

import os
import time
import tracemalloc

import numpy as np
import pytest
from scipy.io import savemat

from vasowave.base import InputError
from vasowave.base.io import LONGEST_LINE, apart
from vasowave.catheter.read import describe_recording, read_raw_recording, read_recording

HEAD = "Interval=\t0.001 s\nChannelTitle=\tPAP\tFlow\tECG\nUnitName=\tmmHg\tml/s\tmV\n"
WAVE = np.sin(2 * np.pi * 9 * np.arange(1500) / 1000)


def export(path, repeats=1, tail="\n"):
    body = "\n".join(f"{14 + 5 * w:.5f}\t{0.2 + 0.2 * w:.5f}\t{w:.5f}" for w in WAVE)
    path.write_text(HEAD + "\n".join([body] * repeats) + tail)
    return path


@pytest.mark.parametrize("read", [read_raw_recording, read_recording, describe_recording])
def test_a_folder_a_pipe_and_a_device_are_refused_at_once(tmp_path, read):
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    begun = time.monotonic()
    with pytest.raises(InputError, match="is a pipe or a device"):
        read(pipe)
    with pytest.raises(InputError, match="is a pipe or a device"):
        read("/dev/zero")
    with pytest.raises(InputError, match="is a folder"):
        read(tmp_path)
    for kind in (".edf", ".mat"):
        os.mkfifo(tmp_path / f"pipe{kind}")
        with pytest.raises(InputError, match="is a pipe or a device"):
            read(tmp_path / f"pipe{kind}")
    assert time.monotonic() - begun < 5


@pytest.mark.validation
def test_a_recording_takes_at_most_four_times_the_memory_of_its_samples(tmp_path):
    path = export(tmp_path / "long.txt", repeats=80)
    fractions = []
    tracemalloc.start()
    try:
        raw = read_raw_recording(path, progress=fractions.append)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(raw.pressure) == 120_000
    size = 3 * raw.pressure.nbytes
    assert peak < 4 * size + 16e6  # a block of a megabyte, as lines and as numbers
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0
    assert len(fractions) > 2


def test_a_line_of_many_megabytes_is_refused_before_it_is_held(tmp_path):
    path = tmp_path / "line.txt"
    with path.open("w") as file:
        file.write(HEAD)
        for _ in range(20):
            file.write("1" * LONGEST_LINE)
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match="line 4: longer than 1000000 characters"):
            read_raw_recording(path)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()


def test_a_compressed_variable_that_inflates_without_end_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "bomb.mat"
    savemat(path, {"p": np.zeros(250_000_000, dtype=np.uint8)}, do_compression=True)
    assert path.stat().st_size < 1e6
    monkeypatch.setattr(apart, "MEMORY", 400 << 20)
    with pytest.raises(InputError, match="far more memory than the file is long"):
        read_recording(path, period=0.1)


def test_an_export_is_described_without_being_told_what_it_is(tmp_path):
    found = describe_recording(export(tmp_path / "raw.txt"))
    assert (found.format, found.kind) == ("labchart text", "raw")
    (block,) = found.blocks
    assert (block.sampling_rate, block.samples, block.duration) == pytest.approx((1000, 1500, 1.5))
    assert [(c.title, c.unit, c.quantity) for c in block.channels] == [
        ("PAP", "mmHg", "pressure"),
        ("Flow", "ml/s", "flow"),
        ("ECG", "mV", "ecg"),
    ]
    assert str(found) == (
        "LabChart text export, continuous: 1.5 s at 1000 samples/s; PAP [mmHg], Flow [ml/s], ECG [mV]"
    )


@pytest.mark.parametrize(
    ("step", "count", "kind"), [(0.001, 4000, "raw"), (0.001, 120, "cycle"), (None, 120, ""), (None, 4000, "")]
)
def test_a_table_is_a_cycle_or_continuous_by_its_times(tmp_path, step, count, kind):
    path = tmp_path / "c.csv"
    head = "pressure [mmHg];flow [ml/s]\n" if step is None else "time [s];pressure [mmHg];flow [ml/s]\n"
    times = [""] * count if step is None else [f"{i * step:.4f};" for i in range(count)]
    path.write_text((head + "".join(f"{t}{14 + i % 9};0.{i % 9}\n" for i, t in enumerate(times))).replace(".", ","))
    found = describe_recording(path)
    assert (found.format, found.kind) == ("table", kind)
    assert found.blocks[0].samples == count


def test_untitled_columns_and_matlab_variables_are_described(tmp_path):
    path = tmp_path / "p.dat"
    path.write_text("\n".join(f"{14 + w:.4f}" for w in WAVE[:128]) + "\n")
    found = describe_recording(path)
    assert (found.kind, found.blocks[0].samples, found.blocks[0].channels[0].title) == ("", 128, "")
    savemat(tmp_path / "c.mat", {"t": np.arange(128) / 1000, "P": 14 + WAVE[:128], "q": WAVE[:128], "P_unit": "mmHg"})
    found = describe_recording(tmp_path / "c.mat")
    assert (found.format, found.kind) == ("mat", "cycle")
    assert {c.quantity for c in found.blocks[0].channels} == {"pressure", "flow"}
