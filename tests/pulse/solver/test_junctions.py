"""Junctions of one total pressure, and what is lost at them: energy, the equation of a cone, theory, derivatives."""

import numpy as np
import pytest

from horn import steady_inlet
from vasowave.base import NumericalError
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
    Windkessel,
    linear_solution,
    windkessels,
)
from vasowave.pulse.network import Network
from vasowave.pulse.solver import simulate_run

WALLS = pytest.mark.parametrize("wall", [LinearWall(57.0), TangentWall(9.0, 4.0)], ids=["linear", "tangent"])
FORK = Network(("a", "b", "c"), [-1, 0, 0], [0.45, 0.35, 0.08], [0.047, 0.042, 0.037])


def at_ends(run):
    """Pressure, velocity and flow at inlets and outlets as the nodes left them, shape (time, end, vessel)."""
    area, flow = (np.moveaxis(one, -1, 1)[:, ::2] for one in run.recorded)
    wall, area0 = run.model.at(*np.broadcast_arrays(np.arange(len(run.model.network)), np.array([[0.0], [1.0]])))
    return wall.pressure_at(area / area0, *wall), flow / area, flow


@WALLS
@pytest.mark.parametrize("loss", [0.0, 1.5], ids=["no loss", "loss"])
def test_the_energy_of_every_junction_is_balanced(inflow, wall, loss):
    """What the flow brings leaves, but for K ½ρu² of the daughters; blood flows back in a part of the cycle."""
    network, rng = control_network(), np.random.default_rng(3)
    losses = loss * rng.uniform(0.0, 1.0, 21)
    shape = Shape(np.exp(0.05 * rng.standard_normal((21, 2))))
    beds = windkessels(network, 76.0, 0.11, a=0.12)
    back = Inflow(inflow.flow - 0.2 * inflow.flow.max() * np.sin(np.arange(len(inflow.flow))), inflow.period)
    run = simulate_run(Model(network, wall, beds, shape=shape, loss=losses), back, Numerics(samples=64))
    p, u, q = at_ends(run)
    assert q.min() < -0.01
    half = 0.5 * run.model.blood.inertia
    total, lost = p + half * u**2, half * losses * np.abs(u[:, 0]) * u[:, 0]
    for row, daughters in enumerate(network.daughters):
        if daughters:
            brought, taken = total[:, 1, row] * q[:, 1, row], (total[:, 0] + lost) * q[:, 0]
            left = brought - taken[:, list(daughters)].sum(axis=1)
            assert np.max(np.abs(left)) < 1e-10 * np.max(np.abs(total)) * np.max(np.abs(q))
    assert abs(run.volume_error) < 1e-13


ROWS = {
    "mouse": (LinearWall(60.0), 1.0, 0.05, 50.0, 0.3, 0.11),
    "mouse, tangent": (TangentWall(9.0, 4.0), 1.0, 0.05, 50.0, 0.3, 0.11),
    "human": (LinearWall(400.0), 10.0, 1.2, 0.05, 300.0, 1.0),
    "human, power": (PowerWall(400.0, 2.0), 10.0, 1.2, 0.05, 300.0, 1.0),
}


@pytest.mark.parametrize("row", ["mouse", *(pytest.param(one, marks=pytest.mark.validation) for one in list(ROWS)[1:])])
def test_pieces_of_tube_that_share_the_total_pressure_become_the_cone_and_others_do_not(row):
    """Steady flow in a cone that falls by 40 %: its differential equation, and straight pieces of it at junctions."""
    wall, length, radius, R_T, flow, period = ROWS[row]
    beds = Windkessel(*(np.array([value]) for value in (0.2 * R_T, 0.8 * R_T, 0.05 / R_T)))
    expected = steady_inlet(
        type(wall), wall, Blood(), flow, period, flow * R_T, length,
        lambda x: radius * (1.2 - 0.4 * x / length), lambda x: 1.0,
    )  # fmt: skip

    def error(count, junctions):
        middles = radius * (1.2 - 0.4 * (np.arange(count) + 0.5) / count)
        sizes = np.full(count, length / count), np.concatenate([[1.2 * radius], middles[1:-1], [0.8 * radius]])
        pieces = Network(tuple(map(str, range(count))), np.arange(count) - 1, *sizes)
        model = Model(pieces, wall, beds, junctions=junctions)
        run = simulate_run(model, Inflow(np.full(64, flow), period), Numerics(samples=64, cell_size=length))
        return run.inlet_pressure(64)[0] - expected

    assert abs(error(64, "static")) > 0.15
    errors = [error(count, "total") for count in (16, 32, 64)]
    assert abs(errors[2]) < 1e-3
    assert abs(errors[0]) > 3 * abs(errors[1]) > 9 * abs(errors[2])  # second order would be 4


def test_without_friction_a_steady_flow_has_one_total_pressure_in_the_whole_tree():
    """Bernoulli's equation, from the root of a tree of random tapers to each of its outlets."""
    network, rng = control_network(), np.random.default_rng(5)
    shape = Shape(1.0 + np.outer(rng.uniform(-0.1, 0.15, 21), [1.0, 0.0, -1.0]))
    beds = windkessels(network, 76.0, 0.11, a=0.12)
    model = Model(network, LinearWall(60.0), beds, Blood(viscosity=1e-12), shape=shape)
    run = simulate_run(model, Inflow(np.full(64, 0.3), 0.11), Numerics(samples=64, tolerance=1e-9))
    p, u, _ = at_ends(run)
    total = (p + 0.5 * model.blood.inertia * u**2)[0]
    assert np.ptp(p[0]) > 0.5
    assert np.ptp(total) < 2e-4


