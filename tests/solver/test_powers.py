"""The compiled solver's own powers against the library's."""

import numpy as np
import pytest
from numba import njit

from vasowave.datasets import control_network, virtual_mouse
from vasowave.model.model import Model
from vasowave.model.nominal import estimate_nominal
from vasowave.model.walls import LinearWall, PowerWall
from vasowave.solver.cells import WHOLE
from vasowave.solver.powers import exponential, logarithm, power
from vasowave.solver.simulate import Numerics, simulate_run


@njit(**WHOLE)
def compiled(x, m, found):
    """As the kernels compile it, who let the compiler reorder sums."""
    for j in range(len(x)):
        found[j] = power(x[j], m[j])


def compiled_power(x, m):
    found = np.empty(len(x))
    compiled(x, np.broadcast_to(m, x.shape).copy(), found)
    return found


def test_logarithm_is_exact_to_rounding():
    x = np.concatenate([np.geomspace(1e-300, 1e300, 100001), np.linspace(0.5, 2.0, 100001)])
    assert np.all(np.abs(logarithm(x) - np.log(x)) <= 4e-16 * np.abs(np.log(x)))


def test_exponential_is_exact_to_rounding():
    y = np.linspace(-50.0, 50.0, 200001)
    # n log 2, taken from y, is rounded in its last digit.
    assert np.all(np.abs(exponential(y) / np.exp(y) - 1) <= 1e-15 + 2e-16 * np.abs(y))


@pytest.mark.parametrize("found", [power, compiled_power], ids=["as written", "compiled"])
def test_power_is_as_exact_as_its_logarithm(found):
    rng = np.random.default_rng(5)
    x, m = np.exp(rng.uniform(-1.0, 3.0, 50000)), np.exp(rng.uniform(-3.0, 4.0, 50000))
    assert np.all(np.abs(found(x, m) / x**m - 1) <= 1e-15 + 4e-16 * np.abs(m * np.log(x)))
    assert np.all(found(np.ones(8), np.geomspace(0.01, 50.0, 8)) == 1.0)


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
