"""Rows of files that are added: their channels, site and sheet."""

import pickle
import subprocess
import sys

import pytest

from made_workbook import saved, signals
from vasowave.base import VasowaveWarning, finding_of
from vasowave.catheter.read import read_raw_recording
from vasowave.study.entering import add_files, check_study, new_study
from vasowave.study.entering.table import read_rows


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


def test_every_subject_of_a_table_becomes_a_row_and_one_that_is_named_alone(tmp_path):
    numbers = range(40)
    head = ",".join(["id", *(f"p_{i} [mmHg]" for i in numbers), *(f"q_{i} [ml/s]" for i in numbers)])
    rows = [",".join([name, *(str(15 + i % 7) for i in [*numbers, *numbers])]) for name in ("m1", "m2", "m3")]
    (tmp_path / "all.csv").write_text("\n".join([head, *rows, ""]))
    new_study(tmp_path / "study")
    added = add_files(tmp_path / "study", [tmp_path / "all.csv"], cells={"period [s]": "0.11"})
    assert [(row["animal"], row["subject row"]) for row in added.rows] == [("m1", "m1"), ("m2", "m2"), ("m3", "m3")]
    new_study(tmp_path / "other")
    added = add_files(tmp_path / "other", [tmp_path / "all.csv"], cells={"subject row": "m2"})
    assert [row["animal"] for row in added.rows] == ["m2"]


def test_loops_of_a_ventricle_are_named_and_become_no_row(tmp_path):
    rows = "".join(f"{i * 0.001:.3f},{20 + i % 100},{30 - i % 20}\n" for i in range(4000))
    (tmp_path / "rv.csv").write_text("time [s],RV pressure [mmHg],RV volume [ul]\n" + rows)
    saved(tmp_path / "c.xlsx", A=signals(15))
    new_study(tmp_path / "study")
    added = add_files(tmp_path / "study", [tmp_path / "rv.csv", tmp_path / "c.xlsx"])
    assert [row["animal"] for row in added.rows] == ["c"]
    assert "rv.csv: holds a ventricle's volume" in added.refused[0]
    assert "column 'loops'" in added.refused[0]


def test_two_sheets_of_a_workbook_are_two_recordings(tmp_path):
    saved(tmp_path / "c.xlsx", A=signals(15), B=signals(12))
    new_study(tmp_path / "study")
    add_files(tmp_path / "study", [tmp_path / "c.xlsx"], cells={"sheet": "A"})
    table = tmp_path / "study/animals.csv"
    row = table.read_text("utf-8").splitlines()[-1]
    table.write_text(table.read_text("utf-8") + row.replace("c,", "d,", 1).replace("A", "B") + "\n", "utf-8")
    assert [(row["animal"], row["sheet"]) for row in read_rows(table).rows] == [("c", "A"), ("d", "B")]
    assert not [problem for problem in check_study(tmp_path / "study").problems if "same recording" in str(problem)]


def test_another_sheet_of_a_file_that_is_there_becomes_a_row_of_its_own_and_the_same_sheet_keeps_its_row(tmp_path):
    saved(tmp_path / "c.xlsx", A=signals(15), B=signals(12))
    study = tmp_path / "study"
    new_study(study)
    for sheet in ("", "B", "A", "", "b"):
        add_files(study, [tmp_path / "c.xlsx"], cells={"sheet": sheet} if sheet else {})
    assert [(row["animal"], row["sheet"]) for row in read_rows(study / "animals.csv").rows] == [
        ("c", "A"),
        ("c B", "b"),
    ]


def test_a_sheet_is_named_in_the_row_of_a_file_of_which_no_other_row_was_meant(tmp_path):
    saved(tmp_path / "c.xlsx", A=signals(15), B=signals(12))
    study = tmp_path / "study"
    new_study(study)
    add_files(study, [tmp_path / "c.xlsx"], cells={"sheet": "B"})
    add_files(study, [tmp_path / "c.xlsx"])  # as when a folder is added again
    assert [(row["animal"], row["sheet"]) for row in read_rows(study / "animals.csv").rows] == [("c", "B")]


def test_what_was_noticed_of_a_sheet_is_told_in_a_process_that_read_no_workbook(tmp_path):
    saved(tmp_path / "c.xlsx", A=signals(15), B=signals(12))
    with pytest.warns(VasowaveWarning, match="the sheets 'A' and 'B' hold signals") as warned:
        read_raw_recording(tmp_path / "c.xlsx")
    note = finding_of(warned[0].message)
    (tmp_path / "note").write_bytes(pickle.dumps(note))
    told = "import pickle, sys; note = pickle.load(open(sys.argv[1], 'rb')); print(note, note.remedy, len(note.cures))"
    answer = subprocess.run([sys.executable, "-c", told, tmp_path / "note"], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == f"{note} {note.remedy} 1"
