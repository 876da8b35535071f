"""A pressure behind the beds that changes over the cycle: against the linear model, as a cause alone, and in fits."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vasowave as vw
from small_tree import SMALL
from vasowave import pulse
from vasowave.base import InputError
from vasowave.pulse.model import Numerics, linear_solution

NETWORK, MOUSE = vw.control_network(), vw.virtual_mouse()
BEDS = vw.estimate_nominal(NETWORK, MOUSE).outlets
FEW_BEDS = vw.estimate_nominal(SMALL, MOUSE).outlets
T = np.arange(64) / 64
WAVE = 2.0 * np.sin(2 * np.pi * T + 0.3) + 0.7 * np.cos(6 * np.pi * T)  # mmHg
TINY = 1e-4
FINE = Numerics(samples=64, tolerance=1e-12, cell_size=0.05)


@pytest.mark.parametrize("viscosity", [0.0, pytest.param(0.02, marks=pytest.mark.weekly)])
def test_a_small_wave_behind_the_beds_runs_up_the_tree_as_the_linear_model_says(viscosity):
    still = vw.Inflow(np.full(64, 1e-3), MOUSE.period)
    steady = vw.Model(SMALL, vw.LinearWall(60.0), FEW_BEDS, outlet_pressure=8.0, wall_viscosity=viscosity)
    beating = steady.changed(outlet_pulsation=TINY * WAVE)
    waves = [vw.simulate(one, still, FINE) for one in (beating, steady)]
    linear = [linear_solution(one, still, 31) for one in (beating, steady)]
    for name in ("pressure", "flow"):
        one, other = (each[name].sel(station="inlet").transpose("time", "vessel").values for each in waves)
        found = (one - other) / TINY
        expected = linear[0].over_cycle(getattr(linear[0], name) - getattr(linear[1], name), 64) / TINY
        assert np.max(np.abs(found - expected)) < 2e-3 * np.max(np.abs(expected)), name
    assert np.max(np.abs(expected)) > 0


def test_a_wave_behind_all_beds_that_is_slow_lifts_the_whole_network():
    """Nothing flows in, and the vessels are filled and emptied slowly: the pressure is that behind the beds."""
    slow = vw.Inflow(np.full(64, 0.0), 100.0)
    model = vw.Model(vw.Network(("1",), [-1], [0.4], [0.05]), vw.LinearWall(60.0), BEDS_OF_ONE, outlet_pressure=8.0,
                     outlet_pulsation=WAVE)  # fmt: skip
    pressure = vw.simulate(model, slow, Numerics(samples=64)).pressure.sel(vessel="1", station="inlet").values
    assert np.max(np.abs(pressure - 8.0 - WAVE)) < 0.05


def test_a_windkessel_before_a_beating_atrium_is_its_ordinary_differential_equation():
    """The capacitor stands against the pressure around the lung, so that it smooths what comes from behind."""
    R1, R2, C = (float(np.asarray(one)[0]) for one in (BEDS_OF_ONE.R1, BEDS_OF_ONE.R2, BEDS_OF_ONE.C))
    period, flow = MOUSE.period, np.maximum(np.sin(2 * np.pi * np.arange(256) / 256), 0) * 0.5
    time = np.arange(256) / 256 * period

    def over(values, t):
        return np.interp(t % period, np.append(time, period), np.append(values, values[0]))

    behind = 8.0 + np.interp(np.arange(256) / 256, np.append(T, 1), np.append(WAVE, WAVE[0]))
    solved = solve_ivp(lambda t, p: (over(flow, t) - (p - over(behind, t)) / R2) / C, (0, 12 * period), [15.0],
                       t_eval=11 * period + time, rtol=1e-8, max_step=period / 200)  # fmt: skip
    expected = solved.y[0] + R1 * flow
    stub = vw.Network(("1",), [-1], [0.02], [0.05])  # no water in it, and a wall that does not give
    model = vw.Model(stub, vw.LinearWall(5e4), BEDS_OF_ONE, outlet_pressure=8.0, outlet_pulsation=behind)
    waves = vw.simulate(model, vw.Inflow(flow, period), Numerics(samples=256)).sel(vessel="1", station="outlet")
    assert np.max(np.abs(waves.pressure.values - expected)) < 0.1
    steady = vw.simulate(model.changed(outlet_pulsation=None), vw.Inflow(flow, period), Numerics(samples=256))
    moved = waves.pressure.values - steady.sel(vessel="1", station="outlet").pressure.values
    assert np.ptp(moved) < 0.4 * np.ptp(behind)


def test_beds_that_are_no_circuits_refuse_what_they_may_let_through():
    beds = vw.estimate_nominal(NETWORK, MOUSE, bed=vw.StructuredTree).outlets
    with pytest.raises(InputError, match="what StructuredTree lets through of it is not known"):
        vw.Model(NETWORK, vw.LinearWall(60.0), beds, outlet_pulsation=WAVE)


BEDS_OF_ONE = vw.Windkessel(np.array([5.0]), np.array([70.0]), np.array([1e-3]))


@pytest.mark.weekly
def test_a_fit_that_is_told_of_the_wave_finds_the_truth_and_one_that_is_not_errs():
    model = vw.Model(SMALL, vw.LinearWall(70.0), FEW_BEDS, outlet_pressure=8.0, outlet_pulsation=3 * WAVE)
    waves = vw.simulate(model, MOUSE.inflow, Numerics(samples=256)).sel(vessel="1", station="inlet")
    recording = vw.Recording(waves.pressure.values, waves.flow.values, MOUSE.period)
    untold = replace(recording, wedge_pressure=8.0)
    told = replace(untold, wedge_pulsation=3 * WAVE)
    fits = [pulse.calibrate(SMALL, one, starts=1) for one in (told, untold)]
    errors = [abs(np.log(fit.parameters["value"]["beta"] / 70.0)) for fit in fits]
    assert errors[0] < 1e-3
    assert errors[1] > 20 * errors[0]
    assert fits[0].rmse < 1e-3
    assert fits[1].rmse > 50 * fits[0].rmse


def test_a_wave_of_another_shape_is_refused_with_the_shapes_that_may_be():
    with pytest.raises(InputError, match=r"outlet_pulsation: give finite samples .* each of the 11 terminal vessels"):
        vw.Model(NETWORK, vw.LinearWall(60.0), BEDS, outlet_pulsation=np.zeros((64, 3)))
    with pytest.raises(InputError, match="wedge_pulsation"):
        replace(MOUSE, wedge_pulsation=np.full(64, np.nan))
