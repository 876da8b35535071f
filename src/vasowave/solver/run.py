"""One simulation: choose the step, start well, run cycles, and refuse to return a number that cannot be trusted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vasowave import walls
from vasowave.errors import NumericalError
from vasowave.linear import LinearSolution, linear_solution
from vasowave.model import Model
from vasowave.recording import Inflow
from vasowave.solver import kernels
from vasowave.solver.grid import Grid, make_grid
from vasowave.solver.periodic import Convergence, fixed_point

if TYPE_CHECKING:
    from vasowave.solver.simulate import Numerics

_AIM = 0.85  # Courant number at which a chosen step aims; the scheme is stable to 1
_ATTEMPTS = 8  # of finding a step that is small enough


@dataclass(frozen=True, eq=False)
class State:
    """Area (cm²) and flow (ml/s) of every slot, and what every terminal remembers (mmHg, or ml/s)."""

    area: np.ndarray
    flow: np.ndarray
    memory: np.ndarray


@dataclass(frozen=True, eq=False)
class Run:
    """A finished simulation as bare arrays.

    Attributes
    ----------
    grid : Grid
    period : float
        s.
    steps : int
        Steps per cycle.
    stations : array, shape (2, sample, vessel, 3)
        Area and flow at inlet, middle, outlet.
    cells : array, shape (2, sample, slot)
        Area and flow in every slot; no samples unless every cell was asked for.
    end : State
        State at the end of the cycle.
    convergence : Convergence
    courant : float
        Largest Courant number of the last cycle.
    volume_error : float
        (inflow - outflow - stored)/inflow over the last cycle.
    tolerance : float
        mmHg.
    """

    grid: Grid
    period: float
    steps: int
    stations: np.ndarray
    cells: np.ndarray
    end: State
    convergence: Convergence
    courant: float
    volume_error: float
    tolerance: float

    @property
    def model(self) -> Model:
        """The model that was simulated."""
        return self.grid.model

    def inlet_pressure(self) -> np.ndarray:
        """Pressure at the root's inlet, mmHg, shape (sample,)."""
        root = self.model.network.root
        wall = type(self.model.wall)(*(value[root] for value in self.model.wall))
        return np.asarray(walls.pressure(wall, self.stations[0, :, root, 0], self.model.network.area0[root]))


class _TooFast(Exception):  # noqa: N818  a signal between functions of this file, not an error
    """The Courant number passed 1: the step must be smaller."""

    def __init__(self, courant: float, message: str) -> None:
        super().__init__(message)
        self.courant = courant


