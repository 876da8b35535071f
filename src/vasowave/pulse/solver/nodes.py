"""The compiled scheme where vessels end: every node has one pressure, at which the flows into it balance.

It is the static pressure or, at junctions that keep energy, the total one: p + ½ρu² at every end, with what an end
loses between the two (`density`, `loss`, `viscous` of `Ends`). The dynamic pressure of an end is one more unknown of
Newton's method, which is eliminated end by end.

Every vessel end gives a straight line q = α + m A from the characteristic that leaves its vessel. An inlet, a junction
of any vessels' starts and ends, and an outlet are then the same equation for the node's pressure p::

    weight · (source + Σ ± q(p)) = outlet · (p - memory)

with weight 1 and outlet 0 at inlets (whose source is the inflow) and at junctions (without source), and weight R,
outlet 1 where a bed with p = memory + R q is connected; an inlet whose pressure is given is a bed with R = 0. Newton's
method solves all nodes together, end by end in arrays, which the compiler turns into vector instructions.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from vasowave.pulse.solver.beds import bed_pressure, remember
from vasowave.pulse.solver.cells import INLINED, OPTIONS, slowed
from vasowave.pulse.solver.grid import Ends
from vasowave.pulse.solver.laws import ratio_at, slope_at
from vasowave.pulse.solver.terms import Kinds, of_all, of_one

NEWTON_CLOSE = 1e-4  # mmHg; a smaller Newton step is taken linearly: what that neglects is below 1e-9 mmHg
NEWTON_MOST = 50  # steps, at most
LEAST_GIVE = 0.02  # 1 - |u|/c of a flow into a junction, at least: faster ones are slowed to find out that they are


class NodeStates(NamedTuple):
    """Scratch memory of one simulation: what every end and every node has at the half step."""

    area: np.ndarray  # (end,) of the cell next to the end, cm²
    flow: np.ndarray  # (end,)
    inner_area: np.ndarray  # (end,) of the cell behind that one
    inner_flow: np.ndarray  # (end,)
    cell_pressure: np.ndarray  # (end,)
    drag: np.ndarray  # (end,) 1/s
    gain: np.ndarray  # (end,) what a vessel that changes on its way adds to the flow by the end, ml/s
    intercept: np.ndarray  # (end,) α, ml/s
    slope: np.ndarray  # (end,) m, cm/s
    trial: np.ndarray  # (end,) pressure that is tried, mmHg
    end_area: np.ndarray  # (end,) at that pressure
    compliance: np.ndarray  # (end,) dA/dp at that pressure, later by the node's, cm²/mmHg
    missed: np.ndarray  # (end,) what the trial's dynamic pressure lacks, mmHg
    share: np.ndarray  # (end,) of a change of the node's pressure that becomes a static one
    dynamic: np.ndarray  # (4, end) pressure of the node above the end's at the last four half steps, the latest first
    pressure: np.ndarray  # (4, node) at the last four half steps, the latest first
    excess: np.ndarray  # (node,) flow into the node that its pressure leaves over, ml/s
    fall: np.ndarray  # (node,) its derivative by the pressure
    step: np.ndarray  # (node,) last Newton step, mmHg
    source: np.ndarray  # (node,) ml/s
    weight: np.ndarray  # (node,)
    outlet: np.ndarray  # (node,)
    memory: np.ndarray  # (node,) mmHg


def make_node_states(ends: Ends, of_pressure: bool = False) -> NodeStates:
    """Return scratch memory for one simulation; with `of_pressure` the inlets have a given pressure, not a flow."""
    count, nodes = len(ends.face), int(ends.start[1])
    at_ends, at_nodes = [np.ones(count) for _ in range(14)], [np.zeros(nodes) for _ in range(7)]
    states = NodeStates(*at_ends, np.zeros((4, count)), np.zeros((4, nodes)), *at_nodes)  # type: ignore[call-arg]
    states.gain[:] = 0.0
    states.weight[: ends.first_terminal] = 1.0
    states.outlet[ends.first_terminal :] = 1.0
    if of_pressure:
        states.weight[ends.inlet : ends.first_terminal] = 0.0
        states.outlet[ends.inlet : ends.first_terminal] = 1.0
    return states


@njit(**OPTIONS)
def gather(area, flow, fluxes, ends, nodes):
    """Collect what the ends need of their cells."""
    for e in range(len(ends.face)):
        end, inner = ends.cell[e], ends.inner[e]
        nodes.area[e], nodes.flow[e] = area[end], flow[end]
        nodes.inner_area[e], nodes.inner_flow[e] = area[inner], flow[inner]
        nodes.cell_pressure[e], nodes.drag[e] = fluxes.pressure[end], fluxes.drag[end]


@njit(**OPTIONS)
def characteristics(ends, wall, fluid, nodes):
    """Line q = α + m A that the characteristic leaving every vessel carries to its end.

    It starts at the foot, half a time step earlier, and keeps dq - m dA = -drag q dt along its way, m = u ∓ c being the
    other characteristic's speed.
    """
    for e in range(len(ends.face)):
        A, q, side, half = nodes.area[e], nodes.flow[e], ends.side[e], ends.half[e]
        c = np.sqrt(A * ends.per_area0[e] / (fluid.inertia * slope_at(wall, e, nodes.cell_pressure[e])))
        u = q / A
        reach = 0.5 - side * (u + side * c) * half
        foot_area = A + reach * (A - nodes.inner_area[e])
        foot_flow = q + reach * (q - nodes.inner_flow[e]) + nodes.gain[e]
        E, Phi = slowed(0.5 * ends.dt[e] * nodes.drag[e])
        m = Phi * (foot_flow / foot_area - side * c)
        nodes.slope[e] = m
        nodes.intercept[e] = E * foot_flow - m * foot_area


@njit(**OPTIONS)
def first_guess(step, ends, nodes):
    """Pressure of every node extrapolated from its last four half steps; at the start of a cycle its cell's."""
    p = nodes.pressure
    if step == 0:
        for k in range(p.shape[1]):
            p[:, k] = nodes.cell_pressure[k]
    extrapolate(p)
    if ends.dynamic:
        if step == 0:
            for e in range(len(ends.face)):
                u = nodes.flow[e] / nodes.area[e]
                nodes.dynamic[:, e] = (0.5 * (ends.density[e] * u + ends.loss[e] * abs(u)) + ends.viscous[e]) * u
            for k in range(p.shape[1]):
                p[0, k] += nodes.dynamic[0, k]
                p[1:, k] = p[0, k]
        extrapolate(nodes.dynamic)


