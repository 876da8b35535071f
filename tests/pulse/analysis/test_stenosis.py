"""Coefficients of a stenosis from the pressures at its two sides, as the nonlinear solver gives them."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.model import Poiseuille

SAMPLES, PERIOD = 256, 0.11
TRUTHS = [
    (vw.Stenosis(), 0.8, 0.05),
    (vw.Stenosis(turbulent=1.0), 0.7, 0.1),
    (vw.Stenosis(turbulent=2.2, length=1.5, diameter=3.0), 0.75, 0.04),
    (vw.Stenosis(turbulent=0.6, length=0.5, diameter=1.0, inertial=1.2), 0.6, 0.2),
]


def two_sides(coefficients, area_lost, length):
    """Return pressures before and beyond a narrowing of one vessel, and the flow through it, of a simulation."""
    network = vw.Network(("only",), [-1], [1.0], [0.05])
    whole = vw.Model(network, vw.LinearWall(20_000.0), vw.Resistance([100.0]), vw.Blood(friction=Poiseuille()))
    angle = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    inflow = Inflow(0.1 + 0.09 * np.sin(angle) + 0.03 * np.cos(2 * angle), PERIOD)
    model = vw.narrowed(whole, "only", area_lost, length, coefficients=coefficients)
    waves = vw.simulate(model, inflow, vw.Numerics(samples=SAMPLES)).sel(vessel=["only", "only beyond"])
    before, beyond = (waves.isel(vessel=row).sel(station=station) for row, station in enumerate(("outlet", "inlet")))
    return [before.pressure.to_numpy(), beyond.pressure.to_numpy(), before.flow.to_numpy()]


def fitted(signals, area_lost, length):
    before, beyond, flow = signals
    return vw.fit_stenosis(vw.Recording(before, flow, PERIOD), beyond, radius=0.05, area_lost=area_lost, length=length)


def numbers(found):
    return np.array([found.coefficients.turbulent, found.viscous_ratio, found.coefficients.inertial or np.nan])


@pytest.mark.parametrize(("truth", "area_lost", "length"), TRUTHS)
def test_the_pressures_at_two_sites_give_back_the_coefficients_that_made_them(truth, area_lost, length):
    found = fitted(two_sides(truth, area_lost, length), area_lost, length)
    assert found.coefficients.turbulent == pytest.approx(truth.turbulent, abs=0.03)
    assert found.viscous_ratio == pytest.approx(truth.diameter / 1.64, rel=0.02)
    assert found.coefficients.inertial == pytest.approx(truth.inertial or 1 / (1 - area_lost), rel=0.02)
    assert found.misfit < 0.002


@pytest.mark.parametrize(("truth", "area_lost", "length"), TRUTHS)
def test_under_noise_the_standard_errors_hold_what_is_found_without(truth, area_lost, length):
    signals = two_sides(truth, area_lost, length)
    clean, rng, away = numbers(fitted(signals, area_lost, length)), np.random.default_rng(3), []
    for _ in range(200):
        noisy = [one + 0.3 * rng.standard_normal(SAMPLES) for one in signals[:2]]
        found = fitted([*noisy, signals[2]], area_lost, length)
        if found.coefficients.inertial is not None:
            away.append((numbers(found) - clean) / [found.turbulent_sd, found.viscous_ratio_sd, found.inertial_sd])
    assert len(away) > 150
    share = np.mean(np.abs(away) < 2, axis=0)
    assert np.all((share > 0.88) & (share < 0.99))


def test_signals_that_cannot_be_a_stenosis_are_refused():
    truth, area_lost, length = TRUTHS[0]
    before, beyond, flow = two_sides(truth, area_lost, length)
    with pytest.raises(InputError, match="comes later than the flow"):
        fitted([np.roll(before, 12), np.roll(beyond, 12), flow], area_lost, length)
    with pytest.raises(InputError, match="does not tell"):
        fitted([before, beyond, np.full(SAMPLES, 0.1)], area_lost, length)
    with pytest.raises(InputError, match="cannot carry 14 harmonics"):
        fitted([before, beyond[:20], flow], area_lost, length)
    with pytest.raises(InputError, match="length = 0 cm of a stenosis"):
        fitted([before, beyond, flow], area_lost, 0.0)
    with pytest.raises(InputError, match="closes 1 of the area"):
        fitted([before, beyond, flow], 1.0, length)
