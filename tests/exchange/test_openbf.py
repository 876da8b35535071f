"""openBF's files: written as its manual says, read back, and checked against published curves."""

import csv
import warnings
from pathlib import Path

import numpy as np
import pytest
import yaml

from vasowave.errors import InputError, VasowaveWarning
from vasowave.exchange import read_openbf
from vasowave.exchange.openbf import linear_tube, write_openbf
from vasowave.exchange.openbf_reading import _cycle, _in_order, _profile, _reflections, _Vessel
from vasowave.exchange.solved import circuit, solve
from vasowave.model import walls
from vasowave.model.blood import PowerLaw
from vasowave.model.model import Model
from vasowave.model.nominal import windkessels
from vasowave.model.outlets import ImpedanceSpectrum, ReflectionCoefficient
from vasowave.network.network import Network
from vasowave.solver import Numerics, simulate
from vasowave.solver.simulate import simulate_run
from vasowave.units import MMHG

PA = MMHG / 10
MANDATORY = {"label": str, "sn": int, "tn": int, "L": float, "E": float}
KNOWN = {*MANDATORY, "R0", "Rp", "Rd", "M", "h0", "Pext", "gamma_profile", "to_save"}
OUTLET = {"R1", "R2", "Cc", "inlet_impedance_matching"}
"""The keys of a vessel in openBF's manual, and those of an outlet with three elements."""


def config_of(solved, folder):
    write_openbf(solved, folder)
    return yaml.safe_load((folder / "openbf.yaml").read_text(encoding="utf-8"))


def test_the_file_has_the_keys_and_types_of_openbfs_manual_and_passes_the_checks_of_its_validator(tangent, tmp_path):
    config = config_of(tangent, tmp_path)
    assert {"project_name", "inlet_file", "write_results", "solver", "blood", "network"} == set(config)
    assert set(config["write_results"]) <= {"P", "Q", "u", "A"}
    assert {name: type(value) for name, value in config["solver"].items()} == {
        "Ccfl": float, "cycles": int, "convergence_tolerance": float, "jump": int}  # fmt: skip
    assert 0 < config["solver"]["Ccfl"] <= 1
    assert set(config["blood"]) == {"rho", "mu"}
    starts, ends = {one["sn"] for one in config["network"]}, [one["tn"] for one in config["network"]]
    assert len(ends) == len(set(ends))
    for one in config["network"]:
        assert {key: type(one[key]) for key in MANDATORY} == MANDATORY
        assert one["sn"] != one["tn"]
        assert one["sn"] == 1 or one["sn"] in ends  # one connected tree, whose inlet starts at node 1
        assert set(one) == {*MANDATORY, "R0", "M", "h0", "gamma_profile"} | (
            OUTLET if one["tn"] not in starts else set()
        )
        assert isinstance(one["M"], int)
        assert one["M"] >= 5
        assert isinstance(one["gamma_profile"], int)
        assert one["gamma_profile"] >= 2


def test_the_inlet_file_repeats_the_first_flow_at_the_period_in_cubic_meters_a_second(linear, tmp_path):
    config = config_of(linear, tmp_path)
    table = np.loadtxt(tmp_path / config["inlet_file"])
    assert table[0, 0] == 0
    assert table[-1, 0] == linear.inflow.period  # openBF takes the last time for the period
    assert table[-1, 1] == table[0, 1]
    np.testing.assert_allclose(table[:-1, 1], 1e-6 * linear.inflow.flow, rtol=1e-15)


def test_a_linear_model_comes_back_from_openbf_as_it_was(linear, tmp_path):
    write_openbf(linear, tmp_path)
    model, inflow = read_openbf(tmp_path / "openbf.yaml")
    was = linear.model
    assert set(model.network.name) == set(was.network.name)
    rows = [model.network.row(name) for name in was.network.name]
    np.testing.assert_allclose(model.network.length[rows], was.network.length, rtol=1e-12)
    np.testing.assert_allclose(model.area0[rows], was.area0, rtol=1e-12)
    np.testing.assert_allclose(model.wall.beta[rows], was.wall.beta, rtol=1e-9)
    parents = ["" if p < 0 else was.network.name[p] for p in was.network.parent]
    assert parents == ["" if p < 0 else model.network.name[p] for p in model.network.parent[rows]]
    order = [list(model.network.terminals).index(rows[row]) for row in was.network.terminals]
    for there, here in zip(model.outlets, was.outlets, strict=True):
        np.testing.assert_allclose(there[order], here, rtol=1e-12)
    assert model.blood.viscosity == pytest.approx(was.blood.viscosity, rel=1e-12)
    assert model.blood.friction == PowerLaw(2.0)
    np.testing.assert_allclose(inflow.flow, linear.inflow.flow, rtol=1e-12)
    assert inflow.period == linear.inflow.period


