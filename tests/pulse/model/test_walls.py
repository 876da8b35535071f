import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.pulse.model import (
    Blood,
    BoundaryLayer,
    LinearWall,
    Poiseuille,
    PowerLaw,
    PowerWall,
    TangentWall,
    VeinWall,
    one_per_vessel,
    walls,
)

AREA0 = 0.0069
INERTIA = 1.057 / 1333.22
PRESSURE = np.linspace(-2.0, 45.0, 13)
LAWS = {
    "linear": LinearWall(57.0),
    "tangent": TangentWall(7.0, 4.0),
    "power": PowerWall(40.0, 3.0),
    "power, soft": PowerWall(30.0, 0.3),
    "vein": VeinWall(57.0),
    "vein, soft": VeinWall(3.0),
}
all_laws = pytest.mark.parametrize("wall", LAWS.values(), ids=LAWS)


def slope(wall):
    h = 1e-3
    return (walls.area(wall, PRESSURE + h, AREA0) - walls.area(wall, PRESSURE - h, AREA0)) / (2 * h)


@all_laws
def test_area_compliance_is_the_derivative_of_area(wall):
    np.testing.assert_allclose(walls.area_compliance(wall, PRESSURE, AREA0), slope(wall), rtol=1e-6)


@all_laws
def test_squared_wave_speed_is_area_over_density_and_compliance(wall):
    expected = walls.area(wall, PRESSURE, AREA0) / (INERTIA * slope(wall))
    np.testing.assert_allclose(walls.wave_speed(wall, PRESSURE, INERTIA) ** 2, expected, rtol=1e-6)


@all_laws
def test_pressure_and_area_are_inverse(wall):
    there = walls.area(wall, PRESSURE, AREA0)
    np.testing.assert_allclose(walls.pressure(wall, there, AREA0), PRESSURE, rtol=1e-10, atol=1e-10)
    assert walls.area(wall, 0.0, AREA0) == pytest.approx(AREA0, rel=1e-14)


def test_the_linear_wall_has_the_wave_speed_of_equation_32():
    found = walls.wave_speed(LinearWall(57.0), PRESSURE, INERTIA) ** 2
    np.testing.assert_allclose(found, (57.0 + PRESSURE) / (2 * INERTIA), rtol=1e-12)


def test_the_tangent_wall_has_the_wave_speed_of_equation_32():
    p1, gamma = 7.0, 4.0
    x = PRESSURE / p1
    expected = np.pi * p1 / (gamma * INERTIA) * (gamma / np.pi * np.arctan(x) + 1) * (1 + x**2)
    np.testing.assert_allclose(walls.wave_speed(TangentWall(p1, gamma), PRESSURE, INERTIA) ** 2, expected, rtol=1e-12)


def test_the_wave_speed_at_rest_is_that_of_equation_33():
    expected = {LinearWall(57.0): 57.0 / (2 * INERTIA), TangentWall(7.0, 4.0): np.pi * 7.0 / (4.0 * INERTIA)}
    for wall, squared in expected.items():
        assert walls.wave_speed_at_rest(wall, INERTIA) ** 2 == pytest.approx(squared, rel=1e-12)


def test_the_area_of_the_tangent_wall_ends_at_that_of_equation_5():
    wall = TangentWall(7.0, 4.0)
    assert wall.limits(*wall)[1] == pytest.approx(3.0, rel=1e-14)
    assert walls.area(wall, 1e12, AREA0) == pytest.approx(3 * AREA0, rel=1e-9)
    assert np.isinf(LinearWall.limits(57.0)[1])


def test_one_parameter_per_vessel_gives_one_pressure_per_vessel():
    found = walls.pressure(LinearWall(np.array([50.0, 80.0])), np.array([[4.0, 2.25]]), 1.0)
    np.testing.assert_allclose(found, [[50.0, 40.0]], rtol=1e-14)


