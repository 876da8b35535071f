import numpy as np
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


def test_fit_names_a_file_that_does_not_exist():
    result = CliRunner().invoke(app, ["fit", "missing.csv", "x.csv"])
    assert isinstance(result.exception, InputError)
    assert "missing.csv" in str(result.exception)


def test_simulate_writes_waveforms_that_xarray_opens(tmp_path):
    network, cycle, output = tmp_path / "network.csv", tmp_path / "cycle.csv", tmp_path / "waveforms.nc"
    write_network(control_network(), network)
    mouse = virtual_mouse()
    columns = np.column_stack([mouse.time, mouse.pressure, mouse.flow])
    np.savetxt(cycle, columns, fmt="%.17g", delimiter=",", header="time [s],pressure [mmHg],flow [ml/s]", comments="")
    result = CliRunner().invoke(app, ["simulate", str(network), str(cycle), "--output", str(output)])
    assert result.exit_code == 0, result.output
    with xr.open_dataset(output) as waves:
        pressure, flow = waves["pressure"].values[:, 0, 0], waves["flow"].values[:, 0, 0]
    assert pressure.mean() == pytest.approx(mouse.mean_pressure, rel=0.1)
    assert flow.mean() == pytest.approx(mouse.cardiac_output, rel=0.005)
    assert not list(tmp_path.glob("*.part"))
