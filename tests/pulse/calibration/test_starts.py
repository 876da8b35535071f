"""Many starts: those that are not followed would have ended where the best one did, and other valleys are seen."""

import threading

import pytest

from vasowave.pulse.calibration import ROUGH_TOLERANCE, Objective, compared_part, parameter_space, search
from vasowave.pulse.calibration import starts as starting
from vasowave.pulse.examples import virtual_mouse
from vasowave.pulse.model import Blood, Numerics, estimate_nominal
from vasowave.pulse.network import Network


def test_starts_that_are_not_followed_would_have_ended_at_the_same_optimum():
    network, mouse = Network(("1", "2", "3"), [-1, 0, 0], [0.4, 0.4, 0.5], [0.05, 0.035, 0.04]), virtual_mouse()
    space = parameter_space("tangent", network, estimate_nominal(network, mouse), Blood())
    compared = compared_part(mouse, "signal")
    numerics = Numerics(samples=64, tolerance=1e-6, cell_size=0.2)
    points = starting.starting_points(space, 3, seed=1)
    found, stopped = starting.search_all(space, compared, numerics, points, "least-squares")
    assert not stopped
    best = min(one.S for one in found)
    followed = 0
    for point, one in zip(points, found, strict=True):
        objective = Objective(space, compared, numerics, 1, threading.Event())
        end = search(objective, point, "least-squares", ROUGH_TOLERANCE)
        assert best <= (1 + starting.SAME_OPTIMUM_SHARE) * end.S
        if one.joined:
            followed += 1
            assert one.simulations < end.simulations
            assert end.S == pytest.approx(best, rel=starting.SAME_OPTIMUM_SHARE, abs=1e-6 * len(compared.measured))
    assert followed > 0
