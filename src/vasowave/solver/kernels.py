"""The compiled scheme: two-step Lax-Wendroff in the vessels, characteristics at their ends, one pressure a node.

One step goes from level n to n + 1. At the half step between, every face has a state (A, q, p): inner faces by the
first Lax-Wendroff step, vessel ends from their node. The cells then take the difference of the faces' fluxes, so
whatever volume leaves a cell enters its neighbour, and the network keeps volume to round-off.

Half steps lie at t = 0, dt, 2dt …: inflow, outlets and output live there, and nothing is interpolated in time.
"""

import hashlib
import inspect
import sys
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from vasowave import walls
from vasowave.solver import grid, laws
from vasowave.solver.grid import Cells, Nodes
from vasowave.solver.laws import outlet_line, pressure_at, ratio_at, remember, slope_at

_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": {"contract", "reassoc", "nsz"}}

_part = njit(
    inline="always", **_OPTIONS
)  # for what runs once per vessel end: a real call would cost more than its body

DONE, LEFT_LAW, NODE_FAILED = 0, 1, 2
"""How a cycle ended: well; an area outside the wall law; a node whose pressure was not found."""

_NEWTON_CLOSE = 1e-5  # mmHg; a smaller Newton step is taken linearly: what that neglects is below 1e-11 mmHg
_NEWTON_MOST = 50


class Fluid(NamedTuple):
    """Blood in the units of the model: density (mmHg s²/cm²) and friction (k0 + k1 √A) q/A."""

    inertia: float
    k0: float
    k1: float


class Faces(NamedTuple):
    """State at the faces at the half step, and the fluxes of the cells; scratch memory of one simulation."""

    area: np.ndarray
    flow: np.ndarray
    pressure: np.ndarray
    cell_pressure: np.ndarray
    momentum: np.ndarray
    friction: np.ndarray
    line: np.ndarray  # (vessel, 2, 2): q = line[v, end, 0] + line[v, end, 1] · A at the inlet (0) and outlet (1)
    node: np.ndarray  # (junction + terminal, 3): pressure at the last three half steps, the latest first


@njit(**_OPTIONS)
def cell_fluxes(area, flow, cells, wall, fluid, faces):
    """Pressure, momentum flux q²/A and friction of every cell (eqs. 2, 3, 4); False if an area left the wall law."""
    inside = True
    for j in range(len(area)):
        A, q = area[j], flow[j]
        inside &= (A > cells.smallest[j]) & (A < cells.largest[j])
        u = q / A
        faces.cell_pressure[j] = pressure_at(wall, j, A / cells.area0[j])
        faces.momentum[j] = q * u
        faces.friction[j] = (fluid.k0 + fluid.k1 * np.sqrt(A)) * u
    return inside


@njit(**_OPTIONS)
def inner_faces(area, flow, cells, fluid, faces):
    """First Lax-Wendroff step: A and q at every face at the half step (vessel ends are overwritten later)."""
    for j in range(1, len(area)):
        half = cells.half[j - 1]
        A = 0.5 * (area[j - 1] + area[j])
        faces.area[j] = A - half * (flow[j] - flow[j - 1])
        force = faces.momentum[j] - faces.momentum[j - 1]
        force += A / fluid.inertia * (faces.cell_pressure[j] - faces.cell_pressure[j - 1])
        drag = 0.25 * cells.dt[j - 1] * (faces.friction[j - 1] + faces.friction[j])
        faces.flow[j] = 0.5 * (flow[j - 1] + flow[j]) - half * force - drag


