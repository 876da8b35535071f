"""openBF's files: written as its manual says, read back, and checked against published curves."""

import csv
import re
import warnings

import numpy as np
import pytest
import yaml

from vasowave.base import MMHG, InputError, VasowaveWarning
from vasowave.pulse.model import Model, Numerics, PowerLaw, ReflectionCoefficient, walls, windkessels
from vasowave.pulse.network import Network
from vasowave.pulse.solver import simulate, simulate_run
from vasowave.study.exchange import linear_tube, read_openbf, solve, write_openbf

PA = MMHG / 10
MANDATORY = {"label": str, "sn": int, "tn": int, "L": float, "E": float}
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


BLOOD = {"rho": 1060, "mu": "4e-3"}
VESSEL = {"label": "a", "sn": 1, "tn": 2, "L": 0.1, "R0": 0.01, "h0": 1e-3, "E": 4e5, "R1": 1e7, "R2": 1e8, "Cc": 1e-8}
BED = {"R1": 2e8, "R2": 8e8, "Cc": 1e-11}
ROOT = {"label": "a", "sn": 1, "tn": 2, "L": 0.01, "E": 4e5, "R0": 5e-4, "h0": 1e-4}
LEFT = ROOT | BED | {"label": "b", "sn": 2, "tn": 3, "L": 0.02, "R0": 4e-4}
RIGHT = LEFT | {"label": "c", "tn": 4, "L": 0.03}
STEADY = "\n".join(f"{t / 50} {1e-6}" for t in range(51))


def file_of(tmp_path, *vessels, rows=STEADY, **more):
    """Write a configuration of openBF and the table of its inlet; what is None is left out."""
    (tmp_path / "in.dat").write_text(rows)
    vessels = [{key: value for key, value in one.items() if value is not None} for one in vessels]
    config = {"project_name": "x", "inlet_file": "in.dat", "blood": BLOOD, "network": vessels} | more
    (tmp_path / "x.yaml").write_text(yaml.safe_dump({key: value for key, value in config.items() if value is not None}))
    return tmp_path / "x.yaml"


@pytest.mark.parametrize(("radius", "share"), [(0.01, 0.1202), (0.003, 0.1896), (0.001, 0.3000)])
def test_a_wall_without_thickness_gets_that_of_arteries_of_its_radius(tmp_path, radius, share):
    """Its manual takes a fit to human arteries; h0/R0 of three radii is worked out by hand from its figures."""
    model, _ = read_openbf(file_of(tmp_path, VESSEL | {"R0": radius, "h0": None}))
    assert model.wall.beta == pytest.approx(4e5 * share / (1 - 0.5**2) / PA, rel=1e-3)


@pytest.mark.parametrize(("share", "tapers"), [(1e-6, True), (1e-11, False)])
def test_a_taper_is_one_from_a_millionth_of_the_radius_on_not_what_rounding_leaves(tmp_path, share, tapers):
    path = file_of(tmp_path, VESSEL | {"R0": None, "Rp": 0.01, "Rd": 0.01 * (1 - share)})
    assert read_openbf(path)[0].changing.tolist() == [tapers]


def test_a_tapering_vessel_has_openbf_s_wall_of_one_thickness_everywhere(tmp_path):
    """β = E h0/((1 - σ²) R0) at both ends, each with its own R0, and so in the file that is written back."""
    model, inflow = read_openbf(file_of(tmp_path, VESSEL | {"R0": None, "Rp": 0.012, "Rd": 0.008}))
    wall, area0 = model.at([0, 0], [0.0, 1.0])
    np.testing.assert_allclose(np.sqrt(area0 / np.pi), [1.2, 0.8])
    np.testing.assert_allclose(wall.beta * PA, 4e5 * 1e-3 / (0.75 * np.array([0.012, 0.008])))
    back = config_of(solve(model, inflow, Numerics(cell_size=2.0)), tmp_path)["network"][0]
    assert (back["Rp"], back["Rd"]) == pytest.approx((0.012, 0.008))
    assert back["E"] * back["h0"] == pytest.approx(4e5 * 1e-3)


def test_beds_without_a_second_resistance_are_matched_to_their_vessel(tmp_path):
    Z = np.sqrt(1060 * 4e5 * 1e-4 / (0.75 * 4e-4) / 2) / (np.pi * 4e-4**2)
    one, two = LEFT | {"R1": 9e10, "R2": None}, RIGHT | {"R1": 3e10, "R2": 9e10, "inlet_impedance_matching": True}
    with pytest.warns(VasowaveWarning, match=r"its Windkessel was given R1 = ρ c0/A0") as heard:
        model, _ = read_openbf(file_of(tmp_path, ROOT, one, two))
    assert len(heard) == 2
    assert model.outlets.R1 == pytest.approx([Z / (1e6 * PA)] * 2)
    assert model.outlets.R2 == pytest.approx([(9e10 - Z) / (1e6 * PA), (12e10 - Z) / (1e6 * PA)])