@njit(**OPTIONS)
def extrapolate(p):
    """Put before the last four values of each column what a cubic through them has next."""
    for k in range(p.shape[1]):
        guess = 4.0 * (p[0, k] + p[2, k]) - 6.0 * p[1, k] - p[3, k]
        p[3, k], p[2, k], p[1, k], p[0, k] = p[2, k], p[1, k], p[0, k], guess


@njit(**OPTIONS)
def try_pressures(ends, wall, nodes):
    """Area and compliance of every end at the present pressure of its node."""
    for r in range(len(ends.start) - 1):
        first = ends.start[r]
        for k in range(ends.start[r + 1] - first):
            nodes.trial[first + k] = nodes.pressure[0, k]
    if ends.dynamic:
        for e in range(len(ends.face)):
            nodes.trial[e] -= nodes.dynamic[0, e]
    for e in range(len(ends.face)):
        nodes.end_area[e] = ends.area0[e] * ratio_at(wall, e, nodes.trial[e])
        nodes.compliance[e] = ends.area0[e] * slope_at(wall, e, nodes.trial[e])


@njit(**OPTIONS)
def eliminate_dynamic(ends, nodes):
    """Make area and compliance of every end those by its node's pressure, whatever the end's velocity makes of it.

    With D(p) the dynamic pressure on the characteristic, a change of the node's pressure by dP moves that of the end by
    (dP - missed)/(1 + dD/dp). Without loss 1 + dD/dp is 1 - |u|/c, of a flow to the node.
    """
    for e in range(len(ends.face)):
        A = nodes.end_area[e]
        u = nodes.intercept[e] / A + nodes.slope[e]
        by_speed = ends.density[e] * u + ends.loss[e] * abs(u)
        max_step = 5.0 + 0.5 * abs(nodes.trial[e])
        head = (0.5 * by_speed + ends.viscous[e]) * u
        nodes.missed[e] = min(max(head - nodes.dynamic[0, e], -max_step), max_step)
        by_pressure = -(by_speed + ends.viscous[e]) * nodes.intercept[e] * nodes.compliance[e] / (A * A)
        nodes.share[e] = 1.0 / max(1.0 + by_pressure, LEAST_GIVE)
        nodes.compliance[e] *= nodes.share[e]
        nodes.end_area[e] -= nodes.compliance[e] * nodes.missed[e]


@njit(**OPTIONS)
def move_dynamic(ends, nodes):
    """Move all dynamic pressures by the Newton step of the nodes; returns whether the ends' own steps were small."""
    small = True
    for r in range(len(ends.start) - 1):
        first = ends.start[r]
        for k in range(ends.start[r + 1] - first):
            e = first + k
            moved = nodes.share[e] * (nodes.step[k] - nodes.missed[e])
            nodes.dynamic[0, e] += nodes.step[k] - moved
            small &= abs(moved) < NEWTON_CLOSE
    return small