def test_the_walls_modulus_is_that_of_openbfs_tube_law(linear, tmp_path):
    """Its manual: β = E h0/((1 - σ²) R0) with σ = 1/2, in Pa, of the radius at no pressure, in m."""
    for one in config_of(linear, tmp_path)["network"]:
        assert one["E"] * one["h0"] / ((1 - 0.5**2) * one["R0"]) == pytest.approx(57.0 * PA, rel=1e-9)
        row = linear.network.row(one["label"])
        assert one["R0"] == pytest.approx(1e-2 * np.sqrt(linear.model.area0[row] / np.pi), rel=1e-9)


def test_openbfs_friction_is_the_papers_at_mean_area_within_what_the_file_says(tangent, tmp_path):
    said = write_openbf(tangent, tmp_path)[1]
    config = yaml.safe_load((tmp_path / "openbf.yaml").read_text(encoding="utf-8"))
    kinematic = 1e4 * config["blood"]["mu"] / config["blood"]["rho"]
    theirs = {one["label"]: 2 * np.pi * (one["gamma_profile"] + 2) * kinematic for one in config["network"]}
    error = [abs(theirs[name] / drag - 1) for name, drag in zip(tangent.network.name, tangent.drag, strict=True)]
    assert f"to {100 * max(error):.1f} %" in said
    assert max(error) < 0.042


def test_a_stiffening_wall_becomes_the_linear_one_of_the_same_area_and_wave_speed_at_mean_pressure(tangent):
    tube, model, pressure = linear_tube(tangent), tangent.model, tangent.mean_pressure
    wall = walls.LinearWall(tube.beta)
    np.testing.assert_allclose(
        walls.area(wall, pressure, tube.area0), walls.area(model.wall, pressure, model.area0), rtol=1e-12
    )
    np.testing.assert_allclose(
        walls.wave_speed(wall, pressure, 1e-3), walls.wave_speed(model.wall, pressure, 1e-3), rtol=1e-12
    )
    row = tangent.network.root
    waves = tangent.along(row)
    theirs = tube.beta[row] * (np.sqrt(waves.area / tube.area0[row]) - 1)
    assert tube.misfit[row] == pytest.approx(np.abs(theirs - waves.pressure).max())
    assert tube.misfit[row] > 0.1  # a stiffening wall is not a linear one, and the file says so


def test_the_files_comment_says_how_far_its_wall_is_from_the_models(tangent, tmp_path):
    write_openbf(tangent, tmp_path)
    head = (tmp_path / "openbf.yaml").read_text(encoding="utf-8").splitlines()[:3]
    assert f"differ by up to {linear_tube(tangent).misfit.max():.2g} mmHg" in head[1]


def test_an_external_pressure_moves_the_law_and_nothing_else(linear, tmp_path):
    config = config_of(linear, tmp_path)
    for one in config["network"]:
        one["Pext"] = 500.0
    (tmp_path / "openbf.yaml").write_text(yaml.safe_dump(config))
    model, _ = read_openbf(tmp_path / "openbf.yaml")
    row, was = model.network.row("1"), linear.model
    area = np.linspace(0.9, 2.0, 7) * was.area0[0]
    theirs = 500.0 / PA + 57.0 * (np.sqrt(area / was.area0[0]) - 1)  # openBF: P = Pext + β (√(A/A0) - 1)
    ours = walls.pressure(walls.LinearWall(model.wall.beta[row]), area, model.area0[row])
    np.testing.assert_allclose(ours, theirs, rtol=1e-9)


