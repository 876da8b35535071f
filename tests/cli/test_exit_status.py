"""What a script that calls vasowave sees: exit status, streams, colors."""

import os
import subprocess
import sys
import warnings
from unittest import mock

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import NumericalError
from vasowave.cli import run


@pytest.fixture
def vasowave(tmp_path, monkeypatch, capsys):
    """Return a function that runs a command line and returns its exit status, output and errors."""
    monkeypatch.chdir(tmp_path)

    def called(*arguments):
        monkeypatch.setattr(sys, "argv", ["vasowave", *arguments])
        status = 0
        with warnings.catch_warnings(), mock.patch.dict(os.environ):
            warnings.simplefilter("default")
            try:
                run()
            except SystemExit as left:
                status = left.code or 0
        return status, *capsys.readouterr()

    return called


def write_mouse(folder):
    network, mouse = vw.Network(("a",), [-1], [0.4], [0.05]), vw.virtual_mouse()
    vw.write_network(network, folder / "n.csv")
    columns = np.column_stack([mouse.time, mouse.pressure, mouse.flow])
    np.savetxt(folder / "c.csv", columns, delimiter=",", header="time [s],pressure [mmHg],flow [ml/s]", comments="")


def test_wrong_data_wrong_commands_and_failures_are_told_apart(tmp_path, vasowave):
    write_mouse(tmp_path)
    status, output, errors = vasowave("simulate", "missing.csv", "c.csv")
    assert (status, output) == (1, "")
    assert errors.startswith("Error: missing.csv")
    assert len(errors.splitlines()) == 1
    assert vasowave("simulate", "n.csv", "c.csv", "--wal", "linear")[0] == 2
    failing = mock.Mock(side_effect=NumericalError("vessel 'a', t = 0.01 s: the flow passes the wave speed"))
    with mock.patch("vasowave.pulse.solver.simulation.simulate", failing):
        status, _, errors = vasowave("simulate", "n.csv", "c.csv")
    assert (status, errors) == (3, "Error: vessel 'a', t = 0.01 s: the flow passes the wave speed\n")
    assert not (tmp_path / "waveforms.nc").exists()
    status, output, errors = vasowave("--version")
    assert (status, output.split()[0], errors) == (0, "vasowave", "")


def test_verbose_says_versions_time_memory_and_where_an_error_arose(vasowave):
    _, _, errors = vasowave("-v", "simulate", "missing.csv", "c.csv")
    for word in ("Python 3.", f"vasowave {vw.__version__}", "numba", "threads", "s of the processor", "Traceback"):
        assert word in errors
    assert errors.splitlines()[-1].startswith("Error: missing.csv")
    assert "Traceback" not in vasowave("simulate", "missing.csv", "c.csv")[2]


def test_no_color_is_respected_even_where_color_is_forced():
    command = [sys.executable, "-c", "from vasowave.cli import run; run()", "simulate", "--help"]
    forced, plain = (
        subprocess.run(command, capture_output=True, text=True, check=True, env=os.environ | given).stdout
        for given in ({"FORCE_COLOR": "1"}, {"FORCE_COLOR": "1", "NO_COLOR": "1"})
    )
    colors = ("\x1b[3", "\x1b[1;3")
    assert any(color in forced for color in colors)
    assert not any(color in plain for color in colors)


def test_linear_algebra_takes_one_thread():
    asked = "print(*{one['num_threads'] for one in threadpoolctl.threadpool_info()})"
    code = f"from vasowave.cli import run\ntry: run()\nexcept SystemExit: import threadpoolctl, numpy; {asked}"
    free = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    command = [sys.executable, "-c", code, "simulate", "--help"]
    said = subprocess.run(command, capture_output=True, text=True, check=True, env=free).stdout
    assert said.splitlines()[-1] == "1"


def test_an_interruption_that_falls_into_a_destructor_is_not_lost():
    code = """
import signal, sys, time
from vasowave.cli import interrupt_again
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.unraisablehook = interrupt_again
class Dying:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)
try:
    Dying()
    time.sleep(60)
except KeyboardInterrupt:
    sys.exit(130)
"""
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True, timeout=30)
    assert (done.returncode, done.stderr) == (130, "")


def test_an_interruption_that_falls_into_an_import_ends_the_program_as_any_other():
    code = """
import signal
import vasowave.cli as cli
signal.signal(signal.SIGINT, signal.default_int_handler)
class Named:
    def __set_name__(self, *place):
        signal.raise_signal(signal.SIGINT)
def imported():
    type("Importing", (), {"name": Named()})
cli.app = imported
cli.run()
"""
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True, timeout=30)
    assert (done.returncode, done.stderr) == (130, "Interrupted; nothing half-written was left.\n")
