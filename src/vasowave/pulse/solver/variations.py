"""The scheme inside the vessels (`cells`), linearized: how one step hands on small changes of areas and flows.

In each direction (a relative change of the model, `sensitivity`) every slot has a change of area and one of flow. A
step is linear in them; what it multiplies them with is found once for all directions. A wall law's derivatives by its
parameters are central differences of its own equations, so that any law has them.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vasowave.pulse.solver.cells import OPTIONS
from vasowave.pulse.solver.laws import pressure_at, slope_at

SHIFT = 1e-5
"""Relative change of a parameter in the central differences of a law: truncation and rounding are both near 1e-10."""


class Weights(NamedTuple):
    """Relative change of what slots or ends are made of, in each direction."""

    wall: np.ndarray  # (direction, parameter + 1, slot or end) of the law's parameters; the last is of the area A0
    length: np.ndarray  # (direction, slot or end)
    rows: np.ndarray  # (direction,) how many rows of the wall differ from zero; those behind them are left out
    lengthens: np.ndarray  # (direction,) whether a length differs from zero; where none does, they are left out


class Slopes(NamedTuple):
    """Derivatives of what `find_fluxes` finds."""

    pressure: np.ndarray  # (slot,) by the area
    momentum_by_area: np.ndarray  # (slot,) of the momentum flux q²/A: -u²
    momentum_by_flow: np.ndarray  # (slot,) 2 u
    drag: np.ndarray  # (slot,) by the area
    wall: np.ndarray  # (parameter + 1, slot) of the pressure by the logarithms of the law's parameters and of A0


class Stencil(NamedTuple):
    """What half a step multiplies with, to give the change of a flow: the changes of its two neighbors, and others."""

    left_area: np.ndarray  # (slot,)
    right_area: np.ndarray  # (slot,)
    left_flow: np.ndarray  # (slot,)
    right_flow: np.ndarray  # (slot,)
    flow: np.ndarray  # (slot,) by the sum of the neighbors' flows alone
    area: np.ndarray  # (slot,) by that of their areas alone
    drag: np.ndarray  # (slot,) by that of their drags
    push: np.ndarray  # (slot,) by the rise of the momentum flux from left to right
    fall: np.ndarray  # (slot,) by that of the pressure
    length: np.ndarray  # (slot,) of the vessel, in the logarithm
    wall: (
        np.ndarray
    )  # (parameter + 1 or fewer, slot) its parameters and A0, in logarithms; as many as directions change


@njit(**OPTIONS)
def differentiate_fluxes(state, cells, wall, shifted, fluid, fluxes, slopes):
    """Derivatives of pressure, momentum flux and drag in all slots; `shifted` has a pair of walls per parameter."""
    area, flow = state.area, state.flow
    last = len(slopes.wall) - 1
    for j in range(len(area)):
        A, per_area = area[j], 1.0 / area[j]
        slopes.pressure[j] = cells.per_area0[j] / slope_at(wall, j, fluxes.pressure[j])
        u = flow[j] * per_area
        slopes.momentum_by_area[j], slopes.momentum_by_flow[j] = -u * u, 2.0 * u
        slopes.drag[j] = -0.5 * per_area * (fluxes.drag[j] + fluid.k0 * per_area)
        slopes.wall[last, j] = -A * slopes.pressure[j]
    k = 0
    for up, down in shifted:
        for j in range(len(area)):
            a = area[j] * cells.per_area0[j]
            slopes.wall[k, j] = (pressure_at(up, j, a) - pressure_at(down, j, a)) / (2.0 * SHIFT)
        k += 1  # noqa: SIM113  Numba cannot enumerate tuples


@njit(**OPTIONS)
def differentiate_slowed(x):
    """Factors E and Φ of `slowed`, and their derivatives by x."""
    E = 1.0 / (1.0 + x + 0.5 * x * x)
    Phi = (1.0 + 0.5 * x) * E
    return E, Phi, -(1.0 + x) * E * E, E * (0.5 - (1.0 + x) * Phi)


@njit(**OPTIONS)
def differentiate_faces(area, flow, cells, fluid, fluxes, slopes, stencil):
    """First half of a step, `inner_faces`: what the flow at every face makes of the cells around it.

    Left and right have loops of their own: in one, the compiler hands values on from slot to slot, one slot at a time.
    """
    per_inertia = 1.0 / fluid.inertia
    for j in range(1, len(area)):
        half, quarter = cells.half[j - 1], 0.25 * cells.dt[j - 1]
        mass, rise = 0.5 * per_inertia * (area[j - 1] + area[j]), fluxes.pressure[j] - fluxes.pressure[j - 1]
        force = fluxes.momentum[j] - fluxes.momentum[j - 1] + mass * rise
        E, Phi, dE, dPhi = differentiate_slowed(quarter * (fluxes.drag[j - 1] + fluxes.drag[j]))
        push = -half * Phi
        stencil.flow[j], stencil.push[j] = 0.5 * E, push
        stencil.area[j], stencil.fall[j] = 0.5 * push * per_inertia * rise, push * mass
        stencil.drag[j] = quarter * (0.5 * dE * (flow[j - 1] + flow[j]) - half * dPhi * force)
        stencil.length[j] = -push * force  # a longer vessel has longer cells
    for j in range(1, len(area)):
        by_flux = -stencil.push[j] * slopes.momentum_by_area[j - 1] - stencil.fall[j] * slopes.pressure[j - 1]
        stencil.left_area[j] = stencil.area[j] + stencil.drag[j] * slopes.drag[j - 1] + by_flux
        stencil.left_flow[j] = stencil.flow[j] - stencil.push[j] * slopes.momentum_by_flow[j - 1]
    for j in range(1, len(area)):
        by_flux = stencil.push[j] * slopes.momentum_by_area[j] + stencil.fall[j] * slopes.pressure[j]
        stencil.right_area[j] = stencil.area[j] + stencil.drag[j] * slopes.drag[j] + by_flux
        stencil.right_flow[j] = stencil.flow[j] + stencil.push[j] * slopes.momentum_by_flow[j]
    for k in range(len(stencil.wall)):
        for j in range(1, len(area)):
            stencil.wall[k, j] = stencil.fall[j] * (slopes.wall[k, j] - slopes.wall[k, j - 1])


@njit(**OPTIONS)
def differentiate_cells(area, flow, cells, fluid, fluxes, slopes, stencil):
    """Second half of a step, `update_cells`: what the flow in every cell makes of its faces, whose state this is."""
    per_inertia = 1.0 / fluid.inertia
    for j in range(len(area) - 1):
        push, mass = -2.0 * cells.half[j], 0.5 * per_inertia * (area[j] + area[j + 1])
        rise = fluxes.pressure[j + 1] - fluxes.pressure[j]
        stencil.area[j], stencil.fall[j] = 0.5 * push * per_inertia * rise, push * mass
        stencil.length[j] = -push * (fluxes.momentum[j + 1] - fluxes.momentum[j] + mass * rise)
    for j in range(len(area) - 1):
        push, by_drag = -2.0 * cells.half[j], -0.5 * cells.dt[j]
        by_flux = -push * slopes.momentum_by_area[j] - stencil.fall[j] * slopes.pressure[j]
        stencil.left_area[j] = stencil.area[j] + by_drag * slopes.drag[j] * flow[j] + by_flux
        stencil.left_flow[j] = by_drag * fluxes.drag[j] - push * slopes.momentum_by_flow[j]
    for j in range(len(area) - 1):
        push, by_drag = -2.0 * cells.half[j], -0.5 * cells.dt[j]
        by_flux = push * slopes.momentum_by_area[j + 1] + stencil.fall[j] * slopes.pressure[j + 1]
        stencil.right_area[j] = stencil.area[j] + by_drag * slopes.drag[j + 1] * flow[j + 1] + by_flux
        stencil.right_flow[j] = by_drag * fluxes.drag[j + 1] + push * slopes.momentum_by_flow[j + 1]
    for k in range(len(stencil.wall)):
        for j in range(len(area) - 1):
            stencil.wall[k, j] = stencil.fall[j] * (slopes.wall[k, j + 1] - slopes.wall[k, j])


@njit(**OPTIONS)
def change_faces(dA, dq, cells, stencil, weight, face_dA, face_dq):
    """Changes of area and flow at all inner faces in one direction."""
    for j in range(1, len(dA)):
        face_dA[j] = 0.5 * (dA[j - 1] + dA[j]) - cells.half[j - 1] * (dq[j] - dq[j - 1])
        moved = stencil.left_area[j] * dA[j - 1] + stencil.right_area[j] * dA[j]
        face_dq[j] = moved + stencil.left_flow[j] * dq[j - 1] + stencil.right_flow[j] * dq[j]
    for k in range(len(weight)):
        for j in range(1, len(dA)):
            face_dq[j] += stencil.wall[k, j] * weight[k, j]


@njit(**OPTIONS)
def lengthen_faces(longer, flow, cells, stencil, face_dA, face_dq):
    """What longer vessels add to the changes at the faces; `flow` is that of the cells."""
    for j in range(1, len(longer)):
        face_dA[j] += cells.half[j - 1] * longer[j] * (flow[j] - flow[j - 1])
        face_dq[j] += stencil.length[j] * longer[j]


@njit(**OPTIONS)
def change_cells(face_dA, face_dq, cells, stencil, weight, dA, dq):
    """Changes of area and flow in all cells in one direction."""
    for j in range(len(dA) - 1):
        dA[j] -= 2.0 * cells.half[j] * (face_dq[j + 1] - face_dq[j])
        moved = stencil.left_area[j] * face_dA[j] + stencil.right_area[j] * face_dA[j + 1]
        dq[j] += moved + stencil.left_flow[j] * face_dq[j] + stencil.right_flow[j] * face_dq[j + 1]
    for k in range(len(weight)):
        for j in range(len(dA) - 1):
            dq[j] += stencil.wall[k, j] * weight[k, j]


@njit(**OPTIONS)
def lengthen_cells(longer, flow, cells, stencil, dA, dq):
    """What longer vessels add to the changes in the cells; `flow` is that of the faces."""
    for j in range(len(longer) - 1):
        dA[j] += 2.0 * cells.half[j] * longer[j] * (flow[j + 1] - flow[j])
        dq[j] += stencil.length[j] * longer[j]