def test_more_than_two_daughters_are_told_because_openbf_may_refuse_them(linear, tmp_path):
    network = Network(("a", "b", "c", "d"), [-1, 0, 0, 0], [0.4] * 4, [0.05, 0.03, 0.03, 0.03])
    crowded = solve(Model(network, walls.LinearWall(57.0), windkessels(network, 76.0, 0.11, a=0.12)), linear.inflow)
    with pytest.warns(VasowaveWarning, match="more than three vessels meet where 'a' ends"):
        write_openbf(crowded, tmp_path)


BOMB = (
    "a: &a [x, x, x, x, x, x, x, x, x]\n"
    + "".join(
        f"{two}: &{two} [{', '.join([f'*{one}'] * 9)}]\n" for one, two in zip("abcdefghijk", "bcdefghijkl", strict=True)
    )
    + "network: [{label: *l}]\nblood: {rho: 1, mu: 1}"
)  # 9^12 texts, if anything wrote them out
VESSEL = {"label": "a", "sn": 1, "tn": 2, "L": 0.1, "R0": 0.01, "h0": 1e-3, "E": 4e5, "R1": 1e7, "R2": 1e8, "Cc": 1e-8}


@pytest.mark.parametrize(("radius", "share"), [(0.01, 0.1202), (0.003, 0.1896), (0.001, 0.3000)])
def test_a_wall_without_thickness_gets_that_of_arteries_of_its_radius(tmp_path, radius, share):
    """Its manual takes a fit to human arteries; h0/R0 of three radii is worked out by hand from its figures."""
    (tmp_path / "x_inlet.dat").write_text("\n".join(f"{t / 50} {1e-5}" for t in range(51)))
    content = {"project_name": "x", "blood": {"rho": 1060, "mu": "4e-3"}, "network": [VESSEL | {"R0": radius}]}
    del content["network"][0]["h0"]
    (tmp_path / "x.yaml").write_text(yaml.safe_dump(content))
    model, _ = read_openbf(tmp_path / "x.yaml")
    assert model.wall.beta == pytest.approx(4e5 * share / (1 - 0.5**2) / PA, rel=1e-3)


@pytest.mark.parametrize("radius", [1e-4, 1e-2])
@pytest.mark.parametrize(("share", "tapers"), [(1e-6, True), (1e-11, False)])
def test_a_taper_is_one_from_a_millionth_of_the_radius_on_not_what_rounding_leaves(tmp_path, radius, share, tapers):
    (tmp_path / "x_inlet.dat").write_text("\n".join(f"{t / 50} {1e-9}" for t in range(51)))
    vessel = {key: value for key, value in VESSEL.items() if key != "R0"} | {"Rp": radius, "Rd": radius * (1 - share)}
    vessel |= {"h0": 0.1 * radius, "R1": 1e12, "R2": 1e13}
    (tmp_path / "x.yaml").write_text(yaml.safe_dump({"blood": {"rho": 1060, "mu": 4e-3}, "network": [vessel],
                                                     "project_name": "x"}))  # fmt: skip
    assert read_openbf(tmp_path / "x.yaml")[0].changing.tolist() == [tapers]


