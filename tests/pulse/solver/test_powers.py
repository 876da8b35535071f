"""The compiled solver's own powers against the library's."""

import numpy as np

from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import LinearWall, Model, Numerics, PowerWall, estimate_nominal
from vasowave.pulse.solver import power, simulate_run


def test_power_is_as_exact_as_its_logarithm():
    rng = np.random.default_rng(5)
    x, m = np.exp(rng.uniform(-1.0, 3.0, 50000)), np.exp(rng.uniform(-3.0, 4.0, 50000))
    assert np.all(np.abs(power(x, m) / x**m - 1) <= 1e-15 + 4e-16 * np.abs(m * np.log(x)))
    assert np.all(power(np.ones(8), np.geomspace(0.01, 50.0, 8)) == 1.0)


def test_the_solver_takes_a_power_wall_of_one_half_for_a_linear_one():
    network, mouse = control_network(), virtual_mouse()
    nominal = estimate_nominal(network, mouse)
    numerics = Numerics(samples=64, tolerance=1e-9)
    runs = [
        simulate_run(Model(network, wall, nominal.outlets), mouse.inflow, numerics)
        for wall in (LinearWall(50.0), PowerWall(50.0, 0.5))
    ]
    assert runs[0].steps == runs[1].steps
    np.testing.assert_allclose(runs[0].pressure, runs[1].pressure, atol=1e-10)
