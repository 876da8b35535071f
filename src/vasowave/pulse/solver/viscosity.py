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

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from vasowave.pulse.solver.cells import OPTIONS
from vasowave.pulse.solver.grid import Grid
from vasowave.pulse.solver.laws import ratio_at, slope_at
from vasowave.pulse.solver.nodes import LEAST_GIVE, NEWTON_CLOSE, NEWTON_MOST, fill_beds, meet_outside
from vasowave.pulse.solver.valve import eject, meet_ventricle, valve_moves


class Joints(NamedTuple):
    """Which ends and nodes vessels join, and in which order nodes are eliminated."""

    inlet: np.ndarray  # (vessel,) its end among `Ends`
    outlet: np.ndarray  # (vessel,)
    node: np.ndarray  # (end,)
    entry: np.ndarray  # (vessel,) place of its two nodes' coefficient among the entries
    order: np.ndarray  # (node,)
    start: np.ndarray  # (node + 1,) first entry of each node in that order
    neighbor: np.ndarray  # (entry,) a node that is eliminated later
    fill: np.ndarray  # (pair of entries of one node,) entry of the two neighbors


class Viscous(NamedTuple):
    """What kernels know of viscous walls, and their scratch memory."""

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


def make_viscous(grid: Grid) -> Viscous | None:
    """Return what kernels know of the viscous walls of a grid; None where no wall is viscous."""
    viscosity = np.broadcast_to(grid.model.wall_viscosity, len(grid.counts))
    if not viscosity.any():
        return None
    joints = _joints(grid)
    coefficient = viscosity[grid.vessel] / (2.0 * np.sqrt(grid.area0) * grid.spacing)
    slots, vessels, ends, nodes = len(grid.vessel), len(grid.counts), len(joints.node), len(joints.order)
    sizes = [*9 * [slots], ends, vessels, *6 * [ends], vessels, nodes, len(joints.neighbor), nodes]
    return Viscous(joints, coefficient, *map(np.zeros, sizes))


def _joints(grid: Grid) -> Joints:
    start, vessel, side = grid.joined_ends
    count = len(grid.counts)
    node = np.arange(len(vessel)) - np.repeat(start[:-1], np.diff(start))
    inlet, outlet = np.zeros((2, count), dtype=np.int64)
    inlet[vessel[side < 0]], outlet[vessel[side > 0]] = np.flatnonzero(side < 0), np.flatnonzero(side > 0)
    pairs = [frozenset((int(node[a]), int(node[b]))) for a, b in zip(inlet, outlet, strict=True)]
    order, later = _elimination(int(start[1]), pairs)
    place: dict[frozenset[int], int] = {}
    for eliminated, neighbors in zip(order, later, strict=True):
        for neighbor in neighbors:
            place[frozenset((eliminated, neighbor))] = len(place)
    fill = [
        place[frozenset((a, b))] for neighbors in later for i, a in enumerate(neighbors) for b in neighbors[i + 1 :]
    ]
    indices: Any = [node, [place[pair] for pair in pairs], order, np.cumsum([0, *map(len, later)]),
                  [neighbor for neighbors in later for neighbor in neighbors], fill]  # fmt: skip
    return Joints(inlet, outlet, *(np.asarray(values, dtype=np.int64) for values in indices))