def test_of_velocity_profiles_that_differ_the_one_is_taken_that_loses_as_much_of_the_pressure(tmp_path):
    """A flow q loses 2 π (ζ + 2) μ q/A² per length; here ζ is 2, and 9 and 4 in daughters of 2 and 3 cm."""
    vessels = [one | {"gamma_profile": profile} for one, profile in zip((ROOT, LEFT, RIGHT), (2, 9, 4), strict=True)]
    with pytest.warns(VasowaveWarning, match="profile"):
        model, _ = read_openbf(file_of(tmp_path, *vessels))
    power = np.array([1.0, 0.6, 0.4]) ** 2 * np.array([1.0, 2.0, 3.0]) / np.array([0.05, 0.04, 0.04]) ** 4
    found, _ = model.blood.friction.coefficients(1.0, 1.0)
    assert found / (2 * np.pi) == pytest.approx(power @ np.array([4.0, 11.0, 6.0]) / power.sum())


@pytest.mark.parametrize(
    ("vessels", "more", "words"),
    [
        ((ROOT, LEFT | {"Ro": 1}, RIGHT | {"Ro": 2}), {}, "2 of 3 vessels.*'Ro' means nothing"),
        ((ROOT, LEFT, RIGHT), {"solvr": {}}, r"'solvr' means nothing to openBF .*\(did you mean 'solver'\?\)"),
        ((ROOT | BED, LEFT, RIGHT), {}, r"a bed is given where other vessels follow \(Cc, R1, R2 of 'a'\)"),
        ((ROOT | {"Rp": 1.1e-3}, LEFT, RIGHT), {}, "'Rp' of 'a' is given and not used"),
        ((ROOT, LEFT | {"Rt": 0.4}, RIGHT | {"Rt": 0.4}), {}, "'R1' of 'b', 'c' is given and not used"),
        ((ROOT, LEFT, RIGHT), {"blood": BLOOD | {"Cp": 3e3}}, "'Cp' of 'blood' is given and not used"),
    ],
)
def test_every_value_that_nothing_takes_is_told(tmp_path, vessels, more, words):
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        read_openbf(file_of(tmp_path, *vessels, **more))
    assert any(re.search(words, str(one.message)) for one in heard)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"tn": 1}, "ends in the node in which it begins"),
        ({"L": "long"}, r"vessel 1 \('a'\): 'L' is 'long', not a number"),
        ({"L": [1, [2]]}, "'L' is neither a number nor a text"),
        ({"L": -1}, "'L' is -1; it must be a number of at least 0"),
        ({"E": None}, "no 'E'; openBF needs it"),
        ({"E": float("nan")}, "at least 0"),
        ({"E": True}, "not a number"),
        ({"sn": 1.5}, "nodes are whole numbers"),
        ({"R0": 0}, "its radius is zero"),
        ({"Cc": None}, "ends without a Windkessel; give it R1, R2 and Cc, or Rt"),
        ({"Rt": -1.5}, "'Rt' is -1.5; it must be a number of at least -1"),
        ({"Pext": 1e9}, "collapses under Pext"),
        ({"R1": 1e3, "R2": 0}, "below its own impedance"),
        ({"label": ""}, "has no name"),
        ({"inlet": "P"}, r"its inlet is 'P', not a flow \(Q\)"),
    ],
)
def test_what_no_vessel_can_be_is_an_error_that_names_the_vessel_and_the_key(tmp_path, change, words):
    with pytest.raises(InputError, match=words) as caught:
        read_openbf(file_of(tmp_path, VESSEL | change))
    assert "x.yaml" in str(caught.value)


def test_vessels_that_do_not_go_together_are_refused(tmp_path):
    with pytest.raises(InputError, match="'a' and 'b' end in a node where none begins"):
        read_openbf(file_of(tmp_path, VESSEL, VESSEL | {"label": "b", "sn": 3}))
    with pytest.raises(InputError, match=r"vessel 2 \('b'\): ends without Rt, where others have it; give all"):
        read_openbf(file_of(tmp_path, ROOT, LEFT, RIGHT | {"Rt": 0.5}))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "not YAML"),
        ("[" * 2000, "not YAML"),
        ("a: 1", "not a configuration of openBF"),
        ("network: 3", "is not a list"),
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


def test_a_file_that_no_network_is_as_long_as_is_not_read(tmp_path):
    with (tmp_path / "x.yaml").open("wb") as file:
        file.truncate(2**30)
    with pytest.raises(InputError, match="no file of openBF is"):
        read_openbf(tmp_path / "x.yaml")


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("0 1\n1 two\n", "line 2: not a time and a flow"),
        ("0 1 2\n", "line 1"),
        ("0.1 1e-5\n0.2 1e-5\n", "begin at 0"),
        ("0 1e-5\n0.52 1e-5\n0.5 1e-5\n1 1e-5", "begin at 0 and increase"),
        ("0 1e4\n0.5 1.3e4\n1 1e4\n", "is no flow"),
        ("", "empty"),
        ("0 nan\n1 1\n", "not a time and a flow"),
    ],
)
def test_an_inlet_file_that_holds_no_flow_is_refused(tmp_path, table, words):
    with pytest.raises(InputError, match=words):
        read_openbf(file_of(tmp_path, VESSEL, rows=table))