class _Stepper:
    """Runs cycles of one model with one step size; owns the scratch memory, which is why it is not a value."""

    def __init__(self, grid: Grid, inflow: Inflow, numerics: Numerics, steps: int) -> None:
        self.grid, self.steps, self.period = grid, steps, inflow.period
        self.inflow = inflow.resampled(steps)
        self.constants = grid.cells(inflow.period / steps)
        self.outlets = grid.outlets(steps, inflow.period)
        blood = grid.model.blood
        self.fluid = kernels.Fluid(blood.inertia, *blood.friction.coefficients(blood.viscosity, inflow.period))
        slots, vessels = len(grid.vessel), len(grid.model.network)
        self.faces = kernels.make_faces(slots, grid.nodes)
        self.stations = np.zeros((2, numerics.samples, vessels, 3))
        self.cells = np.zeros((2, numerics.samples if numerics.every_cell else 0, slots))
        self.courant = self.volume_error = 0.0

    def cycle(self, state: State) -> State:
        """Run one cycle; the waveforms of the last one stay in `stations` and `cells`."""
        area, flow, memory = state.area.copy(), state.flow.copy(), state.memory.copy()
        report = kernels.advance_cycle(
            area, flow, memory, self.inflow, self.grid.wall, self.outlets, self.constants, self.grid.nodes,
            self.fluid, self.faces, self.stations, self.cells,
        )  # fmt: skip
        self._check(report)
        self.courant = report[3]
        stored = np.sum((area - state.area)[self.grid.is_cell] * self.grid.spacing[self.grid.is_cell])
        dt = self.period / self.steps
        self.volume_error = float((report[6] - report[7]) * dt - stored) / max(abs(report[6] * dt), 1e-300)
        return State(area, flow, memory)

    def _check(self, report: np.ndarray) -> None:
        """Raise if the cycle failed or was unstable."""
        network = self.grid.model.network
        if report[3] > 1 or not math.isfinite(report[3]):
            vessel = int(report[4])
            speed = report[3] * self.grid.spacing[self.grid.nodes.first[vessel]] / (self.period / self.steps)
            needed = math.ceil(self.steps * report[3] / _AIM / self.stations.shape[1]) * self.stations.shape[1]
            raise _TooFast(
                report[3],
                f"vessel '{network.name[vessel]}' ({network.length[vessel]:.4g} cm), t = {self._time(report[5])}: "
                f"Courant number {report[3]:.2f} at |u| + c = {speed:.0f} cm/s; raise steps_per_cycle "
                f"from {self.steps} to {needed}",
            )
        if report[0] == kernels.LEFT_LAW:
            slot = int(report[1])
            name = network.name[self.grid.vessel[slot]]
            low, high = self.constants.smallest[slot], self.constants.largest[slot]
            raise NumericalError(
                f"vessel '{name}', t = {self._time(report[2])}: the area left the range of the wall law "
                f"({low:.3g} to {high:.3g} cm²); the wall is too soft for these pressures: raise its stiffness "
                "(for the tangent law p1 or gamma), or check flow and resistance"
            )
        if report[0] == kernels.NODE_FAILED:
            raise NumericalError(
                f"vessel '{network.name[int(report[1])]}', t = {self._time(report[2])}: no pressure balances the flows "
                "at its end; check resistances and stiffness, or raise steps_per_cycle"
            )

    def _time(self, step: float) -> str:
        return f"{step * self.period / self.steps:.4g} s"


def run_to_periodic(model: Model, inflow: Inflow, numerics: Numerics, start: Run | None = None) -> Run:
    """Run until the state repeats itself; raises `NumericalError` if it does not within the allowed cycles."""
    grid = make_grid(model, numerics.cell_size)
    linear = None if start is not None else linear_solution(model, inflow)
    steps = _first_steps(grid, inflow, numerics, linear, start)

    def attempt(steps: int) -> Run:
        stepper = _Stepper(grid, inflow, numerics, steps)
        scale = _scale(grid, inflow, linear, start, steps)
        began = _begin(grid, inflow.period, steps, linear, start)

        def cycle(x: np.ndarray) -> np.ndarray:
            return scale.vector(stepper.cycle(scale.state(x)))

        def allowed(x: np.ndarray) -> bool:
            area = scale.state(x).area
            return bool(np.all((area > stepper.constants.smallest) & (area < stepper.constants.largest)))

        x, convergence = fixed_point(cycle, scale.vector(began), numerics.tolerance, numerics.most_cycles, allowed)
        if not convergence.converged:
            raise NumericalError(
                f"not periodic after {numerics.most_cycles} cycles: the last one still changed by "
                f"{convergence.changes[-1]:.2g} mmHg (tolerance {numerics.tolerance:.2g}); raise most_cycles "
                "or tolerance, and look whether a Windkessel's R2 C is many periods long"
            )
        return _finished(stepper, scale.state(x), convergence, numerics)

    return _with_stable_step(attempt, steps, numerics)


def run_cycles(model: Model, inflow: Inflow, numerics: Numerics, count: int) -> Run:
    """Run exactly `count` cycles from rest and return the last, periodic or not."""
    grid = make_grid(model, numerics.cell_size)
    steps = _first_steps(grid, inflow, numerics, linear_solution(model, inflow), None)

    def attempt(steps: int) -> Run:
        stepper = _Stepper(grid, inflow, numerics, steps)
        slots = len(grid.vessel)
        memory = np.zeros((len(model.network.terminals), grid.memory_length(steps)))
        state = State(model.network.area0[grid.vessel].copy(), np.zeros(slots), memory)
        scale = _Scale(grid, np.zeros(len(model.network)), len(memory[0]))
        changes = []
        for _ in range(count):
            before, state = state, stepper.cycle(state)
            changes.append(float(np.max(np.abs(scale.vector(state) - scale.vector(before)))))
        return _finished(stepper, state, Convergence(tuple(changes), changes[-1] <= numerics.tolerance), numerics)

    return _with_stable_step(attempt, steps, numerics)


