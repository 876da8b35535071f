"""Reading one averaged cycle: round trips through units and files, and what every wrong file is told."""

from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from vasowave.base import InputError, VasowaveWarning
from vasowave.catheter.read import read_recording
from vasowave.catheter.signals import SensorCalibration

MOUSE = Path(__file__).parents[2] / ".." / "shared" / "data" / "mouse-c6"
PERIOD = 0.11
PHASE = np.arange(256) / 256
PRESSURE = 14 + 4 * np.sin(2 * np.pi * PHASE) + 1.5 * np.cos(4 * np.pi * PHASE)
FLOW = 0.18 + 0.2 * np.sin(2 * np.pi * PHASE) + 0.05 * np.cos(4 * np.pi * PHASE)
TIME = PHASE * PERIOD


def write(path: Path, *columns: np.ndarray, header: str = "", decimals: int = 9, separator: str = ",") -> Path:
    rows = [separator.join(f"{value:.{decimals}f}" for value in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join(([header] if header else []) + rows) + "\n", encoding="utf-8")
    return path


def closed(values: np.ndarray) -> np.ndarray:
    return np.append(values, values[0])


@pytest.mark.parametrize(
    ("pressure_unit", "per_mmhg", "flow_unit", "per_ml_s"),
    [
        ("mmHg", 1.0, "ml/s", 1.0),
        ("kPa", 0.133322, "µl/s", 1000.0),
        ("dyn/cm²", 1333.22, "ml/min", 60.0),
        ("Pa", 133.322, "l/min", 0.06),
    ],
)
def test_the_same_cycle_in_other_units_reads_back_the_same(tmp_path, pressure_unit, per_mmhg, flow_unit, per_ml_s):
    header = f"t [ms],p [{pressure_unit}],Q ({flow_unit})"
    path = write(tmp_path / "cycle.csv", TIME * 1e3, PRESSURE * per_mmhg, FLOW * per_ml_s, header=header)
    recording = read_recording(path)
    np.testing.assert_allclose(recording.pressure, PRESSURE, atol=1e-7)
    np.testing.assert_allclose(recording.flow, FLOW, atol=1e-7)
    assert recording.period == pytest.approx(PERIOD, rel=1e-9)


def test_zeros_and_gains_are_taken_off_before_a_cycle_is_judged(tmp_path):
    path = write(tmp_path / "cycle.csv", TIME, PRESSURE - 20, 0.1 - FLOW / 2, header="t [s],p [mmHg],Q [ml/s]")
    with pytest.raises(InputError, match="is not positive"):
        read_recording(path)
    recording = read_recording(path, calibration=SensorCalibration(zero=-20, flow_gain=-2, flow_zero=0.1))
    np.testing.assert_allclose(recording.pressure, PRESSURE, atol=1e-7)
    np.testing.assert_allclose(recording.flow, FLOW, atol=1e-7)
    said = [str(one) for one in recording.notes]
    assert "the given zero of +0.1 ml/s was subtracted from the flow" in said
    assert "the flow was multiplied by the given gain of -2" in said


@pytest.mark.parametrize(("suffix", "separator"), [("csv", ","), ("csv", ";"), ("tsv", "\t")])
def test_a_repeated_first_sample_is_dropped_whatever_the_separator(tmp_path, suffix, separator):
    header = separator.join(["time [s]", "pressure [mmHg]", "flow [ml/s]"])
    time = np.append(TIME, PERIOD)
    path = write(
        tmp_path / f"c.{suffix}", time, closed(PRESSURE), closed(FLOW), header=header, separator=separator, decimals=6
    )
    recording = read_recording(path)
    assert len(recording.pressure) == len(recording.flow) == 256
    assert recording.period == pytest.approx(PERIOD, rel=1e-6)
    assert any("repeats the first" in str(note) for note in recording.notes)


@pytest.mark.parametrize("line", ['"0.1,12,0.2', "0.1,12," + "1" * 200_000])
def test_an_open_quotation_mark_or_an_endless_cell_is_refused(tmp_path, line):
    path = tmp_path / "c.csv"
    path.write_text("time [s],pressure [mmHg],flow [ml/s]\n" + line + "\n0.2,13,0.3\n")
    with pytest.raises(InputError, match=r"c\.csv, line 2: a quotation"):
        read_recording(path)


def test_two_files_of_different_rates_say_which_units_were_assumed(tmp_path):
    pressure = write(tmp_path / "p.dat", closed(PRESSURE))
    flow = write(tmp_path / "q.dat", closed(FLOW)[::2])
    recording = read_recording(pressure, flow, period=PERIOD)
    assert (len(recording.pressure), len(recording.flow)) == (256, 128)
    assert sum("assumed" in str(note) for note in recording.notes) == 2


def test_a_stated_unit_is_used_and_no_longer_assumed(tmp_path):
    pressure = write(tmp_path / "p.dat", PRESSURE * 0.133322)
    flow = write(tmp_path / "q.dat", FLOW * 60)
    recording = read_recording(pressure, flow, period=PERIOD, pressure_unit="kPa", flow_unit="ml/min")
    assert recording.mean_pressure == pytest.approx(14, rel=1e-6)
    assert recording.cardiac_output == pytest.approx(0.18, rel=1e-6)
    assert not any("assumed" in str(note) for note in recording.notes)


@pytest.mark.parametrize(("p", "q"), [(closed(PRESSURE), FLOW[::2]), (PRESSURE[::2], closed(FLOW))])
def test_of_two_files_of_different_rates_each_decides_for_itself_whether_its_end_repeats(tmp_path, p, q):
    recording = read_recording(write(tmp_path / "p.dat", p), write(tmp_path / "q.dat", q), period=PERIOD)
    assert sorted((len(recording.pressure), len(recording.flow))) == [128, 256]


def test_mat_variables_of_different_rates_are_read(tmp_path):
    path = tmp_path / "cycle.mat"
    savemat(path, {"P": PRESSURE * 0.133322, "q": FLOW[::2, None], "pressure_unit": "kPa", "flow_unit": "ml/s"})
    recording = read_recording(path, period=PERIOD)
    np.testing.assert_allclose(recording.pressure, PRESSURE, rtol=1e-12)
    assert len(recording.flow) == 128


def test_times_in_a_mat_file_give_the_period(tmp_path):
    path = tmp_path / "cycle.mat"
    savemat(path, {"t": 1e3 * np.append(TIME, PERIOD), "t_unit": "ms", "p": closed(PRESSURE), "q": closed(FLOW)})
    assert read_recording(path).period == pytest.approx(PERIOD, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"pressure": np.where(np.arange(256) == 2, np.nan, PRESSURE)}, "'pressure': sample 3 is missing"),
        ({"flow": np.where(np.arange(256) == 3, np.inf, FLOW)}, "'flow': sample 4 is missing"),
        ({"time": np.where(np.arange(256) == 1, np.nan, TIME)}, r"time\(2\), time: the cell is empty or no number"),
        ({"flow": FLOW[::2]}, "no channel says that it holds flow.*it has: 'pressure'"),
        ({"P": PRESSURE}, "2 channels may hold pressure, name one of them"),
        ({"T": 2 * TIME}, "different rates or times; keep one of them"),
        ({"flow": FLOW + 1j}, "no channel says that it holds flow"),
        ({"flow": np.ones((2, 2))}, "no channel says that it holds flow"),
        ({"flow": None}, "no channel says that it holds flow"),
    ],
)
def test_a_cycle_in_variables_is_refused_with_variable_and_place(tmp_path, changes, said):
    variables = {"time": TIME, "pressure": PRESSURE, "flow": FLOW} | changes
    savemat(tmp_path / "c.mat", {name: values for name, values in variables.items() if values is not None})
    with pytest.raises(InputError, match=rf"c\.mat.*{said}"):
        read_recording(tmp_path / "c.mat")


