"""What lies in an untidy folder: notes, two animals in one file, IDs that are written otherwise than in a table."""

import shlex

import numpy as np
import pytest
from typer.testing import CliRunner

import vasowave as vw
from vasowave.catheter import synthetic_raw_recording
from vasowave.cli import app
from vasowave.pulse.network import write_network
from vasowave.study.entering import add_files, check_study, new_study, read_rows

SHEET = "ID,Treatment,Sex\nR05,control,m\nR06,MCT,f\nR08,MCT,m\n"
NOTES = "Rats, SD, both sexes. MCT 60 mg/kg s.c. on day 0.\nR05 and R06 were recorded at the same time.\n"


@pytest.fixture(scope="module")
def signals():
    """Return time and, of two animals, pressure and flow; the second has half of the flow."""
    raws = [
        synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(k), duration=6.0, sampling_rate=500.0).raw
        for k in (1, 2)
    ]
    return raws[0].time, [(raws[0].pressure, raws[0].flow), (1.5 * raws[1].pressure, 0.5 * raws[1].flow)]


def write(file, signals, labels):
    time, animals = signals
    titles = [f"{signal} {label} [{unit}]" for label in labels for signal, unit in (("PAP", "mmHg"), ("Flow", "ml/s"))]
    columns = [time, *(column for animal in animals for column in animal)]
    np.savetxt(file, np.column_stack(columns), "%.6g", ",", header=",".join(["time [s]", *titles]), comments="")


def folder_of(tmp_path, signals, labels=("R05", "R06"), name="R05_R06.csv"):
    lab = tmp_path / "lab"
    lab.mkdir()
    write(lab / name, signals, labels)
    write_network(vw.control_network(), lab / "lung.csv")
    (lab / "animals.csv").write_text(SHEET, "utf-8")
    (lab / "protocol.txt").write_text(NOTES, "utf-8")
    new_study(tmp_path / "study")
    return lab


def rows(tmp_path):
    return read_rows(tmp_path / "study/animals.csv").rows


def test_two_animals_that_one_file_holds_are_two_rows_each_with_its_channels_and_its_group(tmp_path, signals):
    lab = folder_of(tmp_path, signals)
    added = add_files(tmp_path / "study", [lab])
    assert "R05_R06.csv: holds several animals, by the titles of its channels: R05, R06" in added.said
    cells = [(row["animal"], row["group"], row["pressure channel"], row["flow channel"]) for row in rows(tmp_path)]
    assert cells == [("R05", "control", "PAP R05", "Flow R05"), ("R06", "MCT", "PAP R06", "Flow R06")]
    checked = check_study(tmp_path / "study")
    assert [str(problem) for problem in checked.problems if problem.error] == []
    flows = {animal.animal: float(animal.row()[8]) for animal in checked.read}
    for animal, (_, flow) in zip(("R05", "R06"), signals[1], strict=True):
        assert flows[animal] == pytest.approx(flow.mean(), rel=0.03)
    assert add_files(tmp_path / "study", [lab]).rows == ()
    assert len(rows(tmp_path)) == 2


@pytest.mark.parametrize("letters", [("PAP", "Flow"), ("P", "Q")])
def test_animals_that_every_title_names_are_rows_whatever_their_file_is_called(tmp_path, signals, letters):
    lab = folder_of(tmp_path, signals, ("Rat 5", "Rat 6"), "monday.csv")
    text = (lab / "monday.csv").read_text("utf-8")
    (lab / "monday.csv").write_text(text.replace("PAP", letters[0]).replace("Flow", letters[1]), "utf-8")
    add_files(tmp_path / "study", [lab])
    cells = [(row["animal"], row["pressure channel"], row["flow channel"]) for row in rows(tmp_path)]
    assert cells == [(f"rat {i}", f"{letters[0]} Rat {i}", f"{letters[1]} Rat {i}") for i in (5, 6)]


@pytest.mark.parametrize("labels", [("1", "2"), ("run 1", "run 2"), ("C1", "C2"), ("Rat 5 near", "Rat 5 far")])
def test_numbers_without_a_word_for_an_animal_and_places_in_one_are_no_animals(tmp_path, signals, labels):
    lab = folder_of(tmp_path, signals, labels, "monday.csv")
    add_files(tmp_path / "study", [lab])
    assert len(rows(tmp_path)) == 1


