"""Calibration recovers what it should, and says what it cannot: in a study."""

from dataclasses import replace

import numpy as np

from known_exactly import summary_without_errors
from vasowave.pulse.calibration import calibrate
from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import Numerics


def test_a_passive_tree_leaves_the_beds_no_more_than_the_measured_resistance():
    """Another animal's tree and beds that fit badly: pressure over flow still bounds what they can have."""
    mouse, network = virtual_mouse(), control_network()
    foreign = replace(network, radius=0.8 * network.radius, length=np.roll(network.length, 3))
    fit = calibrate(foreign, mouse, starts=1, bed="resistance", numerics=Numerics(cell_size=0.4, samples=128))
    row = summary_without_errors(fit).loc["R_T"]
    fall = mouse.vascular_resistance - row["value"]
    assert row["value"] < row["high"] <= mouse.vascular_resistance
    assert row["low"] > mouse.vascular_resistance - 3.0 * fall  # no vessel takes three times what the model has it take
