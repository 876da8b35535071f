"""Recordings in files of NumPy, JSON and Igor's text, by the numbers that went into them."""

import json

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.catheter.read import describe_recording, read_raw_recording, read_recording

TIME = np.arange(4000) / 1000.0
PRESSURE = 15 + 5 * np.cos(2 * np.pi * 9 * TIME)
FLOW = 12 + 9 * np.sin(2 * np.pi * 9 * TIME)  # ml/min
TABLE = {"time (s)": TIME.tolist(), "PAP (mmHg)": PRESSURE.tolist(), "PA flow (ml/min)": FLOW.tolist()}
ROWS = [list(row) for row in zip(*TABLE.values(), strict=True)]
CHANNELS = [{"name": "PAP", "unit": "mmHg", "data": PRESSURE.tolist()},
            {"name": "PA flow", "unit": "ml/min", "data": FLOW.tolist()}]  # fmt: skip
FORMS = {
    "columns": TABLE,
    "rows by number": {title: {str(i): value for i, value in enumerate(values)} for title, values in TABLE.items()},
    "objects": [dict(zip(TABLE, row, strict=True)) for row in ROWS],
    "objects by number": {str(i): dict(zip(TABLE, row, strict=True)) for i, row in enumerate(ROWS)},
    "objects beside a schema": {
        "schema": {"primaryKey": ["time (s)"]},
        "data": [dict(zip(TABLE, row)) for row in ROWS],
    },
    "a matrix beside labels": {"columns": list(TABLE), "index": list(range(len(ROWS))), "data": ROWS},
    "channels": {"fs": 1000, "channels": CHANNELS},
    "in an object": {"recording": {"samplingRate": 1000, **{title: TABLE[title] for title in list(TABLE)[1:]}}},
}


def is_read(path):
    recording = read_raw_recording(path)
    np.testing.assert_allclose(recording.pressure, PRESSURE)
    np.testing.assert_allclose(recording.flow, FLOW / 60)
    assert recording.sampling_rate == pytest.approx(1000.0)


@pytest.mark.parametrize("form", FORMS)
def test_json_in_the_forms_of_pandas_and_of_channels_is_read(tmp_path, form):
    (tmp_path / "a.json").write_text(json.dumps(FORMS[form]))
    is_read(tmp_path / "a.json")
    assert describe_recording(tmp_path / "a.json").kind == "raw"


def test_an_archive_of_numpy_is_read_by_the_names_of_its_arrays(tmp_path):
    np.savez(tmp_path / "a.npz", time_s=TIME, PAP_mmHg=PRESSURE, flow_mlmin=FLOW)
    is_read(tmp_path / "a.npz")
    titles, stated = np.array(["PAP", "PA flow"]), np.array(["mmHg", "ml/min"])
    np.savez_compressed(tmp_path / "b.npz", data=np.stack([PRESSURE, FLOW]), labels=titles, units=stated, fs=1000)
    is_read(tmp_path / "b.npz")


@pytest.mark.parametrize("above", ["[HEADER]\nDate=2026-03-01\n[DATA]\n", "{ rig 2 }\n"])
def test_a_table_whose_first_line_stands_in_brackets_is_no_json(tmp_path, above):
    (tmp_path / "a.txt").write_text(
        above + "\n".join([",".join(TABLE), *(",".join(map(repr, row)) for row in ROWS), ""])
    )
    is_read(tmp_path / "a.txt")


def test_times_in_ms_that_name_no_unit_are_asked_for_it_and_read_with_it(tmp_path):
    signals = {"time": 1000 * TIME, "PAP_mmHg": PRESSURE, "flow_mlmin": FLOW}
    np.savez(tmp_path / "a.npz", **signals)
    with pytest.raises(InputError, match="name the unit of their times"):
        read_raw_recording(tmp_path / "a.npz")
    np.savez(tmp_path / "a.npz", **signals, time_unit="ms")
    is_read(tmp_path / "a.npz")


def test_two_matrices_beside_the_same_labels_are_asked_about(tmp_path):
    titles, stated = np.array(["PAP", "PA flow"]), np.array(["mmHg", "ml/min"])
    matrices = {"baseline": np.stack([PRESSURE, FLOW]), "hypoxia": np.stack([PRESSURE + 50, FLOW])}
    np.savez(tmp_path / "a.npz", **matrices, labels=titles, units=stated, fs=1000)
    with pytest.raises(InputError, match="2 channels may hold pressure"):
        read_raw_recording(tmp_path / "a.npz")
    read = read_raw_recording(tmp_path / "a.npz", pressure="hypoxia PAP", flow="hypoxia PA flow")
    np.testing.assert_allclose(read.pressure, PRESSURE + 50)


def test_what_an_archive_of_numpy_holds_beside_its_signals_in_objects_keeps_none_from_being_read(tmp_path):
    notes = np.array({"animal": "R1"}, object)
    np.savez(tmp_path / "a.npz", time_s=TIME, PAP_mmHg=PRESSURE, flow_mlmin=FLOW, notes=notes)
    is_read(tmp_path / "a.npz")


def test_fields_of_a_numpy_array_are_its_columns_and_without_them_names_are_asked_for(tmp_path):
    fields = np.zeros(40, [("time", float), ("pressure", float), ("flow", float)])
    wave = np.sin(2 * np.pi * np.arange(40) / 40)
    fields["time"], fields["pressure"], fields["flow"] = TIME[:40] * 3, 15 + wave, 0.2 + 0.1 * wave
    np.save(tmp_path / "a.npy", fields)
    assert read_recording(tmp_path / "a.npy").mean_pressure == pytest.approx(15.0)
    np.save(tmp_path / "b.npy", np.array(ROWS))
    with pytest.raises(InputError, match="without names of its columns"):
        read_raw_recording(tmp_path / "b.npy")


