"""Filters and catheters: told by what a fit leaves, undone where they are known, not told where there is none."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import vasowave as vw
from vasowave import pulse

NETWORK = vw.Network(("1", "2", "3"), [-1, 0, 0], [0.5, 0.8, 0.6], [0.05, 0.035, 0.03])
BETA = 57.0


TANGENT = vw.TangentWall(12.0, 3.0)


@cache
def animal(wall=vw.LinearWall(BETA)):  # noqa: B008  a value, which nobody changes
    """A recording with noise of 0.1 mmHg whose upper harmonics fall, as those of averaged beats do."""
    mouse = vw.virtual_mouse(noise=0)
    model = vw.Model(NETWORK, wall, vw.Windkessel([20, 30], [130, 160], [8e-4, 7e-4]))
    waves = vw.simulate(model, mouse.inflow, vw.Numerics(samples=256))["pressure"].to_numpy()[:, 0, 0]
    rough = np.fft.rfft(np.random.default_rng(4).standard_normal(256)) * np.exp(-np.arange(129) / 8)
    noise = np.fft.irfft(rough, 256)
    flow = np.fft.irfft(np.fft.rfft(mouse.flow)[:129], 256) / (len(mouse.flow) / 256)
    return vw.Recording(waves + 0.1 * noise / noise.std(), flow, mouse.period)


def charged(values, period, cutoff):
    """Return what a resistor and a capacitor make of one period, by steps of Euler's implicit rule, after ten."""
    fine = np.repeat(np.asarray(values), 64)
    share, level, out = period / len(fine) * 2 * np.pi * cutoff, fine.mean(), np.empty(len(fine))
    for _ in range(10):
        for place, value in enumerate(fine):
            level = out[place] = (level + share * value) / (1 + share)
    return out[32::64]


def of_filters(recording, law="linear"):
    fit = pulse.calibrate(NETWORK, recording, law, starts=1)
    return fit.parameters["value"].iloc[0], [one for one in fit.findings if one.code == "fit.low-pass"]


def test_a_recording_without_a_filter_tells_none():
    beta, findings = of_filters(animal())
    assert beta == pytest.approx(BETA, rel=0.03)
    assert not findings


@pytest.mark.parametrize("cutoff", [20.0, 50.0, 100.0])
def test_a_filter_is_told_beside_a_wall_that_stiffens_and_imitates_it(cutoff):
    clean, findings = of_filters(animal(TANGENT), "tangent")
    assert not findings
    seen = replace(animal(TANGENT), pressure=charged(animal(TANGENT).pressure, animal().period, cutoff))
    soft, findings = of_filters(seen, "tangent")
    assert soft < 0.5 * clean
    (values,) = (dict(one.values) for one in findings)
    assert values["signal"] == "pressure"
    assert values["cutoff"] == pytest.approx(cutoff, rel=0.25)
    assert values["value"] == pytest.approx(clean, rel=0.25)  # of p1 with a filter


@pytest.mark.parametrize("cutoff", [20.0, 50.0])
def test_an_unknown_filter_is_found_beside_a_wall_that_stiffens(cutoff):
    seen = replace(animal(TANGENT), pressure=charged(animal(TANGENT).pressure, animal().period, cutoff))
    fit = pulse.calibrate(NETWORK, seen, "tangent", starts=1, pressure_lag_sd=0.003)
    p1, found = fit.parameters.loc["p1"], fit.response["pressure_lag"]
    assert p1["interval_low"] < 12.0 < p1["interval_high"]
    assert abs(found.value - 1 / (2 * np.pi * cutoff)) < 2.5 * found.error


def test_a_filter_of_the_flow_and_a_late_pressure_are_told_as_what_they_are():
    filtered = replace(animal(), flow=charged(animal().flow, animal().period, 50.0))
    late = replace(animal(), pressure=np.roll(animal().pressure, round(0.004 / animal().period * 256)))
    told = [dict(finding.values) for seen in (filtered, late) for finding in of_filters(seen)[1]]
    assert [one["signal"] for one in told] == ["flow", "pressure"]
    assert told[0]["cutoff"] == pytest.approx(50.0, rel=0.35)
    assert told[1]["delay"] == pytest.approx(4.0, rel=0.35)


