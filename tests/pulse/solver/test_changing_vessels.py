"""Vessels that change on their way, and veins: the steady differential equation, fine cells, rest, volume."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq

from horn import steady_inlet
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import (
    Blood,
    LinearWall,
    Model,
    Numerics,
    PowerWall,
    Shape,
    TangentWall,
    VeinWall,
    Windkessel,
    linear_solution,
    windkessels,
)
from vasowave.pulse.network import Network
from vasowave.pulse.solver import State, Stepper, make_grid, run_to_periodic, simulate_run

WALLS = pytest.mark.parametrize(
    "wall",
    [LinearWall(60.0), TangentWall(9.0, 4.0), pytest.param(PowerWall(60.0, 1.5), marks=pytest.mark.validation)],
    ids=["linear", "tangent", "power"],
)
NARROWS = Shape([1.2, 0.8])


def tube(wall, length, radius, R_T, shape=None, blood=None):
    network = Network(("tube",), [-1], [length], [radius])
    beds = Windkessel(*(np.array([value]) for value in (0.2 * R_T, 0.8 * R_T, 0.05 / R_T)))
    return Model(network, wall, beds, blood or Blood(), shape=shape)


ROWS = {
    "mouse": (LinearWall(60.0), 1.0, 0.05, 50.0, 0.3, 0.11),
    "mouse, tangent": (TangentWall(9.0, 4.0), 1.0, 0.05, 50.0, 0.3, 0.11),
    "human": (LinearWall(400.0), 10.0, 1.2, 0.05, 300.0, 1.0),
    "human, power": (PowerWall(400.0, 2.0), 10.0, 1.2, 0.05, 300.0, 1.0),
}


@pytest.mark.parametrize("row", [*list(ROWS)[:-1], pytest.param("human, power", marks=pytest.mark.validation)])
@pytest.mark.parametrize("stiffer", [1.0, 1.6], ids=["one stiffness", "stiffer distally"])
def test_a_steady_flow_in_a_tapering_tube_is_that_of_the_ordinary_differential_equation(row, stiffer):
    """Tubes that taper by 40 %; without the convective acceleration the inlet would be 0.4 to 2 mmHg lower."""
    wall, length, radius, R_T, flow, period = ROWS[row]
    shape, inflow = Shape([1.2, 0.8], [1.0, stiffer]), Inflow(np.full(64, flow), period)
    model = tube(wall, length, radius, R_T, shape)
    expected = steady_inlet(
        type(wall), wall, model.blood, flow, period, flow * R_T, length,
        lambda x: radius * (1.2 - 0.4 * x / length), lambda x: 1.0 + (stiffer - 1.0) * x / length,
    )  # fmt: skip
    errors = []
    for cells in (8, 16, 32):
        run = simulate_run(model, inflow, Numerics(cell_size=length / cells, samples=64, tolerance=1e-9))
        errors.append(abs(run.inlet_pressure(64)[0] - expected))
        assert abs(run.volume_error) < 1e-13
    assert errors[0] < 0.01
    assert errors[2] < 1e-3
    assert errors[0] / errors[2] > 8 or errors[2] < 1e-5  # second order would be 16


@WALLS
def test_rest_under_a_uniform_pressure_stays_rest_whatever_the_shape(wall):
    """Beds whose time constant is endless hold the pressure; every term that remains would set the blood in motion."""
    rng = np.random.default_rng(7)
    network = control_network()
    for pressure in (0.0, 4.0, 18.0):
        tables = np.exp(0.25 * rng.standard_normal((2, 21, 3)))
        tables[0, 5:9], tables[1, 3:7] = 1.0, 1.0
        beds = Windkessel(np.full(11, 100.0), np.full(11, 1e15), np.full(11, 1e9))
        model = Model(network, wall, beds, shape=Shape(*tables))
        counts = np.where(model.stiffening, 4, rng.integers(1, 6, 21))
        grid = make_grid(model, counts)
        stepper = Stepper(grid, Inflow(np.zeros(64), 0.11), Numerics(samples=64), 4096)
        area = grid.area0 * grid.wall.ratio_at(pressure, *grid.wall)
        end = stepper.cycle(State(area, np.zeros(len(area)), np.full((11, 1), pressure + 0j)))
        stepper.stations[0, :, :, 1] *= grid.middle
        everywhere, area0 = grid.at_stations
        found = everywhere.pressure_at(np.moveaxis(stepper.stations[0], -1, -2) / area0, *everywhere)
        assert np.max(np.abs(found - pressure)) < 1e-12 * max(1.0, float(np.max(wall[0])))
        assert np.max(np.abs(end.flow)) < 1e-12
        assert np.max(np.abs(end.area / area - 1.0)[grid.is_cell]) < 1e-12


@pytest.mark.parametrize("wall", [LinearWall(57.0), TangentWall(9.0, 4.0)], ids=["linear", "tangent"])
def test_a_tree_that_tapers_is_right_to_second_order(wall, inflow):
    """Pressures at inlets and outlets of all vessels: the differences of three grids, each of half the cells."""
    network = control_network()
    rng = np.random.default_rng(2)
    taper = 1.0 + np.outer(rng.uniform(0.0, 0.2, 21), [0.5, -0.5])
    model = Model(network, wall, windkessels(network, 76.0, 0.11, a=0.12), shape=Shape(taper, taper[:, ::-1]))
    runs = [
        run_to_periodic(model, inflow, Numerics(samples=64, tolerance=1e-8), refinement=finer).pressure[:, ::2]
        for finer in (1, 2, 4, 8)
    ]
    apart = [float(np.sqrt(np.mean((one - two) ** 2))) for one, two in pairwise(runs)]
    assert apart[0] < 0.01
    assert np.log2(apart[0] / apart[1]) > 1.7, apart  # from vessels of one cell on
    assert np.log2(apart[1] / apart[2]) > 1.9, apart


def test_a_tapering_vessel_is_two_that_taper_each_for_its_half(inflow):
    """At the node between them, of one area on both sides, pressure and energy are continuous."""
    beds = Windkessel(np.array([20.0]), np.array([60.0]), np.array([1e-3]))
    whole = Model(Network(("a",), [-1], [0.8], [0.05]), LinearWall(60.0), beds, shape=NARROWS)
    halves = Network(("a", "b"), [-1, 0], [0.4, 0.4], [0.055, 0.045])
    shape = Shape([[0.06 / 0.055, 0.05 / 0.055], [0.05 / 0.045, 0.04 / 0.045]])
    cut = Model(halves, LinearWall(60.0), beds, shape=shape)
    numerics = Numerics(cell_size=0.0125, samples=64, tolerance=1e-8)
    one, two = (simulate_run(model, inflow, numerics) for model in (whole, cut))
    assert np.max(np.abs(one.inlet_pressure(64) - two.inlet_pressure(64))) < 2e-3
    assert np.max(np.abs(one.pressure[:, 1, 0] - two.pressure[:, 2, 0])) < 2e-3


def test_at_small_amplitude_a_tree_that_tapers_and_stiffens_is_the_linear_one():
    network, t, rng = control_network(), np.arange(256) / 256, np.random.default_rng(0)
    q = np.exp(-0.5 * ((t - 0.2) / 0.03) ** 2)
    tiny = Inflow(1e-5 * q / q.mean(), 0.11)
    shape = Shape(*np.exp(0.2 * rng.standard_normal((2, 21, 2))))
    model = Model(network, LinearWall(57.0), windkessels(network, 76.0, 0.12, 0.12), shape=shape)
    straight = Model(network, LinearWall(57.0), windkessels(network, 76.0, 0.12, 0.12))
    run = simulate_run(model, tiny, Numerics(cell_size=0.025, samples=256, tolerance=1e-11))
    pressure, flow = (np.fft.rfft(one)[:13] for one in (run.pressure[:, 0, 0], run.stations[1, :, 0, 0]))
    expected, other = (linear_solution(one, tiny).input_impedance[:13, 0] for one in (model, straight))
    assert np.max(np.abs(pressure / flow / expected - 1)) < 1e-3
    assert np.max(np.abs(other / expected - 1)) > 0.1


def test_a_measured_taper_is_simulated_unless_another_shape_is_given(inflow):
    sizes = (("only",), [-1], [1.0], [0.05])
    measured = Network(*sizes, taper=[0.02])
    beds = windkessels(measured, 76.0, 0.11, a=0.2)
    by_default, same = (Model(measured, LinearWall(60.0), beds, shape=shape) for shape in (None, NARROWS))
    straight, without = (
        Model(measured, LinearWall(60.0), beds, shape=Shape()),
        Model(Network(*sizes), LinearWall(60.0), beds),
    )
    one, two, three, four = (
        simulate_run(model, inflow, Numerics()).inlet_pressure(64) for model in (by_default, same, straight, without)
    )
    np.testing.assert_allclose(one, two, rtol=1e-12)
    assert np.array_equal(three, four)
    assert np.max(np.abs(one - three)) > 0.1


@pytest.mark.parametrize(
    ("stiffness", "flow", "outlet"),
    [(60.0, 0.05, 3.0), (60.0, 0.05, -3.0), (20.0, 0.01, -4.0), (60.0, 0.02, -9.0)],
    ids=["filled", "below zero", "collapsed", "stiff and collapsed"],
)
def test_a_steady_flow_in_a_vein_is_that_of_the_ordinary_differential_equation(stiffness, flow, outlet):
    model = tube(VeinWall(stiffness), 1.0, 0.05, 1.0).changed(outlet_pressure=outlet - flow)
    run = simulate_run(model, Inflow(np.full(64, flow), 0.11), Numerics(cell_size=1 / 32, samples=64, tolerance=1e-9))
    expected = steady_inlet(
        VeinWall, VeinWall(stiffness), model.blood, flow, 0.11, outlet, 1.0, lambda x: 0.05, lambda x: 1.0
    )
    assert run.inlet_pressure(64)[0] == pytest.approx(expected, abs=2e-5)
    assert expected > outlet + 0.05
    end = run.stations[0, 0, 0, 2] / (np.pi * 0.05**2)
    assert end == pytest.approx(brentq(lambda a: a**10 - a**-1.5 - 23 * outlet / stiffness, 0.1, 3.0), rel=1e-6)
    assert abs(run.volume_error) < 1e-12
    assert [note.code for note in run.notes] == []  # a vein that collapses does what its law says


def test_a_vein_that_fills_and_collapses_in_a_beat_keeps_its_blood(inflow):
    bed = Windkessel(4.0, 16.0, 0.004)
    model = Model(Network(("vein",), [-1], [1.0], [0.05]), VeinWall(20.0), bed, outlet_pressure=-4.0)
    run = simulate_run(model, inflow, Numerics(samples=128, tolerance=1e-6))
    area = run.stations[0, :, 0, 2] / (np.pi * 0.05**2)
    assert area.min() < 0.8 < 1.02 < area.max()
    assert abs(run.volume_error) < 1e-10
