"""Elastances of ventricle and artery from one beat, against ventricles whose elastance is known."""

from functools import cache

import numpy as np
import pytest

import vasowave as vw
from approval import approve, parts
from vasowave.base import InputError
from vasowave.pulse.analysis import coupling
from vasowave.pulse.cycle import Recording, VentricularPressure
from vasowave.pulse.model import windkessels

PERIOD = 0.11


def relaxing(share):
    """An elastance of another shape than the one that is assumed: a saturating rise, then a Gaussian relaxation."""
    rising = (1 - np.exp(-2.2 * share**1.5)) / (1 - np.exp(-2.2))
    return np.where(share < 1, rising, np.exp(-(((share - 1) / 0.28) ** 2)))


@cache
def beat(shape="published", R_T=90.0, scale=1.0):
    """Recording and ventricle of a simulated heart, and its elastances; `scale` of all times and volumes."""
    network = vw.control_network()
    model = vw.Model(network, vw.LinearWall(60.0), windkessels(network, R_T, 0.12, 0.2))
    heart = vw.Ventricle.from_peak(1500.0, 110.0, PERIOD, 4.0)
    if shape != "published":
        share = np.arange(1024) / 1024 / 0.36
        heart = vw.Ventricle(110.0 + 1390.0 * relaxing(share), PERIOD, 4.0)
    waves = vw.simulate(model, heart, vw.Numerics(samples=512))
    at_root = waves.sel(vessel=network.name[network.root], station="inlet")
    inside, volume = waves.ventricular_pressure.to_numpy(), waves.ventricular_volume.to_numpy()
    load = inside[np.argmax(inside / volume)] / (volume[0] - volume[-1])
    flow = np.clip(at_root.flow.to_numpy(), 0, None)
    recording = Recording(at_root.pressure.to_numpy(), flow / scale**2, PERIOD * scale)
    return recording, VentricularPressure(inside, PERIOD * scale), heart.elastance.max() * scale, load * scale


@pytest.mark.parametrize("R_T", [60.0, *(pytest.param(one, marks=pytest.mark.validation) for one in (90.0, 180.0))])
def test_the_elastances_of_a_ventricle_of_the_published_shape_are_found(R_T):
    recording, inside, elastance, load = beat(R_T=R_T)
    found = coupling(recording, inside)
    assert found.load == pytest.approx(load, rel=0.03)
    assert found.elastance == pytest.approx(elastance, rel=0.12)
    assert found.ratio == pytest.approx(found.elastance / found.load)
    assert found.stroke_volume == pytest.approx(recording.flow.mean() * PERIOD, rel=0.01)
    assert not found.findings


def test_an_elastance_of_another_shape_lies_within_the_interval():
    recording, inside, elastance, load = beat("relaxing")
    found = coupling(recording, inside)
    assert abs(np.log(found.elastance / found.load / (elastance / load))) < 0.3 < 1.96 * found.error


def test_neither_the_gain_of_the_probe_nor_where_the_cycle_is_cut_moves_the_ratio():
    recording, inside, *_ = beat()
    usual = coupling(recording, inside)
    gained = Recording(recording.pressure, 1.3 * recording.flow, PERIOD)
    assert coupling(gained, inside).ratio == pytest.approx(usual.ratio, rel=1e-4)
    assert coupling(gained, inside).elastance == pytest.approx(usual.elastance / 1.3, rel=1e-4)
    for moved in (100, 300, 450):
        turned = VentricularPressure(np.roll(inside.pressure, moved), PERIOD)
        cut = Recording(np.roll(recording.pressure, 2 * moved), np.roll(recording.flow, 2 * moved), PERIOD)
        assert coupling(cut, turned).ratio == pytest.approx(usual.ratio, rel=0.02)


def test_a_heart_of_another_size_and_rate_has_the_same_ratio():
    mouse, inside, *_ = beat()
    bigger, slower, *_ = beat(scale=7.0)
    assert coupling(bigger, slower).ratio == pytest.approx(coupling(mouse, inside).ratio, rel=1e-3)


