"""Files as labs have them: wrong units, titles of other places, cut ends, clocks, offsets; each said with its cure."""

import warnings

import numpy as np
import pytest
from scipy.io import savemat

from vasowave.base import InputError, Severity, VasowaveWarning
from vasowave.catheter import average_beats
from vasowave.catheter.check import odd_values, resting_flow
from vasowave.catheter.read import describe_recording, read_raw_recording, read_recording
from vasowave.catheter.signals import Plateau, plateau_findings
from vasowave.pulse.examples import virtual_mouse

MOUSE = virtual_mouse()
TIME = np.arange(0, 5, 1e-3)


def signals(pressure_scale=1.0):
    phase = (TIME / MOUSE.period) % 1
    p, q = (np.interp(phase, np.arange(len(v) + 1) / len(v), np.append(v, v[0])) for v in (MOUSE.pressure, MOUSE.flow))
    return p * pressure_scale, q


def labchart(titles, unit_names=("mmHg", "mL/s"), pressure_scale=1.0):
    rows = (f"{t:.3f}\t{p:.4f}\t{q:.5f}" for t, p, q in zip(TIME, *signals(pressure_scale)))
    units = ["UnitName=\t" + "\t".join(unit_names)] if unit_names else []
    head = ["Interval=\t0.001 s", "ChannelTitle=\t" + "\t".join(titles), "Range=\t100 mV\t10 V", *units]
    return "\n".join([*head, *rows, ""])


def read(path, **options):
    with warnings.catch_warnings(record=True):
        warnings.simplefilter("always", VasowaveWarning)
        return read_raw_recording(path, **options)


@pytest.mark.parametrize(("scale", "unit"), [(133.322, "Pa"), (0.133322, "kPa")])
def test_a_unit_that_is_given_counts_though_the_file_says_another(tmp_path, scale, unit):
    path = tmp_path / "raw.txt"
    path.write_text(labchart(["PAP", "Flow"], pressure_scale=scale), "utf-8")
    with pytest.raises(InputError, match=f"pressure_unit='{unit}'"):
        average_beats(read(path), reject_ventilation=False, drift="warn")
    raw = read(path, pressure_unit=unit)
    assert raw.pressure.mean() == pytest.approx(MOUSE.pressure.mean(), rel=1e-2)
    (said,) = [one for one in raw.notes if one.code == "recording.unit-replaced"]
    assert said.severity is Severity.LOOK
    assert str(said) == f"pressure was taken to be in {unit}, as given, although the file says mmHg"
    assert not any(one.code == "recording.unit-replaced" for one in read_same(path).notes)


def read_same(path):
    path.write_text(labchart(["PAP", "Flow"]), "utf-8")
    return read(path, pressure_unit="mmHg")


def test_a_unit_that_is_given_counts_for_a_cycle_too(tmp_path):
    rows = (f"{t:.6f},{p * 133.322:.4f},{q:.6f}" for t, p, q in zip(MOUSE.time, MOUSE.pressure, MOUSE.flow))
    (tmp_path / "c.csv").write_text("\n".join(["time [s],pressure [mmHg],flow [ml/s]", *rows, ""]), "utf-8")
    made = read_recording(tmp_path / "c.csv", pressure_unit="Pa")
    assert made.mean_pressure == pytest.approx(MOUSE.mean_pressure, rel=1e-4)
    assert [one.code for one in made.notes].count("recording.unit-replaced") == 1
    named = {"time": MOUSE.time, "pressure": MOUSE.pressure * 133.322, "pressure_unit": "mmHg", "flow": MOUSE.flow}
    savemat(tmp_path / "c.mat", named)
    made = read_recording(tmp_path / "c.mat", pressure_unit="Pa")
    assert made.mean_pressure == pytest.approx(MOUSE.mean_pressure, rel=1e-4)
    assert "recording.unit-replaced" in [one.code for one in made.notes]


def test_a_title_and_a_range_that_contradict_each_other_are_both_named(tmp_path):
    (tmp_path / "raw.txt").write_text(labchart(["PAP (mmHg)", "Flow"], unit_names=None), "utf-8")
    with pytest.raises(InputError, match="pressure is in mV, though its title speaks of mmHg") as refused:
        read(tmp_path / "raw.txt")
    assert "flow is in V; set the units conversion" in str(refused.value)  # both at once
    assert "pressure_unit='mmHg'" in refused.value.__notes__


def test_variables_without_known_times_are_refused_until_their_rate_is_given(tmp_path):
    p, q = signals()
    named = {"moments": TIME, "druck": p, "Qpa": q, "ekg": p}
    savemat(tmp_path / "m.mat", named)
    options = {"pressure": "druck", "flow": "Qpa", "pressure_unit": "mmHg", "flow_unit": "ml/s"}
    with pytest.raises(InputError, match=r"m\.mat: no times; say how many samples a second has\nsampling_rate="):
        read(tmp_path / "m.mat", **options)
    raw = read(tmp_path / "m.mat", **options, sampling_rate=1000.0)
    np.testing.assert_allclose(raw.pressure, p)
    assert raw.time[-1] == pytest.approx(TIME[-1])


