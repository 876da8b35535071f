"""The kernels as Python runs them: all combinations of walls, shapes, drives and beds, a few steps each.

Each combination is compiled for some seconds, so that few are run otherwise. What is approved was found right by the
other tests here: volume is kept, hardly viscous walls are elastic ones, derivatives are those of differences.
"""

from dataclasses import replace

import numpy as np
import pytest
from in_python import in_python, use_python
from test_sensitivity import part_times

import vasowave as vw
from approval import approve, parts
from vasowave.model import walls
from vasowave.model.blood import Blood, PowerLaw
from vasowave.model.nominal import windkessels
from vasowave.model.shape import Shape
from vasowave.model.ventricle import Ventricle
from vasowave.recording import Inflow, InletPressure
from vasowave.solver import (
    Numerics,
    beds,
    cells,
    changing,
    changing_variations,
    cycle,
    laws,
    node_variations,
    nodes,
    powers,
    valve,
    variations,
    varied_cycle,
    viscosity,
    viscosity_variations,
)
from vasowave.solver.direction import direction_between
from vasowave.solver.grid import make_grid
from vasowave.solver.run import run_cycles
from vasowave.solver.start import at_rest
from vasowave.solver.state import Scale, State
from vasowave.solver.stepper import Stepper
from vasowave.solver.varied_stepper import VariedStepper

MODULES = (beds, cells, changing, cycle, laws, nodes, powers, valve, viscosity, changing_variations, node_variations,
           varied_cycle, variations, viscosity_variations, walls)  # fmt: skip
PERIOD, STEPS = 0.006875, 32
SHARE = np.arange(STEPS) / STEPS
COUNTS = {"fork": (4, 3, 1), "ring": (2, 2, 4, 1, 1, 2, 3)}
LINEAR, TANGENT = vw.LinearWall(57.0), vw.TangentWall(9.0, 4.0)
WAVE = 2.0 * np.sin(2 * np.pi * SHARE + 0.3)
SHAPE = Shape(np.array([[1.05, 0.95], [1.0, 1.0], [0.9, 1.1]]), np.array([[1.0, 1.2], [1.0, 1.0], [1.0, 0.8]]))
TAPERS = {"shape": SHAPE, "loss": np.array([0.0, 0.8, 0.5])}
DRIVES = {
    "flow": Inflow(0.17 * (1 + np.sin(2 * np.pi * SHARE)), PERIOD),
    "pressure": InletPressure(9.0 + 4.0 * np.sin(2 * np.pi * SHARE), PERIOD),
    "ventricle": Ventricle.from_peak(230.0, 100.0, PERIOD, 6.0, at=0.3),
}


@pytest.fixture(autouse=True)
def _python(monkeypatch):
    use_python(monkeypatch)


def fork(wall=LINEAR, **more):
    network = vw.Network(("a", "b", "c"), [-1, 0, 0], [0.75, 0.55, 0.15], [0.047, 0.037, 0.026])
    return vw.Model(network, wall, windkessels(network, 76.0, 0.11, a=0.2), Blood(friction=PowerLaw(5.0)), **more)


def ring(wall=LINEAR, **more):
    """Return a network whose vessels meet again, with a vessel across."""
    nodes_of = [[0, 1], [1, 2], [1, 3], [2, 4], [3, 4], [2, 3], [4, 5]]
    sizes = [0.5, 0.6, 0.9, 0.2, 0.18, 0.4, 0.4], [0.05, 0.035, 0.03, 0.03, 0.025, 0.02, 0.04]
    network = vw.Network(tuple("abcdefg"), None, *sizes, nodes=nodes_of)
    return vw.Model(network, wall, vw.Windkessel(*(np.array([one]) for one in (10.0, 60.0, 1.5e-3))), **more)


def two_inlets(**more):
    network = vw.Network(tuple("abcd"), None, [0.6, 0.5, 0.7, 0.4], [0.04, 0.045, 0.05, 0.03],
                         nodes=[[0, 2], [1, 2], [2, 3], [2, 4]])  # fmt: skip
    return vw.Model(network, TANGENT, windkessels(network, 76.0, 0.11, a=0.2), **more)