GOOD = {"time [s]": TIME, "pressure [mmHg]": PRESSURE, "flow [ml/s]": FLOW}
GAP = np.where(np.arange(256) == 40, np.nan, PRESSURE)
SKIPPED = np.where(np.arange(256) >= 100, TIME + PERIOD / 256, TIME)


@pytest.mark.parametrize(
    ("change", "kwargs", "message"),
    [
        ({"pressure [mmHg]": GAP}, {}, r"line 42, column 'pressure': nan is not a finite number"),
        ({"time [s]": SKIPPED}, {}, r"line 102, column 'time': uneven sampling"),
        ({"time [s]": TIME[::-1]}, {}, "line 3, column 'time': time does not increase"),
        ({"pressure [mmHg]": PRESSURE * 0.133322}, {}, "looks like kPa"),
        ({"pressure [mmHg]": PRESSURE * 0 + 14}, {}, "the pressure is constant"),
        ({"flow [ml/s]": FLOW * 0 + 0.2}, {}, "the flow is constant"),
        ({"flow [ml/s]": -FLOW}, {}, "turn its sign, as of a probe mounted backward"),
        ({"flow [ml/s]": 0.15 - 0.5 * np.exp(-(((PHASE - 0.5) / 0.08) ** 2))}, {}, "largest flow is backward"),
        ({"pressure [mmHg]": PRESSURE + 8 * PHASE}, {}, "cycle of pressure does not close"),
        ({"time [s]": TIME * 1000}, {}, "is it in ms"),
        ({}, {"period": 0.12}, "the time column covers 0.11 s, the period given is 0.12 s"),
        ({}, {"period": 110.0}, "is it in ms"),
        (
            {},
            {"pressure_unit": "Pa"},
            "too low for an artery; is the unit right",
        ),  # what is given counts, and is judged
    ],
)
def test_a_wrong_table_is_refused_with_the_place_and_the_cure(tmp_path, change, kwargs, message):
    columns = {**GOOD, **change}
    path = write(tmp_path / "cycle.csv", *columns.values(), header=",".join(columns))
    with pytest.raises(InputError, match=message):
        read_recording(path, **kwargs)


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("time [s],pressure [ml/s],flow [ml/s]", "'ml/s' is not a unit of pressure"),
        ("time [s],pressure,flow [ml/s]", "has no unit"),
        ("time [s],p [mmHg],flow [ml/s],p [mmHg]", "columns where"),
        ("", "3 columns without a header"),
    ],
)
def test_a_wrong_header_is_refused(tmp_path, header, message):
    path = write(tmp_path / "cycle.csv", TIME, PRESSURE, FLOW, header=header)
    with pytest.raises(InputError, match=message):
        read_recording(path)


