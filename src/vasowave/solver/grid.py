"""The network cut into cells, and its vessels' ends tied into nodes, as flat arrays for the kernels.

Slots: every vessel owns its n cells and one ghost slot behind them, so that face j is the left face of slot j, face j+1
its right one, and one loop over all slots serves the whole network. Faces 0 and n of a vessel are its two ends.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from vasowave import walls
from vasowave.linear import LinearSolution
from vasowave.model import Model

_STEADY_ERROR = 2e-4  # of the pressure, allowed to the fall of the mean pressure along a vessel
FEWEST_CELLS = 2  # the foot of a characteristic is extrapolated from the two cells next to an end


class Vessels(NamedTuple):
    """Where the vessels' slots and faces lie."""

    first: np.ndarray  # (vessel,) first cell, which is also the inlet face
    last: np.ndarray  # (vessel,) outlet face, which is also the ghost slot


class Ends(NamedTuple):
    """How vessel ends meet: they are sorted by node, and node k owns ends start[k] … start[k+1].

    Node 0 is the inlet of the root; then come the junctions, the parent's end first; then the terminals' outlets.
    """

    start: np.ndarray  # (node + 1,)
    terminal_node: np.ndarray  # (terminal,)
    vessel: np.ndarray  # (end,)
    node: np.ndarray  # (end,)
    side: np.ndarray  # (end,) 1 at an outlet, -1 at an inlet
    face: np.ndarray  # (end,)
    cell: np.ndarray  # (end,) next to the end
    inner: np.ndarray  # (end,) the one behind it
    area0: np.ndarray  # (end,) cm²
    half: np.ndarray  # (end,) dt/(2 dx), s/cm
    dt: np.ndarray  # (end,) s


class Cells(NamedTuple):
    """What a kernel knows of each slot; all zero-step in ghost slots, whose state therefore never changes."""

    per_area0: np.ndarray  # (slot,) 1/cm²
    smallest: np.ndarray  # (slot,) cm², below it the wall law ends
    largest: np.ndarray  # (slot,) cm², above it the wall law ends
    half: np.ndarray  # (slot,) dt/(2 dx), s/cm
    dt: np.ndarray  # (slot,) s


