"""Viscous walls: theory of small waves, order, volume, energy, the elastic scheme, derivatives: in a study."""

import numpy as np
import pytest

import vasowave as vw
from vasowave.pulse.model import Numerics
from vasowave.pulse.solver import simulate_run

T = 0.11
WALLS = pytest.mark.parametrize(
    "wall",
    [
        pytest.param(vw.LinearWall(57.0), id="linear"),
        pytest.param(vw.TangentWall(9.0, 4.0), id="tangent", marks=pytest.mark.validation),  # has kernels of its own
    ],
)
GAMMAS = 1e-3, *(pytest.param(one, marks=pytest.mark.validation) for one in (1e-5, 1e-4, 1e-2, 1e-1))
"""Viscosity as tube laws have it, Γ/(A0 √A) ∂A/∂t, mmHg s cm: from hardly any to more than the stiffness."""


def of_gamma(model, gamma):
    return model.changed(wall_viscosity=2.0 * gamma / np.sqrt(model.area0))


@pytest.mark.parametrize("gamma", GAMMAS)
@WALLS
def test_the_pulse_of_a_measured_mouse_is_periodic_and_keeps_its_volume(shared, gamma, wall):
    folder = shared / "mouse-c6"
    mouse = vw.read_recording(folder / "pC6_1024.dat", folder / "qC6_1024.dat", period=T)
    network = vw.control_network()
    beds = vw.estimate_nominal(network, mouse).outlets
    run = simulate_run(of_gamma(vw.Model(network, wall, beds), gamma), mouse.inflow, Numerics())
    assert run.convergence.converged
    assert abs(run.volume_error) < 1e-13
    assert not run.notes