@pytest.mark.parametrize("end", ["\r", "\n", "\r\n"])
def test_waves_in_igors_text_are_read_with_their_scale_and_unit(tmp_path, end):
    lines = ["IGOR", "WAVES/D\tPAP, 'PA flow'", "BEGIN", *(f"\t{p!r}\t{q!r}" for _, p, q in ROWS), "END"]
    lines += ['X SetScale/P x 0,1,"ms", PAP; SetScale y 0,0,"mmHg", PAP']
    lines += ["X SetScale/P x 0,1,\"ms\", 'PA flow'; SetScale y 0,0,\"ml/min\", 'PA flow'", ""]
    (tmp_path / "a.itx").write_bytes(end.join(lines).encode())
    is_read(tmp_path / "a.itx")


@pytest.mark.parametrize("scale", ["/P x 0,0.003", "/I x 0,0.117", " x 0,0.12"])
def test_the_scale_of_an_igor_wave_is_a_step_a_last_place_or_an_end(tmp_path, scale):
    wave = np.sin(2 * np.pi * np.arange(40) / 40)
    rows = [f"{15 + a!r} {0.2 + 0.1 * a!r}" for a in wave.tolist()]
    end = [f'X SetScale{scale},"s", p, q; SetScale y 0,0,"mmHg", p; SetScale y 0,0,"ml/s", q', ""]
    (tmp_path / "a.itx").write_text("\n".join(["IGOR", "WAVES/D p q", "BEGIN", *rows, "END", *end]))
    assert describe_recording(tmp_path / "a.itx").used.sampling_rate == pytest.approx(1 / 0.003)


def igor_text(start, flags="/D", comma="", note=()):
    lines = ["IGOR", *note, f"WAVES{flags}\tPAP\tflow", "BEGIN", *(f"{p!r} {q!r}" for _, p, q in ROWS), "END"]
    lines += [f'X SetScale/P x{comma} 0,1,"ms", PAP; SetScale y{comma} 0,0,"mmHg", PAP']
    return "\n".join([*lines, f'X SetScale/P x{comma} {start},1,"ms", flow; SetScale y{comma} 0,0,"ml/min", flow', ""])


def test_igor_waves_that_begin_at_different_times_are_not_taken_for_simultaneous(tmp_path):
    (tmp_path / "a.itx").write_text(igor_text(start=500))
    with pytest.raises(InputError, match="different rates or starts"):
        read_raw_recording(tmp_path / "a.itx")


@pytest.mark.parametrize("form", [{"comma": ","}, {"flags": " /D"}, {"note": ("WAVES/T\tnote", "BEGIN", '"x"', "END")}])
def test_igors_text_is_read_with_a_comma_behind_the_axis_a_blank_before_flags_and_a_wave_of_texts(tmp_path, form):
    (tmp_path / "a.itx").write_text(igor_text(start=0, **form))
    is_read(tmp_path / "a.itx")


@pytest.mark.parametrize(("name", "content"), [
    ("a.json", b'{"pressure": [1, 2'), ("a.json", b'{"a": "text"}'), ("a.npz", b"PK\x03\x04" + bytes(99)),
    ("a.itx", b"IGOR\nWAVES a b\nBEGIN\n1 2\n3\nEND\n"), ("a.itx", b"IGOR\nX SetScale/P x 0,0,\"s\", a\n"),
    ("a.json", b'{"pressure": [[1], [2, 3]], "flow": [{"x": 1}, 2]}'),
])  # fmt: skip
def test_files_that_are_damaged_or_hold_no_signals_are_refused_by_name(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=name):
        read_raw_recording(tmp_path / name)


@pytest.mark.parametrize(
    "content",
    [
        lambda t, p, q: {
            "time": t,
            "pressure": p,
            "flow": q,
            "units": {"time": "ms", "pressure": "mmHg", "flow": "ml/min"},
        },
        lambda t, p, q: {"fs": 500, "signals": {"PAP": p, "flow": q}, "units": {"PAP": "mmHg", "flow": "ml/min"}},
        lambda t, p, q: {"fs": 500, "data": {"PAP": p, "flow": q, "unit": {"PAP": "mmHg", "flow": "ml/min"}}},
    ],
)
def test_units_that_stand_by_name_beside_the_signals_are_theirs(tmp_path, content):
    time = np.arange(4000) / 500
    wave = np.sin(2 * np.pi * 8 * time)
    lists = (list(values) for values in (1e3 * time, 15 + 5 * wave, 10 + 10 * wave))
    (tmp_path / "a.json").write_text(json.dumps(content(*lists)))
    raw = read_raw_recording(tmp_path / "a.json")
    assert raw.sampling_rate == pytest.approx(500)
    np.testing.assert_allclose(raw.flow, (10 + 10 * wave) / 60, rtol=1e-12)
    np.testing.assert_allclose(raw.pressure, 15 + 5 * wave, rtol=1e-12)


def test_units_of_two_signals_are_asked_for_in_a_line_to_paste(tmp_path):
    wave = 15 + 5 * np.sin(np.arange(4000) / 10)
    np.savez(tmp_path / "a.npz", time=np.arange(4000) / 500, pressure=wave, flow=wave)
    with pytest.raises(InputError, match="flow has no unit") as caught:
        read_raw_recording(tmp_path / "a.npz")
    assert caught.value.cures[0].cells == (("pressure unit", "mmHg"), ("flow unit", "ml/s"))
