# mypy: disallow-untyped-defs=False
"""The system that viscous walls make of all flows at faces and all pressures of nodes, solved by elimination.

Inner faces are eliminated vessel by vessel, then the ends, and the pressures of the nodes are left.
"""

from heapq import heapify, heappop, heappush
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from vasowave.pulse.solver.cells import OPTIONS
from vasowave.pulse.solver.grid import Grid


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


def make_joints(grid: Grid) -> Joints:
    """Return how the vessels of a grid join, and the order of elimination."""
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
    queue = [(len(neighbors[k]), k) for k in range(count)]
    heapify(queue)
    eliminable = [True] * count
    while queue:
        degree, eliminated = heappop(queue)
        if degree != len(neighbors[eliminated]) or not eliminable[eliminated]:
            continue  # the entry is older than a change of its neighbors
        eliminable[eliminated] = False
        order.append(eliminated)
        later.append(sorted(neighbors[eliminated]))
        for neighbor in neighbors[eliminated]:
            neighbors[neighbor] |= neighbors[eliminated] - {neighbor}
            neighbors[neighbor].discard(eliminated)
            heappush(queue, (len(neighbors[neighbor]), neighbor))
    return order, later


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
