"""The scheme inside the vessels (`cells`), linearized: how one step hands on small changes of areas and flows.

In each direction (a relative change of the model, `sensitivity`) every slot has a change of area and one of flow. A
step is linear in them; what it multiplies them with is found once for all directions. A wall law's derivatives by its
parameters are central differences of its own equations, so that any law has them.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vasowave.solver.cells import OPTIONS
from vasowave.solver.laws import pressure_at, slope_at

SHIFT = 1e-5
"""Relative change of a parameter in the central differences of a law: truncation and rounding are both near 1e-10."""


class Weights(NamedTuple):
    """Relative change of what slots or ends are made of, in each direction."""

    wall: np.ndarray  # (direction, parameter + 1, slot or end) of the law's parameters; the last is of the area A0
    length: np.ndarray  # (direction, slot or end)
    rows: np.ndarray  # (direction,) how many rows of the wall differ from zero; those behind them are left out


class Slopes(NamedTuple):
    """Derivatives of what `find_fluxes` finds."""

    pressure: np.ndarray  # (slot,) by the area
    velocity: np.ndarray  # (slot,) q/A: the momentum flux changes by 2 u dq - u² dA
    drag: np.ndarray  # (slot,) by the area
    wall: np.ndarray  # (parameter + 1, slot) of the pressure by the logarithms of the law's parameters and of A0


class FaceSlopes(NamedTuple):
    """What `inner_faces` multiplies changes with."""

    keep: np.ndarray  # (slot,) both cells' changes of flow
    push: np.ndarray  # (slot,) the change of the force
    drag: np.ndarray  # (slot,) the change of the drag's exponent x
    force: np.ndarray  # (slot,) itself


class Changes(NamedTuple):
    """Changes of what `find_fluxes` finds, in one direction."""

    pressure: np.ndarray  # (slot,)
    momentum: np.ndarray  # (slot,)
    drag: np.ndarray  # (slot,)


@njit(**OPTIONS)
def differentiate_fluxes(area, flow, cells, wall, shifted, fluid, fluxes, slopes):
    """Derivatives of pressure, momentum flux and drag in all slots; `shifted` has a pair of walls per parameter."""
    last = len(slopes.wall) - 1
    for j in range(len(area)):
        A, per_area = area[j], 1.0 / area[j]
        slopes.pressure[j] = cells.per_area0[j] / slope_at(wall, j, fluxes.pressure[j])
        slopes.velocity[j] = flow[j] * per_area
        slopes.drag[j] = -0.5 * per_area * (fluxes.drag[j] + fluid.k0 * per_area)
        slopes.wall[last, j] = -A * slopes.pressure[j]
    k = 0
    for up, down in shifted:
        for j in range(len(area)):
            a = area[j] * cells.per_area0[j]
            slopes.wall[k, j] = (pressure_at(up, j, a) - pressure_at(down, j, a)) / (2.0 * SHIFT)
        k += 1  # noqa: SIM113  Numba cannot enumerate tuples


@njit(**OPTIONS)
def change_fluxes(dA, dq, slopes, weight, changes):
    """Changes of pressure, momentum flux and drag in all slots."""
    for j in range(len(dA)):
        u = slopes.velocity[j]
        changes.pressure[j] = slopes.pressure[j] * dA[j]
        changes.momentum[j] = u * (2.0 * dq[j] - u * dA[j])
        changes.drag[j] = slopes.drag[j] * dA[j]
    for k in range(len(weight)):
        for j in range(len(dA)):
            changes.pressure[j] += slopes.wall[k, j] * weight[k, j]


@njit(**OPTIONS)
def differentiate_slowed(x):
    """Factors E and Φ of `slowed`, and their derivatives by x."""
    E = 1.0 / (1.0 + x + 0.5 * x * x)
    Phi = (1.0 + 0.5 * x) * E
    return E, Phi, -(1.0 + x) * E * E, E * (0.5 - (1.0 + x) * Phi)


@njit(**OPTIONS)
def differentiate_faces(area, flow, cells, fluid, fluxes, slopes):
    """What the first half of a step multiplies changes with, at every inner face."""
    for j in range(1, len(area)):
        half = cells.half[j - 1]
        A = 0.5 * (area[j - 1] + area[j])
        force = fluxes.momentum[j] - fluxes.momentum[j - 1]
        force += A / fluid.inertia * (fluxes.pressure[j] - fluxes.pressure[j - 1])
        x = 0.25 * cells.dt[j - 1] * (fluxes.drag[j - 1] + fluxes.drag[j])
        E, Phi, by_E, by_Phi = differentiate_slowed(x)
        slopes.keep[j], slopes.push[j], slopes.force[j] = 0.5 * E, half * Phi, force
        slopes.drag[j] = 0.5 * by_E * (flow[j - 1] + flow[j]) - half * by_Phi * force


@njit(**OPTIONS)
def change_faces(area, flow, dA, dq, cells, fluid, fluxes, slopes, longer, changes, face_dA, face_dq):
    """First half of a step, `inner_faces`; a `longer` vessel has longer cells."""
    per_inertia = 1.0 / fluid.inertia
    for j in range(1, len(dA)):
        half = cells.half[j - 1]
        A, change = 0.5 * (area[j - 1] + area[j]), 0.5 * (dA[j - 1] + dA[j])
        face_dA[j] = change - half * (dq[j] - dq[j - 1] - longer[j - 1] * (flow[j] - flow[j - 1]))
        force = per_inertia * change * (fluxes.pressure[j] - fluxes.pressure[j - 1])
        force += per_inertia * A * (changes.pressure[j] - changes.pressure[j - 1])
        force += changes.momentum[j] - changes.momentum[j - 1] - longer[j - 1] * slopes.force[j]
        x = 0.25 * cells.dt[j - 1] * (changes.drag[j - 1] + changes.drag[j])
        face_dq[j] = slopes.keep[j] * (dq[j - 1] + dq[j]) + slopes.drag[j] * x - slopes.push[j] * force


@njit(**OPTIONS)
def change_cells(area, flow, face_dA, face_dq, cells, fluid, fluxes, longer, changes, dA, dq):
    """Second half of a step, `update_cells`; area, flow and fluxes are those of the faces."""
    per_inertia = 1.0 / fluid.inertia
    for j in range(len(dA) - 1):
        twice, mean_area = 2.0 * cells.half[j], 0.5 * (area[j] + area[j + 1])
        dA[j] -= twice * (face_dq[j + 1] - face_dq[j] - longer[j] * (flow[j + 1] - flow[j]))
        steepness = per_inertia * (fluxes.pressure[j + 1] - fluxes.pressure[j])
        force = fluxes.momentum[j + 1] - fluxes.momentum[j] + mean_area * steepness
        change = changes.momentum[j + 1] - changes.momentum[j] + 0.5 * (face_dA[j] + face_dA[j + 1]) * steepness
        change += per_inertia * mean_area * (changes.pressure[j + 1] - changes.pressure[j])
        drag = changes.drag[j] * flow[j] + changes.drag[j + 1] * flow[j + 1]
        drag += fluxes.drag[j] * face_dq[j] + fluxes.drag[j + 1] * face_dq[j + 1]
        dq[j] -= twice * (change - longer[j] * force) + 0.5 * cells.dt[j] * drag
