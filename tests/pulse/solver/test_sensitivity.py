"""Derivatives of the simulated pressure against central differences of fourth order and against theory."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from vasowave.base import InputError, NumericalError
from vasowave.pulse.calibration import Objective, compared_part, parameter_space
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import (
    Blood,
    ImpedanceSpectrum,
    LinearWall,
    Model,
    Numerics,
    PowerLaw,
    PowerWall,
    Shape,
    TangentWall,
    Windkessel,
    estimate_nominal,
    linear_solution,
    windkessels,
)
from vasowave.pulse.network import Network
from vasowave.pulse.solver import direction_between, pressure_derivatives, simulate_run

APART = 1e-3  # in the logarithm: the differences' own error is then below 1e-9
LINEAR, TANGENT, POWER = LinearWall(57.0), TangentWall(9.0, 4.0), PowerWall(60.0, 1.5)
FROM_REST = {"cycles_from_rest": 2}
TAPERS = Shape([[1.2, 0.9], [0.9, 1.05], [1.05, 0.95]], [[1.3, 0.8], [1.0, 1.0], [1.0, 1.0]])
BULGE = Shape([[1.2, 1.1, 0.9], [0.9, 1.0, 1.05], [1.1, 1.0, 0.92]], TAPERS.stiffness)
CHANGES = {"tapers": np.array([0.5, 0.0, -0.5]), "bulge": np.array([0.0, 1.0, 0.0])}
"""What is added to the radii of a shape."""


class Mixed:
    """A friction of both powers of the area."""

    def coefficients(self, viscosity, period):
        return 1.5, 25.0


def fork(wall=LINEAR, friction=None, pressure=0.0, **parts):
    """A junction, and a vessel of one cell."""
    network = Network(("a", "b", "c"), [-1, 0, 0], [0.45, 0.35, 0.09], [0.047, 0.042, 0.037], pressure=pressure)
    blood = Blood(friction=friction or PowerLaw(9.0))
    return Model(network, wall, windkessels(network, 76.0, 0.11, a=0.2), blood, **parts)


def ring():
    """A ring that nothing makes symmetric: two branches, and a vessel across them."""
    nodes = [[0, 1], [1, 2], [1, 3], [2, 4], [3, 5], [2, 3]]
    sizes = [0.5, 0.6, 0.9, 0.5, 0.3, 0.4], [0.05, 0.035, 0.03, 0.03, 0.025, 0.03]
    network = Network(tuple("012345"), None, *sizes, nodes=nodes)
    beds = Windkessel(*(np.full(2, value) for value in (20.0, 120.0, 7.5e-4)))
    return Model(network, LinearWall(60.0), beds, junctions="total", loss=0.4, outlet_pressure=2.0)


def part_times(part, vessel, factor):
    """Return what multiplies one part of one vessel, or of the outlets, by a factor, or moves a shape by its log."""

    def changed(model):
        scale, shape = np.ones(len(model.network)), model.shape
        scale[vessel] = factor
        if part in ("length", "radius"):
            return model.changed(network=replace(model.network, **{part: getattr(model.network, part) * scale}))
        if part in CHANGES:
            return model.changed(shape=replace(shape, radius=shape.radius + np.log(factor) * CHANGES[part]))
        if part == "stiffness":
            return model.changed(shape=replace(shape, stiffness=shape.stiffness * scale[:, np.newaxis]))
        if part == "viscosity":
            return model.changed(wall_viscosity=factor * np.asarray(model.wall_viscosity))
        if part in model.wall._fields:
            return model.changed(wall=model.wall._replace(**{part: getattr(model.wall, part) * scale}))
        return model.changed(outlets=model.outlets._replace(**{part: getattr(model.outlets, part) * factor}))

    return changed


def direction(change, model):
    return direction_between(*(part_times(*change, np.exp(side * 1e-5))(model) for side in (-1, 1)), 2e-5)


def fourth_order(values):
    """Return the central difference of values at 1, -1, 2 and -2 times `APART`."""
    near, near_below, far, far_below = values
    return (8 * (near - near_below) - (far - far_below)) / (12 * APART)


def long(name, *values):
    return pytest.param(*values, marks=pytest.mark.validation, id=name)


def weekly(name, *values):
    return pytest.param(*values, marks=pytest.mark.weekly, id=name)


LOSSES = {"junctions": "total", "loss": [0.0, 0.8, 0.0]}
BEATING = 6.0 * np.sin(2 * np.pi * np.arange(64) / 64 + 0.3)


@pytest.mark.parametrize(
    ("model", "parts", "practice", "close"),
    [
        pytest.param(fork(), "beta 1, radius 2, length 0, R1 0, R2 0, C 0", {}, 1e-6, id="linear"),
        pytest.param(fork(TANGENT), "p1 1, gamma 1, radius 2, length 0", FROM_REST, 1e-6, id="tangent, from rest"),
        pytest.param(fork(**LOSSES), "beta 1, radius 0, length 1", FROM_REST, 1e-7, id="losses, from rest"),
        pytest.param(fork(shape=TAPERS, pressure=5.0), "beta 1, radius 0, length 0, C 0", {}, 1e-6, id="tapers"),
        pytest.param(fork(shape=BULGE), "tapers 0, bulge 0, stiffness 0", {}, 1e-7, id="shapes"),
        pytest.param(ring(), "beta 5, radius 2, length 5, R2 0", {}, 1e-6, id="ring"),
        long("linear, from rest", fork(), "beta 1, radius 2, length 0, R1 0, R2 0, C 0", FROM_REST, 1e-6),
        long("tangent", fork(TANGENT), "p1 1, gamma 1, radius 2, length 0, R1 0, R2 0, C 0", {}, 1e-6),
        long("losses", fork(TANGENT, **LOSSES), "p1 1, gamma 1, radius 0, length 1, R1 0, C 0", {}, 1e-7),
        weekly("losses and tapers", fork(shape=TAPERS, **LOSSES), "beta 0, radius 1, length 0, R1 0, C 0", {}, 1e-6),
        weekly("tangent, tapers", fork(TANGENT, shape=TAPERS, pressure=5.0), "p1 1, gamma 0, radius 0, C 0", {}, 1e-6),
        weekly("power, tapers", fork(POWER, shape=TAPERS, pressure=5.0), "beta 1, m 0, radius 0, C 0", {}, 1e-6),
        weekly("tapers, from rest", fork(shape=TAPERS, pressure=5.0), "beta 1, radius 0, length 0", FROM_REST, 1e-6),
        long("shapes, mixed friction", fork(shape=BULGE, friction=Mixed()), "tapers 0, bulge 0, stiffness 0", {}, 1e-7),
        long("pulsation behind", fork(outlet_pulsation=BEATING), "beta 1, R1 0, R2 0, C 0", {}, 1e-5),
        long("viscous", fork(wall_viscosity=0.15), "beta 1, radius 2, length 0, R1 0, C 0, viscosity 0", {}, 1e-6),
        weekly("viscous, losses", fork(TANGENT, wall_viscosity=0.15, shape=TAPERS, **LOSSES),
             "p1 1, gamma 0, radius 2, length 0, viscosity 0", {}, 1e-6),
    ],
)  # fmt: skip
def test_derivatives_of_the_inlet_pressure_are_those_of_differences(inflow, model, parts, practice, close):
    numerics = Numerics(samples=64, steps_per_cycle=2048, tolerance=1e-11, **practice)
    changes = [(part, int(vessel)) for part, vessel in map(str.split, parts.split(", "))]
    run = simulate_run(model, inflow, numerics)
    found = pressure_derivatives(run, inflow, [direction(one, model) for one in changes], numerics, 1e-10)
    for change, derivative in zip(changes, found, strict=True):
        moved = [part_times(*change, np.exp(k * APART))(model) for k in (1, -1, 2, -2)]
        near = None if practice else run
        expected = fourth_order([simulate_run(one, inflow, numerics, near).inlet_pressure(2048) for one in moved])
        assert np.max(np.abs(derivative - expected)) < close * np.max(np.abs(expected)), change


@pytest.mark.parametrize("name", ["linear", "tangent"])
def test_the_jacobian_of_a_fit_is_right_to_a_millionth_and_that_of_its_searches_to_a_hundredth(name):
    network, mouse = control_network(), virtual_mouse()
    space = parameter_space(name, network, estimate_nominal(network, mouse), Blood())
    numerics = Numerics(tolerance=1e-9)
    x, compared = np.log(space.nominal[space.free]), compared_part(mouse, "all")
    objectives = [
        Objective(space, compared, numerics, workers, threading.Event(), exactness)
        for workers, exactness in ((2, 1e-6), (1, 3e-3))
    ]
    exact, rough = (objective.jacobian(x) for objective in objectives)
    base = objectives[0].last
    numerics = replace(numerics, steps_per_cycle=base.steps)
    for i, unit in enumerate(np.eye(len(x))):
        one, two, minus, minus_two = (
            simulate_run(space.model(space.values(x + k * APART * unit)), mouse.inflow, numerics, base)
            for k in (1, 2, -1, -2)
        )
        p = [compared.simulated(run) for run in (one, minus, two, minus_two)]
        expected = -(8 * (p[0] - p[1]) - (p[2] - p[3])) / (12 * APART)
        size = np.max(np.abs(expected))
        assert np.max(np.abs(exact[:, i] - expected)) < 1e-6 * size, space.free_names[i]
        assert np.max(np.abs(rough[:, i] - expected)) < 1e-2 * size, space.free_names[i]


def test_at_small_amplitude_derivatives_are_those_of_the_linear_network():
    """Theory in the frequency domain, which shares no code with the scheme: dP/P of the first harmonics."""
    network, t = control_network(), np.arange(256) / 256
    q = np.exp(-0.5 * ((t - 0.2) / 0.02) ** 2)
    tiny = Inflow(1e-5 * q / q.mean(), 0.11)
    numerics = Numerics(cell_size=0.025, samples=256, tolerance=1e-12)
    model = Model(network, LinearWall(57.0), windkessels(network, 76.0, 0.11, a=0.12))
    run = simulate_run(model, tiny, numerics)
    for part in ("beta", "R1", "C"):

        def changed(factor, part=part):
            return part_times(part, slice(None), factor)(model)

        way = direction_between(changed(1.0), changed(2.0), np.log(2.0))
        found = np.fft.rfft(pressure_derivatives(run, tiny, [way], numerics)[0])[:8]
        low, high = (
            linear_solution(changed(np.exp(side * APART)), tiny).input_impedance[:8, network.root] for side in (-1, 1)
        )
        expected = (high - low) / (2 * APART) * np.fft.rfft(run.inlet_pressure(run.steps))[:8]
        expected /= linear_solution(model, tiny).input_impedance[:8, network.root]
        assert np.max(np.abs(found - expected)) < 0.01 * np.max(np.abs(expected)), part


def test_a_direction_that_changes_nothing_has_no_derivative_and_spectra_have_no_parameters(inflow):
    model = fork()
    numerics = Numerics(samples=64)
    run = simulate_run(model, inflow, numerics)
    still = direction_between(model, model, 1.0)
    assert not pressure_derivatives(run, inflow, [still], numerics).any()
    spectrum = model.changed(outlets=ImpedanceSpectrum(model.outlets.impedance_at(9, inflow.period)))
    with pytest.raises(InputError, match="derivatives need beds of one kind"):
        direction_between(spectrum, spectrum, 1.0)
    with pytest.raises(InputError, match="the same vessels and the same wall law"):
        direction_between(model, model.changed(wall=TANGENT), 1.0)
    with pytest.raises(InputError, match="same junctions"):
        direction_between(model, model.changed(junctions="total"), 1.0)
    with pytest.raises(InputError, match="viscous in both models or in none"):
        direction_between(model, model.changed(wall_viscosity=0.1), 1.0)
    total = model.changed(junctions="total")
    with pytest.raises(InputError, match="change in both models or in none"):
        direction_between(total, total.changed(shape=TAPERS), 1.0)


def test_a_derivative_that_does_not_become_periodic_is_an_error_and_never_zero(inflow):
    """No rounding meets this tolerance."""
    model, numerics = fork(), Numerics(samples=64)
    run = simulate_run(model, inflow, numerics)
    with pytest.raises(NumericalError, match="derivatives of the pressure do not become periodic"):
        pressure_derivatives(run, inflow, [direction(("beta", 0), model)], numerics, 1e-300)
