"""One simulation: choose the step, start well, run cycles, and refuse to return a number that cannot be trusted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vasowave import walls
from vasowave.errors import NumericalError
from vasowave.linear import linear_solution
from vasowave.model import Model
from vasowave.recording import Inflow
from vasowave.recording.cycle import resample
from vasowave.solver.grid import Grid, make_grid
from vasowave.solver.periodic import Convergence, fixed_point
from vasowave.solver.start import Scale, begin, first_steps, scale_of
from vasowave.solver.stepper import AIM, State, Stepper, TooFast

if TYPE_CHECKING:
    from vasowave.solver.simulate import Numerics

_ATTEMPTS = 8  # of finding a step that is small enough


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
    inlet_area : array, shape (step,)
        Area at the root's inlet at every step, cm².
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
    inlet_area: np.ndarray
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

    def inlet_pressure(self, samples: int) -> np.ndarray:
        """Pressure at the root's inlet, mmHg, at `samples` evenly spaced times of the cycle."""
        root = self.model.network.root
        wall = type(self.model.wall)(*(value[root] for value in self.model.wall))
        pressure = np.asarray(walls.pressure(wall, self.inlet_area, self.model.network.area0[root]))
        if self.steps % samples == 0:
            return pressure[:: self.steps // samples]
        return resample(pressure, samples)


def run_to_periodic(model: Model, inflow: Inflow, numerics: Numerics, start: Run | None = None) -> Run:
    """Run until the state repeats itself; raises `NumericalError` if it does not within the allowed cycles."""
    grid = make_grid(model, numerics.cell_size)
    linear = None if start is not None else linear_solution(model, inflow)
    steps = first_steps(grid, inflow, numerics, linear, start)

    def attempt(steps: int) -> Run:
        stepper = Stepper(grid, inflow, numerics, steps)
        scale = scale_of(grid, inflow, linear, start, steps)
        began = begin(grid, inflow.period, steps, linear, start)

        def cycle(x: np.ndarray) -> np.ndarray:
            return scale.vector(stepper.cycle(scale.state(x)))

        def allowed(x: np.ndarray) -> bool:
            return stepper.allows(scale.state(x))

        learned = start.convergence.secants if start is not None else None
        x, convergence = fixed_point(
            cycle, scale.vector(began), numerics.tolerance, numerics.most_cycles, allowed, learned
        )
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
    steps = first_steps(grid, inflow, numerics, linear_solution(model, inflow), None)

    def attempt(steps: int) -> Run:
        stepper = Stepper(grid, inflow, numerics, steps)
        slots = len(grid.vessel)
        memory = np.zeros((len(model.network.terminals), grid.memory_length(steps)))
        state = State(model.network.area0[grid.vessel].copy(), np.zeros(slots), memory)
        scale = Scale(grid, np.zeros(len(model.network)), len(memory[0]))
        changes = []
        for _ in range(count):
            before, state = state, stepper.cycle(state)
            changes.append(float(np.max(np.abs(scale.vector(state) - scale.vector(before)))))
        return _finished(stepper, state, Convergence(tuple(changes), changes[-1] <= numerics.tolerance), numerics)

    return _with_stable_step(attempt, steps, numerics)


def _finished(stepper: Stepper, end: State, convergence: Convergence, numerics: Numerics) -> Run:
    return Run(
        stepper.grid, stepper.period, stepper.steps, stepper.inlet_area, stepper.stations, stepper.cells, end,
        convergence, stepper.courant, stepper.volume_error, numerics.tolerance,
    )  # fmt: skip


def _with_stable_step(attempt, steps: int, numerics: Numerics) -> Run:  # type: ignore[no-untyped-def]
    """Run with more steps as long as the Courant number passes 1, unless the caller fixed their number."""
    for _ in range(_ATTEMPTS):
        try:
            return attempt(steps)
        except TooFast as signal:
            if numerics.steps_per_cycle is not None:
                raise NumericalError(str(signal)) from None
            last = signal
            factor = max(1.15, min(2.0, last.courant / AIM)) if math.isfinite(last.courant) else 2.0
            steps = math.ceil(steps * factor / numerics.samples) * numerics.samples
    raise NumericalError(f"{last}; {_ATTEMPTS} smaller steps were tried: check the wall parameters")
