"""The way of a newcomer: a folder of recordings, and `new`, `add`, `check`, `run` typed from wherever one stands."""

import csv
import os
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat
from typer.testing import CliRunner

from lab_files import SMALL, exported, recorded, write_lab
from vasowave.base import NameGroups
from vasowave.cli import Shell, app
from vasowave.pulse.network import write_network
from vasowave.study.entering import add_files
from vasowave.study.results import read_results

pytestmark = pytest.mark.usefixtures("undrawn")

MICE = {"WT_101": 14.2, "WT_102": 15.3, "WT_103": 13.6, "HOX_1": 27.9, "HOX_2": 30.2, "HOX_3": 25.4}
DRIFTS = {"WT_102": -4.0, "HOX_2": 6.0}


def typed(*words):
    """Run a command; it must succeed."""
    done = CliRunner().invoke(app, list(map(str, words)))
    assert done.exit_code == 0, f"{done.output}{done.exception}"
    return done.output


def table(study):
    lines = (study / "animals.csv").read_text("utf-8").splitlines()
    return {row["animal"]: row for row in csv.DictReader(line for line in lines if not line.startswith("#"))}


def labchart(folder, name, seed, mean):
    gap = (2.0, 2.35) if name == "HOX_1" else None
    (folder / f"{name}.txt").write_text(exported(recorded(seed, mean, DRIFTS.get(name, 0.0)), gap=gap), "utf-8")


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    return write_lab(tmp_path_factory.mktemp(".hidden above") / "lab" / "raw data ü", labchart, MICE)


def quick(study):
    text = (study / "study.yaml").read_text("utf-8")
    for key, value in (("walls", "[linear]"), ("starts", "1"), ("cell_size", "0.3"), ("pdf", "false")):
        text = re.sub(rf"^  {key}: .*$", f"  {key}: {value}", text, flags=re.MULTILINE)
    (study / "study.yaml").write_text(text, "utf-8")


@pytest.mark.validation
def test_six_labchart_files_become_results_with_four_commands_and_nothing_to_mend(lab, monkeypatch):
    monkeypatch.chdir(lab.parent)
    typed("new", "my-study")
    study = lab.parent / "my-study"
    monkeypatch.chdir(study)
    said = typed("add", ".", "../raw data ü")
    assert "animals.csv: 6 new rows" in said
    assert "note: groups: names begin with WT (3 of them) and HOX (3 of them)" in said
    assert "study.yaml: groups are [WT, HOX] now, the first is the reference" in said
    assert "6 more" not in said
    assert said.count("'Lead II' was taken for ecg: no other has such a unit") == 1
    assert "HOX_1.txt: samples are missing; the longest stretch without a gap is read, 2.35 to 9 s" in said
    assert "The study can run: vasowave run ." in said
    assert max(map(len, said.partition("Animals 6")[0].splitlines())) <= 80
    rows = table(study)
    assert {name: row["group"] for name, row in rows.items()} == {name: name.split("_")[0] for name in MICE}
    assert (rows["HOX_1"]["start [s]"], rows["HOX_1"]["end [s]"]) == ("2.35", "9")
    assert typed("check").endswith("0 errors, 2 warnings; each by itself: vasowave -v check .\n")
    checked = typed("-v", "check")
    assert "\n0 errors, 2 warnings\n" in checked
    for name, drift in DRIFTS.items():
        (line,) = [line for line in checked.splitlines() if line.startswith("warning") and f"('{name}')" in line]
        assert f"drifts by {'+' if drift > 0 else '-'}" in line
        assert "removed" in line
    before = (study / "animals.csv").read_text("utf-8")
    again = typed("add", "../raw data ü")
    assert "0 new rows" in again
    assert "6 of these recordings are in the table already" in again
    one = typed("add", "../raw data ü/WT_101.txt")  # a file, from inside the study
    assert "1 of these recordings are in the table already" in one
    assert (study / "animals.csv").read_text("utf-8") == before
    quick(study)
    ran = typed("run", "--workers", "1", "--no-report")
    assert "6 animals computed, 0 kept from earlier, 0 failed." in ran
    results = read_results(study)
    for name, mean in MICE.items():
        assert results[name].recording.attrs["source"] == f"../raw data ü/{name}.txt"
        assert float(results[name].recording["mPAP"]) == pytest.approx(mean, abs=0.25), name
    monkeypatch.chdir(lab.parent)
    assert "6 of 6 animals done; not being run" in typed("status", "my-study")


