import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import typer
import xarray as xr
from typer.testing import CliRunner

from approval import approve, tree
from vasowave.base import InputError
from vasowave.cli import app
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.network import Network, write_network
from vasowave.study.results import read_results


@pytest.mark.parametrize("command", [[], ["demo"], ["fit"], ["simulate"], ["extract"], ["match"]])
def test_help_shows_an_example(command):
    result = CliRunner().invoke(app, [*command, "--help"])
    assert result.exit_code == 0
    assert "Example: vasowave" in result.output


def test_the_help_of_a_fit_shows_a_dozen_settings_and_the_way_to_all_others():
    shown = CliRunner().invoke(app, ["fit", "--help"], env={"COLUMNS": "100"}).output
    assert len(shown.splitlines()) < 90
    assert 10 <= sum(line.startswith("│ --") for line in shown.splitlines()) <= 20
    assert "--set" in shown
    assert "docs/study-file.md" in shown


@pytest.mark.parametrize(
    ("by_key", "by_option"),
    [
        (["practice=papier"], ["--practice", "papier"]),
        (["calibration.starts=0"], ["--starts", "0"]),
        (["calibration.bounds.beta=400:10"], ["--bounds", "beta=400:10"]),
        (["bounds.beta=10:400", "bounds.gamma=3:1"], ["--bounds", "beta=10:400", "--bounds", "gamma=3:1"]),
        (["zero [mmHg]=low"], ["--zero", "low"]),
        (["channel.presure=a"], ["--channel", "presure=a"]),
        (["flow unit=ml/h/h"], ["--unit", "flow=ml/h/h"]),
        (["hematocrit [1]=45"], ["--hematocrit", "45"]),
        (["zero after [mmHg]=low"], ["--zero-after", "low"]),
        (["flow gain sd=-1"], ["--flow-gain-sd", "-1"]),
        (["image pressure [mmHg]=x"], ["--image-pressure", "x"]),
    ],
)
def test_a_setting_by_its_key_is_that_of_its_option(tmp_path, by_key, by_option):
    network, cycle = _write_mouse(tmp_path)
    start = ["fit", str(network), str(cycle), "-o", str(tmp_path / "out")]
    first = CliRunner().invoke(app, [*start, *(word for text in by_key for word in ("--set", text))]).exception
    second = CliRunner().invoke(app, [*start, *by_option]).exception
    assert isinstance(first, InputError)
    assert str(first) == str(second)
    assert by_option[0] in str(first)


@pytest.mark.parametrize("before", [["--set", "calibration.starts=3"], ["--starts", "3"]])
def test_a_setting_that_is_given_twice_is_refused(before):
    result = CliRunner().invoke(app, ["fit", "a.csv", "b.csv", *before, "--set", "starts=2"])
    assert str(result.exception) == "--set starts=2: starts is given twice; give it once"


def test_a_setting_of_a_fit_alone_is_no_key_of_a_posterior():
    result = CliRunner().invoke(app, ["posterior", "a.csv", "b.csv", "--set", "calibration.starts=2"])
    assert "--set calibration.starts=2: this command has no setting 'calibration.starts'" in str(result.exception)
    for text in ("starts", "starts="):
        result = CliRunner().invoke(app, ["fit", "a.csv", "b.csv", "--set", text])
        assert str(result.exception) == f"--set {text}: no value is given; write --set starts=VALUE"


def test_a_key_that_there_is_not_is_named_with_the_nearest(tmp_path):
    result = CliRunner().invoke(app, ["fit", "a.csv", "b.csv", "--set", "wals=linear"])
    assert "--set wals=linear: this command has no setting 'wals'" in str(result.exception)
    assert "did you mean 'walls'?" in str(result.exception)


def test_a_recording_in_place_of_the_network_is_named(tmp_path):
    network, recording = tmp_path / "lung.csv", tmp_path / "mouse.txt"
    write_network(control_network(), network)
    recording.write_text("time [s],pressure [mmHg],flow [ml/s]\n0,10,0\n", "utf-8")
    result = CliRunner().invoke(app, ["fit", str(recording), str(network), "-o", str(tmp_path / "out")])
    assert str(result.exception) == f"{network} holds vessels, {recording} does not: the network comes first"


def _vasowave(*arguments, **options):
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"  # a background job ignores it
    command = [sys.executable, "-c", f"{heard}; from vasowave.cli import run; run()", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)


def _write_mouse(folder):
    network, cycle = folder / "network.csv", folder / "cycle.csv"
    write_network(control_network(), network)
    mouse = virtual_mouse()
    columns = np.column_stack([mouse.time, mouse.pressure, mouse.flow])
    np.savetxt(cycle, columns, fmt="%.17g", delimiter=",", header="time [s],pressure [mmHg],flow [ml/s]", comments="")
    return network, cycle


