"""Rules of the solver around its kernels: steps, cells, errors of a grid, ends of a search, and words of failures."""

from types import SimpleNamespace

import numpy as np
import pytest
from in_python import use_python

import vasowave as vw
from approval import approve, parts
from vasowave.errors import InputError, NumericalError
from vasowave.model.linear import linear_solution
from vasowave.model.nominal import windkessels
from vasowave.model.shape import Shape
from vasowave.recording import Inflow
from vasowave.solver import Numerics, failures
from vasowave.solver.dataset import stack
from vasowave.solver.discharge import common_discharge
from vasowave.solver.grid import cell_counts, make_grid, wave_cells
from vasowave.solver.grid_error import echoes, judge
from vasowave.solver.middles import cells_for_middles, find_middles, middle_errors
from vasowave.solver.periodic import affine_fixed_point, fixed_point
from vasowave.solver.places import Places, Waves, at_places
from vasowave.solver.start import at_rest
from vasowave.solver.state import Scale, State
from vasowave.solver.validity import Extreme, Extremes, find_extremes, notes_of, require_subcritical

PERIOD = 0.11
T = np.arange(64) / 64
FLOW = Inflow(0.17 * (1 + np.sin(2 * np.pi * T) + 0.3 * np.cos(6 * np.pi * T)), PERIOD)


LINEAR = vw.LinearWall(57.0)


def fork(wall=LINEAR, radius=(0.047, 0.037, 0.012), **more):
    network = vw.Network(("a", "b", "c"), [-1, 0, 0], [0.75, 0.55, 0.4], list(radius))
    return vw.Model(network, wall, windkessels(network, 76.0, PERIOD, a=0.2), **more)


def said(error, function, *given, **more):
    with pytest.raises(error) as raised:
        function(*given, **more)
    return str(raised.value)


def test_steps_are_multiples_of_a_quarter_of_the_samples_while_few_and_of_twice_as_many_while_many():
    of = Numerics(samples=64)
    assert [of.steps_for(demand) for demand in (1, 64, 65, 81, 255, 256)] == [64, 64, 80, 96, 256, 256]
    assert [of.steps_for(demand) for demand in (257, 321, 1024, 1025, 1300)] == [320, 384, 1024, 1152, 1408]
    assert [Numerics(samples=63).steps_for(demand) for demand in (64, 200)] == [126, 252]
    assert Numerics(samples=64, cycles_from_rest=2).steps_for(65) == 128
    assert Numerics(samples=64, most_steps=1000).largest_steps == 960
    assert Numerics(samples=64, most_steps=10).largest_steps == 64
    assert [of.kept_every(steps) for steps in (64, 128, 192, 256, 80, 512, 1024)] == [1, 2, 3, 4, 1, 4, 4]
    assert "steps_per_cycle 63 is less than samples 64 or no multiple of 16; take 64" in said(
        InputError, Numerics, samples=64, steps_per_cycle=63
    )
    assert "steps_per_cycle 90 is less than samples 64 or no multiple of 16; take 96" in said(
        InputError, Numerics, samples=64, steps_per_cycle=90
    )
    for more in ({"steps_per_cycle": 512}, {"cycles_from_rest": 3}):
        assert "accuracy chooses steps and cycles" in said(InputError, Numerics, accuracy=0.1, **more)