@pytest.mark.parametrize(
    "way",
    [
        *(pytest.param(one, marks=pytest.mark.validation) for one in ("relative", "absolute", "dots", "link")),
        "files",
        "link inside",
    ],
)
def test_a_folder_is_found_on_every_way_to_it_whatever_is_hidden_above(lab, tmp_path, monkeypatch, way):
    home = tmp_path / ".cache" / "me"
    home.mkdir(parents=True)
    monkeypatch.chdir(home)
    typed("new", "s")
    (home / "link").symlink_to(lab)
    (home / "around").mkdir()
    (home / "around" / "in").symlink_to(lab)
    (home / "around" / "back").symlink_to(home / "around")
    (home / "around" / ".git").mkdir()
    (home / "around" / ".git" / "WT_7.txt").write_text("hidden inside what is named", "utf-8")
    paths = {
        "relative": [os.path.relpath(lab)],
        "absolute": [lab],
        "dots": [f"./s/../{os.path.relpath(lab)}/../{lab.name}"],
        "link": ["link"],
        "files": sorted(lab.iterdir()),
        "link inside": ["around"],
    }[way]
    added = add_files(Path("s"), [Path(one) for one in paths])
    assert len(added.rows) == 6
    for row in table(home / "s").values():
        assert (home / "s" / row["recording"]).samefile(lab / Path(row["recording"]).name)
        assert row["network"]
    assert add_files(home / "s", [lab]).rows == ()


def test_a_study_that_is_reached_by_a_link_names_files_that_exist(lab, tmp_path, monkeypatch):
    typed("new", tmp_path / "far" / "deep" / "s")
    (tmp_path / "near").symlink_to(tmp_path / "far" / "deep" / "s")
    monkeypatch.chdir(tmp_path)
    add_files(Path("near"), [lab / "WT_101.txt", lab / "lung.csv"])
    (row,) = table(tmp_path / "near").values()
    assert (tmp_path / "near" / row["recording"]).is_file()


def test_the_column_group_and_all_others_stay_and_an_option_fills_the_row_again(lab, tmp_path):
    study = tmp_path / "s"
    typed("new", study)
    text = (study / "animals.csv").read_text("utf-8")
    (study / "animals.csv").write_text(text.replace("flow,kind", "weight,flow,kind"), "utf-8")
    added = add_files(study, [lab / "WT_101.txt", lab / "lung.csv"])
    assert any(
        "neither name nor folder tells the group" in one and "name the groups as names hold them" in one
        for one in added.said
    )
    header = next(line for line in (study / "animals.csv").read_text("utf-8").splitlines() if not line.startswith("#"))
    assert header.startswith("animal,group,network,recording,weight,flow,kind,period [s]")
    assert table(study)["WT_101"]["group"] == ""
    again = add_files(study, [lab / "WT_101.txt"], group="WT", cells={"start [s]": "1", "end [s]": "8"})
    before = (study / "study.yaml").read_bytes()
    add_files(study, [lab / "WT_101.txt"], group="Slip")  # the row has a group
    assert (study / "study.yaml").read_bytes() == before
    assert (again.rows, again.updated) == ((), ("WT_101",))
    row = table(study)["WT_101"]
    assert (row["group"], row["start [s]"], row["end [s]"]) == ("WT", "1", "8")
    text = (study / "animals.csv").read_text("utf-8")
    (study / "animals.csv").write_text(text.replace("WT_101,WT", "Mouse A,WT"), "utf-8")
    add_files(study, [lab / "WT_101.txt"])
    assert list(table(study)) == ["Mouse A"]  # what a person wrote stays


def test_a_copy_is_left_out_and_a_file_that_moved_keeps_its_row(lab, tmp_path):
    study, raw = tmp_path / "s", tmp_path / "raw"
    raw.mkdir()
    for place in (raw / "WT_101.txt", raw / "WT_101 (copy).txt"):  # the copy comes first in the folder
        place.write_bytes((lab / "WT_101.txt").read_bytes())
    typed("new", study)
    added = add_files(study, [raw, lab / "lung.csv"], group="CTL")
    assert len(added.rows) == 1
    assert added.rows[0]["animal"] == "WT_101"
    (said,) = [one for one in added.said if one.endswith("left out")]
    assert "WT_101 (copy).txt: holds the same bytes as the recording of WT_101.txt" in said
    (raw / "WT_101 (copy).txt").unlink()
    raw.rename(tmp_path / "moved")
    again = add_files(study, [tmp_path / "moved"])
    assert again.rows == ()
    (row,) = table(study).values()
    assert (study / row["recording"]).is_file()


