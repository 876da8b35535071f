"""svZeroDSolver's file: the circuit in it solved by hand, and by the program itself."""

import json
import subprocess
import warnings

import numpy as np
import pytest

from programs_by_others import environment_with
from vasowave.base import MMHG, InputError, VasowaveWarning
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import LinearWall, Model, Numerics, Resistance, linear_solution, walls, windkessels
from vasowave.pulse.network_formats import read_network
from vasowave.study.exchange import read_svzerod, solve, write_svzerod

SCRIPT = """
import json, sys, svzerod
found = svzerod.simulate(sys.argv[1])
root = found[found["name"].astype(str) == sys.argv[2]]
print(json.dumps({"time": root["time"].tolist(), "pressure": root["pressure_in"].tolist()}))
"""


def circuit_of(solved, folder):
    write_svzerod(solved, folder)
    return json.loads((folder / "svzerod.json").read_text(encoding="utf-8"))


def input_impedance(circuit, omega):
    """Return the impedance that the inflow meets, by the rules of the manual's BloodVessel and WindkesselBC."""
    after = {one["inlet_vessels"][0]: one["outlet_vessels"] for one in circuit["junctions"]}
    beds = {one["bc_name"]: one["bc_values"] for one in circuit["boundary_conditions"]}

    def into(number):
        vessel = circuit["vessels"][number]
        value = vessel["zero_d_element_values"]
        if number in after:
            load = 1 / sum(1 / into(daughter) for daughter in after[number])
        else:
            bed = beds[vessel["boundary_conditions"]["outlet"]]
            load = bed["Rp"] + bed["Rd"] / (1 + 1j * omega * bed["Rd"] * bed["C"])
        load = load + 1j * omega * value["L"]
        return value["R_poiseuille"] + 1 / (1 / load + 1j * omega * value["C"])

    (first,) = (i for i, one in enumerate(circuit["vessels"]) if "inlet" in one.get("boundary_conditions", {}))
    return into(first)


def test_the_inflow_of_the_circuit_is_the_models_closed_over_one_period(linear, tmp_path):
    (inflow,) = (one for one in circuit_of(linear, tmp_path)["boundary_conditions"] if one["bc_type"] == "FLOW")
    time, flow = (np.array(inflow["bc_values"][name]) for name in "tQ")
    period, count = linear.inflow.period, len(linear.inflow.flow)
    np.testing.assert_allclose(time, np.append(np.arange(count), count) * period / count, rtol=1e-12)
    np.testing.assert_array_equal(flow, np.append(linear.inflow.flow, linear.inflow.flow[0]))


@pytest.mark.parametrize("wall", ["linear", "tangent"])
def test_the_circuit_has_the_mean_pressure_of_the_model(wall, request, tmp_path):
    """What remains is the kinetic energy of the inflow, 0.4 to 0.6 % of the mean pressure here."""
    solved = request.getfixturevalue(wall)
    steady = input_impedance(circuit_of(solved, tmp_path), 0.0).real / MMHG * solved.inflow.flow.mean()
    assert steady == pytest.approx(solved.run.pressure[:, 0, solved.network.root].mean(), rel=0.01)


def test_the_file_has_the_keys_of_the_manual(tangent, tmp_path):
    circuit = circuit_of(tangent, tmp_path)
    assert {"simulation_parameters", "vessels", "junctions", "boundary_conditions"} < set(circuit)
    ids = [one["vessel_id"] for one in circuit["vessels"]]
    assert ids == list(range(21))
    assert all(set(one["zero_d_element_values"]) == {"R_poiseuille", "L", "C", "stenosis_coefficient"}
               for one in circuit["vessels"])  # fmt: skip
    assert sorted(one["bc_type"] for one in circuit["boundary_conditions"]) == ["FLOW", *["RCR"] * 11]
    joined = [row for one in circuit["junctions"] for row in one["outlet_vessels"]]
    assert sorted(joined) == ids[1:]  # every vessel but the root follows one junction
    inflow = next(one["bc_values"] for one in circuit["boundary_conditions"] if one["bc_type"] == "FLOW")
    assert inflow["Q"][0] == inflow["Q"][-1]
    assert inflow["t"][-1] == tangent.inflow.period


def test_beds_are_written_in_dynes_and_those_without_a_capacitor_as_resistances(linear, tmp_path):
    """1 mmHg is 1333.22 dyn/cm²."""
    circuit = circuit_of(linear, tmp_path)
    whole = next(one["bc_values"] for one in circuit["boundary_conditions"] if one["bc_type"] == "RCR")
    R1, R2, C = (float(value[0]) for value in linear.model.outlets)
    assert whole == pytest.approx({"Rp": R1 * 1333.22, "Rd": R2 * 1333.22, "C": C / 1333.22, "Pd": 0.0}, rel=1e-5)
    resistance = Resistance(np.full(11, 900.0))
    bare = solve(linear.model.changed(outlets=resistance, outlet_pressure=5.0), linear.inflow, Numerics(samples=64))
    _, one, *_ = circuit_of(bare, tmp_path)["boundary_conditions"]
    assert one["bc_type"] == "RESISTANCE"
    assert one["bc_values"] == pytest.approx({"R": 900 * 1333.22, "Pd": 6666.1}, rel=1e-5)