@dataclass(frozen=True, eq=False)
class Grid:
    """A model on cells.

    Attributes
    ----------
    model : Model
    vessels : Vessels
    vessel : int array, shape (slot,)
        Row of the vessel that owns the slot.
    position : float array, shape (slot,)
        Distance of the cell's centre from the vessel's inlet, cm; NaN in ghost slots.
    spacing : float array, shape (slot,)
        Cell length dx, cm.
    wall : wall law
        Its parameters, one per slot.
    """

    model: Model
    vessels: Vessels
    vessel: np.ndarray
    position: np.ndarray
    spacing: np.ndarray
    wall: Any

    @property
    def counts(self) -> np.ndarray:
        """Number of cells, shape (vessel,)."""
        return self.vessels.last - self.vessels.first

    @property
    def is_cell(self) -> np.ndarray:
        """True where the slot is a cell, False where it is a ghost; shape (slot,)."""
        return ~np.isnan(self.position)

    @cached_property
    def _ends(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Number of ends of every node, and vessel and side of every end."""
        network = self.model.network
        junctions = [row for row, daughters in enumerate(network.daughters) if daughters]
        meeting = [[row, *network.daughters[row]] for row in junctions]
        count = [1, *map(len, meeting), *[1] * len(network.terminals)]
        vessel = [network.root, *(row for rows in meeting for row in rows), *network.terminals]
        sides = [[1.0, *[-1.0] * (len(rows) - 1)] for rows in meeting]
        side = [-1.0, *(sign for signs in sides for sign in signs), *[1.0] * len(network.terminals)]
        return np.array(count), np.array(vessel), np.array(side)

    def ends(self, dt: float) -> Ends:
        """Return the vessel ends' constants for the time step `dt` (s)."""
        count, vessel, side = self._ends
        nodes, beds = len(count), len(self.model.network.terminals)
        face = np.where(side > 0, self.vessels.last[vessel], self.vessels.first[vessel])
        cell = np.where(side > 0, face - 1, face)
        inner = cell - side.astype(np.int64)
        return Ends(
            start=np.concatenate([[0], np.cumsum(count)]),
            terminal_node=np.arange(nodes - beds, nodes),
            vessel=vessel,
            node=np.repeat(np.arange(nodes), count).astype(np.uintp),
            side=side,
            face=face.astype(np.uintp),
            cell=cell.astype(np.uintp),
            inner=inner.astype(np.uintp),
            area0=self.model.area0[vessel],
            half=dt / (2 * self.spacing[cell]),
            dt=np.full(len(vessel), dt),
        )

    def wall_at_ends(self) -> Any:
        """Return the wall law, its parameters one per vessel end."""
        return type(self.wall)(*(value[self.vessels.first[self._ends[1]]] for value in self.wall))

    def cells(self, dt: float) -> Cells:
        """Return the slots' constants for the time step `dt` (s)."""
        area0 = self.model.area0[self.vessel]
        low, high = self.wall.limits(*self.wall)
        step = np.where(self.is_cell, dt, 0.0)
        return Cells(1 / area0, low * area0, high * area0, step / (2 * self.spacing), step)


def make_grid(model: Model, counts: np.ndarray) -> Grid:
    """Cut every vessel into the given number of equal cells."""
    network = model.network
    slots = counts + 1
    first = np.concatenate([[0], np.cumsum(slots)[:-1]])
    vessel = np.repeat(np.arange(len(network)), slots)
    number = np.arange(slots.sum()) - first[vessel]
    spacing = (network.length / counts)[vessel]
    position = np.where(number < counts[vessel], (number + 0.5) * spacing, np.nan)
    wall = type(model.wall)(*(np.array(value[vessel]) for value in model.wall))
    return Grid(model, Vessels(first, first + counts), vessel, position, spacing, wall)


def cell_counts(model: Model, cell_size: float, steady: LinearSolution) -> np.ndarray:
    """Return the number of cells of every vessel.

    Cells are at most `cell_size` (cm), at least two, and so many that the mean flow of the linear solution loses the
    right pressure to drag: where a thin vessel takes most of the pressure, two would not follow its fall.
    """
    count = np.ceil(model.network.length / cell_size - 1e-9)
    for_drag = 2 * np.ceil(
        0.5 * np.sqrt(_error_of_one_cell(model, steady) / _STEADY_ERROR)
    )  # even: a face in the middle
    return np.maximum(FEWEST_CELLS, np.maximum(count, for_drag)).astype(np.int64)


def _error_of_one_cell(model: Model, steady: LinearSolution) -> np.ndarray:
    """Error that one cell would make in the steady fall of pressure along each vessel, as a share of the pressure."""
    inlet = steady.pressure[0].real
    outlet = inlet - steady.resistance * model.network.length * steady.flow[0].real
    p = outlet + np.linspace(0.0, 1.0, 9)[:, np.newaxis] * (inlet - outlet)
    A = np.asarray(walls.area(model.wall, np.maximum(p, 0.0), model.area0))
    k0, k1 = model.blood.friction.coefficients(model.blood.viscosity, steady.period)
    drag = (k0 + k1 * np.sqrt(A)) / A  # the fall per length is proportional to drag/A
    simpson = np.array([1, 4, 2, 4, 2, 4, 2, 4, 1]) / 24
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = (drag[0] + drag[-1]) / (A[0] + A[-1]) * np.tensordot(simpson, A / drag, axes=1)
        error = np.abs((ratio - 1) * (inlet - outlet) / np.maximum(inlet, outlet))
    return np.where(np.isfinite(error), np.minimum(error, 1.0), 0.0)
