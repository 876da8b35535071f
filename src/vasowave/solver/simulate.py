"""Simulate a model, or many of them at once, and return labelled waveforms."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import xarray as xr

from vasowave.errors import InputError, VasowaveError
from vasowave.model import Model
from vasowave.recording import Inflow, Recording
from vasowave.solver.dataset import as_dataset, stack
from vasowave.solver.run import Run, run_cycles, run_to_periodic
from vasowave.threads import threads


@dataclass(frozen=True)
class Numerics:
    """How finely and how long to simulate; the defaults serve every network of the size of a mouse lung.

    Attributes
    ----------
    cell_size : float
        Longest cell, cm; every vessel gets at least two cells.
    samples : int
        Evenly spaced output times per cycle.
    steps_per_cycle : int, optional
        Time steps a cycle, a multiple of `samples`; by default chosen from the wave speeds met.
    tolerance : float
        The state is periodic when no variable changes by more than this over a cycle, mmHg. The default is the paper's
        criterion, squared change below 1e-8, asked of every cell and every outlet.
    most_cycles : int
        Cycles after which a state that is still not periodic is an error.
    cycles_from_rest : int, optional
        Simulate exactly this many cycles from rest instead, periodic or not (the paper's practice: 8).
    every_cell : bool
        Return every cell instead of inlet, middle and outlet of each vessel.
    """

    cell_size: float = 0.1
    samples: int = 512
    steps_per_cycle: int | None = None
    tolerance: float = 1e-4
    most_cycles: int = 60
    cycles_from_rest: int | None = None
    every_cell: bool = False

    def __post_init__(self) -> None:
        """Check the values."""
        if not self.cell_size > 0:
            raise InputError(f"cell_size {self.cell_size} cm is not positive")
        if self.samples < 1 or self.most_cycles < 1 or not self.tolerance > 0:
            raise InputError("samples and most_cycles must be at least 1, and tolerance positive")
        if self.cycles_from_rest is not None and self.cycles_from_rest < 1:
            raise InputError(f"cycles_from_rest {self.cycles_from_rest} must be at least 1")
        if self.steps_per_cycle is not None and (self.steps_per_cycle < 1 or self.steps_per_cycle % self.samples):
            raise InputError(
                f"steps_per_cycle {self.steps_per_cycle} is not a multiple of samples {self.samples}; "
                f"take {max(1, -(-self.steps_per_cycle // self.samples)) * self.samples}"
            )


def simulate(
    model: Model | Sequence[Model],
    inflow: Inflow | Recording,
    numerics: Numerics | None = None,
    *,
    progress: Callable[[int], None] | None = None,
) -> xr.Dataset:
    """Simulate one cycle of the periodic state.

    Parameters
    ----------
    model : Model or sequence of Model
        Several models of networks with the same vessels run in parallel over all cores.
    inflow : Inflow or Recording
        Flow into the root.
    numerics : Numerics, optional
    progress : callable, optional
        Called with the number of finished models.

    Returns
    -------
    Dataset
        ``pressure`` (mmHg), ``flow`` (ml/s), ``area`` (cm²), ``velocity`` (cm/s), ``wave_speed`` (cm/s) with dims
        (time, vessel, station), or (time, cell) with ``every_cell``; a sequence adds a first dimension ``ensemble`` and
        the variable ``failure`` (empty where a member is fine; its waveforms are NaN where it is not). Attributes:
        cycles, change (mmHg over the last cycle), converged, courant (the largest), steps_per_cycle,
        volume_error (relative, over the last cycle).

    Raises
    ------
    NumericalError
        Unstable, outside the wall law, or not periodic; with vessel, time and what to change. In an ensemble only
        if every member fails.
    """
    flow = inflow.inflow if isinstance(inflow, Recording) else inflow
    numerics = numerics or Numerics()
    if isinstance(model, Model):
        return as_dataset(simulate_run(model, flow, numerics))
    models = list(model)
    if not models:
        raise InputError("no models to simulate")
    outcomes = simulate_runs(models, flow, numerics, progress=progress)
    return stack(outcomes)


def simulate_run(model: Model, inflow: Inflow, numerics: Numerics, start: Run | None = None) -> Run:
    """Simulate and return the bare arrays, from the linear solution or a neighbouring run `start`."""
    if numerics.cycles_from_rest is not None:
        return run_cycles(model, inflow, numerics, numerics.cycles_from_rest)
    return run_to_periodic(model, inflow, numerics, start)


def simulate_runs(
    models: Sequence[Model],
    inflow: Inflow,
    numerics: Numerics,
    start: Run | None = None,
    *,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> list[Run | VasowaveError]:
    """Simulate many models in threads (the kernels release the interpreter); a member that fails returns its error."""

    def one(model: Model) -> Run | VasowaveError:
        try:
            return simulate_run(model, inflow, numerics, start)
        except VasowaveError as error:
            return error

    outcomes: list[Run | VasowaveError] = []
    with ThreadPoolExecutor(min(len(models), workers or threads())) as pool:
        for done, outcome in enumerate(pool.map(one, models), 1):
            outcomes.append(outcome)
            if progress is not None:
                progress(done)
    return outcomes
