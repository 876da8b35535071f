"""The ends and nodes of `nodes`, linearized: how small changes pass from vessel to vessel and into the outlets."""

from typing import NamedTuple

import numpy as np
from numba import njit

from vasowave.solver.cells import OPTIONS
from vasowave.solver.laws import ratio_at, slope_at
from vasowave.solver.nodes import try_pressures
from vasowave.solver.variations import SHIFT, differentiate_slowed


class EndSlopes(NamedTuple):
    """Derivatives of the wave speed next to every end, and of the area at it; scratch memory."""

    speed: np.ndarray  # (end,) c itself, cm/s
    speed_by_area: np.ndarray  # (end,)
    speed_by_wall: np.ndarray  # (parameter + 1, end) by the logarithms of the wall's parameters and of the area A0
    area_by_wall: np.ndarray  # (parameter + 1, end) by the same, at an unchanged pressure of the node


class EndChanges(NamedTuple):
    """Changes in one direction at the ends and nodes; scratch memory."""

    intercept: np.ndarray  # (end,) of α
    slope: np.ndarray  # (end,) of m
    area: np.ndarray  # (end,) at an unchanged pressure of the node
    pressure: np.ndarray  # (node,)


class OutletChanges(NamedTuple):
    """Changes of `laws.WindkesselSteps` in every direction, shape (direction, terminal)."""

    decay_half: np.ndarray
    decay: np.ndarray
    gain_half: np.ndarray
    gain: np.ndarray
    R1: np.ndarray


@njit(**OPTIONS)
def differentiate_ends(ends, wall, shifted, fluid, cell_slopes, nodes, slopes):
    """Find the derivatives at all ends."""
    try_pressures(ends, wall, nodes)  # the last Newton step has moved the pressures
    last = len(slopes.area_by_wall) - 1
    for e in range(len(ends.face)):
        p, A = nodes.cell_pressure[e], nodes.area[e]
        shift = SHIFT * A * cell_slopes.pressure[ends.cell[e]]
        softness = slope_at(wall, e, p)
        c = np.sqrt(A / ends.area0[e] / (fluid.inertia * softness))
        softer = (slope_at(wall, e, p + shift) - slope_at(wall, e, p - shift)) / (2.0 * SHIFT * softness)
        slopes.speed[e] = c
        slopes.speed_by_area[e] = 0.5 * c * (1.0 - softer) / A
        slopes.speed_by_wall[last, e] = -0.5 * c * (1.0 - softer)
        slopes.area_by_wall[last, e] = nodes.end_area[e]
    k = 0
    for up, down in shifted:
        for e in range(len(ends.face)):
            p, shift = nodes.cell_pressure[e], SHIFT * cell_slopes.wall[k, ends.cell[e]]
            softer = slope_at(up, e, p + shift) - slope_at(down, e, p - shift)
            softer /= 2.0 * SHIFT * slope_at(wall, e, p)
            slopes.speed_by_wall[k, e] = -0.5 * slopes.speed[e] * softer
            wider = ratio_at(up, e, nodes.trial[e]) - ratio_at(down, e, nodes.trial[e])
            slopes.area_by_wall[k, e] = ends.area0[e] * wider / (2.0 * SHIFT)
        k += 1


@njit(**OPTIONS)
def change_characteristics(dA, dq, ends, nodes, slopes, drag, wall_weights, length, changes):
    """Changes of the lines that `characteristics` draws, in one direction; `drag` has its changes in all slots."""
    for e in range(len(ends.face)):
        end, inner, side, half = ends.cell[e], ends.inner[e], ends.side[e], ends.half[e]
        A, q, c = nodes.area[e], nodes.flow[e], slopes.speed[e]
        u = q / A
        reach = 0.5 - side * (u + side * c) * half
        foot_area = A + reach * (A - nodes.inner_area[e])
        foot_flow = q + reach * (q - nodes.inner_flow[e])
        foot_speed = foot_flow / foot_area
        E, Phi, by_E, by_Phi = differentiate_slowed(0.5 * ends.dt[e] * nodes.drag[e])

        dc, changes.area[e] = slopes.speed_by_area[e] * dA[end], 0.0
        for k in range(len(wall_weights)):
            dc += slopes.speed_by_wall[k, e] * wall_weights[k, e]
            changes.area[e] += slopes.area_by_wall[k, e] * wall_weights[k, e]
        du = (dq[end] - u * dA[end]) / A
        farther = (0.5 - reach) * length[e] - side * half * (du + side * dc)
        foot_dA = dA[end] + reach * (dA[end] - dA[inner]) + farther * (A - nodes.inner_area[e])
        foot_dq = dq[end] + reach * (dq[end] - dq[inner]) + farther * (q - nodes.inner_flow[e])
        x = 0.5 * ends.dt[e] * drag[end]
        m = Phi * ((foot_dq - foot_speed * foot_dA) / foot_area - side * dc) + by_Phi * x * (foot_speed - side * c)
        changes.slope[e] = m
        changes.intercept[e] = E * foot_dq + by_E * x * foot_flow - m * foot_area - nodes.slope[e] * foot_dA


@njit(**OPTIONS)
def change_nodes(d, before, memory, outlet, outlets, ends, nodes, faces, changes, face_dA, face_dq):
    """Changes of all ends at the half step in direction d, and of what the outlets (`outlet`) then remember.

    `before` is what the outlets remembered before this step, and `memory` the change of it; `outlets` are the changes
    of the outlets themselves.
    """
    beds = len(ends.terminal_node)
    for k in range(len(changes.pressure)):
        inflow, slope = 0.0, 0.0
        for e in range(ends.start[k], ends.start[k + 1]):
            m, side = nodes.slope[e], ends.side[e]
            area = nodes.end_area[e]
            inflow += side * (changes.intercept[e] + changes.slope[e] * area + m * changes.area[e])
            slope += side * m * nodes.compliance[e]
        changes.pressure[k] = -inflow / slope
        if nodes.outlet[k] > 0.0:
            j = k - (len(changes.pressure) - beds)
            resistance = outlet.R1[j] + outlet.gain_half[j]
            rise = outlet.decay_half[j] * memory[j] + outlets.decay_half[d, j] * before[j]
            rise += (outlets.R1[d, j] + outlets.gain_half[d, j]) * faces.flow[ends.face[ends.start[k]]]
            changes.pressure[k] = (rise + resistance * inflow) / (1.0 - resistance * slope)
    for e in range(len(ends.face)):
        area = changes.area[e] + nodes.compliance[e] * changes.pressure[ends.node[e]]
        flow = changes.intercept[e] + changes.slope[e] * nodes.end_area[e] + nodes.slope[e] * area
        face_dA[ends.face[e]], face_dq[ends.face[e]] = area, flow
    for j in range(beds):
        face = ends.face[ends.start[ends.terminal_node[j]]]
        memory[j] = outlet.decay[j] * memory[j] + outlets.decay[d, j] * before[j]
        memory[j] += outlet.gain[j] * face_dq[face] + outlets.gain[d, j] * faces.flow[face]
