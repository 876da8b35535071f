"""The compiled scheme where walls are viscous: flows and pressures at the half step, found together.

A viscous wall resists the rate at which it stretches: the pressure is that of the law plus

    ψ = η ∂√(A/A0)/∂t = -η/(2 √(A A0)) ∂q/∂x

In a cell that is κ (q_left - q_right), of the same flows through its faces at the half step from which its area
changes. It pushes the flow at the faces, and opposes that at the vessel's ends. So all flows at faces and all pressures
of nodes depend on each other at once, however small the step; what is taken implicitly makes no step shorter:

    at inner faces    q + b (ψ_right - ψ_left) = what the elastic step makes of it,  b = dt A/(2 ρ dx)
    at vessel ends    q on its characteristic, at the law's pressure p(node) - ψ(cell at the end)
    at nodes          as in `nodes`

Divided by b, or by what an end's flow yields to pressure, this is symmetric and positive definite. Inner faces are
eliminated vessel by vessel, then the ends, and the pressures of the nodes are left: a sparse system, whose elimination
has no fill in a tree. The cells then take ψ as they take every other pressure at the half step, which is the midpoint
rule: of second order, stable for any viscosity.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vasowave.pulse.solver.cells import JOINED, OPTIONS
from vasowave.pulse.solver.elimination import (
    Joints,
    eliminate_faces,
    fill_faces,
    join_vessels,
    make_joints,
    solve_joined,
)
from vasowave.pulse.solver.grid import Grid
from vasowave.pulse.solver.laws import ratio_at, slope_at
from vasowave.pulse.solver.nodes import LEAST_GIVE, NEWTON_CLOSE, NEWTON_MOST


class Viscous(NamedTuple):
    """What kernels know of viscous walls, and their scratch memory: a term."""

    joints: Joints
    coefficient: np.ndarray  # (slot,) η/(2 √A0 dx): κ √A
    area: np.ndarray  # (slot,) at the half step, cm²
    kappa: np.ndarray  # (slot,) κ, mmHg s/ml
    pressure: np.ndarray  # (slot,) ψ, mmHg
    at_faces: np.ndarray  # (slot,) ψ at the left face
    per_push: np.ndarray  # (slot,) 1/b of the left face, mmHg s/ml
    right_side: np.ndarray  # (slot,) right side of the equation of the left face, mmHg
    pivot: np.ndarray  # (slot,) of the left face
    to_next: np.ndarray  # (slot,) share of the next face's flow in that of the left face
    to_inlet: np.ndarray  # (slot,) share of the inlet's flow in it
    end_coefficient: np.ndarray  # (end,) coefficient of the end's own flow once the inner faces are gone
    across: np.ndarray  # (vessel,) that of its two ends
    give: np.ndarray  # (end,) what the flow into the vessel gains by a pressure at its end, ml/s/mmHg
    flow: np.ndarray  # (end,) that it would have, later that it has
    trial: np.ndarray  # (end,) that of the trial
    head: np.ndarray  # (end,) pressure of the node, less ψ, at which it would
    side: np.ndarray  # (end,) right side of the equation of the end, mmHg
    admittance: np.ndarray  # (end,) flow into the vessel by the pressure of its node
    transfer: np.ndarray  # (vessel,) flow through it by the pressure at its other end
    diagonal: np.ndarray  # (node,)
    entries: np.ndarray  # (entry,) coefficients, later their shares of the diagonal
    balance: np.ndarray  # (node,) right side, later the pressure

    def prepare(self, step, n):
        """Find the coefficients of the system."""
        state, scheme = step.state, step.scheme
        find_viscosity(state.area, state.flow, scheme.vessels, scheme.cells, scheme.fluid, self)

    def solve(self, step, n):
        """Give all ends the state at which the nodes are in balance; returns whether that succeeded."""
        scheme, nodes, faces = step.scheme, step.half.nodes, step.half.faces
        if not join_all(scheme.vessels, scheme.ends, scheme.walls.ends, self, nodes, faces):
            return False
        close_joined(scheme.ends, self, nodes, faces)
        return True

    def worst(self, step, n):
        """Return the end whose last Newton step was the longest."""
        missed, where = step.half.nodes.missed, 0
        for e in range(len(missed)):
            if abs(missed[e]) > abs(missed[where]):
                where = e
        return where

    def after_nodes(self, step, n):
        """Find the flows at inner faces and the viscous pressures."""
        vessels, flow = step.scheme.vessels, step.half.faces.flow
        fill_faces(vessels, self, flow)
        for v in range(len(vessels.first)):
            for j in range(vessels.first[v], vessels.last[v]):
                self.pressure[j] = self.kappa[j] * (flow[j] - flow[j + 1])
        to_faces(vessels, self.pressure, self.at_faces)

    def record(self, step, n):
        """Keep the viscous pressures of this half step."""
        record_viscous(n, len(step.inflow), step.scheme.vessels, self, step.records)

    def in_cells(self, step, n):
        """Let the viscous pressure push the flow."""
        scheme = step.scheme
        push_cells(step.state.flow, scheme.vessels, scheme.cells, scheme.fluid, self, step.half.faces)


def make_viscous(grid: Grid) -> Viscous | None:
    """Return what kernels know of the viscous walls of a grid; None where no wall is viscous."""
    viscosity = np.broadcast_to(grid.model.wall_viscosity, len(grid.counts))
    if not viscosity.any():
        return None
    joints = make_joints(grid)
    coefficient = viscosity[grid.vessel] / (2.0 * np.sqrt(grid.area0) * grid.spacing)
    slots, vessels, ends, nodes = len(grid.vessel), len(grid.counts), len(joints.node), len(joints.order)
    sizes = [*9 * [slots], ends, vessels, *6 * [ends], vessels, nodes, len(joints.neighbor), nodes]
    return Viscous(joints, coefficient, *map(np.zeros, sizes))


@njit(**OPTIONS)
def half_step_areas(area, flow, vessels, cells, half_areas):
    """Areas of the cells at the half step, by the flows of the cells beside."""
    for v in range(len(vessels.first)):
        first, last = vessels.first[v], vessels.last[v]
        for j in range(first, last):
            lower, upper = max(j - 1, first), min(j + 1, max(last - 1, first + 1))  # a single cell has its line
            half_areas[j] = area[j] - cells.half[j] * (flow[upper] - flow[lower]) / (upper - lower)


@njit(**OPTIONS)
def find_viscosity(area, flow, vessels, cells, fluid, viscous):
    """Coefficients κ of all cells and 1/b of all inner faces, and what is left of them once these are eliminated."""
    half_step_areas(area, flow, vessels, cells, viscous.area)
    joints, kappa = viscous.joints, viscous.kappa
    for v in range(len(vessels.first)):
        first, last = vessels.first[v], vessels.last[v]
        for j in range(first, last):
            kappa[j] = viscous.coefficient[j] / np.sqrt(viscous.area[j])
        inlet_diagonal, coupled, before = kappa[first], kappa[first], 0.0
        for j in range(first + 1, last):
            viscous.per_push[j] = 2.0 * fluid.inertia / (cells.half[j - 1] * (area[j - 1] + area[j]))
            viscous.pivot[j] = viscous.per_push[j] + kappa[j - 1] + kappa[j] - before
            viscous.to_next[j], viscous.to_inlet[j] = kappa[j] / viscous.pivot[j], coupled / viscous.pivot[j]
            inlet_diagonal -= coupled * viscous.to_inlet[j]
            coupled, before = coupled * viscous.to_next[j], kappa[j] * viscous.to_next[j]
        viscous.end_coefficient[joints.inlet[v]], viscous.end_coefficient[joints.outlet[v]] = (
            inlet_diagonal,
            kappa[last - 1] - before,
        )
        viscous.across[v] = coupled


@njit(**OPTIONS)
def to_faces(vessels, of_cells, at_faces):
    """Bring what cells have to their faces: the mean of the two, and at vessel ends that of the one."""
    for v in range(len(vessels.first)):
        first, last = vessels.first[v], vessels.last[v]
        at_faces[first], at_faces[last] = of_cells[first], of_cells[last - 1]
        for j in range(first + 1, last):
            at_faces[j] = 0.5 * (of_cells[j - 1] + of_cells[j])


@njit(**OPTIONS)
def try_ends(ends, wall, nodes, viscous):
    """Line of every end about the trial of its law's pressure: flow, and head, p with the dynamic pressure."""
    for e in range(len(ends.face)):
        p = nodes.trial[e]
        A, C = ends.area0[e] * ratio_at(wall, e, p), ends.area0[e] * slope_at(wall, e, p)
        q = nodes.intercept[e] + nodes.slope[e] * A
        by_speed = ends.density[e] * q / A + ends.loss[e] * abs(q / A)
        by_pressure = -(by_speed + ends.viscous[e]) * nodes.intercept[e] * C / (A * A)
        nodes.share[e] = 1.0 / max(1.0 + by_pressure, LEAST_GIVE)
        nodes.end_area[e], nodes.compliance[e] = A, C
        viscous.trial[e], viscous.head[e] = q, p + (0.5 * by_speed + ends.viscous[e]) * q / A
        viscous.give[e] = -ends.side[e] * nodes.slope[e] * C * nodes.share[e]
        viscous.side[e] = q / viscous.give[e] + ends.side[e] * viscous.head[e]


