"""Directions: relative changes of a model, in which derivatives are taken."""

from typing import Any, NamedTuple

import numpy as np

from vasowave.errors import InputError
from vasowave.model.model import Model
from vasowave.model.outlets import Bed


class Direction(NamedTuple):
    """A relative change of a model: the derivatives of the logarithms of its parts by one number.

    Attributes
    ----------
    wall : array, shape (parameter, vessel)
    area0, length : array, shape (vessel,)
    outlets : array, shape (field, terminal)
        Of the fields of the beds.
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
        Outlets without parameters, or models that differ in their vessels or in the kind of their beds.
    """
    if not (isinstance(before.outlets, Bed) and type(before.outlets) is type(after.outlets)):
        raise InputError("derivatives need beds of one kind with parameters; an impedance spectrum has none")
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
