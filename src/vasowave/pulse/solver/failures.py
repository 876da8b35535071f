"""What a failed cycle says: the fault that is there, where it is, and what to do about it."""

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.model import walls
from vasowave.pulse.model.linear import LinearSolution
from vasowave.pulse.model.rational import Rational
from vasowave.pulse.solver.grid import Grid
from vasowave.pulse.solver.state import State

_FILLED = 0.97  # of the largest area that a wall law has


class Lost(NumericalError):  # noqa: N818  what happened, not what kind of thing it is
    """A cycle ended early; from another start it may not."""


class TooSteep(Lost):
    """A wave does not fit the only cell of a vessel; on two it may."""


def left_law(grid: Grid, state: State, slot: int, face: float | None, time: float) -> Lost:
    """Return the error for a slot whose area left the range of its wall law, or that of its `face` (cm²)."""
    vessel = grid.vessel[slot]
    area, area0, wall = state.area[slot], grid.area0[slot], grid.wall
    if face is not None:
        area, area0, wall = face, grid.face_area0[slot], grid.face_wall
    low, high = (np.broadcast_to(limit, grid.vessel.shape)[slot] for limit in wall.limits(*wall))
    share = area / area0
    if share >= high:
        reason = (
            f"the wall reaches its largest area, {high:.3g} times the undeformed one; it cannot hold the flow that "
            "enters: stiffen it, lower the resistance, or check the units of the flow"
        )
    elif share <= low:
        reason = (
            f"the vessel collapses (its area falls to {max(share, 0.0):.2g} of the undeformed one); the wall is too "
            "soft for the flow that leaves it: raise its stiffness, or check the inflow for backflow"
        )
    else:
        reason = "area or flow is no longer a number; check the wall's stiffness and the outlets' resistance"
    return Lost(f"vessel '{grid.model.network.name[vessel]}', t = {time:.4g} s: {reason}{_speed(grid, state, vessel)}")


def too_steep(grid: Grid, vessel: int, time: float) -> TooSteep:
    """Return the error for a vessel of one cell, whose ends lie so far apart that their line leaves the wall law."""
    name, length = grid.model.network.name[vessel], grid.model.network.length[vessel]
    return TooSteep(
        f"vessel '{name}', t = {time:.4g} s: a wave is too steep for the only cell of this vessel ({length:.4g} cm); "
        f"take shorter cells, Numerics(cell_size={0.4 * length:.2g}), or a flow that rises less suddenly"
    )


def no_balance(grid: Grid, state: State, vessel: int, time: float) -> Lost:
    """Return the error for a node at the end of a vessel whose flows balance at no pressure."""
    name = grid.model.network.name[vessel]
    speed = _speed(grid, state, vessel)
    soft = "; the wall is too soft, or an outlet or a narrowing too tight, for the flow that arrives there"
    advice = "" if speed else soft
    if grid.model.total_pressure and vessel not in grid.model.network.terminals and not speed:
        advice = (
            "; at one total pressure a flow passes a junction no faster than its waves: check radius and taper of this "
            "vessel and of its daughters, or take junctions='static'"
        )
    return Lost(f"vessel '{name}', t = {time:.4g} s: no pressure balances the flows at its end{advice}{speed}")


def runaway(where: str, first: int, steps: int) -> Lost:
    """Return the error for a vessel (`where`) whose waves grow faster the smaller the steps are."""
    return Lost(
        f"{where}the wave speed grows without end as steps grow smaller (from {first} to {steps} a cycle): the wall is "
        "driven against its largest area, or a wave breaks; stiffen the wall, or lower the peak of the "
        "flow or the suddenness of its rise"
    )


def faster_than_allowed(grid: Grid, where: str, steps: int, limit: int) -> Lost:
    """Return the error for a vessel (`where`) whose waves turn out to ask for more than `limit` steps a cycle."""
    return Lost(
        f"{where}the waves there ask for about {steps} steps a cycle, more than most_steps = {limit}: check radius, "
        f"length and stiffness of this vessel{_fewer_steps(grid)}, or allow more steps (most_steps)"
    )


def no_waves(grid: Grid, vessel: int) -> NumericalError:
    """Return the error for a model so far from any animal's that its waves cannot be computed, first in a vessel."""
    return NumericalError(
        f"vessel '{grid.model.network.name[vessel]}': the waves there are too fast, too slow or too high for any "
        "number; check stiffness, resistance and compliance, and their units"
    )