def test_files_of_one_name_in_two_folders_are_called_by_their_folders_too(lab, tmp_path):
    for group, source in (("sham", "WT_101.txt"), ("banded", "HOX_2.txt")):
        (tmp_path / "lab" / group).mkdir(parents=True)
        (tmp_path / "lab" / group / "1.txt").write_bytes((lab / source).read_bytes())
    typed("new", tmp_path / "s", "--groups", "sham,banded")
    added = add_files(tmp_path / "s", [tmp_path / "lab", lab / "lung.csv"])
    assert {row["animal"]: row["group"] for row in added.rows} == {"sham 1": "sham", "banded 1": "banded"}


def test_groups_that_a_user_chose_are_not_replaced_and_one_option_says_which_is_which(lab, tmp_path):
    study = tmp_path / "s"
    typed("new", study, "--groups", "control,hypoxic")
    first = add_files(study, [lab])
    assert any("Say which is which: control=WT,hypoxic=HOX" in one for one in first.said)
    assert NameGroups("control=WT,hypoxic=HOX") in first.cures
    assert {row["group"] for row in table(study).values()} == {""}
    second = add_files(study, [lab], groups="control=WT,hypoxic=HOX")
    assert len(second.updated) == 6
    assert {row["group"] for row in table(study).values()} == {"control", "hypoxic"}


def test_a_person_is_asked_for_the_groups_once(lab, tmp_path):
    asked = []

    def ask(question, proposal):
        asked.append((question, proposal))
        return "HOX,WT"

    typed("new", tmp_path / "s")
    add_files(tmp_path / "s", [lab], ask=ask)
    assert asked == [("Names begin with wt (3 of them) and hox (3 of them). Groups, the reference first", "WT,HOX")]
    assert "groups: [HOX, WT]" in (tmp_path / "s" / "study.yaml").read_text("utf-8")


def comma(folder, name, seed, mean):
    raw, place = recorded(seed + 20, mean), folder / name.split()[0]
    place.mkdir(exist_ok=True)
    rows = [f"{t:.3f};{p / 7.50062:.5f};{60 * q:.4f}" for t, p, q in zip(raw.time, raw.pressure, raw.flow)]
    text = "\ufeffZeit (s);Druck (kPa);Fluss (ml/min)\r\n" + "\r\n".join(rows).replace(".", ",") + "\r\n"
    (place / f"Tier {name.split()[1]}.csv").write_text(text, encoding="utf-8")


def matlab(folder, name, seed, mean):
    raw = recorded(seed + 30, mean)
    signals = {"t": raw.time, "P": raw.pressure, "Q": raw.flow, "P_unit": "mmHg", "Q_unit": "ml/s"}
    savemat(folder / f"{name.replace(' ', '')}.mat", signals)


def pauses(folder, name, seed, mean):
    raw = recorded(seed + 40, mean)
    kept = (raw.time < 2.0) | (raw.time >= 2.5) | (seed > 0)
    rows = [f"{t:.3f},{a:.3f},{p:.3f},{q:.5f}" for t, a, p, q in
            zip(raw.time[kept], raw.pressure[kept] + 70, raw.pressure[kept], raw.flow[kept])]  # fmt: skip
    text = "\n".join(["Time [s],BP aortic [mmHg],PA [mmHg],Transonic [ml/s]", *rows, ""])
    (folder / f"{name}.csv").write_text(text, "utf-8")


@pytest.mark.parametrize("habit", [comma, matlab, pauses])
def test_other_labs_habits_need_no_mending_either(habit, tmp_path):
    mice = {"KO 1": 26.0, "KO 2": 24.0, "WT 1": 14.0, "WT 2": 15.0}
    write_lab(tmp_path / "lab", habit, mice)
    typed("new", tmp_path / "s")
    said = typed("add", tmp_path / "s", tmp_path / "lab")
    assert "The study can run" in said
    rows = table(tmp_path / "s")
    assert sorted(row["group"] for row in rows.values()) == ["KO", "KO", "WT", "WT"]
    starts = [row.get("start [s]", "") for row in rows.values()]
    assert starts == (["2.5", "", "", ""] if habit is pauses else [""] * 4)


