"""The scheme of `cells` and `nodes`, linearized: how a step hands small changes of areas and flows on.

A direction is a relative change of a model (`direction`). For each of them every slot has a change of area and flow,
and a step of the scheme is linear in them. What a step multiplies them with is found once for all directions. The
derivatives of a wall law by its parameters are central differences of the law itself, so that any law has them.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vasowave.solver.cells import OPTIONS
from vasowave.solver.laws import pressure_at, ratio_at, slope_at

SHIFT = 1e-5
"""Relative change of a parameter in the central differences of a law: truncation and rounding are both near 1e-10."""


class Weights(NamedTuple):
    """Relative change of what the slots or ends are made of, in each direction.

    `wall` has one row for each parameter of the law and a last one for the undeformed area.
    """

    wall: np.ndarray  # (direction, parameter + 1, slot or end)
    length: np.ndarray  # (direction, slot or end)


class Slopes(NamedTuple):
    """Derivatives of what `find_fluxes` finds, in all slots."""

    pressure: np.ndarray  # (slot,) of the pressure by the area
    velocity: np.ndarray  # (slot,) q/A: the momentum flux changes by 2 u dq - u² dA
    drag: np.ndarray  # (slot,) of the drag by the area
    wall: np.ndarray  # (parameter + 1, slot) of the pressure by the logarithms of the parameters and of the area A0


class Changes(NamedTuple):
    """Changes in one direction of what `find_fluxes` finds; scratch memory."""

    pressure: np.ndarray  # (slot,)
    momentum: np.ndarray  # (slot,)
    drag: np.ndarray  # (slot,)


class FaceSlopes(NamedTuple):
    """What the first half of a step multiplies changes with, at every face."""

    keep: np.ndarray  # (slot,) E/2, of both cells' flows
    push: np.ndarray  # (slot,) dt/(2 dx) Φ, of the force
    by_drag: np.ndarray  # (slot,) derivative of the face's flow by the exponent x = drag dt/2
    force: np.ndarray  # (slot,)


@njit(**OPTIONS)
def differentiate_fluxes(area, flow, cells, wall, shifted, fluid, fluxes, slopes):
    """Find the derivatives of pressure, momentum flux and drag in all slots."""
    last = len(slopes.wall) - 1
    for j in range(len(area)):
        A, per_area = area[j], 1.0 / area[j]
        by_area = cells.per_area0[j] / slope_at(wall, j, fluxes.pressure[j])
        slopes.pressure[j] = by_area
        slopes.velocity[j] = flow[j] * per_area
        slopes.drag[j] = -0.5 * per_area * (fluxes.drag[j] + fluid.k0 * per_area)
        slopes.wall[last, j] = -A * by_area
    k = 0
    for up, down in shifted:
        for j in range(len(area)):
            a = area[j] * cells.per_area0[j]
            slopes.wall[k, j] = (pressure_at(up, j, a) - pressure_at(down, j, a)) / (2.0 * SHIFT)
        k += 1


@njit(**OPTIONS)
def change_fluxes(dA, dq, slopes, wall_weights, changes):
    """Changes of pressure, momentum flux and drag in one direction."""
    for j in range(len(dA)):
        u = slopes.velocity[j]
        changes.pressure[j] = slopes.pressure[j] * dA[j]
        changes.momentum[j] = u * (2.0 * dq[j] - u * dA[j])
        changes.drag[j] = slopes.drag[j] * dA[j]
    for k in range(len(wall_weights)):
        for j in range(len(dA)):
            changes.pressure[j] += slopes.wall[k, j] * wall_weights[k, j]


@njit(**OPTIONS)
def differentiate_slowed(x):
    """Factors E and Φ of `slowed` and their derivatives by x."""
    E = 1.0 / (1.0 + x + 0.5 * x * x)
    Phi = (1.0 + 0.5 * x) * E
    return E, Phi, -(1.0 + x) * E * E, E * (0.5 - (1.0 + x) * Phi)


@njit(**OPTIONS)
def differentiate_faces(area, flow, cells, fluid, fluxes, slopes):
    """What `inner_faces` multiplies changes with."""
    for j in range(1, len(area)):
        half = cells.half[j - 1]
        A = 0.5 * (area[j - 1] + area[j])
        force = fluxes.momentum[j] - fluxes.momentum[j - 1]
        force += A / fluid.inertia * (fluxes.pressure[j] - fluxes.pressure[j - 1])
        x = 0.25 * cells.dt[j - 1] * (fluxes.drag[j - 1] + fluxes.drag[j])
        E, Phi, dE, dPhi = differentiate_slowed(x)
        slopes.keep[j], slopes.push[j], slopes.force[j] = 0.5 * E, half * Phi, force
        slopes.by_drag[j] = 0.5 * dE * (flow[j - 1] + flow[j]) - half * dPhi * force


@njit(**OPTIONS)
def change_faces(base, dA, dq, cells, fluid, fluxes, slopes, length, changes, face_dA, face_dq):
    """First half of a step of `inner_faces` for the changes in one direction; `base` is area and flow."""
    area, flow = base
    per_inertia = 1.0 / fluid.inertia
    for j in range(1, len(dA)):
        half = cells.half[j - 1]
        A, change = 0.5 * (area[j - 1] + area[j]), 0.5 * (dA[j - 1] + dA[j])
        shorter = half * length[j - 1]  # a longer vessel has longer cells
        face_dA[j] = change - half * (dq[j] - dq[j - 1]) + shorter * (flow[j] - flow[j - 1])
        force = changes.momentum[j] - changes.momentum[j - 1]
        force += per_inertia * change * (fluxes.pressure[j] - fluxes.pressure[j - 1])
        force += per_inertia * A * (changes.pressure[j] - changes.pressure[j - 1])
        x = 0.25 * cells.dt[j - 1] * (changes.drag[j - 1] + changes.drag[j])
        kept = slopes.keep[j] * (dq[j - 1] + dq[j]) + slopes.by_drag[j] * x
        face_dq[j] = kept - slopes.push[j] * (force - length[j - 1] * slopes.force[j])


@njit(**OPTIONS)
def change_cells(base, face_dA, face_dq, cells, fluid, fluxes, length, changes, dA, dq):
    """Second half of a step, `update_cells`, for the changes in one direction; `base` is area and flow at the faces."""
    area, flow = base
    per_inertia = 1.0 / fluid.inertia
    for j in range(len(dA) - 1):
        twice, mean_area = 2.0 * cells.half[j], 0.5 * (area[j] + area[j + 1])
        dA[j] -= twice * (face_dq[j + 1] - face_dq[j] - length[j] * (flow[j + 1] - flow[j]))
        slope = per_inertia * (fluxes.pressure[j + 1] - fluxes.pressure[j])
        force = fluxes.momentum[j + 1] - fluxes.momentum[j] + mean_area * slope
        change = changes.momentum[j + 1] - changes.momentum[j] + 0.5 * (face_dA[j] + face_dA[j + 1]) * slope
        change += per_inertia * mean_area * (changes.pressure[j + 1] - changes.pressure[j])
        drag = changes.drag[j] * flow[j] + changes.drag[j + 1] * flow[j + 1]
        drag += fluxes.drag[j] * face_dq[j] + fluxes.drag[j + 1] * face_dq[j + 1]
        dq[j] -= twice * (change - length[j] * force) + 0.5 * cells.dt[j] * drag