def _fewer_steps(grid: Grid) -> str:
    """Return a clause with what asks for fewer steps where nothing is wrong with a vessel, if anything does."""
    if len(grid.counts) > 1:
        return ", merge it with its neighbor"
    return ", take longer cells (a larger cell_size)" if grid.counts[0] > 1 else ""


def too_many_steps(grid: Grid, linear: LinearSolution, demand: np.ndarray, limit: int) -> NumericalError:
    """Return the error for a model whose vessels ask for more than `limit` steps a cycle (`demand`, one per vessel)."""
    network, model = grid.model.network, grid.model
    v = int(np.argmax(demand))
    remaining_demand = np.delete(demand, v)
    head = (
        f"vessel '{network.name[v]}' ({network.length[v]:.4g} cm, radius {network.radius[v]:.4g} cm) asks for "
        f"about {demand[v]:.0f} steps a cycle, more than most_steps = {limit}"
    )
    if not len(remaining_demand):
        return NumericalError(f"{head}: check it{_fewer_steps(grid)}, or allow more steps (most_steps)")
    compliance = network.length * walls.area_compliance(model.wall, linear.mean_pressure, model.area0)
    fall = float(linear.resistance[v] * network.length[v] * linear.flow[0, v].real)
    return NumericalError(
        f"{head}; of {len(remaining_demand)} others the next asks for {np.max(remaining_demand):.0f}. "
        f"It holds {100 * compliance[v] / np.sum(compliance):.2g} % of the vessels' "
        f"compliance, and the mean flow loses {fall:.2g} mmHg in it: that is what merging it with its neighbor would "
        "change. Merge it, or allow more steps (most_steps)"
    )


def not_periodic(
    grid: Grid, state: State, beds: Rational, changes: tuple[float, ...], tolerance: float, period: float
) -> NumericalError:
    """Return the error for a state, the last, that does not repeat itself."""
    cycles, late = len(changes), changes[-min(10, len(changes)) :]
    reason = "the changes grow smaller: raise most_cycles, or tolerance"
    slowest = float(np.max(np.where(beds.residues != 0, -1.0 / beds.poles.real, 0.0), initial=0.0)) / period
    if cycles > len(late) and (min(late) >= 0.5 * changes[0] or late[-1] > 2 * min(late)):
        reason = (
            f"the changes no longer grow smaller, so that more cycles will not help: {at_the_edge(grid, state)}; "
            "simulate with cycles_from_rest to see it"
        )
    elif slowest > 3:
        reason += f"; the slowest bed's time constant is {slowest:.1f} periods long: check its compliance"
    return NumericalError(
        f"not periodic after {cycles} cycles: the last one still changed by {changes[-1]:.2g} mmHg (tolerance "
        f"{tolerance:.2g}); {reason}"
    )


def at_the_edge(grid: Grid, state: State) -> str:
    """Return which vessel is near collapse or near its largest area in a state, or that none is."""
    cells = np.flatnonzero(grid.is_cell)
    wall = type(grid.wall)(*(value[cells] for value in grid.wall))
    ratio, largest = state.area[cells] / grid.area0[cells], np.asarray(wall.limits(*wall)[1])
    p = np.asarray(walls.pressure(wall, state.area[cells], grid.area0[cells]))
    filled, lowest = int(np.argmax(ratio / largest)), int(np.argmin(p))
    if ratio[filled] > _FILLED * np.broadcast_to(largest, ratio.shape)[filled]:
        name = grid.model.network.name[grid.vessel[cells[filled]]]
        return f"vessel '{name}' is near its largest area (a pressure of {p[filled]:.4g} mmHg); stiffen it"
    if p[lowest] < wall.law().lowest:
        name = grid.model.network.name[grid.vessel[cells[lowest]]]
        return f"vessel '{name}' is near collapse ({p[lowest]:.4g} mmHg); check the inflow for backflow"
    return "no vessel is near collapse or near its largest area, the waves themselves do not settle"


def _speed(grid: Grid, state: State, vessel: int) -> str:
    """Return a clause where the flow in the vessel passes its wave speed, which explains the rest."""
    rows = np.flatnonzero((grid.vessel == vessel) & grid.is_cell)
    wall = type(grid.wall)(*(value[rows] for value in grid.wall))
    area, flow = state.area[rows], state.flow[rows]
    with np.errstate(invalid="ignore", divide="ignore"):
        p = walls.pressure(wall, area, grid.area0[rows])
        mach = np.abs(flow / area) / walls.wave_speed(wall, p, grid.model.blood.inertia)
    if not np.any(mach >= 1):
        return ""
    return f"; the flow passes the wave speed there (|u|/c = {np.nanmax(mach):.1f}): check the units of flow and radius"