@_part
def characteristic(end, inner, side, area, flow, cells, wall, fluid, faces):
    """Line q = α + m A that the characteristic leaving the vessel carries to its end, and the Courant number there.

    It starts at the foot, half a time step earlier, and keeps dq - m dA = -friction dt along its way, m = u ∓ c being
    the other characteristic's speed. `side` is 1 at an outlet, -1 at an inlet; `end` and `inner` are the cells nearest.
    """
    A, q, half = area[end], flow[end], cells.half[end]
    a, p = A / cells.area0[end], faces.cell_pressure[end]
    c = np.sqrt(a / (fluid.inertia * slope_at(wall, end, p)))
    u = q / A
    reach = 0.5 - side * (u + side * c) * half
    foot_area = A + reach * (A - area[inner])
    foot_flow = q + reach * (q - flow[inner])
    m = foot_flow / foot_area - side * c
    intercept = foot_flow - m * foot_area - 0.5 * cells.dt[end] * faces.friction[end]
    return intercept, m, (abs(u) + c) * 2.0 * half


@njit(**_OPTIONS)
def all_ends(area, flow, cells, wall, fluid, nodes, faces):
    """Lines of all vessel ends; returns the largest Courant number at an end and its vessel."""
    largest, where = 0.0, 0
    for v in range(len(nodes.first)):
        i, k = nodes.first[v], nodes.last[v] - 1
        alpha, m, courant = characteristic(i, i + 1, -1.0, area, flow, cells, wall, fluid, faces)
        faces.line[v, 0, 0], faces.line[v, 0, 1] = alpha, m
        if courant > largest:
            largest, where = courant, v
        alpha, m, courant = characteristic(k, k - 1, 1.0, area, flow, cells, wall, fluid, faces)
        faces.line[v, 1, 0], faces.line[v, 1, 1] = alpha, m
        if courant > largest:
            largest, where = courant, v
    return largest, where


@_part
def try_end(v, end, cell, face, p, wall, cells, faces):
    """Put pressure p on a vessel end; returns the flow there and its derivative by p."""
    m = faces.line[v, end, 1]
    A = cells.area0[cell] * ratio_at(wall, cell, p)
    q = faces.line[v, end, 0] + m * A
    faces.area[face] = A
    faces.flow[face] = q
    faces.momentum[face] = cells.area0[cell] * slope_at(wall, cell, p)  # kept until the end is closed
    return q, m * faces.momentum[face]


@_part
def close_end(v, end, face, dp, faces):
    """Move a vessel end by the last, small Newton step; linear, so that the flows at its node sum to zero exactly."""
    dA = faces.momentum[face] * dp
    faces.area[face] += dA
    faces.flow[face] += faces.line[v, end, 1] * dA


@_part
def inlet(q, cells, wall, nodes, faces):
    """Root: the inflow is given, the line gives the area, the wall law the pressure."""
    v = nodes.root[0]
    face = nodes.first[v]
    faces.area[face] = (q - faces.line[v, 0, 0]) / faces.line[v, 0, 1]
    faces.flow[face] = q


@_part
def next_guess(node, step, cell, faces):
    """Pressure of a node extrapolated from its last three half steps; at the start of a cycle its cell's pressure."""
    if step == 0:
        for i in range(3):
            faces.node[node, i] = faces.cell_pressure[cell]
    return 3.0 * (faces.node[node, 0] - faces.node[node, 1]) + faces.node[node, 2]


@_part
def limited(step, p):
    """Newton step no longer than the pressure allows: laws that saturate throw a full step out of their range."""
    most = 5.0 + 0.5 * abs(p)
    return min(max(step, -most), most)


@_part
def keep_pressure(node, p, faces):
    """Let a node's new pressure into its history."""
    faces.node[node, 2] = faces.node[node, 1]
    faces.node[node, 1] = faces.node[node, 0]
    faces.node[node, 0] = p


@njit(**_OPTIONS)
def junction(k, step_number, cells, wall, nodes, faces):
    """One pressure for all ends that meet, such that the flows sum to zero (eq. 6): Newton's method in p."""
    v = nodes.parent[k]
    p = next_guess(k, step_number, nodes.last[v] - 1, faces)
    for _ in range(_NEWTON_MOST):
        excess, slope = try_end(v, 1, nodes.last[v] - 1, nodes.last[v], p, wall, cells, faces)
        for i in range(nodes.start[k], nodes.start[k + 1]):
            d = nodes.daughter[i]
            q, change = try_end(d, 0, nodes.first[d], nodes.first[d], p, wall, cells, faces)
            excess -= q
            slope -= change
        step = limited(-excess / slope, p)
        p += step
        if abs(step) < _NEWTON_CLOSE:
            close_end(v, 1, nodes.last[v], step, faces)
            for i in range(nodes.start[k], nodes.start[k + 1]):
                close_end(nodes.daughter[i], 0, nodes.first[nodes.daughter[i]], step, faces)
            keep_pressure(k, p, faces)
            return True
    return False