@pytest.mark.validation
def test_fit_reads_what_add_reads_says_how_to_cut_a_gap_and_status_knows_it(lab, tmp_path, monkeypatch):
    write_network(SMALL, tmp_path / "n.csv")
    monkeypatch.chdir(tmp_path)
    words = ["fit", "n.csv", lab / "HOX_1.txt", "-o", "fit", "--walls", "linear", "--starts", "1", "--no-pdf"]
    refused = CliRunner().invoke(app, list(map(str, words)))
    assert "no samples from 2 to 2.35 s; the longest stretch without a gap is 2.35 to 9 s" in str(refused.exception)
    (proposed,) = (Shell().command(cure).split() for cure in refused.exception.cures)
    assert proposed == ["--start=2.35", "--end=9"]
    said = typed(*words, *proposed, "--channel", "pressure=pressure 1", "--cell-size", "0.3")
    assert "best fit, linear wall: beta" in said
    (result,) = read_results(tmp_path / "fit").in_order()
    assert float(result.recording["mPAP"]) == pytest.approx(MICE["HOX_1"], abs=0.25)
    told = r"HOX_1: done\n1 of 1 animal done; not being run\nThe last run, of [-\d]+ [:\d]+: finished\n"
    assert re.fullmatch(told, typed("status", "fit"))
    wrong = CliRunner().invoke(app, [*map(str, words), "--channel", "presure=Pressure 1"])
    assert "--channel presure=Pressure 1: write pressure=… or flow=… or ecg=…" in str(wrong.exception)
    missing = CliRunner().invoke(app, [*map(str, words), *proposed, "--channel", "flow=Pressure 2"])
    assert "no channel 'Pressure 2' (did you mean 'Pressure 1'?)" in str(missing.exception)

    drawn = typed("posterior", "fit", "--draws", "40", "-o", "p.nc")
    assert re.search(r"^wave_speed +[\d.]+ +\[[\d.]+, [\d.]+\] .* cm/s$", drawn, re.MULTILINE)
    assert re.search(r"Pareto k -?[\d.]+, \d+ of 40 draws effective", drawn)
    assert max(map(len, drawn.partition("The sampling")[0].splitlines())) <= 80
    assert (tmp_path / "p.nc").stat().st_size > 1000
    assert "brings recording and settings along; leave out --seed" in str(
        CliRunner().invoke(app, ["posterior", "fit", "--seed", "1", "-o", "q.nc"]).exception
    )

    typed("sweep", "fit", "--vary", "R_T=60:120:3", "--vary", "beta=40,80", "-o", "s.csv", "--plot", "s.png")
    rows = list(csv.DictReader((tmp_path / "s.csv").read_text("utf-8").splitlines()))
    assert [float(row["R_T [mmHg s/ml]"]) for row in rows] == [60, 60, 90, 90, 120, 120]
    means = np.array([float(row["mean [mmHg]"]) for row in rows]).reshape(3, 2)
    assert np.all(np.diff(means, axis=0) > 0)
    for row in rows:
        pulse = float(row["systolic [mmHg]"]) - float(row["diastolic [mmHg]"])
        assert float(row["pulse [mmHg]"]) == pytest.approx(pulse, abs=1e-3)
    assert (tmp_path / "s.png").read_bytes().startswith(b"\x89PNG")


def test_times_without_a_unit_are_asked_for_once_and_never_assumed(tmp_path):
    def unitless(folder, name, seed, mean):
        pauses(folder, name, seed, mean)
        path = folder / f"{name}.csv"
        path.write_text(path.read_text("utf-8").replace("Time [s]", "Time"))

    lab = write_lab(tmp_path / "lab", unitless, {"KO 1": 26.0, "WT 1": 14.0})
    typed("new", tmp_path / "s", "--groups", "WT,KO")
    add = ["add", str(tmp_path / "s"), str(lab)]
    added = CliRunner().invoke(app, add)
    assert added.exit_code == 3  # a file could not be read
    refused = added.output
    assert "column 'time' has no unit; write it in the header ('time [s]'), or say how many samples" in refused
    assert "(the same in line" in refused
    rated = CliRunner().invoke(app, [*add, "--sampling-rate", "1000"])
    again = rated.output
    assert rated.exit_code == 3  # for the gap
    assert "2 rows updated" in again
    assert "no samples from 2 to 2.5 s; the longest stretch without a gap is 2.5 to 9 s" in again
