"""Waves at places along vessels: at shares of their length, between the faces of the cells that lie beside."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vasowave.pulse.model import walls
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.ventricle import Driven
from vasowave.pulse.solver.direction import Direction
from vasowave.pulse.solver.grid import Grid
from vasowave.pulse.solver.result import Run, with_viscous
from vasowave.pulse.solver.stepper import Stepper

QUANTITIES = ("pressure", "flow", "velocity", "area", "diameter")
"""What can be seen at a place."""


@dataclass(frozen=True, eq=False)
class Places:
    """Places in vessels.

    Attributes
    ----------
    vessel : int array, shape (place,)
        Rows.
    share : float array, shape (place,)
        Of the vessels' lengths, from the inlet.
    """

    vessel: np.ndarray
    share: np.ndarray

    def faces(self, grid: Grid) -> tuple[np.ndarray, np.ndarray]:
        """Return the faces before and after each place, shape (2, place), and how far it is between them, (place,)."""
        count = grid.counts[self.vessel]
        before = np.minimum((self.share * count).astype(np.int64), count - 1)
        first = grid.vessels.first[self.vessel] + before
        return np.array([first, first + 1]), self.share * count - before


class Waves(NamedTuple):
    """Waves at places.

    Attributes
    ----------
    pressure, flow, area : array, shape (..., place)
        mmHg, ml/s, cm².
    """

    pressure: np.ndarray
    flow: np.ndarray
    area: np.ndarray

    def of(self, quantity: str) -> np.ndarray:
        """Return one of `QUANTITIES`, of the same shape; velocity in cm/s, diameter in cm."""
        if quantity == "velocity":
            return self.flow / self.area
        if quantity == "diameter":
            return 2.0 * np.sqrt(self.area / np.pi)
        return np.asarray(getattr(self, quantity))

    def changed(self, quantity: str, changes: "Waves") -> np.ndarray:
        """Return the derivative of one of `QUANTITIES` where these are the derivatives of the waves."""
        if quantity == "velocity":
            return (changes.flow - changes.area * self.flow / self.area) / self.area
        if quantity == "diameter":
            return changes.area / np.sqrt(np.pi * self.area)
        return np.asarray(getattr(changes, quantity))


def waves_at(run: Run, inflow: Driven, places: Places) -> Waves:
    """Return the waves of a periodic run at places, shape (step, place), from one more cycle of it."""
    faces, between = places.faces(run.grid)
    stepper = Stepper(run.grid, inflow, Numerics(samples=1), run.steps, faces.ravel())
    stepper.cycle(run.end)
    watched_waves = stepper.watched_waves[:, :, -faces.size :]
    area, flow = watched_waves[:2]
    wall = type(run.grid.wall)(*(value[faces.ravel()] for value in run.grid.face_wall))
    pressure = np.asarray(walls.pressure(wall, area, run.grid.face_area0[faces.ravel()]))
    waves = with_areas(run.model, places, at_places(pressure, between), at_places(flow, between))
    return waves._replace(pressure=with_viscous(waves.pressure, at_places(watched_waves, between)))


def at_places(at_faces: np.ndarray, between: np.ndarray) -> np.ndarray:
    """Return what is between two faces, shape (..., place), from (..., 2 · place)."""
    before, after = np.split(at_faces, 2, axis=-1)
    return (1 - between) * before + between * after


def with_areas(model: Model, places: Places, pressure: np.ndarray, flow: np.ndarray) -> Waves:
    """Return waves whose areas are those of the walls' laws at these pressures, mmHg, shape (..., place)."""
    wall, area0 = model.at(places.vessel, places.share)
    return Waves(pressure, flow, np.asarray(walls.area(wall, pressure, area0)))


def area_changes(
    directions: Sequence[Direction], model: Model, places: Places, pressure: np.ndarray, changes: np.ndarray
) -> np.ndarray:
    """Return the derivatives of the areas, cm², shape (direction, step, place), from those of the laws' pressures."""
    wall, area0 = model.at(places.vessel, places.share)
    soft = np.asarray(walls.area_compliance(wall, pressure, area0)) * changes
    for row, direction in zip(soft, directions, strict=True):
        row += with_areas(direction.after, places, pressure, 0.0 * pressure).area / direction.distance
        row -= with_areas(direction.before, places, pressure, 0.0 * pressure).area / direction.distance
    return soft
