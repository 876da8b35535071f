"""Cycles of a finished run with changes beside them: what `stepper` is for the linearized scheme."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from vasowave.base.errors import InputError, NumericalError
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.ventricle import Driven, Ventricle
from vasowave.pulse.solver.beds import Pulsation, PulsationTangent, bed_steps
from vasowave.pulse.solver.cells import Faces, FluidConstants
from vasowave.pulse.solver.changing import Changing, make_changing_tangent
from vasowave.pulse.solver.direction import Direction
from vasowave.pulse.solver.node_variations import EndChanges, EndSlopes, OutletChanges
from vasowave.pulse.solver.result import Run
from vasowave.pulse.solver.scheme import RecordChanges, SlotStates, StepArguments, Tangent, Walls
from vasowave.pulse.solver.start import at_rest
from vasowave.pulse.solver.state import State
from vasowave.pulse.solver.stepper import Stepper, make_pulsation
from vasowave.pulse.solver.variations import SHIFT, Slopes, Stencil, Weights
from vasowave.pulse.solver.varied_cycle import varied_cycle_kernel
from vasowave.pulse.solver.viscosity import Viscous, ViscousTangent

_APART = 1e-5  # relative, of the central differences of what beds do in one step


class VariedStepper:
    """Runs cycles of the changes in all directions beside those of a finished run; owns the scratch memory."""

    def __init__(
        self, run: Run, inflow: Driven, directions: Sequence[Direction], faces: Sequence[int] | np.ndarray = ()
    ) -> None:
        if isinstance(inflow, Ventricle):
            raise InputError("derivatives of a network behind a ventricle are not known; give the flow into it")
        self.run: Run = run
        self.stepper: Stepper = Stepper(run.grid, inflow, Numerics(samples=1), run.steps)
        scheme, slots = self.stepper.scheme, len(run.grid.vessel)
        count, nodes, rows = len(scheme.ends.face), int(scheme.ends.start[1]), len(run.grid.wall) + 1
        self.weights: tuple[Weights, ...] = _weights(directions, run.grid.places)
        changed = int(self.weights[0].rows.max())
        self.terms: tuple[Any, ...] = tuple(self._tangent_of(term, directions, rows) for term in self.stepper.terms)
        watched = np.asarray(faces, dtype=np.uintp)
        waves = np.zeros((len(run.at_inlet), len(directions), run.steps, len(watched)))
        self.records: RecordChanges = RecordChanges(watched, waves, np.zeros((len(directions), run.steps)))
        self.tangent: Tangent = Tangent(
            Faces(run.end.area, run.end.flow),
            Walls(*map(_beside, scheme.walls)),
            _outlet_changes(run, directions),
            self.weights[0],
            self.weights[1],
            self.weights[2],
            _ones(Slopes, [*4 * [(slots,)], (rows, slots)]),
            _ones(Slopes, [*4 * [(slots,)], (rows, slots)]),
            _ones(Stencil, [*10 * [(slots,)], (changed, slots)]),
            _ones(Stencil, [*10 * [(slots,)], (changed, slots)]),
            _ones(EndSlopes, [*15 * [(count,)], *2 * [(rows, count)], (nodes,)]),
            _ones(EndChanges, [*3 * [(count,)], *2 * [(nodes,)]]),
            Faces(*np.zeros((2, slots))),
            self.records,
        )

    def _tangent_of(self, term: Any, directions: Sequence[Direction], rows: int) -> Any:
        """Return the tangent of a term in these directions."""
        grid = self.run.grid
        if isinstance(term, Changing):
            drags = _drags(grid, directions, self.stepper.fluid)
            return make_changing_tangent(term, rows, len(grid.vessel), drags)
        if isinstance(term, Viscous):
            viscosities = np.array([direction.wall_viscosity[grid.vessel] for direction in directions])
            return ViscousTangent(term, viscosities, *np.zeros((3, len(grid.vessel))))
        if isinstance(term, Pulsation):
            return PulsationTangent(term, _moved_behind(self.run, directions))
        raise NumericalError(f"derivatives of '{type(term).__name__}' are not known: give its tangent here")

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
        watched_waves = np.moveaxis(self.records.waves, 1, 0).reshape(len(self.records.inlet), -1)
        return np.concatenate([self.records.inlet, watched_waves], axis=1)

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
        changed = SlotStates(*(np.array([getattr(change, name) for change in changes]) for name in SlotStates._fields))
        at_start = SlotStates(state.area, state.flow, state.memory)
        step = StepArguments(stepper.inflow, at_start, stepper.scheme, stepper.half, stepper.records)
        kernel = varied_cycle_kernel(type(stepper.grid.wall), tuple(map(type, self.terms)))
        outlets = self.tangent.outlets._replace(memory=changed.memory)
        kernel(step, self.terms, self.tangent._replace(changed=Faces(*changed[:2]), outlets=outlets))
        return state, np.array([scale.vector(State(*change)) for change in zip(*changed, strict=True)])


def _ones(kind: Any, shapes: Sequence[tuple[int, ...]]) -> Any:
    return kind(*map(np.ones, shapes))


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


def _drags(grid: Any, directions: Sequence[Direction], fluid: FluidConstants) -> np.ndarray:
    """Return the relative changes of the drag along cells, shape (direction, slot)."""
    drags, cells = np.zeros((len(directions), len(grid.vessel))), grid.changing.cell
    for row, direction in zip(drags, directions, strict=True):
        row[cells] = direction.relative(lambda model: grid.drag_along(model, fluid.k0, fluid.k1, cells))
    return drags


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
            make_pulsation(model.changed(outlets=beds.moved(side * _APART * direction.outlets)), run.steps, run.period)
            for side in (1, -1)
        )
        assert up is not None
        assert down is not None
        changes.append((up.pressure - down.pressure) / (2 * _APART))
    return np.array(changes)


def _outlet_changes(run: Run, directions: Sequence[Direction]) -> OutletChanges:
    """Return how the beds' steps change, by differences of their fields."""
    beds: Any = run.model.outlets
    dt, changes = run.period / run.steps, []
    for direction in directions:
        moved = (beds.moved(side * _APART * direction.outlets).rational(run.period, beds) for side in (1, -1))
        up, down = (bed_steps(rational, dt, run.model.outlet_pressure)[:-1] for rational in moved)
        changes.append([(a - b) / (2 * _APART) for a, b in zip(up, down, strict=True)])
    memory = run.end.memory
    decay_half, decay, gain_half, gain, resistance = (np.array(value) for value in zip(*changes, strict=True))
    return OutletChanges(decay_half, decay, gain_half, gain, resistance, memory, np.zeros_like(memory))
