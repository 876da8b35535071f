"""Exact derivatives of a run's waves by whatever its model is made of."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.model import walls
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.ventricle import Driven
from vasowave.pulse.solver.direction import Direction
from vasowave.pulse.solver.failures import at_the_edge
from vasowave.pulse.solver.periodic import affine_fixed_point
from vasowave.pulse.solver.places import Places, Waves, area_changes, at_places
from vasowave.pulse.solver.result import Run, with_viscous
from vasowave.pulse.solver.varied_stepper import VariedStepper

_MOST = 20  # cycles; 3 or 4 reach 1e-6


def pressure_derivatives(
    run: Run,
    inflow: Driven,
    directions: Sequence[Direction],
    numerics: Numerics,
    tolerance: float = 1e-6,
    workers: int = 1,
) -> np.ndarray:
    """Return the derivatives of the inlet pressure, mmHg, at every step, shape (direction, step); see `derivatives`."""
    return _output(run, inflow, directions, numerics, np.zeros(0, dtype=np.int64), tolerance, workers)


def derivatives(
    run: Run,
    inflow: Driven,
    directions: Sequence[Direction],
    numerics: Numerics,
    watched_waves: tuple[Places, Waves],
    tolerance: float = 1e-6,
    workers: int = 1,
) -> tuple[np.ndarray, Waves]:
    """Return the derivatives of the inlet pressure and of the waves at places, at every step.

    The scheme itself is linearized about the run, so that these are the derivatives of what `simulate_run` returns on
    the same grid and with the same steps, and the linearized cycle is brought to its own periodic state.

    Parameters
    ----------
    run : Run
        Of the model at which derivatives are asked.
    inflow : Inflow or InletPressure
        With which it was made.
    directions : sequence of Direction
    numerics : Numerics
        With which it was made; a run of so many cycles from rest has the derivatives of these cycles.
    watched_waves : (Places, Waves)
        Places, and the waves there (`waves_at`), shape (step, place).
    tolerance : float
        Change from cycle to cycle that counts as periodic, as a share of the largest change of the state.
    workers : int
        Threads that share the directions.

    Returns
    -------
    inlet : array, shape (direction, step)
        mmHg.
    waves : Waves
        Shape (direction, step, place).

    Raises
    ------
    NumericalError
        The linearized cycle does not become periodic.
    """
    places, waves = watched_waves
    faces, between = places.faces(run.grid)
    output = _output(run, inflow, directions, numerics, faces.ravel(), tolerance, workers)
    inlet, at_faces = output[:, : run.steps], output[:, run.steps :]
    at_faces = at_faces.reshape(len(output), len(run.at_inlet), run.steps, faces.size)
    kinds = at_places(np.moveaxis(at_faces, 1, 0), between)
    of_law = waves.pressure
    if len(kinds) > 2:
        wall, area0 = run.model.at(places.vessel, places.share)
        of_law = np.asarray(walls.pressure(wall, waves.area, area0))
    area = area_changes(directions, run.model, places, of_law, kinds[0])
    return inlet, Waves(with_viscous(kinds[0], kinds), kinds[1], area)


def _output(
    run: Run,
    inflow: Driven,
    directions: Sequence[Direction],
    numerics: Numerics,
    faces: np.ndarray,
    tolerance: float,
    workers: int,
) -> np.ndarray:
    """Return `VariedStepper.output` of the periodic state of the changes."""
    chunks = [chunk for chunk in np.array_split(np.arange(len(directions)), workers) if len(chunk)]
    steppers = [VariedStepper(run, inflow, [directions[d] for d in chunk], faces) for chunk in chunks]
    if numerics.cycles_from_rest is not None:
        return np.concatenate([stepper.from_rest(numerics.cycles_from_rest) for stepper in steppers])

    def cycle(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        done = list(pool.map(lambda stepper, chunk: stepper.cycle(x[chunk]), steppers, chunks))
        return np.concatenate([end for end, _ in done]), np.concatenate([output for _, output in done])

    start = np.zeros((len(directions), steppers[0].size))
    with ThreadPoolExecutor(len(chunks)) as pool:
        fixed_point = affine_fixed_point(cycle, start, tolerance, _MOST, run.convergence.secants)
    if fixed_point is None or not np.all(np.isfinite(fixed_point)):
        raise NumericalError(
            f"the derivatives of the pressure do not become periodic within {_MOST} cycles; the state is at the edge "
            f"of its stability: {at_the_edge(run.grid, run.end)}"
        )
    return fixed_point
