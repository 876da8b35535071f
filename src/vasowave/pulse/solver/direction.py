"""Directions: relative changes of a model, in which derivatives are taken."""

from collections.abc import Callable
from typing import Any, NamedTuple, cast

import numpy as np

from vasowave.base.errors import InputError
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.outlets import Bed


class Direction(NamedTuple):
    """A relative change of a model: the derivatives of the logarithms of its parts by one number.

    Attributes
    ----------
    before, after : Model
    distance : float
        How far they are apart in the number.
    """

    before: Model
    after: Model
    distance: float

    def walls(self, vessel: np.ndarray, share: np.ndarray) -> np.ndarray:
        """Return what becomes of the wall law's parameters and A0 at places (`Model.at`), (parameter + 1, place)."""

        def parts(model: Model) -> np.ndarray:
            wall, area0 = model.at(vessel, share)
            return np.array([*wall, area0])

        return self.relative(parts)

    @property
    def length(self) -> np.ndarray:
        """What becomes of the vessels' lengths, shape (vessel,)."""
        return self.relative(lambda model: model.network.length)

    @property
    def wall_viscosity(self) -> np.ndarray:
        """What becomes of the viscosity of the walls, shape (vessel,)."""
        return self.relative(lambda model: np.broadcast_to(model.wall_viscosity, len(model.network)))

    @property
    def outlets(self) -> np.ndarray:
        """What becomes of the fields of the beds, shape (field, terminal)."""
        return self.relative(lambda model: np.array(list(cast(Any, model.outlets))))

    def relative(self, quantity: Callable[[Model], np.ndarray]) -> np.ndarray:
        """Return what becomes of a part of the model, in the logarithm."""
        before, after = quantity(self.before), quantity(self.after)
        same = before == after  # also where both are zero
        return np.asarray(np.log(np.where(same, 1.0, after) / np.where(same, 1.0, before)) / self.distance)


def direction_between(before: Model, after: Model, distance: float) -> Direction:
    """Return the direction from one model to another of the same vessels, `distance` from it in the number.

    Exact where all parts are powers or exponentials of the number; else the two models must be near to each other.

    Raises
    ------
    InputError
        Outlets without parameters, or models that differ in their vessels, in which of these change along their way or
        have viscous walls, in their junctions, or in the kind of their beds.
    """
    if not (isinstance(before.outlets, Bed) and type(before.outlets) is type(after.outlets)):
        raise InputError("derivatives need beds of one kind with parameters; an impedance spectrum has none")
    if before.network.name != after.network.name or type(before.wall) is not type(after.wall):
        raise InputError("a direction leads between two models of the same vessels and the same wall law")
    alike = (np.array_equal(getattr(before, name), getattr(after, name)) for name in ("loss", "resistance"))
    if before.total_pressure != after.total_pressure or not all(alike):
        raise InputError("a direction leads between two models with the same junctions and losses")
    if not np.array_equal(before.changing, after.changing):
        raise InputError("derivatives need vessels that change in both models or in none; take differences of models")
    if not np.array_equal(np.equal(before.wall_viscosity, 0.0), np.equal(after.wall_viscosity, 0.0)):
        raise InputError("derivatives need walls viscous in both models or in none; take differences of models")
    return Direction(before, after, distance)
