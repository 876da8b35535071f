"""The stated error of vessels whose shape has points, against far shorter cells; networks without such keep theirs."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.pulse.cycle import Inflow
from vasowave.pulse.model import LinearWall, Model, Numerics, Shape, windkessels
from vasowave.pulse.network import Network
from vasowave.pulse.solver import difference, run_on_cells, run_to_periodic

FORK = Network(("a", "b", "c"), [-1, 0, 0], [0.41, 0.445, 0.372], [0.047, 0.026, 0.037])


@pytest.fixture(scope="module")
def inflow():
    """Return an ejection of 0.1 ml/s, 0.4 at most."""
    t = np.arange(256) / 256
    q = np.exp(-0.5 * ((t - 0.3) / 0.1) ** 2)
    return Inflow(0.1 * q / q.mean(), 0.11)


def fork(points=None, stiffness=1.0, **parts):
    shape = None if points is None else Shape([points] * 3, stiffness)
    return Model(FORK, LinearWall(57.0), windkessels(FORK, 76.0, 0.12), shape=shape, **parts)


def true_error(run, model, inflow):
    """Largest error of the pressures at any station, mmHg, against a run on a fifth of the cell length."""
    fine = run_on_cells(model, inflow, Numerics(tolerance=1e-5), 5 * run.grid.counts)
    return float(np.max(np.abs(run.pressure - fine.pressure)))


@pytest.mark.parametrize(
    ("points", "parts"),
    [
        ((1.0, 0.8, 1.0, 0.8, 1.0), {}),
        ((0.7, 1.3), {"junctions": "total"}),
        ((1.0, 1.25, 0.7), {"loss": 0.5}),
        ((1.0, 1.4, 0.6), {"stiffness": [[1.0, 2.0]] * 3}),
    ],
    ids=str,
)
def test_the_stated_error_of_a_shape_with_points_is_that_which_shorter_cells_show(points, parts, inflow):
    model = fork(points, **parts)
    run = run_to_periodic(model, inflow, Numerics())
    true, stated = true_error(run, model, inflow), run.extremes.grid_error.value
    assert true < 3 * stated < 0.01 * run.largest_pressure
    assert true < 0.004 * run.largest_pressure


def test_cells_whose_faces_miss_the_points_of_a_shape_are_far_worse_and_another_grid_shows_it(inflow):
    """Waves alone show a hundredth of it; so many cells serve the straight vessels."""
    model, counts = fork((1.0, 0.75, 1.25, 0.75, 1.0)), np.array([5, 5, 4])
    run, other = (run_on_cells(model, inflow, Numerics(), factor * counts) for factor in (1, 2))
    true = true_error(run, model, inflow)
    assert true > 0.01 * run.largest_pressure
    assert run.extremes.grid_error.value < 0.1 * true
    assert run.notes == ()
    seen = replace(run, two_grids=difference(run, other))
    assert 0.3 * true < seen.extremes.grid_error.value < 3 * true
    assert [note.code for note in seen.notes] == ["solver.depends-on-grid"]
    assert true_error(run_to_periodic(model, inflow, Numerics()), model, inflow) < 0.2 * true


def test_a_run_beside_another_states_the_error_of_its_cells(inflow):
    model = fork((1.0, 0.8, 1.0, 0.8, 1.0))
    run = run_to_periodic(model, inflow, Numerics())
    beside = run_to_periodic(model.changed(wall=LinearWall(58.0)), inflow, Numerics(), neighbor=run)
    assert beside.extremes.grid_error.value >= run.two_grids.value > 0
