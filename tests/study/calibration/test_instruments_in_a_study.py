"""Filters and catheters: told by what a fit leaves, undone where they are known, not told where there is none."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import vasowave as vw
from vasowave import pulse
from vasowave.catheter.check import LowPass, correct_catheter
from vasowave.study.animal import Animal, Settings, analyze
from vasowave.study.figures import new_figure, plot_pressure

NETWORK = vw.Network(("1", "2", "3"), [-1, 0, 0], [0.5, 0.8, 0.6], [0.05, 0.035, 0.03])
BETA = 57.0


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


@pytest.mark.parametrize("cutoff", [50.0, 100.0])
def test_a_filter_of_the_pressure_makes_arteries_soft_is_told_and_undone_where_it_is_known(cutoff):
    seen = replace(animal(), pressure=charged(animal().pressure, animal().period, cutoff))
    soft, findings = of_filters(seen)
    assert soft < 0.95 * BETA
    (values,) = (dict(one.values) for one in findings)
    assert values["signal"] == "pressure"
    assert values["cutoff"] == pytest.approx(cutoff, rel=0.25)
    assert values["value"] == pytest.approx(BETA, rel=0.1)  # of β with a filter
    corrected = correct_catheter(seen, LowPass(cutoff))
    beta, findings = of_filters(corrected)
    assert beta == pytest.approx(BETA, rel=0.03)
    assert not findings


def test_a_figure_shows_the_fitted_pressure_as_the_filter_let_it_through():
    """At 20 Hz the true pulse is 1.1 times the recorded one; the drawn curve misses the data by the residual alone."""
    seen = replace(animal(), pressure=charged(animal().pressure, animal().period, 20.0))
    settings = Settings(walls=("linear",), starts=1, model_selection=False, pressure_lag_sd=0.003)
    result = analyze(Animal("1", "CTL", NETWORK, seen), settings)
    measured, fitted = plot_pressure(new_figure(8, 8).subplots(), result).get_lines()
    apart = np.std(measured.get_ydata() - fitted.get_ydata())
    assert apart == pytest.approx(float(result.laws["linear"].residual.std()), rel=0.3)
    assert np.ptp(result.laws["linear"].simulated("pressure", "1").to_numpy()) > 1.05 * np.ptp(fitted.get_ydata())
