"""Recorders' binary files: BDF by edfio's writer, WFDB by its manual, MATLAB files of AcqKnowledge by SciPy's."""

import os
import time

import numpy as np
import pytest
from scipy.io import savemat

from vasowave.base import InputError
from vasowave.catheter.read import describe_recording, read_raw_recording

RATE, COUNT = 500.0, 2000
TIME = np.arange(COUNT) / RATE
PRESSURE = 16.0 + 6.0 * np.sin(2 * np.pi * 2.5 * TIME) + 2.0 * np.cos(2 * np.pi * 5.0 * TIME)
FLOW = 40.0 + 45.0 * np.sin(2 * np.pi * 2.5 * TIME + 0.4)


def check(path, step_of_pressure, step_of_flow):
    raw = read_raw_recording(path)
    assert raw.sampling_rate == RATE
    assert np.abs(raw.pressure - PRESSURE).max() <= 0.51 * step_of_pressure
    assert np.abs(raw.flow - FLOW).max() <= 0.51 * step_of_flow
    return raw


def test_bdf_of_another_writer_is_read_with_all_of_its_24_bits(tmp_path):
    import edfio

    said = (("PAP", "mmHg", PRESSURE, (-50, 150)), ("Flow", "ml/s", FLOW, (-200, 200)))
    signals = [edfio.BdfSignal(values, RATE, label=name, physical_dimension=unit, physical_range=span)
               for name, unit, values, span in said]  # fmt: skip
    edfio.Bdf(signals, annotations=[edfio.EdfAnnotation(1.5, None, "sigh")]).write(tmp_path / "a.bdf")
    raw = check(tmp_path / "a.bdf", 200 / 2**24, 400 / 2**24)
    assert [(comment.time, comment.text) for comment in raw.comments] == [(1.5, "sigh")]


def wfdb(folder, form, content, lines, record="r 2 500 2000 10:00:00 05/04/2021"):
    (folder / "r.dat").write_bytes(content)
    signals = "".join(f"r.dat {form} {line}\n" for line in lines)
    (folder / "r.hea").write_text(f"# a comment\n{record}\n{signals}# 34 kg\n")
    return folder / "r.hea"


def counts(bits):
    """Return both signals in numbers that fill the bits, and what stands in the header of them."""
    gains = 2 ** (bits - 1) / 60.0, 2 ** (bits - 1) / 240.0
    baselines = -round(16 * gains[0]), -round(40 * gains[1])
    numbers = [np.rint(v * g).astype(int) + b for v, g, b in zip((PRESSURE, FLOW), gains, baselines, strict=True)]
    units = "mmHg", "mL/s"
    titles = "PAP", "Flow"
    lines = [f"{g!r}({b})/{u} {bits} 0 {n[0]} 0 0 {t}"
             for g, b, u, n, t in zip(gains, baselines, units, numbers, titles, strict=True)]  # fmt: skip
    return np.column_stack(numbers), lines, [1 / gain for gain in gains]


def packed(numbers):
    """Return numbers of 12 bits in pairs of three bytes, as signal(5) lays them out."""
    pairs = [(int(a) & 0xFFF, int(b) & 0xFFF) for a, b in numbers]
    return b"".join(bytes([a & 0xFF, (a >> 8) | ((b >> 8) << 4), b & 0xFF]) for a, b in pairs)


BYTES = {
    16: ("16", lambda numbers: numbers.astype("<i2").tobytes()),
    24: ("24", lambda numbers: b"".join(int(n).to_bytes(3, "little", signed=True) for n in numbers.ravel())),
    12: ("212", packed),
    8: ("80", lambda numbers: (numbers + 128).astype(np.uint8).tobytes()),
}


@pytest.mark.parametrize("bits", BYTES)
def test_a_wfdb_record_is_read_in_every_format_from_its_header_or_its_samples(tmp_path, bits):
    form, write = BYTES[bits]
    numbers, lines, steps = counts(bits)
    header = wfdb(tmp_path, form, write(numbers), lines)
    raw = check(header, *steps)
    assert np.array_equal(read_raw_recording(header.with_suffix(".dat")).flow, raw.flow)


