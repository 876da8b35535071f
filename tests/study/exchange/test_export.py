"""The command `export` and what MATLAB, tables and the command line see of it."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.io import loadmat
from typer.testing import CliRunner

import vasowave as vw
from approval import approve, parts
from vasowave.base import MMHG, InputError
from vasowave.cli import app
from vasowave.study.exchange import FORMATS, drawn_axes, write_matlab, write_openbf, write_svzerod, write_tables


def test_matlab_reads_waves_parameters_and_units(tangent, tmp_path):
    write_matlab(tangent, tmp_path)
    found = loadmat(tmp_path / "waves.mat", squeeze_me=True)
    waves, units = found["waves"][()], found["units"][()]
    assert waves["pressure"].shape == (512, 21, 3)
    np.testing.assert_array_equal(np.moveaxis(waves["pressure"], 1, 2), tangent.run.pressure)
    np.testing.assert_array_equal(waves["flow"], tangent.run.stations[1])
    assert len(found["time"]) == 512
    assert str(units["waves"][()]["pressure"]) == "mmHg"
    assert str(units["outlets"][()]["R1"]) == "mmHg s/ml"
    network = found["network"][()]
    assert network["parent"].tolist() == (tangent.network.parent + 1).tolist()
    assert [str(name) for name in network["name"]] == list(tangent.network.name)
    np.testing.assert_array_equal(found["wall"][()]["p1"], tangent.model.wall.p1)
    np.testing.assert_array_equal(found["outlets"][()]["C"], tangent.model.outlets.C)


def test_tables_hold_the_network_and_every_parameter_to_the_last_bit(tangent, tmp_path):
    write_tables(tangent, tmp_path)
    again = vw.read_network(tmp_path / "network.csv")
    np.testing.assert_array_equal(again.radius, tangent.network.radius)
    with (tmp_path / "parameters.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["p1 [mmHg]"]) for row in rows] == tangent.model.wall.p1.tolist()
    ends = [float(row["C [ml/mmHg]"]) for row in rows if row["C [ml/mmHg]"]]
    assert ends == np.asarray(tangent.model.outlets.C).tolist()
    flow = np.loadtxt(tmp_path / "inflow.csv", delimiter=",", skiprows=1)[:, 1]
    np.testing.assert_array_equal(flow, tangent.inflow.flow)


def written_mouse(folder, mouse):
    vw.write_network(vw.control_network(), folder / "network.csv")
    columns = np.column_stack([mouse.time, mouse.pressure, mouse.flow])
    np.savetxt(folder / "cycle.csv", columns, delimiter=",", header="time [s],pressure [mmHg],flow [ml/s]", comments="")
    return str(folder / "network.csv"), str(folder / "cycle.csv")


def test_one_command_writes_each_program_and_openbfs_file_is_a_model_again(tmp_path, mouse):
    files = written_mouse(tmp_path, mouse)
    for program in FORMATS:
        given = [*files, "--to", program, "-o", str(tmp_path / program)]
        done = CliRunner().invoke(app, ["export", *given, "--friction", "poiseuille"])
        assert done.exit_code == 0, done.output
        assert f"Written: {tmp_path / program}" in done.output.replace("\n", "")
    assert not list(tmp_path.rglob(".vasowave-part-*"))
    assert (tmp_path / "paraview" / "frames" / "063.vtp").exists()
    back = CliRunner().invoke(app, ["export", str(tmp_path / "openbf" / "openbf.yaml"), "--to", "tables",
                                    "-o", str(tmp_path / "back")])  # fmt: skip
    assert back.exit_code == 0, back.output
    first, second = vw.read_network(tmp_path / "network.csv"), vw.read_network(tmp_path / "back" / "network.csv")
    rows = [second.row(name) for name in first.name]
    np.testing.assert_allclose(second.radius[rows], first.radius, rtol=1e-9)


def test_viscous_walls_are_refused_by_programs_that_are_given_elastic_ones(tangent, tmp_path):
    viscous = replace(
        tangent,
        run=replace(tangent.run, grid=replace(tangent.run.grid, model=tangent.model.changed(wall_viscosity=0.1))),
    )
    for write in (write_openbf, write_svzerod):
        with pytest.raises(InputError, match="elastic walls only"):
            write(viscous, tmp_path)


def test_the_loss_of_a_jet_goes_into_tables_and_matlab_and_is_refused_by_openbf(jet, tmp_path):
    """1.52 (1/0.2 - 1)² = 24.32 behind the narrowing, and nowhere else."""
    row = jet.network.row("2 beyond")
    write_tables(jet, tmp_path)
    with (tmp_path / "parameters.csv").open(encoding="utf-8") as file:
        lost = [float(one["loss [1]"]) for one in csv.DictReader(file)]
    write_matlab(jet, tmp_path)
    found = loadmat(tmp_path / "waves.mat", squeeze_me=True)["network"]["loss"][()]
    assert lost == found.tolist()
    assert [place for place, one in enumerate(lost) if one] == [row]
    resistance = loadmat(tmp_path / "waves.mat", squeeze_me=True)["network"]["resistance"][()]
    diameter = 2 * jet.network.radius[row - 1]
    along, area = 0.83 * 0.05 + 1.64 * diameter, jet.network.area[row - 1]
    mu = jet.model.blood.inertia * jet.model.blood.viscosity
    assert resistance[row - 1] == pytest.approx(8 * np.pi * mu * along / area**2)
    assert np.count_nonzero(resistance) == 1
    assert lost[row] == pytest.approx(24.32)
    with pytest.raises(InputError, match="'2 narrow' has one"):
        write_openbf(jet, tmp_path)


def test_the_circuit_of_a_jet_loses_the_pressure_that_the_model_loses(jet, tmp_path):
    """In the model, between what leaves the narrowing and what enters the vessel beyond it."""
    write_svzerod(jet, tmp_path)
    values = [one["zero_d_element_values"] for one in json.loads((tmp_path / "svzerod.json").read_text())["vessels"]]
    row = jet.network.row("2 beyond")
    assert [place for place, one in enumerate(values) if one["stenosis_coefficient"]] == [row]
    flow, pressure = jet.run.stations[1, :, row, 0], jet.run.pressure
    theirs = values[row]["stenosis_coefficient"] * np.mean(flow * np.abs(flow)) / MMHG
    ours = (pressure[:, 2, jet.network.row("2 narrow")] - pressure[:, 0, row]).mean()
    assert ours > 0.9
    assert theirs == pytest.approx(ours, rel=1e-3)
    narrow = values[row - 1]["R_poiseuille"] / MMHG - jet.resistance[row - 1]  # beside the drag along it
    viscous = (pressure[:, 2, row - 2] - pressure[:, 0, row - 1]).mean()
    assert viscous > 0.5
    assert narrow * jet.run.stations[1, :, row - 1, 0].mean() == pytest.approx(viscous, rel=1e-3)


def test_approved_what_other_programs_are_given(tangent, tmp_path):
    said = [*write_openbf(tangent, tmp_path), *write_svzerod(tangent, tmp_path)]
    circuit = json.loads((tmp_path / "svzerod.json").read_text(encoding="utf-8"))
    _, *beds = circuit["boundary_conditions"]
    approve("exchange", [
        *said,
        *(tmp_path / "openbf.yaml").read_text(encoding="utf-8").splitlines(),
        *parts("inlet", np.loadtxt(tmp_path / "openbf_inlet.dat")),
        *parts("circuit", circuit | {"boundary_conditions": beds}),
        *(line for row, axis in enumerate(drawn_axes(tangent.network)) for line in parts(f"axis {row}", axis)),
    ], 1e-9)  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--to", "paravew"], "did you mean 'paraview'"),
        (["--wall", "linaer"], "linear"),
        (["--centerlines", "nowhere.csv"], "nowhere.csv"),
        (["-o", "network.csv"], "is a file"),
    ],
)
def test_a_wrong_option_is_an_error_and_nothing_is_written(tmp_path, mouse, monkeypatch, arguments, words):
    files = written_mouse(tmp_path, mouse)
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["export", *files, *arguments])
    assert isinstance(done.exception, InputError)
    assert words in str(done.exception)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cycle.csv", "network.csv"]


def test_openbfs_file_brings_its_own_inflow_and_wall(tmp_path, mouse):
    files = written_mouse(tmp_path, mouse)
    (tmp_path / "x.yaml").write_text("network: []")
    for arguments, words in (
        (["x.yaml", files[1]], "leave the recording out"),
        (["x.yaml", "--wall", "tangent"], "linear one"),
    ):
        path = str(tmp_path / arguments[0])
        done = CliRunner().invoke(app, ["export", path, *arguments[1:]])
        assert words in str(done.exception)
