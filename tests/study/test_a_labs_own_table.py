"""A lab's own table of animals (ID, treatment, weight, sex) is read by `add` and by dropping, and is no recording."""

import numpy as np
import openpyxl
import pytest

import vasowave as vw
from made_workbook import write_workbook
from vasowave.base import InputError
from vasowave.pulse.network import write_network
from vasowave.study.entering import add_files, check_study, new_study, read_rows
from vasowave.study.folder import read_settings
from vasowave.study.results import load_animal
from vasowave.study.running import read_study

SHEET = """Animal ID;Treatment;Weight [g];Sex;Date
R1;sham;312;m;2026-03-01
R2;sham;298;f;2026-03-01
R10;MCT;340;m;2026-03-02
R11;MCT;331;f;2026-03-03
"""


def cycle(folder, name, scale=1.0):
    mouse = vw.virtual_mouse()
    rows = np.column_stack([mouse.time, scale * mouse.pressure, mouse.flow])
    folder.mkdir(exist_ok=True, parents=True)
    np.savetxt(folder / f"{name}.csv", rows, "%.9g", ",", header="time [s],pressure [mmHg],flow [ml/s]", comments="")


@pytest.fixture
def lab(tmp_path):
    for number, name in enumerate(("2026 R1 baseline", "2026 R2 baseline", "2026 R10 baseline", "2026 R11 baseline")):
        cycle(tmp_path / "lab", name, 1 + 0.05 * number)
    write_network(vw.control_network(), tmp_path / "lab/lung.csv")
    (tmp_path / "lab/animals of March.csv").write_text(SHEET, "utf-8")
    new_study(tmp_path / "study")
    return tmp_path


def rows(lab):
    return {row["recording"].rpartition("/")[2].split()[1]: row for row in read_rows(lab / "study/animals.csv").rows}


def expected(found):
    assert {key: (row["group"], row["weight [g]"], row["sex"]) for key, row in found.items()} == {
        "R1": ("sham", "312", "m"), "R2": ("sham", "298", "f"), "R10": ("MCT", "340", "m"), "R11": ("MCT", "331", "f")
    }  # fmt: skip


def test_its_cells_become_columns_and_its_treatment_the_group(lab):
    added = add_files(lab / "study", [lab / "lab"])
    assert added.refused == ()
    expected(rows(lab))
    assert read_settings(lab / "study/study.yaml")[0].groups == ["sham", "MCT"]
    assert "a table of 4 animals, which tells group, weight [g], sex, date" in "; ".join(added.said)
    assert [problem for problem in check_study(lab / "study").problems if problem.error] == []


def test_it_may_come_after_the_recordings_and_fills_empty_cells_alone(lab):
    sheet = lab / "lab/animals of March.csv"
    text = sheet.read_text("utf-8")
    sheet.unlink()
    add_files(lab / "study", [lab / "lab"])
    table = (lab / "study/animals.csv").read_text("utf-8")
    (lab / "study/animals.csv").write_text(table.replace("R2 baseline,,", "R2 baseline,sham,"), "utf-8")
    sheet.write_text(text.replace("R2;sham", "R2;MCT"), "utf-8")
    added = add_files(lab / "study", [sheet])
    assert len(added.updated) == 4
    expected(rows(lab))  # the group that was there stays
    assert add_files(lab / "study", [sheet]).updated == ()


def test_a_workbook_is_read_too_and_a_column_that_no_table_can_have_is_left_out_and_named(lab):
    (lab / "lab/animals of March.csv").unlink()
    lines = [line.split(";") for line in SHEET.splitlines()]
    lines = [[*line, extra] for line, extra in zip(lines, ["law", "a", "b", "c", "d"], strict=True)]
    write_workbook(lab / "lab/animals.xlsx", lines)
    added = add_files(lab / "study", [lab / "lab"])
    expected(rows(lab))
    assert any("without law, which a study's table cannot have" in text for text in added.said)


def test_a_number_is_told_from_one_that_begins_alike_and_no_animal_from_two(lab):
    (lab / "lab/animals of March.csv").write_text(SHEET.replace("R", ""), "utf-8")
    add_files(lab / "study", [lab / "lab"])
    expected(rows(lab))
    (lab / "lab/animals of March.csv").write_text("ID;Sex\n1;m\nbaseline;f\n", "utf-8")
    table = (lab / "study/animals.csv").read_text("utf-8").replace(",m,", ",,").replace(",f,", ",,")
    (lab / "study/animals.csv").write_text(table, "utf-8")
    add_files(lab / "study", [lab / "lab/animals of March.csv"])
    assert {key: row["sex"] for key, row in rows(lab).items()} == {"R1": "", "R2": "f", "R10": "f", "R11": "f"}


def test_an_animal_that_stands_twice_makes_it_no_table_of_animals(lab):
    (lab / "lab/animals of March.csv").write_text(SHEET + "R1;sham;1;m;2026-03-04\n", "utf-8")
    with pytest.raises(InputError, match="no recording among these files"):
        add_files(lab / "study", [lab / "lab/animals of March.csv"])


def test_a_recording_whose_rows_are_numbered_is_no_table_of_animals(tmp_path):
    new_study(tmp_path / "s")
    mouse = vw.virtual_mouse()
    rows = (f"{i},{p:.5f},{q:.6f}" for i, (p, q) in enumerate(zip(mouse.pressure, mouse.flow, strict=True)))
    file = tmp_path / "CTL_1.csv"
    file.write_text("\n".join(["id,PAP [mmHg],Q [ml/s]", *rows, ""]))
    added = add_files(tmp_path / "s", [file], cells={"period [s]": "0.1126"})
    assert [row["animal"] for row in added.rows] == ["CTL_1"]


def test_a_workbook_that_holds_the_animals_and_a_recording_is_both(lab):
    book = openpyxl.Workbook()
    for line in SHEET.splitlines():
        book.active.append(line.split(";"))
    mouse, trace = vw.virtual_mouse(), book.create_sheet("trace")
    trace.append(["time [s]", "pressure [mmHg]", "flow [ml/s]"])
    for row in np.column_stack([mouse.time, 2 * mouse.pressure, mouse.flow]):
        trace.append([float(value) for value in row])
    book.save(lab / "R2 all.xlsx")
    added = add_files(lab / "study", [lab / "R2 all.xlsx", lab / "lab/lung.csv"])
    (row,) = added.rows
    assert (row["group"], row["weight [g]"]) == ("sham", "298")
    assert any("'trace'" in text for text in added.said)
    assert [problem for problem in check_study(lab / "study").problems if problem.error] == []
    study = read_study(lab / "study")
    recording = load_animal(study.animals[0], study.settings, study.folder).recording
    assert recording.pressure.mean() == pytest.approx(2 * mouse.pressure.mean(), rel=1e-3)