def test_slots_of_a_grid_are_cells_and_ghosts():
    """Four cells, one, and two: five slots, three, and three."""
    grid = make_grid(fork(shape=Shape(np.array([[1.0, 1.0], [1.1, 0.9], [1.0, 1.0]]))), np.array([4, 1, 2]))
    assert grid.vessel.tolist() == [0] * 5 + [1] * 3 + [2] * 3
    assert (grid.vessels.first.tolist(), grid.vessels.last.tolist()) == ([0, 5, 8], [4, 6, 10])
    assert grid.vessels.single.tolist() == []
    nan = np.nan
    expected = [0.09375, 0.28125, 0.46875, 0.65625, nan, 0.275, 0.825, -0.275, 0.1, 0.3, nan]
    assert grid.position == pytest.approx(expected, nan_ok=True)
    assert grid.is_cell.tolist() == [True] * 4 + [False, True, False, False, True, True, False]
    assert grid.has_state.tolist() == [True] * 4 + [False] + [True] * 5 + [False]
    assert grid.spacing[[0, 5, 8]] == pytest.approx([0.1875, 0.55, 0.2])
    assert grid.share[0][[0, 4, 5, 6, 8]] == pytest.approx([0.125, 0.875, 0.5, 0.5, 0.25])
    assert grid.share[1][[0, 3, 4, 5, 6, 10]] == pytest.approx([0, 0.75, 1, 0, 1, 1])
    assert [one.tolist() for one in grid.changing] == [[], [5], [5, 6, 7], [2, 4], [5]]
    start, vessel, side = grid.joined_ends
    assert (start.tolist(), vessel.tolist(), side.tolist()) == ([0, 4, 5, 6], [0, 0, 1, 2, 1, 2], [1, -1, 1, 1, -1, -1])
    ends = grid.ends(0.002, 0.1)
    assert (ends.inlet, ends.first_terminal) == (1, 2)
    assert ends.face.tolist() == [4, 0, 6, 10, 5, 8]
    assert ends.cell.tolist() == [3, 0, 5, 9, 5, 8]
    assert ends.inner.tolist() == [2, 1, 7, 8, 6, 9]
    assert ends.half == pytest.approx(0.001 / grid.spacing[[3, 0, 5, 9, 5, 8]])
    assert ends.density[[1, 2, 3]].tolist() == [0, 0, 0]
    assert (ends.density[[0, 4, 5]] > 0).all()
    middle = make_grid(fork(), np.array([3, 1, 2])).middle
    assert middle.tolist() == [1, 1, 1]
    tapered = grid.middle
    assert tapered == pytest.approx([1, 1 / (0.5 * (1.1**2 + 0.9**2)), 1])


def test_drag_along_a_cell_that_changes_is_simpsons_integral():
    model = fork(shape=Shape(np.array([[1.0, 1.0], [1.2, 0.8], [1.0, 1.0]])))
    grid = make_grid(model, np.array([1, 1, 1]))
    found = grid.drag_along(model, 0.3, 0.0, np.array([3]))
    x = np.linspace(0, 1, 2001)
    A = np.pi * (0.037 * (1.2 - 0.4 * x)) ** 2
    mean_of_faces = 0.5 * (1 / A[0] + 1 / A[-1]) / (0.5 * (A[0] + A[-1]))
    assert found == pytest.approx([np.trapezoid(1 / A**2, x) / mean_of_faces], rel=1e-4)
    assert grid.drag_along(model, 0.0, 0.0, np.array([3])).tolist() == [1.0]


def test_places_lie_between_two_faces():
    grid = make_grid(fork(), np.array([4, 1, 2]))
    faces, between = Places(np.array([0, 0, 1, 2]), np.array([0.3, 1.0, 0.25, 0.5])).faces(grid)
    assert faces.tolist() == [[1, 3, 5, 9], [2, 4, 6, 10]]
    assert between == pytest.approx([0.2, 1.0, 0.25, 0.0])
    assert at_places(np.array([[1.0, 2, 3, 5]]), np.array([0.25, 0.5])) == pytest.approx(np.array([[1.5, 3.5]]))
    waves = Waves(np.array([9.0]), np.array([0.6]), np.array([0.04]))
    small = Waves(np.array([1.0]), np.array([0.1]), np.array([0.002]))
    assert waves.of("velocity") == pytest.approx([15.0])
    assert waves.of("diameter") == pytest.approx([2 * np.sqrt(0.04 / np.pi)])
    assert waves.of("pressure").tolist() == [9.0]
    after = Waves(*(one + 1e-6 * other for one, other in zip(waves, small, strict=True)))
    for name in ("pressure", "flow", "area", "velocity", "diameter"):
        expected = (after.of(name) - waves.of(name)) / 1e-6
        assert waves.changed(name, small) == pytest.approx(expected, rel=1e-4)


SHAPE = Shape(np.array([[1.1, 0.9], [1.0, 1.0], [0.9, 1.2]]), np.array([[1, 1.2], [1, 1], [1, 1]]))
MODELS = {
    "straight": (fork(), (4, 3, 2)),
    "thin, tangent": (fork(vw.TangentWall(9.0, 4.0), (0.047, 0.037, 0.006)), (3, 2, 4)),
    "shaped": (fork(shape=SHAPE), (2, 1, 3)),
}


