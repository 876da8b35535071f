"""The state of a simulation between two cycles, and its form as one vector of pressures."""

from dataclasses import dataclass

import numpy as np

from vasowave.pulse.model import walls
from vasowave.pulse.solver.grid import Grid


@dataclass(frozen=True, eq=False)
class State:
    """Area (cm²) and flow (ml/s) of every slot, and the modes of every bed (mmHg, complex; terminal, mode)."""

    area: np.ndarray
    flow: np.ndarray
    memory: np.ndarray


class Scale:
    """Turns states into vectors of pressures (mmHg) and back, so that one tolerance fits all variables.

    Parameters
    ----------
    grid : Grid
    mean_pressure : array, shape (vessel,)
        mmHg, at which compliance and characteristic impedance are taken.
    """

    def __init__(self, grid: Grid, mean_pressure: np.ndarray) -> None:
        model, area0 = grid.model, grid.model.area0
        compliance = np.asarray(walls.area_compliance(model.wall, mean_pressure, area0))
        area = walls.area(model.wall, mean_pressure, area0)
        speed = walls.wave_speed(model.wall, mean_pressure, model.blood.inertia)
        impedance = np.asarray(model.blood.inertia * speed / area)
        self.held: np.ndarray = grid.has_state
        self.ghost_area: np.ndarray = grid.area0
        self.compliance: np.ndarray = compliance[grid.vessel[self.held]]
        self.impedance: np.ndarray = impedance[grid.vessel[self.held]]
        self.beds: int = len(model.network.terminals)

    def vector(self, state: State) -> np.ndarray:
        """Return the state as pressures, mmHg."""
        held = self.held
        modes = state.memory.view(float).ravel()
        return np.concatenate([state.area[held] / self.compliance, state.flow[held] * self.impedance, modes])

    def state(self, x: np.ndarray) -> State:
        """Return the state whose vector is `x`."""
        n = len(self.compliance)
        area, flow = self.ghost_area.copy(), np.zeros(len(self.held))
        area[self.held], flow[self.held] = x[:n] * self.compliance, x[n : 2 * n] / self.impedance
        modes = np.ascontiguousarray(x[2 * n :]).view(complex)
        return State(area, flow, modes.reshape(self.beds, len(modes) // self.beds).copy())

    def change(self, x: np.ndarray) -> State:
        """Return the difference between two states whose vectors differ by `x`."""
        change = self.state(x)
        return State(np.where(self.held, change.area, 0.0), change.flow, change.memory)
