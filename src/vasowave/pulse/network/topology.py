"""What joins the vessels of a table: parents, daughters, or nodes, whose order may be the way of the blood or none."""

import re
from collections.abc import Callable, Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import Finding, look_kind
from vasowave.base.io.columns import Columns
from vasowave.pulse.network.graph import numbered
from vasowave.pulse.network.titles import topology_of

_NO_PARENT = ("0", "-1", "nan", "none", "na", "n/a", "-", "root")  # how other programs write that there is no parent

ROOT_TAKEN = look_kind(
    "network.root-taken",
    "blood is taken to enter at node '{node}' ({radius:.3g} cm), {reason}; {remedy}",
    "if it enters elsewhere, write every vessel the way blood flows, in columns 'from' and 'to'",
)


def joined_vessels(
    table: Columns, names: Sequence[str], radius: np.ndarray, where: Callable[[int], str]
) -> tuple[np.ndarray | None, np.ndarray | None, list[Finding]]:
    """Return rows of the parents, or numbers of the nodes, of a table of vessels, and where blood was taken to enter.

    Raises
    ------
    InputError
        A parent, a daughter or a node that is missing, or joins what is no network; the row is named through `where`.
    """
    topology = topology_of(table.names)
    if topology == ("parent",) and "from" in table.names and "to" in table.names:
        raise InputError(f"{table.source}: both 'parent' and 'from', 'to' say what joins the vessels; keep one of them")
    if topology == ("daughters",):
        return np.array(_parent_rows(names, _parents_by_daughters(table, names, where), where)), None, []
    if topology == ("parent",):
        parents = [row[table.require("parent")] for row in table.cells]
        return np.array(_parent_rows(names, parents, where)), None, []
    columns = [table.require(title) for title in topology]
    ends = [[row[column].strip() for column in columns] for row in table.cells]
    empty = next((row for row, pair in enumerate(ends) if not all(pair)), None)
    if empty is not None:
        raise InputError(
            f"{where(empty)} (vessel '{names[empty]}'): no node in '{topology[0]}' or '{topology[1]}'; every vessel "
            "has two"
        )
    if topology == ("from", "to"):
        return None, numbered(ends), []
    return None, *directed_from_root(ends, radius, where, directed=topology == ("source", "target"))


def _parents_by_daughters(table: Columns, names: Sequence[str], where: Callable[[int], str]) -> list[str]:
    """Return the name of every vessel's parent by the columns that name its daughters."""
    rows, parents = {name: row for row, name in enumerate(names)}, [""] * len(names)
    columns = [column for column, name in enumerate(table.names) if name == "daughters"]
    for row, cells in enumerate(table.cells):
        for cell in (cells[column].strip() for column in columns):
            for daughter in [cell] if cell in rows else re.split(r"[\s;,|]+", cell):
                if daughter in rows and parents[rows[daughter]]:
                    raise InputError(f"{where(row)}: '{daughter}' is a daughter of two; write nodes, 'from' and 'to'")
                if daughter in rows:
                    parents[rows[daughter]] = names[row]
                elif daughter.lower() not in ("", *_NO_PARENT):
                    raise InputError(f"{where(row)}: daughter '{daughter}' is not in the table")
    return parents


def _parent_rows(names: Sequence[str], parents: Sequence[str], where: Callable[[int], str]) -> list[int]:
    rows = {name: row for row, name in enumerate(names)}
    numbers = []
    for row, parent in enumerate(parents):
        if parent not in rows and parent.lower() in ("", *_NO_PARENT):
            numbers.append(-1)
            continue
        if parent not in rows:
            twice = next((name for name in names if names.count(name) > 1), None)
            hint = f"; '{twice}' stands there twice, is one of them it?" if twice else did_you_mean(parent, rows)
            raise InputError(f"{where(row)} (vessel '{names[row]}'): parent '{parent}' is not in the table{hint}")
        numbers.append(rows[parent])
    return numbers


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
