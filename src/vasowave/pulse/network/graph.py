"""Vessels as edges between numbered nodes: which are inlets, in what order blood reaches the others, how flow divides.

A tree is the graph in which one vessel ends wherever others begin.
"""

from collections.abc import Callable, Hashable, Sequence
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import InputError


class Meeting(NamedTuple):
    """Vessels that meet in one node.

    Attributes
    ----------
    ending, beginning : tuple of int
        Rows, in their order.
    """

    ending: tuple[int, ...]
    beginning: tuple[int, ...]


def numbered(nodes: Sequence[Sequence[Hashable]]) -> np.ndarray:
    """Return the two nodes of every vessel as numbers, shape (vessel, 2), in the order in which they are named."""
    number: dict[Hashable, int] = {}
    return np.array([[number.setdefault(node, len(number)) for node in pair] for pair in nodes], dtype=np.int64)


def meetings(start: np.ndarray, end: np.ndarray) -> dict[int, Meeting]:
    """Return what meets in every node, by its number; nodes in the order in which vessels end in them, then others."""
    ending: dict[int, list[int]] = {}
    beginning: dict[int, list[int]] = {}
    for row, (first, last) in enumerate(zip(start.tolist(), end.tolist(), strict=True)):
        ending.setdefault(last, []).append(row)
        beginning.setdefault(first, []).append(row)
    nodes = dict.fromkeys([*ending, *beginning])
    return {node: Meeting(tuple(ending.get(node, ())), tuple(beginning.get(node, ()))) for node in nodes}


def parents(name: tuple[str, ...], nodes: np.ndarray, where: Callable[[int], str]) -> np.ndarray:
    """Return the row of the vessel through which blood reaches each vessel on the shortest way, -1 at an inlet.

    Ways are counted in vessels from the inlets on, from start to end; of equal ones the first that is met counts.

    Raises
    ------
    InputError
        A vessel that ends where it begins, no inlet or no end, several vessels at an inlet or an end, vessels that are
        not reached; the row is named through `where`.
    """
    start, end = nodes.T
    bad = np.flatnonzero(start == end)
    if len(bad):
        raise InputError(f"{where(int(bad[0]))} (vessel '{name[bad[0]]}'): ends in the node in which it begins")
    met = meetings(start, end)
    _check_open_ends(name, met, where)
    parent, visited = np.full(len(name), -2), set[int]()
    level = sorted(row for meeting in met.values() if not meeting.ending for row in meeting.beginning)
    parent[level] = -1
    while level:
        further: list[int] = []
        for row in level:
            if end[row] not in visited:
                visited.add(int(end[row]))
                below = met[int(end[row])].beginning
                parent[list(below)] = row
                further += below
        level = further
    lost = np.flatnonzero(parent == -2)
    if len(lost):
        raise InputError(
            f"{where(int(lost[0]))} (vessel '{name[lost[0]]}'): not reached from an inlet along the vessels, from "
            "their starts to their ends; join it to the others, or turn those that are drawn against the way of blood"
        )
    _check_outlets(name, met, where)
    _check_whole(name, start, end, np.flatnonzero(parent == -1), where)
    return parent


def _check_open_ends(name: tuple[str, ...], met: dict[int, Meeting], where: Callable[[int], str]) -> None:
    """Refuse graphs without an inlet or an end, and those where several vessels share one."""
    for verb, one_side, advice in (
        ("begin", [meeting.beginning for meeting in met.values() if not meeting.ending], "let one vessel lead to them"),
        ("end", [meeting.ending for meeting in met.values() if not meeting.beginning], "let them lead to one vessel"),
    ):
        if not one_side:
            raise InputError(f"{where(0)}: no vessel {verb}s in a node of its own, where blood could "
                             f"{'enter' if verb == 'begin' else 'leave'}; the vessels form a ring")  # fmt: skip
        several = next((rows for rows in one_side if len(rows) > 1), None)
        if several:
            names = " and ".join(f"'{name[row]}'" for row in several[:2])
            raise InputError(
                f"{where(several[0])}: {names} {verb} in a node where none {'ends' if verb == 'begin' else 'begins'}; "
                f"{advice}, or turn one that is drawn against the way of blood"
            )


def _check_outlets(name: tuple[str, ...], met: dict[int, Meeting], where: Callable[[int], str]) -> None:
    """Refuse vessels that lead to no end."""
    level = [row for meeting in met.values() if not meeting.beginning for row in meeting.ending]
    leads = set(level)
    starts = {row: meeting for meeting in met.values() for row in meeting.beginning}
    while level:
        before = {row for later in level for row in starts[later].ending} - leads
        leads |= before
        level = list(before)
    lost = sorted(set(range(len(name))) - leads)
    if lost:
        raise InputError(
            f"{where(lost[0])} (vessel '{name[lost[0]]}'): leads to no vessel that ends in a bed; turn those that are "
            "drawn against the way of blood"
        )


def _check_whole(
    name: tuple[str, ...], start: np.ndarray, end: np.ndarray, inlets: np.ndarray, where: Callable[[int], str]
) -> None:
    """Refuse several inlets whose vessels never meet."""
    if len(inlets) < 2:
        return
    first, last, count = _places(start, end)
    component = _parts(first, last, count)
    strays = inlets[component[first[inlets]] != component[first[inlets[0]]]]
    if len(strays):
        raise InputError(
            f"{where(int(strays[0]))}: vessel '{name[strays[0]]}' and what follows it never meet the vessels behind "
            f"'{name[inlets[0]]}'; give each network a file of its own"
        )


