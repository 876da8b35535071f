"""The scheme where vessels end (`nodes`), linearized: how small changes pass from vessel to vessel and into outlets.

At every end the flow changes by ``r + m dA``: m is the slope of its characteristic's line, and r what the cells of its
vessel, its wall and its length bring. The area changes by ``C (dp - g)``: C is the compliance, and g what the wall
brings. The flows into a node stay in balance, which is one linear equation for its dp.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vasowave.solver.cells import OPTIONS
from vasowave.solver.laws import slope_at
from vasowave.solver.variations import SHIFT, differentiate_slowed


class EndSlopes(NamedTuple):
    """Derivatives of r and g at every end, and what else changes are multiplied with; scratch memory."""

    speed: np.ndarray  # (end,) c next to the end, cm/s
    area: np.ndarray  # (end,) of r by the area of the cell next to the end
    flow: np.ndarray  # (end,) by its flow
    inner_area: np.ndarray  # (end,) by the area of the cell behind that one
    inner_flow: np.ndarray  # (end,)
    length: np.ndarray  # (end,) by the logarithm of the vessel's length
    by_speed: np.ndarray  # (end,) by the wave speed
    wall: np.ndarray  # (parameter + 1, end) by the logarithms of the law's parameters and of A0
    pressure: np.ndarray  # (parameter + 1, end) of g by the same
    compliance: np.ndarray  # (end,) C
    line: np.ndarray  # (end,) ± m C


class EndChanges(NamedTuple):
    """Changes in one direction; scratch memory."""

    flow: np.ndarray  # (end,) r
    wall: np.ndarray  # (end,) g
    balance: np.ndarray  # (end,) flow into the node at an unchanged pressure
    pressure: np.ndarray  # (node,)


class OutletChanges(NamedTuple):
    """Changes of `laws.WindkesselSteps` in every direction, shape (direction, terminal)."""

    decay_half: np.ndarray
    decay: np.ndarray
    gain_half: np.ndarray
    gain: np.ndarray
    R1: np.ndarray


@njit(**OPTIONS)
def differentiate_ends(ends, fluid, wall, shifted, nodes, faces, cell_slopes, face_slopes, slopes):
    """Find all derivatives at the ends; those of the cells and of the faces are known."""
    last = len(slopes.wall) - 1
    for e in range(len(ends.face)):
        p, A, q, side = nodes.cell_pressure[e], nodes.area[e], nodes.flow[e], ends.side[e]
        softness, shift = slope_at(wall, e, p), SHIFT * A * cell_slopes.pressure[ends.cell[e]]
        softer = (slope_at(wall, e, p + shift) - slope_at(wall, e, p - shift)) / (2.0 * SHIFT * softness)
        c = np.sqrt(A / (ends.area0[e] * fluid.inertia * softness))
        by_area = 0.5 * c * (1.0 - softer)  # of c, by the logarithm of the area

        reach = 0.5 - side * (q / A + side * c) * ends.half[e]
        dA, dq = A - nodes.inner_area[e], q - nodes.inner_flow[e]
        foot_area, foot_flow = A + reach * dA, q + reach * dq
        E, Phi, by_E, by_Phi = differentiate_slowed(0.5 * ends.dt[e] * nodes.drag[e])
        foot_speed, away = foot_flow / foot_area, faces.area[ends.face[e]] - foot_area

        by_foot_flow = E + away * Phi / foot_area
        by_foot_area = -nodes.slope[e] - away * Phi / foot_area * foot_speed
        by_reach = by_foot_flow * dq + by_foot_area * dA
        by_speed = -side * away * Phi - ends.half[e] * by_reach
        by_drag = 0.5 * ends.dt[e] * (by_E * foot_flow + away * by_Phi * (foot_speed - side * c))
        by_velocity = -side * ends.half[e] * by_reach
        slopes.flow[e] = by_foot_flow * (1.0 + reach) + by_velocity / A
        slopes.area[e] = by_foot_area * (1.0 + reach) - by_velocity * q / (A * A) + by_speed * by_area / A
        slopes.area[e] += by_drag * cell_slopes.drag[ends.cell[e]]
        slopes.inner_flow[e], slopes.inner_area[e] = -by_foot_flow * reach, -by_foot_area * reach
        slopes.length[e] = (0.5 - reach) * by_reach
        slopes.speed[e], slopes.by_speed[e], slopes.wall[last, e] = c, by_speed, -by_speed * by_area
    for e in range(len(ends.face)):
        slopes.compliance[e] = 1.0 / face_slopes.pressure[ends.face[e]]
        slopes.line[e] = ends.side[e] * nodes.slope[e] * slopes.compliance[e]
    for k in range(len(slopes.wall)):
        for e in range(len(ends.face)):
            slopes.pressure[k, e] = face_slopes.wall[k, ends.face[e]]
    k = 0
    for up, down in shifted:
        for e in range(len(ends.face)):
            p, shift = nodes.cell_pressure[e], SHIFT * cell_slopes.wall[k, ends.cell[e]]
            softer = slope_at(up, e, p + shift) - slope_at(down, e, p - shift)
            softer /= 2.0 * SHIFT * slope_at(wall, e, p)
            slopes.wall[k, e] = -0.5 * slopes.by_speed[e] * slopes.speed[e] * softer
        k += 1


@njit(**OPTIONS)
def change_characteristics(dA, dq, ends, slopes, weight, longer, changes):
    """Changes r and g at every end."""
    for e in range(len(ends.face)):
        end, inner = ends.cell[e], ends.inner[e]
        r = slopes.area[e] * dA[end] + slopes.flow[e] * dq[end]
        r += slopes.inner_area[e] * dA[inner] + slopes.inner_flow[e] * dq[inner]
        changes.flow[e], changes.wall[e] = r + slopes.length[e] * longer[e], 0.0
    for k in range(len(weight)):
        for e in range(len(ends.face)):
            changes.flow[e] += slopes.wall[k, e] * weight[k, e]
            changes.wall[e] += slopes.pressure[k, e] * weight[k, e]
    for e in range(len(ends.face)):
        changes.balance[e] = ends.side[e] * changes.flow[e] - slopes.line[e] * changes.wall[e]


@njit(**OPTIONS)
def change_nodes(d, before, memory, outlet, outlets, ends, nodes, faces, slopes, changes):
    """Changes of the pressures of all nodes in direction d.

    `before` is what the outlets remembered before this step, `memory` its change, `outlets` the changes of the outlets.
    """
    first = len(changes.pressure) - len(ends.terminal_node)
    for k in range(len(changes.pressure)):
        flow, slope = 0.0, 0.0
        for e in range(ends.start[k], ends.start[k + 1]):
            flow += changes.balance[e]
            slope += slopes.line[e]
        if k < first:
            changes.pressure[k] = -flow / slope
        else:
            j, q = k - first, faces.flow[ends.face[ends.start[k]]]
            resistance = outlet.R1[j] + outlet.gain_half[j]
            rise = outlet.decay_half[j] * memory[j] + outlets.decay_half[d, j] * before[j]
            rise += (outlets.R1[d, j] + outlets.gain_half[d, j]) * q
            changes.pressure[k] = (rise + resistance * flow) / (1.0 - resistance * slope)


@njit(**OPTIONS)
def change_ends(d, before, memory, outlet, outlets, ends, nodes, faces, slopes, changes, face_dA, face_dq):
    """Changes of area and flow at all ends, and of what the outlets remember of this step."""
    for e in range(len(ends.face)):
        area = slopes.compliance[e] * (changes.pressure[ends.node[e]] - changes.wall[e])
        face_dA[ends.face[e]] = area
        face_dq[ends.face[e]] = changes.flow[e] + nodes.slope[e] * area
    for j in range(len(ends.terminal_node)):
        face = ends.face[ends.start[ends.terminal_node[j]]]
        memory[j] = outlet.decay[j] * memory[j] + outlets.decay[d, j] * before[j]
        memory[j] += outlet.gain[j] * face_dq[face] + outlets.gain[d, j] * faces.flow[face]
