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


@pytest.mark.parametrize("wall", LAWS)
def test_the_first_coordinate_is_the_area_strain_at_mean_pressure_and_r1_and_r2_give_resistance_and_ratio(wall):
    there = coordinates_of(wall)
    z = there.of(np.log(there.space.nominal))
    model = there.space.model(there.space.nominal)
    law = type(model.wall)(*(value[0] for value in model.wall))
    strain, largest = law.ratio_at(there.pressure, *law) - 1.0, law.limits(*law)[1] - 1.0
    assert np.exp(z[0]) == pytest.approx((strain**-4 - largest**-4) ** -0.25)  # the strain, far from the law's end
    moved = z.copy()
    place = there.space.names.index("r1")
    moved[place] += np.log(2.0)
    values = there.space.values(there.logarithms(moved))
    outlets = there.space.model(values).outlets
    assert outlets.total_resistance() == pytest.approx(2 * model.outlets.total_resistance())
    assert outlets.resistance_ratio() == pytest.approx(model.outlets.resistance_ratio())


def test_a_held_stiffness_stays_a_held_stiffness():
    there = coordinates_of("tangent", {"p1": 5.0})
    assert not there.strained
    assert there.space.values(there.logarithms(there.of(np.zeros(4))))[0] == 5.0
