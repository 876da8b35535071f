"""The network cut into cells, and its vessels' ends tied into nodes, as flat arrays for the kernels.

Slots: every vessel owns its n cells and one ghost slot behind them, so that face j is the left face of slot j, face j+1
its right one, and one loop over all slots serves the whole network. Faces 0 and n of a vessel are its two ends.
The state of a vessel of one cell is a straight line: its ghost slot holds it a cell ahead, a second one a cell back.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from vasowave.pulse.model import walls
from vasowave.pulse.model.linear import LinearSolution
from vasowave.pulse.model.model import Model
from vasowave.pulse.network.network import Network
from vasowave.pulse.solver.changing import Changing

_STEADY_ERROR = 2e-4  # of the pressure, allowed to the fall of the mean pressure along a vessel
_FLAT = 0.05  # share of the pressure: where the mean falls by more, a vessel's middle is not the mean of its ends
_LOW = 0.1  # of the network's largest mean pressure: a lower one is not what errors are measured by
SHORTEST = 0.1  # cm: cells that nobody asked for are no shorter; they serve the lungs of mice
_CELLS_A_WAVE = 32  # of the shortest wave that matters, at least: it then runs too slowly by 0.6 % at most
_ENOUGH = 0.9  # of the known harmonics
_MATTERS = 0.003  # of the pulse: harmonics whose root sum of squares is below it do not matter
_BEND = 0.2  # change of the logarithm of a shape's radius within a cell, at most
_SIMPSON = np.array([1, 4, 2, 4, 2, 4, 2, 4, 1]) / 24  # weights of nine places


class Vessels(NamedTuple):
    """Where the vessels' slots and faces lie."""

    first: np.ndarray  # (vessel,) first cell, which is also the inlet face
    last: np.ndarray  # (vessel,) outlet face, which is also the ghost slot
    single: np.ndarray  # (short vessel,) the only cell of every straight vessel of one cell


class Ends(NamedTuple):
    """How vessel ends meet.

    Nodes are sorted by the number of their ends: junctions, then the inlets, then the terminals' outlets.
    Ends are sorted by rank: the first end of every node, then the second of those that have one, and so on. The end of
    rank r at node k is start[r] + k: ends of one rank lie side by side, as their nodes do.
    """

    start: np.ndarray  # (rank + 1,)
    inlet: int  # node of the root's inlet, before those of other inlets
    first_terminal: int  # node
    vessel: np.ndarray  # (end,)
    side: np.ndarray  # (end,) 1 at an outlet, -1 at an inlet
    face: np.ndarray  # (end,)
    cell: np.ndarray  # (end,) next to the end
    inner: np.ndarray  # (end,) the one behind it
    area0: np.ndarray  # (end,) cm²
    per_area0: np.ndarray  # (end,) 1/cm²
    half: np.ndarray  # (end,) dt/(2 dx), s/cm
    dt: np.ndarray  # (end,) s
    dynamic: bool  # whether any end has a density below
    density: np.ndarray  # (end,) ρ where the node shares the total pressure, else 0, mmHg s²/cm²
    loss: np.ndarray  # (end,) K ρ by the loss coefficient of a vessel's inlet, else 0
    viscous: np.ndarray  # (end,) what a vessel's inlet takes of pressure in proportion to the velocity, mmHg s/cm


class Cells(NamedTuple):
    """What a kernel knows of each slot, or of its left face; zero-step in ghost slots, whose state never changes."""

    per_area0: np.ndarray  # (slot,) 1/cm²
    smallest: np.ndarray  # (slot,) cm², below it the wall law ends
    largest: np.ndarray  # (slot,) cm², above it the wall law ends
    half: np.ndarray  # (slot,) dt/(2 dx), s/cm
    dt: np.ndarray  # (slot,) in which drag acts, s