def test_options_that_contradict_each_other_are_an_error_that_names_them(tmp_path):
    network, cycle = _write_mouse(tmp_path)
    result = CliRunner().invoke(app, ["fit", str(network), str(cycle), "--practice", "paper", "--cell-size", "0.3"])
    assert isinstance(result.exception, InputError)
    assert str(result.exception).startswith("options: practice 'paper' sets numerics itself")


def test_more_than_pressure_and_flow_are_no_recording(tmp_path):
    files = [str(tmp_path / name) for name in ("n.csv", "p.csv", "q.csv", "r.csv")]
    done = CliRunner().invoke(app, ["fit", *files, "-o", str(tmp_path / "out")])
    assert (
        "3 files given; a recording is one file, or one of pressure and one of flow" in f"{done.output}{done.exception}"
    )
    assert not (tmp_path / "out").exists()


@pytest.mark.validation
def test_interrupting_the_search_writes_nothing_or_what_had_finished(tmp_path):
    network, cycle = _write_mouse(tmp_path)
    output = tmp_path / "result"
    alone = "--practice", "paper", "--starts", 40, "--walls", "tangent", "--no-pdf"  # one start after the other
    running = _vasowave("fit", network, cycle, *alone, "-o", output)
    while running.poll() is None and not any(path.stat().st_size for path in output.rglob("*.jsonl")):
        time.sleep(0.1)  # until a start has ended
    os.kill(running.pid, signal.SIGINT)
    text = running.communicate(timeout=300)[0]
    if (output / "results" / "index.json").exists():
        assert "Interrupted: " in (output / "report" / "report.html").read_text()
        (result,) = read_results(output).in_order()
        assert result.interrupted
    else:
        assert running.returncode == 130
        assert "nothing half-written" in text
        assert not (output / "report").exists()
    assert "Traceback" not in text
    assert list(tmp_path.rglob(".vasowave-part-*")) == []


@pytest.mark.parametrize(
    ("option", "message"),
    [
        (("--walls", "lineer"), "did you mean 'linear'"),
        (("--fixed", "c1"), "--fixed: calibration.fixed.c1"),
        (("--fixed", "c1=one"), "--fixed: calibration.fixed.c1: 'one' is not a number"),
        (("--fixed", "cc1=1"), "--fixed: calibration.fixed: 'cc1' is not known (did you mean 'c1'?)"),
        (("--bounds", "beta=20"), "--bounds: calibration.bounds.beta: write a list"),
        (("--bounds", "beta=90:20"), "90 is not below 20"),
        (("--friction", "poisseuille"), "did you mean 'poiseuille'"),
        (("--reference-radius", "0.07", "--friction", "poiseuille"), "belongs to friction 'boundary-layer'"),
        (("--method", "newton"), "choose from: least-squares, sqp"),
        (("--starts", "0"), "--starts: calibration.starts: '0' is too small; at least 1"),
        (("--unit", "flwo=x"), "did you mean 'flow'"),
        (("--unit", "flow"), "--unit flow: write pressure=… or flow=…"),
        (("--unit", "ecg=mV"), "--unit ecg=mV"),
    ],
)
def test_a_wrong_option_of_fit_is_an_error_that_says_what_to_write(tmp_path, option, message):
    network, cycle = _write_mouse(tmp_path)
    result = CliRunner().invoke(app, ["fit", str(network), str(cycle), "-o", str(tmp_path / "x"), *option])
    assert isinstance(result.exception, InputError)
    assert message in str(result.exception)
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize("option", ["--wall", "--bed", "--friction"])
@pytest.mark.parametrize("command", ["simulate", "sweep", "export"])
def test_an_empty_name_is_refused_and_not_taken_for_the_default(command, option):
    result = CliRunner().invoke(app, [command, "network.csv", option, ""])
    assert isinstance(result.exception, InputError)
    assert str(result.exception).startswith(f"{option} is empty; name one")


@pytest.mark.parametrize("place", ["taken/fit", "taken"])
def test_fit_refuses_a_place_it_cannot_write_before_it_computes(tmp_path, place):
    network, cycle = _write_mouse(tmp_path)
    (tmp_path / "taken").write_text("a file")
    result = CliRunner().invoke(app, ["fit", str(network), str(cycle), "-o", str(tmp_path / place)])
    assert isinstance(result.exception, InputError)
    assert "compiles" not in result.output


