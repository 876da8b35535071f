"""Many starts led together end no higher than each of them followed alone."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from vasowave.pulse.calibration import (
    ROUGH_TOLERANCE,
    Misled,
    Objective,
    ValleyRules,
    Valleys,
    compared_part,
    parameter_space,
    search,
)
from vasowave.pulse.calibration import starts as starting
from vasowave.pulse.examples import virtual_mouse
from vasowave.pulse.model import Blood, Numerics, estimate_nominal
from vasowave.pulse.network import Network

TREE, MOUSE = Network(("1", "2", "3"), [-1, 0, 0], [0.4, 0.4, 0.5], [0.05, 0.035, 0.04]), virtual_mouse()
RING = Network(("in", "a", "b", "out"), None, [0.4, 0.3, 0.5, 0.4], [0.05, 0.035, 0.03, 0.04],
               nodes=[[0, 1], [1, 2], [1, 2], [2, 3]])  # fmt: skip
WAVE = np.sin(2 * np.pi * np.arange(len(MOUSE.pressure)) / len(MOUSE.pressure))
KINDS = {
    "straight": (TREE, MOUSE, "tangent"),
    "tapering": (replace(TREE, taper=0.3 * TREE.radius / TREE.length), MOUSE, "tangent"),
    "loop": (RING, MOUSE, "linear"),
    "pulsating beds": (TREE, replace(MOUSE, wedge_pressure=3.0, wedge_pulsation=1.5 * WAVE), "linear"),
}


@pytest.fixture(scope="module", params=KINDS)
def posed(request):
    network, mouse, law = KINDS[request.param]
    space = parameter_space(law, network, estimate_nominal(network, mouse), Blood())
    compared, numerics = compared_part(mouse, "signal"), Numerics(samples=64, tolerance=1e-6, cell_size=0.2)
    points = starting.starting_points(space, 3, seed=1)
    alone = [
        search(Objective(space, compared, numerics, 1, threading.Event()), point, "least-squares", ROUGH_TOLERANCE)
        for point in points
    ]
    return space, compared, numerics, points, alone


def test_starts_that_are_led_together_end_no_higher_than_each_of_them_alone(posed):
    *problem, alone = posed
    together, stopped = starting.search_all(*problem, "least-squares")
    assert not stopped
    least = min(end.S for end in alone)
    assert min(end.S for end in together) <= (1 + 1e-3) * least  # the step, which a search chooses, changes S by 4e-4
    assert sum(end.simulations for end in together) < 0.5 * sum(end.simulations for end in alone)


def test_where_the_linear_network_needs_too_many_simulations_it_misleads(posed):
    space, compared, numerics, points, _ = posed
    objective = Objective(space, compared, numerics, 1, threading.Event())
    valleys = Valleys(objective, np.array(points), rules=ValleyRules(max_simulations=1))
    with pytest.raises(Misled):
        valleys.search(lambda S: None)
    assert len(valleys.simulated) == 1