def test_a_tapering_vessel_has_openbf_s_wall_of_one_thickness_everywhere(tmp_path):
    """β = E h0/((1 - σ²) R0) at both ends, each with its own R0, and so in the file that is written back."""
    (tmp_path / "x_inlet.dat").write_text("\n".join(f"{t / 50} {1e-5}" for t in range(51)))
    vessel = {key: value for key, value in VESSEL.items() if key != "R0"} | {"Rp": 0.012, "Rd": 0.008}
    content = {"blood": {"rho": 1060, "mu": 4e-3}, "network": [vessel], "project_name": "x"}
    (tmp_path / "x.yaml").write_text(yaml.safe_dump(content))
    model, inflow = read_openbf(tmp_path / "x.yaml")
    wall, area0 = model.at([0, 0], [0.0, 1.0])
    np.testing.assert_allclose(np.sqrt(area0 / np.pi), [1.2, 0.8])
    np.testing.assert_allclose(wall.beta * PA, 4e5 * 1e-3 / (0.75 * np.array([0.012, 0.008])))
    write_openbf(solve(model, inflow, Numerics(cell_size=2.0)), tmp_path)
    back = yaml.safe_load((tmp_path / "openbf.yaml").read_text())["network"][0]
    assert (back["Rp"], back["Rd"]) == pytest.approx((0.012, 0.008))
    assert back["E"] * back["h0"] == pytest.approx(4e5 * 1e-3)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"tn": 1}, "ends in the node in which it begins"),
        ({"L": "long"}, "'L' is 'long', not a number"),
        ({"L": [1, [2]]}, "'L' is neither a number nor a text"),
        ({"label": {"a": 1}}, "'label' is neither a number nor a text"),
        ({"L": -1}, "at least 0"),
        ({"E": None}, "no 'E'"),
        ({"E": float("nan")}, "at least 0"),
        ({"E": True}, "not a number"),
        ({"sn": 1.5}, "nodes are whole numbers"),
        ({"R0": 0}, "its radius is zero"),
        ({"Cc": None}, "no 'Cc'"),
        ({"Rt": -1.5}, "'Rt' is -1.5; it must be a number of at least -1"),
        ({"Pext": 1e9}, "collapses under Pext"),
        ({"R1": 1e3, "R2": 0}, "below its own impedance"),
        ({"label": ""}, "has no name"),
    ],
)
def test_what_no_vessel_can_be_is_an_error_that_names_the_vessel_and_the_key(tmp_path, change, words):
    (tmp_path / "x_inlet.dat").write_text("\n".join(f"{t / 50} {1e-5}" for t in range(51)))
    path = tmp_path / "x.yaml"
    content = {"project_name": "x", "blood": {"rho": 1060, "mu": "4e-3"}, "network": [VESSEL | change]}
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(InputError, match=words) as caught:
        read_openbf(path)
    assert "x.yaml" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "not YAML"),
        ("[" * 5000, "not YAML"),
        ("a: 1", "no configuration of openBF"),
        ("network: 3", "is no list"),
        ("network: []\nblood: {}", "lists no vessel"),
        ("network: [1]\nblood: {rho: 1, mu: 1}", "not a list of keys"),
        ("network: [{label: a}]", "'blood' is missing"),
        ("network: !!python/object:os.system {}", "not YAML"),
        ("\x00\x01", "not YAML"),
        (BOMB, "'label' is neither a number nor a text"),
    ],
)
def test_what_is_no_configuration_of_openbf_is_one_of_our_errors(tmp_path, text, words):
    (tmp_path / "x.yaml").write_text(text)
    with pytest.raises(InputError, match=words):
        read_openbf(tmp_path / "x.yaml")


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("0 1\n1 two\n", "line 2: not a time and a flow"),
        ("0 1 2\n", "line 1"),
        ("0.1 1e-5\n0.2 1e-5\n", "begin at 0"),
        ("0 1e4\n0.5 1.3e4\n1 1e4\n", "is no flow"),
        ("", "empty"),
        ("0 nan\n1 1\n", "not a time and a flow"),
    ],
)
def test_an_inlet_file_that_holds_no_flow_is_refused(tmp_path, table, words):
    (tmp_path / "flow.dat").write_text(table)
    (tmp_path / "x.yaml").write_text(
        yaml.safe_dump({"inlet_file": "flow.dat", "blood": {"rho": 1060, "mu": 4e-3}, "network": [VESSEL]})
    )
    with pytest.raises(InputError, match=words):
        read_openbf(tmp_path / "x.yaml")


def test_an_inflow_at_uneven_times_is_followed_with_at_least_four_samples_a_step(tmp_path):
    time = np.sort(np.random.default_rng(3).uniform(0, 1, 300))
    time = np.concatenate([[0.0], time, [1.0]])
    flow = 1e-6 * (1 + np.sin(2 * np.pi * time))
    np.savetxt(tmp_path / "flow.dat", np.column_stack([time, flow]))
    (tmp_path / "x.yaml").write_text(
        yaml.safe_dump({"inlet_file": "flow.dat", "blood": {"rho": 1060, "mu": 4e-3}, "network": [VESSEL]})
    )
    inflow = read_openbf(tmp_path / "x.yaml")[1]
    assert len(inflow.flow) >= 4 * (len(time) - 1)
    even = np.arange(len(inflow.flow)) / len(inflow.flow)
    np.testing.assert_allclose(inflow.flow, 1 + np.sin(2 * np.pi * even), atol=2e-3)


