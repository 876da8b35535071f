"""What `check` warns of is said at every door, and no file, animal, group or fit is lost in silence."""

import csv
import json
import re
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from vasowave.base import VasowaveWarning
from vasowave.cli import app
from vasowave.pulse.cycle import Recording
from vasowave.pulse.network import write_network
from vasowave.study.cohort import Design
from vasowave.study.entering import add_files
from vasowave.study.results import write_results
from vasowave.study.running import read_study

pytestmark = pytest.mark.usefixtures("undrawn")

QUICK = ["--walls", "linear", "--starts", "1", "--no-pdf", "--cell-size", "0.3", "--no-model-selection"]


def typed(*words, status=0):
    done = CliRunner().invoke(app, list(map(str, words)))
    assert done.exit_code == status, (done.output, done.exception)
    return done.output


def cycle_text(cycle, flow_unit="ml/s", flow_scale=1.0):
    rows = (f"{t:.6f},{p:.6f},{q * flow_scale:.6f}" for t, p, q in zip(cycle.time, cycle.pressure, cycle.flow))
    return "\n".join([f"time [s],pressure [mmHg],flow [{flow_unit}]", *rows, ""])


def groups_of(study):
    lines = [line for line in (study / "animals.csv").read_text("utf-8").splitlines() if not line.startswith("#")]
    return {row["animal"]: row["group"] for row in csv.DictReader(lines)}


def chosen_groups(study):
    return re.search(r"^groups: (.*)$", (study / "study.yaml").read_text("utf-8"), re.MULTILINE)[1]


@pytest.fixture
def lab(tmp_path, mice):
    """Return a folder of four cycles and a network."""
    folder = tmp_path / "lab"
    folder.mkdir()
    from vasowave.pulse.network import Network

    write_network(Network(("1", "2", "3"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037]), folder / "lung.csv")
    for name, mouse, shift in (("Nx_1", 0, 0.0), ("Nx_2", 1, 0.0), ("SuHx_1", 2, 1.0), ("SuHx_2", 2, 2.0)):
        moved = Recording(mice[mouse].pressure + shift, mice[mouse].flow, mice[mouse].period)
        (folder / f"{name}.csv").write_text(cycle_text(moved), "utf-8")
    return folder


def test_the_first_group_of_the_option_stays_the_reference(lab, tmp_path):
    study = tmp_path / "s"
    typed("new", study, "--groups", "normoxia,SuHx")
    first = add_files(study, [lab / "Nx_1.csv", lab / "SuHx_1.csv", lab / "lung.csv"])
    assert any("neither name nor folder tells the group" in one for one in first.said)
    again = add_files(study, [lab / "Nx_1.csv", lab / "SuHx_1.csv"], groups="normoxia=Nx,SuHx")
    assert chosen_groups(study) == "[normoxia, SuHx]"
    assert not any("groups are" in one for one in again.said)
    assert groups_of(study) == {"Nx_1": "normoxia", "SuHx_1": "SuHx"}


@pytest.mark.validation
def test_an_implausible_flow_is_said_by_add_run_fit_and_in_front_of_the_page(lab, tmp_path, mice):
    study = tmp_path / "s"
    (lab / "SuHx_2.csv").write_text(cycle_text(mice[2], flow_unit="ml/min"), "utf-8")  # the numbers are ml/s
    for one in ("Nx_1", "SuHx_1"):  # two animals show it
        (lab / f"{one}.csv").unlink()
    typed("new", study, "--groups", "Nx,SuHx")
    added = typed("add", study, lab)
    text = (study / "study.yaml").read_text("utf-8")
    text = re.sub(r"walls: .*", "walls: [linear]", text)
    text = re.sub(r"starts: \d+", "starts: 1", re.sub(r"cell_size: .*", "cell_size: 0.3", text))
    text = re.sub(r"model_selection: .*", "model_selection: false", re.sub(r"pdf: .*", "pdf: false", text))
    (study / "study.yaml").write_text(text, "utf-8")
    checked = typed("check", study)
    ran = typed("run", study, "--workers", "1")
    fitted = typed("fit", lab / "lung.csv", lab / "SuHx_2.csv", "-o", tmp_path / "fit", *QUICK)
    page = (study / "report" / "report.html").read_text("utf-8")
    single = (tmp_path / "fit" / "report" / "report.html").read_text("utf-8")
    for said in (added, checked, ran, fitted):
        warnings = [line for line in said.splitlines() if "warning: " in line]
        assert any("a mouse has about 0.2 ml/s" in line for line in warnings)
        assert any("is implausible for a mouse" in line for line in warnings)
    for shown in (page, single):
        front = shown.partition("Recordings to look at")[2]
        assert "SuHx_2: mean flow" in front
        assert "is implausible for a mouse (0.05 to 0.45)" in front
        assert "All fits succeeded" not in shown
    (event,) = [json.loads(line) for line in typed("run", study, "--json").splitlines() if '"done", "results"' in line]
    assert {one["code"] for one in event["warnings"]} >= {"recording.odd-flow", "physiology.implausible"}
    assert {one["animal"] for one in event["warnings"]} == {"SuHx_2"}

    changed = (study / "animals.csv").read_text("utf-8").replace("Nx_2,Nx", "Nx_2,SuHx")
    typed("report", study)
    (study / "animals.csv").write_text(changed, "utf-8")
    with pytest.warns(VasowaveWarning, match="Nx_2.*run it again: what changed is computed"):
        typed("report", study)
    assert f"the study is {study}" in str(CliRunner().invoke(app, ["status", str(study / "report")]).exception)

    other = CliRunner().invoke(app, ["fit", *map(str, (lab / "lung.csv", lab / "Nx_2.csv", "-o", tmp_path / "fit"))])
    assert "holds the fit of 'SuHx_2' from " in str(other.exception)