def test_slow_waves_meet_the_impedance_of_transmission_lines(mouse, tmp_path):
    """A lumped vessel is a short piece of line: at a twentieth of the heart rate they agree to 0.2 %."""
    network = control_network()
    model = Model(network, LinearWall(57.0), windkessels(network, 76.0, 0.11, a=0.12))
    flow = 0.005 * (1 + 0.01 * np.cos(2 * np.pi * np.arange(64) / 64))
    slow = solve(model, Inflow(flow, 20 * mouse.period), Numerics(samples=64))
    line = linear_solution(model, slow.inflow).input_impedance[1, network.root]
    ours = input_impedance(circuit_of(slow, tmp_path), 2 * np.pi / slow.inflow.period) / MMHG
    assert abs(ours / line - 1) < 2e-3


@pytest.mark.parametrize("bed", ["windkessels", "resistances"])
def test_a_model_comes_back_with_its_network_its_beds_and_its_inflow(linear, tmp_path, bed):
    solved = linear
    if bed == "resistances":
        bare = linear.model.changed(outlets=Resistance(np.linspace(800, 900, 11)), outlet_pressure=5.0)
        solved = solve(bare, linear.inflow, Numerics(samples=64))
    write_svzerod(solved, tmp_path)
    with pytest.warns(VasowaveWarning, match="walls are linear"):
        model, inflow = read_svzerod(tmp_path / "svzerod.json")
    assert model.network.name == solved.network.name
    for field in ("parent", "length", "radius", "pressure"):
        np.testing.assert_array_equal(getattr(model.network, field), getattr(solved.network, field))
    np.testing.assert_allclose(np.array(list(model.outlets)), np.array(list(solved.model.outlets)), rtol=1e-12)
    np.testing.assert_allclose(model.outlet_pressure, solved.model.outlet_pressure, rtol=1e-12)
    np.testing.assert_array_equal(inflow.flow, solved.inflow.flow)
    assert inflow.period == solved.inflow.period
    assert model.blood.density == solved.model.blood.density
    assert model.blood.viscosity == pytest.approx(solved.model.blood.viscosity, rel=1e-12)


@pytest.mark.filterwarnings("ignore::vasowave.base.errors.VasowaveWarning")
def test_the_walls_that_come_back_have_the_compliance_of_the_file(tangent, tmp_path):
    """C = L dA/dp where the radius was measured, ml/(dyn/cm²)."""
    values = [one["zero_d_element_values"]["C"] for one in circuit_of(tangent, tmp_path)["vessels"]]
    model, _ = read_svzerod(tmp_path / "svzerod.json")
    shown = walls.area_compliance(model.wall, np.full(21, model.network.pressure), model.area0) * model.network.length
    np.testing.assert_allclose(np.asarray(shown), np.array(values) * MMHG, rtol=1e-9)


@pytest.mark.filterwarnings("ignore::vasowave.base.errors.VasowaveWarning")
@pytest.mark.parametrize("told", ["vessel_D", "R_poiseuille", "L", "R_poiseuille and L"])
def test_radii_are_told_by_diameters_or_follow_from_the_elements(tmp_path, told):
    write_circuit(tmp_path / "c.json", told)
    network = read_network(tmp_path / "c.json")
    np.testing.assert_allclose(network.radius, [0.05, 0.04, 0.03], rtol=1e-9)
    np.testing.assert_allclose(network.length, [0.4, 0.3, 0.2], rtol=1e-12)
    assert network.parent.tolist() == [-1, 0, 0]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"viscosity": None, "density": None}, "'main': no radius: .*'viscosity'.*'vessel_D'"),
        ({"density": 10.6}, "its radius is .* by R_poiseuille and .* by L; are R, L, viscosity and density in cm"),
        ({"viscosity": 10**400}, "'viscosity' is not a finite number"),
    ],
)
def test_radii_that_nothing_or_two_things_tell_are_refused(tmp_path, change, words):
    write_circuit(tmp_path / "c.json", "R_poiseuille and L", **change)
    with pytest.raises(InputError, match=words):
        read_network(tmp_path / "c.json")


