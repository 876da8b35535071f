"""Vessels that narrow, as pieces of tubes: against the conical horn, the steady fall in a cone, and another cutting."""

from dataclasses import replace

import numpy as np
import pytest

from horn import BETA, FALL, FLOW, LENGTH, RADIUS, TUBE, horn_impedance
from known_animals import tapered as cut_in_four
from vasowave.datasets import control_network, virtual_mouse
from vasowave.errors import InputError
from vasowave.model.blood import Blood
from vasowave.model.linear import linear_solution
from vasowave.model.model import Model
from vasowave.model.outlets import Windkessel
from vasowave.model.shape import Shape
from vasowave.model.tapering import tapered
from vasowave.model.walls import LinearWall


def cone(blood, outlet, longest):
    """A nearly rigid tube that narrows to both sides of its middle, cut into pieces."""
    straight = Model(TUBE, LinearWall(BETA), Windkessel(*(np.array([value]) for value in outlet)), blood)
    return tapered(straight, np.array([FALL]), longest)


def test_waves_in_the_pieces_are_those_of_a_conical_horn():
    blood = Blood(viscosity=1e-9)
    model = cone(blood, (3000.0, 1e-3, 1e9), 0.02)
    found = linear_solution(model, FLOW)
    speed = float(np.sqrt(BETA / (2 * blood.inertia)))  # of the linear wall without pressure
    for k in (1, 3):
        expected = horn_impedance(2 * np.pi * k / FLOW.period, speed, blood.inertia, 3000.0)
        assert found.input_impedance[k, 0] == pytest.approx(expected, rel=4e-3)
        straight = linear_solution(cone(blood, (3000.0, 1e-3, 1e9), 9.0), FLOW).input_impedance[k, 0]
        assert abs(straight / expected - 1) > 0.05


def test_a_single_piece_has_the_steady_resistance_of_the_cone():
    """Mean of r⁻⁴ along the cone, by numerical integration; the drag here goes with r⁻⁴ alone."""
    model = cone(Blood(), (1.0, 2.0, 1e-3), 9.0)
    share = np.linspace(-0.5, 0.5, 100_001)
    expected = np.mean((RADIUS * (1 - FALL * share)) ** -4.0)
    assert model.network.radius[0] ** -4.0 == pytest.approx(expected, rel=1e-3)


def test_outlets_stay_at_the_ends_they_had_and_lengths_add_up():
    network = replace(control_network(), parent=np.array(control_network().parent))
    beds = Windkessel(*(np.arange(1.0, 12.0) for _ in range(3)))
    model = Model(network, LinearWall(np.arange(50.0, 71.0)), beds)
    cut = tapered(model, np.linspace(-0.3, 0.3, 21))
    ends = [cut.network.name[row].rsplit(".", 1)[0] for row in cut.network.terminals]
    assert ends == [network.name[row] for row in network.terminals]
    assert cut.network.length.sum() == pytest.approx(network.length.sum())
    owner = np.array([name.rsplit(".", 1)[0] for name in cut.network.name])
    for row, name in enumerate(network.name):
        own = np.flatnonzero(owner == name)
        assert cut.network.length[own].sum() == pytest.approx(network.length[row])
        assert np.all(cut.wall.beta[own] == 50.0 + row)
        above = cut.network.parent[own[0]]
        if network.parent[row] >= 0:
            parents = np.flatnonzero(owner == network.name[network.parent[row]])
            assert above == parents[-1]


def test_a_positive_fall_narrows_away_from_the_heart():
    radius = cone(Blood(), (1.0, 2.0, 1e-3), 0.1).network.radius
    assert np.all(np.diff(radius) < 0)
    assert (radius[0] - radius[-1]) / RADIUS == pytest.approx(FALL * 19 / 20, rel=1e-2)  # between middles of pieces


def test_cut_by_another_rule_the_pressure_is_nearly_the_same():
    """Four pieces each, with the radius in their middles, as benchmarks cut them; straight vessels are farther off."""
    network, mouse = control_network(), virtual_mouse()
    beds = Windkessel(np.full(11, 50.0), np.full(11, 700.0), np.full(11, 1.5e-4))
    straight = Model(network, LinearWall(57.0), beds)
    fine = linear_solution(replace(straight, network=cut_in_four(network), wall=LinearWall(57.0)), mouse.inflow)
    ours, none = (linear_solution(model, mouse.inflow) for model in (tapered(straight, np.full(21, 0.2)), straight))
    root = np.abs(fine.pressure[:12, 0])
    off = np.linalg.norm(np.abs(ours.pressure[:12, 0]) - root)
    assert off < 0.4 * np.linalg.norm(np.abs(none.pressure[:12, 0]) - root)


def test_without_a_fall_nothing_is_cut():
    model = Model(TUBE, LinearWall(60.0), Windkessel(*(np.ones(1) for _ in range(3))))
    assert tapered(model, np.zeros(1)).network.length.tolist() == [LENGTH]


def test_a_vessel_that_closes_is_refused_by_name():
    with pytest.raises(InputError, match="vessel 'only' tapers until it is closed"):
        tapered(Model(TUBE, LinearWall(60.0), Windkessel(*(np.ones(1) for _ in range(3)))), np.array([2.0]))


def test_a_model_that_has_a_shape_is_not_cut():
    beds = Windkessel(*(np.ones(1) for _ in range(3)))
    with pytest.raises(InputError, match="have a shape already"):
        tapered(Model(TUBE, LinearWall(60.0), beds, shape=Shape([1.1, 0.9])), np.array([0.2]))