def rows_of(time, flow):
    return "\n".join(f"{t!r} {q!r}" for t, q in zip(np.asarray(time).tolist(), np.asarray(flow).tolist(), strict=True))


def test_an_inflow_at_even_times_keeps_its_samples_and_one_at_uneven_times_its_course(tmp_path):
    even = np.arange(65) / 64
    flow = 1e-6 * (1 + 0.5 * np.sin(2 * np.pi * even))
    taken = read_openbf(file_of(tmp_path, VESSEL, rows=rows_of(even, flow)))[1]
    assert taken.flow == pytest.approx(1e6 * flow[:-1])
    uneven = np.concatenate([[0.0], np.sort(np.random.default_rng(3).uniform(0, 1, 300)), [1.0]])
    rows = rows_of(uneven, 1e-6 * (1 + np.sin(2 * np.pi * uneven)))
    inflow = read_openbf(file_of(tmp_path, VESSEL, rows=rows))[1]
    assert len(inflow.flow) >= 4 * (len(uneven) - 1)
    share = np.arange(len(inflow.flow)) / len(inflow.flow)
    np.testing.assert_allclose(inflow.flow, 1 + np.sin(2 * np.pi * share), atol=2e-3)


def test_rows_that_go_back_by_at_most_a_hundredth_of_the_period_are_sorted_and_told(tmp_path):
    time = np.array([0.0, 0.502, 0.5, 0.7, 0.692, 1.0])
    flow = 1e-6 * np.array([1.0, 2.0, 3.0, 4.0, 5.0, 1.0])
    with pytest.warns(VasowaveWarning, match="2") as told:
        inflow = read_openbf(file_of(tmp_path, VESSEL, rows=rows_of(time, flow)))[1]
    values = dict(told[0].message.finding.values)
    assert (values["count"], values["most"]) == (2, pytest.approx(8.0))  # ms
    order = np.argsort(time)
    share = np.arange(len(inflow.flow)) / len(inflow.flow)
    np.testing.assert_allclose(inflow.flow, np.interp(share, time[order], 1e6 * flow[order]), atol=1e-6)


def test_reflection_coefficients_are_read_and_written(linear, tmp_path):
    path = file_of(tmp_path, VESSEL | {"R1": None, "R2": None, "Cc": None, "Rt": 0.3})
    with pytest.warns(VasowaveWarning, match="Rt was taken as the resistance"):
        model, _ = read_openbf(path)
    c0 = np.sqrt(4e5 * 1e-3 / (0.75 * 0.01) / (2 * 1060))  # m/s
    expected = 1060 * c0 / (np.pi * 0.01**2) * 1.3 / 0.7 / (1e6 * PA)
    assert model.outlets.total_resistance() == pytest.approx(expected)
    network = linear.network
    beds = ReflectionCoefficient(np.full(len(network.terminals), 30.0), np.linspace(-0.2, 0.8, len(network.terminals)))
    config = config_of(solve(linear.model.changed(outlets=beds), linear.inflow, Numerics(samples=64)), tmp_path)
    written = {one["label"]: one for one in config["network"] if "Rt" in one}
    assert [written[network.name[row]]["Rt"] for row in network.terminals] == pytest.approx(beds.R_t.tolist())
    assert not any(OUTLET & set(one) for one in config["network"])


@pytest.mark.parametrize("name", ["{folder}/flow.dat", "../flow.dat"])
def test_an_inlet_outside_the_folder_is_not_opened_and_no_foreign_line_is_quoted(tmp_path, name):
    folder = tmp_path / "openbf"
    folder.mkdir()
    (tmp_path / "flow.dat").write_text("root:x:0:0\n")
    with pytest.raises(InputError, match="names an inlet outside its own folder") as outside:
        read_openbf(file_of(folder, VESSEL, inlet_file=name.format(folder=tmp_path)))
    (folder / "flow.dat").symlink_to(tmp_path / "flow.dat")
    with pytest.raises(InputError, match="line 1: not a time and a flow") as linked:
        read_openbf(file_of(folder, VESSEL, inlet_file="flow.dat"))
    assert not any("x:0" in str(one.value) for one in (outside, linked))


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


@pytest.fixture
def body(shared):
    """Return a model of 77 tapering arteries and its inflow."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return read_openbf(shared / "benchmarks" / "boileau2015_inputs_openBF" / "adan56" / "adan56.yaml")


def test_a_body_of_77_arteries_is_read_with_every_taper(body):
    model, inflow = body
    assert len(model.network) == 77
    assert model.changing.sum() > 30
    assert 80 < inflow.flow.mean() * model.outlets.total_resistance() < 110  # mmHg, an adult's arteries


@pytest.mark.validation
def test_a_body_of_77_tapering_arteries_runs(body):
    model, inflow = body
    mean = inflow.flow.mean() * model.outlets.total_resistance()
    run = simulate_run(model, inflow, Numerics(cell_size=2.0, samples=128))
    assert mean - 1 < run.inlet_pressure(128).mean() < mean + 15
    assert abs(run.volume_error) < 1e-12