def stepper_of(model, drive="flow", steps=STEPS, samples=16):
    """Return what runs cycles of a model, and a state with pressures and flows that differ from slot to slot."""
    count = COUNTS["ring" if len(model.network) == 7 else "fork"] if len(model.network) != 4 else (2, 3, 3, 1)
    grid = make_grid(model, np.array(count))
    driven = DRIVES[drive] if isinstance(drive, str) else drive
    stepper = Stepper(grid, driven, Numerics(samples=samples, every_cell=True), steps, grid.vessels.last[1:3])
    rest = at_rest(grid, stepper.beds)
    place = np.arange(len(rest.area))
    area = grid.area0 * grid.wall.ratio_at(8.0 + np.cos(place), *grid.wall)
    flow = np.where(grid.has_state, 0.06 + 0.03 * np.sin(2.0 * place), 0.0)
    return stepper, State(area, flow, rest.memory + 5.0 + np.arange(rest.memory.size).reshape(rest.memory.shape))


def found_of(model, drive="flow"):
    stepper, state = stepper_of(model, drive)
    end = stepper.cycle(state)
    return {"end": end, "stations": stepper.stations, "cells": stepper.cells, "seen": stepper.watched_waves,
            "mach": stepper.mach.value, "courant": stepper.courant, "volume error": stepper.volume_error,
            "nodes": stepper.scratch[2].pressure}  # fmt: skip


CASES = {
    "elastic": (fork(), "flow"),
    "tangent, with a pulsation behind": (fork(TANGENT, outlet_pulsation=WAVE), "flow"),
    "pressure": (fork(TANGENT), "pressure"),
    "ventricle": (fork(), "ventricle"),
    "changing, total pressure, losses": (fork(TANGENT, **TAPERS), "flow"),
    "changing, ventricle": (fork(LINEAR, **TAPERS), "ventricle"),
    "changing, pressure, pulsation": (fork(LINEAR, **TAPERS, outlet_pulsation=WAVE), "pressure"),
    "ring": (ring(TANGENT), "flow"),
    "ring, static": (ring(LINEAR, junctions="static"), "ventricle"),
}


@pytest.mark.parametrize("case", CASES)
def test_volume_is_kept_and_hardly_viscous_walls_are_elastic_in_every_combination(case):
    """The nodes of elastic walls are solved one by one and share no line with those of viscous walls."""
    model, drive = CASES[case]
    elastic = found_of(model, drive)
    viscous = found_of(model.changed(wall_viscosity=1e-9), drive)
    assert abs(elastic["volume error"]) < 1e-13
    assert abs(viscous["volume error"]) < 1e-13
    for name in ("area", "flow", "memory"):
        one, other = getattr(elastic["end"], name), getattr(viscous["end"], name)
        assert np.max(np.abs(one - other)) < 1e-6 * np.max(np.abs(one)), name
    assert np.max(np.abs(elastic["stations"] - viscous["stations"][:2])) < 1e-6
    assert np.max(np.abs(elastic["cells"] - viscous["cells"][:2])) < 1e-6
    assert np.max(np.abs(elastic["seen"] - viscous["seen"][:2])) < 1e-6
    assert np.max(np.abs(viscous["stations"][2])) < 1e-5


def test_approved_a_cycle_of_every_combination():
    lines = []
    for viscous in (0.0, 0.15):
        for name, (model, drive) in CASES.items():
            kind = f"{name}{', viscous' if viscous else ''}"
            found = found_of(model.changed(wall_viscosity=viscous), drive)
            memory = found["end"].memory
            found |= {"area": found["end"].area, "flow": found["end"].flow, "memory": memory.view(float), "end": 0}
            lines += parts(kind, {key: value for key, value in found.items() if key != "volume error"})
    approve("kernels", lines, 1e-9, 2e-5)