def test_two_vessels_that_end_in_one_bed_are_refused(tmp_path):
    (tmp_path / "x.yaml").write_text(
        yaml.safe_dump({"blood": {"rho": 1060, "mu": 4e-3}, "network": [VESSEL, VESSEL | {"label": "b", "sn": 3}]})
    )
    with pytest.raises(InputError, match="'a' and 'b' end in a node where none begins"):
        read_openbf(tmp_path / "x.yaml")


def curve(path):
    """Return times and values of a digitized curve, by time."""
    with path.open(encoding="utf-8") as file:
        table = np.array([row[:2] for row in csv.reader(file) if row and row[0].strip()], dtype=float)
    return table[np.argsort(table[:, 0])].T


@pytest.mark.parametrize(
    ("case", "flow", "pressure"),
    [
        ("uta", "uper_thoracic_aorta/UTA_BC.csv", "uper_thoracic_aorta/midpoint_pressure.csv"),
        ("cca", "common_carotid_artery/CC_inlet_BC.csv", "common_carotid_artery/mid_pressure.csv"),
        ("ibif", "bifurcation/Inlet_BC.csv", "bifurcation/mid_ao_Pressure.csv"),
    ],
)
def test_openbfs_own_inputs_give_the_published_3d_pressure(shared, case, flow, pressure):
    """Boileau et al. 2015 find 1D and 3D pressures 1 to 2 % apart (root mean square); digitized to about 0.5 %.

    The published clock may run ahead of the input's, by as much as the flows into the vessel say.
    """
    folder = shared / "benchmarks"
    model, inflow = read_openbf(folder / "boileau2015_inputs_openBF" / case / f"{case}.yaml")
    waves = simulate(model, inflow, Numerics(cell_size=1.0))

    def ours(signal, time):
        return np.interp(time, np.arange(len(signal)) * inflow.period / len(signal), signal, period=inflow.period)

    time, published = curve(folder / "digitised_3D_chezzoba" / flow)
    ahead = min(np.arange(0, 0.1, 0.002), key=lambda s: np.sum((ours(inflow.flow, time + s) - published) ** 2))
    time, published = curve(folder / "digitised_3D_chezzoba" / pressure)
    middle = waves["pressure"].values[:, model.network.root, 1] * PA
    assert np.sqrt(np.mean((ours(middle, time + ahead) / published - 1) ** 2)) < 0.02


def test_a_body_of_77_tapering_arteries_is_read_with_every_taper_and_runs(shared):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model, inflow = read_openbf(shared / "benchmarks" / "boileau2015_inputs_openBF" / "adan56" / "adan56.yaml")
    assert len(model.network) == 77
    assert model.changing.sum() > 30
    mean = inflow.flow.mean() * model.outlets.total_resistance()
    assert 80 < mean < 110  # mmHg, an adult's arteries
    run = simulate_run(model, inflow, Numerics(cell_size=2.0, samples=128))
    assert mean - 1 < run.inlet_pressure(128).mean() < mean + 15
    assert abs(run.volume_error) < 1e-12