def test_approved_judgments_of_a_grid_and_its_discharge():
    lines = []
    for name, (model, counts) in MODELS.items():
        linear = linear_solution(model, FLOW)
        grid = make_grid(model, np.array(counts))
        network, rows = model.network, np.arange(3)
        waves = np.array([
            [linear.over_cycle(values, 128) for values in linear.at(rows, share * network.length)]
            for share in (0.0, 0.5, 1.0)
        ])  # fmt: skip
        pressure, flow = np.moveaxis(waves, 0, -1)
        wall, area0 = model.at(np.broadcast_to(rows[:, None], (3, 3)), np.broadcast_to([0, 0.5, 1.0], (3, 3)))
        area = area0 * wall.ratio_at(pressure, *wall)
        middles = find_middles(model, PERIOD, np.array([area, flow]))
        judged = judge(grid, PERIOD, 512, area, middles)
        beds = model.outlets.rational(PERIOD)
        scale = Scale(grid, linear.mean_pressure)
        rest = at_rest(grid, beds)
        wider = State(grid.area0 * grid.wall.ratio_at(6.0, *grid.wall), rest.flow, rest.memory)
        for key, value in {
            "judged": judged, "middles": middles, "echoes": echoes(model, PERIOD, area.mean(axis=(0, 2))),
            "discharge": common_discharge(grid, scale, wider, beds, PERIOD),
            "held": common_discharge(grid, scale, wider, beds, PERIOD, held=True),
            "extremes": find_extremes(grid, PERIOD, np.moveaxis(pressure, 1, 2), judged),
            "counts": cell_counts(model, None, linear), "given": cell_counts(model, 0.2, linear, 0.5),
            "waves": wave_cells(linear), "cells": grid.cells(1e-4, (0.3, 2.0)), "faces": grid.faces(1e-4),
        }.items():  # fmt: skip
            lines += parts(f"{name}, {key}", value)
    approve("grids", lines, 1e-9, 2e-4)


def test_a_middle_of_a_cell_is_where_half_of_the_integral_is_reached():
    """Without a change of pressure nothing is wrong; with a fall the error grows with its square."""
    model = fork()
    flow = np.full((4, 1), 0.05)
    ends = np.array([np.full((4, 1), 12.0), flow]), np.array([np.full((4, 1), 12.0), flow])
    assert middle_errors(model, PERIOD, ends, np.array([2])) == pytest.approx(np.zeros((4, 1)))
    one, two = (
        middle_errors(model, PERIOD, (np.array([np.full((4, 1), 12 + fall), flow]), ends[1]), np.array([2]))[0, 0]
        for fall in (1.0, 2.0)
    )
    assert two / one == pytest.approx(4.0, rel=0.1)
    known = SimpleNamespace(rows=np.array([0, 2]), error=np.array([[0.01, 1.0], [0.02, 0.5]]), largest=20.0,
                            fall=np.array([0.05, 0.3]))  # fmt: skip
    run = SimpleNamespace(grid=SimpleNamespace(counts=np.array([1, 3, 1])), middles=known)
    assert cells_for_middles(run).tolist() == [1, 1, 6]  # √(0.05/0.0025)/2 = 2.2: six


def test_a_fixed_point_is_found_with_what_is_to_come_and_within_what_is_allowed():
    M, b = np.array([[0.9, 0.1, 0.0], [0.0, 0.5, 0.2], [0.1, 0.0, 0.3]]), np.array([1.0, 2.0, 3.0])
    expected = np.linalg.solve(np.eye(3) - M, b)

    def cycle(x):
        return M @ x + b

    found, how = fixed_point(cycle, np.zeros(3), 1e-9, 20, lambda x: True, lambda change: 0 * change)
    assert found == pytest.approx(expected)
    assert how.converged
    assert len(how.changes) <= 6
    again, quick = fixed_point(cycle, expected + 1, 1e-9, 20, lambda x: True, lambda change: 0 * change, how.secants)
    assert again == pytest.approx(expected)
    assert len(quick.changes) <= len(how.changes)
    whole = np.linalg.solve(np.eye(3) - M, M)
    _, at_once = fixed_point(cycle, np.zeros(3), 1e-9, 20, lambda x: True, lambda change: whole @ change)
    assert len(at_once.changes) == 2
    _, plain = fixed_point(cycle, np.zeros(3), 1e-9, 4, lambda x: False, lambda change: 0 * change)
    assert plain.changes[:1] == (3.0,)
    assert plain.changes[1] == pytest.approx(np.abs(M @ b).max())
    assert not plain.converged
    rows = np.array([b, 2 * b + [0, 1, 0]])
    outputs = affine_fixed_point(lambda x: (x @ M.T + rows, x @ M.T[:, :2] + 1), np.zeros((2, 3)), 1e-10, 12)
    points = np.linalg.solve(np.eye(3) - M, rows.T).T
    assert outputs == pytest.approx(points @ M.T[:, :2] + 1)
    assert affine_fixed_point(lambda x: (x @ M.T + rows, x), np.zeros((2, 3)), 1e-10, 1) is None