@njit(**_OPTIONS)
def terminal(j, node, outlet, memory, step_number, cells, wall, nodes, faces):
    """Outlet: p = memory + resistance · q meets the vessel's line; Newton's method in p (eq. 7)."""
    v = nodes.terminal[j]
    past, resistance = outlet_line(outlet, memory, j, step_number)
    p = next_guess(node, step_number, nodes.last[v] - 1, faces)
    for _ in range(_NEWTON_MOST):
        q, slope = try_end(v, 1, nodes.last[v] - 1, nodes.last[v], p, wall, cells, faces)
        step = limited(-(p - past - resistance * q) / (1.0 - resistance * slope), p)
        p += step
        if abs(step) < _NEWTON_CLOSE:
            close_end(v, 1, nodes.last[v], step, faces)
            remember(outlet, memory, j, step_number, faces.flow[nodes.last[v]])
            keep_pressure(node, p, faces)
            return True
    return False


@njit(**_OPTIONS)
def face_fluxes(cells, wall, fluid, faces):
    """Pressure, momentum flux q²/A and friction at all faces; False if an area left the wall law."""
    inside = True
    for j in range(len(faces.area)):
        A, q = faces.area[j], faces.flow[j]
        inside &= (A > cells.smallest[j]) & (A < cells.largest[j])
        u = q / A
        faces.pressure[j] = pressure_at(wall, j, A / cells.area0[j])
        faces.momentum[j] = q * u
        faces.friction[j] = (fluid.k0 + fluid.k1 * np.sqrt(A)) * u
    return inside


@njit(**_OPTIONS)
def update_cells(area, flow, cells, fluid, faces):
    """Second Lax-Wendroff step: every cell takes the difference of its faces (eq. 2)."""
    for j in range(len(area) - 1):
        twice = 2.0 * cells.half[j]
        area[j] -= twice * (faces.flow[j + 1] - faces.flow[j])
        force = faces.momentum[j + 1] - faces.momentum[j]
        mean_area = 0.5 * (faces.area[j] + faces.area[j + 1])
        force += mean_area / fluid.inertia * (faces.pressure[j + 1] - faces.pressure[j])
        flow[j] -= twice * force + 0.5 * cells.dt[j] * (faces.friction[j] + faces.friction[j + 1])


@_part
def worst_cell(area, cells):
    """First slot whose area is outside its wall law or not a number."""
    for j in range(len(area)):
        if not ((area[j] > cells.smallest[j]) & (area[j] < cells.largest[j])):
            return j
    return 0


@njit(**_OPTIONS)
def largest_courant(area, flow, cells, wall, fluid, faces):
    """Largest Courant number (|u| + c) dt/dx over all cells, and its slot."""
    largest, where = 0.0, 0
    for j in range(len(area)):
        a = area[j] / cells.area0[j]
        c = np.sqrt(a / (fluid.inertia * slope_at(wall, j, faces.cell_pressure[j])))
        courant = (abs(flow[j] / area[j]) + c) * 2.0 * cells.half[j]
        if courant > largest:
            largest, where = courant, j
    return largest, where


@njit(**_OPTIONS)
def solve_nodes(q, step, outlet, memory, cells, wall, nodes, faces):
    """Inlet, all junctions, all terminals; returns the vessel whose node failed, or -1."""
    inlet(q, cells, wall, nodes, faces)
    count = len(nodes.parent)
    for k in range(count):
        if not junction(k, step, cells, wall, nodes, faces):
            return nodes.parent[k]
    for j in range(len(nodes.terminal)):
        if not terminal(j, count + j, outlet, memory, step, cells, wall, nodes, faces):
            return nodes.terminal[j]
    return -1