def in_loops(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return which vessels are part of a loop: of a flow led into one end and out of the other some takes another way.

    In a network of n nodes at least 1/n of it does, between resistors of one size.
    """
    first, last, count = _places(start, end)
    between = np.linalg.pinv(_laplacian(first, last, np.ones(len(start)), count), hermitian=True)
    through = between[first, first] + between[last, last] - 2.0 * between[first, last]
    return np.asarray(through < 1.0 - 0.5 / count)


def in_series(conductance: np.ndarray, previous: np.ndarray) -> np.ndarray:
    """Return the conductance of each vessel with the pieces that continue it, shape (vessel,).

    Parameters
    ----------
    conductance : array, shape (vessel,)
        Of each piece.
    previous : int array, shape (vessel,)
        The vessel that a piece alone continues, -1 where it is no continuation.
    """
    conductance = conductance.copy()
    for piece in np.setdiff1d(np.flatnonzero(previous >= 0), previous).tolist():  # the last of each vessel
        while previous[piece] >= 0:
            before = previous[piece]
            conductance[before] = 1.0 / (1.0 / conductance[before] + 1.0 / conductance[piece])
            piece = before
    return conductance


def shares_by_conductance(start: np.ndarray, end: np.ndarray, conductance: np.ndarray) -> np.ndarray:
    """Return the share of the whole flow in each vessel, negative where it runs from end to start.

    What arrives at a junction, or at vessels that form loops together, divides as if one pressure stood at the ends of
    all vessels that lead away from there. Inlets share as their conductances.
    """
    first, last, count = _places(start, end)
    loops, inlets = in_loops(start, end), ~np.isin(start, end)
    conductance = in_series(conductance, _continued(first, last, loops, count))
    component = _parts(first[loops], last[loops], count)  # a junction alone, or nodes that loops join
    flow = np.zeros(len(start))
    flow[inlets] = conductance[inlets] / conductance[inlets].sum()
    awaited = np.bincount(component[last[~loops]], minlength=count)
    arrived: list[int] = np.flatnonzero(inlets).tolist()
    while arrived:
        into = component[last[arrived.pop()]]
        awaited[into] -= 1
        if awaited[into] == 0:
            leaving = np.flatnonzero((component[first] == into) & ~loops)
            _divide(np.flatnonzero(component == into), first, last, loops, conductance, flow)
            arrived += leaving.tolist()
    return flow


def _continued(first: np.ndarray, last: np.ndarray, loops: np.ndarray, count: int) -> np.ndarray:
    """Return the vessel that each vessel outside of loops alone continues, -1 where there is none."""
    entering = np.full(count, -1)
    entering[last[~loops]] = np.flatnonzero(~loops)
    through = (np.bincount(first, minlength=count) == 1) & (np.bincount(last, minlength=count) == 1)
    return np.where(~loops & through[first], entering[first], -1)


def _divide(
    nodes: np.ndarray, first: np.ndarray, last: np.ndarray, loops: np.ndarray, conductance: np.ndarray, flow: np.ndarray
) -> None:
    """Set the flows in all vessels between some nodes, and in those that leave them, by those that enter them."""
    is_inside = np.zeros(max(first.max(), last.max()) + 1, dtype=bool)
    is_inside[nodes] = True
    inner = np.flatnonzero(loops & is_inside[first])
    entering, leaving = np.flatnonzero(~loops & is_inside[last]), np.flatnonzero(~loops & is_inside[first])
    if not len(leaving):
        return
    place = np.zeros(len(is_inside), dtype=np.int64)
    place[nodes] = np.arange(len(nodes))
    balance = _laplacian(place[first[inner]], place[last[inner]], conductance[inner], len(nodes))
    np.add.at(balance, (place[first[leaving]],) * 2, conductance[leaving])
    pressure = np.linalg.solve(balance, np.bincount(place[last[entering]], flow[entering], len(nodes)))
    flow[leaving] = conductance[leaving] * pressure[place[first[leaving]]]
    flow[inner] = conductance[inner] * (pressure[place[first[inner]]] - pressure[place[last[inner]]])


def _places(start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """Return both nodes of every vessel as places from 0 on, and how many there are."""
    number, places = np.unique(np.concatenate([start, end]), return_inverse=True)
    return places[: len(start)], places[len(start) :], len(number)


def _parts(first: np.ndarray, last: np.ndarray, count: int) -> np.ndarray:
    """Return for each of `count` nodes the number of the part to which these vessels join it, shape (node,)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    return np.asarray(
        connected_components(coo_array((np.ones(len(first)), (first, last)), shape=2 * (count,)), False)[1]
    )


def _laplacian(first: np.ndarray, last: np.ndarray, conductance: np.ndarray, count: int) -> np.ndarray:
    """Return what pressures are multiplied by to have the flows out of the nodes, shape (node, node)."""
    laplacian = np.zeros((count, count))
    for node, neighbor in ((first, last), (last, first)):
        np.add.at(laplacian, (node, node), conductance)
        np.add.at(laplacian, (node, neighbor), -conductance)
    return laplacian


def steady_flows(start: np.ndarray, end: np.ndarray, conductance: np.ndarray) -> np.ndarray:
    """Return the flow in each vessel where the pressure is 1 at all inlets and 0 behind all ends."""
    first, last, count = _places(start, end)
    entered, exited = np.zeros(count, bool), np.zeros(count, bool)
    entered[last], exited[first] = True, True
    laplacian, pressure = _laplacian(first, last, conductance, count), np.where(entered, 0.0, 1.0)
    inner, boundary = np.flatnonzero(entered & exited), np.flatnonzero(~(entered & exited))
    pulled = laplacian[np.ix_(inner, boundary)] @ pressure[boundary]
    pressure[inner] = -np.linalg.solve(laplacian[np.ix_(inner, inner)], pulled)
    return np.asarray(conductance * (pressure[first] - pressure[last]))