def extremes(error=0.0, low=5.0, strain=0.1):
    worst = Extreme(error, "a", 0.03)
    return Extremes(Extreme(0.1, "a", 0.0), Extreme(low, "b", 0.01), Extreme(strain, "c", 0.02), worst)


def test_notes_begin_at_their_limits():
    from vasowave.solver.validity import GRID_SHARE

    assert notes_of(extremes(error=0.999 * GRID_SHARE * 20), 20.0, -1.0) == ()
    (grid,) = notes_of(extremes(error=1.001 * GRID_SHARE * 20), 20.0, -1.0)
    assert "by the end of vessel 'a' at t = 0.03 s" in str(grid)
    assert notes_of(extremes(error=9.0), 20.0, -1.0, 0.01) == ()
    assert "costs all meaning" in str(notes_of(extremes(error=6.0), 20.0, -1.0)[0])
    assert "(29.9 % of the largest pressure)" in str(notes_of(extremes(error=5.98), 20.0, -1.0)[0])
    assert notes_of(extremes(error=np.inf), 20.0, -1.0)[0].code == "solver.depends-on-grid-alone"
    assert notes_of(extremes(low=-1.0), 20.0, -1.0) == ()
    (low,) = notes_of(extremes(low=-1.1), 20.0, -1.0)
    assert "falls to -1.1 mmHg at t = 0.01 s" in str(low)
    assert notes_of(extremes(strain=3.0), 20.0, -1.0) == ()
    (wide,) = notes_of(extremes(strain=3.01), 20.0, -1.0)
    assert "'c' is strained beyond what an artery survives: its area grows by 301 % at t = 0.02 s" in str(wide)
    require_subcritical(Extreme(0.999, "a", 0.1))
    assert said(NumericalError, require_subcritical, Extreme(1.0, "a", 0.0123456)).startswith(
        "vessel 'a', t = 0.01235 s: the flow passes the wave speed (|u|/c = 1.00) where"
    )


def state(grid, ratio=1.2, flow=0.01):
    return State(grid.area0 * ratio, np.full(len(grid.area0), flow), np.zeros((2, 1), complex))