@pytest.mark.parametrize("cutoff", [0.0, 50.0, 20.0])
def test_an_unknown_filter_with_a_prior_is_fitted_beside_the_parameters_and_told(cutoff):
    seen = animal()
    if cutoff:
        seen = replace(seen, pressure=charged(seen.pressure, seen.period, cutoff))
    fit = pulse.calibrate(NETWORK, seen, "linear", starts=1, pressure_lag_sd=0.003)
    beta, lag = fit.parameters.loc["beta"], 1 / (2 * np.pi * cutoff) if cutoff else 0.0
    assert beta["value"] == pytest.approx(BETA, rel=0.03)
    assert beta["interval_low"] < BETA < beta["interval_high"]
    found = fit.response["pressure_lag"]
    assert abs(found.value - lag) < 2 * found.error < 0.003
    assert found.prior == 0.003
    (told,) = (dict(one.values) for one in fit.findings if one.code == "fit.lag")
    assert told["lag"] == pytest.approx(1e3 * found.value)
    assert f"lag of the pressure {1e3 * found.value:.2g} ±" in repr(fit)


def test_a_lag_that_is_hardly_possible_is_hardly_fitted_and_one_of_a_pressure_that_enters_is_not():
    seen = replace(animal(), pressure=charged(animal().pressure, animal().period, 50.0))
    fit = pulse.calibrate(NETWORK, seen, "linear", starts=1, pressure_lag_sd=1e-5)
    assert abs(fit.response["pressure_lag"].value) < 5e-5
    assert fit.response["pressure_lag"].error == pytest.approx(1e-5, rel=0.05)
    assert not pulse.calibrate(NETWORK, seen, "linear", starts=1, pressure_lag_sd=0.003, enters="pressure").response


def swung(recording, frequency, damping):
    """Return the recording with what a mass on a damped spring makes of its pressure, by small steps, after ten."""
    fine = np.repeat(recording.pressure, 64)
    step, rate, level, speed = recording.period / len(fine), 2 * np.pi * frequency, fine.mean(), 0.0
    out = np.empty(len(fine))
    for _ in range(10):
        for place, value in enumerate(fine):
            speed += step * rate * (rate * (value - level) - 2 * damping * speed)
            level = out[place] = level + step * speed
    rounding = 0.02 * np.random.default_rng(7).standard_normal(256)
    return replace(recording, pressure=out[32::64] + rounding)


@pytest.mark.parametrize(("frequency", "damping"), [(60.0, 0.15), (60.0, 0.8), (1e3, 0.5)])
def test_an_unknown_catheter_with_a_prior_is_fitted_beside_the_parameters_and_told(frequency, damping):
    seen = swung(animal(), frequency, damping)
    fit = pulse.calibrate(NETWORK, seen, "linear", starts=1, pressure_lag_sd=0.003, pressure_inertia_sd=7e-6)
    beta, time = fit.parameters.loc["beta"], 1 / (2 * np.pi * frequency)
    assert beta["value"] == pytest.approx(BETA, rel=0.05)
    assert beta["interval_low"] < BETA < beta["interval_high"]
    lag, inertia = fit.response["pressure_lag"], fit.response["pressure_inertia"]
    assert abs(lag.value - 2 * damping * time) < 2 * lag.error < 0.003
    assert abs(inertia.value - time**2) < 2 * inertia.error < 7e-6
    (told,) = (dict(one.values) for one in fit.findings if one.code == "fit.inertia")
    assert told["inertia"] == pytest.approx(1e6 * inertia.value)
    assert f"inertia of the catheter {1e6 * inertia.value:.2g} ±" in repr(fit)