@WALLS
def test_a_junction_of_equal_sections_is_not_there(inflow, wall):
    beds = Windkessel(np.array([20.0]), np.array([60.0]), np.array([1e-3]))
    two = Network(("a", "b"), [-1, 0], [0.4, 0.4], [0.05, 0.05])
    static, total = (
        simulate_run(Model(two, wall, beds, junctions=one), inflow, Numerics(samples=64, tolerance=1e-9))
        for one in ("static", "total")
    )
    np.testing.assert_allclose(total.pressure, static.pressure, rtol=0, atol=1e-8)
    whole = Model(Network(("a",), [-1], [0.8], [0.05]), wall, beds, junctions="total")
    one = simulate_run(whole, inflow, Numerics(samples=64, cell_size=0.0125, tolerance=1e-9))
    fine = simulate_run(Model(two, wall, beds, junctions="total"), inflow, Numerics(samples=64, cell_size=0.0125))
    assert np.max(np.abs(one.inlet_pressure(64) - fine.inlet_pressure(64))) < 2e-3


@pytest.mark.parametrize(
    ("shape", "loss", "close"),
    [(None, 0.0, 3e-3), (None, 1.0, 3e-3), (Shape([1.05, 0.95]), 0.0, 0.01)],
    ids=["straight", "loss", "tapering"],
)
def test_small_waves_about_a_fast_flow_are_those_of_linear_theory(shape, loss, close):
    """|u|/c is 0.15: with one static pressure, and no wave carried by the flow, theory is a third off."""
    t = np.arange(256) / 256
    pulse = np.exp(-0.5 * ((t - 0.2) / 0.03) ** 2)
    small = Inflow(0.3 + 1e-5 * (pulse - pulse.mean()), 0.11)
    beds = windkessels(FORK, 33.0, 0.11, a=0.12)
    models = [
        Model(FORK, LinearWall(57.0), beds, Blood(viscosity=1e-6), shape=shape, loss=loss, junctions=one)
        for one in ("total", "static")
    ]
    run = simulate_run(models[0], small, Numerics(cell_size=0.02, samples=256, tolerance=1e-10))
    pressure, flow = (np.fft.rfft(one, axis=0)[:11] for one in (run.pressure[:, 0], run.stations[1, :, :, 0]))
    theory, other = (linear_solution(model, small) for model in models)
    np.testing.assert_allclose(theory.pressure[0].real, pressure[0].real / 256, atol=close)
    assert np.max(np.abs(pressure[1:] / flow[1:] / theory.input_impedance[1:11] - 1)) < close
    assert np.max(np.abs(pressure[1:, 0] / flow[1:, 0] / other.input_impedance[1:11, 0] - 1)) > 0.2
    spots = theory.at(np.arange(3), np.array([0.45, 0.35, 0.08]))
    for ours, station in zip(spots, (run.pressure[:, 2], run.stations[1, :, :, 2]), strict=True):
        np.testing.assert_allclose(np.abs(ours[1:11] / (np.fft.rfft(station, axis=0)[1:11] / 128)), 1.0, atol=2 * close)


def test_a_tree_that_tapers_keeps_its_pressure_and_loses_it_at_static_junctions(inflow):
    """The tree's own drag rises the mean pressure by a few tenths of a mmHg; static junctions take more than one."""
    network, beds = control_network(), windkessels(control_network(), 76.0, 0.12, 0.12)

    def mean(**parts):
        return (
            simulate_run(Model(network, LinearWall(57.0), beds, **parts), inflow, Numerics()).inlet_pressure(64).mean()
        )

    tapering = Shape([1.1, 0.9])
    assert mean(shape=tapering) == mean(shape=tapering, junctions="total")
    assert mean() == mean(junctions="static")
    assert 0.1 < mean(shape=tapering) - mean(junctions="total") < 0.4
    assert mean(shape=tapering, junctions="static") - mean() > 1.0


def test_a_flow_that_chokes_at_a_junction_is_an_error_that_says_so(inflow):
    """The velocity at the end of the narrow vessel passes that of its waves as the vessel before a wide one narrows."""
    network = Network(("a", "b"), [-1, 0], [0.4, 0.4], [0.04, 0.06])
    beds = windkessels(network, 76.0, 0.11, a=0.2)

    def mach(fall):
        shape = Shape([[1.0 + fall / 2, 1.0 - fall / 2], [1.0, 1.0]])
        run = simulate_run(Model(network, LinearWall(60.0), beds, shape=shape), inflow, Numerics(samples=64))
        p, u, _ = at_ends(run)
        return np.max(np.abs(u[:, 1, 0]) * np.sqrt(run.model.blood.inertia / (60.0 / 2 * (1 + p[:, 1, 0] / 60.0))))

    assert 0.3 < mach(0.0) < mach(0.2) < 1.0
    with pytest.raises(NumericalError, match=r"vessel 'a', .* no faster than its waves: check radius and taper"):
        mach(0.8)
