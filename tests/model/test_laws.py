"""Finding wall laws: ours by name, a user's from a file of their own, and laws that contradict themselves."""

from typing import NamedTuple

import numpy as np
import pytest

from own_laws import EXPONENTIAL
from vasowave.calibration import Search, calibrate
from vasowave.calibration.parameters import fitted_parameters
from vasowave.datasets import control_network
from vasowave.errors import InputError
from vasowave.model.laws import LAWS, find_bed, find_law
from vasowave.model.model import Model
from vasowave.model.nominal import windkessels
from vasowave.model.walls import LinearWall, wave_speed
from vasowave.recording import Inflow, Recording
from vasowave.solver import Numerics, simulate


@pytest.fixture
def own_law(tmp_path, monkeypatch):
    (tmp_path / "laws_of_our_lab.py").write_text(EXPONENTIAL)
    monkeypatch.syspath_prepend(tmp_path)
    return "laws_of_our_lab:ExponentialWall"


@pytest.mark.validation  # a law of its own is compiled anew
def test_a_law_in_a_file_of_ones_own_is_simulated_and_its_parameters_come_back(own_law):
    law, network = find_law(own_law), control_network()
    assert find_law(law) is law
    phase = np.arange(64) / 64
    flow = np.exp(-0.5 * ((phase - 0.3) / 0.09) ** 2)
    inflow = Inflow(0.17 * flow / flow.mean(), 0.11)
    model = Model(network, law(14.0, 2.5), windkessels(network, 76.0, 0.12, 0.2))
    pressure = simulate(model, inflow, Numerics(samples=64, tolerance=1e-8)).pressure.values[:, network.root, 0]
    recording = Recording(pressure, inflow.flow, 0.11)
    fit = calibrate(network, recording, own_law, search=Search(starts=1))
    assert fit.wall == "exponential"
    assert fit.S < 1e-6 * 64
    speed = wave_speed(law(*fit.parameters["value"][["exponential.k", "exponential.m"]]), 15.0, model.blood.inertia)
    assert speed == pytest.approx(wave_speed(law(14.0, 2.5), 15.0, model.blood.inertia), rel=1e-3)
    assert fit.total_resistance == pytest.approx(76.0, rel=1e-3)


def test_an_unknown_law_is_refused_with_the_nearest_known_one():
    with pytest.raises(InputError, match=r"unknown wall law 'liner' \(did you mean 'linear'\?\).*module:Class"):
        find_law("liner")
    with pytest.raises(InputError, match="no_such_module_of_mine"):
        find_law("no_such_module_of_mine:Wall")
    with pytest.raises(InputError, match="has no 'NoWall'"):
        find_law("vasowave.model.walls:NoWall")


@pytest.mark.parametrize("name", ["", "foo:", ":Foo", ":", "linear,vein"])
def test_a_name_that_is_none_is_answered_with_those_there_are(name):
    with pytest.raises(InputError, match=f"unknown wall law '{name}'.*choose from: linear, tangent, power, vein"):
        find_law(name)
    with pytest.raises(InputError, match=f"unknown beds '{name}'.*choose from: windkessel"):
        find_bed(name)


def test_a_law_whose_equations_contradict_each_other_is_refused():
    class Wrong(NamedTuple):
        beta: float
        law = staticmethod(lambda: LinearWall.law()._replace(name="wrong"))
        pressure_at = LinearWall.pressure_at
        ratio_at = LinearWall.ratio_at
        slope_at = staticmethod(lambda p, beta: 2.0 / beta * (1.0 + 2.0 * p / beta))
        limits = LinearWall.limits

    with pytest.raises(InputError, match=r"slope_at.*derivative of ratio_at does not hold"):
        find_law(Wrong)
    with pytest.raises(InputError, match=r"is not a wall law.*pressure_at"):
        find_law(dict)


@pytest.mark.parametrize("name", LAWS)
def test_the_nominal_values_of_our_laws_lie_within_their_bounds(name):
    assert list(fitted_parameters(name))[-3:] == ["r1", "r2", "c1"]
    for parameter in LAWS[name].law().parameters:
        low, high = parameter.bounds
        assert low < parameter.nominal < high
