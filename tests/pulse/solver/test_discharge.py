"""The beds' common discharge, by which periodic states are found in three cycles, against the cycles themselves."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.pulse.model import Numerics, walls
from vasowave.pulse.solver import run_cycles, run_to_periodic


@pytest.mark.parametrize(
    "wall", [walls.TangentWall(7.0, 4.0), walls.TangentWall(12.0, 2.0), walls.PowerWall(20.0, 3.0)]
)
def test_what_the_first_cycle_brought_tells_where_a_wall_that_stiffens_ends(control, inflow, wall):
    """Vessels are softer where a cycle begins than in most of it: that their pressure is more volume there, counts."""
    run = run_to_periodic(control.changed(wall=wall), inflow, Numerics(tolerance=1e-6))
    first, second, third = run.convergence.changes[:3]
    assert second < 0.02 * first
    assert third < 0.001 * first


def test_an_ordinary_simulation_takes_three_cycles_and_ends_where_plain_repetition_does(control, inflow):
    run = run_to_periodic(control, inflow, Numerics())
    assert len(run.convergence.changes) == 3
    plain = run_cycles(control, inflow, Numerics(steps_per_cycle=run.steps, samples=run.steps // 2), 25)
    found = replace(run, samples=run.steps // 2)
    np.testing.assert_allclose(found.pressure, plain.pressure, atol=3e-4)  # the tolerance of a cycle, over 1 - 0.43


def test_beds_that_discharge_apart_and_beds_without_a_discharge_become_periodic_too(control, inflow):
    beds = control.outlets
    apart = control.changed(outlets=beds._replace(C=beds.C * np.linspace(0.3, 3.0, len(beds.C))))
    run = run_to_periodic(apart, inflow, Numerics(samples=64, tolerance=1e-6))
    plain = run_cycles(apart, inflow, Numerics(samples=64, steps_per_cycle=run.steps), 60)
    np.testing.assert_allclose(run.pressure, plain.pressure, atol=1e-4)


def test_samples_between_two_steps_are_those_of_a_grid_of_times_that_holds_them(control, inflow):
    """512 samples of 768 or 1280 steps, half or three quarters of them on no step, against samples on steps."""
    run = run_to_periodic(control, inflow, Numerics(tolerance=1e-8))
    assert run.steps % 512
    on_steps = run_to_periodic(control, inflow, Numerics(samples=256, steps_per_cycle=run.steps, tolerance=1e-8))
    np.testing.assert_allclose(run.stations[:, ::2], on_steps.stations, rtol=0, atol=1e-6 * np.max(run.stations))
    assert run.pressure.shape[0] == 512