def test_samples_of_a_record_that_change_are_read_again(tmp_path):
    numbers, lines, steps = counts(16)
    header = wfdb(tmp_path, "16", BYTES[16][1](numbers), lines)
    long_ago = time.time_ns() - 10**10  # else a file is read anew for its youth
    for file in tmp_path.iterdir():
        os.utime(file, ns=(long_ago, long_ago))
    check(header, *steps)
    header.with_suffix(".dat").write_bytes(BYTES[16][1](numbers // 2))
    os.utime(header.with_suffix(".dat"), ns=(long_ago + 10**9, long_ago + 10**9))
    assert np.ptp(read_raw_recording(header).pressure) == pytest.approx(np.ptp(PRESSURE) / 2, rel=1e-2)


def test_an_odd_number_of_twelve_bits_ends_a_record_and_a_skew_is_refused(tmp_path):
    numbers, lines, steps = counts(12)
    odd = np.column_stack([numbers, numbers[:, 0]])[:1999]
    pairs = np.append(odd.ravel(), 0).reshape(-1, 2)
    lines = [*lines, lines[0].replace("PAP", "again")]
    header = wfdb(tmp_path, "212", packed(pairs)[:-1], lines, "r 3 500 1999")
    assert np.abs(read_raw_recording(header).pressure - PRESSURE[:1999]).max() <= 0.51 * steps[0]
    header.write_text(header.read_text().replace("r.dat 212", "r.dat 212:20"))
    with pytest.raises(InputError, match="skewed, 20 frames late"):
        read_raw_recording(header)


def test_samples_of_a_wfdb_record_that_are_missing_are_gaps(tmp_path):
    numbers, lines, _ = counts(16)
    numbers[300:400, 0] = -32768
    header = wfdb(tmp_path, "16", numbers.astype("<i2").tobytes(), lines)
    with pytest.raises(InputError, match=r"0\.6.* to 0\.8"):
        read_raw_recording(header)


@pytest.mark.parametrize(
    ("form", "line", "record", "words"),
    [
        ("16", "200/mmHg 16 0 0 0 0 PAP", "r/3 2 500", "several segments; read one"),
        ("310", "200/mmHg 16 0 0 0 0 PAP", "r 2 500", "is not of a format that is read"),
        ("16", "200/mmHg 16 0 0 0 0 PAP", "r 2 500 9999", "copy it again"),
        ("16", "0 16 0 0 0 0 PAP", "r 2 500 2000", "counts"),
        ("16", "200/mmHg 16 0 0 0 0 PAP", "r 7 500 2000", "no sound header"),
        ("16", "200/mmHg 16 0 0 0 0 PAP", "r 2 1e999 2000", "no sound header"),
    ],
)
def test_a_wfdb_record_that_cannot_be_read_is_refused_in_words(tmp_path, form, line, record, words):
    numbers, lines, _ = counts(16)
    header = wfdb(tmp_path, form, numbers.astype("<i2").tobytes(), [line, lines[1]], record)
    with pytest.raises(InputError, match=words):
        read_raw_recording(header)


def test_a_wfdb_header_names_no_file_of_another_folder(tmp_path):
    _, lines, _ = counts(16)
    (tmp_path / "r.hea").write_text(f"r 1 500 2000\n../secret.dat 16 {lines[0]}\n")
    with pytest.raises(InputError, match="is not of a format"):
        read_raw_recording(tmp_path / "r.hea")


def test_matlab_files_of_acqknowledge_say_titles_units_and_interval(tmp_path):
    path = tmp_path / "a.mat"
    texts = np.array(["PA pressure", "PA flow    "]), np.array(["mmHg  ", "l/min "])
    savemat(path, {"data": np.column_stack([PRESSURE, FLOW * 0.06]), "labels": texts[0], "units": texts[1],
                   "isi": 2.0, "isi_units": "ms", "start_sample": 0.0})  # fmt: skip
    check(path, 1e-9, 1e-9)
    assert describe_recording(path).kind == "raw"


def test_matlab_files_of_acq2mat_hold_a_structure_a_channel(tmp_path):
    channels = np.empty(2, object)
    for place, (name, unit, values) in enumerate((("PAP", "mmHg", PRESSURE), ("Flow", "ml/s", FLOW))):
        channels[place] = {"name": name, "units": unit, "samples_per_second": RATE, "data": values,
                           "frequency_divider": 1}  # fmt: skip
    savemat(tmp_path / "a.mat", {"channels": channels, "samples_per_second": RATE})
    check(tmp_path / "a.mat", 1e-9, 1e-9)


def test_what_structures_say_of_themselves_says_nothing_of_the_signals_above_them(tmp_path):
    signals = {"pressure": PRESSURE, "flow": FLOW, "pressure_unit": "mmHg", "flow_unit": "ml/s"}
    beside = {"events": {"time": np.array([0.1, 0.2])}, "meta": {"video": {"fs": 30.0}},
              "info": {"samples": 2000.0, "unit": "mmHg"}}  # fmt: skip
    for name, clock in (("a.mat", {"fs": RATE}), ("b.mat", {"time": TIME})):
        savemat(tmp_path / name, signals | clock | beside)
        check(tmp_path / name, 1e-9, 1e-9)
    with pytest.raises(InputError, match="it says 500 samples/s, given are 1000"):
        read_raw_recording(tmp_path / "a.mat", sampling_rate=1000.0)


def test_a_structure_of_matlab_with_its_rate_asks_for_units_alone(tmp_path):
    savemat(tmp_path / "a.mat", {"rec": {"pressure": PRESSURE, "flow": FLOW, "fs": RATE}})
    with pytest.raises(InputError, match="has no unit"):
        read_raw_recording(tmp_path / "a.mat")
    raw = read_raw_recording(tmp_path / "a.mat", pressure_unit="mmHg", flow_unit="ml/s")
    assert raw.sampling_rate == RATE


def test_containers_of_other_programs_are_named_with_what_helps(tmp_path):
    (tmp_path / "a.bin").write_bytes(b"TDSm" + bytes(4000))
    (tmp_path / "a.pxp").write_bytes(b"\x00\x08" + bytes(4000))
    for name, word in (("a.bin", "LabVIEW TDMS"), ("a.pxp", "Igor Pro")):
        with pytest.raises(InputError, match=f"a file of {word}"):
            read_raw_recording(tmp_path / name)


def structure(title, unit, values, rate, **fields):
    """A channel as Spike2 exports it."""
    return {"title": title, "units": unit, "interval": 1 / rate, "values": values, "length": len(values), **fields}


def test_a_structure_a_channel_has_its_title_unit_and_rate(tmp_path):
    savemat(tmp_path / "a.mat", {
        "M_Ch1": structure("PAP", "mmHg", PRESSURE, RATE), "M_Ch2": structure("PA flow", "ml/s", FLOW[::2], RATE / 2),
        "M_Ch31": {"title": "Keyboard", "times": np.array([1.0, 2.0])}, "file": {"name": "M.smrx"},
    })  # fmt: skip
    raw = read_raw_recording(tmp_path / "a.mat")
    assert raw.sampling_rate == RATE
    count = len(raw.pressure)  # as long as both last
    assert count >= COUNT - 2
    assert np.abs(raw.pressure - PRESSURE[:count]).max() < 1e-9
    assert np.abs(raw.flow[::2] - FLOW[:count:2]).max() < 0.02 * np.ptp(FLOW)


def test_structures_within_a_structure_of_version_7_3_are_channels(tmp_path):
    import h5py

    with h5py.File(tmp_path / "a.mat", "w", userblock_size=512) as file:
        for name, unit, values in (("PAP", "mmHg", PRESSURE), ("flow", "ml/s", FLOW)):
            group = file.create_group(f"rec/{name}")
            for field, content, kind in (("data", values[None], "double"), ("fs", np.array([[RATE]]), "double"),
                                         ("unit", np.array([[ord(c)] for c in unit], "<u2"), "char")):  # fmt: skip
                group.create_dataset(field, data=content).attrs["MATLAB_class"] = np.bytes_(kind)
    content = bytearray((tmp_path / "a.mat").read_bytes())
    content[:19], content[124:128] = b"MATLAB 7.3 MAT-file", b"\x00\x02IM"
    (tmp_path / "a.mat").write_bytes(content)
    check(tmp_path / "a.mat", 1e-9, 1e-9)


def test_a_structure_whose_rate_contradicts_another_or_is_none_is_refused(tmp_path):
    channels = {"a": structure("PAP", "mmHg", PRESSURE, RATE, fs=250.0), "b": structure("flow", "ml/s", FLOW, RATE)}
    savemat(tmp_path / "a.mat", channels)
    with pytest.raises(InputError, match=r"channel 'PAP': different rates are said"):
        read_raw_recording(tmp_path / "a.mat")
    savemat(tmp_path / "b.mat", {"a": structure("PAP", "mmHg", PRESSURE, RATE) | {"interval": 0.0}})
    with pytest.raises(InputError, match="'0' is not a rate or interval between samples"):
        read_raw_recording(tmp_path / "b.mat")


@pytest.mark.parametrize("clock", [{"fs": RATE}, {"fs": RATE, "dt": np.float32(1 / RATE)}, {"time": TIME}])
def test_the_rate_of_a_structure_stands_in_it_or_around_it(tmp_path, clock):
    channels = [{"unit": unit, "data": values} for unit, values in (("mmHg", PRESSURE), ("ml/s", FLOW))]
    savemat(
        tmp_path / "a.mat", {"rec": dict(zip(("PAP", "flow"), (channel | clock for channel in channels), strict=True))}
    )
    check(tmp_path / "a.mat", 1e-9, 1e-9)
    if "time" not in clock:
        savemat(tmp_path / "b.mat", {"rec": dict(zip(("PAP", "flow"), channels, strict=True)) | clock})
        check(tmp_path / "b.mat", 1e-9, 1e-9)
        with pytest.raises(InputError, match=r"different rates are said \(500, 1000 samples/s\)"):
            read_raw_recording(tmp_path / "b.mat", sampling_rate=1000.0)


def test_structures_that_begin_apart_or_write_words_for_a_rate_are_refused(tmp_path):
    for fields, message in (({"start": 0.5}, "begin at different times"), ({"fs": "1 kHz"}, "'1 kHz' is not a rate")):
        channels = {"a": structure("PAP", "mmHg", PRESSURE, RATE, start=0.0),
                    "b": structure("flow", "ml/s", FLOW, RATE) | fields}  # fmt: skip
        savemat(tmp_path / "a.mat", channels)
        with pytest.raises(InputError, match=message):
            read_raw_recording(tmp_path / "a.mat")