def test_reflection_coefficients_are_read_and_written(linear, tmp_path):
    (tmp_path / "x_inlet.dat").write_text("\n".join(f"{t / 50} {1e-5}" for t in range(51)))
    vessel = {key: value for key, value in VESSEL.items() if key not in ("R1", "R2", "Cc")} | {"Rt": 0.3}
    (tmp_path / "x.yaml").write_text(
        yaml.safe_dump({"project_name": "x", "blood": {"rho": 1060, "mu": "4e-3"}, "network": [vessel]})
    )
    with pytest.warns(VasowaveWarning, match="Rt was taken as the resistance"):
        model, _ = read_openbf(tmp_path / "x.yaml")
    c0 = np.sqrt(4e5 * 1e-3 / (0.75 * 0.01) / (2 * 1060))  # m/s
    expected = 1060 * c0 / (np.pi * 0.01**2) * 1.3 / 0.7 / (1e6 * PA)
    assert model.outlets.total_resistance() == pytest.approx(expected)

    network = linear.network
    beds = ReflectionCoefficient(np.full(len(network.terminals), 30.0), np.linspace(-0.2, 0.8, len(network.terminals)))
    config = config_of(solve(linear.model.changed(outlets=beds), linear.inflow, Numerics(samples=64)), tmp_path)
    written = {one["label"]: one for one in config["network"] if "Rt" in one}
    assert [written[network.name[row]]["Rt"] for row in network.terminals] == pytest.approx(beds.R_t.tolist())
    assert not any(OUTLET & set(one) for one in config["network"])


def test_outlets_that_openbf_does_not_know_are_refused(linear, tmp_path):
    Z = linear.model.outlets.impedance_at(20, linear.inflow.period)
    with pytest.raises(InputError, match="this model has ImpedanceSpectrum"):
        circuit(linear.model.changed(outlets=ImpedanceSpectrum(Z)), "openBF", three_element=True)


def test_an_inflow_that_is_even_in_time_keeps_its_samples_and_any_other_its_course(linear, tmp_path):
    write_openbf(linear, tmp_path)
    path = tmp_path / "openbf_inlet.dat"
    table = np.loadtxt(path)
    assert len(read_openbf(tmp_path / "openbf.yaml")[1].flow) == len(table) - 1
    table[1:-1, 0] += 0.2 * table[1, 0]  # no longer even
    np.savetxt(path, table)
    inflow = read_openbf(tmp_path / "openbf.yaml")[1]
    assert len(inflow.flow) >= 512
    time = np.arange(len(inflow.flow)) * inflow.period / len(inflow.flow)
    np.testing.assert_allclose(inflow.flow, np.interp(time, table[:, 0], 1e6 * table[:, 1]), atol=1e-9)


@pytest.mark.parametrize("name", ["{folder}/flow.dat", "../flow.dat"])
def test_an_inlet_outside_the_folder_is_not_opened_and_no_foreign_line_is_quoted(tmp_path, name):
    folder = tmp_path / "openbf"
    folder.mkdir()
    (tmp_path / "flow.dat").write_text("root:x:0:0\n")
    config = {"blood": {"rho": 1060, "mu": 4e-3}, "network": [VESSEL]}
    (folder / "x.yaml").write_text(yaml.safe_dump(config | {"inlet_file": name.format(folder=tmp_path)}))
    with pytest.raises(InputError, match="names an inlet outside its own folder") as outside:
        read_openbf(folder / "x.yaml")
    (folder / "flow.dat").symlink_to(tmp_path / "flow.dat")
    (folder / "x.yaml").write_text(yaml.safe_dump(config | {"inlet_file": "flow.dat"}))
    with pytest.raises(InputError, match="line 1: not a time and a flow") as linked:
        read_openbf(folder / "x.yaml")
    assert not any("x:0" in str(one.value) for one in (outside, linked))


def test_of_velocity_profiles_that_differ_the_one_is_taken_that_loses_as_much_of_the_pressure(tmp_path):
    """A flow q loses 2 π (ζ + 2) μ q/A² per length; here ζ is 2, and 9 and 4 in daughters of 2 and 3 cm."""
    network = Network(("1", "2", "3"), [-1, 0, 0], [1.0, 2.0, 3.0], [0.05, 0.04, 0.04])
    values = [_Vessel(tmp_path, row + 1, {"gamma_profile": one}) for row, one in enumerate((2.0, 9.0, 4.0))]
    with pytest.warns(VasowaveWarning, match="profile"):
        found = _profile(network, values, 9.0)
    power = np.array([1.0, 0.6, 0.4]) ** 2 * np.array([1.0, 2.0, 3.0]) / np.array([0.05, 0.04, 0.04]) ** 4
    assert power @ np.full(3, found + 2) == pytest.approx(power @ np.array([4.0, 11.0, 6.0]))
    alike = [_Vessel(tmp_path, row + 1, {}) for row in range(3)]
    assert _profile(network, alike, 9.0) == 9.0


