"""The network cut into cells, and its vessels' ends tied into nodes, as flat arrays for the kernels.

Slots: every vessel owns its n cells and one ghost slot behind them, so that face j is the left face of slot j, face j+1
its right one, and one loop over all slots serves the whole network. Faces 0 and n of a vessel are its two ends.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from vasowave.model import Model
from vasowave.outlets import Windkessel
from vasowave.solver.laws import ConvolutionSteps, WindkesselSteps

FEWEST_CELLS = 2  # the foot of a characteristic is extrapolated from the two cells next to an end


class Nodes(NamedTuple):
    """How vessel ends meet. `daughter` lists the daughters of all junctions; junction k owns start[k] … start[k+1]."""

    first: np.ndarray  # (vessel,) first cell, which is also the inlet face
    last: np.ndarray  # (vessel,) outlet face, which is also the ghost slot
    root: np.ndarray  # (1,) row of the root vessel
    parent: np.ndarray  # (junction,)
    start: np.ndarray  # (junction + 1,)
    daughter: np.ndarray
    terminal: np.ndarray  # (terminal,)


class Cells(NamedTuple):
    """What a kernel knows of each slot; all zero-step in ghost slots, whose state therefore never changes."""

    area0: np.ndarray  # (slot,) cm²
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
    nodes : Nodes
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
    nodes: Nodes
    vessel: np.ndarray
    position: np.ndarray
    spacing: np.ndarray
    wall: Any

    @property
    def is_cell(self) -> np.ndarray:
        """True where the slot is a cell, False where it is a ghost; shape (slot,)."""
        return ~np.isnan(self.position)

    def cells(self, dt: float) -> Cells:
        """Return the slots' constants for the time step `dt` (s)."""
        area0 = self.model.network.area0[self.vessel]
        low, high = self.wall.limits(*self.wall)
        step = np.where(self.is_cell, dt, 0.0)
        return Cells(area0, low * area0, high * area0, step / (2 * self.spacing), step)

    def outlets(self, steps: int, period: float) -> WindkesselSteps | ConvolutionSteps:
        """Return the outlets' response over one of `steps` steps a cycle."""
        outlets = self.model.outlets
        if isinstance(outlets, Windkessel):
            R1, R2, C = (np.asarray(value) for value in outlets)
            half, whole = np.exp(-period / steps / (2 * R2 * C)), np.exp(-period / steps / (R2 * C))
            return WindkesselSteps(half, whole, R2 * (1 - half), R2 * (1 - whole), np.array(R1))
        Z = outlets.impedance_at_harmonics(steps // 2 + 1)
        return ConvolutionSteps(np.ascontiguousarray(np.fft.irfft(Z, steps, axis=0).T))

    def memory_length(self, steps: int) -> int:
        """Return how many numbers a terminal remembers: a capacitor pressure, or the flow of one cycle."""
        return 1 if isinstance(self.model.outlets, Windkessel) else steps


def make_grid(model: Model, cell_size: float) -> Grid:
    """Cut every vessel into equal cells of at most `cell_size` (cm), at least two a vessel."""
    network = model.network
    count = np.maximum(FEWEST_CELLS, np.ceil(network.length / cell_size - 1e-9).astype(np.int64))
    slots = count + 1
    first = np.concatenate([[0], np.cumsum(slots)[:-1]])
    vessel = np.repeat(np.arange(len(network)), slots)
    number = np.arange(slots.sum()) - first[vessel]
    spacing = (network.length / count)[vessel]
    position = np.where(number < count[vessel], (number + 0.5) * spacing, np.nan)
    wall = type(model.wall)(*(np.array(value[vessel]) for value in model.wall))
    junctions = [row for row, daughters in enumerate(network.daughters) if daughters]
    widths = [len(network.daughters[row]) for row in junctions]
    nodes = Nodes(
        first=first,
        last=first + count,
        root=np.array([network.root]),
        parent=np.array(junctions, dtype=np.int64),
        start=np.concatenate([[0], np.cumsum(widths)]).astype(np.int64),
        daughter=np.array([d for row in junctions for d in network.daughters[row]], dtype=np.int64),
        terminal=np.array(network.terminals, dtype=np.int64),
    )
    return Grid(model, nodes, vessel, position, spacing, wall)