def _elimination(count: int, pairs: list[frozenset[int]]) -> tuple[list[int], list[list[int]]]:
    """Return the order in which nodes are eliminated, fewest neighbors first, and the neighbors that each has then."""
    neighbors: list[set[int]] = [set() for _ in range(count)]
    for a, b in map(tuple, pairs):
        neighbors[a].add(b)
        neighbors[b].add(a)
    order: list[int] = []
    later: list[list[int]] = []
    remaining = set(range(count))
    while remaining:
        eliminated = min(remaining, key=lambda k: (len(neighbors[k]), k))
        remaining.remove(eliminated)
        order.append(eliminated)
        later.append(sorted(neighbors[eliminated]))
        for neighbor in neighbors[eliminated]:
            neighbors[neighbor] |= neighbors[eliminated] - {neighbor}
            neighbors[neighbor].discard(eliminated)
    return order, later


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
def eliminate_faces(vessels, viscous):
    """Take the right sides of the inner faces to those of the ends: `right_side` to `side`."""
    joints = viscous.joints
    for v in range(len(vessels.first)):
        inlet, outlet, before = joints.inlet[v], joints.outlet[v], 0.0
        for j in range(vessels.first[v] + 1, vessels.last[v]):
            viscous.right_side[j] += before
            viscous.side[inlet] += viscous.to_inlet[j] * viscous.right_side[j]
            before = viscous.to_next[j] * viscous.right_side[j]
        viscous.side[outlet] += before


@njit(**OPTIONS)
def join_vessels(vessels, nodes, viscous):
    """Admittances of the vessels by what their ends give, and the nodes' coefficients, eliminated.

    `diagonal` holds at first what each node's bed takes by its pressure.
    """
    joints, diagonal, entries = viscous.joints, viscous.diagonal, viscous.entries
    for i in range(len(entries)):
        entries[i] = 0.0
    for v in range(len(vessels.first)):
        a, b = joints.inlet[v], joints.outlet[v]
        inlet_diagonal, outlet_diagonal = (
            1.0 / viscous.give[a] + viscous.end_coefficient[a],
            1.0 / viscous.give[b] + viscous.end_coefficient[b],
        )
        per_determinant = 1.0 / (inlet_diagonal * outlet_diagonal - viscous.across[v] * viscous.across[v])
        viscous.admittance[a], viscous.admittance[b] = (
            outlet_diagonal * per_determinant,
            inlet_diagonal * per_determinant,
        )
        viscous.transfer[v] = viscous.across[v] * per_determinant
        diagonal[joints.node[a]] += viscous.admittance[a]
        diagonal[joints.node[b]] += viscous.admittance[b]
        if nodes.weight[joints.node[a]] > 0.0 and nodes.weight[joints.node[b]] > 0.0:
            entries[joints.entry[v]] -= viscous.transfer[v]
    for k in range(len(diagonal)):
        if nodes.weight[k] == 0.0:  # its pressure is given
            diagonal[k] = 1.0
    filled = 0
    for i in range(len(joints.order)):
        for a in range(joints.start[i], joints.start[i + 1]):
            share = entries[a] / diagonal[joints.order[i]]
            diagonal[joints.neighbor[a]] -= share * entries[a]
            for b in range(a + 1, joints.start[i + 1]):
                entries[joints.fill[filled]] -= share * entries[b]
                filled += 1
    for i in range(len(joints.order)):
        for a in range(joints.start[i], joints.start[i + 1]):
            entries[a] /= diagonal[joints.order[i]]


@njit(**OPTIONS)
def solve_joined(vessels, nodes, viscous):
    """Pressures of all nodes and flows at all ends.

    `side` holds the right sides of the ends, `balance` at first those of the nodes: what flows into each from without
    or, where its pressure is given, that; at last it holds the pressures.
    """
    joints, balance = viscous.joints, viscous.balance
    for v in range(len(vessels.first)):
        a, b = joints.inlet[v], joints.outlet[v]
        at_a, at_b = joints.node[a], joints.node[b]
        viscous.flow[a] = viscous.admittance[a] * viscous.side[a] + viscous.transfer[v] * viscous.side[b]
        viscous.flow[b] = viscous.admittance[b] * viscous.side[b] + viscous.transfer[v] * viscous.side[a]
        by_a, by_b = -viscous.flow[a], viscous.flow[b]
        if nodes.weight[at_a] == 0.0:
            by_a, by_b = 0.0, by_b + viscous.transfer[v] * balance[at_a]
        if nodes.weight[at_b] == 0.0:
            by_a, by_b = by_a + viscous.transfer[v] * balance[at_b], 0.0
        balance[at_a] += by_a
        balance[at_b] += by_b
    for i in range(len(joints.order)):
        for a in range(joints.start[i], joints.start[i + 1]):
            balance[joints.neighbor[a]] -= viscous.entries[a] * balance[joints.order[i]]
    for i in range(len(joints.order) - 1, -1, -1):
        k = joints.order[i]
        balance[k] /= viscous.diagonal[k]
        for a in range(joints.start[i], joints.start[i + 1]):
            balance[k] -= viscous.entries[a] * balance[joints.neighbor[a]]
    for v in range(len(vessels.first)):
        a, b = joints.inlet[v], joints.outlet[v]
        at_a, at_b = balance[joints.node[a]], balance[joints.node[b]]
        viscous.flow[a] += viscous.admittance[a] * at_a - viscous.transfer[v] * at_b
        viscous.flow[b] += viscous.transfer[v] * at_a - viscous.admittance[b] * at_b


