"""Where a simulation may start: each start knows the steps that suit it, the scale of its variables and its state."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.model import walls
from vasowave.pulse.model.linear import LinearSolution, linear_solution
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.rational import Rational
from vasowave.pulse.model.ventricle import Driven
from vasowave.pulse.solver.failures import no_waves, too_many_steps
from vasowave.pulse.solver.grid import Grid
from vasowave.pulse.solver.periodic import Secants
from vasowave.pulse.solver.result import Run
from vasowave.pulse.solver.state import State

AIM = 0.9  # Courant number at which a chosen step aims; the scheme is stable to 1
_UNSURE = 1.25  # the linear waves are a guess: only a demand this far above the allowed steps is refused untried
_WASTEFUL = 0.7  # a neighbour's step is kept, so that results change smoothly, unless so few steps would do


class Start(Protocol):
    """What a simulation asks before its first cycle."""

    @property
    def grid(self) -> Grid:
        """The grid on which it starts."""
        ...

    @property
    def secants(self) -> Secants | None:
        """What a neighbouring run has learned about the cycle map."""
        ...

    def steps(self, numerics: Numerics) -> int:
        """Return the steps per cycle to try first."""
        ...

    def mean_pressure(self) -> np.ndarray:
        """Return the pressures at which the variables are scaled, mmHg, shape (vessel,)."""
        ...

    def state(self, beds: Rational, steps: int) -> State:
        """Return the state half a step before t = 0."""
        ...


@dataclass(frozen=True, eq=False)
class FromLinear:
    """A start from the linear solution."""

    grid: Grid
    linear: LinearSolution
    secants: Secants | None = None

    def steps(self, numerics: Numerics) -> int:
        """Return steps for the wave speeds at the pressures of the linear solution."""
        if numerics.steps_per_cycle is not None:
            return numerics.steps_per_cycle
        demand = self.demand()
        if not np.all(possible := demand < 2**53):  # no number of steps is larger
            raise no_waves(self.grid, int(np.argmin(possible)))
        if np.max(demand) > _UNSURE * numerics.most_steps:
            raise too_many_steps(self.grid, self.linear, demand, numerics.most_steps)
        return min(numerics.steps_for(float(np.max(demand))), numerics.largest_steps)

    def demand(self) -> np.ndarray:
        """Return the steps per cycle that each vessel asks for, shape (vessel,)."""
        model, linear = self.grid.model, self.linear
        stretching = linear.of_law(linear.pressure)
        pressure, flow = (linear.over_cycle(waves, 72) for waves in (stretching, linear.flow))
        pressure = np.clip(pressure, *_range_of_pressure(model))
        wall, area0 = self.grid.at_stations
        if area0.ndim > 1:
            pressure, flow = pressure[:, np.newaxis], flow[:, np.newaxis]
        speed = walls.wave_speed(wall, pressure, model.blood.inertia)
        speed = speed + np.abs(flow) / walls.area(wall, pressure, area0)
        return (
            np.max(speed, axis=tuple(range(area0.ndim)))
            / self.grid.spacing[self.grid.vessels.first]
            * (linear.period / AIM)
        )

    def mean_pressure(self) -> np.ndarray:
        """Return the mean pressures of the linear solution, mmHg."""
        return np.maximum(self.linear.mean_pressure, 0.0)

    def state(self, beds: Rational, steps: int) -> State:
        """Return the linear solution half a step before t = 0."""
        grid, linear, model = self.grid, self.linear, self.grid.model
        held, step = grid.has_state, linear.period / steps
        P, Q = linear.at(grid.vessel[held], grid.position[held])
        area, flow = grid.area0.copy(), np.zeros(len(grid.vessel))
        wall = type(grid.wall)(*(value[held] for value in grid.wall))
        P = linear.of_law(P, grid.vessel[held])
        pressure = np.clip(linear.in_time(P, -0.5 * step), *_range_of_pressure(model))
        area[held] = walls.area(wall, pressure, area[held])
        flow[held] = linear.in_time(Q, -0.5 * step)
        terminals = model.network.terminals
        leaving = linear.at(terminals, model.network.length[terminals])[1]
        return State(area, flow, beds.waves(leaving, linear.period, -0.5 * step))


@dataclass(frozen=True, eq=False)
class FromNeighbor:
    """A start from the end of a run of a similar model."""

    grid: Grid
    inflow: Driven
    run: Run

    @property
    def secants(self) -> Secants | None:
        """The neighbour's, whose slow directions are nearly the same."""
        return self.run.convergence.secants

    def steps(self, numerics: Numerics) -> int:
        """Return the neighbour's steps, or fewer where many fewer would do."""
        if numerics.steps_per_cycle is not None:
            return numerics.steps_per_cycle
        run = self.run
        if run.samples != numerics.samples:
            return FromLinear(self.grid, linear_solution(self.grid.model, self.inflow)).steps(numerics)
        fewer = numerics.steps_for(run.steps * run.courant / AIM)
        return fewer if fewer < _WASTEFUL * run.steps else run.steps

    def mean_pressure(self) -> np.ndarray:
        """Return the neighbour's mean pressures in the middle of its vessels, mmHg."""
        model, area = self.run.model, self.run.recorded[0, :, :, 1].mean(axis=0)
        wall, area0 = model.at(np.arange(len(area)), 0.5)
        return np.maximum(np.asarray(walls.pressure(wall, area, area0)), 0.0)

    def state(self, beds: Rational, steps: int) -> State:
        """Return the neighbour's pressures, flows and memory at the end of its cycle."""
        grid, end, before = self.grid, self.run.end, self.run.grid
        area0 = grid.area0
        if len(end.area) != len(area0) or len(end.memory) != len(beds.poles):
            raise NumericalError("the neighbouring run has another grid; start without it")
        memory = end.memory
        if memory.shape != beds.poles.shape:  # of beds that are stepped by another number of modes
            leaving = self.run.recorded[1][:, grid.model.network.terminals, 2]
            flow = np.fft.rfft(leaving, axis=0)[: len(leaving) // 2] / len(leaving)
            flow[1:] *= 2.0
            memory = beds.waves(flow, self.run.period, -0.5 * self.run.period / steps)
        pressure: walls.Values = np.zeros(len(area0))
        if type(before.wall) is type(grid.wall):
            pressure = walls.pressure(before.wall, end.area, before.area0)
        return State(np.asarray(walls.area(grid.wall, pressure, area0)), end.flow, memory)


@dataclass(frozen=True, eq=False)
class FromRest:
    """A start without flow or pressure, with the steps that the linear solution suggests."""

    grid: Grid
    linear: LinearSolution
    secants: Secants | None = None

    def steps(self, numerics: Numerics) -> int:
        """Return steps for the wave speeds at the pressures of the linear solution."""
        return FromLinear(self.grid, self.linear).steps(numerics)

    def mean_pressure(self) -> np.ndarray:
        """Return zero, mmHg."""
        return np.zeros(len(self.grid.model.network))

    def state(self, beds: Rational, steps: int) -> State:
        """Return undeformed vessels without flow."""
        return at_rest(self.grid, beds)


def at_rest(grid: Grid, beds: Rational) -> State:
    """Return undeformed vessels without flow, whose outlets remember none."""
    return State(grid.area0.copy(), np.zeros(len(grid.vessel)), np.zeros_like(beds.poles))


def _range_of_pressure(model: Model) -> tuple[float, float]:
    """Pressures beyond which a linear guess is cut: near the collapse of the softest wall, and 100 kPa."""
    speed_at_rest = walls.wave_speed_at_rest(model.wall, model.blood.inertia)
    return float(-0.5 * model.blood.inertia * np.min(speed_at_rest) ** 2), 750.0
