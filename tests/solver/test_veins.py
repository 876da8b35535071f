"""Veins: the steady flow of a tube that collapses, by the ordinary differential equation, and its volume."""

import numpy as np
import pytest
from scipy.optimize import brentq

from horn import steady_inlet
from vasowave.model.blood import Blood
from vasowave.model.model import Model
from vasowave.model.outlets import Windkessel
from vasowave.model.walls import VeinWall
from vasowave.network.network import Network
from vasowave.recording import Inflow
from vasowave.solver import Numerics
from vasowave.solver.simulate import simulate_run

LENGTH, RADIUS, PERIOD = 1.0, 0.05, 0.11


def vein(stiffness, flow, outlet):
    """A tube at whose end a bed of 1 mmHg s/ml leads a steady flow to so low a pressure that `outlet` is at its end."""
    bed = Windkessel(np.array([0.2]), np.array([0.8]), np.array([0.05]))
    network = Network(("vein",), [-1], [LENGTH], [RADIUS])
    return Model(network, VeinWall(stiffness), bed, Blood(), outlet_pressure=outlet - flow)


@pytest.mark.parametrize(
    ("stiffness", "flow", "outlet"),
    [(60.0, 0.05, 3.0), (60.0, 0.05, -3.0), (20.0, 0.01, -4.0), (60.0, 0.02, -9.0)],
    ids=["filled", "below zero", "collapsed", "stiff and collapsed"],
)
def test_a_steady_flow_in_a_vein_is_that_of_the_ordinary_differential_equation(stiffness, flow, outlet):
    model = vein(stiffness, flow, outlet)
    run = simulate_run(
        model, Inflow(np.full(64, flow), PERIOD), Numerics(cell_size=LENGTH / 32, samples=64, tolerance=1e-9)
    )
    expected = steady_inlet(
        VeinWall, VeinWall(stiffness), model.blood, flow, PERIOD, outlet, LENGTH, lambda x: RADIUS, lambda x: 1.0
    )
    assert run.inlet_pressure(64)[0] == pytest.approx(expected, abs=2e-5)
    assert expected > outlet + 0.05
    end = run.stations[0, 0, 0, 2] / (np.pi * RADIUS**2)
    assert end == pytest.approx(brentq(lambda a: a**10 - a**-1.5 - 23 * outlet / stiffness, 0.1, 3.0), rel=1e-6)
    assert abs(run.volume_error) < 1e-12
    assert [note.code for note in run.notes] == []  # a vein that collapses does what its law says


def test_a_vein_that_fills_and_collapses_in_a_beat_keeps_its_blood(inflow):
    bed = Windkessel(np.array([4.0]), np.array([16.0]), np.array([0.004]))
    model = Model(Network(("vein",), [-1], [LENGTH], [RADIUS]), VeinWall(20.0), bed, Blood(), outlet_pressure=-4.0)
    run = simulate_run(model, inflow, Numerics(samples=128, tolerance=1e-6))
    area = run.stations[0, :, 0, 2] / (np.pi * RADIUS**2)
    assert area.min() < 0.8 < 1.02 < area.max()
    assert abs(run.volume_error) < 1e-10
