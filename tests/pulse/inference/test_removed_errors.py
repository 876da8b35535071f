"""Every error that a lab may know, taken out of what was seen: each changes its own thing, by as much as it says."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network
from vasowave.pulse.inference import KnownErrors, Observed, kinds
from vasowave.pulse.model import Blood

SHARE = np.arange(64) / 64
CYCLE = Recording(16 + 5 * np.sin(2 * np.pi * SHARE), 0.2 + 0.1 * np.cos(2 * np.pi * SHARE), 0.11)
SEEN = Observed(control_network(), CYCLE, Blood())


def without(name, value):
    return kinds()[name].without(SEEN, value)


def test_sizes_and_pressure_of_the_image():
    assert without("radius_scale", 1.1).network.radius == pytest.approx(1.1 * SEEN.network.radius)
    assert np.array_equal(without("radius_scale", 1.1).network.length, SEEN.network.length)
    assert without("length_scale", 0.9).network.length == pytest.approx(0.9 * SEEN.network.length)
    assert without("image_pressure", 7.0).network.pressure == 7.0


def test_flow_and_pressure():
    """A flow that was shown 5 ms too late was in truth earlier."""
    time = SHARE * 0.11
    early = 0.2 + 0.1 * np.cos(2 * np.pi * (time + 0.005) / 0.11)
    assert without("flow_delay", 0.005).recording.flow == pytest.approx(early)
    assert without("flow_gain", 1.2).recording.flow == pytest.approx(1.2 * SEEN.recording.flow)
    assert without("zero", 0.7).recording.pressure == pytest.approx(SEEN.recording.pressure - 0.7)


def test_lag_and_inertia_are_undone_as_those_of_a_single_catheter():
    frequency, damping = 30.0, 0.4
    ratio = 1 / (0.11 * frequency)
    time = 1 / (2 * np.pi * frequency)
    later = kinds()["pressure_inertia"].without(without("pressure_lag", 2 * damping * time), time**2)
    true = 16 + 5 * np.imag((1 - ratio**2 + 2j * damping * ratio) * np.exp(2j * np.pi * SHARE))
    assert later.recording.pressure == pytest.approx(true)


def test_blood_and_structure():
    assert without("viscosity", 1.5).blood.viscosity == pytest.approx(1.5 * SEEN.blood.viscosity)
    assert without("k", 0.3) is SEEN


def test_a_network_tells_the_pressure_of_its_image_and_how_well_it_was_measured():
    image = replace(SEEN.network, pressure=6.0, radius_sd=0.08 * SEEN.network.radius)
    errors = {one.name: one for one in KnownErrors().assumed(image)}
    assert (errors["image_pressure"].sd, errors["image_pressure"].source) == (0.3, "usual")
    assert errors["radius_scale"].sd == pytest.approx(0.08)
    assert errors["radius_scale"].source == "image"
    finer = replace(image, radius_sd=0.01 * SEEN.network.radius)  # it knows nothing of the size of the voxels
    assert {one.name: one.source for one in KnownErrors().assumed(finer)}["radius_scale"] == "usual"
    assert {one.name: one.source for one in KnownErrors(radius_scale_sd=0.02).assumed(image)}["radius_scale"] == "lab"
    falling = replace(SEEN.network, taper=0.1 * SEEN.network.radius / SEEN.network.length)
    taper = {one.name: one for one in KnownErrors().assumed(falling)}["taper"]
    assert (taper.sd, taper.source) == (pytest.approx(0.01), "image")  # a tenth of what all fall
