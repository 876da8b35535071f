"""Vessels that change on their way: the steady differential equation, fine cells, rest, volume, derivatives."""

from itertools import pairwise

import numpy as np
import pytest

from horn import steady_inlet
from vasowave.datasets import control_network
from vasowave.errors import InputError
from vasowave.model.blood import Blood, PowerLaw
from vasowave.model.linear import linear_solution
from vasowave.model.model import Model
from vasowave.model.nominal import windkessels
from vasowave.model.outlets import Windkessel
from vasowave.model.shape import Shape
from vasowave.model.walls import LinearWall, PowerWall, TangentWall
from vasowave.network.network import Network
from vasowave.recording import Inflow
from vasowave.solver import Numerics
from vasowave.solver.direction import direction_between
from vasowave.solver.grid import make_grid
from vasowave.solver.run import run_to_periodic
from vasowave.solver.sensitivity import pressure_derivatives
from vasowave.solver.simulate import simulate_run
from vasowave.solver.state import State
from vasowave.solver.stepper import Stepper

WALLS = pytest.mark.parametrize(
    "wall",
    [LinearWall(60.0), TangentWall(9.0, 4.0), pytest.param(PowerWall(60.0, 1.5), marks=pytest.mark.validation)],
    ids=["linear", "tangent", "power"],
)
NARROWS = Shape([1.2, 0.8])


class Mixed:
    """A friction of both powers of the area."""

    def coefficients(self, viscosity, period):
        return 1.5, 25.0


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


def test_cells_of_a_taper_err_no_more_than_those_of_the_tube_of_its_narrow_end(inflow):
    errors = []
    for radius, shape in ((0.04, None), (0.05, NARROWS)):
        model = tube(LinearWall(60.0), 1.0, radius, 76.0, shape)
        runs = [simulate_run(model, inflow, Numerics(cell_size=c, samples=64, tolerance=1e-7)) for c in (0.1, 0.0125)]
        errors.append(np.max(np.abs(runs[0].pressure[:, [0, 2]] - runs[1].pressure[:, [0, 2]])))
    assert errors[1] < errors[0] < 0.01


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


@pytest.mark.parametrize(
    "wall",
    [
        LinearWall(60.0),
        *(pytest.param(one, marks=pytest.mark.validation) for one in (TangentWall(9.0, 4.0), PowerWall(60.0, 1.5))),
    ],
    ids=["linear", "tangent", "power"],
)
@pytest.mark.parametrize("practice", [{}, {"cycles_from_rest": 2}], ids=["periodic", "from rest"])
def test_derivatives_of_a_tree_that_changes_are_those_of_differences(inflow, wall, practice):
    """Vessels of one and of several cells, straight and changing; an image under pressure, so that A0(x) moves too."""
    network = Network(("a", "b", "c"), [-1, 0, 0], [0.45, 0.35, 0.08], [0.047, 0.047, 0.043], pressure=5.0)
    shape = Shape([[1.2, 0.9], [0.9, 1.05], [1.05, 0.95]], [[1.3, 0.8], [1.0, 1.0], [1.0, 1.0]])
    blood = Blood(friction=PowerLaw(9.0))
    numerics = Numerics(samples=64, steps_per_cycle=1024, tolerance=1e-11, **practice)
    beds = windkessels(network, 76.0, 0.11, a=0.2)

    def changed(name, by):
        f = np.exp(by)
        parts = {"network": network, "wall": wall, "outlets": beds}
        if name in ("radius", "length"):
            sizes = {"radius": network.radius, "length": network.length, name: getattr(network, name) * f}
            parts["network"] = Network(network.name, network.parent, **sizes, pressure=5.0)
        elif name in wall._fields:
            parts["wall"] = wall._replace(**{name: getattr(wall, name) * f})
        else:
            parts["outlets"] = beds._replace(**{name: getattr(beds, name) * f})
        return Model(*parts.values(), blood, shape=shape)

    run = simulate_run(changed("C", 0.0), inflow, numerics)
    assert run.grid.counts[2] == 1
    names = (*wall._fields, "radius", "length", "C")
    directions = [direction_between(changed(name, -1e-5), changed(name, 1e-5), 2e-5) for name in names]
    found = pressure_derivatives(run, inflow, directions, numerics, 1e-9)
    for name, derivative in zip(names, found, strict=True):
        p = [
            simulate_run(changed(name, k * 1e-3), inflow, numerics, None if practice else run).inlet_pressure(1024)
            for k in (1, -1, 2, -2)
        ]
        expected = (8 * (p[0] - p[1]) - (p[2] - p[3])) / 12e-3
        assert np.max(np.abs(derivative - expected)) < 1e-6 * np.max(np.abs(expected)), name


