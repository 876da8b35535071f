"""svZeroDSolver's file: the circuit in it solved by hand, and by the program itself."""

import json
import subprocess

import numpy as np
import pytest

from programs_by_others import environment_with
from vasowave.base import MMHG
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import LinearWall, Model, Numerics, Resistance, linear_solution, windkessels
from vasowave.study.exchange import solve, write_svzerod

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
