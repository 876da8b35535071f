"""Vessels that change on their way, in the frequency domain: against the conical horn and the steady fall in a cone."""

import numpy as np
import pytest

from horn import BETA, FALL, FLOW, LENGTH, RADIUS, TUBE, horn_impedance
from vasowave.base import InputError
from vasowave.pulse.model import Blood, LinearWall, Model, Shape, Windkessel, linear_solution
from vasowave.pulse.network import Network


def cone(blood, outlet, fall=FALL):
    """A nearly rigid tube that narrows to both sides of its middle."""
    beds = Windkessel(*(np.array([value]) for value in outlet))
    return Model(TUBE, LinearWall(BETA), beds, blood, shape=Shape([1 + fall / 2, 1 - fall / 2]))


def test_waves_are_those_of_a_conical_horn():
    blood = Blood(viscosity=1e-9)
    model = cone(blood, (3000.0, 1e-3, 1e9))
    found = linear_solution(model, FLOW)
    speed = float(np.sqrt(BETA / (2 * blood.inertia)))  # of the linear wall without pressure
    for k in (1, 3):
        expected = horn_impedance(2 * np.pi * k / FLOW.period, speed, blood.inertia, 3000.0)
        assert found.input_impedance[k, 0] == pytest.approx(expected, rel=2e-3)
        straight = linear_solution(cone(blood, (3000.0, 1e-3, 1e9), 0.0), FLOW).input_impedance[k, 0]
        assert abs(straight / expected - 1) > 0.015


def test_a_model_shows_the_shape_of_its_vessels():
    assert repr(cone(Blood(), (1.0, 1.0, 1.0), 0.2)).endswith("Shape(radius 1.1 to 0.9, stiffness 1))")
    assert "Shape" not in repr(cone(Blood(), (1.0, 1.0, 1.0), 0.0))
    assert repr(Shape([[1.0, 1.2, 0.8], [1.0, 1.0, 0.6]], 2.0)) == "Shape(radius 1 to 0.7, stiffness 2)"


def test_the_steady_resistance_is_that_of_the_cone():
    """Mean of r⁻³ along the cone, by numerical integration: a boundary layer's drag goes with r⁻¹, and 1/A with r⁻²."""
    share = np.linspace(-0.5, 0.5, 100_001)
    expected = np.mean((1 - FALL * share) ** -3.0)
    one, other = (linear_solution(cone(Blood(), (1e-6, 1e-6, 1e-3), fall), FLOW) for fall in (FALL, 0.0))
    assert one.resistance[0] / other.resistance[0] == pytest.approx(expected, rel=2e-3)


def test_spectra_along_a_vessel_join_those_of_its_ends():
    """At the outlet pressure over flow is the bed's impedance; what lies between has no jumps."""
    model = cone(Blood(), (300.0, 700.0, 1e-5))
    found = linear_solution(model, FLOW)
    x = np.linspace(0.0, LENGTH, 401)
    P, Q = found.at(np.zeros(401, dtype=int), x)
    bed = model.outlets.impedance_at(len(P), FLOW.period)
    np.testing.assert_allclose(P[:, -1] / Q[:, -1], bed[:, 0], rtol=1e-9)
    np.testing.assert_allclose(P[:, 0], found.pressure[:, 0], rtol=1e-12)
    steps = np.abs(np.diff(P[:6], axis=1))
    assert np.all(steps.max(axis=1) < 20 * np.median(steps, axis=1) + 1e-12)


def test_one_row_of_radii_stands_beside_stiffnesses_of_every_vessel_and_any_other_count_is_refused():
    network = Network(("a", "b", "c"), [-1, 0, 0], [1.0] * 3, [0.05] * 3)
    beds, rows = Windkessel(*(np.ones(2) for _ in range(3))), np.array([[1.0, 1.0], [1.0, 2.0], [3.0, 1.0]])
    model = Model(network, LinearWall(60.0), beds, shape=Shape([1.2, 0.8], rows))
    wall, area0 = model.at([0, 1, 2], [0.5, 0.5, 0.0])
    np.testing.assert_allclose(wall.beta, [60.0, 90.0, 180.0])
    np.testing.assert_allclose(area0, np.pi * 0.05**2 * np.array([1.0, 1.0, 1.44]))
    for wrong in (Shape(rows[:2], rows), Shape([1.0, 1.0], rows[:2])):
        with pytest.raises(InputError, match="one row of points, or one for each of the 3 vessels"):
            Model(network, LinearWall(60.0), beds, shape=wrong)


