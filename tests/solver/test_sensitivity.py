"""Derivatives of the simulated pressure against central differences of fourth order and against theory."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from vasowave.calibration.compared import compared_part
from vasowave.calibration.objective import Objective
from vasowave.calibration.parameters import parameter_space
from vasowave.datasets import control_network, virtual_mouse
from vasowave.errors import InputError, NumericalError
from vasowave.model.blood import Blood, PowerLaw
from vasowave.model.linear import linear_solution
from vasowave.model.model import Model
from vasowave.model.nominal import estimate_nominal, windkessels
from vasowave.model.outlets import ImpedanceSpectrum
from vasowave.model.walls import LinearWall, TangentWall
from vasowave.network.network import Network
from vasowave.recording import Inflow
from vasowave.solver import Numerics
from vasowave.solver.direction import direction_between
from vasowave.solver.periodic import affine_fixed_point
from vasowave.solver.sensitivity import pressure_derivatives
from vasowave.solver.simulate import simulate_run
from vasowave.solver.varied_stepper import VariedStepper

_APART = 1e-3  # in the logarithm: the differences' own error is then below 1e-9
WALLS = pytest.mark.parametrize("wall", [LinearWall(57.0), TangentWall(9.0, 4.0)], ids=["linear", "tangent"])


def fork(wall, blood=None):
    network = Network(
        ("a", "b", "c"), np.array([-1, 0, 0]), np.array([0.75, 0.55, 0.35]), np.array([0.047, 0.037, 0.026])
    )
    return Model(network, wall, windkessels(network, 76.0, 0.11, a=0.2), blood or Blood())


def part_times(part, vessel, factor):
    """One model with one part of one vessel, or of the outlets, multiplied by a factor."""

    def changed(model):
        scale = np.ones(len(model.network))
        scale[vessel] = factor
        if part in ("length", "radius"):
            return model.changed(network=replace(model.network, **{part: getattr(model.network, part) * scale}))
        if part in model.wall._fields:
            return model.changed(wall=model.wall._replace(**{part: getattr(model.wall, part) * scale}))
        return model.changed(outlets=model.outlets._replace(**{part: getattr(model.outlets, part) * factor}))

    return changed


def differences(change, model, inflow, numerics, run=None):
    """Central difference of fourth order of the inlet pressure by the logarithm of a factor."""

    def pressure(power):
        moved = change(np.exp(power * _APART))(model)
        return simulate_run(moved, inflow, numerics, run).inlet_pressure(numerics.steps_per_cycle)

    return (8 * (pressure(1) - pressure(-1)) - (pressure(2) - pressure(-2))) / (12 * _APART)


@WALLS
@pytest.mark.parametrize("practice", [{}, {"cycles_from_rest": 2}], ids=["periodic", "from rest"])
def test_derivatives_by_stiffness_radius_length_and_outlets_are_those_of_central_differences(inflow, wall, practice):
    model = fork(wall, Blood(friction=PowerLaw(9.0)))
    numerics = Numerics(samples=64, steps_per_cycle=2048, tolerance=1e-11, **practice)
    parts = [*((name, 1) for name in wall._fields), ("radius", 2), ("length", 0), ("R1", 0), ("R2", 0), ("C", 0)]
    changes = [lambda f, part=part, vessel=vessel: part_times(part, vessel, f) for part, vessel in parts]
    directions = [direction_between(change(1.0)(model), change(2.0)(model), np.log(2.0)) for change in changes]
    run = simulate_run(model, inflow, numerics)
    found = pressure_derivatives(run, inflow, directions, numerics, 1e-9)
    for change, derivative, part in zip(changes, found, parts, strict=True):
        expected = differences(change, model, inflow, numerics, None if practice else run)
        assert np.max(np.abs(derivative - expected)) < 1e-6 * np.max(np.abs(expected)), part


@pytest.mark.parametrize("name", ["linear", "tangent"])
def test_the_jacobian_of_a_fit_is_right_to_a_millionth_and_that_of_its_searches_to_a_hundredth(name):
    network, mouse = control_network(), virtual_mouse()
    space = parameter_space(name, network, estimate_nominal(network, mouse), Blood(), {}, {}, False)
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
            simulate_run(space.model(space.values(x + k * _APART * unit)), mouse.inflow, numerics, base)
            for k in (1, 2, -1, -2)
        )
        p = [compared.simulated(run) for run in (one, minus, two, minus_two)]
        expected = -(8 * (p[0] - p[1]) - (p[2] - p[3])) / (12 * _APART)
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

        direction = direction_between(changed(1.0), changed(2.0), np.log(2.0))
        found = np.fft.rfft(pressure_derivatives(run, tiny, [direction], numerics)[0])[:8]
        low, high = (
            linear_solution(changed(np.exp(side * _APART)), tiny).input_impedance[:8, network.root] for side in (-1, 1)
        )
        expected = (high - low) / (2 * _APART) * np.fft.rfft(run.inlet_pressure(run.steps))[:8]
        expected /= linear_solution(model, tiny).input_impedance[:8, network.root]
        assert np.max(np.abs(found - expected)) < 0.01 * np.max(np.abs(expected)), part


def test_a_direction_that_changes_nothing_has_no_derivative_and_spectra_have_no_parameters(inflow):
    model = fork(LinearWall(57.0))
    numerics = Numerics(samples=64)
    run = simulate_run(model, inflow, numerics)
    still = direction_between(model, model, 1.0)
    assert not pressure_derivatives(run, inflow, [still], numerics).any()
    spectrum = model.changed(outlets=ImpedanceSpectrum(model.outlets.impedance_at(9, inflow.period)))
    with pytest.raises(InputError, match="derivatives need beds of one kind"):
        direction_between(spectrum, spectrum, 1.0)
    with pytest.raises(InputError, match="the same vessels and the same wall law"):
        direction_between(model, model.changed(wall=TangentWall(9.0, 4.0)), 1.0)


def test_outputs_of_affine_fixed_points_are_those_of_solving_the_equations_and_unmet_tolerances_are_told():
    rng = np.random.default_rng(3)
    M = rng.standard_normal((30, 30)) * 0.7 ** np.arange(30)
    M *= 0.8 / np.max(np.abs(np.linalg.eigvals(M)))
    b, C = rng.standard_normal((4, 30)), rng.standard_normal((30, 12))
    expected = np.linalg.solve(np.eye(30) - M, b.T).T @ C

    def cycle(x):
        return x @ M.T + b, x @ C

    found = affine_fixed_point(cycle, np.zeros((4, 30)), 1e-9, 20)
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-7 * np.max(np.abs(expected)))
    assert affine_fixed_point(cycle, np.zeros((4, 30)), 1e-9, 2) is None


def test_a_derivative_that_cannot_be_had_is_an_error_and_never_zero(inflow, monkeypatch):
    from vasowave.solver import sensitivity

    monkeypatch.setattr(sensitivity, "_MOST", 1)
    model, numerics = fork(LinearWall(57.0)), Numerics(samples=64)
    run = simulate_run(model, inflow, numerics)
    wall = model.changed(wall=LinearWall(60.0))
    with pytest.raises(NumericalError, match="derivatives of the pressure do not become periodic"):
        pressure_derivatives(run, inflow, [direction_between(model, wall, 1.0)], numerics)


def arrays(one):
    """All arrays in a bundle of bundles, each once."""
    if isinstance(one, np.ndarray):
        return {id(one): one}
    return {k: v for part in one for k, v in arrays(part).items()} if isinstance(one, tuple) else {}


@WALLS
def test_no_array_that_kernels_write_overlaps_another(inflow, wall):
    """They are compiled for that (`cells.Distinct`): with an overlap they would be wrong in silence."""
    model = fork(wall)
    run = simulate_run(model, inflow, Numerics(samples=64, every_cell=True))
    varied = VariedStepper(run, inflow, [direction_between(model, model, 1.0)])
    stepper = varied.stepper
    written = arrays(
        (
            varied.base,
            varied.scratch,
            varied.inlet,
            varied.watched_waves,
            stepper.watched_waves,
            stepper.stations,
            stepper.cells,
        )
    )
    read = arrays((stepper.parts, stepper.law, stepper.outlets, stepper.inflow, varied.shifted, varied.weights))
    every = written | read
    assert len(written) > 40
    for key, one in written.items():
        assert not [name for name, other in every.items() if name != key and np.may_share_memory(one, other)]