@pytest.mark.parametrize("damaged", [0, 1])
def test_a_fit_that_is_refused_before_it_computes_leaves_nothing_and_takes_nothing_away(tmp_path, damaged):
    files = [*map(str, _write_mouse(tmp_path))]
    Path(files[damaged]).write_text("name,parent\n1,\n" if damaged == 0 else "no numbers\n")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("kept")
    before = sorted(tmp_path.rglob("*"))
    for place in ("new", "deep/er", "mine"):
        result = CliRunner().invoke(app, ["fit", *files, "-o", str(tmp_path / place)])
        assert isinstance(result.exception, InputError)
        assert sorted(tmp_path.rglob("*")) == before


def test_fit_refuses_the_folder_of_a_study_and_of_an_earlier_version(tmp_path):
    network, cycle = _write_mouse(tmp_path)
    for name, words in (("study.yaml", "is a study; add the animal"), ("results.nc", "of an earlier version")):
        folder = tmp_path / name.partition(".")[0]
        folder.mkdir()
        (folder / name).write_text("")
        result = CliRunner().invoke(app, ["fit", str(network), str(cycle), "-o", str(folder)])
        assert words in str(result.exception)
        assert [path.name for path in folder.iterdir()] == [name]
    report = CliRunner().invoke(app, ["report", str(tmp_path / "results")])
    assert "of an earlier version of vasowave" in str(report.exception)


def test_a_file_that_cannot_be_written_is_refused_and_nothing_stays(tmp_path):
    network, cycle = _write_mouse(tmp_path)
    (tmp_path / "results").mkdir()
    before = sorted(tmp_path.iterdir())
    for command in (["simulate", str(network), str(cycle)], ["match", str(network), str(network)]):
        folder = CliRunner().invoke(app, [*command, "-o", str(tmp_path / "results")])
        assert "is a folder; give the name of a file" in str(folder.exception)
        nowhere = CliRunner().invoke(app, [*command, "-o", str(tmp_path / "no" / "file")])
        assert "there is no folder" in str(nowhere.exception)
    assert sorted(tmp_path.iterdir()) == before


def test_a_stiffness_of_zero_is_not_taken_for_none(tmp_path):
    network, cycle = _write_mouse(tmp_path)
    result = CliRunner().invoke(
        app, ["simulate", str(network), str(cycle), "--set", "beta=0", "-o", str(tmp_path / "w.nc")]
    )
    assert "beta: give positive numbers" in str(result.exception)


def _write_labchart(folder, mouse, words=""):
    from vasowave.catheter import SYNTHETIC_NOTICE, labchart_text, synthetic_raw_recording

    raw = synthetic_raw_recording(mouse, np.random.default_rng(3), duration=6.0).raw
    path = folder / f"{words}raw.txt"
    path.write_text(labchart_text(raw).replace(SYNTHETIC_NOTICE, "start"))
    return path


def test_one_command_leads_from_a_raw_recording_to_the_page_and_back_from_the_results_alone(tmp_path, undrawn):
    network = tmp_path / "network.csv"
    write_network(Network(("1", "2", "3"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037]), network)
    recording = _write_labchart(tmp_path, virtual_mouse(), "not_synthetic_")
    output = tmp_path / "x"
    options = (
        "--walls linear --starts 1 --fixed c1=0.9 --bounds beta=20:900 --reference-radius 0.07 --no-pdf --beats 12"
    )
    result = CliRunner().invoke(app, ["fit", str(network), str(recording), "-o", str(output), *options.split()])
    assert result.exit_code == 0, result.output
    assert re.search(
        r"best fit, linear wall: beta [\d.]+ mmHg, r1 [\d.]+ \(factor of the nominal R_1 of all beds\)", result.output
    )
    assert re.search(r"[Rr]esistance of the beds R_T [\d.]+ \[[\d.]+, [\d.]+\] mmHg s/ml", result.output)
    assert "Pressure and flow: Mean pressure 1" in result.output
    (result,) = read_results(output).in_order()
    found = result.laws["linear"].calibration.set_index(parameter="parameter")
    assert float(found["value"].sel(parameter="c1")) == 0.9
    assert (float(found["lower"].sel(parameter="beta")), float(found["upper"].sel(parameter="beta"))) == (20, 900)
    assert json.loads(found.attrs["friction"]) == {"law": "BoundaryLayer", "reference_radius": 0.07}
    assert int(result.beats["kept"].sum()) == 12
    approve("fit, results", tree(result.to_datatree()), 1e-6, 2e-3)
    assert result.origin["sha256 of network"].startswith(hashlib.sha256(network.read_bytes()).hexdigest())
    page = output / "report" / "report.html"
    first = page.read_text()
    assert "Synthetic data" not in first  # a word in a file's name decides nothing

    again = CliRunner().invoke(app, ["fit", str(network), str(recording), "-o", str(output), *options.split()])
    assert "kept from earlier" in again.output
    elsewhere = tmp_path / "elsewhere" / recording.name
    elsewhere.parent.mkdir()
    elsewhere.write_text(recording.read_text("utf-8") + "\n", "utf-8")
    for other in (["--animal", "another"], []):  # another name; or the same, of another place and content
        source = recording if other else elsewhere
        refused = CliRunner().invoke(app, ["fit", str(network), str(source), "-o", str(output), *other])
        assert f"holds the fit of '{recording.stem}' from" in str(refused.exception)
    for path in (network, recording):
        path.unlink()
    shutil.rmtree(output / "report")
    report = CliRunner().invoke(app, ["report", str(output), "--no-pdf"])
    assert report.exit_code == 0, report.output
    assert len(page.read_text()) == pytest.approx(len(first), rel=0.01)


