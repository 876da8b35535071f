"""Cycles of one model with one step size, and what their failures mean."""

import math

import numpy as np

from vasowave.errors import NumericalError
from vasowave.recording import Inflow
from vasowave.solver.cells import Faces, Fluid, Fluxes
from vasowave.solver.cycle import LEFT_LAW, NODE_FAILED, cycle_kernel
from vasowave.solver.grid import Grid
from vasowave.solver.laws import outlet_steps
from vasowave.solver.nodes import make_node_states
from vasowave.solver.numerics import Numerics
from vasowave.solver.start import AIM
from vasowave.solver.state import State


class TooFast(Exception):  # noqa: N818  a signal between functions of this file, not an error
    """The Courant number passed 1: the step must be smaller."""

    def __init__(self, courant: float, message: str) -> None:
        super().__init__(message)
        self.courant = courant


class Stepper:
    """Runs cycles of one model with one step size; owns the scratch memory, which is why it is not a value."""

    def __init__(self, grid: Grid, inflow: Inflow, numerics: Numerics, steps: int) -> None:
        self.grid, self.steps, self.period = grid, steps, inflow.period
        self.inflow = inflow.resampled(steps)
        dt = inflow.period / steps
        self.parts = grid.vessels, grid.cells(dt), grid.ends(dt)
        self.outlets = outlet_steps(grid.model.outlets, steps, inflow.period)
        blood = grid.model.blood
        self.fluid = Fluid(blood.inertia, *blood.friction.coefficients(blood.viscosity, inflow.period))
        slots, vessels = len(grid.vessel), len(grid.model.network)
        self.law = grid.wall, grid.wall_at_ends()
        self.scratch = (
            Faces(np.ones(slots), np.ones(slots)),
            Fluxes(*np.ones((3, slots))),
            make_node_states(self.parts[2]),
        )
        self.inlet_area = np.zeros(steps)
        self.stations = np.zeros((2, numerics.samples, vessels, 3))
        self.cells = np.zeros((2, numerics.samples if numerics.every_cell else 0, slots))
        self.courant = self.volume_error = 0.0

    def allows(self, state: State) -> bool:
        """Whether all areas lie within the wall law."""
        cells = self.parts[1]
        return bool(np.all((state.area > cells.smallest) & (state.area < cells.largest)))

    def cycle(self, state: State) -> State:
        """Run one cycle; the waveforms of the last one stay in `stations` and `cells`."""
        area, flow, memory = state.area.copy(), state.flow.copy(), state.memory.copy()
        report = cycle_kernel(type(self.grid.wall))(
            (area, flow, memory), self.inflow, self.law, self.outlets, self.parts, self.fluid, self.scratch,
            self.inlet_area, self.stations, self.cells,
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
            speed = report[3] * self.grid.spacing[self.grid.vessels.first[vessel]] / (self.period / self.steps)
            needed = math.ceil(self.steps * report[3] / AIM / self.stations.shape[1]) * self.stations.shape[1]
            raise TooFast(
                report[3],
                f"vessel '{network.name[vessel]}' ({network.length[vessel]:.4g} cm), t = {self._time(report[5])}: "
                f"Courant number {report[3]:.2f} at |u| + c = {speed:.0f} cm/s; raise steps_per_cycle "
                f"from {self.steps} to {needed}",
            )
        if report[0] == LEFT_LAW:
            slot = int(report[1])
            name = network.name[self.grid.vessel[slot]]
            low, high = self.parts[1].smallest[slot], self.parts[1].largest[slot]
            raise NumericalError(
                f"vessel '{name}', t = {self._time(report[2])}: the area left the range of the wall law "
                f"({low:.3g} to {high:.3g} cm²); the wall is too soft for these pressures: raise its stiffness "
                "(for the tangent law p1 or gamma), or check flow and resistance"
            )
        if report[0] == NODE_FAILED:
            raise NumericalError(
                f"vessel '{network.name[int(report[1])]}', t = {self._time(report[2])}: no pressure balances the flows "
                "at its end; check resistances and stiffness, or raise steps_per_cycle"
            )

    def _time(self, step: float) -> str:
        return f"{step * self.period / self.steps:.4g} s"