def test_a_variable_is_called_as_the_file_calls_it(tmp_path):
    p, q = signals()
    savemat(tmp_path / "m.mat", {"t": TIME, "PAP": p, "P": 2 * p, "p": 3 * p, "P_unit": "kPa", "Flow": q})
    (block,) = describe_recording(tmp_path / "m.mat").blocks
    assert [one.title for one in block.channels] == ["PAP", "P", "p", "Flow"]
    units = {"pressure_unit": "mmHg", "flow_unit": "ml/s"}
    for name, scale in (("PAP", 1.0), ("pap", 1.0), ("P", 2.0), ("p", 3.0)):
        raw = read(tmp_path / "m.mat", pressure=name, flow="Flow", **units)
        np.testing.assert_allclose(raw.pressure, scale * p)


@pytest.mark.parametrize("left", [-1, -4, -9, -12])
def test_a_text_that_ends_within_its_last_line_loses_that_line_alone(tmp_path, left):
    text = labchart(["PAP", "Flow"])
    whole = text.count("\n") - 4
    (tmp_path / "raw.txt").write_text(text[:left], "utf-8")
    raw = read(tmp_path / "raw.txt")
    assert len(raw.pressure) == whole - 1
    assert "recording.cut-off" in [one.code for one in raw.notes]
    rows = (f"{t:.3f},{p:.4f},{q:.5f}" for t, p, q in zip(TIME, *signals()))
    table = "\n".join(["time [s],pressure [mmHg],flow [ml/s]", *rows, ""])
    (tmp_path / "raw.csv").write_text(table[:left], "utf-8")
    raw = read(tmp_path / "raw.csv")
    assert len(raw.pressure) == len(TIME) - 1
    assert "recording.cut-off" in [one.code for one in raw.notes]


@pytest.mark.parametrize("comma", [False, True])
@pytest.mark.parametrize(
    "head",
    [
        ["Mouse 17;week 3", "t [s];PAP [mmHg];Flow [ml/s]"],
        ["Rat: 6", "Date: 3.4.2024", "", "t [s];PAP [mmHg];Flow [ml/s]"],
        ["t;PAP;Flow", "s;mmHg;ml/s"],
        ["Rat: 6", "t;PAP;Flow", "[s];[mmHg];[ml/s]"],
    ],
)
def test_prose_above_the_titles_is_left_out_and_units_below_them_are_read(tmp_path, head, comma):
    p, q = signals()
    rows = [f"{t:.3f};{a:.4f};{b:.5f}" for t, a, b in zip(TIME, p, q)]
    rows = [row.replace(".", ",") for row in rows] if comma else rows
    (tmp_path / "t.csv").write_text("\n".join([*head, *rows, ""]), "utf-8")
    raw = read(tmp_path / "t.csv")
    np.testing.assert_allclose(raw.pressure, p, atol=1e-4)
    np.testing.assert_allclose(raw.flow, q, atol=1e-5)
    assert raw.sampling_rate == pytest.approx(1000.0)
    cycle = [f"{t:.6f};{a:.4f};{b:.5f}" for t, a, b in zip(MOUSE.time, MOUSE.pressure, MOUSE.flow)]
    (tmp_path / "c.csv").write_text("\n".join([*head, *cycle, ""]), "utf-8")
    np.testing.assert_allclose(read_recording(tmp_path / "c.csv").pressure, MOUSE.pressure, atol=1e-4)


def test_times_of_day_are_seconds_since_the_first_row(tmp_path):
    rows = [f"{t:.3f},{p:.4f},{q:.5f}" for t, p, q in zip(TIME, *signals())]
    clock = ["time,PAP [mmHg],Flow [ml/s]", *(f"10:01:0{row}" for row in rows), ""]
    (tmp_path / "c.csv").write_text("\n".join(clock), "utf-8")
    (block,) = describe_recording(tmp_path / "c.csv").blocks
    assert block.sampling_rate == pytest.approx(1000.0)
    assert [channel.title for channel in block.channels] == ["PAP", "Flow"]


def test_flows_that_rest_at_zero_or_never_rest_are_left_alone():
    for seed in range(6):
        mouse = virtual_mouse(seed=seed)
        assert not [one for one in odd_values(mouse.pressure, mouse.flow, mouse.period) if "off-zero" in one.code]
    phase = np.arange(256) / 256
    assert resting_flow(0.2 + 0.1 * np.sin(2 * np.pi * phase) + 0.05 * np.sin(4 * np.pi * phase)) == 0.0


@pytest.mark.parametrize(("first", "last", "code"), [(0.2, 9.0, "zero-within"), (3.0, 9.0, "open-to-air")])
def test_a_zero_between_beats_asks_for_a_look(first, last, code):
    (found,) = plateau_findings((Plateau(1.0, 2.0, 0.0),), first, last)
    assert found.code == f"recording.{code}"
    assert (found.severity is Severity.LOOK) == (code == "zero-within")


def test_exchanged_channels_are_called_so_and_a_wrong_zero_is_not():
    codes = [one.code for one in odd_values(60 * MOUSE.flow, MOUSE.pressure / 10, MOUSE.period)]
    assert codes == ["recording.exchanged"]
    for pressure, flow in (
        (MOUSE.pressure, MOUSE.flow),
        (MOUSE.pressure - MOUSE.pressure.min(), MOUSE.flow),  # its lowest value is zero
        (60 * MOUSE.flow, MOUSE.flow),  # a ventricle rests near zero, too
        (MOUSE.pressure, MOUSE.flow + 10 * MOUSE.flow.mean()),  # a flow that never stops
    ):
        assert "recording.exchanged" not in [one.code for one in odd_values(pressure, flow, MOUSE.period)]
