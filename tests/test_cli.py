import os
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from typer.testing import CliRunner

from vasowave.cli import app
from vasowave.datasets import control_network
from vasowave.datasets.virtual import virtual_mouse
from vasowave.errors import InputError
from vasowave.network import write_network


@pytest.mark.parametrize("command", [[], ["demo"], ["fit"], ["simulate"], ["extract"], ["match"]])
def test_help_shows_an_example(command):
    result = CliRunner().invoke(app, [*command, "--help"])
    assert result.exit_code == 0
    assert "Example: vasowave" in result.output


@pytest.mark.parametrize(("command", "columns"), [("fit", "length [cm], radius [cm]"), ("extract", "x [cm], y [cm]")])
def test_help_shows_units_in_brackets(command, columns):
    words = re.sub(r"[\s│]+", " ", CliRunner().invoke(app, [command, "--help"], terminal_width=200).output)
    assert columns in words


def test_fit_names_a_file_that_does_not_exist():
    result = CliRunner().invoke(app, ["fit", "missing.csv", "x.csv"])
    assert isinstance(result.exception, InputError)
    assert "missing.csv" in str(result.exception)


def _vasowave(*arguments, **options):
    command = [sys.executable, "-c", "from vasowave.cli import run; run()", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)


def _write_mouse(folder):
    network, cycle = folder / "network.csv", folder / "cycle.csv"
    write_network(control_network(), network)
    mouse = virtual_mouse()
    columns = np.column_stack([mouse.time, mouse.pressure, mouse.flow])
    np.savetxt(cycle, columns, fmt="%.17g", delimiter=",", header="time [s],pressure [mmHg],flow [ml/s]", comments="")
    return network, cycle


def test_an_error_of_ours_is_one_line_and_exit_status_1():
    done = _vasowave("fit", "missing.csv", "x.csv")
    output = done.communicate(timeout=300)[0]
    assert done.returncode == 1
    assert output.startswith("Error: missing.csv")
    assert len(output.splitlines()) == 1


def test_interrupting_the_search_writes_nothing_or_what_had_finished(tmp_path):
    network, cycle = _write_mouse(tmp_path)
    output = tmp_path / "result"
    running = _vasowave("fit", network, cycle, "--starts", 40, "--wall", "tangent", "-o", output)
    begun = ""
    while "compiles the solver" not in begun:
        begun = running.stdout.readline()
    time.sleep(5)
    os.kill(running.pid, signal.SIGINT)
    text = running.communicate(timeout=300)[0]
    if output.exists():
        assert "Interrupted: " in (output / "report.html").read_text()
    else:
        assert running.returncode == 130
        assert "nothing half-written" in text
    assert "Traceback" not in text
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []


@pytest.mark.parametrize(
    ("option", "message"),
    [
        (("--wall", "lineer"), "did you mean 'linear'"),
        (("--hold", "c1"), "--hold c1: write a parameter's name"),
        (("--hold", "c1=one"), "--hold c1=one: 'one' is not a number"),
        (("--hold", "cc1=1"), "no parameter 'cc1' (did you mean 'c1'?)"),
        (("--bounds", "beta=20"), "write name=low:high"),
        (("--bounds", "beta=90:20"), "they must be positive and ordered"),
        (("--friction", "poisseuille"), "did you mean 'poiseuille'"),
        (("--friction", "fixed"), "write local, fixed:0.07"),
        (("--method", "newton"), "choose 'least-squares' or 'sqp'"),
        (("--starts", "0"), "at least one is needed"),
    ],
)
def test_a_wrong_option_of_fit_is_an_error_that_says_what_to_write(tmp_path, option, message):
    network, cycle = _write_mouse(tmp_path)
    result = CliRunner().invoke(app, ["fit", str(network), str(cycle), "-o", str(tmp_path / "x"), *option])
    assert isinstance(result.exception, InputError)
    assert message in str(result.exception)
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize("place", ["taken/fit", "taken"])
def test_fit_refuses_a_place_it_cannot_write_before_it_computes(tmp_path, place):
    network, cycle = _write_mouse(tmp_path)
    (tmp_path / "taken").write_text("a file")
    result = CliRunner().invoke(app, ["fit", str(network), str(cycle), "-o", str(tmp_path / place)])
    assert isinstance(result.exception, InputError)
    assert "Recording(" not in result.output


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
        app, ["simulate", str(network), str(cycle), "--beta", "0", "-o", str(tmp_path / "w.nc")]
    )
    assert "beta = 0; it must be positive" in str(result.exception)


def test_options_of_fit_reach_the_calibration(tmp_path):
    network, cycle = _write_mouse(tmp_path)
    options = [
        "--wall",
        "linear",
        "--starts",
        "1",
        "--hold",
        "c1=0.9",
        "--bounds",
        "beta=80:90",
        "--friction",
        "fixed:0.07",
    ]
    result = CliRunner().invoke(app, ["fit", str(network), str(cycle), "-o", str(tmp_path / "x"), *options])
    assert result.exit_code == 0, result.output
    table = pd.read_csv(tmp_path / "x" / "parameters.csv").set_index("parameter")
    assert table["value"]["c1"] == 0.9
    assert (table["lower"]["beta"], table["upper"]["beta"]) == (80, 90)
    assert "a boundary layer (fixed radius 0.0700 cm)" in (tmp_path / "x" / "report.html").read_text()


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
