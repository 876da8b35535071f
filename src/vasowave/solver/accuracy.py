"""Simulate as finely as an accuracy asks, by comparing grids."""

import math
from dataclasses import replace

import numpy as np

from vasowave.errors import NumericalError
from vasowave.model.model import Model
from vasowave.recording import Inflow
from vasowave.solver.failures import TooSteep
from vasowave.solver.numerics import Numerics
from vasowave.solver.result import Run
from vasowave.solver.run import run_to_periodic

_COARSEST = 2.0  # the first grid's cells, in the given cell size
_OF_CYCLES = 0.02  # share of the accuracy that the last cycle may still change
_SECOND_ORDER = 2.5  # halving the cells must gain at least this, of 4, before the gain is counted on


def run_to_accuracy(model: Model, inflow: Inflow, numerics: Numerics, accuracy: float) -> Run:
    """Return a run whose pressures are within `accuracy` (mmHg) by the comparison of its grid with a coarser one.

    The scheme is of second order in space and time together, so that a grid k times finer than another differs from it
    by k² - 1 times its own error. That is counted on once three grids have shown it; what two grids differ by is taken
    as the error of the finer one until then.

    Raises
    ------
    NumericalError
        The accuracy needs more than ``numerics.most_steps``, or finer grids do not come nearer to each other.
    """
    tolerance = min(numerics.tolerance, _OF_CYCLES * accuracy)
    numerics = replace(numerics, cell_size=_COARSEST * numerics.cell_size, tolerance=tolerance, accuracy=None)
    refinement, factor, wanted = 1, 2, math.nan
    try:
        before = run_to_periodic(model, inflow, numerics)
    except TooSteep:
        refinement = 2
        before = run_to_periodic(model, inflow, numerics, refinement=refinement)
    while True:
        refinement *= factor
        run = _refined(model, inflow, numerics, refinement, before, accuracy)
        apart = float(np.max(np.abs(run.pressure - before.pressure)))
        by_order = apart / (factor**2 - 1)
        ordered = by_order <= wanted
        error = by_order if ordered else apart
        if error <= accuracy:
            return replace(run, error_estimate=error)
        failed = not (ordered or math.isnan(wanted))
        before = replace(run, error_estimate=error)
        factor = 2 if failed else max(2, math.ceil(math.sqrt(by_order / accuracy)))
        wanted = by_order / (_SECOND_ORDER / 4 * factor**2)


def _refined(model: Model, inflow: Inflow, numerics: Numerics, refinement: int, before: Run, accuracy: float) -> Run:
    try:
        return run_to_periodic(model, inflow, numerics, refinement=refinement)
    except NumericalError as error:
        known = f" (an error of {before.error_estimate:.2g} mmHg was reached)" if before.error_estimate > 0 else ""
        raise NumericalError(
            f"an accuracy of {accuracy:g} mmHg cannot be reached{known}: on cells {refinement} times finer, {error}"
        ) from None
