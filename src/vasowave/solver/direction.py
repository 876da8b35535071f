"""Directions: relative changes of a model, in which derivatives are taken."""

from typing import Any, NamedTuple, cast

import numpy as np

from vasowave.errors import InputError
from vasowave.model.model import Model
from vasowave.model.outlets import Bed
from vasowave.model.shape import Shape


class Direction(NamedTuple):
    """A relative change of a model: the derivatives of the logarithms of its parts by one number.

    Attributes
    ----------
    before, after : Model
    apart : float
        How far they are apart in the number.
    """

    before: Model
    after: Model
    apart: float

    def walls(self, vessel: np.ndarray, share: np.ndarray) -> np.ndarray:
        """Return what becomes of the wall law's parameters and A0 at places (`Model.at`), (parameter + 1, place)."""
        low, high = (np.array([*wall, area0]) for wall, area0 in (m.at(vessel, share) for m in self[:2]))
        return self._relative(low, high)

    @property
    def length(self) -> np.ndarray:
        """What becomes of the vessels' lengths, shape (vessel,)."""
        return self._relative(self.before.network.length, self.after.network.length)

    @property
    def outlets(self) -> np.ndarray:
        """What becomes of the fields of the beds, shape (field, terminal)."""
        before, after = (np.array(list(cast(Any, one.outlets))) for one in (self.before, self.after))
        return self._relative(before, after)

    def _relative(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        return np.asarray(np.log(high / low) / self.apart)


def direction_between(before: Model, after: Model, apart: float) -> Direction:
    """Return the direction from one model to another of the same vessels, `apart` from it in the number.

    Exact where all parts are powers or exponentials of the number; else the two models must be near to each other.

    Raises
    ------
    InputError
        Outlets without parameters, or models that differ in their vessels, in how these change along their way, or in
        the kind of their beds.
    """
    if not (isinstance(before.outlets, Bed) and type(before.outlets) is type(after.outlets)):
        raise InputError("derivatives need beds of one kind with parameters; an impedance spectrum has none")
    if before.network.name != after.network.name or type(before.wall) is not type(after.wall):
        raise InputError("a direction leads between two models of the same vessels and the same wall law")
    if before.total_pressure != after.total_pressure or not np.array_equal(before.loss, after.loss):
        raise InputError("a direction leads between two models with the same junctions and losses")
    if not all(np.array_equal(*both) for both in zip(_profile(before), _profile(after), strict=True)):
        raise InputError("derivatives by the shape of vessels are not known; take differences of simulations")
    return Direction(before, after, apart)


def _profile(model: Model) -> tuple[np.ndarray, np.ndarray]:
    shape = model.profile or Shape()
    return np.asarray(shape.radius), np.asarray(shape.stiffness)
