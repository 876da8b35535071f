"""A table of animals of a lab (ID, treatment, weight, sex) is read by `add` and by dropping, not as a recording."""

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
    assert "several" not in "; ".join([*added.said, *add_files(lab / "study", [lab / "lab"]).said])
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


@pytest.mark.parametrize(
    ("title", "cells", "expected_mmhg"),
    [
        ("PCWP", ("8", "9.5", "n/a", "10"), (8, 9.5, None, 10)),
        ("Wedge pressure (mmHg)", ("8", "9.5", "8", "10"), (8, 9.5, 8, 10)),
        ("Keil [kPa]", ("1", "1.2", "1", "1"), (7.5006, 9.0007, 7.5006, 7.5006)),  # 1 kPa is 7.5006 mmHg
        ("PAWP cmH2O", ("10", "10", "10", "10"), (7.3556,) * 4),  # 1 cmH2O is 0.73556 mmHg
    ],
)
def test_a_column_of_wedge_pressures_is_one_whatever_its_title_and_unit_and_this_is_said(
    lab, title, cells, expected_mmhg
):
    sheet = lab / "lab/animals of March.csv"
    lines = [f"{line};{cell}" for line, cell in zip(SHEET.splitlines(), (title, *cells), strict=True)]
    sheet.write_text("\n".join([*lines, ""]), "utf-8")
    added = add_files(lab / "study", [lab / "lab"])
    wedges = {row.animal.split()[1]: row.wedge for row in read_study(lab / "study").animals}
    assert [wedges[name] for name in ("R1", "R2", "R10", "R11")] == [
        value and pytest.approx(value, rel=1e-4) for value in expected_mmhg
    ]
    assert any(f"'{title}' was taken for wedge [mmHg]" in text for text in added.said)
    assert not [problem for problem in check_study(lab / "study").problems if "remove the column" in str(problem)]


def test_a_column_called_wedge_is_the_wedge_pressure_though_that_of_the_left_atrium_stands_before_it(lab):
    sheet = lab / "lab/animals of March.csv"
    lines = [f"{line};{cell}" for line, cell in zip(SHEET.splitlines(), ("LAP [mmHg];wedge [mmHg]", *["5;8"] * 4))]
    sheet.write_text("\n".join([*lines, ""]), "utf-8")
    said = "; ".join(add_files(lab / "study", [lab / "lab"]).said)
    assert [row.wedge for row in read_study(lab / "study").animals] == [8] * 4
    assert "taken for wedge" not in said


def test_a_wedge_of_another_unit_that_is_no_number_is_refused_with_what_brings_it_to_mmhg(lab):
    sheet = lab / "lab/animals of March.csv"
    lines = [f"{line};{cell}" for line, cell in zip(SHEET.splitlines(), ("PCWP [cmH2O]", "10*", "9", "9", "9"))]
    sheet.write_text("\n".join([*lines, ""]), "utf-8")
    add_files(lab / "study", [lab / "lab"])
    (error,) = (problem for problem in check_study(lab / "study").problems if problem.error)
    assert "'10* times 0.7356' is not a number" in str(error)  # 1 cmH2O is 0.73556 mmHg


@pytest.mark.parametrize(("title", "meant"), [("PCWP [mmHg]", "wedge [mmHg]"), ("Hct (%)", "hematocrit [1]")])
def test_a_number_of_another_title_in_the_studys_own_table_is_asked_for_and_no_covariate(lab, title, meant):
    add_files(lab / "study", [lab / "lab"])
    table = lab / "study/animals.csv"
    table.write_text(table.read_text("utf-8").replace("weight [g]", title), "utf-8")
    (error,) = (problem for problem in check_study(lab / "study").problems if problem.error)
    assert f"unknown column (did you mean '{meant}'?)" in str(error)


def test_groups_that_differ_in_capitals_or_spaces_are_one_and_this_is_said(lab):
    sheet = lab / "lab/animals of March.csv"
    sheet.write_text(SHEET.replace("R11;MCT", "R11;mct ").replace("R2;sham", "R2;Sham"), "utf-8")
    added = add_files(lab / "study", [lab / "lab"])
    expected(rows(lab))
    assert "the group 'mct' was taken for 'MCT'" in "; ".join(added.said)


def slips(lab, *groups):
    """Return what is said of groups of these animals by code, and the cures by what they write."""
    for number in range(len(groups)):
        cycle(lab / "lab", f"{number} rat", 1 + 0.05 * number)
    lines = [f"{number};{group}" for number, group in enumerate(groups)]
    (lab / "lab/animals of March.csv").write_text("\n".join(["ID;Group", *lines, ""]), "utf-8")
    files = [*(lab / "lab").glob("? rat.csv"), lab / "lab/animals of March.csv", lab / "lab/lung.csv"]
    add_files(lab / "study", files)
    findings = [problem.finding for problem in check_study(lab / "study").problems]
    return {finding.code: finding for finding in findings if finding.code.startswith("animals.")}


def test_a_slip_in_a_group_is_asked_about_with_the_group_that_was_meant(lab):
    found = slips(lab, "Control", "Contol", "Control", "HPH", "HPH")
    slip = found.pop("animals.group-slip")
    assert found == {}
    assert "'Contol' in 1 rat alone, 'Control' in 2: did you mean 'Control'?" in str(slip)
    cell, groups = slip.cures
    assert (cell.cells, groups.key, groups.text) == ((("group", "Control"),), "groups", "[Control, HPH]")


def test_groups_of_nearly_one_name_with_several_animals_each_are_two_groups(lab):
    assert slips(lab, "CTL", "CTL", "CTR", "CTR", "HPH", "HPH") == {}


