"""Workbooks with several sheets, velocities in place of flows: what is read, what is left out, what is asked."""

import warnings

import numpy as np
import openpyxl
import pytest

from made_workbook import write_ods
from vasowave.base import InputError, VasowaveWarning
from vasowave.catheter.read import describe_recording, read_raw_recording, read_recording
from vasowave.study.entering import add_files, new_study

TIME = np.arange(0, 3.2, 2e-3)
TITLES = ("time [s]", "PAP [mmHg]", "PA flow [ml/s]")
GROUPS = [("animal", "group", "weight [g]"), *((f"R{i}", "CTL", 200 + i) for i in range(20))]


def beats(pressure=15.0, flow=0.2, period=0.11):
    phase = TIME / period % 1
    ejection = np.where(phase < 0.4, np.sin(np.pi * phase / 0.4), 0.0)
    return pressure + 6 * np.cos(2 * np.pi * (phase - 0.25)), flow * ejection / ejection.mean()


def signals(pressure, flow=0.2, titles=TITLES):
    columns = (TIME, *beats(pressure, flow))
    return [titles, *zip(*(column.tolist() for column in columns), strict=True)]


def saved(path, **sheets):
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        page = book.create_sheet(name)
        for row in rows:
            page.append(row)
    book.save(path)
    return path


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


def test_rows_get_the_channels_that_their_files_have_the_site_and_the_sheet(tmp_path):
    for name, title in (("a", "Ch 3"), ("b", "Ch 4")):
        rows = signals(95, titles=("time [s]", f"{title} [mmHg]", "Aortic flow [ml/s]"))
        (tmp_path / f"{name}.csv").write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n")
    saved(tmp_path / "c.xlsx", A=signals(15), B=signals(12))
    new_study(tmp_path / "study")
    cells = {"pressure channel": "Ch 3", "site": "aorta", "sheet": "B"}
    rows = {row["animal"]: row for row in add_files(tmp_path / "study", [tmp_path], cells=cells).rows}
    assert rows["a"]["pressure channel"] == "Ch 3"
    assert rows["b"].get("pressure channel", "") != "Ch 3"
    assert {row["site"] for row in rows.values()} == {"aorta"}
    assert [name for name, row in rows.items() if row.get("sheet") == "B"] == ["c"]
