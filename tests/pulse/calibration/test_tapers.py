"""Fits of networks whose vessels were measured to taper: the truth is found, and without the taper missed."""

from dataclasses import replace

import pytest

from vasowave.pulse.calibration import Search, calibrate
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import LinearWall, Model, Numerics, Shape, windkessels
from vasowave.pulse.solver import PAPER, simulate


@pytest.fixture(scope="module")
def measured():
    network = control_network()
    return replace(network, taper=0.15 * network.radius / network.length)


def test_a_fit_of_a_network_that_tapers_finds_the_truth_and_one_of_straight_vessels_does_not(measured):
    """The truth is simulated on finer cells, with a shape that is given; the fit makes its own of the network."""
    mouse = virtual_mouse()
    beds = windkessels(control_network(), 76.0, 0.12, 0.12)
    truth = Model(control_network(), LinearWall(57.0), beds, shape=Shape([1.075, 0.925]))
    inlet = simulate(truth, mouse, Numerics(samples=512, cell_size=0.05))["pressure"].sel(vessel="1", station="inlet")
    recording = Recording(inlet.values, mouse.flow, mouse.period)
    found, straight = (
        calibrate(network, recording, search=Search(starts=1)) for network in (measured, control_network())
    )
    beta, other = (fit.parameters["value"]["beta"] for fit in (found, straight))
    assert beta == pytest.approx(57.0, rel=0.01)
    assert abs(other / 57.0 - 1) > 0.02
    assert found.mean_square < 0.1 * straight.mean_square
    assert found.model.changing.all()


def test_the_papers_practice_takes_measured_tapers_for_straight(measured):
    network = PAPER.network(measured)
    beds = windkessels(network, 76.0, 0.12, 0.12)
    model = Model(network, LinearWall(57.0), beds)
    assert not model.changing.any()
    assert not model.total_pressure