def test_one_column_with_decimal_commas_is_told_so(tmp_path):
    path = write(tmp_path / "p.dat", PRESSURE)
    path.write_text(path.read_text().replace(".", ","))
    with pytest.raises(InputError, match="if the comma is a decimal one, write a point"):
        read_recording(path, write(tmp_path / "q.dat", FLOW), period=PERIOD)


def test_a_continuous_recording_is_told_from_a_cycle(tmp_path):
    labchart = tmp_path / "raw.txt"
    labchart.write_text("Interval=\t0.001 s\nChannelTitle=\tPAP\tFlow\n0.0\t14.0\t0.2\n")
    with pytest.raises(InputError, match=r"continuous recording \(LabChart text.*read it as continuous"):
        read_recording(labchart)
    long = write(tmp_path / "long.csv", 100 * TIME, PRESSURE, FLOW, header=",".join(GOOD))
    with pytest.raises(InputError, match="or a continuous recording"):
        read_recording(long)


@pytest.mark.parametrize("separator", [";", "\t", " "])
def test_decimal_commas_are_read_whatever_other_separator(tmp_path, separator):
    header = separator.join(GOOD)
    path = write(tmp_path / "c.csv", TIME, PRESSURE, FLOW, header=header, separator=separator)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b".", b","))
    recording = read_recording(path)
    np.testing.assert_allclose(recording.pressure, PRESSURE, atol=1e-8)
    np.testing.assert_allclose(recording.flow, FLOW, atol=1e-8)
    assert recording.period == pytest.approx(PERIOD, rel=1e-6)


