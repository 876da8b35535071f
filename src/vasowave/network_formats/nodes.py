"""Edges between named nodes as a tree of vessels."""

from collections.abc import Sequence
from pathlib import Path

from vasowave.errors import InputError


def parents_of_edges(path: Path, edges: Sequence[tuple[str, str, str]]) -> list[int]:
    """Return the row of every edge's parent, -1 for the root.

    Parameters
    ----------
    path : Path
        For messages.
    edges : sequence of (name, start, end)
        Nodes by name; blood flows from start to end.

    Raises
    ------
    InputError
        Two edges end in one node, where flows would meet: the network has a loop, or an edge runs against the flow.
    """
    into: dict[str, int] = {}
    for row, (name, _, end) in enumerate(edges):
        if end in into:
            other = edges[into[end]][0]
            raise InputError(
                f"{path}: '{other}' and '{name}' both end in node '{end}', so that flows meet; a network with loops "
                "cannot be simulated. Cut one of them, or turn it if it runs against the flow"
            )
        into[end] = row
    return [into.get(start, -1) for _, start, _ in edges]