@njit(**_OPTIONS)
def record_stations(sample, nodes, faces, out):
    """Area and flow at inlet, middle and outlet of every vessel into out[0] and out[1]."""
    for v in range(len(nodes.first)):
        i, k = nodes.first[v], nodes.last[v]
        left = (i + k) // 2
        right = i + k - left  # the same face for an even number of cells, else the two around the middle cell
        for kind, values in enumerate((faces.area, faces.flow)):
            out[kind, sample, v, 0] = values[i]
            out[kind, sample, v, 1] = 0.5 * (values[left] + values[right])
            out[kind, sample, v, 2] = values[k]


def _source_fingerprint() -> str:
    """Hash of everything that is compiled: it stands in the kernel's closure, so that no stale binary is ever run."""
    text = "".join(inspect.getsource(module) for module in (walls, laws, grid, sys.modules[__name__]))
    return hashlib.sha256(text.encode()).hexdigest()


def _compiled(fingerprint: str) -> Any:
    @njit(cache=True, **_OPTIONS)
    def advance_cycle(area, flow, memory, inflow, wall, outlet, cells, nodes, fluid, faces, out, cell_out):
        _ = fingerprint
        steps = len(inflow)
        every = steps // out.shape[1]
        per_cell = cell_out.shape[1] > 0
        report = np.zeros(8)  # status, slot or vessel, step; Courant number, its vessel, its step; volume in, out
        for n in range(steps):
            sampled = n % every == 0
            if not cell_fluxes(area, flow, cells, wall, fluid, faces):
                report[0], report[1], report[2] = LEFT_LAW, worst_cell(area, cells), n
                return report
            inner_faces(area, flow, cells, fluid, faces)
            courant, v = all_ends(area, flow, cells, wall, fluid, nodes, faces)
            if sampled:
                inner, slot = largest_courant(area, flow, cells, wall, fluid, faces)
                if inner > courant:
                    courant, v = inner, np.searchsorted(nodes.last, slot)
            if courant > report[3]:
                report[3], report[4], report[5] = courant, v, n
            failed = solve_nodes(inflow[n], n, outlet, memory, cells, wall, nodes, faces)
            if failed >= 0:
                report[0], report[1], report[2] = NODE_FAILED, failed, n
                return report
            if not face_fluxes(cells, wall, fluid, faces):
                report[0], report[1], report[2] = LEFT_LAW, worst_cell(faces.area, cells), n
                return report
            if sampled:
                record_stations(n // every, nodes, faces, out)
                if per_cell:
                    cell_out[0, n // every] = area
                    cell_out[1, n // every] = flow
            update_cells(area, flow, cells, fluid, faces)
            if sampled and per_cell:  # the cell at the half step is the mean of before and after
                cell_out[0, n // every] = 0.5 * (cell_out[0, n // every] + area)
                cell_out[1, n // every] = 0.5 * (cell_out[1, n // every] + flow)
            report[6] += inflow[n]
            for j in range(len(nodes.terminal)):
                report[7] += faces.flow[nodes.last[nodes.terminal[j]]]
        if not cell_fluxes(area, flow, cells, wall, fluid, faces):
            report[0], report[1], report[2] = LEFT_LAW, worst_cell(area, cells), steps
        return report

    return advance_cycle


advance_cycle = _compiled(_source_fingerprint())


def make_faces(slots: int, nodes: Nodes) -> Faces:
    """Return scratch memory for one simulation."""
    area, flow, pressure, cell_pressure, momentum, friction = np.ones((6, slots))
    line = np.zeros((len(nodes.first), 2, 2))
    node = np.zeros((len(nodes.parent) + len(nodes.terminal), 3))
    return Faces(area, flow, pressure, cell_pressure, momentum, friction, line, node)


__all__ = ["DONE", "LEFT_LAW", "NODE_FAILED", "Cells", "Faces", "Fluid", "advance_cycle", "make_faces"]
