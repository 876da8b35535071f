"""The beds' common discharge, by which periodic states are found in three cycles, against the cycles themselves."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from vasowave.pulse.model import Numerics, Rational, walls
from vasowave.pulse.solver import bed_relaxation, run_cycles, run_to_periodic

PERIOD = 0.11  # s


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


def beds_of(terminals, modes, swing=0.0):
    """Beds of different resistances and time constants; with a `swing` every other mode oscillates, up to so fast."""
    random = np.random.default_rng(terminals)
    resistance = 10 ** random.uniform(2, 3, terminals)
    poles = -random.uniform(1, 80, (terminals, modes)).astype(complex)
    share = random.uniform(0.1, 1.0, (terminals, modes))
    residues = -poles.real * resistance[:, np.newaxis] * share / share.sum(axis=1, keepdims=True) + 0j
    if swing:
        poles[:, ::2] += 1j * random.uniform(0.1 * swing, swing, poles[:, ::2].shape)
        residues[:, ::2] *= np.exp(1j * random.uniform(-0.5, 0.5, poles[:, ::2].shape))
    residues[0, 1:] = 0.0  # a bed with one mode
    return Rational(0.1 * resistance, poles, residues)


def left_after_a_cycle(beds, compliance):
    """The matrix exponential of C dp/dt = -Σ q, dx/dt = pole x + residue q, q = (p - Re Σ x)/direct."""
    terminals, modes = beds.poles.shape
    first = 1 + 2 * np.arange(terminals * modes).reshape(terminals, modes)
    flow = np.zeros((terminals, 1 + 2 * terminals * modes))
    flow[:, 0] = 1.0
    np.put_along_axis(flow, first, -1.0, axis=1)
    flow /= beds.direct[:, np.newaxis]
    A = np.zeros((flow.shape[1], flow.shape[1]))
    A[0] = -flow.sum(axis=0) / compliance
    for j, i in np.ndindex(terminals, modes):
        k, pole, residue = first[j, i], beds.poles[j, i], beds.residues[j, i]
        A[k], A[k + 1] = residue.real * flow[j], residue.imag * flow[j]
        A[k : k + 2, k : k + 2] += [[pole.real, -pole.imag], [pole.imag, pole.real]]
    return expm(A * PERIOD)


@pytest.mark.parametrize("swing", [0.0, 12.0, 600.0])  # 1/s: of the last, some modes turn ten times in a cycle
def test_what_a_cycle_leaves_of_beds_is_the_exponential_of_the_matrix_of_all_their_modes(swing):
    beds, compliance, softer = beds_of(7, 3, swing), 1e-3, 1.3
    exponential = left_after_a_cycle(beds, compliance)
    real = np.stack([beds.residues != 0, (beds.residues != 0) & (beds.poles.imag != 0)], axis=-1)
    exist = np.concatenate([[True], real.ravel()])  # neither modes without residue nor imaginary parts of real ones
    exponential[~exist] = exponential[:, ~exist] = 0.0
    left, unit = bed_relaxation(beds, compliance, PERIOD), np.eye(len(exponential))
    np.testing.assert_allclose(left.after(unit), exponential, rtol=0, atol=1e-12 * np.abs(exponential).max())

    share = np.clip(exponential[0, 0] / np.trace(exponential), 0.0, 1.0)  # of modes that turn it may be any number
    exponential[:, 0] *= softer
    exponential /= 1.0 + (softer - 1.0) * share
    to_come = np.linalg.inv(unit - exponential) - unit
    np.testing.assert_allclose(left.all_to_come(unit, softer), to_come, rtol=0, atol=1e-12 * np.abs(to_come).max())


def test_beds_before_a_pressure_that_is_held_relax_each_alone():
    beds = beds_of(5, 2)
    together = bed_relaxation(beds, np.inf, PERIOD).all_to_come(np.ones(21))
    assert together[0] == 0
    for j in range(5):
        bed = Rational(*(values[j : j + 1] for values in beds))
        alone = bed_relaxation(bed, np.inf, PERIOD).all_to_come(np.ones(5))
        np.testing.assert_allclose(together[1 + 4 * j : 5 + 4 * j], alone[1:], rtol=0, atol=1e-14)


def test_ten_times_the_beds_take_ten_times_the_memory():
    def peak(terminals):
        beds = beds_of(terminals, 1)
        tracemalloc.start()
        bed_relaxation(beds, 1e-3, PERIOD).all_to_come(np.ones(1 + 2 * terminals))
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return peak

    peak(10)  # what the first call imports
    assert peak(2_500) < 12 * peak(250)