def test_the_fitted_ventricle_drives_the_network_as_the_true_one_does():
    recording, inside, *_ = beat()
    network = vw.control_network()
    model = vw.Model(network, vw.LinearWall(60.0), windkessels(network, 90.0, 0.12, 0.2))
    waves = vw.simulate(model, coupling(recording, inside).ventricle)
    at_root = waves.sel(vessel=network.name[network.root], station="inlet")
    assert float(at_root.flow.mean()) == pytest.approx(recording.cardiac_output, rel=0.08)
    assert float(at_root.pressure.max()) == pytest.approx(recording.systolic_pressure, rel=0.05)


def test_noise_moves_the_ratio_little_and_widens_its_interval():
    recording, inside, elastance, load = beat()
    rng, found = np.random.default_rng(4), []
    for _ in range(3):
        noisy = VentricularPressure(inside.pressure + 0.4 * rng.standard_normal(512), PERIOD)
        found.append(coupling(recording, noisy))
    assert max(abs(np.log(one.ratio * load / elastance)) for one in found) < 0.25
    assert min(one.error for one in found) > coupling(recording, inside).error


def test_twice_the_noise_makes_four_times_the_variance_that_noise_adds():
    """What elastances of other shapes add, 0.5, stays; noise of 0.5 and 1 mmHg is above what is assumed at least."""
    recording, inside, *_ = beat()
    noise = np.random.default_rng(8).standard_normal(512)
    once, twice = (coupling(recording, VentricularPressure(inside.pressure + sd * noise, PERIOD)) for sd in (0.5, 1.0))
    assert twice.error**2 - 0.25 == pytest.approx(4 * (once.error**2 - 0.25), rel=0.2)


def test_the_single_beat_method_finds_the_peak_of_a_sine():
    """The pressure is a sine before and after ejection, and sags in between."""
    t = np.arange(512) / 512
    isovolumic = 5.0 + 45.0 * np.sin(np.pi * np.clip(t / 0.6, 0, 1)) ** 2
    left = np.clip((t - 0.17) / 0.26, 0, 1)
    pressure = isovolumic * (1 - 0.4 * np.sin(np.pi * left))
    flow = np.sin(np.pi * left)
    found = coupling(Recording(19 + 4 * np.sin(2 * np.pi * (t - 0.17)), flow, 0.1), VentricularPressure(pressure, 0.1))
    end_systolic = found.load * found.stroke_volume
    assert (found.single_beat + 1) * end_systolic == pytest.approx(50.0, rel=0.1)


def test_what_does_not_go_together_is_said():
    recording, inside, *_ = beat()
    faster = coupling(recording, VentricularPressure(inside.pressure, 0.7 * PERIOD))
    assert "ventricle.other-rate" in [one.code for one in faster.findings]
    lower = coupling(recording, VentricularPressure(inside.pressure - 6.0, PERIOD))
    assert "ventricle.below-artery" in [one.code for one in lower.findings]


def test_a_ventricle_that_does_not_reach_the_artery_is_refused():
    recording, inside, *_ = beat()
    with pytest.raises(InputError, match="zero or the unit"):
        coupling(recording, VentricularPressure(inside.pressure / 7.5, PERIOD))
    with pytest.raises(InputError, match="beginning and end"):
        coupling(Recording(recording.pressure, recording.flow + 5, PERIOD), inside)


def test_approved_couplings_of_a_ventricle_and_its_artery():
    """Of one beat, with its error by the slopes of the fit, and of one that lasts longer than the artery's."""
    t = np.arange(256) / 256
    flow = np.where((t > 0.1) & (t < 0.4), np.sin(np.pi * np.clip((t - 0.1) / 0.3, 0, 1)), 0.0)
    artery = Recording(15 + 4 * np.sin(2 * np.pi * (t - 0.12)), flow, period=0.11)
    lines = []
    for period, most in ((0.11, 30.0), (0.13, 15.0)):
        inside = VentricularPressure(3 + (most - 3) * np.sin(np.pi * np.minimum(t / 0.5, 1)) ** 2, period=period)
        found = coupling(artery, inside)
        lines += parts(f"period {period}", found)
        lines += [str(one) for one in found.findings]
        lines += parts(f"period {period}, ventricle", found.ventricle)
        lines.append(repr(found))
    approve("coupling", lines, 1e-9, 1e-3)