def test_too_few_samples_and_a_missing_period_are_refused(tmp_path):
    short = write(tmp_path / "s.csv", TIME[:12], PRESSURE[:12], FLOW[:12], header=",".join(GOOD))
    with pytest.raises(InputError, match="line 13: the file ends after 12 samples"):
        read_recording(short)
    with pytest.raises(InputError, match="no time column; give its period in s"):
        read_recording(write(tmp_path / "p.dat", PRESSURE), write(tmp_path / "q.dat", FLOW))


def test_swapped_files_are_told_so(tmp_path):
    pressure, flow = write(tmp_path / "p.dat", PRESSURE), write(tmp_path / "q.dat", FLOW)
    with pytest.raises(InputError, match="the first must hold pressure"):
        read_recording(flow, pressure, period=PERIOD)


def test_mat_files_that_are_truncated_or_raw_are_refused_with_the_cure(tmp_path):
    path = tmp_path / "cycle.mat"
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512) + b"\x89HDF\r\n\x1a\n")
    with pytest.raises(InputError, match=r"truncated, damaged.*'-v7'"):
        read_recording(path)
    savemat(path, {"p": PRESSURE, "q": FLOW})
    path.write_bytes(path.read_bytes()[:2500])
    with pytest.raises(InputError, match="truncated, damaged"):
        read_recording(path)
    savemat(path, {"data": PRESSURE, "datastart": 1, "dataend": 2})
    with pytest.raises(InputError, match="read_raw_recording"):
        read_recording(path)


def test_a_period_may_be_longer_than_the_times_by_half_a_sample_and_no_more(tmp_path):
    path = write(tmp_path / "c.csv", TIME, PRESSURE, FLOW, header="time [s],pressure [mmHg],flow [ml/s]")
    sample = PERIOD / 256
    assert read_recording(path, period=PERIOD + 0.4 * sample).period == PERIOD + 0.4 * sample
    with pytest.raises(InputError, match=r"covers 0\.11 s, the period given is"):
        read_recording(path, period=PERIOD + 0.9 * sample)


@settings(max_examples=150, deadline=None)
@given(content=st.binary(max_size=400), suffix=st.sampled_from(["csv", "tsv", "dat"]))
def test_no_bytes_raise_a_foreign_exception(tmp_path_factory, content, suffix):
    path = Path(mkdtemp(dir=tmp_path_factory.getbasetemp())) / f"file.{suffix}"
    path.write_bytes(content + b"\n")
    with pytest.raises(InputError):
        read_recording(path, period=0.1)


@pytest.mark.parametrize(("name", "examples"), [("c.csv", 100), ("c.mat", 3)])
def test_no_damage_to_a_good_file_raises_a_foreign_exception(tmp_path_factory, name, examples):
    @settings(max_examples=examples, deadline=None)
    @given(data=st.data())
    def damage(data):
        path = Path(mkdtemp(dir=tmp_path_factory.getbasetemp())) / name
        if path.suffix == ".mat":
            savemat(path, {"t": TIME, "p": PRESSURE, "q": FLOW})
        else:
            write(path, *GOOD.values(), header=",".join(GOOD), decimals=6)
        content = bytearray(path.read_bytes())
        for place in data.draw(st.lists(st.integers(0, len(content) - 1), max_size=6)):
            content[place] = data.draw(st.integers(0, 255))
        path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
        try:
            recording = read_recording(path)
        except (InputError, VasowaveWarning):
            return
        assert np.isfinite(recording.pressure).all()
        assert recording.period > 0

    damage()


@pytest.mark.skipif(not MOUSE.exists(), reason="needs shared/data/mouse-c6 beside the project")
@pytest.mark.parametrize(("p", "q"), [(1024, 1024), (512, 8192), (1024, 512)])
def test_the_measured_mouse_has_its_published_resistance_at_every_sampling(p, q):
    recording = read_recording(MOUSE / f"pC6_{p}.dat", MOUSE / f"qC6_{q}.dat", period=0.11)
    assert recording.vascular_resistance == pytest.approx(87, rel=0.01)  # Table of nominal values, CTL 6
    assert len(recording.pressure) == p - 1
    assert len(recording.flow) == {1024: 1023, 512: 511, 8192: 8192}[q]