@pytest.mark.filterwarnings("ignore::vasowave.base.errors.VasowaveWarning")
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c["vessels"][1]["zero_d_element_values"].update(C=0.0), "'left': C is 0"),
        (
            lambda c: c["boundary_conditions"][1].update(bc_type="CORONARY"),
            "outlets are CORONARY, RCR; a model needs",
        ),
        (
            lambda c: c["boundary_conditions"][0].update(bc_type="PRESSURE"),
            "'INFLOW': is PRESSURE; a model needs",
        ),
        (lambda c: c["boundary_conditions"][0]["bc_values"].update(t=[0, "x"]), "t and Q must be numbers"),
        (lambda c: c["vessels"][1].pop("boundary_conditions"), "'left': no boundary condition at its outlet"),
        (lambda c: c["simulation_parameters"].update(density=0), "'density' is 0; blood has a positive one"),
        (lambda c: c["junctions"][0].update(outlet_vessels=[1, 7]), "name vessel '7', which is not in the file"),
        (lambda c: c.update(vessels=[]), "'vessels' lists none"),
        (lambda c: c.update(junctions=[3]), "'junctions' is not a list of objects"),
    ],
)
def test_circuits_that_are_no_model_are_refused_in_words(tmp_path, change, words):
    circuit = write_circuit(tmp_path / "c.json", "vessel_D")
    change(circuit)
    (tmp_path / "c.json").write_text(json.dumps(circuit))
    with pytest.raises(InputError, match=words):
        read_svzerod(tmp_path / "c.json")


def write_circuit(path, told, **blood):
    """Write three vessels whose radii are 0.05, 0.04 and 0.03 cm by what is `told`, and return the content."""
    blood = {"viscosity": 0.04, "density": 1.06} | blood
    vessels = []
    for row, (name, length, radius) in enumerate([("main", 0.4, 0.05), ("left", 0.3, 0.04), ("right", 0.2, 0.03)]):
        values = {"C": 1e-8}
        values |= {"R_poiseuille": 8 * 0.04 * length / np.pi / radius**4 if "R" in told or told == "vessel_D" else 0.0}
        values |= {"L": 1.06 * length / np.pi / radius**2} if "L" in told else {}
        ends = {"outlet": name} if row else {"inlet": "INFLOW"}
        vessel = {"vessel_id": row, "vessel_name": name, "vessel_length": length, "zero_d_element_values": values,
                  "zero_d_element_type": "BloodVessel", "boundary_conditions": ends}  # fmt: skip
        vessels.append(vessel | ({"vessel_D": 2 * radius} if told == "vessel_D" else {}))
    beds = [{"bc_name": name, "bc_type": "RCR", "bc_values": {"Rp": 1e5, "Rd": 1e6, "C": 1e-7, "Pd": 0.0}}
            for name in ("left", "right")]  # fmt: skip
    inflow = {"bc_name": "INFLOW", "bc_type": "FLOW", "bc_values": {"t": [0.0, 0.05, 0.1], "Q": [0.1, 0.3, 0.1]}}
    circuit = {"simulation_parameters": {key: value for key, value in blood.items() if value is not None},
               "vessels": vessels, "boundary_conditions": [inflow, *beds],
               "junctions": [{"junction_name": "J", "junction_type": "NORMAL_JUNCTION", "inlet_vessels": [0],
                              "outlet_vessels": [1, 2]}]}  # fmt: skip
    path.write_text(json.dumps(circuit))
    return circuit


def test_a_stenosis_that_does_not_come_back_is_named(jet, tmp_path):
    write_svzerod(jet, tmp_path)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        read_svzerod(tmp_path / "svzerod.json")
    named = [str(warning.message) for warning in caught if "stenosis coefficient" in str(warning.message)]
    assert len(named) == 1
    assert "vessel '2" in named[0]


@pytest.mark.validation
def test_svzerodsolver_itself_finds_the_mean_pressure_of_a_model_with_a_jet(jet, tangent, tmp_path):
    """The jet raises the mean pressure at the root by several percent, which its coefficient must bring."""
    python = environment_with(tmp_path, "svzerod==3.2")
    write_svzerod(jet, tmp_path)
    command = [python, "-c", SCRIPT, tmp_path / "svzerod.json", jet.network.name[jet.network.root]]
    found = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    theirs = np.mean(found["pressure"][:-1]) / MMHG
    ours, sound = (one.run.pressure[:, 0, one.network.root].mean() for one in (jet, tangent))
    assert ours > 1.02 * sound
    assert theirs == pytest.approx(ours, rel=0.01)


@pytest.mark.validation
def test_svzerodsolver_itself_finds_the_pressure_of_the_circuit_and_the_mean_of_the_model(linear, tangent, tmp_path):
    python = environment_with(tmp_path, "svzerod==3.2")
    for solved in (linear, tangent):
        circuit = circuit_of(solved, tmp_path)
        root = solved.network.name[solved.network.root]
        command = [python, "-c", SCRIPT, tmp_path / "svzerod.json", root]
        found = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        theirs = np.array(found["pressure"])[:-1] / MMHG
        flow = np.fft.rfft(solved.inflow.resampled(len(theirs)))
        omega = 2 * np.pi / solved.inflow.period * np.arange(len(flow))
        by_hand = np.fft.irfft(flow * input_impedance(circuit, omega), len(theirs)) / MMHG
        np.testing.assert_allclose(theirs, by_hand, atol=0.02 * np.ptp(by_hand))  # two ways through time
        ours = solved.run.pressure[:, 0, solved.network.root]
        assert theirs.mean() == pytest.approx(ours.mean(), rel=0.01)
