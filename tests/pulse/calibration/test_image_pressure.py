"""Radii belong to the pressure of their image: areas, linear theory, fits and files know it."""

from dataclasses import replace

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.pulse.analysis import wave_speeds
from vasowave.pulse.calibration import Search, calibrate
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import (
    Blood,
    LinearWall,
    Model,
    Numerics,
    PowerWall,
    TangentWall,
    estimate_nominal,
    linear_solution,
    stiffness,
    walls,
    windkessels,
)
from vasowave.pulse.network import NO_PRESSURE, Network, unknown_pressure, write_network
from vasowave.pulse.network_formats import read_network
from vasowave.pulse.solver import simulate

FILLED = 6.3  # mmHg, the paper's
LAWS = [LinearWall(57.0), TangentWall(7.0, 2.8), PowerWall(20.0, 2.0)]


def filled(pressure=FILLED):
    return replace(control_network(), pressure=pressure)


def model_of(wall, network):
    return Model(network, wall, windkessels(network, 76.0, 0.12, 0.12))


@pytest.mark.parametrize("wall", LAWS, ids=lambda wall: type(wall).__name__)
def test_at_the_pressure_of_the_image_every_law_has_the_area_of_the_image(wall):
    beta = np.linspace(0.5, 2.0, 21) * wall[0]  # another wall in every vessel
    model = model_of(wall._replace(**{wall._fields[0]: beta}), filled())
    np.testing.assert_allclose(walls.area(model.wall, FILLED, model.area0), np.pi * model.network.radius**2, rtol=1e-13)
    assert np.all(model.area0 < model.network.area)
    radius = wave_speeds(model, FILLED)["radius [cm]"]
    np.testing.assert_allclose(radius, model.network.radius, rtol=1e-13)


@pytest.mark.parametrize("wall", LAWS, ids=lambda wall: type(wall).__name__)
def test_a_filled_image_is_the_empty_vessels_seen_wider(wall):
    """The same animal twice: imaged filled, and with the radii it has at zero pressure."""
    model = model_of(wall, filled())
    empty = Network(model.network.name, model.network.parent, model.network.length, np.sqrt(model.area0 / np.pi))
    other = Model(empty, wall, model.outlets)
    mouse = virtual_mouse()
    for one, two in zip(*(linear_solution(each, mouse.inflow).at(np.arange(21), 0.0) for each in (model, other))):
        np.testing.assert_allclose(one, two, rtol=1e-9, atol=1e-12)
    numerics = Numerics(tolerance=1e-8)
    waves, expected = simulate(model, mouse, numerics), simulate(other, mouse, numerics)
    for name in ("pressure", "area", "flow", "wave_speed"):
        np.testing.assert_allclose(waves[name], expected[name], rtol=1e-9, atol=1e-9)


def test_a_fit_finds_the_truth_only_where_the_radii_were_measured():
    wall, mouse = LinearWall(45.0), virtual_mouse()
    truth = model_of(wall, filled())
    inlet = simulate(truth, mouse, Numerics(samples=512, tolerance=1e-8))["pressure"].sel(vessel="1", station="inlet")
    recording = Recording(inlet.values, mouse.flow, mouse.period)
    right, wrong = (calibrate(filled(p), recording, search=Search(starts=1)) for p in (FILLED, 0.0))
    assert right.parameters["value"]["beta"] == pytest.approx(45.0, rel=1e-3)
    assert right.total_resistance == pytest.approx(76.0, rel=1e-3)
    # Too wide a vessel needs a stiffer wall for the same impedance: c/A counts, and A is 1.3 times too large.
    assert wrong.parameters["value"]["beta"] > 1.15 * 45.0
    assert NO_PRESSURE() not in right.findings
    assert wrong.findings.count(NO_PRESSURE()) == 1


def test_the_nominal_stiffness_is_that_of_the_linear_law_at_the_pressure_of_the_image():
    blood, area, beta = Blood(), 0.0069, 45.0
    Z_c = blood.inertia * float(walls.wave_speed(LinearWall(beta), FILLED, blood.inertia)) / area
    assert stiffness(Z_c, area, blood, FILLED) == pytest.approx(beta)
    assert stiffness(Z_c, area, blood, 90.0) > 0  # so soft a wall cannot be; a fit can still begin somewhere
    mouse = virtual_mouse()
    at_rest, at_image = (estimate_nominal(filled(p), mouse).beta for p in (0.0, FILLED))
    assert at_rest - at_image == pytest.approx(FILLED)


def test_a_network_keeps_the_pressure_of_its_image_in_its_file(tmp_path):
    path = tmp_path / "network.csv"
    write_network(filled(), path)
    again = read_network(path)
    assert again.pressure == FILLED
    np.testing.assert_array_equal(again.radius, filled().radius)
    write_network(control_network(), path)
    assert "pressure" not in path.read_text()
    assert read_network(path).pressure == 0.0
    assert unknown_pressure(control_network())
    assert not unknown_pressure(filled())


@pytest.mark.parametrize(
    ("title", "cells", "message"),
    [
        ("pressure [mmHg]", ("6.3", "6.4"), r"line 3: pressure 6.4 mmHg, but 6.3 mmHg in the first row"),
        ("pressure [mmHg]", ("-1", "-1"), r"line 2: pressure of the image -1 mmHg: .* between 0"),
        ("pressure [kPa]", ("63", "63"), r"line 2: .* 472.5\d mmHg.*is its unit right"),
        ("pressure", ("6.3", "6.3"), r"column 'pressure' has no unit"),
        ("pressure [cm]", ("6.3", "6.3"), r"'cm' is not a unit of pressure"),
        ("pressure [mmHg]", ("6.3", ""), r"line 3, column 'pressure': the cell is empty"),
    ],
)
def test_a_wrong_pressure_of_the_image_is_an_error_that_says_where(tmp_path, title, cells, message):
    path = tmp_path / "network.csv"
    path.write_text(f"name,parent,length [cm],radius [cm],{title}\na,,0.4,0.04,{cells[0]}\nb,a,0.4,0.03,{cells[1]}\n")
    with pytest.raises(InputError, match=message):
        read_network(path)