@pytest.mark.parametrize(("count", "shift", "kept"), [(101, 0.0, 100), (100, 0.5, 100)])
def test_times_and_period_together_say_whether_the_last_sample_is_the_next_cycle_s_first(tmp_path, count, shift, kept):
    # With half a sample's shift the cosine ends where it began although nothing is repeated.
    rows = np.arange(count)
    wave = np.cos(2 * np.pi * (rows + shift) / 100)
    np.savetxt(
        tmp_path / "c.csv", np.column_stack([rows / 1000, 14 + 4 * wave, 0.2 + 0.1 * wave]), "%.17g", ",",
        header="time [s],pressure [mmHg],flow [ml/s]", comments="",
    )  # fmt: skip
    found = read_recording(tmp_path / "c.csv", period=0.1)
    assert len(found.pressure) == len(found.flow) == kept
    assert found.period == pytest.approx(0.1, rel=1e-12)


def at_rest(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a pressure and a flow that rest from 0.4 of the cycle to its end, as a file of three decimals has them."""
    phase = np.arange(count) / count
    ejection = np.where(phase < 0.4, np.sin(np.pi * phase / 0.4) ** 2, 0)
    return np.round(12 + 10 * ejection, 3), np.round(0.5 * ejection, 3)


def test_a_cycle_that_ends_at_rest_keeps_its_period_and_says_what_another_reading_would_make_of_it(tmp_path):
    times, header = np.arange(128) / 128 * PERIOD, "time [s],pressure [mmHg],flow [ml/s]"
    path = write(tmp_path / "c.csv", times, *at_rest(128), header=header)
    with pytest.warns(VasowaveWarning, match=r"say the period \[period="):
        found = read_recording(path)
    assert (len(found.pressure), found.period) == (128, pytest.approx(PERIOD, rel=1e-6))  # times have nine decimals
    (note,) = found.notes
    assert note.code == "recording.last-sample-in-doubt"
    values = dict(note.values)
    assert values["other"] == pytest.approx(PERIOD * 127 / 128, rel=1e-6)
    assert (values["percent"], values["less"]) == (pytest.approx(100 / 128), pytest.approx(PERIOD / 128, rel=1e-6))
    for period, kept in ((PERIOD, 128), (PERIOD * 127 / 128, 127)):
        told = read_recording(path, period=period)
        assert (len(told.flow), told.period) == (kept, period)
        assert [one.code for one in told.notes] == ["recording.last-sample-repeated"] * (kept == 127)


@pytest.mark.filterwarnings("ignore:.*the upstroke of the flow begins")
def test_a_flow_at_rest_ends_as_the_pressure_that_the_same_program_wrote(tmp_path):
    _, flow = at_rest(128)
    for pressure, kept in ((closed(PRESSURE), 127), (PRESSURE, 128)):
        found = read_recording(write(tmp_path / "p.dat", pressure), write(tmp_path / "q.dat", flow), period=PERIOD)
        assert (len(found.pressure), len(found.flow)) == (256, kept)


def test_a_column_that_only_its_unit_tells_is_taken_with_a_note(tmp_path):
    path = write(tmp_path / "cycle.csv", *GOOD.values(), header="time [s],presure [mmHg],flow [ml/s]")
    recording = read_recording(path)
    assert (
        recording.mean_pressure
        == read_recording(write(tmp_path / "same.csv", *GOOD.values(), header=",".join(GOOD))).mean_pressure
    )
    (note,) = [note for note in recording.notes if note.code == "recording.channel-taken"]
    assert "'presure' was taken for pressure" in str(note)


def test_pressure_and_flow_of_two_cycles_are_refused_with_how_long_each_lasts(tmp_path):
    files = [
        write(tmp_path / f"{name}.csv", TIME * stretch, values, header=f"time [s],{name} [{unit}]")
        for name, unit, values, stretch in (("pressure", "mmHg", PRESSURE, 1.0), ("flow", "ml/s", FLOW, 1.05))
    ]
    with pytest.raises(InputError, match=r"pressure\.csv lasts 0\.11 s and .*flow\.csv 0\.1155 s; .* of one cycle"):
        read_recording(*files)
