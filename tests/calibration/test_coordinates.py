"""The coordinates of a search against the equations of the wall laws and of the outlets."""

import numpy as np
import pytest

from vasowave.calibration.coordinates import Coordinates
from vasowave.calibration.parameters import parameter_space
from vasowave.datasets import control_network, virtual_mouse
from vasowave.model.blood import Blood
from vasowave.model.laws import LAWS
from vasowave.model.nominal import estimate_nominal


def coordinates_of(wall, fixed=None):
    network, mouse = control_network(), virtual_mouse()
    nominal = estimate_nominal(network, mouse)
    return Coordinates(parameter_space(wall, network, nominal, Blood(), {}, fixed or {}, False), mouse.mean_pressure)


@pytest.mark.parametrize("wall", LAWS)
@pytest.mark.parametrize("fixed", [{}, {"r1": 0.7}, {"c1": 1.0}])
def test_coordinates_and_logarithms_are_inverse_and_their_slopes_are_the_derivative(wall, fixed):
    there = coordinates_of(wall, fixed)
    rng = np.random.default_rng(1)
    x = np.log(there.space.nominal[there.space.free]) + rng.uniform(-0.4, 0.4, there.space.free.sum())
    z = there.of(x)
    np.testing.assert_allclose(there.logarithms(z), x, rtol=1e-9, atol=1e-9)
    h = 1e-4 * rng.standard_normal(len(z))
    change = there.logarithms(z + h) - there.logarithms(z - h)
    np.testing.assert_allclose(change, 2 * there.slopes(z) @ h, rtol=1e-4, atol=1e-10)