def test_failures_name_the_vessel_the_time_and_the_cause():
    grid = make_grid(fork(vw.TangentWall(9.0, 1.0)), np.array([4, 1, 2]))
    fine = state(grid)
    assert "the wall reaches its largest area, 1.5 times the undeformed one" in str(
        failures.left_law(grid, state(grid, 1.5), 8, None, 0.0123456)
    )
    low = str(failures.left_law(grid, state(grid, 0.5), 8, None, 0.0123456))
    assert low.startswith("vessel 'c', t = 0.01235 s: the vessel collapses (its area falls to 0.5 of the undeformed")
    assert "(its area falls to 0 of" in str(failures.left_law(grid, state(grid, -1.0), 0, None, 0.0))
    assert "area or flow is no longer a number" in str(failures.left_law(grid, state(grid, np.nan), 0, None, 0.0))
    at_face = str(failures.left_law(grid, fine, 6, 1.6 * float(grid.face_area0[6]), 0.0))
    assert at_face.startswith("vessel 'b', t = 0 s: the wall reaches its largest area")
    steep = str(failures.too_steep(grid, 1, 0.01))
    assert (
        "a wave is too steep for the only cell of this vessel (0.55 cm); take shorter cells, Numerics(cell_size=0.22)"
        in steep
    )
    calm = str(failures.no_balance(grid, fine, 0, 0.01))
    assert (
        "no pressure balances the flows at its end; the wall is too soft, or an outlet or a narrowing too tight, for"
        in calm
    )
    fast = str(failures.no_balance(grid, state(grid, 1.2, 50.0), 0, 0.01))
    assert "; the flow passes the wave speed there (|u|/c = " in fast
    assert "too soft" not in fast
    total = make_grid(fork(vw.TangentWall(9.0, 1.0), junctions="total"), np.array([4, 1, 2]))
    assert "at one total pressure a flow passes a junction no faster" in str(failures.no_balance(total, fine, 0, 0.0))
    assert "at one total pressure" not in str(failures.no_balance(total, fine, 1, 0.0))
    assert "(from 64 to 900 a cycle)" in str(failures.runaway("x: ", 64, 900))
    found = str(failures.faster_than_allowed(grid, "x: ", 900, 100))
    assert "about 900 steps a cycle, more than most_steps = 100: check radius, length and stiffness" in found
    assert "of this vessel, merge it" in found
    alone = vw.Network(("a",), [-1], [1.0], [0.05])
    one = vw.Model(alone, vw.LinearWall(57.0), windkessels(alone, 76.0, PERIOD, a=0.2))
    single, cut = make_grid(one, np.array([1])), make_grid(one, np.array([3]))
    assert "this vessel, or go on in Python" in str(failures.faster_than_allowed(single, "", 900, 100))
    assert "take longer cells (a larger cell_size)" in str(failures.faster_than_allowed(cut, "", 900, 100))
    linear = linear_solution(one, FLOW)
    assert str(failures.too_many_steps(single, linear, np.array([1234.4]), 100)).startswith(
        "vessel 'a' (1 cm, radius 0.05 cm) asks for about 1234 steps a cycle, more than most_steps = 100: check it, or"
    )
    of_fork = fork()
    many = str(failures.too_many_steps(grid, linear_solution(of_fork, FLOW), np.array([10.0, 300.0, 20.0]), 100))
    assert many.startswith("vessel 'b' (0.55 cm, radius 0.037 cm) asks for about 300 steps a cycle, more than")
    assert "; of 2 others the next asks for 20. It holds" in many


def test_what_does_not_become_periodic_says_why():
    model = fork()
    grid = make_grid(model, np.array([4, 1, 2]))
    beds = model.outlets.rational(PERIOD)

    def why(changes, of=beds, ratio=1.2):
        return str(failures.not_periodic(grid, state(grid, ratio), of, tuple(changes), 1e-4, PERIOD))

    falling = [1.0 / 2**i for i in range(15)]
    assert why(falling).startswith("not periodic after 15 cycles: the last one still changed by 6.1e-05 mmHg")
    assert "the changes grow smaller: raise most_cycles, or tolerance" in why(falling)
    assert "the changes no longer grow smaller" in why([1.0] * 15)
    assert "the changes no longer grow smaller" in why([*falling[:14], 3 * falling[13]])
    assert "the changes grow smaller" in why([1.0] * 10)  # too few to tell
    slow = windkessels(model.network, 76.0, 4.0 * PERIOD, a=0.2).rational(PERIOD)
    assert "the slowest bed's time constant is" in why(falling, slow)
    assert "no vessel is near collapse or near its largest area" in why([1.0] * 15)
    tangent = make_grid(fork(vw.TangentWall(9.0, 1.0)), np.array([4, 1, 2]))
    assert "vessel 'a' is near its largest area" in failures.at_the_edge(tangent, state(tangent, 1.499))
    soft = make_grid(fork(), np.array([4, 1, 2]))
    flat = state(soft, 1.2)
    flat.area[8] = 0.01 * soft.area0[8]
    assert failures.at_the_edge(soft, flat).startswith("vessel 'c' is near collapse (-51.3 mmHg); check the inflow")


def test_members_that_failed_are_empty_rows_and_all_of_them_are_an_error(monkeypatch):
    use_python(monkeypatch)
    one = vw.simulate(fork(), FLOW, Numerics(samples=16, cell_size=0.4, steps_per_cycle=256, tolerance=0.1))
    both = stack([NumericalError("lost"), one])
    assert both.failure.values.tolist() == ["lost", ""]
    assert np.isnan(both.pressure.values[0]).all()
    assert both.pressure.values[1] == pytest.approx(one.pressure.values)
    assert np.isnan(both.courant.values[0])
    assert both.courant.values[1] == one.attrs["courant"]
    assert both.attrs == {"period": PERIOD}
    words = said(NumericalError, stack, [NumericalError("x"), NumericalError("y")])
    assert words == "all 2 members failed; the first: x"
