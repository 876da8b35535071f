"""A finished simulation as bare arrays."""

from dataclasses import dataclass

import numpy as np

from vasowave import walls
from vasowave.model import Model
from vasowave.recording.cycle import resample
from vasowave.solver.grid import Grid
from vasowave.solver.periodic import Convergence
from vasowave.solver.state import State


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