def test_files_that_cannot_be_read_are_counted_and_the_exit_says_so(lab, tmp_path):
    (lab / "SuHx_9.csv").write_text("time [s],pressure [mmHg],flow [ml/s]\n0.001,x,y\n0.002,1,2\n", "utf-8")
    typed("new", tmp_path / "s", "--groups", "Nx,SuHx")
    said = typed("add", tmp_path / "s", lab, status=3)
    assert f"error: not added: {lab / 'SuHx_9.csv'}" in said
    assert "1 file of these could not be read: no row of the table holds such a file" in said
    assert len(groups_of(tmp_path / "s")) == 4


def test_a_group_is_given_to_what_is_added_alone_and_a_new_one_is_said(lab, tmp_path):
    study = tmp_path / "s"
    typed("new", study, "--groups", "Nx,SuHx")
    typed("add", study, lab / "Nx_1.csv", lab / "SuHx_1.csv", lab / "lung.csv")
    said = typed("add", study, lab / "Nx_1.csv", lab / "SuHx_2.csv", "--group", "late")
    assert groups_of(study) == {"Nx_1": "Nx", "SuHx_1": "SuHx", "SuHx_2": "late"}
    assert "Nx_1: in the table already, with another group than late, and stays there" in said
    assert "groups are [Nx, SuHx, late] now, the first is the reference; 'late' is new" in said


def test_status_says_of_which_earlier_design_the_results_are(lab, tmp_path):
    study = tmp_path / "s"
    typed("new", study, "--groups", "Nx,SuHx")
    typed("add", study, lab / "Nx_1.csv", lab / "lung.csv")
    plan = read_study(study)
    (study / "results").mkdir()
    write_results(study / "results", {}, (), plan.settings, plan.variables)
    assert "earlier" not in typed("status", study)
    table = study / "animals.csv"
    *above, header, row = table.read_text("utf-8").rstrip().splitlines()
    table.write_text("\n".join([*above, f"{header},sex", f"{row},f", ""]), "utf-8")
    other = replace(plan.settings, design=Design(covariates=("weight",)))
    write_results(study / "results", {}, (), other, plan.variables)
    said = typed("status", study)
    assert "The results are of an earlier design and column 'sex'; vasowave run" in said


def test_a_group_in_other_letters_is_proposed(lab, tmp_path):
    typed("new", tmp_path / "s", "--groups", "Nx,SuHx")
    refused = CliRunner().invoke(app, ["add", str(tmp_path / "s"), str(lab), "--group", "suhx"])
    assert "'suhx' is not a group of the study (did you mean 'SuHx'?)" in str(refused.exception)


def test_the_block_that_is_read_is_said_where_there_are_several(tmp_path):
    from test_adding_files import exported, with_decimal_commas_and_a_short_block

    (tmp_path / "m.txt").write_text(with_decimal_commas_and_a_short_block(exported(4, 15.0)), "utf-8")
    typed("new", tmp_path / "s")
    (said,) = [one for one in add_files(tmp_path / "s", [tmp_path / "m.txt"]).said if "block" in one]
    words = r"m.txt: block 2 of 2 is read, the longest \(blocks last [\d.]+ s, 12 s\); the column .block. takes another"
    assert re.search(words, said)
    assert not any("block" in one for one in add_files(tmp_path / "s", [tmp_path / "m.txt"], cells={"block": "1"}).said)


def test_status_lists_the_animals_that_can_run_and_then_the_errors(lab, tmp_path):
    study = tmp_path / "s"
    typed("new", study, "--groups", "Nx,SuHx")
    typed("add", study, lab)
    table = study / "animals.csv"
    table.write_text(re.sub(r"^(Nx_2,Nx),[^,]*", r"\1,", table.read_text("utf-8"), flags=re.MULTILINE), "utf-8")
    said = typed("status", study, status=1)
    assert "Nx_1: waiting" in said
    assert "0 of 3 animals done" in said
    assert "column 'network': the cell is empty" in said
