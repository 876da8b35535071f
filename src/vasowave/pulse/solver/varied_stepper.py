"""Cycles of a finished run with changes beside them: what `stepper` is for the linearized scheme."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.ventricle import Driven, Ventricle
from vasowave.pulse.solver.beds import bed_steps
from vasowave.pulse.solver.cells import FluidConstants, Fluxes
from vasowave.pulse.solver.changing_variations import Carried, Carrying
from vasowave.pulse.solver.direction import Direction
from vasowave.pulse.solver.grid import Changing, Grid
from vasowave.pulse.solver.node_variations import EndChanges, EndSlopes, OutletChanges
from vasowave.pulse.solver.result import Run
from vasowave.pulse.solver.start import at_rest
from vasowave.pulse.solver.state import State
from vasowave.pulse.solver.stepper import Stepper, behind_in_time
from vasowave.pulse.solver.variations import SHIFT, Slopes, Stencil, Weights
from vasowave.pulse.solver.varied_cycle import varied_cycle_kernel
from vasowave.pulse.solver.viscosity import Viscous
from vasowave.pulse.solver.viscosity_variations import ViscousChanges

_APART = 1e-5  # relative, of the central differences of what beds do in one step


class VariedStepper:
    """Runs cycles of the changes in all directions beside those of a finished run; owns the scratch memory."""

    def __init__(
        self, run: Run, inflow: Driven, directions: Sequence[Direction], faces: Sequence[int] | np.ndarray = ()
    ) -> None:
        if isinstance(inflow, Ventricle):
            raise InputError("derivatives of a network behind a ventricle are not known; give the flow into it")
        self.run, self.stepper = run, Stepper(run.grid, inflow, Numerics(samples=1), run.steps)
        ends, vessel = self.stepper.parts[3], run.grid.vessel
        self.weights = _weights(directions, run.grid.places)
        self.drags = _drags(run.grid, directions, self.stepper.fluid)
        self.outlets = _outlet_changes(run, directions)
        self.behind = None if self.stepper.behind is None else (self.stepper.behind, _moved_behind(run, directions))
        self.shifted = tuple(map(_beside, self.stepper.law))
        slots, count, nodes = len(vessel), len(ends.face), int(ends.start[1])
        rows, changed = len(run.grid.wall) + 1, int(self.weights[0].rows.max())
        self.base = *self.stepper.scratch, Fluxes(*np.ones((3, slots)))
        self.scratch = (
            _ones(Slopes, [*4 * [(slots,)], (rows, slots)]),
            _ones(Slopes, [*4 * [(slots,)], (rows, slots)]),
            _ones(Stencil, [*10 * [(slots,)], (changed, slots)]),
            _ones(Stencil, [*10 * [(slots,)], (changed, slots)]),
            _ones(EndSlopes, [*15 * [(count,)], *2 * [(rows, count)], (nodes,)]),
            _ones(EndChanges, [*3 * [(count,)], *2 * [(nodes,)]]),
            _carrying(run.grid.changing, rows, slots),
            np.zeros(slots),
            np.zeros(slots),
            np.zeros_like(run.end.memory),
        )
        self.viscous = _viscous_changes(self.stepper.viscous, run.grid, directions)
        self.watched = np.asarray(faces, dtype=np.uintp)
        self.inlet = np.zeros((len(directions), run.steps))
        self.watched_waves = np.zeros((len(run.at_inlet), len(directions), run.steps, len(self.watched)))

    @property
    def size(self) -> int:
        """Number of variables of a state."""
        return len(self.run.scale.vector(self.run.end))

    def cycle(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the changes at the end of a cycle for those at its start, and the `output`.

        Shapes (direction, variable) and (direction, value).
        """
        return self._cycle(self.run.end, x)[1], self.output

    @property
    def output(self) -> np.ndarray:
        """Changes in the last cycle, a row each direction: inlet pressure (mmHg) by step, then by kind, step and face.

        The kinds are pressure (mmHg) of the law, flow (ml/s) and, where walls are viscous, viscous pressure.
        """
        watched_waves = np.moveaxis(self.watched_waves, 1, 0).reshape(len(self.inlet), -1)
        return np.concatenate([self.inlet, watched_waves], axis=1)

    def from_rest(self, count: int) -> np.ndarray:
        """Return the `output` in the last of `count` cycles from rest."""
        state, scale = at_rest(self.run.grid, self.stepper.beds), self.run.scale
        wider = [State(state.area * row[-1], state.flow, state.memory) for row in self.weights[0].wall]
        x = np.array([scale.vector(change) for change in wider])
        for _ in range(count):
            state, x = self._cycle(state, x)
        return self.output

    def _cycle(self, start: State, x: np.ndarray) -> tuple[State, np.ndarray]:
        stepper, scale = self.stepper, self.run.scale
        state = State(start.area.copy(), start.flow.copy(), start.memory.copy())
        changes = [scale.change(row) for row in x]
        changed = tuple(
            np.array([getattr(state_change, name) for state_change in changes]) for name in ("area", "flow", "memory")
        )
        varied_cycle_kernel(type(stepper.grid.wall))(
            (state.area, state.flow, state.memory), changed, stepper.inflow, self.behind, stepper.law, self.shifted,
            stepper.outlets, self.outlets, stepper.parts, stepper.grid.changing,
            (*self.weights, self.drags), stepper.fluid, self.base, self.scratch, self.viscous,
            self.watched, self.inlet, self.watched_waves,
        )  # fmt: skip
        return state, np.array([scale.vector(State(*change)) for change in zip(*changed, strict=True)])


