"""Waves at shares of a vessel's length, their derivatives, and waves that a pressure at the inlet drives."""

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.pulse.cycle import Inflow, InletPressure
from vasowave.pulse.model import (
    LinearWall,
    Model,
    Numerics,
    Shape,
    TangentWall,
    Ventricle,
    linear_solution,
    windkessels,
)
from vasowave.pulse.network import Network
from vasowave.pulse.solver import QUANTITIES, Places, Waves, derivatives, direction_between, simulate_run, waves_at

NETWORK = Network(("a", "b", "c"), np.array([-1, 0, 0]), np.array([0.75, 0.55, 0.35]), np.array([0.047, 0.037, 0.026]))
INLET = Places(np.array([0]), np.array([0.0]))
WALLS = pytest.mark.parametrize("wall", [LinearWall(57.0), TangentWall(9.0, 4.0)], ids=["linear", "tangent"])
PLACES = Places(np.array([0, 1, 2, 2]), np.array([0.0, 0.37, 0.5, 1.0]))


def fork(wall, **parts):
    return Model(NETWORK, wall, windkessels(NETWORK, 76.0, 0.11, a=0.2), **parts)


def test_at_stations_waves_are_those_of_the_run(inflow):
    run = simulate_run(fork(TangentWall(9.0, 4.0)), inflow, Numerics(samples=64, tolerance=1e-9))
    places = Places(np.array([0, 2, 2]), np.array([0.0, 0.5, 1.0]))
    found = waves_at(run, inflow, places)
    every = run.steps // len(run.pressure)
    for i, (station, vessel) in enumerate(((0, 0), (1, 2), (2, 2))):
        np.testing.assert_allclose(found.pressure[::every, i], run.pressure[:, station, vessel], atol=2e-4)
        np.testing.assert_allclose(found.flow[::every, i], run.stations[1, :, vessel, station], atol=1e-6)


def test_small_waves_at_any_place_are_those_of_the_frequency_domain():
    t = np.arange(256) / 256
    q = np.exp(-0.5 * ((t - 0.2) / 0.05) ** 2)
    tiny, model = Inflow(1e-5 * q / q.mean(), 0.11), fork(LinearWall(57.0))
    run = simulate_run(model, tiny, Numerics(cell_size=0.025, samples=256, tolerance=1e-12))
    found, solved = waves_at(run, tiny, PLACES), linear_solution(model, tiny)
    P, Q = solved.at(PLACES.vessel, PLACES.share * NETWORK.length[PLACES.vessel])
    for wave, spectrum in ((found.pressure, P), (found.flow, Q)):
        expected = solved.over_cycle(spectrum, run.steps)
        assert np.max(np.abs(wave - expected)) < 0.01 * np.max(np.abs(expected))


@pytest.mark.parametrize(
    ("parts", "pressure"),
    [({}, False), ({}, True), ({"shape": Shape([1.0, 0.8]), "wall": LinearWall(57.0)}, False),
     pytest.param({"wall_viscosity": 0.15}, False, marks=pytest.mark.validation)],
    ids=["straight", "driven by a pressure", "tapering", "viscous"],
)  # fmt: skip
def test_derivatives_of_every_quantity_are_those_of_differences(inflow, parts, pressure):
    model = fork(**{"wall": TangentWall(9.0, 4.0), **parts})
    numerics = Numerics(samples=64, steps_per_cycle=2048, tolerance=1e-11)
    run, driven = simulate_run(model, inflow, numerics), inflow
    if pressure:
        driven = InletPressure(run.inlet_pressure(256), inflow.period)
        run = simulate_run(model, driven, numerics)

    def changed(factor):
        beds = model.outlets._replace(C=model.outlets.C * factor**2)
        stiffness, *exponents = model.wall
        wall = type(model.wall)(stiffness * factor, *(one / factor for one in exponents))
        return model.changed(wall=wall, outlets=beds)

    direction, step = direction_between(changed(np.exp(-5e-5)), changed(np.exp(5e-5)), 1e-4), 1e-3
    waves = waves_at(run, driven, PLACES)
    inlet, changes = derivatives(run, driven, [direction], numerics, (PLACES, waves), 1e-9)
    assert inlet.any() != pressure  # a pressure that drives is what it is
    moved = [simulate_run(changed(np.exp(k * step)), driven, numerics, run) for k in (1, -1, 2, -2)]
    ends = [waves_at(one, driven, PLACES) for one in moved]
    for quantity in QUANTITIES:
        found = waves.changed(quantity, Waves(*(one[0] for one in changes)))
        one, below, two, two_below = (end.of(quantity) for end in ends)
        expected = (8 * (one - below) - (two - two_below)) / (12 * step)
        free = slice(0 if pressure and quantity == "flow" else 1, None)  # the inlet has what drives it
        scale = np.max(np.abs(expected), axis=0)
        assert np.all(np.max(np.abs(found - expected), axis=0)[free] < 1e-5 * scale[free]), quantity


@WALLS
@pytest.mark.parametrize("behind", [0.0, 4.0])
def test_the_flow_that_a_pressure_makes_is_the_flow_that_made_the_pressure(inflow, wall, behind):
    model, numerics = (
        fork(wall, outlet_pressure=behind),
        Numerics(cell_size=0.1, steps_per_cycle=2048, samples=64, tolerance=1e-9),
    )
    run = simulate_run(model, inflow, numerics)
    pressure = InletPressure(run.inlet_pressure(run.steps), inflow.period)
    driven = simulate_run(model, pressure, numerics)
    true, found = (waves_at(one, by, INLET).flow[:, 0] for one, by in ((run, inflow), (driven, pressure)))
    assert np.max(np.abs(found - true)) < 1e-6 * np.max(np.abs(true))
    assert len(driven.convergence.changes) <= len(run.convergence.changes) + 4
    assert abs(driven.volume_error) < 1e-8


@WALLS
def test_in_the_frequency_domain_too(inflow, wall):
    model = fork(wall, outlet_pressure=4.0)
    solved = linear_solution(model, inflow)
    pressure = InletPressure(solved.over_cycle(solved.pressure[:, 0], 128), inflow.period)
    again = linear_solution(model, pressure)
    assert np.max(np.abs(again.flow[:, 0] - solved.flow[:, 0])) < 1e-6 * np.max(np.abs(solved.flow[:, 0]))


def test_a_pressure_drives_one_inlet_only():
    with pytest.raises(InputError, match="a pressure drives one inlet only"):
        InletPressure(np.ones(64), 0.1).into(["a", "b"])
    with pytest.raises(InputError, match="one inlet only"):
        Ventricle.from_peak(1400.0, 100.0, 0.11, 4.0).into(("a", "b"))
