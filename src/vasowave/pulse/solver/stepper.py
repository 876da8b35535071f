"""Cycles of one model with one step size, and what their failures mean."""

from collections.abc import Sequence

import numpy as np

from vasowave.pulse.cycle.cycle import resample
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.rational import Rational
from vasowave.pulse.model.ventricle import Driven, Ventricle
from vasowave.pulse.solver import cycle as cycles
from vasowave.pulse.solver.beds import BedSteps, Pulsation, bed_steps
from vasowave.pulse.solver.cells import Faces, FluidConstants, Fluxes
from vasowave.pulse.solver.failures import left_law, no_balance, too_steep
from vasowave.pulse.solver.grid import Grid
from vasowave.pulse.solver.nodes import make_node_states
from vasowave.pulse.solver.scheme import HalfStep, Scheme, SlotStates, StepArguments, StepRecords, Walls
from vasowave.pulse.solver.start import AIM
from vasowave.pulse.solver.state import State
from vasowave.pulse.solver.validity import Extreme
from vasowave.pulse.solver.valve import make_heart
from vasowave.pulse.solver.viscosity import make_viscous


class TooFast(Exception):  # noqa: N818  a signal between functions of this file, not an error
    """The Courant number passed 1: the step must be smaller."""

    def __init__(self, courant: float, where: str, advice: str) -> None:
        super().__init__(where + advice)
        self.courant, self.where = courant, where


