import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.pulse.calibration import Search, calibrate
from vasowave.pulse.cycle import Inflow, Recording
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import (
    Blood,
    LinearWall,
    Model,
    TangentWall,
    characteristic_impedance,
    estimate_nominal,
    oddities,
    stiffness,
    time_constant,
    upstroke,
    walls,
    windkessels,
)
from vasowave.pulse.solver import simulate


def test_windkessels_share_resistance_and_time_constant_and_split_by_a():
    beds = windkessels(control_network(), 76.0, 0.11, a=0.12)
    R_Tj = beds.R1 + beds.R2
    assert len(R_Tj) == 11
    assert 1 / np.sum(1 / R_Tj) == pytest.approx(76.0, rel=1e-12)
    np.testing.assert_allclose(R_Tj * beds.C, 0.11, rtol=1e-12)
    np.testing.assert_allclose(beds.R1 / R_Tj, 0.12, rtol=1e-12)


def test_characteristic_impedance_of_a_straight_loop_is_its_slope(inflow):
    recording = Recording(12.0 + 31.0 * inflow.flow, inflow.flow, inflow.period)
    flow, pressure = upstroke(recording)
    assert flow.min() < 0.1 * inflow.flow.max()
    assert 0.95 * inflow.flow.max() <= flow.max() <= inflow.flow.max() * (1 + 1e-9)
    assert characteristic_impedance(flow, pressure) == pytest.approx(31.0, rel=1e-9)


@pytest.mark.parametrize("shift", [0, 37, 190])
def test_the_upstroke_runs_from_5_to_95_percent_of_the_peak_wherever_the_cycle_was_cut(shift):
    t = np.arange(256) / 256
    flow = np.roll(0.5 * np.clip(np.sin(2 * np.pi * t), 0, None) + 0.002, shift)
    found, _ = upstroke(Recording(np.roll(12 + 5 * np.sin(2 * np.pi * t), shift), flow, 0.11))
    peak = flow.max()
    assert found[0] <= 0.05 * peak < found[1]
    assert found[-2] < 0.95 * peak <= found[-1]
    assert (np.diff(found) > 0).all()


def test_the_time_constant_of_an_exponential_is_recovered():
    time = np.linspace(0.05, 0.1, 40)
    assert time_constant(time, 22.0 * np.exp(-time / 0.13)) == pytest.approx(0.13, rel=1e-10)


def test_a_diastolic_pressure_that_rises_is_an_error_naming_the_source():
    time = np.linspace(0.05, 0.1, 40)
    with pytest.raises(InputError, match="mouse 6"):
        time_constant(time, np.exp(time), "mouse 6")


def test_stiffness_from_characteristic_impedance_restores_the_wave_speed():
    blood, area0, c0 = Blood(), 0.0069, 190.0
    beta = stiffness(blood.inertia * c0 / area0, area0, blood)
    assert walls.wave_speed(LinearWall(beta), 0.0, blood.inertia) == pytest.approx(c0, rel=1e-12)
    assert walls.wave_speed(TangentWall(beta / np.pi, 2.0), 0.0, blood.inertia) == pytest.approx(c0, rel=1e-12)


def test_a_flow_that_never_stops_is_fitted_and_its_wall_and_resistance_are_found(inflow):
    network = control_network()
    steady = Inflow(inflow.flow + 0.8 * inflow.flow.mean(), inflow.period)
    truth = Model(network, LinearWall(60.0), windkessels(network, 45.0, 0.11, a=0.15))
    root = simulate(truth, steady).sel(vessel=network.name[network.root], station="inlet")
    recording = Recording(root["pressure"].values, steady.flow, steady.period)
    assert recording.flow.min() > 0.1 * recording.flow.max()
    nominal = estimate_nominal(network, recording)
    (note,) = oddities(nominal, recording.flow)
    assert note.code == "nominal.flow-never-stops"
    assert f"below {100 * recording.flow.min() / recording.flow.max():.0f} % of its peak" in str(note)
    fit = calibrate(network, recording, "linear", search=Search(starts=1))
    assert fit.parameters["value"]["beta"] == pytest.approx(60.0, rel=2e-3)
    assert fit.total_resistance == pytest.approx(45.0, rel=2e-3)
    assert "nominal.flow-never-stops" in {one.code for one in fit.findings}


def test_a_pressure_out_of_step_is_told_and_starts_from_the_higher_harmonics(inflow):
    pressure = 12.0 + 20.0 * np.roll(inflow.flow, 128)
    nominal = estimate_nominal(control_network(), Recording(pressure, inflow.flow, inflow.period))
    assert nominal.characteristic_impedance == pytest.approx(20.0, rel=1e-6)  # |P/Q| at every harmonic
    assert nominal.beta > 0
    assert "nominal.no-upstroke" in {one.code for one in oddities(nominal, inflow.flow)}


def test_a_pressure_that_falls_below_the_wedge_is_told_and_starts_from_the_volume_of_a_pulse(inflow):
    pressure = 12.0 + 20.0 * inflow.flow
    recording = Recording(pressure, inflow.flow, inflow.period, wedge_pressure=12.5)
    nominal = estimate_nominal(control_network(), recording)
    volume = np.maximum(inflow.flow - inflow.flow.mean(), 0).mean() * inflow.period
    tau = (pressure.mean() - 12.5) / inflow.flow.mean() * volume / np.ptp(pressure)
    assert nominal.time_constant == pytest.approx(tau, rel=1e-6)
    assert "nominal.no-decay" in {one.code for one in oddities(nominal, inflow.flow)}
