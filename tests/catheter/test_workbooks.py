"""Workbooks with several sheets, velocities in place of flows: what is read, what is left out, what is asked."""

import warnings

import numpy as np
import pytest

from made_workbook import TIME, beats, saved, signals, write_ods
from vasowave.base import InputError, VasowaveWarning
from vasowave.catheter.read import describe_recording, read_raw_recording, read_recording

GROUPS = [("animal", "group", "weight [g]"), *((f"R{i}", "CTL", 200 + i) for i in range(20))]


def test_the_sheet_with_signals_is_found_and_the_others_are_named(tmp_path):
    path = tmp_path / "rat.ods"
    write_ods(path, GROUPS, "Groups", [("Trace", signals(15))])
    recording = read_raw_recording(path)
    assert recording.pressure.mean() == pytest.approx(15, rel=5e-3)
    (note,) = (note for note in recording.notes if note.code == "recording.sheets-left-out")
    assert "'Groups' (animal, group, weight)" in str(note)


def test_of_several_sheets_with_signals_the_first_is_read_and_told_and_another_can_be_named(tmp_path):
    path = saved(tmp_path / "m.xlsx", Info=[("Study", "A")], Before=signals(15), After=signals(11))
    with pytest.warns(VasowaveWarning, match="the sheets 'Before' and 'After' hold signals; 'Before' was read"):
        assert read_raw_recording(path).pressure.mean() == pytest.approx(15, rel=5e-3)
    assert read_raw_recording(path, sheet="after").pressure.mean() == pytest.approx(11, rel=5e-3)
    assert [block.sheet for block in describe_recording(path).blocks] == ["Before", "After"]


def test_a_sheet_of_signals_without_units_and_times_is_known_by_its_titles(tmp_path):
    rows = [("PA Pressure", "PA Flow"), *(row[1:] for row in signals(15)[1:])]
    path = saved(tmp_path / "m.xlsx", Root=[("Root Name", "Author"), ("run12", "lab")], Untitled=rows)
    with pytest.raises(InputError, match="say how many samples a second has") as caught:
        read_raw_recording(path)
    assert "pressure has no unit" in str(caught.value)
    units = {"pressure_unit": "mmHg", "flow_unit": "ml/s"}
    assert read_raw_recording(path, sampling_rate=500, **units).pressure.mean() == pytest.approx(15, rel=5e-3)


def test_a_workbook_without_signals_names_its_sheets(tmp_path):
    path = saved(tmp_path / "w.xlsx", Groups=GROUPS, Weights=[("animal", "RV [mg]"), ("R1", 20)])
    with pytest.raises(InputError, match=r"'Groups' \(animal, group, weight\); 'Weights' \(animal, rv\)"):
        read_raw_recording(path)


def test_one_cycle_is_read_from_the_sheet_that_is_named(tmp_path):
    rows = signals(15)[:56]
    path = saved(tmp_path / "c.xlsx", A=rows, B=[rows[0], *((t, p + 3, q) for t, p, q in rows[1:])])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        first, second = read_recording(path), read_recording(path, sheet="B")
    assert second.pressure.mean() - first.pressure.mean() == pytest.approx(3)


def test_a_velocity_is_a_flow_with_the_diameter_of_the_vessel_and_asks_for_it_without(tmp_path):
    area = np.pi * 0.12**2 / 4
    pressure, flow = beats()
    rows = (f"{t:.4f},{p:.5f},{v:.5f}" for t, p, v in zip(TIME, pressure, flow / area / 100, strict=True))
    (tmp_path / "d.csv").write_text("\n".join(["time [s],PA pressure [mmHg],PA velocity [m/s]", *rows, ""]))
    with pytest.raises(InputError, match="'PA velocity': a velocity is a flow where the vessel's diameter"):
        read_raw_recording(tmp_path / "d.csv")
    recording = read_raw_recording(tmp_path / "d.csv", flow_diameter=1.2)
    assert recording.flow.mean() == pytest.approx(flow.mean(), rel=1e-3)
    assert "recording.flow-of-velocity" in {note.code for note in recording.notes}
    with pytest.raises(InputError, match="give it in mm"):
        read_raw_recording(tmp_path / "d.csv", flow_diameter=1200)


def test_a_sheet_of_signals_that_cannot_be_read_is_told_and_one_with_times_goes_before_one_without(tmp_path):
    bad = signals(15)
    bad[300] = (bad[300][0], "bad", bad[300][2])
    with pytest.warns(VasowaveWarning, match="a sheet with signals cannot be read"):
        recorded = read_raw_recording(saved(tmp_path / "a.xlsx", Before=bad, After=signals(11)))
    assert recorded.pressure.mean() == pytest.approx(11, rel=0.01)
    numbers = [("ID", "mPAP [mmHg]", "CO [ml/min]"), *((i, 14.0 + i / 10, 11.0) for i in range(30))]
    (block,) = describe_recording(saved(tmp_path / "b.xlsx", Groups=numbers, Trace=signals(15))).blocks
    assert block.sheet == "Trace"


def test_a_sheet_is_named_of_the_workbook_of_a_pair(tmp_path):
    halves = [[row[:2] for row in signals(15)], [row[::2] for row in signals(15)]]
    book = saved(tmp_path / "p.xlsx", P=halves[0], Q=[("a",)])
    text = tmp_path / "q.csv"
    text.write_text("\n".join(",".join(map(str, row)) for row in halves[1]) + "\n")
    assert read_raw_recording(book, text, sheet="P").pressure.mean() == pytest.approx(15, rel=0.01)
    with pytest.raises(InputError, match="is not a workbook and has no sheet 'P'"):
        read_raw_recording(text, text, sheet="P")