def _ones(kind: Any, shapes: Sequence[tuple[int, ...]]) -> Any:
    return kind(*map(np.ones, shapes))


def _carrying(changing: Changing | None, rows: int, slots: int) -> Carrying | None:
    if changing is None:
        return None
    places = changing.face, changing.end, changing.end, changing.single, changing.single
    carried = (_ones(Carried, [(len(place),), (len(place),), (rows, len(place))]) for place in places)
    gains = (np.ones(len(changing.end)) for _ in range(3))
    return Carrying(*carried, *gains, np.ones((2, slots)), np.ones((5, slots)), np.ones(slots))  # type: ignore[call-arg]


def _weights(directions: Sequence[Direction], places: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[Weights, ...]:
    """Return the directions' relative changes at slots, faces and ends: vessels, and shares of their lengths."""
    walls = [np.array([direction.walls(*place) for direction in directions]) for place in places]
    lengths = np.array([direction.length for direction in directions])
    varies = np.any([np.any(wall, axis=2) for wall in walls], axis=0)
    rows = np.array([max((k + 1 for k, varied in enumerate(flags) if varied), default=0) for flags in varies])
    lengthens = np.any(lengths, axis=1)
    return tuple(
        Weights(np.ascontiguousarray(wall), np.ascontiguousarray(lengths[:, vessel]), rows, lengthens)
        for wall, (vessel, _) in zip(walls, places, strict=True)
    )


def _drags(grid: Grid, directions: Sequence[Direction], fluid: FluidConstants) -> np.ndarray:
    """Return the relative changes of the drag along cells, shape (direction, slot); 0 where no vessel changes."""
    drags = np.zeros((len(directions), len(grid.vessel)))
    if grid.changing is not None:
        cells = grid.changing.cell
        for row, direction in zip(drags, directions, strict=True):
            row[cells] = direction.relative(lambda model: grid.drag_along(model, fluid.k0, fluid.k1, cells))
    return drags


def _viscous_changes(viscous: Viscous | None, grid: Grid, directions: Sequence[Direction]) -> ViscousChanges | None:
    if viscous is None:
        return None
    viscosities = np.array([direction.wall_viscosity[grid.vessel] for direction in directions])
    return ViscousChanges(viscous, viscosities, *np.zeros((3, len(grid.vessel))))


def _beside(wall: Any) -> tuple[tuple[Any, Any], ...]:
    """Return the wall with each of its parameters a little larger, and a little smaller."""

    def shifted(k: int, factor: float) -> Any:
        return type(wall)(*(value * factor if i == k else value for i, value in enumerate(wall)))

    return tuple((shifted(k, 1 + SHIFT), shifted(k, 1 - SHIFT)) for k in range(len(wall)))


def _moved_behind(run: Run, directions: Sequence[Direction]) -> np.ndarray:
    """Return how what stands before the beds of the pressure behind them changes, shape (direction, step, terminal)."""
    model, changes = run.model, []
    beds: Any = model.outlets
    for direction in directions:
        up, down = (
            behind_in_time(model.changed(outlets=beds.moved(side * _APART * direction.outlets)), run.steps, run.period)
            for side in (1, -1)
        )
        changes.append((up - down) / (2 * _APART))
    return np.array(changes)


def _outlet_changes(run: Run, directions: Sequence[Direction]) -> OutletChanges:
    """Return how the beds' steps change, by differences of their fields."""
    beds: Any = run.model.outlets
    dt, changes = run.period / run.steps, []
    for direction in directions:
        moved = (beds.moved(side * _APART * direction.outlets).rational(run.period, beds) for side in (1, -1))
        up, down = (bed_steps(rational, dt, run.model.outlet_pressure)[:-1] for rational in moved)
        changes.append([(a - b) / (2 * _APART) for a, b in zip(up, down, strict=True)])
    return OutletChanges(*(np.array(value) for value in zip(*changes, strict=True)))
