"""Simulate a model, or many of them at once, and return labelled waveforms."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import xarray as xr

from vasowave.base.errors import InputError, NumericalError, VasowaveError
from vasowave.base.findings import warn
from vasowave.base.runtime.thread_limits import threads
from vasowave.pulse.cycle.averaged import EnsembleAverage, one_cycle
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.ventricle import Driven, Ventricle
from vasowave.pulse.network.network import Network
from vasowave.pulse.solver.accuracy import run_to_accuracy
from vasowave.pulse.solver.dataset import as_dataset, stack
from vasowave.pulse.solver.result import Run
from vasowave.pulse.solver.run import run_cycles, run_to_periodic
from vasowave.pulse.solver.valve import ventricular_waves


def simulate(
    model: Model | Sequence[Model],
    inflow: Driven | Recording | EnsembleAverage,
    numerics: Numerics | None = None,
    *,
    progress: Callable[[int], None] | None = None,
) -> xr.Dataset:
    """Simulate one cycle of the periodic state.

    Parameters
    ----------
    model : Model or sequence of Model
        Several models of networks with the same vessels run in parallel over all cores.
    inflow : Inflow, Recording, EnsembleAverage, InletPressure or Ventricle
        Flow into the root; or the pressure at its inlet, from which the flow follows; or the ventricle that ejects into
        it, from which both follow.
    numerics : Numerics, optional
    progress : callable, optional
        Called with the number of finished models.

    Returns
    -------
    Dataset
        ``pressure`` (mmHg), ``flow`` (ml/s), ``area`` (cm²), ``velocity`` (cm/s), ``wave_speed`` (cm/s) with dims
        (time, vessel, station), or (time, cell) with ``every_cell``; of a ventricle also ``ventricular_pressure`` and
        ``ventricular_volume`` (ml above V0), with dim (time); a sequence adds a first dimension ``ensemble`` and
        the variable ``failure`` (empty where a member is fine; its waveforms are NaN where it is not). Attributes:
        cycles, change (mmHg over the last cycle), converged, courant (the largest), steps_per_cycle,
        volume_error (relative, over the last cycle), error_estimate (mmHg, where an accuracy was asked for), what the
        waves reach at most (mach, steepness, lowest_pressure, area_strain, grid_error; each with ``_vessel`` and
        ``_time``), and notes: what a reader must know before believing them, one a line. An ensemble has them as
        variables.

    Warns
    -----
    VasowaveWarning
        For every note of a single model.

    Raises
    ------
    NumericalError
        Unstable, outside the wall law, faster than its waves, not periodic, in need of more steps than allowed, or not
        as accurate as asked; with vessel, time and what to change. In an ensemble only
        if every member fails.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> nominal = vw.estimate_nominal(network, mouse)
    >>> waves = vw.simulate(vw.Model(network, nominal.wall(vw.LinearWall), nominal.outlets), mouse)
    >>> waves.pressure.dims, waves.pressure.attrs["units"]
    (('time', 'vessel', 'station'), 'mmHg')
    """
    flow = driving(inflow)
    numerics = numerics or Numerics()
    if isinstance(model, Model):
        run = simulate_run(model, flow, numerics)
        for note in run.notes:
            warn(note)
        return _labelled(run, flow)
    if isinstance(model, Network):
        raise InputError("a Network was given where a Model is needed: a network with a wall law and vascular beds")
    models = list(model)
    if not models:
        raise InputError("no models to simulate")
    outcomes = simulate_runs(models, flow, numerics, progress=progress)
    return stack([_labelled(outcome, flow) if isinstance(outcome, Run) else outcome for outcome in outcomes])


def driving(source: Driven | Recording | EnsembleAverage) -> Driven:
    """Return what drives a network: what is given, or the flow of a recording or an average."""
    return source if isinstance(source, Driven) else one_cycle(source).inflow


def _labelled(run: Run, driven: Driven) -> xr.Dataset:
    """Return the labelled waveforms of a run, with those of the ventricle that drove it."""
    dataset = as_dataset(run)
    if isinstance(driven, Ventricle):
        times, sample_times = np.arange(run.steps) / run.steps, np.arange(run.samples) / run.samples
        waves = ventricular_waves(driven, run.at_inlet[1])  # the volume jumps where filling ends: no Fourier series
        pressure, volume = (np.interp(sample_times, times, wave) for wave in waves)
        dataset["ventricular_pressure"] = ("time", pressure, {"units": "mmHg", "long_name": "ventricular pressure"})
        dataset["ventricular_volume"] = ("time", volume, {"units": "ml", "long_name": "ventricular volume above V0"})
    return dataset


def simulate_run(model: Model, inflow: Driven, numerics: Numerics, start: Run | None = None) -> Run:
    """Simulate and return the bare arrays, from the linear solution or, on its grid, a neighbouring run `start`."""
    if numerics.accuracy is not None and start is None:
        return run_to_accuracy(model, inflow, numerics, numerics.accuracy)
    if numerics.cycles_from_rest is not None:
        return run_cycles(model, inflow, numerics, numerics.cycles_from_rest)
    return run_to_periodic(model, inflow, numerics, start)


def simulate_runs(
    models: Sequence[Model],
    inflow: Driven | Sequence[Driven],
    numerics: Numerics,
    *,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> Iterator[Run | VasowaveError]:
    """Simulate many models in threads (kernels release the interpreter), and yield each run, or its error, in order.

    They have one inflow, or each its own. A run holds every step of every vessel: take from it what is needed, and let
    it go, before the next one.
    """
    inflows = [inflow] * len(models) if isinstance(inflow, Driven) else inflow

    def one(model: Model, inflow: Driven) -> Run | VasowaveError:
        try:
            return simulate_run(model, inflow, numerics)
        except VasowaveError as error:
            return error
        except (ArithmeticError, ValueError) as error:  # of a user's law, which may raise what it likes
            return NumericalError(f"this model cannot be ({type(error).__name__}: {error})")

    count = min(len(models), workers or threads())
    pool = ThreadPoolExecutor(max(count, 1))
    try:
        # handing each to a thread costs as much as a tenth of a short run
        outcomes = map(one, models, inflows) if count < 2 else pool.map(one, models, inflows)
        for done in range(1, len(models) + 1):
            yield next(outcomes)
            if progress is not None:
                progress(done)
    finally:
        pool.shutdown(cancel_futures=True)  # whoever stops listening does not wait for the rest


__all__ = ["Numerics", "simulate", "simulate_run", "simulate_runs"]
