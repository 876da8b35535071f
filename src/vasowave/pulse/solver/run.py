"""One simulation: choose the step, start well, run cycles, and refuse to return a number that cannot be trusted."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.model.linear import LinearSolution, linear_solution
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.ventricle import Driven, Ventricle
from vasowave.pulse.solver.discharge import common_discharge
from vasowave.pulse.solver.failures import Lost, TooSteep, faster_than_allowed, not_periodic, runaway
from vasowave.pulse.solver.grid import Grid, aligned, cell_counts, counts_by_length, make_grid
from vasowave.pulse.solver.middles import cells_for_middles
from vasowave.pulse.solver.periodic import Convergence, fixed_point
from vasowave.pulse.solver.result import Run, at_samples, difference, needs_two_grids
from vasowave.pulse.solver.start import AIM, FromLinear, FromNeighbor, FromRest, Start
from vasowave.pulse.solver.state import Scale, State
from vasowave.pulse.solver.stepper import Stepper, TooFast
from vasowave.pulse.solver.validity import SETTLED_SHARE, require_subcritical
from vasowave.pulse.solver.valve import require_emptied

_GROWTH = 8  # a model whose steps grow by more than this, and beyond those allowed, has no finite wave speed
_REFINEMENTS = 2  # at most, by what two grids show
_HALVED = 2  # parts of a cell that was too long for its wave


def run_to_periodic(
    model: Model, inflow: Driven, numerics: Numerics, neighbor: Run | None = None, refinement: int = 1
) -> Run:
    """Run until the state repeats itself; raises `NumericalError` if it does not within the allowed cycles."""
    if neighbor is not None:
        if len(neighbor.grid.counts) != len(model.network):
            raise NumericalError("the neighbouring run has another network; start without it")
        grid = make_grid(model, neighbor.grid.counts)
        return replace(_from(FromNeighbor(grid, inflow, neighbor), inflow, numerics), two_grids=neighbor.two_grids)
    linear = linear_solution(model, inflow)
    try:
        run = _run_by_waves(model, inflow, numerics, linear, refinement)
    except TooSteep:
        if numerics.cell_size is not None or refinement > 1:
            raise
        run = _run_by_waves(model, inflow, numerics, linear, _HALVED)  # or the reason why shorter cells do not help
    return _by_two_grids(run, inflow, numerics, linear) if refinement == 1 and needs_two_grids(run) else run


def _by_two_grids(run: Run, inflow: Driven, numerics: Numerics, linear: LinearSolution) -> Run:
    """Return the run with the error that another grid shows, or one on shorter cells where that error is large.

    The other grid has half the cells, or where that is no grid, twice as many.
    """
    counts = run.grid.counts
    half = aligned(run.model, np.ceil(counts / 2))
    if np.all((half < counts) | ~run.model.changing) and np.any(half < counts):
        coarser = _other_run(run, half, inflow, numerics, linear)
        run = run if coarser is None else replace(run, two_grids=difference(run, coarser))
    for _ in range(_REFINEMENTS):
        shown = run.two_grids
        if shown is not None and (
            numerics.cell_size is not None or shown.value <= SETTLED_SHARE * run.largest_pressure
        ):
            break
        finer = _other_run(run, 2 * run.grid.counts, inflow, numerics, linear)
        if finer is None:
            break
        run = replace(finer, two_grids=difference(finer, run))
    return run


def _other_run(run: Run, counts: np.ndarray, inflow: Driven, numerics: Numerics, linear: LinearSolution) -> Run | None:
    """Return the run on so many cells, or nothing where there is none within twice the steps that these should need."""
    finer = max(1.0, float(np.max(counts / run.grid.counts)))
    numerics = replace(numerics, most_steps=min(numerics.most_steps, math.ceil(2 * finer * run.steps)))
    try:
        return run_on_cells(run.model, inflow, numerics, counts, linear)
    except (NumericalError, TooSteep):
        return None


def _run_by_waves(model: Model, inflow: Driven, numerics: Numerics, linear: LinearSolution, refinement: int) -> Run:
    """Return the run on cells as short as its waves ask for, each cut into `refinement` parts."""
    longer, counted = 1.0, counts_by_length(model, numerics.cell_size, linear)
    while True:
        counts = refinement * counted(longer)
        run = run_on_cells(model, inflow, numerics, counts, linear)
        longer *= 0.5
        finer = refinement * counted(longer)
        if numerics.cell_size is not None or np.all(finer <= run.grid.counts) or run.settled:
            break
    needed = aligned(model, refinement * cells_for_middles(run.middles, run.grid.counts))
    if np.any(needed > run.grid.counts):
        run = run_on_cells(model, inflow, numerics, np.maximum(needed, run.grid.counts), linear)
    return run


def run_on_cells(
    model: Model, inflow: Driven, numerics: Numerics, counts: np.ndarray, linear: LinearSolution | None = None
) -> Run:
    """Return the periodic run with so many cells in every vessel."""
    linear = linear or linear_solution(model, inflow)
    return _from_linear(make_grid(model, counts), linear, inflow, numerics)


def _from_linear(grid: Grid, linear: LinearSolution, inflow: Driven, numerics: Numerics) -> Run:
    """Return the periodic run from the linear solution or, where that does not lead to it, from rest."""
    try:
        return _from(FromLinear(grid, linear), inflow, numerics)
    except Lost:  # the linear solution can be far from what a nonlinear wall does; rest is never wrong, but slow
        return _from(FromRest(grid, linear), inflow, numerics)


def _from(start: Start, inflow: Driven, numerics: Numerics) -> Run:
    """Return the periodic run from one start."""

    def attempt(steps: int) -> Run:
        return _periodic(Stepper(start.grid, inflow, numerics, steps), start, numerics)

    return _with_stable_step(attempt, start, numerics)


def _periodic(stepper: Stepper, start: Start, numerics: Numerics) -> Run:
    """Return the fixed point of the cycle map of one step size."""
    scale = Scale(stepper.grid, start.mean_pressure())

    def cycle(x: np.ndarray) -> np.ndarray:
        return scale.vector(stepper.cycle(scale.state(x)))

    def allowed(x: np.ndarray) -> bool:
        return stepper.allows(scale.state(x))

    began = start.state(stepper.beds, stepper.steps)
    discharge = common_discharge(stepper.grid, scale, began, stepper.beds, stepper.period, stepper.of_pressure)
    x, convergence = fixed_point(
        cycle, scale.vector(began), numerics.tolerance, numerics.most_cycles, allowed, discharge.after, start.secants
    )
    if not convergence.converged:
        last = scale.state(x)
        raise not_periodic(stepper.grid, last, stepper.beds, convergence.changes, numerics.tolerance, stepper.period)
    return _finished(stepper, scale.state(x), convergence, scale, numerics)


def run_cycles(model: Model, inflow: Driven, numerics: Numerics, count: int) -> Run:
    """Run exactly `count` cycles from rest and return the last, periodic or not."""
    linear, numerics = linear_solution(model, inflow), replace(numerics, cycles_from_rest=count)
    grid = make_grid(model, cell_counts(model, numerics.cell_size, linear))
    start = FromRest(grid, linear)

    def attempt(steps: int) -> Run:
        stepper = Stepper(grid, inflow, numerics, steps)
        scale = Scale(grid, start.mean_pressure())
        state, changes = start.state(stepper.beds, steps), []
        for _ in range(count):
            before, state = state, stepper.cycle(state)
            changes.append(float(np.max(np.abs(scale.vector(state) - scale.vector(before)))))
        return _finished(
            stepper, state, Convergence(tuple(changes), changes[-1] <= numerics.tolerance), scale, numerics
        )

    return _with_stable_step(attempt, start, numerics)


def _finished(stepper: Stepper, end: State, convergence: Convergence, scale: Scale, numerics: Numerics) -> Run:
    require_subcritical(stepper.mach)
    if isinstance(stepper.driven, Ventricle):
        require_emptied(stepper.driven, stepper.at_inlet[1])
    stepper.stations[0, :, :, 1] *= stepper.grid.middle
    cells = stepper.cells if not numerics.every_cell else at_samples(stepper.cells, numerics.samples, axis=1)
    return Run(
        stepper.grid, stepper.period, stepper.steps, numerics.samples, stepper.at_inlet, stepper.stations, cells, end,
        convergence, scale, stepper.courant, stepper.mach, stepper.volume_error, numerics.tolerance,
    )  # fmt: skip


def _with_stable_step(attempt: Callable[[int], Run], start: Start, numerics: Numerics) -> Run:
    """Run with more steps as long as the Courant number passes 1, unless the caller fixed their number.

    What a step that is too long says of the speed is no proof: the most that are allowed are tried before giving up.
    """
    steps = first = start.steps(numerics)
    largest = numerics.largest_steps
    while True:
        try:
            return attempt(steps)
        except TooFast as signal:
            if numerics.steps_per_cycle is not None:
                raise NumericalError(str(signal)) from None
            last = signal
        factor = max(1.15, min(2.0, last.courant / AIM))
        requested = numerics.steps_for(steps * factor)
        if requested > largest and steps >= largest:
            if requested > _GROWTH * first:
                raise runaway(last.where, first, requested)
            raise faster_than_allowed(start.grid, last.where, requested, numerics.most_steps)
        steps = min(requested, largest)
