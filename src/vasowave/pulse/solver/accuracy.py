"""Simulate as finely as an accuracy asks, by comparing grids."""

import math
from dataclasses import replace

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.model.linear import linear_solution
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.ventricle import Driven
from vasowave.pulse.solver.failures import TooSteep
from vasowave.pulse.solver.grid import aligned, cell_counts
from vasowave.pulse.solver.middles import cells_for_middles
from vasowave.pulse.solver.result import Run
from vasowave.pulse.solver.run import run_on_cells

_COARSEST = 2.0  # the first grid's cells, in those that would be taken without an accuracy
_OF_CYCLES = 0.02  # share of the accuracy that the last cycle may still change
_SAFETY = 2.0  # factor on an error by the order that three grids show: of 65 models the error exceeded 1.6 in one
_ASSUMED = 1.25  # on one by the first order, where two grids are all that is known (Roache's grid convergence index)
_ORDERS = np.linspace(2.0, 0.8, 25)  # the scheme's own, and what fronts leave of it
_FIRST = 1.0  # order that is counted on where two grids are all that is known, or three show none


def run_to_accuracy(model: Model, inflow: Driven, numerics: Numerics, accuracy: float) -> Run:
    """Return a run whose pressures are within `accuracy` (mmHg) by the comparison of its grid with coarser ones.

    All grids have the cells of the first, each cut into the same number of parts. The order at which they come nearer
    to each other is the one that three of them show, two at most; the first order until then.

    Raises
    ------
    NumericalError
        The accuracy needs more than ``numerics.most_steps``, or finer grids do not come nearer to each other.
    """
    tolerance = min(numerics.tolerance, _OF_CYCLES * accuracy)
    numerics = replace(numerics, tolerance=tolerance, accuracy=None)
    counts, before = _coarsest(model, inflow, numerics)
    refinement, factor, gap, earlier = 1, 2, math.nan, 2
    while True:
        refinement *= factor
        run = _refined(model, inflow, numerics, refinement, counts, before, accuracy)
        difference = float(np.max(np.abs(run.pressure - before.pressure)))
        order, three = _order(gap / max(difference, 1e-300), earlier, factor), not math.isnan(gap)
        error = (_SAFETY if three else _ASSUMED) * difference / (factor**order - 1)
        run = replace(run, error_estimate=error)
        if error <= accuracy:
            return run
        gap, earlier, before = difference, factor, run
        at_best = _SAFETY * difference / (factor**2 - 1)
        factor = 2 if three and order <= _FIRST else max(2, math.ceil(math.sqrt(at_best / accuracy)))


def _coarsest(model: Model, inflow: Driven, numerics: Numerics) -> tuple[np.ndarray, Run]:
    """Return the cells of every vessel that are cut into parts, and their run."""
    linear = linear_solution(model, inflow)
    counts = cell_counts(model, numerics.cell_size, linear, _COARSEST)
    try:
        run = run_on_cells(model, inflow, numerics, counts, linear)
    except TooSteep:
        counts = 2 * counts
        run = run_on_cells(model, inflow, numerics, counts, linear)
    needed = aligned(model, cells_for_middles(run.middles, run.grid.counts))
    if np.any(needed > counts):
        counts = np.maximum(needed, counts)
        run = run_on_cells(model, inflow, numerics, counts, linear)
    return counts, run


def _order(ratio: float, earlier: int, factor: int) -> float:
    """Return the order that three grids show, the second `earlier`, the third `factor` times finer than that before.

    `ratio` is how many times as far apart the first two are as the last two; NaN where there are only two grids.
    """
    shown = (earlier**_ORDERS - 1.0) * factor**_ORDERS / (factor**_ORDERS - 1.0)  # grows with the order
    if math.isnan(ratio) or ratio < shown[-1]:
        return _FIRST
    return float(_ORDERS[int(np.argmax(shown <= ratio))])


def _refined(
    model: Model, inflow: Driven, numerics: Numerics, refinement: int, counts: np.ndarray, before: Run, accuracy: float
) -> Run:
    try:
        return run_on_cells(model, inflow, numerics, refinement * counts)
    except NumericalError as error:
        reached = f" (an error of {before.error_estimate:.2g} mmHg was reached)" if before.error_estimate > 0 else ""
        raise NumericalError(
            f"an accuracy of {accuracy:g} mmHg cannot be reached{reached}: on cells {refinement} times finer, {error}"
        ) from None
