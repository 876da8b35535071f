"""Edges between nodes, whose direction may be that of the blood or none, as a tree from where blood enters."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind
from vasowave.pulse.network.graph import numbered

ROOT_TAKEN = look_kind(
    "network.root-taken",
    "blood is taken to enter at node '{node}' ({radius:.3g} cm), {reason}; {remedy}",
    "if it enters elsewhere, write every vessel the way blood flows, in columns 'from' and 'to'",
)


def directed_from_root(
    ends: Sequence[Sequence[str]], radius: np.ndarray, where: Callable[[int], str], directed: bool
) -> tuple[np.ndarray, list[Finding]]:
    """Return the nodes of every edge in the direction of flow, shape (edge, 2), and where blood was taken to enter.

    Parameters
    ----------
    ends : sequence of pairs of str
        Names of the two nodes of each edge.
    radius : float array, shape (edge,)
        cm; blood enters at the widest end of a tree without a direction.
    where : callable
        Says for a row how errors call it.
    directed : bool
        Whether the order of the two nodes is believed if all edges lead away from one node.

    Raises
    ------
    InputError
        Edges that close a loop, or are several trees.
    """
    nodes = numbered(ends)
    _require_tree(ends, nodes, where)
    label = {number: name for pair, names in zip(nodes.tolist(), ends, strict=True)
             for number, name in zip(pair, names, strict=True)}  # fmt: skip
    degree = np.bincount(nodes.ravel())
    leaves = np.flatnonzero(degree[nodes].min(axis=1) == 1)
    widest = int(leaves[np.argmax(radius[leaves])])
    if directed and np.bincount(nodes[:, 1]).max() == 1:  # a tree in which no two edges end together has one root
        root = int(np.setdiff1d(nodes[:, 0], nodes[:, 1])[0])
        first = float(radius[nodes[:, 0] == root].max())
        if first >= radius[widest]:
            return nodes, []
        reason = f"where the edges begin, though another end is wider ({radius[widest]:.3g} cm)"
        return nodes, [ROOT_TAKEN(node=label[root], radius=first, reason=reason)]
    root = int(nodes[widest][np.argmin(degree[nodes[widest]])])
    graph = coo_array((np.ones(len(nodes)), nodes.T), shape=(len(degree), len(degree)))
    _, above = breadth_first_order(graph.tocsr(), root, directed=False)
    nodes = np.where((above[nodes[:, 1]] == nodes[:, 0])[:, None], nodes, nodes[:, ::-1])
    reason = "the widest end of vessels whose order says no direction"
    return nodes, [ROOT_TAKEN(node=label[root], radius=float(radius[widest]), reason=reason)]


def _require_tree(ends: Sequence[Sequence[str]], nodes: np.ndarray, where: Callable[[int], str]) -> None:
    group = list(range(int(nodes.max()) + 1))

    def top(node: int) -> int:
        while group[node] != node:
            group[node] = group[group[node]]
            node = group[node]
        return node

    for row, (first, last) in enumerate(nodes.tolist()):
        if top(first) == top(last):
            raise InputError(
                f"{where(row)}: the edge from '{ends[row][0]}' to '{ends[row][1]}' closes a loop; remove it if it is "
                "none, or write all vessels the way blood flows, in columns 'from' and 'to'"
            )
        group[top(first)] = top(last)
    separate = next((row for row, (first, _) in enumerate(nodes.tolist()) if top(first) != top(int(nodes[0, 0]))), None)
    if separate is not None:
        trees = len({top(node) for node in range(len(group))})
        raise InputError(
            f"{where(separate)}: the edges are {trees} trees that nothing joins: no way leads from '{ends[0][0]}' to "
            f"'{ends[separate][0]}'; a network is one tree: take out the others"
        )