@pytest.mark.parametrize(("command", "endings"), [("sweep", ".csv or .nc"), ("simulate", ".nc"), ("posterior", ".nc")])
def test_the_name_of_an_output_must_say_what_is_written(command, endings, tmp_path):
    refused = CliRunner().invoke(app, [command, "n.csv", "c.csv", "-o", str(tmp_path / "out.xlsx")])
    assert str(refused.exception) == f"{tmp_path / 'out.xlsx'}: the name of this file ends in {endings}"


def test_a_report_without_results_says_what_keeps_both(tmp_path):
    (tmp_path / "report.html").write_text("a report")
    with pytest.raises(InputError, match="a report alone, without results; a run of the study"):
        read_results(tmp_path)


def test_simulate_writes_waveforms_that_xarray_opens(tmp_path):
    network, cycle = _write_mouse(tmp_path)
    mouse, output = virtual_mouse(), tmp_path / "waveforms.nc"
    result = CliRunner().invoke(app, ["simulate", str(network), str(cycle), "--output", str(output)])
    assert result.exit_code == 0, result.output
    with xr.open_dataset(output) as waves:
        pressure, flow = waves["pressure"].values[:, 0, 0], waves["flow"].values[:, 0, 0]
    assert pressure.mean() == pytest.approx(mouse.mean_pressure, rel=0.1)
    assert flow.mean() == pytest.approx(mouse.cardiac_output, rel=0.005)
    assert not list(tmp_path.glob("*.part"))
    assert re.search(r"numerical error about [\d.e-]+ mmHg, by its waves", result.output)
    finer = CliRunner().invoke(app, ["simulate", str(network), str(cycle), "-o", str(output), "--accuracy", "0.2"])
    with xr.open_dataset(output) as waves:
        told = f"numerical error at most {waves.attrs['error_estimate']:.2g} mmHg"
    assert told in finer.output


def test_a_narrowing_is_typed_with_its_vessel_and_is_that_of_python(tmp_path):
    network, cycle = _write_mouse(tmp_path)
    output, given = tmp_path / "narrow.nc", ["simulate", str(network), str(cycle), "--narrow"]
    result = CliRunner().invoke(app, [*given, "2=0.8,0.05", "-o", str(output)])
    assert result.exit_code == 0, result.output
    with xr.open_dataset(output) as waves:
        assert "2 narrow" in waves.vessel
        lost = waves.pressure.sel(station="middle").mean("time")
        assert float(lost.sel(vessel="2") - lost.sel(vessel="2 beyond")) > 0.2
    swept = ["sweep", str(network), str(cycle), "--vary", "beta=40,60", "-o", str(tmp_path / "s.csv")]
    means = []
    for narrowing in ([], ["--narrow", "2=0.8,0.05"]):
        assert CliRunner().invoke(app, [*swept, *narrowing]).exit_code == 0
        means.append(np.loadtxt(tmp_path / "s.csv", delimiter=",", skiprows=1, usecols=3))
    assert np.all(means[1] > means[0] + 0.1)
    suture = ["--narrow", "2=0.8,0.05,20"]
    both = [*swept[:3], "--vary", "R_T=60", "--vary", "beta=80", *swept[-2:], *suture]
    assert CliRunner().invoke(app, both).exit_code == 0
    mean = np.loadtxt(tmp_path / "s.csv", delimiter=",", skiprows=1, usecols=4)
    alone = ["simulate", str(network), str(cycle), "--set", "R_T=60", "--set", "beta=80", *suture, "-o", str(output)]
    assert CliRunner().invoke(app, alone).exit_code == 0
    with xr.open_dataset(output) as waves:  # beds are shared as without the narrowing, which keeps its stiffness
        assert mean == pytest.approx(float(waves.pressure[:, 0, 0].mean()), abs=2e-3)
    for wrong, words in (
        *(
            (text, f"--narrow {text}: write VESSEL=SHARE,CM")
            for text in ("2", "2=0.8", "0.8,0.05", "2=a,b", "2=.8,1,1,1")
        ),
        ("2=8,0.1", "--narrow 2=8,0.1: a narrowing that closes 8 of the area"),
    ):
        assert words in str(CliRunner().invoke(app, [*given, wrong, "-o", str(output)]).exception)


