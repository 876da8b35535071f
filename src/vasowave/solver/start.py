"""Before the first cycle: the step, the scale of the variables, and a state near the periodic one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vasowave import walls
from vasowave.errors import NumericalError
from vasowave.linear import LinearSolution, linear_solution
from vasowave.model import Model
from vasowave.recording import Inflow
from vasowave.solver.grid import Grid
from vasowave.solver.stepper import AIM, State

if TYPE_CHECKING:
    from vasowave.solver.run import Run
    from vasowave.solver.simulate import Numerics

_WASTEFUL = 0.7  # a neighbour's step is kept, so that results change smoothly, unless so few steps would do


def first_steps(
    grid: Grid, inflow: Inflow, numerics: Numerics, linear: LinearSolution | None, start: Run | None
) -> int:
    """Steps per cycle for the wave speeds at the pressures that the linear solution or a neighbouring run meets."""
    if numerics.steps_per_cycle is not None:
        return numerics.steps_per_cycle
    if start is not None and start.stations.shape[1] == numerics.samples:
        fewer = math.ceil(start.steps * start.courant / AIM / numerics.samples) * numerics.samples
        return fewer if fewer < _WASTEFUL * start.steps else start.steps
    model = grid.model
    if linear is None:
        linear = linear_solution(model, inflow)
    times = np.linspace(0, inflow.period, 64, endpoint=False)
    pressure, flow = linear.in_time(linear.pressure, times), linear.in_time(linear.flow, times)
    low, high = _range_of_pressure(model)
    pressure = np.clip(pressure, low, high)
    speed = walls.wave_speed(model.wall, pressure, model.blood.inertia)
    speed = speed + np.abs(flow) / walls.area(model.wall, pressure, model.network.area0)
    crossings = float(np.max(speed / grid.spacing[grid.vessels.first])) * inflow.period
    return max(1, math.ceil(crossings / AIM / numerics.samples)) * numerics.samples


def _range_of_pressure(model: Model) -> tuple[float, float]:
    """Pressures beyond which a linear guess is cut: near the collapse of the softest wall, and 100 kPa."""
    rest = walls.wave_speed_at_rest(model.wall, model.blood.inertia)
    return float(-0.5 * model.blood.inertia * np.min(rest) ** 2), 750.0


class Scale:
    """Turns states into vectors of pressures (mmHg) and back, so that one tolerance fits all variables."""

    def __init__(self, grid: Grid, mean_pressure: np.ndarray, memory_length: int) -> None:
        model = grid.model
        area0 = model.network.area0
        compliance = np.asarray(walls.area_compliance(model.wall, mean_pressure, area0))
        area = walls.area(model.wall, mean_pressure, area0)
        speed = walls.wave_speed(model.wall, mean_pressure, model.blood.inertia)
        impedance = np.asarray(model.blood.inertia * speed / area)
        self.cell = grid.is_cell
        self.ghost_area = area0[grid.vessel]
        vessel = grid.vessel[self.cell]
        self.compliance, self.impedance = compliance[vessel], impedance[vessel]
        beds = np.array(model.network.terminals)
        terminal = 1.0 if memory_length == 1 else impedance[beds, np.newaxis]
        self.memory = np.broadcast_to(terminal, (len(beds), memory_length))

    def vector(self, state: State) -> np.ndarray:
        """Return the state as pressures, mmHg."""
        cell = self.cell
        return np.concatenate(
            [
                state.area[cell] / self.compliance,
                state.flow[cell] * self.impedance,
                (state.memory * self.memory).ravel(),
            ]
        )

    def state(self, x: np.ndarray) -> State:
        """Return the state whose vector is `x`."""
        n = len(self.compliance)
        area, flow = self.ghost_area.copy(), np.zeros(len(self.cell))
        area[self.cell], flow[self.cell] = x[:n] * self.compliance, x[n : 2 * n] / self.impedance
        return State(area, flow, x[2 * n :].reshape(self.memory.shape) / self.memory)


def scale_of(grid: Grid, inflow: Inflow, linear: LinearSolution | None, start: Run | None, steps: int) -> Scale:
    """Return the scale that suits the mean pressures of the linear solution or of a neighbouring run."""
    if linear is not None:
        mean = np.maximum(linear.mean_pressure, 0.0)
    else:
        assert start is not None
        area = start.stations[0, :, :, 1].mean(axis=0)
        mean = np.maximum(np.asarray(walls.pressure(start.model.wall, area, start.model.network.area0)), 0.0)
    return Scale(grid, mean, grid.memory_length(steps))


def begin(grid: Grid, period: float, steps: int, linear: LinearSolution | None, start: Run | None) -> State:
    """State half a step before t = 0, from a neighbouring run or the linear solution."""
    model = grid.model
    if start is not None and len(start.end.area) == len(grid.vessel):
        pressure = walls.pressure(
            type(model.wall)(*start.grid.wall), start.end.area, start.model.network.area0[grid.vessel]
        ) if type(start.grid.wall) is type(grid.wall) else np.zeros(len(grid.vessel))  # fmt: skip
        area = walls.area(grid.wall, pressure, model.network.area0[grid.vessel])
        memory = start.end.memory
        if memory.shape[1] == grid.memory_length(steps):
            return State(np.asarray(area), start.end.flow, memory)
    if linear is None:
        raise NumericalError("the neighbouring run has another grid; start without it")
    cell = grid.is_cell
    before = -0.5 * period / steps
    P, Q = linear.at(grid.vessel[cell], grid.position[cell])
    low, high = _range_of_pressure(model)
    area, flow = model.network.area0[grid.vessel].copy(), np.zeros(len(grid.vessel))
    wall = type(grid.wall)(*(value[cell] for value in grid.wall))
    area[cell] = walls.area(wall, np.clip(linear.in_time(P, before), low, high), area[cell])
    flow[cell] = linear.in_time(Q, before)
    terminals = model.network.terminals
    P_end, Q_end = linear.at(terminals, model.network.length[terminals])
    return State(area, flow, _memory(grid, linear, P_end, Q_end, before, steps, period))


def _memory(
    grid: Grid, linear: LinearSolution, P: np.ndarray, Q: np.ndarray, t: float, steps: int, period: float
) -> np.ndarray:
    """What the terminals remember in the linear solution: capacitor pressure, or one cycle of flow."""
    if grid.memory_length(steps) == 1:
        return linear.in_time(P - Q * grid.model.outlets.R1, t)[:, np.newaxis]  # type: ignore[union-attr]
    return linear.in_time(Q, np.arange(steps) * (period / steps)).T.copy()