@njit(**OPTIONS)
def fill_faces(vessels, viscous, flow):
    """Flows at all faces from those at the ends."""
    for v in range(len(vessels.first)):
        first, last = vessels.first[v], vessels.last[v]
        flow[first], flow[last] = viscous.flow[viscous.joints.inlet[v]], viscous.flow[viscous.joints.outlet[v]]
        for j in range(last - 1, first, -1):
            flow[j] = viscous.right_side[j] / viscous.pivot[j]
            flow[j] += viscous.to_inlet[j] * flow[first] + viscous.to_next[j] * flow[j + 1]


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
def solve_viscous(inflow, heart, outlet, memory, vessels, ends, wall, viscous, nodes, faces):
    """Flows at all faces, and the state of all vessel ends, at the half step; -1, or the end that has no solution."""
    meet_outside(inflow, outlet, memory, ends, nodes)
    if heart is not None:
        meet_ventricle(inflow[0], heart, ends, nodes)
    if not join_all(vessels, ends, wall, viscous, nodes, faces):
        return worst_end(nodes)
    if heart is not None:
        e = ends.inlet  # the inlet's only end
        if valve_moves(inflow[0], heart, viscous.flow[e], viscous.balance[e]):
            meet_ventricle(inflow[0], heart, ends, nodes)
            if not join_all(vessels, ends, wall, viscous, nodes, faces):
                return worst_end(nodes)
        eject(heart, viscous.flow[e])
    for e in range(len(ends.face)):
        faces.area[ends.face[e]] = nodes.end_area[e] + nodes.compliance[e] * nodes.missed[e]
    for k in range(len(viscous.balance)):
        nodes.pressure[0, k] = viscous.balance[k]
    fill_faces(vessels, viscous, faces.flow)
    for v in range(len(vessels.first)):
        for j in range(vessels.first[v], vessels.last[v]):
            viscous.pressure[j] = viscous.kappa[j] * (faces.flow[j] - faces.flow[j + 1])
    to_faces(vessels, viscous.pressure, viscous.at_faces)
    fill_beds(outlet, memory, ends, nodes, faces)
    return -1


@njit(**OPTIONS)
def worst_end(nodes):
    """Return the end whose last Newton step was the longest."""
    where = 0
    for e in range(len(nodes.missed)):
        if abs(nodes.missed[e]) > abs(nodes.missed[where]):
            where = e
    return where


@njit(**OPTIONS)
def push_cells(flow, vessels, cells, fluid, viscous, faces):
    """What the viscous pressure at the faces makes of the flow in the cells."""
    for v in range(len(vessels.first)):
        for j in range(vessels.first[v], vessels.last[v]):
            mean_area = 0.5 * (faces.area[j] + faces.area[j + 1])
            push = 2.0 * cells.half[j] * mean_area / fluid.inertia
            flow[j] -= push * (viscous.at_faces[j + 1] - viscous.at_faces[j])
