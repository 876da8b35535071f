"""Pressure behind the vascular beds: it drives the flow less, and stretches the walls all the same."""

from dataclasses import replace

import numpy as np
import pytest

import vasowave as vw
from small_tree import SMALL
from vasowave.base import InputError
from vasowave.pulse.calibration import Search, calibrate
from vasowave.pulse.cycle import Inflow, Recording
from vasowave.pulse.inference import Sampling, posterior_of, problem_of
from vasowave.pulse.model import ImpedanceSpectrum, Model, Numerics, Resistance, linear_solution

BEHIND, BETA = 8.0, 60.0
FINE = Numerics(tolerance=1e-10, steps_per_cycle=4608)


def beds_of(network, kind, period):
    windkessels = vw.estimate_nominal(network, vw.virtual_mouse()).outlets
    if kind == "windkessel":
        return windkessels
    return (
        ImpedanceSpectrum(windkessels.impedance_at(400, period))
        if kind == "spectrum"
        else Resistance(windkessels.R1 + windkessels.R2)
    )


@pytest.mark.parametrize("kind", ["windkessel", "resistance", "spectrum"])
def test_a_linear_wall_before_a_pressure_is_a_stiffer_and_wider_one_before_none(inflow, kind):
    """With p = β(√(A/A0) - 1), p - P is the same law with β + P in place of β and A0 (1 + P/β)² in place of A0."""
    network = vw.control_network()
    wider = replace(network, radius=network.radius * (1 + BEHIND / BETA))
    beds = beds_of(network, kind, inflow.period)
    model = Model(network, vw.LinearWall(BETA), beds, outlet_pressure=BEHIND)
    plain = Model(wider, vw.LinearWall(BETA + BEHIND), beds)
    linear, other = linear_solution(model, inflow), linear_solution(plain, inflow)
    np.testing.assert_allclose(linear.mean_pressure, other.mean_pressure + BEHIND, rtol=1e-12)
    np.testing.assert_allclose(linear.flow, other.flow, rtol=1e-9, atol=1e-15)
    found, expected = vw.simulate(model, inflow, FINE), vw.simulate(plain, inflow, FINE)
    np.testing.assert_allclose(found["pressure"], expected["pressure"] + BEHIND, atol=2e-8)
    np.testing.assert_allclose(found["flow"], expected["flow"], atol=1e-9)
    np.testing.assert_allclose(found["area"], expected["area"], rtol=1e-8)


def test_what_drives_the_mean_flow_through_a_bed_is_the_pressure_above_that_behind_it(inflow):
    network = vw.control_network()
    beds = vw.estimate_nominal(network, vw.virtual_mouse()).outlets
    behind = np.linspace(-3.0, 12.0, len(network.terminals))
    model = Model(network, vw.TangentWall(7.0, 4.0), beds, outlet_pressure=behind)
    waves = vw.simulate(model, inflow, FINE).isel(vessel=network.terminals).sel(station="outlet").mean("time")
    np.testing.assert_allclose(waves["pressure"] - behind, (beds.R1 + beds.R2) * waves["flow"], rtol=1e-6)
    assert float(waves["flow"].sum()) == pytest.approx(inflow.flow.mean(), rel=1e-6)
    linear = linear_solution(model, inflow)
    _, flow = linear.at(network.terminals, network.length[network.terminals])
    np.testing.assert_allclose(flow[0].real, waves["flow"], rtol=0.02)
    assert float(flow[0].real.sum()) == pytest.approx(inflow.flow.mean(), rel=1e-12)


@pytest.fixture(scope="module")
def before_the_atrium():
    """Return a recording of a mouse with a linear wall whose left atrium has 8 mmHg, and its model."""
    mouse = vw.virtual_mouse()
    beds = vw.estimate_nominal(SMALL, replace(mouse, wedge_pressure=0.0)).outlets
    model = Model(SMALL, vw.LinearWall(BETA), beds, outlet_pressure=BEHIND)
    waves = vw.simulate(model, Inflow(mouse.flow, mouse.period)).sel(vessel="1", station="inlet")
    return Recording(waves["pressure"].values, mouse.flow, mouse.period, wedge_pressure=BEHIND), model


def test_a_fit_that_is_told_of_the_pressure_finds_the_wall_and_the_resistance_and_one_that_is_not_does_not(
    before_the_atrium,
):
    recording, model = before_the_atrium
    search = Search(starts=1)
    told = calibrate(model.network, recording, "linear", search=search)
    assert told.parameters["value"]["beta"] == pytest.approx(BETA, rel=2e-3)
    assert told.total_resistance == pytest.approx(model.outlets.total_resistance(), rel=2e-3)
    untold = calibrate(model.network, replace(recording, wedge_pressure=0.0), "linear", search=search)
    assert untold.total_resistance > 1.3 * told.total_resistance