def _finished(stepper: _Stepper, end: State, convergence: Convergence, numerics: Numerics) -> Run:
    return Run(
        stepper.grid, stepper.period, stepper.steps, stepper.stations, stepper.cells, end, convergence,
        stepper.courant, stepper.volume_error, numerics.tolerance,
    )  # fmt: skip


def _with_stable_step(attempt, steps: int, numerics: Numerics) -> Run:  # type: ignore[no-untyped-def]
    """Run with more steps as long as the Courant number passes 1, unless the caller fixed their number."""
    for _ in range(_ATTEMPTS):
        try:
            return attempt(steps)
        except _TooFast as signal:
            if numerics.steps_per_cycle is not None:
                raise NumericalError(str(signal)) from None
            last = signal
            factor = max(1.15, min(2.0, last.courant / _AIM)) if math.isfinite(last.courant) else 2.0
            steps = math.ceil(steps * factor / numerics.samples) * numerics.samples
    raise NumericalError(f"{last}; {_ATTEMPTS} smaller steps were tried: check the wall parameters")


def _first_steps(
    grid: Grid, inflow: Inflow, numerics: Numerics, linear: LinearSolution | None, start: Run | None
) -> int:
    """Steps per cycle for the wave speeds at the pressures that the linear solution or a neighbouring run meets."""
    if numerics.steps_per_cycle is not None:
        return numerics.steps_per_cycle
    if start is not None and start.stations.shape[1] == numerics.samples:
        return start.steps
    model = grid.model
    if linear is None:
        linear = linear_solution(model, inflow)
    times = np.linspace(0, inflow.period, 64, endpoint=False)
    pressure, flow = linear.in_time(linear.pressure, times), linear.in_time(linear.flow, times)
    low, high = _range_of_pressure(model)
    pressure = np.clip(pressure, low, high)
    speed = walls.wave_speed(model.wall, pressure, model.blood.inertia)
    speed = speed + np.abs(flow) / walls.area(model.wall, pressure, model.network.area0)
    crossings = float(np.max(speed / grid.spacing[grid.nodes.first])) * inflow.period
    return max(1, math.ceil(crossings / _AIM / numerics.samples)) * numerics.samples


def _range_of_pressure(model: Model) -> tuple[float, float]:
    """Pressures beyond which a linear guess is cut: near the collapse of the softest wall, and 100 kPa."""
    rest = np.sqrt(model.wall.wave_speed_squared_at_rest(model.blood.inertia, *model.wall))
    return float(-0.5 * model.blood.inertia * np.min(rest) ** 2), 750.0


class _Scale:
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
        terminal = 1.0 if memory_length == 1 else impedance[grid.nodes.terminal, np.newaxis]
        self.memory = np.broadcast_to(terminal, (len(grid.nodes.terminal), memory_length))

    def vector(self, state: State) -> np.ndarray:
        cell = self.cell
        return np.concatenate(
            [
                state.area[cell] / self.compliance,
                state.flow[cell] * self.impedance,
                (state.memory * self.memory).ravel(),
            ]
        )

    def state(self, x: np.ndarray) -> State:
        n = len(self.compliance)
        area, flow = self.ghost_area.copy(), np.zeros(len(self.cell))
        area[self.cell], flow[self.cell] = x[:n] * self.compliance, x[n : 2 * n] / self.impedance
        return State(area, flow, x[2 * n :].reshape(self.memory.shape) / self.memory)


def _scale(grid: Grid, inflow: Inflow, linear: LinearSolution | None, start: Run | None, steps: int) -> _Scale:
    if linear is not None:
        mean = np.maximum(linear.mean_pressure, 0.0)
    else:
        assert start is not None
        area = start.stations[0, :, :, 1].mean(axis=0)
        mean = np.maximum(np.asarray(walls.pressure(start.model.wall, area, start.model.network.area0)), 0.0)
    return _Scale(grid, mean, grid.memory_length(steps))


def _begin(grid: Grid, period: float, steps: int, linear: LinearSolution | None, start: Run | None) -> State:
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
