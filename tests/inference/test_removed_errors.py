"""Every error that a lab may know, taken out of what was seen: each changes its own thing, by as much as it says."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.datasets import control_network
from vasowave.inference.known_errors import KnownErrors, Seen, columns, kinds
from vasowave.model.blood import Blood
from vasowave.recording import Recording

SHARE = np.arange(64) / 64
CYCLE = Recording(16 + 5 * np.sin(2 * np.pi * SHARE), 0.2 + 0.1 * np.cos(2 * np.pi * SHARE), 0.11)
SEEN = Seen(control_network(), CYCLE, Blood())


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


def test_medians_are_no_error_and_the_pressure_that_is_known():
    assert {name: one.center(SEEN) for name, one in kinds().items()} == {
        "radius_scale": 1.0, "length_scale": 1.0, "k": 0.0, "taper": 0.0,
        "image_pressure": SEEN.network.pressure, "flow_gain": 1.0,
        "flow_delay": 0.0, "zero": 0.0, "flow_zero": 0.0, "pressure_lag": 0.0, "pressure_inertia": 0.0, "flow_lag": 0.0,
        "pressure_gain": 1.0, "viscosity": 1.0}  # fmt: skip
    assert {name for name, one in kinds().items() if one.positive} == {
        "radius_scale", "length_scale", "image_pressure", "flow_gain", "pressure_gain", "viscosity"}  # fmt: skip


def test_what_is_not_said_is_as_usual_and_what_is_said_zero_is_not_there():
    errors = KnownErrors(flow_gain_sd=0.07, zero_sd=0.0)
    assert (errors.sd("flow_gain"), errors.sd("zero"), errors.sd("radius_scale")) == (0.07, 0.0, 0.05)
    assert {one.name: (one.sd, one.unit, one.source) for one in errors.assumed(SEEN.network)} == {
        "radius_scale": (0.05, "1", "usual"), "length_scale": (0.05, "1", "usual"), "k": (0.5, "1", "usual"),
        "taper": (0.1, "1", "usual"), "flow_gain": (0.07, "1", "lab"), "zero": (0.0, "mmHg", "lab")}  # fmt: skip


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


def test_columns_say_the_unit_of_what_is_no_share():
    found = {name: title for name, (title, _) in columns().items()}
    assert (found["zero_sd"], found["flow_delay_sd"]) == ("zero sd [mmHg]", "flow delay sd [s]")
    assert (found["flow_gain_sd"], found["image_pressure_sd"], found["k_sd"]) == (
        "flow gain sd", "image pressure sd", "k sd")  # fmt: skip