def widths_by_integration(problem, point):
    """Return the squared width (95 %) of ln R_T by an integral over the prior of the discrepancy that is written here.

    The mean and the waves are linear in the parameters around the truth; σ, r and s of the discrepancy are log-normal.
    """
    step = 1e-3 * np.eye(len(point))
    outputs = problem.simulate(point + np.vstack([step, -step, 0 * step[:1]]))
    jacobian = (outputs[: len(point)] - outputs[len(point) : -1]).T / 2e-3
    resistance = [np.log(problem.unknowns.model(point + one).outlets.total_resistance()) for one in (*step, *-step)]
    slope = (np.array(resistance[: len(point)]) - resistance[len(point) :]) / 2e-3
    measured = problem.measured - outputs[-1] + jacobian @ point
    k = np.r_[: problem.samples // 2 + 1, 1 : problem.samples // 2 + 1]
    scores = np.linspace(-4, 4, 17)
    found = []
    for size, r, s in np.array(np.meshgrid(np.linspace(-5, 5, 41), scores, scores)).reshape(3, -1).T:
        rate, power = 0.5 * np.exp(0.5 * r), 6 * np.exp(0.5 * s)
        shape = (1 + rate * k / power) ** -power
        variance = (0.03 * problem.recording.pulse_pressure * np.exp(0.7 * size)) ** 2 * shape / shape.mean()
        variance[0] = min(variance[0], problem.samples * (0.5 * problem.mean_drop) ** 2)
        variance += problem.measurement_error
        precision = np.eye(len(point)) + (jacobian.T / variance) @ jacobian
        mean = np.linalg.solve(precision, (jacobian.T / variance) @ measured)
        square = measured @ (measured / variance) - mean @ precision @ mean + size**2 + r**2 + s**2
        log = -0.5 * (np.log(variance).sum() + np.linalg.slogdet(precision)[1] + square)
        found.append((log, slope @ mean, slope @ np.linalg.solve(precision, slope)))
    log, mean, variance = np.array(found).T
    weight = np.exp(log - log.max()) / np.exp(log - log.max()).sum()
    return (2 * 1.96) ** 2 * (weight @ (variance + mean**2) - (weight @ mean) ** 2)


@pytest.mark.weekly
@pytest.mark.parametrize(("noise", "hidden"), [(0.3, True), (0.0, False)])
def test_an_uncertain_pressure_behind_the_beds_widens_what_depends_on_it(before_the_atrium, noise, hidden):
    """By all of its error where noise hides how pressure decays to it; a recording without noise tells some of it."""
    recording, model = before_the_atrium
    time, rng = np.arange(len(recording.pressure)) / len(recording.pressure), np.random.default_rng(4)
    waves = [np.exp(-0.25 * n) * np.cos(2 * np.pi * (n * time - rng.random())) for n in range(1, 17)]
    recording = replace(recording, pressure=recording.pressure + noise * np.sum(waves, axis=0))
    widths, expected = {}, {}
    for sd in (0.0, 2.0):
        exact = dict.fromkeys(("radius_scale_sd", "length_scale_sd", "k_sd", "flow_gain_sd", "taper_sd"), 0.0)
        priors = vw.Priors(wedge=sd, radius=0.0, length=0.0, **exact)
        how = Sampling(priors=priors, search=Search(pressure_harmonics=16), draws=400)
        found = posterior_of(problem := problem_of(model.network, recording, "linear", how), how)
        true = model.outlets.R1[0], model.outlets.R2[0], model.outlets.C[0]
        now = problem.unknowns.space.outlets
        factors = {n: t / m[0] for n, t, m in zip(("r1", "r2", "c1"), true, (now.R1, now.R2, now.C), strict=True)}
        expected[sd] = widths_by_integration(problem, problem.unknowns.scores({"beta": BETA, **factors}))
        low, high = found.summary.loc["R_T", ["interval_low", "interval_high"]]
        assert low < model.outlets.total_resistance() < high
        widths[sd] = (2 * 1.96) ** 2 * np.var(np.log(found.draws("R_T")))
        assert widths[sd] == pytest.approx(expected[sd], rel=0.3)  # variance of 400 weighted draws: 0.1 at most
    own = (2.0 * 1.96 * 2.0 / (recording.mean_pressure - BEHIND)) ** 2
    share = (expected[2.0] - expected[0.0]) / own
    assert share > 0.9 if hidden else share < 0.7


def test_vascular_resistance_counts_from_the_wedge_pressure_and_the_total_one_from_zero():
    mouse = replace(vw.virtual_mouse(), wedge_pressure=5.0)
    assert mouse.indices()["PVR"] == pytest.approx((mouse.mean_pressure - 5.0) / mouse.cardiac_output)
    assert mouse.input_resistance == pytest.approx(mouse.mean_pressure / mouse.cardiac_output)
    with pytest.raises(InputError, match="wedge pressure of 90 mmHg is not below the mean pressure"):
        replace(mouse, wedge_pressure=90.0)
