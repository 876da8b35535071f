"""Exact derivatives of a run's inlet pressure by whatever its model is made of."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from vasowave.errors import NumericalError
from vasowave.model import Model
from vasowave.outlets import Windkessel
from vasowave.recording import Inflow
from vasowave.solver.cells import Fluxes
from vasowave.solver.grid import Grid
from vasowave.solver.laws import outlet_steps
from vasowave.solver.node_variations import EndChanges, EndSlopes, OutletChanges
from vasowave.solver.numerics import Numerics
from vasowave.solver.result import Run
from vasowave.solver.state import Scale, State
from vasowave.solver.stepper import Stepper
from vasowave.solver.varied_cycle import varied_cycle_kernel
from vasowave.solver.variations import SHIFT, Changes, FaceSlopes, Slopes, Weights


class Direction(NamedTuple):
    """A relative change of a model: derivatives of the logarithms of its parts by one number."""

    wall: np.ndarray  # (parameter, vessel)
    area0: np.ndarray  # (vessel,)
    length: np.ndarray  # (vessel,)
    outlets: np.ndarray  # (3, terminal) of R1, R2 and C


def direction(before: Model, after: Model, apart: float) -> Direction:
    def relative(parts):
        low, high = parts(before), parts(after)
        return np.log(np.asarray(high) / np.asarray(low)) / apart
    return Direction(
        relative(lambda m: np.array([np.asarray(v) for v in m.wall])),
        relative(lambda m: m.network.area0),
        relative(lambda m: m.network.length),
        relative(lambda m: np.array([np.asarray(v) for v in m.outlets])),
    )


class Varied:
    """Cycles of a finished run with changes beside them."""

    def __init__(self, run: Run, inflow: Inflow, directions: Sequence[Direction]) -> None:
        grid = run.grid
        self.run, self.stepper = run, Stepper(grid, inflow, Numerics(samples=1), run.steps)
        s = self.stepper
        vessel, ends = grid.vessel, s.parts[2]
        wall = np.array([np.vstack([one.wall, one.area0]) for one in directions])
        length = np.array([one.length for one in directions])
        self.weights = (
            Weights(np.ascontiguousarray(wall[:, :, vessel]), np.ascontiguousarray(length[:, vessel])),
            Weights(np.ascontiguousarray(wall[:, :, ends.vessel]), np.ascontiguousarray(length[:, ends.vessel])),
        )
        self.outlets = OutletChanges(*(np.ascontiguousarray(v) for v in self._outlets(directions)))
        self.shifted = tuple(self._shifted(w) for w in s.law)
        D, slots, n = len(directions), len(vessel), len(ends.face)
        K = wall.shape[1]
        self.more = (
            Fluxes(*np.ones((3, slots))),
            Slopes(*np.ones((3, slots)), np.ones((K, slots))),
            Slopes(*np.ones((3, slots)), np.ones((K, slots))),
            FaceSlopes(*np.ones((4, slots))),
            EndSlopes(*np.ones((7, n)), *np.ones((2, K, n)), *np.ones((2, n))),
            Changes(*np.zeros((3, slots))),
            EndChanges(*np.zeros((3, n)), np.zeros(len(ends.start) - 1)),
            np.zeros(slots), np.zeros(slots), np.zeros(len(ends.terminal_node)),
        )
        self.out = np.zeros((D, run.steps))

    def _outlets(self, directions):
        o = self.run.model.outlets
        h = 1e-30
        cols = []
        for one in directions:
            moved = outlet_steps(Windkessel(*(np.asarray(v) * (1 + 1j * h * w) for v, w in zip(o, one.outlets))), self.run.steps, self.run.period)
            cols.append([np.imag(v) / h for v in moved])
        return [np.array([c[i] for c in cols]) for i in range(5)]

    def _shifted(self, wall):
        kind = type(wall)
        def one(k, sign):
            return kind(*(v * (1 + sign * SHIFT) if i == k else v for i, v in enumerate(wall)))
        return tuple((one(k, 1), one(k, -1)) for k in range(len(wall)))

    def cycle(self, state: State, dA, dq, dm):
        s = self.stepper
        area, flow, memory = state.area.copy(), state.flow.copy(), state.memory.copy()
        dA, dq, dm = dA.copy(), dq.copy(), dm.copy()
        ok = varied_cycle_kernel(type(s.grid.wall))(
            (area, flow, memory), (dA, dq, dm), s.inflow, s.law, self.shifted, s.outlets, self.outlets,
            s.parts[1:], self.weights, s.fluid, (*s.scratch, *self.more), self.out)
        assert ok
        return State(area, flow, memory), dA, dq, dm
