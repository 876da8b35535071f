"""The scheme where vessels end (`nodes`), linearized: how small changes pass from vessel to vessel and into outlets.

At every end the flow changes by ``r + m dA``: m is the slope of its characteristic's line, and r what the cells of its
vessel, its wall and its length bring. The area changes by ``C (dp - g)``: C is the compliance, and g what the wall
brings. The flows into a node stay in balance, which is one linear equation for its dp. Where the node shares the total
pressure, that of the end changes by the node's less what its velocity takes: C is smaller there, and g has a part of r.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from vasowave.pulse.solver.cells import INLINED, OPTIONS
from vasowave.pulse.solver.laws import slope_at
from vasowave.pulse.solver.terms import Kinds, change_of_one
from vasowave.pulse.solver.variations import SHIFT, differentiate_slowed


class EndSlopes(NamedTuple):
    """Derivatives of r and g at every end, and what they are made of; scratch memory."""

    cell_pressure: np.ndarray  # (end,) of the pressure of the cell next to the end, by its area
    cell_drag: np.ndarray  # (end,) of its drag
    end_area: np.ndarray  # (end,) A at the end, cm²
    compliance: np.ndarray  # (end,) C
    line: np.ndarray  # (end,) ± m C
    speed: np.ndarray  # (end,) c next to the end, cm/s
    by_flow: np.ndarray  # (end,) of the dynamic pressure by the flow, mmHg s/ml
    by_softness: np.ndarray  # (end,) of c by dA/dp, in central differences
    area: np.ndarray  # (end,) of r by the area of the cell next to the end
    flow: np.ndarray  # (end,) by its flow
    by_foot_flow: np.ndarray  # (end,) by the flow at the foot of the characteristic
    inner_area: np.ndarray  # (end,) by the area of the cell behind that one
    inner_flow: np.ndarray  # (end,)
    length: np.ndarray  # (end,) by the logarithm of the vessel's length
    by_speed: np.ndarray  # (end,) by c
    wall: np.ndarray  # (parameter + 1, end) by the logarithms of the law's parameters and of A0
    pressure: np.ndarray  # (parameter + 1, end) of g by the same
    give: np.ndarray  # (node,) change of its pressure by the flow into it, mmHg s/ml


class EndChanges(NamedTuple):
    """Changes in one direction; scratch memory."""

    flow: np.ndarray  # (end,) r
    wall: np.ndarray  # (end,) g
    balance: np.ndarray  # (end,) flow into the node at an unchanged pressure
    inflow: np.ndarray  # (node,) the same of all its ends
    pressure: np.ndarray  # (node,)


class OutletChanges(NamedTuple):
    """Changes of `beds.BedSteps` in every direction, shape (direction, terminal, mode) or (direction, terminal).

    Beside them stand those of the memory, and the memory before the step, shape (terminal, mode).
    """

    decay_half: np.ndarray
    decay: np.ndarray
    gain_half: np.ndarray
    gain: np.ndarray
    resistance: np.ndarray
    memory: np.ndarray
    before: np.ndarray


@njit(**OPTIONS)
def gather_slopes(ends, nodes, faces, cell_slopes, face_slopes, slopes):
    """Collect what the ends need of the derivatives in their cells and at their faces."""
    for e in range(len(ends.face)):
        cell, face = ends.cell[e], ends.face[e]
        slopes.cell_pressure[e], slopes.cell_drag[e] = cell_slopes.pressure[cell], cell_slopes.drag[cell]
        slopes.end_area[e], slopes.compliance[e] = faces.area[face], 1.0 / face_slopes.pressure[face]
        slopes.by_flow[e] = 0.0
    if ends.dynamic:
        for e in range(len(ends.face)):
            A, u = faces.area[ends.face[e]], faces.flow[ends.face[e]] / faces.area[ends.face[e]]
            slopes.by_flow[e] = (ends.density[e] * u + ends.loss[e] * abs(u) + ends.viscous[e]) / A
            slopes.compliance[e] /= 1.0 + slopes.compliance[e] * slopes.by_flow[e] * (nodes.slope[e] - u)
    for e in range(len(ends.face)):
        slopes.line[e] = ends.side[e] * nodes.slope[e] * slopes.compliance[e]
    for k in range(len(slopes.wall)):
        for e in range(len(ends.face)):
            slopes.wall[k, e] = cell_slopes.wall[k, ends.cell[e]]
            slopes.pressure[k, e] = face_slopes.wall[k, ends.face[e]]


@njit(**OPTIONS)
def differentiate_speeds(ends, fluid, wall, shifted, nodes, slopes):
    """Derivatives of the wave speed c next to every end; `slopes.wall` has those of the pressure, then of c."""
    last = len(slopes.wall) - 1
    for e in range(len(ends.face)):
        p, A = nodes.cell_pressure[e], nodes.area[e]
        softness, shift = slope_at(wall, e, p), SHIFT * A * slopes.cell_pressure[e]
        softer = slope_at(wall, e, p + shift) - slope_at(wall, e, p - shift)
        c = np.sqrt(A / (ends.area0[e] * fluid.inertia * softness))
        slopes.speed[e], slopes.by_softness[e] = c, -0.25 * c / (SHIFT * softness)
        slopes.wall[last, e] = -0.5 * c - slopes.by_softness[e] * softer
    k = 0
    for up, down in shifted:
        for e in range(len(ends.face)):
            p, shift = nodes.cell_pressure[e], SHIFT * slopes.wall[k, e]
            softer = slope_at(up, e, p + shift) - slope_at(down, e, p - shift)
            slopes.wall[k, e] = slopes.by_softness[e] * softer
        k += 1  # noqa: SIM113  as in `variations`


@njit(**OPTIONS)
def differentiate_characteristics(ends, nodes, slopes):
    """Derivatives of r at every end, by the chain from the foot of the characteristic on."""
    last = len(slopes.wall) - 1
    for e in range(len(ends.face)):
        A, q, side, half, c = nodes.area[e], nodes.flow[e], ends.side[e], ends.half[e], slopes.speed[e]
        u = q / A
        reach = 0.5 - side * (u + side * c) * half
        to_end_area, to_end_flow = A - nodes.inner_area[e], q - nodes.inner_flow[e]
        foot_area, foot_flow = A + reach * to_end_area, q + reach * to_end_flow + nodes.gain[e]
        foot_speed, area_difference = foot_flow / foot_area, slopes.end_area[e] - foot_area
        E, Phi, dE, dPhi = differentiate_slowed(0.5 * ends.dt[e] * nodes.drag[e])

        by_slope = area_difference * Phi / foot_area
        by_foot_flow, by_foot_area = E + by_slope, -nodes.slope[e] - by_slope * foot_speed
        by_reach = by_foot_flow * to_end_flow + by_foot_area * to_end_area
        by_velocity = -side * half * by_reach
        by_speed = -side * area_difference * Phi - half * by_reach
        by_drag = 0.5 * ends.dt[e] * (dE * foot_flow + area_difference * dPhi * (foot_speed - side * c))
        slopes.flow[e], slopes.by_foot_flow[e] = by_foot_flow * (1.0 + reach) + by_velocity / A, by_foot_flow
        by_area = by_foot_area * (1.0 + reach) + by_drag * slopes.cell_drag[e]
        slopes.area[e] = by_area - (by_velocity * u + by_speed * slopes.wall[last, e]) / A
        slopes.inner_flow[e], slopes.inner_area[e] = -by_foot_flow * reach, -by_foot_area * reach
        slopes.length[e], slopes.by_speed[e] = (0.5 - reach) * by_reach, by_speed
    for k in range(len(slopes.wall)):
        for e in range(len(ends.face)):
            slopes.wall[k, e] *= slopes.by_speed[e]


@njit(**OPTIONS)
def differentiate_nodes(outlet, ends, nodes, slopes):
    """What flow into a node makes of its pressure: its vessels, and where there is a bed that too, give way."""
    for k in range(len(slopes.give)):
        slopes.give[k] = 0.0
    for r in range(len(ends.start) - 1):
        first = ends.start[r]
        for k in range(ends.start[r + 1] - first):
            slopes.give[k] -= slopes.line[first + k]
    for k in range(ends.first_terminal, len(slopes.give)):
        j = k - ends.first_terminal
        slopes.give[k] += 1.0 / outlet.resistance[j]
    for k in range(len(slopes.give)):
        slopes.give[k] = 1.0 / slopes.give[k]
    for k in range(ends.inlet, ends.first_terminal):
        if nodes.weight[k] == 0.0:  # a pressure that is given does not give way
            slopes.give[k] = 0.0


@njit(**OPTIONS)
def change_characteristics(dA, dq, ends, slopes, weight, changes):
    """Changes r and g at every end."""
    for e in range(len(ends.face)):
        end, inner = ends.cell[e], ends.inner[e]
        r = slopes.area[e] * dA[end] + slopes.flow[e] * dq[end]
        changes.flow[e] = r + slopes.inner_area[e] * dA[inner] + slopes.inner_flow[e] * dq[inner]
        changes.wall[e] = 0.0
    for k in range(len(weight)):
        for e in range(len(ends.face)):
            changes.flow[e] += slopes.wall[k, e] * weight[k, e]
            changes.wall[e] += slopes.pressure[k, e] * weight[k, e]


@njit(**OPTIONS)
def lengthen_characteristics(longer, slopes, changes):
    """What longer vessels add to r."""
    for e in range(len(longer)):
        changes.flow[e] += slopes.length[e] * longer[e]


@njit(**OPTIONS)
def change_beds(d, outlet, outlets, ends, faces, changes):
    """Flow into the nodes that the beds let go in direction d."""
    before, memory = outlets.before, outlets.memory
    for k in range(ends.first_terminal):
        changes.inflow[k] = 0.0
    for k in range(ends.first_terminal, len(changes.inflow)):
        j, q = k - ends.first_terminal, faces.flow[ends.face[k]]
        rise = outlets.resistance[d, j] * q
        for i in range(memory.shape[2]):
            rise += (outlet.decay_half[j, i] * memory[d, j, i] + outlets.decay_half[d, j, i] * before[j, i]).real
        changes.inflow[k] = rise / outlet.resistance[j]


@njit(**OPTIONS)
def change_nodes(ends, slopes, changes):
    """Changes of the pressures of all nodes."""
    for e in range(len(ends.face)):
        changes.wall[e] += slopes.by_flow[e] * changes.flow[e]
        changes.balance[e] = ends.side[e] * changes.flow[e] - slopes.line[e] * changes.wall[e]
    for r in range(len(ends.start) - 1):
        first = ends.start[r]
        for k in range(ends.start[r + 1] - first):
            changes.inflow[k] += changes.balance[first + k]
    for k in range(len(changes.pressure)):
        changes.pressure[k] = slopes.give[k] * changes.inflow[k]


@njit(**OPTIONS)
def change_ends(ends, nodes, slopes, changes, face_dA, face_dq):
    """Changes of area and flow at all ends."""
    for r in range(len(ends.start) - 1):
        first = ends.start[r]
        for k in range(ends.start[r + 1] - first):
            e = first + k
            area = slopes.compliance[e] * (changes.pressure[k] - changes.wall[e])
            face_dA[ends.face[e]] = area
            face_dq[ends.face[e]] = changes.flow[e] + nodes.slope[e] * area


def ends_changer(kinds: Kinds) -> Any:
    """Return what changes all nodes and ends, compiled: the nodes alone, or a term that joins all vessels."""

    @njit(**INLINED)
    def change_all_ends(ends, nodes, terms, step, tangent, n, d):
        lines, changes, at_faces = tangent.lines, tangent.at_nodes, tangent.faces
        change_nodes(ends, lines, changes)
        change_ends(ends, nodes, lines, changes, at_faces.area, at_faces.flow)

    @njit(**INLINED)
    def change_joined_ends(ends, nodes, terms, step, tangent, n, d):
        change_joined(terms, step, tangent, n, d)

    change_joined = change_of_one("change_nodes", kinds)
    return change_all_ends if change_joined is None else change_joined_ends


@njit(**OPTIONS)
def see_faces(d, n, records, slopes, weight, changes):
    """Changes of pressure and flow at some faces into the first two kinds of waves."""
    for i in range(len(records.watched)):
        f = records.watched[i]
        p = slopes.pressure[f] * changes.area[f]
        for k in range(len(weight)):
            p += slopes.wall[k, f] * weight[k, f]
        records.waves[0, d, n, i], records.waves[1, d, n, i] = p, changes.flow[f]


@njit(**OPTIONS)
def change_memory(d, outlet, outlets, ends, faces, face_dq):
    """Change in direction d of what the outlets remember of this step."""
    before, memory = outlets.before, outlets.memory
    for j in range(memory.shape[1]):
        face = ends.face[ends.first_terminal + j]
        for i in range(memory.shape[2]):
            decayed = outlet.decay[j, i] * memory[d, j, i] + outlets.decay[d, j, i] * before[j, i]
            memory[d, j, i] = decayed + outlet.gain[j, i] * face_dq[face] + outlets.gain[d, j, i] * faces.flow[face]