class Stepper:
    """Runs cycles of one model with one step size; owns the scratch memory, which is why it is not a value."""

    def __init__(
        self, grid: Grid, inflow: Driven, numerics: Numerics, steps: int, watched: Sequence[int] | np.ndarray = ()
    ) -> None:
        self.grid: Grid = grid
        self.driven: Driven = inflow
        self.numerics: Numerics = numerics
        self.steps: int = steps
        self.period: float = inflow.period
        self.of_pressure: bool = inflow.of_pressure
        self.inflow: np.ndarray
        if isinstance(inflow, Ventricle):
            self.inflow = inflow.resampled(steps).reshape(-1, 1)
        else:
            entering = inflow.into(grid.model.network.inlet_names)
            self.inflow = np.ascontiguousarray(resample(entering, steps))
        dt = inflow.period / steps
        heart = make_heart(inflow, dt)
        self.beds: Rational = grid.model.outlets.rational(inflow.period)
        self.outlets: BedSteps = bed_steps(self.beds, dt, grid.model.outlet_pressure)
        blood = grid.model.blood
        friction = blood.friction.coefficients(blood.viscosity, inflow.period)
        self.fluid: FluidConstants = FluidConstants(blood.inertia, *friction)
        cells = grid.cells(dt, friction)
        faces = grid.faces(dt) if grid.model.changing.any() else cells
        ends = grid.ends(dt, inflow.period)
        walls = Walls(grid.wall, grid.face_wall, grid.wall_at_ends())
        self.scheme: Scheme = Scheme(grid.vessels, cells, faces, ends, walls, self.fluid, self.outlets)
        slots, vessels = len(grid.vessel), len(grid.model.network)
        fluxes = (Fluxes(*np.ones((3, slots))) for _ in range(2))
        nodes = make_node_states(ends, inflow.of_pressure)
        self.half: HalfStep = HalfStep(next(fluxes), Faces(np.ones(slots), np.ones(slots)), next(fluxes), nodes)
        viscous, behind = make_viscous(grid), make_pulsation(grid.model, steps, inflow.period)
        self.terms = tuple(term for term in (grid.changing, viscous, behind, heart) if term is not None)
        kinds = 2 if viscous is None else 3
        inlets = ends.face[ends.inlet :][: self.inflow.shape[1]]
        self.watched: np.ndarray = np.concatenate([inlets, np.asarray(watched, dtype=np.uintp)]).astype(np.uintp)
        self.watched_waves: np.ndarray = np.zeros((kinds, steps, len(self.watched)))
        stored_steps = steps // numerics.kept_every(steps)
        of_cells = numerics.samples if steps % numerics.samples == 0 else stored_steps
        self.stations: np.ndarray = np.zeros((kinds, stored_steps, vessels, 3))
        self.cells: np.ndarray = np.zeros((kinds, of_cells if numerics.every_cell else 0, slots))
        self.courant: float = 0.0
        self.volume_error: float = 0.0
        self.mach: Extreme = Extreme(0.0, "", 0.0)

    @property
    def at_inlet(self) -> np.ndarray:
        """What was seen at the root's inlet at every step of the last cycle, shape (kind, step); see `Run`."""
        return np.ascontiguousarray(self.watched_waves[:, :, 0])

    @property
    def records(self) -> StepRecords:
        """Where a cycle is recorded."""
        return StepRecords(self.watched, self.watched_waves, self.stations, self.cells)

    def allows(self, state: State) -> bool:
        """Whether all areas lie within the wall law."""
        cells = self.scheme.cells
        return bool(np.all((state.area > cells.smallest) & (state.area < cells.largest)))

    def cycle(self, state: State) -> State:
        """Run one cycle; the waveforms of the last one stay in `stations` and `cells`."""
        area, flow, memory = state.area.copy(), state.flow.copy(), state.memory.copy()
        report = np.zeros(cycles.REPORT)
        step = StepArguments(self.inflow, SlotStates(area, flow, memory), self.scheme, self.half, self.records)
        cycles.cycle_kernel(type(self.grid.wall), tuple(map(type, self.terms)))(step, self.terms, report)
        self._check(report, State(area, flow, memory))
        self.courant, self.mach = report[cycles.COURANT], self._extreme(report, cycles.MACH)
        stored = np.sum((area - state.area)[self.grid.is_cell] * self.grid.spacing[self.grid.is_cell])
        entered = self.watched_waves[1, :, : self.inflow.shape[1]]
        passed = self.period * float(np.mean(np.abs(entered).sum(axis=1)))  # not of q: it may be zero
        balance = float((report[cycles.INFLOW] - report[cycles.OUTFLOW]) * self.period / self.steps - stored)
        self.volume_error = balance / passed if passed > 0 else balance
        return State(area, flow, memory)

    def _check(self, report: np.ndarray, state: State) -> None:
        """Raise if the cycle failed or was unstable; `state` is where it ended."""
        network = self.grid.model.network
        if report[cycles.COURANT] > 1:
            courant, name, time = self._extreme(report, cycles.COURANT)
            vessel = network.row(name)
            speed = courant * self.grid.spacing[self.grid.vessels.first[vessel]] / (self.period / self.steps)
            raise TooFast(
                courant,
                f"vessel '{name}' ({network.length[vessel]:.4g} cm), t = {time:.4g} s: ",
                f"Courant number {courant:.2f} at |u| + c = {speed:.0f} cm/s; raise steps_per_cycle "
                f"from {self.steps} to {self.numerics.steps_for(self.steps * courant / AIM)}",
            )
        grid, time, place = self.grid, report[cycles.STEP] * self.period / self.steps, int(report[cycles.PLACE])
        if report[cycles.STATUS] == cycles.LEFT_LAW:
            cell, face = state.area[place], self.half.faces.area[place]
            within = self.scheme.cells.smallest[place] < cell < self.scheme.cells.largest[place]
            if np.isfinite(cell) and not (within or grid.is_cell[place]):  # no wall's area: the line's through its ends
                raise too_steep(grid, grid.vessel[place], time)
            raise left_law(grid, state, place, face if within else None, time)
        if report[cycles.STATUS] == cycles.NODE_FAILED:
            raise no_balance(grid, state, place, time)

    def _extreme(self, report: np.ndarray, key: int) -> Extreme:
        """Return what the cycle's report says of one of its largest values."""
        vessel = self.grid.vessel[int(report[key + 1])]
        time = float(report[key + 2] * self.period / self.steps)
        return Extreme(float(report[key]), self.grid.model.network.name[vessel], time)


def make_pulsation(model: Model, steps: int, period: float) -> Pulsation | None:
    """Return what stands before the beds of the pressure behind them by half step; None where it is steady."""
    pulsation = model.pulsation_before_beds(period)
    if pulsation is None:
        return None
    return Pulsation(np.ascontiguousarray(resample(pulsation, steps) + np.asarray(model.outlet_pressure)))