@njit(**OPTIONS)
def move_ends(ends, nodes, viscous):
    """Move the law's pressures by the Newton step whose flows these are; returns whether all steps were small."""
    small = True
    for e in range(len(ends.face)):
        step = -ends.side[e] * nodes.share[e] * (viscous.flow[e] - viscous.trial[e]) / viscous.give[e]
        max_step = 5.0 + 0.5 * abs(nodes.trial[e])
        nodes.missed[e] = min(max(step, -max_step), max_step)
        nodes.trial[e] += nodes.missed[e]
        small &= abs(nodes.missed[e]) < NEWTON_CLOSE
    return small


@njit(**OPTIONS)
def join_all(vessels, ends, wall, viscous, nodes, faces):
    """Find the flows at all ends that balance at all nodes; returns whether that succeeded.

    The flows at inner faces are those of the elastic step before.
    """
    for e in range(len(ends.face)):
        nodes.trial[e] = nodes.cell_pressure[e]
    for _ in range(NEWTON_MOST):
        try_ends(ends, wall, nodes, viscous)
        for v in range(len(vessels.first)):
            for j in range(vessels.first[v] + 1, vessels.last[v]):
                viscous.right_side[j] = viscous.per_push[j] * faces.flow[j]
        eliminate_faces(vessels, viscous)
        for k in range(len(viscous.diagonal)):
            taken = nodes.outlet[k] / nodes.weight[k] if nodes.weight[k] > 0.0 else 1.0
            viscous.diagonal[k], viscous.balance[k] = taken, nodes.source[k] + taken * nodes.memory[k]
        join_vessels(vessels, nodes, viscous)
        solve_joined(vessels, nodes, viscous)
        if move_ends(ends, nodes, viscous):
            return True
    return False