@dataclass(frozen=True, eq=False)
class Grid:
    """A model on cells.

    Attributes
    ----------
    model : Model
    vessels : Vessels
    vessel : int array, shape (slot,)
        Row of the vessel that owns the slot.
    share : pair of float arrays, shape (slot,)
        Place of the slot's wall, and of that of its left face, as shares of the vessel's length.
    position : float array, shape (slot,)
        Distance of the cell's centre from the vessel's inlet, cm; NaN in slots without a state.
    spacing : float array, shape (slot,)
        Cell length dx, cm.
    wall : wall law
        Its parameters, one per slot: those of the cell's middle, in ghost slots those next to it.
    area0 : float array, shape (slot,)
        Likewise A0, cm².
    face_wall, face_area0
        The same of the left face of every slot.
    """

    model: Model
    vessels: Vessels
    vessel: np.ndarray
    share: tuple[np.ndarray, np.ndarray]
    position: np.ndarray
    spacing: np.ndarray
    wall: Any
    area0: np.ndarray
    face_wall: Any
    face_area0: np.ndarray

    @property
    def counts(self) -> np.ndarray:
        """Number of cells, shape (vessel,)."""
        return self.vessels.last - self.vessels.first

    @cached_property
    def is_cell(self) -> np.ndarray:
        """True where the slot is a cell, False where it is a ghost; shape (slot,)."""
        return (self.position > 0) & (self.position < self.model.network.length[self.vessel])

    @cached_property
    def has_state(self) -> np.ndarray:
        """True where the slot is a cell or continues the only one of its vessel; shape (slot,)."""
        return ~np.isnan(self.position)

    @property
    def joined_ends(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where each rank of ends starts, and vessel and side of every end; first come those of vessels that end."""
        return _joined_ends(self.model.network)

    def ends(self, dt: float, period: float) -> Ends:
        """Return the vessel ends' constants for the time step `dt` (s) and the period (s) of the friction."""
        start, vessel, side = self.joined_ends
        first_terminal = int(start[1]) - len(self.model.network.terminals)
        face = np.where(side > 0, self.vessels.last[vessel], self.vessels.first[vessel])
        cell = np.where(side > 0, face - 1, face)
        backward = np.where(self.counts[vessel] > 1, -1, 2)  # the slot behind the cell next to an outlet
        inner = cell + np.where(side > 0, backward, 1)
        density, loss, viscous = self._densities(vessel, side, period)
        return Ends(
            start=start.astype(np.uintp),
            inlet=first_terminal - len(self.model.network.inlets),
            first_terminal=first_terminal,
            vessel=vessel,
            side=side,
            face=face.astype(np.uintp),
            cell=cell.astype(np.uintp),
            inner=inner.astype(np.uintp),
            area0=self.face_area0[face],
            per_area0=1 / self.face_area0[face],
            half=dt / (2 * self.spacing[cell]),
            dt=np.full(len(vessel), dt),
            dynamic=self.model.dynamic,
            density=density,
            loss=loss,
            viscous=viscous,
        )

    def _densities(self, vessel: np.ndarray, side: np.ndarray, period: float) -> np.ndarray:
        """By what the ends' velocities make the dynamic pressure, and both losses between end and junction."""
        model, (start, *_) = self.model, self.joined_ends
        density, loss, viscous = by_velocity = np.zeros((3, len(vessel)))
        if model.dynamic:
            open_ends = len(model.network.inlets) + len(model.network.terminals)
            at_junction = np.r_[: start[1] - open_ends, start[1] : len(vessel)]
            density[at_junction] = model.blood.inertia * model.total_pressure
            losses = model.blood.inertia * np.broadcast_to(model.loss, len(model.network)), model.narrowing_drag(period)
            for values, of_vessel in zip((loss, viscous), losses, strict=True):
                values[at_junction] = np.where(side < 0, of_vessel[vessel], 0.0)[at_junction]
        return by_velocity

    @cached_property
    def changing(self) -> Changing | None:
        """Places of the vessels that change along their way, None where none does: the compiler leaves it out."""
        if not self.model.changing.any():
            return None
        slot = np.flatnonzero(self.model.changing[self.vessel])
        cell = slot[self.is_cell[slot]]
        single = cell[self.counts[self.vessel[cell]] == 1]
        end = np.flatnonzero(self.model.changing[self.joined_ends[1]])
        places = np.setdiff1d(cell, self.vessels.first), cell, slot, end, single
        return Changing(*(place.astype(np.int64) for place in places))

    @property
    def places(self) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
        """Where the walls of slots, their left faces and vessel ends are: vessels, and shares of their length."""
        _, vessel, side = self.joined_ends
        return (self.vessel, self.share[0]), (self.vessel, self.share[1]), (vessel, np.where(side > 0, 1.0, 0.0))

    def wall_at_ends(self) -> Any:
        """Return the wall law, its parameters one per vessel end."""
        _, vessel, side = self.joined_ends
        face = np.where(side > 0, self.vessels.last[vessel], self.vessels.first[vessel])
        return type(self.wall)(*(value[face] for value in self.face_wall))

    @cached_property
    def at_stations(self) -> tuple[Any, np.ndarray]:
        """Wall law and A0 at inlet, middle and outlet, shape (station, vessel); (vessel,) where all are straight."""
        model = self.model
        if not model.changing.any():
            return model.wall, model.area0
        rows = np.arange(len(model.network))
        return model.at(*np.broadcast_arrays(rows, np.array([[0.0], [0.5], [1.0]])))

    @cached_property
    def middle(self) -> np.ndarray:
        """A0 in the middle of vessels over the mean of that at the faces around it, shape (vessel,).

        Where a cell lies in the middle, its area is taken from its faces.
        """
        if not self.model.changing.any():
            return np.ones(len(self.counts))
        left_face = (self.vessels.first + self.vessels.last) // 2
        right_face = self.vessels.first + self.vessels.last - left_face
        return np.asarray(self.at_stations[1][1] / (0.5 * (self.face_area0[left_face] + self.face_area0[right_face])))

    def cells(self, dt: float, friction: tuple[float, float]) -> Cells:
        """Return the slots' constants for the time step `dt` (s) and the coefficients of the friction."""
        cells = self._constants(self.wall, self.area0, dt)
        if self.changing is not None:
            cells.dt[self.changing.cell] *= self.drag_along(self.model, *friction, self.changing.cell)
        return cells

    def faces(self, dt: float) -> Cells:
        """Return the same of their left faces."""
        return self._constants(self.face_wall, self.face_area0, dt)

    def _constants(self, wall: Any, area0: np.ndarray, dt: float) -> Cells:
        low, high = wall.limits(*wall)
        step = np.where(self.is_cell, dt, 0.0)
        return Cells(1 / area0, low * area0, high * area0, step / (2 * self.spacing), step)

    def drag_along(self, model: Model, k0: float, k1: float, cells: np.ndarray) -> np.ndarray:
        """Return the fall of pressure by drag along cells that change over that by the mean of their faces.

        It is that of the radii in the image of `model`, which has the vessels of this grid.
        """
        left_share, right_share = self.share[1][cells], self.share[1][cells + 1]
        share = np.linspace(left_share, right_share, len(_SIMPSON))
        A = model.image_area(np.broadcast_to(self.vessel[cells], share.shape), share)
        drag = (k0 + k1 * np.sqrt(A)) / A
        with np.errstate(divide="ignore", invalid="ignore"):  # of blood without viscosity
            factor = (A[0] + A[-1]) / (drag[0] + drag[-1]) * np.tensordot(_SIMPSON, drag / A, axes=1)
        return np.where(drag[0] > 0, factor, 1.0)


@lru_cache(maxsize=8)
def _joined_ends(network: Network) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    junctions = [[(row, 1.0) for row in junction.ending] + [(row, -1.0) for row in junction.beginning]
                 for junction in network.junctions]  # fmt: skip
    junctions.sort(key=len, reverse=True)
    nodes = [*junctions, *([(row, -1.0)] for row in network.inlets), *([(row, 1.0)] for row in network.terminals)]
    ranks = [[ends[r] for ends in nodes if len(ends) > r] for r in range(len(nodes[0]))]
    vessel, side = zip(*(end for ends in ranks for end in ends), strict=True)
    return np.cumsum([0, *map(len, ranks)]), np.array(vessel), np.array(side)


def make_grid(model: Model, counts: np.ndarray) -> Grid:
    """Cut every vessel into the given number of equal cells."""
    network = model.network
    slots = np.where(counts > 1, counts + 1, 3)
    first = np.concatenate([[0], np.cumsum(slots)[:-1]])
    vessel = np.repeat(np.arange(len(network)), slots)
    number = np.arange(slots.sum()) - first[vessel]
    spacing = (network.length / counts)[vessel]
    position = np.where(number < counts[vessel], (number + 0.5) * spacing, np.nan)
    single = first[counts == 1]
    position[single + 1], position[single + 2] = 1.5 * spacing[single], -0.5 * spacing[single]
    plain = single[~model.changing[vessel[single]]]
    cell_count = counts[vessel]
    middle = np.where(number < cell_count, number + 0.5, cell_count - 0.5) / cell_count
    share = middle, np.where(number <= cell_count, number / cell_count, middle)
    middles = model.at(vessel, share[0])
    lefts = model.at(vessel, share[1]) if model.changing.any() else middles
    return Grid(model, Vessels(first, first + counts, plain), vessel, share, position, spacing, *middles, *lefts)


def cell_counts(model: Model, cell_size: float | None, linear: LinearSolution, longer: float = 1.0) -> np.ndarray:
    """Return the number of cells of every vessel.

    Cells are at most `cell_size` (cm) or, without one, a share of the shortest wave length that matters; with `longer`,
    that many times as long. They are so many that the mean flow of the linear solution loses the right pressure to
    drag: where a thin vessel takes most of the pressure, one would not follow its fall. Without a `cell_size` they also
    follow how a shape changes along a vessel.
    """
    return counts_by_length(model, cell_size, linear)(longer)


def counts_by_length(model: Model, cell_size: float | None, linear: LinearSolution) -> Callable[[float], np.ndarray]:
    """Return `cell_counts` as a function of how many times longer the cells may be."""
    inlet = linear.pressure[0].real
    outlet = inlet - linear.resistance * model.network.length * linear.flow[0].real
    by_waves = wave_cells(linear) if cell_size is None else cell_size
    level = np.maximum(np.abs(inlet), np.abs(outlet))
    level = np.maximum(level, _LOW * np.max(level, initial=1e-300))
    flat = np.abs(inlet - outlet) <= _FLAT * level
    for_drag = 0.5 * np.sqrt(_error_of_one_cell(model, inlet, outlet, level, linear.period) / _STEADY_ERROR)
    for_drag = np.where(flat & (for_drag <= 0.5), 1, 2 * np.maximum(1, np.ceil(for_drag)))  # even: a face in the middle

    def counts(longer: float) -> np.ndarray:
        size = longer * by_waves if cell_size is not None else np.maximum(SHORTEST, longer * by_waves)
        count = np.maximum(np.ceil(model.network.length / size - 1e-9), for_drag)
        if model.profile is not None and cell_size is None:
            by_shape = model.profile.pieces * np.ceil(model.profile.bend / (_BEND * longer))
            count = np.where(model.changing, np.maximum(count, by_shape), count)
        return aligned(model, count)

    return counts


def aligned(model: Model, count: np.ndarray) -> np.ndarray:
    """Return so many cells or a few more, so that faces lie where a shape has a point, and in the middle of a vessel.

    Where the radius bends within a cell, the scheme is of first order.
    """
    count = np.where(model.stiffening, 2 * np.ceil(count / 2), count)
    if model.profile is not None and model.profile.pieces > 1:
        multiple = math.lcm(2, model.profile.pieces)
        count = np.where(model.changing, multiple * np.ceil(count / multiple), count)
    return count.astype(np.int64)


def wave_cells(linear: LinearSolution) -> np.ndarray:
    """Return how long the cells of every vessel may be, cm, shape (vessel,): 0.1 times a power of two.

    That is a share of 2π/|γ| of the highest harmonic that matters: a wave length or, where drag governs, the length in
    which the pressure falls.
    """
    power = np.max(np.abs(linear.pressure[1:]) ** 2, axis=1)
    above = np.sqrt(np.cumsum(power[::-1])[::-1])  # of all harmonics from each on
    highest = max(1, int(np.sum(above > _MATTERS * above[0])))
    if highest > _ENOUGH * len(power):  # shorter ones are not among those that are known
        return np.full(len(linear.length), SHORTEST)
    change = np.max([np.abs(line.propagation[highest]) for line in linear.lines], axis=0)
    doubled = np.floor(np.log2(2 * np.pi / _CELLS_A_WAVE / change / SHORTEST))
    return np.asarray(SHORTEST * 2.0 ** np.maximum(doubled, 0.0))


def _error_of_one_cell(
    model: Model, inlet: np.ndarray, outlet: np.ndarray, level: np.ndarray, period: float
) -> np.ndarray:
    """Error that one cell would make in the steady fall of pressure along each vessel, as a share of `level`."""
    p = outlet + np.linspace(0.0, 1.0, 9)[:, np.newaxis] * (inlet - outlet)
    lowest = -0.5 * np.asarray(walls.stiffness(model.wall))  # a guess below it is no guess
    A = np.asarray(walls.area(model.wall, np.maximum(p, lowest), model.area0))
    k0, k1 = model.blood.friction.coefficients(model.blood.viscosity, period)
    drag = (k0 + k1 * np.sqrt(A)) / A  # the fall per length is proportional to drag/A
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = (drag[0] + drag[-1]) / (A[0] + A[-1]) * np.tensordot(_SIMPSON, A / drag, axes=1)
        error = np.abs((ratio - 1) * (inlet - outlet) / level)
    return np.where(np.isfinite(error), np.minimum(error, 1.0), 0.0)
