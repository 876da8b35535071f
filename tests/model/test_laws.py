"""Finding wall laws: ours by name, a user's from a file of their own, and laws that contradict themselves."""

from typing import NamedTuple

import numpy as np
import pytest

from own_laws import EXPONENTIAL
from vasowave.calibration import Search, calibrate
from vasowave.calibration.parameters import fitted_parameters
from vasowave.datasets import control_network
from vasowave.descriptions import Parameter
from vasowave.errors import InputError
from vasowave.model.laws import LAWS, check_parameter, find_bed, find_law
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
def test_our_laws_pass_the_checks_that_foreign_ones_must(name):
    from vasowave.model.laws import _check_equations

    law = LAWS[name]
    _check_equations(law, [one.nominal * one.scale(50.0) for one in law.law().parameters])
    assert list(fitted_parameters(name))[-3:] == ["r1", "r2", "c1"]
    for parameter in law.law().parameters:
        low, high = parameter.bounds
        assert low < parameter.nominal < high


def test_what_is_wrong_with_the_description_of_a_parameter_is_said():
    fine = Parameter("mmHg", "k", "stiffness", "", 5.0, (1.0, 10.0), (2.0, 8.0), 1.0)
    check_parameter("here", fine)
    check_parameter("here", fine._replace(nominal=1.0))  # a bound belongs to its range
    check_parameter("here", fine._replace(nominal=10.0, paper_bounds=None))
    for change, words in (
        ({"unit": "kPa"}, "its unit is 'kPa'"),
        ({"equation": 3}, "must be texts"),
        ({"bounds": (1.0, 5.0, 10.0)}, "must be two numbers"),
        ({"paper_bounds": [2.0, 8.0]}, "must be two numbers"),
        ({"bounds": (0.0, 10.0)}, "positive and ordered"),
        ({"paper_bounds": (8.0, 8.0)}, "positive and ordered"),
        ({"nominal": 10.5}, "here: its nominal value 10.5 lies outside its bounds 1 to 10"),
        ({"nominal": 0.9}, "its nominal value 0.9 lies outside its bounds 1 to 10"),
    ):
        with pytest.raises(InputError, match=words):
            check_parameter("here", fine._replace(**change))