@pytest.mark.parametrize("viscosity", [0.0, 0.1])
def test_flows_of_several_inlets_are_all_that_enters(viscosity):
    flow = np.column_stack([0.1 + 0.05 * np.sin(2 * np.pi * SHARE), 0.05 + 0.04 * np.cos(2 * np.pi * SHARE)])
    stepper, state = stepper_of(two_inlets(wall_viscosity=viscosity), Inflow(flow, PERIOD))
    stepper.cycle(state)
    assert abs(stepper.volume_error) < 1e-13
    assert stepper.watched_waves[1, :, :2] == pytest.approx(flow, abs=1e-12)


@pytest.mark.parametrize("viscosity", [0.0, 0.1])
@pytest.mark.parametrize("drive", ["flow", "ventricle", "pressure"])
def test_pressures_meet_in_nodes_and_a_bed_answers_what_flows_into_it(drive, viscosity):
    """In a static tree all ends of a node have its pressure; viscous pressure is part of it."""
    model = fork(TANGENT, junctions="static", wall_viscosity=viscosity)
    stepper, state = stepper_of(model, drive, samples=32)
    end = stepper.cycle(state)
    ratio = stepper.stations[0] / model.area0[:, np.newaxis]
    pressure = TANGENT.pressure_at(ratio, *TANGENT)
    pressure = pressure + stepper.stations[2] if viscosity else pressure
    flow = stepper.stations[1]
    assert pressure[:, 0, 2] == pytest.approx(pressure[:, 1, 0], abs=2e-7)
    assert pressure[:, 0, 2] == pytest.approx(pressure[:, 2, 0], abs=2e-7)
    assert flow[:, 0, 2] == pytest.approx(flow[:, 1:, 0].sum(axis=1), abs=1e-12)
    R1, R2, C = (float(one[1]) for one in model.outlets)
    stored, dt = state.memory[1, 0].real, PERIOD / STEPS
    for p, q in zip(pressure[:, 2, 2], flow[:, 2, 2], strict=True):
        half = np.exp(-0.5 * dt / (R2 * C))
        assert p == pytest.approx(R1 * q + half * stored + R2 * (1 - half) * q, abs=2e-6)
        stored = half**2 * stored + R2 * (1 - half**2) * q
    assert end.memory[1, 0].real == pytest.approx(stored)
    if drive == "pressure":
        assert pressure[:, 0, 0] == pytest.approx(DRIVES["pressure"].pressure, abs=2e-7)


def test_viscous_pressure_is_that_of_the_rate_at_which_cells_stretch():
    """ψ = η/(2 √(A A0)) ∂A/∂t, by the areas before and after a step about that in the middle."""
    model = fork(wall_viscosity=0.15)
    stepper, state = stepper_of(model, samples=32)
    dt, grid = PERIOD / STEPS, stepper.grid
    stepper.cycle(state)
    middle, psi = stepper.cells[0], stepper.cells[2]
    for slot in np.flatnonzero(grid.is_cell):
        rate = np.gradient(middle[:, slot], dt, edge_order=2)
        expected = 0.15 / (2 * np.sqrt(middle[:, slot] * grid.area0[slot])) * rate
        assert psi[2:-2, slot] == pytest.approx(expected[2:-2], abs=0.05 * np.max(np.abs(expected)))


def test_a_pulse_in_python_is_that_of_the_compiled_kernel(monkeypatch):
    for model in (fork(), fork(wall_viscosity=0.15)):
        plain = found_of(model)
        with monkeypatch.context() as real:
            real.undo()
            compiled = found_of(model)
        use_python(monkeypatch)
        assert plain["end"].area == pytest.approx(compiled["end"].area, rel=1e-12)
        assert plain["stations"] == pytest.approx(compiled["stations"], rel=1e-10, abs=1e-13)