def test_rows_that_go_back_by_at_most_a_hundredth_of_the_period_are_sorted_and_told(tmp_path):
    table = np.array([[0.0, 1.0], [0.502, 2.0], [0.5, 3.0], [0.7, 4.0], [0.692, 5.0], [1.0, 1.0]])
    with pytest.warns(VasowaveWarning, match="2") as told:
        found = _in_order(tmp_path / "inlet.dat", table)
    assert found[:, 1].tolist() == [1.0, 3.0, 2.0, 5.0, 4.0, 1.0]
    values = dict(told[0].message.finding.values)
    assert (values["count"], values["most"]) == (2, pytest.approx(8.0))  # ms
    in_order, far_back = table[[0, 2, 4, 5]], np.array([[0.0, 1.0], [0.52, 2.0], [0.5, 3.0], [1.0, 1.0]])
    for left in (in_order, far_back):  # what goes back farther is refused later
        assert _in_order(tmp_path / "inlet.dat", left) is left


def test_an_outlet_without_a_reflection_coefficient_beside_others_that_have_one_is_named(tmp_path):
    ends = [(_Vessel(tmp_path, row, {"label": f"v{row}", **keys}), 1060.0, 1e4, 0.01)
            for row, keys in ((3, {"Rt": 0.5}), (5, {"R1": 1e8}), (8, {}))]  # fmt: skip
    with pytest.raises(InputError, match=r"vessel 5 \('v5'\): ends without Rt"):
        _reflections(ends)
    assert _reflections(ends[1:]) is None


def inflow_file(path, rows):
    path.write_text("".join(f"{time!r} {flow!r}\n" for time, flow in rows))
    return path


def test_a_flow_of_an_inlet_is_taken_from_even_times_or_interpolated(tmp_path):
    """A cycle of 32 even steps that closes is taken as it is; of fewer, or uneven ones, 512 samples are made."""

    def flow(time):
        return 1e-7 * (2 + np.sin(2 * np.pi * time))

    even = np.arange(33) / 32
    taken, period = _cycle(inflow_file(tmp_path / "a", zip(even.tolist(), flow(even).tolist())))
    assert taken == pytest.approx(1e6 * flow(even[:-1]))
    assert period == 1.0
    for number, times in enumerate((np.arange(32) / 31, even**1.1)):
        made, _ = _cycle(inflow_file(tmp_path / f"b{number}", zip(times.tolist(), flow(times).tolist())))
        assert made == pytest.approx(np.interp(np.arange(512) / 512, times, 1e6 * flow(times)))
    open_ = np.append(flow(even[:-1]), 1e-7 * 2.01)  # a twentieth of a percent more would be the noise of a digit
    made, _ = _cycle(inflow_file(tmp_path / "c", zip(even.tolist(), open_.tolist())))
    assert len(made) == 512


def test_a_flow_of_a_cubic_meter_is_the_last_that_is_taken(tmp_path):
    times = (np.arange(33) / 32).tolist()
    _cycle(inflow_file(tmp_path / "a", [(time, 1.0) for time in times]))
    with pytest.raises(InputError, match="is no flow"):
        _cycle(inflow_file(tmp_path / "b", [(time, -1.001) for time in times]))
    for rows in ([(0.0, 1e-7)], [(0.1, 1e-7), (0.2, 1e-7)], [(0.0, 1e-7), (0.0, 1e-7)]):
        with pytest.raises(InputError, match=r"must begin at 0 and increase|two columns"):
            _cycle(inflow_file(tmp_path / "c", rows))


def test_a_few_rows_that_go_back_a_little_are_sorted():
    file = Path("flow.dat")
    times = np.arange(101.0)
    table = np.column_stack([times, times])
    assert _in_order(file, table) is table
    back = table.copy()
    back[50, 0] = 48.0  # one before the last: one percent of the period
    with pytest.warns(VasowaveWarning):
        found = _in_order(file, back)
    assert (np.diff(found[:, 0]) >= 0).all()
    far = table.copy()
    far[50, 0] = 47.9
    assert _in_order(file, far) is far