@njit(**OPTIONS)
def newton_step(ends, nodes):
    """Move every node's pressure by one Newton step; returns whether all steps were small.

    A step is no longer than the pressure allows: laws that saturate throw a full step out of their range.
    """
    for k in range(len(nodes.step)):
        nodes.excess[k], nodes.fall[k] = nodes.source[k], 0.0
    for r in range(len(ends.start) - 1):
        first = ends.start[r]
        for k in range(ends.start[r + 1] - first):
            e = first + k
            m = ends.side[e] * nodes.slope[e]
            nodes.excess[k] += ends.side[e] * nodes.intercept[e] + m * nodes.end_area[e]
            nodes.fall[k] += m * nodes.compliance[e]
    small = True
    for k in range(len(nodes.step)):
        p = nodes.pressure[0, k]
        excess = nodes.weight[k] * nodes.excess[k] - nodes.outlet[k] * (p - nodes.memory[k])
        step = -excess / (nodes.weight[k] * nodes.fall[k] - nodes.outlet[k])
        max_step = 5.0 + 0.5 * abs(p)
        step = min(max(step, -max_step), max_step)
        nodes.step[k] = step
        nodes.pressure[0, k] = p + step
        small &= abs(step) < NEWTON_CLOSE
    return small


@njit(**OPTIONS)
def close_ends(ends, nodes, faces):
    """Move all ends by the last, small Newton step; linear, so that the flows at every node balance exactly."""
    for r in range(len(ends.start) - 1):
        first = ends.start[r]
        for k in range(ends.start[r + 1] - first):
            nodes.end_area[first + k] += nodes.compliance[first + k] * nodes.step[k]
    for e in range(len(ends.face)):
        faces.area[ends.face[e]] = nodes.end_area[e]
        faces.flow[ends.face[e]] = nodes.intercept[e] + nodes.slope[e] * nodes.end_area[e]


@njit(**OPTIONS)
def meet_outside(inflow, outlet, memory, ends, nodes):
    """What inlets and beds ask of their nodes at this half step."""
    for i in range(len(inflow)):
        if nodes.weight[ends.inlet + i] == 0.0:  # the pressure is given
            nodes.memory[ends.inlet + i] = inflow[i]
        else:
            nodes.source[ends.inlet + i] = inflow[i]
    for k in range(ends.first_terminal, len(nodes.step)):
        j = k - ends.first_terminal
        nodes.memory[k], nodes.weight[k] = bed_pressure(outlet, memory, j), outlet.resistance[j]


@njit(**OPTIONS)
def balance(ends, wall, nodes):
    """Find the pressures at which the flows into all nodes balance; returns whether that succeeded."""
    for _ in range(NEWTON_MOST):
        try_pressures(ends, wall, nodes)
        if ends.dynamic:
            eliminate_dynamic(ends, nodes)
        small = newton_step(ends, nodes)
        if ends.dynamic:
            small &= move_dynamic(ends, nodes)
        if small:
            return True
    return False


@njit(**OPTIONS)
def fill_beds(outlet, memory, ends, nodes, faces):
    """Let the flows of this half step into the beds."""
    for k in range(ends.first_terminal, len(nodes.step)):
        remember(outlet, memory, k - ends.first_terminal, faces.flow[ends.face[k]])


@njit(**OPTIONS)
def worst_node(nodes):
    """Return the node whose last Newton step was the longest."""
    where = 0
    for k in range(len(nodes.step)):
        if abs(nodes.step[k]) > abs(nodes.step[where]):
            where = k
    return where


def _stay(terms, step, n):
    return False


def nodes_solver(kinds: Kinds) -> Any:
    """Return what finds the state of all ends (eqs. 6, 7), compiled: the nodes alone, or a term that joins vessels."""
    meet, after_nodes, moves = of_all("meet", kinds), of_all("after_nodes", kinds), of_one("moves", kinds, _stay)
    prepare, balanced, worst = (of_one(name, kinds) for name in ("prepare", "solve", "worst"))

    @njit(**INLINED)
    def solve_nodes(inflow, memory, scheme, half, terms, step, n):
        """State of all vessel ends at the half step (eqs. 6, 7); returns the node that has no solution, or -1."""
        outlet, ends, wall, faces, nodes = scheme.outlet, scheme.ends, scheme.walls.ends, half.faces, half.nodes
        meet_outside(inflow, outlet, memory, ends, nodes)
        first_guess(n, ends, nodes)
        for turn in range(2):
            meet(terms, step, n)
            if not balance(ends, wall, nodes):
                return worst_node(nodes)
            close_ends(ends, nodes, faces)
            if turn > 0 or not moves(terms, step, n):
                break
        after_nodes(terms, step, n)
        fill_beds(outlet, memory, ends, nodes, faces)
        return -1

    @njit(**INLINED)
    def solve_joined_nodes(inflow, memory, scheme, half, terms, step, n):
        """As `solve_nodes`, where a term has a part in the balance; returns the end that has no solution, or -1."""
        meet_outside(inflow, scheme.outlet, memory, scheme.ends, half.nodes)
        prepare(terms, step, n)
        for turn in range(2):
            meet(terms, step, n)
            if not balanced(terms, step, n):
                return worst(terms, step, n)
            if turn > 0 or not moves(terms, step, n):
                break
        after_nodes(terms, step, n)
        fill_beds(scheme.outlet, memory, scheme.ends, half.nodes, half.faces)
        return -1

    return solve_nodes if balanced is None else solve_joined_nodes