def test_approved_what_every_command_takes_and_says_of_it():
    approve("commands", described(typer.main.get_command(app), "vasowave"))


def described(command, name):
    """Describe a command and those in it: what it does, its arguments and options, their defaults and meanings."""
    yield f"== {name}: " + " ".join((command.help or "").split())
    for one in command.params:
        few = f" from {one.min} to {one.max}" if (one.min, one.max) != (None, None) else ""
        annotation = str(one.type_descriptor.annotation).replace("pathlib._local.", "pathlib.")  # Python 3.13
        kind = f"{annotation}{few}{' …' * one.multiple}{', required' * one.required}"
        said = " ".join((getattr(one, "help", "") or "").split())
        default = f"{one.default}, shown as {one.show_default}"
        yield f"{' '.join([*one.opts, *one.secondary_opts])} ({kind}) = {default}: {said}"
    for inner in getattr(command, "commands", {}):
        yield from described(command.resolve_command(typer.Context(command), [inner])[1], f"{name} {inner}")


@pytest.mark.parametrize(("command", "typed"), [("simulate", False), ("fit", True)])
def test_an_option_is_offered_by_commands_that_have_it_alone(tmp_path, command, typed):
    """Here the unit of a pressure, which a simulation has no option for."""
    _write_mouse(tmp_path)
    text = (tmp_path / "cycle.csv").read_text("utf-8")
    (tmp_path / "cycle.csv").write_text(text.replace("pressure [mmHg]", "pressure"), "utf-8")
    process = _vasowave(command, "network.csv", "cycle.csv", "-o", "out.nc" if command == "simulate" else "out",
                        cwd=tmp_path)  # fmt: skip
    said, _ = process.communicate()
    assert process.returncode == 1
    assert "'pressure' has no unit" in said
    assert ("--unit" in said) == typed


@pytest.mark.parametrize(
    ("given", "words"),
    [(["m.csv"], "m.csv"), (["--bed", "rc"], "--bed"), (["--seed", "1"], "--seed")],
)
def test_a_fits_folder_brings_all_and_what_is_given_beside_it_is_to_be_left_out(tmp_path, given, words):
    refused = CliRunner().invoke(app, ["posterior", str(tmp_path), *given, "-o", str(tmp_path / "p.nc")])
    assert re.search(f"brings recording and settings along; leave out {words}$", str(refused.exception))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["study", "c.csv"], "leave the recording out"),
        (["study", "--bed", "windkessel"], "leave --bed out"),
        (["model.yaml", "--wall", "tangent"], "model.yaml: its wall is the linear one"),
        (["n.csv", "c.csv", "--friction", "poisseuille"], "did you mean 'poiseuille'"),
        (["n.csv", "c.csv", "--set", "a=1,2"], "a=1,2: write one number"),
        (["n.csv", "c.csv", "--set", "a"], "'a': write NAME=VALUE, for example beta=60"),
    ],
)
def test_what_a_simulation_cannot_take_is_said_with_what_to_write(tmp_path, monkeypatch, given, words):
    network, cycle = _write_mouse(tmp_path)
    network.rename(tmp_path / "n.csv")
    cycle.rename(tmp_path / "c.csv")
    (tmp_path / "study").mkdir()
    (tmp_path / "model.yaml").write_text("project_name: one\n", "utf-8")
    monkeypatch.chdir(tmp_path)
    refused = CliRunner().invoke(app, ["simulate", *given])
    assert words in str(refused.exception)


@pytest.mark.parametrize("text", ["1:2", "1:2:x", "a", ""])
def test_values_to_vary_that_are_no_range_are_told_how_to_write_one(tmp_path, text):
    network, cycle = _write_mouse(tmp_path)
    sweep = ["sweep", str(network), str(cycle), "-o", str(tmp_path / "s.csv"), "--vary", f"beta={text}"]
    assert "write one number, one,other or from:to:count" in str(CliRunner().invoke(app, sweep).exception)
