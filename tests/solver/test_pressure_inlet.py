"""A pressure at the inlet drives the network: the flow is that which makes the pressure."""

import numpy as np
import pytest

from vasowave.errors import InputError
from vasowave.model.linear import linear_solution
from vasowave.model.model import Model
from vasowave.model.nominal import windkessels
from vasowave.model.ventricle import Ventricle
from vasowave.model.walls import LinearWall, TangentWall
from vasowave.network.network import Network
from vasowave.recording import InletPressure
from vasowave.solver import Numerics
from vasowave.solver.places import Places, waves_at
from vasowave.solver.simulate import simulate_run

INLET = Places(np.array([0]), np.array([0.0]))
WALLS = pytest.mark.parametrize("wall", [LinearWall(57.0), TangentWall(9.0, 4.0)], ids=["linear", "tangent"])


def fork(wall, behind=0.0):
    network = Network(
        ("a", "b", "c"), np.array([-1, 0, 0]), np.array([0.75, 0.55, 0.35]), np.array([0.047, 0.037, 0.026])
    )
    return Model(network, wall, windkessels(network, 76.0, 0.11, a=0.2), outlet_pressure=behind)


@WALLS
@pytest.mark.parametrize("behind", [0.0, 4.0])
def test_the_flow_that_a_pressure_makes_is_the_flow_that_made_the_pressure(inflow, wall, behind):
    model, numerics = fork(wall, behind), Numerics(cell_size=0.1, steps_per_cycle=2048, samples=64, tolerance=1e-9)
    run = simulate_run(model, inflow, numerics)
    pressure = InletPressure(run.inlet_pressure(run.steps), inflow.period)
    driven = simulate_run(model, pressure, numerics)
    true, found = (waves_at(one, by, INLET).flow[:, 0] for one, by in ((run, inflow), (driven, pressure)))
    assert np.max(np.abs(found - true)) < 1e-6 * np.max(np.abs(true))
    assert len(driven.convergence.changes) <= len(run.convergence.changes) + 4
    assert abs(driven.volume_error) < 1e-8


@WALLS
def test_in_the_frequency_domain_too(inflow, wall):
    model = fork(wall, 4.0)
    solved = linear_solution(model, inflow)
    pressure = InletPressure(solved.over_cycle(solved.pressure[:, 0], 128), inflow.period)
    again = linear_solution(model, pressure)
    assert np.max(np.abs(again.flow[:, 0] - solved.flow[:, 0])) < 1e-6 * np.max(np.abs(solved.flow[:, 0]))


def test_a_pressure_drives_one_inlet_only():
    with pytest.raises(InputError, match="a pressure drives one inlet only"):
        InletPressure(np.ones(64), 0.1).into(["a", "b"])
    with pytest.raises(InputError, match="one inlet only"):
        Ventricle.from_peak(1400.0, 100.0, 0.11, 4.0).into(("a", "b"))