def test_a_measured_taper_is_drawn_towards_none_by_its_error():
    """As uncertain as the prior it is believed half; what was not measured is straight."""
    share = np.array([0.05, 0.05, 0.05])  # radius over length
    network = Network(
        ("a", "b", "c"),
        [-1, 0, 0],
        [1.0] * 3,
        [0.05] * 3,
        taper=[0.2, 0.2, np.nan] * share,
        taper_sd=[1e-9, 0.015, 1.0],
    )
    np.testing.assert_allclose(Shape.of(network).radius, [[1.1, 0.9], [1.05, 0.95], [1.0, 1.0]])
    assert not Shape.of(TUBE).changes.any()


def test_a0_along_a_vessel_has_the_image_s_area_at_the_image_s_pressure():
    network = Network(("only",), [-1], [LENGTH], [RADIUS], pressure=6.0)
    beds = Windkessel(*(np.ones(1) for _ in range(3)))
    model = Model(network, LinearWall(60.0), beds, shape=Shape([1.1, 0.9], [1.0, 2.0]))
    wall, area0 = model.at([0, 0, 0], [0.0, 0.5, 1.0])
    np.testing.assert_allclose(wall.beta, [60.0, 90.0, 120.0])
    np.testing.assert_allclose(area0 * wall.ratio_at(6.0, *wall), np.pi * RADIUS**2 * np.array([1.21, 1.0, 0.81]))


def test_a_tree_whose_tapers_are_within_their_errors_is_straight_and_shares_the_static_pressure():
    """Scores of 1.2 in 15 vessels come by chance, scores of 2 do not; each alone may be either."""
    count = 15
    sizes = [-1, *(row // 2 for row in range(count - 1))], np.full(count, 0.5), np.full(count, 0.05)
    names, sd = tuple(map(str, range(count))), np.full(count, 0.002)
    signs = np.where(np.arange(count) % 2, 1.0, -1.0)

    def measured(score):
        return Network(names, np.array(sizes[0]), *sizes[1:], taper=score * signs * sd, taper_sd=sd)

    assert not Shape.of(measured(1.2)).changes.any()
    assert Shape.of(measured(2.0)).changes.all()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"wall": "linear"}, "'linear' is not a wall law; use one of `walls`, as in LinearWall"),
        ({"wall": LinearWall([57.0, 57.0])}, r"wall parameter beta has shape \(2,\); give one number or 3 values"),
        ({"outlets": 3.0}, "3.0 is not an outlet; use Windkessel"),
        ({"shape": 0.8}, "shape: 0.8 is no shape; give Shape"),
        ({"outlet_pressure": [1.0, 2.0, 3.0]}, "outlet_pressure: give one number, or one for each of the 2 terminal"),
        ({"outlet_pressure": [1.0, np.nan]}, "vessel 'c': the pressure behind its outlet is nan"),
        ({"junctions": "dynamic"}, "'dynamic' is not known; give 'static' or 'total'"),
        ({"loss": [1.0, 2.0]}, "one for each of the 3"),
        ({"loss": [0.0, -1.0, 0.0]}, "vessel 'b': loss -1"),
        ({"wall_viscosity": [0.1, np.nan, 0.1]}, "vessel 'b': wall_viscosity nan is not valid"),
    ],
)
def test_a_model_of_parts_that_do_not_fit_is_refused(changes, words):
    network = Network(("a", "b", "c"), [-1, 0, 0], [1.0] * 3, [0.05] * 3)
    given = {"network": network, "wall": LinearWall(57.0), "outlets": Windkessel(*(np.ones(2) for _ in range(3)))}
    with pytest.raises(InputError, match=words):
        Model(**(given | changes))


@pytest.mark.parametrize("factors", [(1.0, -0.1), "wide", np.full((1, 3), np.nan)])
def test_a_shape_that_is_none_is_refused(factors):
    with pytest.raises(InputError, match="positive"):
        Shape(factors)