@pytest.mark.parametrize(
    ("kind", "practice"), [(PowerLaw(9.0), {}), (Mixed(), {}), (Mixed(), {"cycles_from_rest": 2})],
    ids=["power", "mixed", "from rest"],
)  # fmt: skip
def test_derivatives_by_the_shape_are_those_of_differences(inflow, kind, practice):
    """Of tapers, of a bulge, and of a stiffness; drag that goes with two powers of the area has a mean of its own."""
    network = Network(("a", "b", "c"), [-1, 0, 0], [0.45, 0.35, 0.09], [0.047, 0.047, 0.043], pressure=5.0)
    numerics = Numerics(samples=64, steps_per_cycle=1024, tolerance=1e-11, **practice)
    beds = windkessels(network, 76.0, 0.11, a=0.2)
    radius = np.array([[1.2, 1.1, 0.9], [0.9, 1.0, 1.05], [1.1, 1.0, 0.92]])
    stiffness = np.array([[1.3, 0.8], [1.0, 1.0], [1.0, 1.0]])

    def changed(name, by):
        wide = radius + by * {"tapers": np.array([0.5, 0.0, -0.5]), "bulge": np.array([0.0, 1.0, 0.0])}.get(name, 0.0)
        stiff = stiffness * np.exp(by * np.array([[0.0, 1.0], [0.0, 0.0], [0.0, 0.0]]) * (name == "stiffness"))
        return Model(network, LinearWall(60.0), beds, Blood(friction=kind), shape=Shape(wide, stiff))

    run = simulate_run(changed("", 0.0), inflow, numerics)
    assert run.grid.counts[2] == 2
    names = ("tapers", "bulge", "stiffness")
    directions = [direction_between(changed(name, -1e-5), changed(name, 1e-5), 2e-5) for name in names]
    found = pressure_derivatives(run, inflow, directions, numerics, 1e-10)
    for name, derivative in zip(names, found, strict=True):
        p = [
            simulate_run(changed(name, k * 1e-3), inflow, numerics, None if practice else run).inlet_pressure(1024)
            for k in (1, -1, 2, -2)
        ]
        expected = (8 * (p[0] - p[1]) - (p[2] - p[3])) / 12e-3
        assert np.max(np.abs(derivative - expected)) < 1e-7 * np.max(np.abs(expected)), name


def test_a_direction_from_a_straight_vessel_to_one_that_tapers_is_refused():
    one, other = (tube(LinearWall(60.0), 1.0, 0.05, 50.0, Shape([1 + d, 1 - d])) for d in (0.0, 0.2))
    with pytest.raises(InputError, match="in both models or in none"):
        direction_between(one.changed(junctions="total"), other, 1.0)


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
    ("factors", "message"),
    [((1.0, -0.1), "positive number"), ("wide", "positive number"), (np.ones((2, 2)), "one row of points, or one")],
)
def test_a_shape_that_is_none_is_refused(factors, message):
    with pytest.raises(InputError, match=message):
        tube(LinearWall(60.0), 1.0, 0.05, 50.0, Shape(factors))
