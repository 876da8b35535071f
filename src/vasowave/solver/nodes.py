"""The compiled scheme where vessels end: every node has one pressure, at which the flows into it balance.

Every vessel end gives a straight line q = α + m A from the characteristic that leaves its vessel. The inlet, a junction
of any number of vessels, and an outlet are then the same equation for the node's pressure p::

    weight · (source + Σ ± q(p)) = outlet · (p - memory)

with weight 1 and outlet 0 at the inlet (whose source is the inflow) and at junctions (without source), and weight R,
outlet 1 where a bed with p = memory + R q is connected. Newton's method solves all nodes together, end by end in
arrays, which the compiler turns into vector instructions.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vasowave.solver.cells import OPTIONS, slowed
from vasowave.solver.grid import Ends
from vasowave.solver.laws import outlet_line, ratio_at, remember, slope_at

_NEWTON_CLOSE = 1e-4  # mmHg; a smaller Newton step is taken linearly: what that neglects is below 1e-9 mmHg
_NEWTON_MOST = 50


class NodeStates(NamedTuple):
    """Scratch memory of one simulation: what every end and every node has at the half step."""

    area: np.ndarray  # (end,) of the cell next to the end, cm²
    flow: np.ndarray  # (end,)
    inner_area: np.ndarray  # (end,) of the cell behind that one
    inner_flow: np.ndarray  # (end,)
    cell_pressure: np.ndarray  # (end,)
    drag: np.ndarray  # (end,) 1/s
    intercept: np.ndarray  # (end,) α, ml/s
    slope: np.ndarray  # (end,) m, cm/s
    trial: np.ndarray  # (end,) pressure that is tried, mmHg
    end_area: np.ndarray  # (end,) at that pressure
    compliance: np.ndarray  # (end,) dA/dp at that pressure, cm²/mmHg
    pressure: np.ndarray  # (3, node) at the last three half steps, the latest first
    step: np.ndarray  # (node,) last Newton step, mmHg
    source: np.ndarray  # (node,) ml/s
    weight: np.ndarray  # (node,)
    outlet: np.ndarray  # (node,)
    memory: np.ndarray  # (node,) mmHg


def make_node_states(ends: Ends) -> NodeStates:
    """Return scratch memory for one simulation."""
    count, nodes, beds = len(ends.face), len(ends.start) - 1, len(ends.terminal_node)
    at_ends, at_nodes = [np.ones(count) for _ in range(11)], [np.zeros(nodes) for _ in range(5)]
    states = NodeStates(*at_ends, np.zeros((3, nodes)), *at_nodes)  # type: ignore[call-arg]
    states.weight[: nodes - beds] = 1.0
    states.outlet[nodes - beds :] = 1.0
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
        c = np.sqrt(A / ends.area0[e] / (fluid.inertia * slope_at(wall, e, nodes.cell_pressure[e])))
        u = q / A
        reach = 0.5 - side * (u + side * c) * half
        foot_area = A + reach * (A - nodes.inner_area[e])
        foot_flow = q + reach * (q - nodes.inner_flow[e])
        E, Phi = slowed(0.5 * ends.dt[e] * nodes.drag[e])
        m = Phi * (foot_flow / foot_area - side * c)
        nodes.slope[e] = m
        nodes.intercept[e] = E * foot_flow - m * foot_area


@njit(**OPTIONS)
def first_guess(step, ends, nodes):
    """Pressure of every node extrapolated from its last three half steps; at the start of a cycle its cell's."""
    p = nodes.pressure
    if step == 0:
        for k in range(p.shape[1]):
            p[:, k] = nodes.cell_pressure[ends.start[k]]
    for k in range(p.shape[1]):
        guess = 3.0 * (p[0, k] - p[1, k]) + p[2, k]
        p[2, k], p[1, k], p[0, k] = p[1, k], p[0, k], guess


@njit(**OPTIONS)
def try_pressures(ends, wall, nodes):
    """Area and compliance of every end at the present pressure of its node."""
    for e in range(len(ends.face)):
        nodes.trial[e] = nodes.pressure[0, ends.node[e]]
    for e in range(len(ends.face)):
        nodes.end_area[e] = ends.area0[e] * ratio_at(wall, e, nodes.trial[e])
        nodes.compliance[e] = ends.area0[e] * slope_at(wall, e, nodes.trial[e])


@njit(**OPTIONS)
def newton_step(ends, nodes):
    """Move every node's pressure by one Newton step; returns the largest step and its node.

    A step is no longer than the pressure allows: laws that saturate throw a full step out of their range.
    """
    largest, where = 0.0, 0
    for k in range(len(nodes.step)):
        excess, slope = nodes.source[k], 0.0
        for e in range(ends.start[k], ends.start[k + 1]):
            m = nodes.slope[e]
            excess += ends.side[e] * (nodes.intercept[e] + m * nodes.end_area[e])
            slope += ends.side[e] * m * nodes.compliance[e]
        p = nodes.pressure[0, k]
        excess = nodes.weight[k] * excess - nodes.outlet[k] * (p - nodes.memory[k])
        slope = nodes.weight[k] * slope - nodes.outlet[k]
        step = -excess / slope
        if step != step:
            return np.inf, k
        most = 5.0 + 0.5 * abs(p)
        step = min(max(step, -most), most)
        nodes.step[k] = step
        nodes.pressure[0, k] = p + step
        if abs(step) > largest:
            largest, where = abs(step), k
    return largest, where


@njit(**OPTIONS)
def close_ends(ends, nodes, faces):
    """Move all ends by the last, small Newton step; linear, so that the flows at every node balance exactly."""
    for e in range(len(ends.face)):
        A = nodes.end_area[e] + nodes.compliance[e] * nodes.step[ends.node[e]]
        faces.area[ends.face[e]] = A
        faces.flow[ends.face[e]] = nodes.intercept[e] + nodes.slope[e] * A


@njit(**OPTIONS)
def solve_nodes(inflow, step, outlet, memory, ends, wall, nodes, faces):
    """State of all vessel ends at the half step (eqs. 6, 7); returns the node that has no solution, or -1."""
    beds = len(ends.terminal_node)
    nodes.source[0] = inflow
    for j in range(beds):
        k = ends.terminal_node[j]
        nodes.memory[k], nodes.weight[k] = outlet_line(outlet, memory, j, step)
    first_guess(step, ends, nodes)
    where = 0
    for _ in range(_NEWTON_MOST):
        try_pressures(ends, wall, nodes)
        largest, where = newton_step(ends, nodes)
        if largest < _NEWTON_CLOSE:
            close_ends(ends, nodes, faces)
            for j in range(beds):
                remember(outlet, memory, j, step, faces.flow[ends.face[ends.start[ends.terminal_node[j]]]])
            return -1
    return where
