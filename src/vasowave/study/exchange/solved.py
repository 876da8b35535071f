"""A model with its inflow and its periodic waves: what the files of other programs are written from."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import warn
from vasowave.pulse.cycle.cycle import Inflow, Recording
from vasowave.pulse.model import walls
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.outlets import Bed, Circuit
from vasowave.pulse.network.network import Network
from vasowave.pulse.solver.result import Run, with_viscous
from vasowave.pulse.solver.simulation import simulate_run


class Along(NamedTuple):
    """Waves along one vessel: place 0 is its inlet, the last its outlet."""

    position: np.ndarray
    """cm from the inlet. Shape (place,)."""
    area: np.ndarray
    flow: np.ndarray
    pressure: np.ndarray
    """cm², ml/s, mmHg. Shape (time, place)."""


@dataclass(frozen=True, eq=False)
class Solved:
    """A model, the flow into it, and one cycle of its periodic state with every cell."""

    run: Run
    inflow: Inflow

    @property
    def model(self) -> Model:
        """The model that was simulated."""
        return self.run.model

    @property
    def network(self) -> Network:
        """Its vessels."""
        return self.run.model.network

    @cached_property
    def mean_pressure(self) -> np.ndarray:
        """Mean pressure in the middle of each vessel, mmHg, shape (vessel,)."""
        return self.run.pressure[:, 1].mean(axis=0)

    @cached_property
    def mean_area(self) -> np.ndarray:
        """Area of each vessel at its mean pressure, cm², shape (vessel,)."""
        return np.asarray(walls.area(self.model.wall, self.mean_pressure, self.model.area0))

    @cached_property
    def drag(self) -> np.ndarray:
        """Friction k0 + k1 √A of each vessel at its mean area, cm²/s, shape (vessel,): A/ρ dp/dx = -k q/A if steady."""
        return self._drag(self.mean_area)

    @cached_property
    def resistance(self) -> np.ndarray:
        """Mean frictional fall of the pressure over the mean flow, mmHg s/ml, shape (vessel,): what the waves do to it.

        Vessels are widest when most flows, so it lies below the resistance at mean area.
        """
        area, flow = self.run.stations[:2, :, :, 1]
        fall = np.mean(self._drag(area) * flow / area**2, axis=0)
        return self.model.blood.inertia * self.network.length * fall / flow.mean(axis=0)

    def _drag(self, area: np.ndarray) -> np.ndarray:
        blood = self.model.blood
        k0, k1 = blood.friction.coefficients(blood.viscosity, self.inflow.period)
        return k0 + k1 * np.sqrt(area)

    def along(self, row: int) -> Along:
        """Return the waves at the inlet, in every cell and at the outlet of a vessel."""
        run = self.run
        slots = np.flatnonzero(run.grid.is_cell & (run.grid.vessel == row))
        position = np.concatenate([[0.0], run.grid.position[slots], [self.network.length[row]]])
        inlet, outlet = run.stations[:, :, row, :1], run.stations[:, :, row, -1:]
        kinds = np.concatenate([inlet, run.cells[:, :, slots], outlet], axis=-1)
        wall, area0 = self.model.at(np.full(len(position), row), position / self.network.length[row])
        return Along(position, kinds[0], kinds[1], with_viscous(walls.pressure(wall, kinds[0], area0), kinds))


def solve(model: Model, inflow: Inflow | Recording, numerics: Numerics | None = None) -> Solved:
    """Simulate one cycle of the periodic state with every cell.

    Raises
    ------
    NumericalError
        As `simulate`.

    Warns
    -----
    VasowaveWarning
        For every note of the simulation.
    """
    flow = inflow.inflow if isinstance(inflow, Recording) else inflow
    run = simulate_run(model, flow, replace(numerics or Numerics(), every_cell=True))
    for note in run.notes:
        warn(note)
    return Solved(run, flow)


def require_elastic(model: Model, program: str) -> None:
    """Raise `InputError` if walls are viscous, whose law `program` has not or writes otherwise."""
    if np.any(model.wall_viscosity):
        raise InputError(f"{program} is given elastic walls only; leave wall_viscosity out of what is exported to it")


def losses(model: Model) -> np.ndarray:
    """Return the loss coefficient of each vessel's inlet, shape (vessel,); where the inflow enters it has no effect."""
    values = np.array(np.broadcast_to(model.loss, len(model.network)), dtype=float)
    values[model.network.inlets] = 0.0
    return values


def circuit(model: Model, program: str, three_element: bool = False) -> Circuit:
    """Return what the beds are to the flow; `InputError` if they are none of what `program` knows.

    If `three_element`, it knows only three-element Windkessels, with a resistance before and behind each capacitor.
    """
    if three_element and np.any(model.outlet_pressure):
        raise InputError(
            f"{program} knows no pressure behind its outlets; this model has {np.max(model.outlet_pressure):g} mmHg. "
            "Fit without a wedge pressure for it, or export to svZeroDSolver, which knows it (--to svzerod)"
        )
    if model.outlet_pulsation is not None:
        raise InputError(f"{program} knows no pressure behind its outlets that changes over the cycle; leave it out")
    elements = model.outlets.circuit() if isinstance(model.outlets, Bed) else None
    if elements is not None and (not three_element or all(np.all(np.asarray(element) > 0) for element in elements)):
        return elements
    kind = type(model.outlets).__name__
    knows = "three-element Windkessels" if three_element else "resistances and Windkessels"
    raise InputError(f"{program} knows {knows} as outlets only, this model has {kind}; give it Windkessel(R1, R2, C)")
