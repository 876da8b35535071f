"""A network of three generations with its waves, small enough to be exported in every test."""

import pytest

from vasowave.pulse.examples import control_network, virtual_mouse
from vasowave.pulse.model import (
    Blood,
    BoundaryLayer,
    LinearWall,
    Model,
    Poiseuille,
    TangentWall,
    narrowed,
    windkessels,
)
from vasowave.study.exchange import solve

LAWS = {"linear": LinearWall(57.0), "tangent": TangentWall(20.0, 2.0)}


def a_model(wall: str, friction) -> Model:
    network = control_network()
    return Model(network, LAWS[wall], windkessels(network, 76.0, 0.11, a=0.12), Blood(friction=friction))


@pytest.fixture(scope="session")
def mouse():
    return virtual_mouse()


@pytest.fixture(scope="session")
def linear(mouse):
    """Return the waves of a linear wall and Poiseuille's friction, which openBF has too."""
    return solve(a_model("linear", Poiseuille()), mouse)


@pytest.fixture(scope="session")
def tangent(mouse):
    """Return the waves of a stiffening wall and the paper's friction."""
    return solve(a_model("tangent", BoundaryLayer()), mouse)


@pytest.fixture(scope="session")
def jet(tangent, mouse):
    """Return the waves of the same mouse with four fifths of the area of one vessel closed."""
    return solve(narrowed(tangent.model, "2", area_lost=0.8, length=0.05), mouse)
