"""Viscous walls (`viscosity`), linearized: the same system, whose right sides are what changes otherwise."""

from typing import NamedTuple

import numpy as np
from numba import njit

from vasowave.pulse.solver.cells import OPTIONS
from vasowave.pulse.solver.viscosity import (
    Viscous,
    eliminate_faces,
    fill_faces,
    half_step_areas,
    join_vessels,
    solve_joined,
    to_faces,
)


class ViscousChanges(NamedTuple):
    """What kernels know of viscous walls, their relative changes, and scratch memory of one direction."""

    base: Viscous
    viscosity: np.ndarray  # (direction, slot) of η, in the logarithm
    kappa: np.ndarray  # (slot,) of κ, in the logarithm
    pressure: np.ndarray  # (slot,) of ψ, mmHg
    at_faces: np.ndarray  # (slot,) of ψ at the left face


@njit(**OPTIONS)
def join_changes(outlet, vessels, ends, nodes, slopes, viscous):
    """The nodes' coefficients by the final state of the ends."""
    for e in range(len(ends.face)):
        viscous.give[e] = -slopes.line[e]
    for k in range(len(viscous.diagonal)):
        viscous.diagonal[k] = 0.0
    for k in range(ends.first_terminal, len(viscous.diagonal)):
        viscous.diagonal[k] = 1.0 / outlet.resistance[k - ends.first_terminal]
    join_vessels(vessels, nodes, viscous)


@njit(**OPTIONS)
def change_viscosity(d, dA, dq, area, flow, vessels, cells, area0, longer, changed):
    """Relative changes of κ in direction d; `area0` has those of A0."""
    half_step_areas(dA, dq, vessels, cells, changed.kappa)
    for v in range(len(vessels.first)):
        first, last = vessels.first[v], vessels.last[v]
        for j in range(first, last):
            lower, upper = max(j - 1, first), min(j + 1, max(last - 1, first + 1))
            dA_half = changed.kappa[j] + longer[j] * cells.half[j] * (flow[upper] - flow[lower]) / (upper - lower)
            by_areas = 0.5 * (dA_half / changed.base.area[j] + area0[j])
            changed.kappa[j] = changed.viscosity[d, j] - longer[j] - by_areas


@njit(**OPTIONS)
def change_joined(area, dA, vessels, ends, longer, nodes, slopes, changed, changes, face_dA, face_dq):
    """Changes of flows at all faces and of the state of all ends; `face_dq` has those of the elastic step before."""
    viscous, kappa = changed.base, changed.kappa
    for v in range(len(vessels.first)):
        for j in range(vessels.first[v] + 1, vessels.last[v]):
            by_push = (dA[j - 1] + dA[j]) / (area[j - 1] + area[j]) - longer[j]
            left_pressure, right_pressure = viscous.pressure[j - 1], viscous.pressure[j]
            lost = by_push * (right_pressure - left_pressure) + kappa[j] * right_pressure - kappa[j - 1] * left_pressure
            viscous.right_side[j] = viscous.per_push[j] * face_dq[j] - lost
    for e in range(len(ends.face)):
        cell, r = ends.cell[e], changes.flow[e]
        changes.wall[e] += slopes.by_flow[e] * r
        resisted = changes.wall[e] + kappa[cell] * viscous.pressure[cell]
        viscous.side[e] = r / viscous.give[e] + ends.side[e] * resisted
    for k in range(len(viscous.balance)):
        viscous.balance[k] = changes.inflow[k]
    eliminate_faces(vessels, viscous)
    solve_joined(vessels, nodes, viscous)
    fill_faces(vessels, viscous, face_dq)
    for e in range(len(ends.face)):
        face_dA[ends.face[e]] = (face_dq[ends.face[e]] - changes.flow[e]) / nodes.slope[e]
    for k in range(len(viscous.balance)):
        changes.pressure[k] = viscous.balance[k]
    for v in range(len(vessels.first)):
        for j in range(vessels.first[v], vessels.last[v]):
            by_flows = viscous.kappa[j] * (face_dq[j] - face_dq[j + 1])
            changed.pressure[j] = by_flows + kappa[j] * viscous.pressure[j]
    to_faces(vessels, changed.pressure, changed.at_faces)


@njit(**OPTIONS)
def change_pushes(dq, vessels, cells, fluid, longer, faces, face_dA, changed):
    """What the changes of the viscous pressure, and of what it pushes, make of the flow in the cells."""
    at_faces = changed.base.at_faces
    for v in range(len(vessels.first)):
        for j in range(vessels.first[v], vessels.last[v]):
            mean_area, push = 0.5 * (faces.area[j] + faces.area[j + 1]), 2.0 * cells.half[j] / fluid.inertia
            wider = 0.5 * (face_dA[j] + face_dA[j + 1]) - longer[j] * mean_area
            rise = changed.at_faces[j + 1] - changed.at_faces[j]
            dq[j] -= push * (wider * (at_faces[j + 1] - at_faces[j]) + mean_area * rise)
