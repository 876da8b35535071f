"""Vessels shorter than a cell: one cell each, so that they do not set everyone's step at the price of accuracy."""

import numpy as np
import pytest

from vasowave.pulse.cycle import Inflow
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import LinearWall, Model, Numerics, TangentWall, Windkessel, linear_solution, windkessels
from vasowave.pulse.network import Network
from vasowave.pulse.solver import run_to_periodic

BED = Windkessel(20.0, 56.0, 0.0016)
WALLS = pytest.mark.parametrize("wall", [LinearWall(57.0), TangentWall(7.0, 4.0)], ids=["linear", "tangent"])


def chain(lengths, wall):
    count = len(lengths)
    network = Network(tuple(map(str, range(count))), np.arange(count) - 1, np.array(lengths), np.full(count, 0.047))
    return Model(network, wall, BED)


@WALLS
def test_vessels_in_a_row_are_the_tube_they_make(inflow, wall):
    """Ten vessels of one cell and one vessel of ten: the nodes between them must neither reflect nor delay a wave."""
    numerics = Numerics(samples=64, steps_per_cycle=1024, tolerance=1e-8)
    cut = run_to_periodic(chain(np.full(10, 0.1), wall), inflow, numerics)
    whole = run_to_periodic(chain([1.0], wall), inflow, numerics)
    assert cut.grid.counts.tolist() == [1] * 10
    assert np.max(np.abs(cut.pressure[:, 0, 0] - whole.pressure[:, 0, 0])) < 0.01
    assert np.max(np.abs(cut.pressure[:, 2, -1] - whole.pressure[:, 2, -1])) < 0.03
    assert abs(cut.volume_error) < 1e-12


@WALLS
def test_a_short_vessel_between_others_costs_third_order(inflow, wall):
    """It is cut from a tube of the same radius: what one cell of its own changes shrinks by eight as cells halve."""
    apart = []
    for cells in (10, 20):
        numerics = Numerics(cell_size=1 / cells, samples=64, steps_per_cycle=192 * cells, tolerance=1e-9)
        short = run_to_periodic(chain([0.8, 1 / cells, 1.2 - 1 / cells], wall), inflow, numerics)
        whole = run_to_periodic(chain([0.8, 1.2], wall), inflow, numerics)
        assert short.grid.counts[1] == 1
        apart.append(max(np.max(np.abs(short.pressure[:, s, v] - whole.pressure[:, s, min(v, 1)]))
                         for s, v in ((0, 0), (2, 0), (2, 2))))  # fmt: skip
    assert apart[0] < 1e-3
    assert apart[0] / apart[1] > 6.0


@pytest.mark.parametrize("courant", [0.9, 0.3, 0.05])
def test_vessels_of_one_cell_are_stable_at_every_step(inflow, courant):
    """Among shorter ones a vessel meets steps far below its own; what it learned half a step ago must not grow."""
    model = chain(np.full(10, 0.1), LinearWall(57.0))
    steps = 64 * round(6 / courant)
    numerics = Numerics(samples=64, steps_per_cycle=steps, tolerance=1e-8, most_cycles=10)
    run = run_to_periodic(model, inflow, numerics)
    assert np.ptp(np.diff(run.at_inlet[0], 2)) < 1e-2 * np.ptp(run.at_inlet[0])


@WALLS
def test_the_linear_network_has_the_mean_pressures_of_a_steady_flow(wall):
    """Its areas, friction and pressures fit each other: the nonlinear scheme finds the same along the tree."""
    network = control_network()
    model = Model(network, wall, windkessels(network, 76.0, 0.11, a=0.12))
    steady = Inflow(np.full(64, 0.17), 0.11)
    run = run_to_periodic(model, steady, Numerics(samples=64))
    found = linear_solution(model, steady).mean_pressure
    np.testing.assert_allclose(found, run.pressure[0, 1], rtol=0.01)