def test_the_power_wall_with_exponent_one_half_is_the_linear_wall_at_all_pressures():
    pressure = np.linspace(-20.0, 60.0, 41)
    linear, power = LinearWall(57.0), PowerWall(57.0, 0.5)
    for quantity in (walls.area, walls.area_compliance):
        np.testing.assert_allclose(quantity(power, pressure, AREA0), quantity(linear, pressure, AREA0), rtol=1e-13)
    np.testing.assert_allclose(walls.wave_speed(power, pressure, INERTIA), walls.wave_speed(linear, pressure, INERTIA))


def test_the_power_wall_with_exponent_one_has_a_constant_compliance_above_zero_pressure():
    found = walls.area_compliance(PowerWall(40.0, 1.0), np.linspace(0.0, 60.0, 7), AREA0)
    np.testing.assert_allclose(found, 2 * AREA0 / 40.0, rtol=1e-13)


def test_the_power_wall_stiffens_with_its_exponent_and_never_collapses_above_the_linear_limit():
    pressure = np.linspace(1.0, 60.0, 10)
    soft, stiff = (walls.area_compliance(PowerWall(40.0, m), pressure, AREA0) for m in (2.0, 8.0))
    assert np.all(stiff < soft)
    assert np.all(np.diff(stiff) < 0)
    assert walls.area(PowerWall(40.0, 8.0), -10.0, 1.0) == pytest.approx((1 - 10 / 40) ** 2)


def test_a_parameter_of_a_vessel_that_is_zero_or_not_finite_is_refused_by_the_vessels_name():
    with pytest.raises(InputError, match="vessel 'b': wall parameter beta = 0; it must be positive and finite"):
        one_per_vessel(LinearWall(np.array([57.0, 0.0])), ("a", "b"), "wall")
    with pytest.raises(InputError, match="vessel 'a': wall parameter beta = inf"):
        one_per_vessel(LinearWall(np.inf), ("a", "b"), "wall")
    with pytest.raises(InputError, match=r"beta has shape \(3,\); give one number or 2 values"):
        one_per_vessel(LinearWall(np.ones(3)), ("a", "b"), "wall")


def test_pressures_of_every_law_are_those_worked_out_by_hand():
    """Linear: 60 (√1.44 - 1) = 12; power with m = 2: 60/4 (1.5² - 1) = 18.75, below 0 linear; tangent: 9 tan(π/4)."""
    assert walls.pressure(LinearWall(60.0), 1.44, 1.0) == pytest.approx(12.0)
    assert walls.pressure(PowerWall(60.0, 2.0), 3.0, 2.0) == pytest.approx(18.75)
    assert walls.pressure(PowerWall(60.0, 2.0), 0.64, 1.0) == pytest.approx(-12.0)
    assert walls.pressure(TangentWall(9.0, 4.0), 2.0, 1.0) == pytest.approx(9.0)
    assert walls.pressure(VeinWall(23.0), 0.25, 1.0) == pytest.approx(0.25**10 - 8)
    assert TangentWall(9.0, 1.0).limits(9.0, 1.0) == (0.5, 1.5)


@pytest.mark.parametrize(("given", "words"), [({"density": 1060.0}, "kg/m³"), ({"viscosity": 4.0}, "4 mPa s")])
def test_a_blood_in_another_unit_is_refused(given, words):
    with pytest.raises(InputError, match=words):
        Blood(**given)


def test_blood_has_the_friction_of_its_profile():
    """2 π (ζ + 2) ν of a power of ζ, Poiseuille's of 2, and a layer of √(ν T/2π)."""
    layer = np.sqrt(0.03 * 0.11 / (2 * np.pi))
    assert BoundaryLayer().coefficients(0.03, 0.11) == pytest.approx((0.0, 2 * np.sqrt(np.pi) * 0.03 / layer))
    assert Poiseuille().coefficients(0.03, 0.11) == pytest.approx((8 * np.pi * 0.03, 0.0))
    assert PowerLaw(5.0).coefficients(0.03, 0.11) == pytest.approx((2 * np.pi * 7 * 0.03, 0.0))