def test_an_ecg_that_two_animals_of_a_file_share_is_of_both(tmp_path, signals):
    lab = folder_of(tmp_path, signals)
    rows_of_file = (lab / "R05_R06.csv").read_text("utf-8").splitlines()
    wider = [rows_of_file[0] + ",ECG [mV]", *(f"{line},{k % 55 == 0:d}" for k, line in enumerate(rows_of_file[1:]))]
    (lab / "R05_R06.csv").write_text("\n".join([*wider, ""]), "utf-8")
    add_files(tmp_path / "study", [lab])
    assert [(row["animal"], row.get("ecg channel", "")) for row in rows(tmp_path)] == [("R05", ""), ("R06", "")]


def test_what_is_said_of_one_of_two_animals_in_a_file_is_written_into_its_row_alone(tmp_path, signals):
    time, (first, (pressure, flow)) = signals
    lab = folder_of(tmp_path, (time, [first, (pressure, flow + 0.03)]))
    add_files(tmp_path / "study", [lab])
    said = CliRunner().invoke(app, ["check", str(tmp_path / "study")]).output
    command = next(line.strip() for line in said.splitlines() if "--flow-zero" in line)
    CliRunner().invoke(app, shlex.split(command)[1:])
    first_zero, second_zero = (row.get("flow zero [ml/s]") for row in rows(tmp_path))
    assert first_zero == ""
    assert float(second_zero) == pytest.approx(0.03, abs=0.005)


@pytest.mark.parametrize(
    ("labels", "name"), [(("proximal", "distal"), "R05.csv"), (("1", "2"), "R05.csv"), (("R05", "R06"), "R05.csv")]
)
def test_channels_of_one_animal_are_no_animals_where_the_file_is_not_called_so(tmp_path, signals, labels, name):
    lab = folder_of(tmp_path, signals, labels, name)
    add_files(tmp_path / "study", [lab])
    assert [row["animal"] for row in rows(tmp_path)] == ["R05"]


def test_notes_in_a_folder_are_no_broken_recording_and_keep_no_network_from_the_animals(tmp_path, signals):
    lab = folder_of(tmp_path, signals)
    added = add_files(tmp_path / "study", [lab])
    assert added.refused == ()
    assert {row["network"] for row in rows(tmp_path)} == {"../lab/lung.csv"}
    named = add_files(tmp_path / "study", [lab / "R05_R06.csv", lab / "protocol.txt"])
    assert [text.rpartition(": ")[2] for text in named.refused] == [
        "a text without numbers, neither a recording nor a network"
    ]


@pytest.mark.parametrize(
    ("name", "sex"),
    [("Rat 8", "m"), ("R8", "m"), ("2026 r08 b", "m"), ("Rat 80", ""), ("Dog 8", ""), ("run 8", ""), ("8", "")],
)
def test_an_id_is_found_where_its_word_is_written_out_and_its_number_without_zeros(tmp_path, signals, name, sex):
    time, (animal, _) = signals
    lab = folder_of(tmp_path, signals)
    (lab / "R05_R06.csv").unlink()
    write(lab / f"{name}.csv", (time, [animal]), ("x",))
    add_files(tmp_path / "study", [lab])
    assert [row.get("sex", "") for row in rows(tmp_path)] == [sex]


def test_a_table_of_animals_that_no_file_is_called_by_is_said_to_be_so(tmp_path, signals):
    lab = folder_of(tmp_path, signals)
    (lab / "old animals.csv").write_text("ID,Sex\nK1,f\nK2,m\n", "utf-8")
    said = add_files(tmp_path / "study", [lab]).said
    assert "old animals.csv: a table of animals (K1 and K2), none of which any file here is called by" in said
    assert "animals.csv: a table of 3 animals, which tells group, sex" in said


def test_a_table_that_comes_later_tells_each_animal_of_a_file_of_two_its_own(tmp_path, signals):
    lab = folder_of(tmp_path, signals)
    sheet = next(file for file in lab.iterdir() if file.read_bytes() == SHEET.encode())
    sheet.unlink()
    add_files(tmp_path / "study", [lab])
    sheet.write_text("ID,Treatment,Sex\nR06,MCT,f\nR09,MCT,m\n")
    add_files(tmp_path / "study", [sheet])
    sex = {row["animal"]: row.get("sex", "") for row in rows(tmp_path)}
    assert (sex["R05"], sex["R06"]) == ("", "f")
