"""Directions: relative changes of a model, in which derivatives are taken."""

from typing import Any, NamedTuple

import numpy as np

from vasowave.errors import InputError
from vasowave.model import Model
from vasowave.outlets import Windkessel


class Direction(NamedTuple):
    """A relative change of a model: the derivatives of the logarithms of its parts by one number.

    Attributes
    ----------
    wall : array, shape (parameter, vessel)
    area0, length : array, shape (vessel,)
    outlets : array, shape (3, terminal)
        Of R1, R2 and C.
    """

    wall: np.ndarray
    area0: np.ndarray
    length: np.ndarray
    outlets: np.ndarray


def direction_between(before: Model, after: Model, apart: float) -> Direction:
    """Return the direction from one model to another of the same vessels, `apart` from it in the number.

    Exact where all parts are powers or exponentials of the number; else the two models must be near to each other.

    Raises
    ------
    InputError
        Outlets that are no Windkessels, or models that differ in their vessels.
    """
    if not (isinstance(before.outlets, Windkessel) and isinstance(after.outlets, Windkessel)):
        raise InputError("derivatives need Windkessel outlets: an impedance spectrum has no parameters")
    if before.network.name != after.network.name or type(before.wall) is not type(after.wall):
        raise InputError("a direction leads between two models of the same vessels and the same wall law")

    def relative(low: Any, high: Any) -> np.ndarray:
        return np.asarray(np.log(np.array(high) / np.array(low)) / apart)

    return Direction(
        relative(tuple(before.wall), tuple(after.wall)),
        relative(before.area0, after.area0),
        relative(before.network.length, after.network.length),
        relative(tuple(before.outlets), tuple(after.outlets)),
    )