def test_two_recordings_of_a_misspelt_group_beside_six_are_asked_about(lab):
    slip = slips(lab, *["vehicle"] * 6, "vehcile", "vehcile")["animals.group-slip"]
    assert "'vehcile' in 6 rat and 7 rat alone, 'vehicle' in 6: did you mean 'vehicle'?" in str(slip)


def test_two_recordings_of_a_group_with_swapped_letters_are_asked_about_beside_as_many(lab):
    found = slips(lab, "vehicle", "vehicle", "vehcile", "vehcile", "drug", "drug", "drug", "drug")
    assert "did you mean" in str(found["animals.group-slip"])


def test_one_animal_of_a_group_of_another_name_is_no_slip(lab):
    assert [*slips(lab, "CTL", "CTL", "SuHx")] == ["animals.small-group"]


def test_an_animal_of_several_recordings_is_a_subject_and_check_asks_for_its_design(lab):
    for number, name in enumerate(("2026 R1 after", "2026 R10 after")):
        cycle(lab / "lab", name, 1.33 + 0.05 * number)
    added = add_files(lab / "study", [lab / "lab"])
    assert "several recordings of R1 and R10: column subject" in "; ".join(added.said)
    subjects = {row["animal"]: row["subject"] for row in read_rows(lab / "study/animals.csv").rows}
    assert subjects == {
        f"2026 {key} {when}": key
        for key, when in [("R1", "after"), ("R1", "baseline"), ("R2", "baseline"), ("R10", "after"),
                          ("R10", "baseline"), ("R11", "baseline")]
    }  # fmt: skip
    assert any("subject" in str(problem) for problem in check_study(lab / "study").problems)


def test_two_files_of_one_name_in_one_folder_are_recordings_of_one_subject(lab):
    cycle(lab / "spare", "2026 R1 baseline", 1.4)
    text = (lab / "spare/2026 R1 baseline.csv").read_text()
    (lab / "lab/2026 R1 baseline.tsv").write_text(text.replace(",", "\t"))
    added = add_files(lab / "study", [lab / "lab"])
    assert "several recordings of R1: column subject" in "; ".join(added.said)
    assert [row["subject"] for row in read_rows(lab / "study/animals.csv").rows].count("R1") == 2


HEMATOCRIT, TEMPERATURE, PERCENT = "hematocrit [1]", "temperature [°C]", ("41", "44", "39", "45")
TITLES = {  # cells, column, value of the first
    "Hct (%)": (PERCENT, HEMATOCRIT, 0.41),
    "Temp °C": (("36.5", "37", "36", "37.2"), TEMPERATURE, 36.5),
    "PAWP mmHg": (("8", "9", "8", "7"), "wedge [mmHg]", 8.0),
    "zero [kPa]": (("0.1", "0.1", "0.1", "0.1"), "zero [mmHg]", 0.75006),
    "flow delay (ms)": (("4", "4", "4", "4"), "flow delay [s]", 0.004),
    "Haematocrit": (("0.41", "0.44", "0.39", "0.45"), HEMATOCRIT, 0.41),
    "Body temperature (°F)": (("98.6", "98", "99", "97"), TEMPERATURE, 37.0),
    "LAP (kPa)": (("1.0", "1.1", "1.2", "1.3"), "wedge [mmHg]", 7.5006),
    "hematocrit %": (PERCENT, HEMATOCRIT, 0.41),
    "Rectal temp": (("36.5", "37", "36", "37.2"), TEMPERATURE, 36.5),
    "PCV": (PERCENT, HEMATOCRIT, 0.41),
}


def test_a_number_in_our_own_unit_keeps_its_digits(lab):
    lines = [f"{line};{cell}" for line, cell in zip(SHEET.splitlines(), ("start [s]", *["0.12345678"] * 9))]
    (lab / "lab/animals of March.csv").write_text("\n".join([*lines, ""]), "utf-8")
    add_files(lab / "study", [lab / "lab"])
    assert rows(lab)["R1"]["start [s]"] == "0.12345678"


@pytest.mark.parametrize("titles", [[*TITLES][:5], [*TITLES][5:8], [*TITLES][8:10], [*TITLES][10:]])
def test_numbers_of_the_blood_and_others_are_known_by_the_titles_and_units_of_labs_and_this_is_said(lab, titles):
    columns = [(title, *TITLES[title][0]) for title in titles]
    lines = [";".join([line, *cells]) for line, *cells in zip(SHEET.splitlines(), *columns)]
    (lab / "lab/animals of March.csv").write_text("\n".join([*lines, ""]), "utf-8")
    added = add_files(lab / "study", [lab / "lab"])
    for title in titles:
        _, column, first = TITLES[title]
        assert float(rows(lab)["R1"][column]) == pytest.approx(first, rel=1e-4)
        assert title.casefold() not in {name.casefold() for name in rows(lab)["R1"]}
        assert any(f"'{title}' was taken for {column}" in text for text in added.said)
    assert [problem for problem in check_study(lab / "study").problems if problem.error] == []


@pytest.mark.parametrize(
    ("title", "column"), [("Room temp", "temperature [°C]"), ("Hct week 3", "hematocrit [1]"), ("Start", "")]
)
def test_a_title_that_only_resembles_one_stays_the_labs_own_and_this_is_said(lab, title, column):
    sheet = lab / "lab/animals of March.csv"
    lines = [f"{line};{cell}" for line, cell in zip(SHEET.splitlines(), (title, "21", "22", "20", "21"))]
    sheet.write_text("\n".join([*lines, ""]), "utf-8")
    said = "; ".join(add_files(lab / "study", [lab / "lab"]).said)
    assert bool(column) == (f"stays a column of your own, not {column}" in said)
    assert "temperature [°C]" not in rows(lab)["R1"]
    assert "start [s]" not in rows(lab)["R1"]