APART = 1e-4
VARIED = {
    "elastic": (fork(TANGENT), "flow", "p1 1, gamma 0, radius 2, length 2, C 0"),
    "pressure, pulsation": (fork(outlet_pulsation=WAVE), "pressure", "beta 0, length 1, R2 0"),
    "changing": (fork(TANGENT, **TAPERS), "flow", "p1 0, gamma 2, radius 2, length 0"),
    "viscous": (fork(wall_viscosity=0.15), "flow", "beta 1, length 2, R1 0, viscosity 0"),
    "viscous, changing": (fork(wall_viscosity=0.15, **TAPERS), "flow", "radius 0, length 0, viscosity 0"),
    "ring": (ring(wall_viscosity=0.1), "flow", "beta 4, length 5"),
}  # fmt: skip


def times(part, vessel, factor):
    if part == "viscosity":
        return lambda model: model.changed(wall_viscosity=factor * np.asarray(model.wall_viscosity))
    return part_times(part, vessel, factor)


@pytest.mark.parametrize("case", VARIED)
def test_changes_in_python_are_the_differences_of_cycles_in_python(case):
    """From one state: what a cycle makes of a changed model, and of a changed state."""
    model, drive, words = VARIED[case]
    named = [(part, int(row)) for part, row in map(str.split, words.split(", "))]
    driven = DRIVES[drive]
    count = np.array(COUNTS["ring" if len(model.network) == 7 else "fork"])
    grid = make_grid(model, count)
    run = run_cycles(model, driven, Numerics(samples=16, steps_per_cycle=STEPS, cell_size=0.5), 1)
    _, begin = stepper_of(model, drive)
    run = ended_in(run, grid, begin)
    directions = [
        direction_between(times(*one, np.exp(-APART))(model), times(*one, np.exp(APART))(model), 2 * APART)
        for one in named
    ]
    varied = VariedStepper(run, driven, directions, grid.vessels.last[:2])
    start = run.scale.vector(begin)
    rng = np.random.default_rng(3)
    change = 0.1 * rng.standard_normal(len(start))
    moved = np.zeros((len(named), len(start)))
    moved[-1] = change
    ends, seen = varied.cycle(moved)

    def ending(factor, row):
        after = Stepper(make_grid(times(*named[row], np.exp(factor))(model), count), driven, Numerics(samples=1), STEPS,
                        grid.vessels.last[:2])  # fmt: skip
        at = run.scale.state(start + (factor * change if row == len(named) - 1 else 0.0))
        end = run.scale.vector(after.cycle(at))
        wall, area0 = after.grid.model.at(0, 0.0)
        pressure = walls.pressure(wall, after.watched_waves[0, :, 0], area0)
        law = after.law[1]
        faces = grid.vessels.last[:2]
        ratios = after.watched_waves[0, :, 1:] / after.grid.face_area0[faces]
        watched = type(law).pressure_at(ratios, *(one[faces] for one in law))
        others = after.watched_waves[1:, :, 1:].reshape(-1)
        if len(after.watched_waves) > 2:
            pressure = pressure + after.watched_waves[2, :, 0]
        return end, np.concatenate([pressure, watched.ravel(), others])

    for row in range(len(named)):
        (up, seen_up), (down, seen_down) = (ending(side * APART, row) for side in (1, -1))
        for found, a, b in ((ends[row], up, down), (seen[row], seen_up, seen_down)):
            expected = (a - b) / (2 * APART)
            assert np.max(np.abs(found - expected)) < 2e-6 * np.max(np.abs(expected)), named[row]


def ended_in(run, grid, end):
    """Return a run on another grid, as if it had ended in another state."""
    return replace(run, grid=grid, end=end, scale=Scale(grid, np.full(len(grid.model.network), 8.0)))


def test_kernels_in_python_are_those_of_their_modules():
    plain = in_python(cycle._compiled())
    assert plain.__globals__["find_fluxes"].__code__ is cells.find_fluxes.py_func.__code__
    own = {one.__module__ for one in vars(cycle).values() if hasattr(one, "py_func")}
    assert {one for one in own if one.startswith("vasowave.solver.")} <= {one.__name__ for one in MODULES}