@njit(**OPTIONS)
def close_joined(ends, viscous, nodes, faces):
    """State of all ends, and pressures of all nodes, by the last, small Newton step."""
    for e in range(len(ends.face)):
        faces.area[ends.face[e]] = nodes.end_area[e] + nodes.compliance[e] * nodes.missed[e]
        faces.flow[ends.face[e]] = viscous.flow[e]
    for k in range(len(viscous.balance)):
        nodes.pressure[0, k] = viscous.balance[k]


@njit(**OPTIONS)
def record_viscous(n, steps, vessels, viscous, records):
    """Viscous pressure at the watched faces, the stations and in the cells, where this half step is kept."""
    of_stations, of_cells = steps // records.stations.shape[1], steps // max(records.cells.shape[1], 1)
    for i in range(len(records.watched)):
        records.waves[2, n, i] = viscous.at_faces[records.watched[i]]
    if n % of_stations == 0:
        for v in range(len(vessels.first)):
            i, k = vessels.first[v], vessels.last[v]
            at_left, at_right = viscous.at_faces[(i + k) // 2], viscous.at_faces[i + k - (i + k) // 2]
            at_stations = records.stations[2, n // of_stations, v]
            at_stations[0], at_stations[1] = viscous.at_faces[i], 0.5 * (at_left + at_right)
            at_stations[2] = viscous.at_faces[k]
    if records.cells.shape[1] > 0 and n % of_cells == 0:
        for j in range(len(viscous.pressure)):
            records.cells[2, n // of_cells, j] = viscous.pressure[j]


@njit(**OPTIONS)
def push_cells(flow, vessels, cells, fluid, viscous, faces):
    """What the viscous pressure at the faces makes of the flow in the cells."""
    for v in range(len(vessels.first)):
        for j in range(vessels.first[v], vessels.last[v]):
            mean_area = 0.5 * (faces.area[j] + faces.area[j + 1])
            push = 2.0 * cells.half[j] * mean_area / fluid.inertia
            flow[j] -= push * (viscous.at_faces[j + 1] - viscous.at_faces[j])


class ViscousTangent(NamedTuple):
    """The tangent of `Viscous`, with scratch memory of one direction: the same system with other right sides."""

    base: Viscous
    viscosity: np.ndarray  # (direction, slot) of η, in the logarithm
    kappa: np.ndarray  # (slot,) of κ, in the logarithm
    pressure: np.ndarray  # (slot,) of ψ, mmHg
    at_faces: np.ndarray  # (slot,) of ψ at the left face

    def linearize(self, step, tangent, n, d):
        """Find the nodes' coefficients by the final state of the ends."""
        scheme = step.scheme
        join_changes(scheme.outlet, scheme.vessels, scheme.ends, step.half.nodes, tangent.lines, self.base)

    def change_nodes(self, step, tangent, n, d):
        """Change the flows at all faces and the state of all ends."""
        change_viscosity(d, step.state, tangent, step.scheme, self)
        change_joined(d, step, tangent, self)

    def record_changes(self, step, tangent, n, d):
        """Keep the changes of the viscous pressure."""
        records = tangent.records
        for i in range(len(records.watched)):
            records.waves[2, d, n, i] = self.at_faces[records.watched[i]]

    def change_cells(self, step, tangent, n, d):
        """Change the flow in the cells by the viscous pressure, and by what it pushes."""
        vessels, cells, fluid, faces = step.scheme.vessels, step.scheme.cells, step.scheme.fluid, step.half.faces
        at_faces, dq, longer = self.base.at_faces, tangent.changed.flow[d], tangent.in_slots.length[d]
        face_dA = tangent.faces.area
        for v in range(len(vessels.first)):
            for j in range(vessels.first[v], vessels.last[v]):
                mean_area, push = 0.5 * (faces.area[j] + faces.area[j + 1]), 2.0 * cells.half[j] / fluid.inertia
                wider = 0.5 * (face_dA[j] + face_dA[j + 1]) - longer[j] * mean_area
                rise = self.at_faces[j + 1] - self.at_faces[j]
                dq[j] -= push * (wider * (at_faces[j + 1] - at_faces[j]) + mean_area * rise)


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


@njit(**JOINED)
def change_viscosity(d, state, tangent, scheme, changed):
    """Relative changes of κ in direction d."""
    flow, vessels, cells = state.flow, scheme.vessels, scheme.cells
    dA, dq, longer = tangent.changed.area[d], tangent.changed.flow[d], tangent.in_slots.length[d]
    area0 = tangent.in_slots.wall[d, -1]
    half_step_areas(dA, dq, vessels, cells, changed.kappa)
    for v in range(len(vessels.first)):
        first, last = vessels.first[v], vessels.last[v]
        for j in range(first, last):
            lower, upper = max(j - 1, first), min(j + 1, max(last - 1, first + 1))
            dA_half = changed.kappa[j] + longer[j] * cells.half[j] * (flow[upper] - flow[lower]) / (upper - lower)
            by_areas = 0.5 * (dA_half / changed.base.area[j] + area0[j])
            changed.kappa[j] = changed.viscosity[d, j] - longer[j] - by_areas


@njit(**JOINED)
def change_joined(d, step, tangent, changed):
    """Changes of flows at all faces and of the state of all ends, from the flows of the elastic step before."""
    area, dA, longer = step.state.area, tangent.changed.area[d], tangent.in_slots.length[d]
    vessels, ends, nodes, slopes = step.scheme.vessels, step.scheme.ends, step.half.nodes, tangent.lines
    changes, face_dA, face_dq = tangent.at_nodes, tangent.faces.area, tangent.faces.flow
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
