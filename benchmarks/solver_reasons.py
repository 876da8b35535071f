"""Whether the reason that an error gives is true: each kind is tried by a run that would contradict it.

A reason is false if that run ends well. None of these runs repeats what the program did before it gave the reason: they
have another grid, another start, forced steps or many more cycles.
"""

import re
import warnings
from collections.abc import Callable

import numpy as np

from vasowave.base import NumericalError, VasowaveWarning
from vasowave.pulse.cycle import Inflow
from vasowave.pulse.model import Model, Numerics
from vasowave.pulse.solver import Run, run_cycles, run_to_periodic

SAMPLES, CALM = 512, 0.9  # the Courant number at which a step of the program's choice aims
FILLED, MANY = 40, 400  # cycles

Check = Callable[[Model, Inflow, "re.Match[str]"], str]


def contradiction(model: Model, inflow: Inflow, message: str) -> str:
    """Return what contradicts the reason in an error's message; empty if nothing does."""
    for pattern, check in CHECKS.items():
        if found := re.search(pattern, message):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", VasowaveWarning)
                return check(model, inflow, found)
    return "no check knows this reason"


def _fewer_steps_do(model: Model, inflow: Inflow, found: "re.Match[str]") -> str:
    """Fewer steps than a vessel asks for: it would run with the most that are allowed, and calmly."""
    steps = int(found["most"]) // SAMPLES * SAMPLES
    run = _ended_well(lambda: run_to_periodic(model, inflow, Numerics(steps_per_cycle=steps)))
    return f"runs with {steps} steps at a Courant number of {run.courant:.2f}" if run and run.courant < CALM else ""


def _more_steps_do(model: Model, inflow: Inflow, found: "re.Match[str]") -> str:
    """A wave speed without end: twice the steps would be enough, from rest until the outlets have filled."""
    steps = 2 * int(found["steps"]) // SAMPLES * SAMPLES
    run = _ended_well(lambda: run_cycles(model, inflow, Numerics(steps_per_cycle=steps), FILLED))
    return f"runs from rest with {steps} steps at a Courant number of {run.courant:.2f}" if run else ""


def _slower_on_finer_cells(model: Model, inflow: Inflow, found: "re.Match[str]") -> str:
    """Flow faster than its waves: on twice the cells it is clearly slower."""
    run = _ended_well(lambda: run_to_periodic(model, inflow, Numerics(), refinement=2))
    return f"|u|/c is {run.mach.value:.2f} on twice the cells" if run and run.mach.value < 0.95 else ""


def _as_lost_on_finer_cells(model: Model, inflow: Inflow, found: "re.Match[str]") -> str:
    """A wave too steep for the only cell of a vessel: on shorter cells than were tried it would fit."""
    try:
        run_to_periodic(model, inflow, Numerics(), refinement=4)
    except NumericalError as error:
        return f"on four times the cells {error}"
    return ""


def _never_periodic(model: Model, inflow: Inflow, found: "re.Match[str]") -> str:
    """Changes that grow smaller: more cycles do not make it periodic."""
    run = _ended_well(lambda: run_to_periodic(model, inflow, Numerics(most_cycles=MANY)))
    return "" if run else f"not periodic after {MANY} cycles either"


def _periodic_after_many(model: Model, inflow: Inflow, found: "re.Match[str]") -> str:
    """Changes that no longer grow smaller: plain repetition from rest becomes periodic."""
    run = _ended_well(lambda: run_cycles(model, inflow, Numerics(), MANY))
    return f"periodic after {MANY} cycles from rest" if run and run.convergence.converged else ""


def _runs_from_rest(model: Model, inflow: Inflow, found: "re.Match[str]") -> str:
    """A wall that is left, or a node without balance: from rest, on finer cells, it runs."""
    run = _ended_well(lambda: run_cycles(model, inflow, Numerics(cell_size=0.04), 20))
    return f"runs for 20 cycles from rest on finer cells, up to {np.max(run.pressure):.0f} mmHg" if run else ""


def _ended_well(task: Callable[[], Run]) -> Run | None:
    try:
        return task()
    except NumericalError:
        return None


CHECKS: dict[str, Check] = {
    r"asks? for about \d+ steps a cycle, more than most_steps = (?P<most>\d+)": _fewer_steps_do,
    r"grows without end as steps grow smaller \(from \d+ to (?P<steps>\d+)": _more_steps_do,
    r"the flow passes the wave speed \(": _slower_on_finer_cells,
    r"too steep for the only cell": _as_lost_on_finer_cells,
    r"no longer grow smaller": _periodic_after_many,
    r"the changes grow smaller": _never_periodic,
    r"t = .* s: ": _runs_from_rest,
}
"""Patterns of messages in the order in which they are tried, the most general last."""
