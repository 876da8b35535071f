"""Graphs as NetworkX, igraph, Gephi and VesselVio write them, GraphML, GML or JSON: edges with lengths and radii."""

import re
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import ParseError

from vasowave.base.errors import InputError
from vasowave.base.io.columns import Columns, read_headings
from vasowave.base.io.textfile import read_bytes, read_start
from vasowave.base.stores import parsed
from vasowave.pulse.network_formats import NETWORKS, table_format

_LARGEST = 64 << 20  # bytes; a hundred thousand edges have 30 MB
_GML = re.compile(rb"(?:\s*(?:#[^\n]*\n|(?:Creator|Version|comment)\b[^\n]*\n))*\s*graph\s*\[")
_NODE_LINK = (b'"directed"', b'"source"')  # beside the nodes, of which thousands may come before the edges


def is_graph(path: Path, start: bytes) -> bool:
    """Return whether a file is GraphML, GML or NetworkX's JSON, by its first element or keys."""
    is_json = start.lstrip().startswith(b"{") and b'"nodes"' in start and any(key in start for key in _NODE_LINK)
    return b"graphml.graphdrawing.org" in start or b"<graphml" in start or bool(_GML.match(start)) or is_json


def graph_columns(path: Path) -> Columns:
    """Return the edges of a graph as a table; nodes are named as in the file.

    Edges have a direction where the file says so of all.

    Raises
    ------
    InputError
        A file that is no graph, or has no edge.
    """
    import networkx

    if path.stat().st_size > _LARGEST:
        raise InputError(f"{path}: larger than {_LARGEST >> 20} MB; take out what is no vessel")
    try:
        graph = _read(path)
    except (networkx.NetworkXException, ParseError, LookupError, ValueError, TypeError, AttributeError,
            RecursionError) as error:  # fmt: skip
        raise InputError(f"{path}: not a graph, or damaged ({' '.join(str(error).split())[:200]})") from None
    edges = list(graph.edges(data=True))
    if not edges:
        raise InputError(f"{path}: has no edge; export the graph with its edges")
    attributes = sorted({str(key) for _, _, values in edges for key in values} - {"id", "source", "target"})
    ends = ("source", "target") if graph.is_directed() else ("node 1", "node 2")
    cells = tuple(
        (str(first), str(last), *(str(values.get(name, "")) for name in attributes)) for first, last, values in edges
    )
    titles = (*ends, *attributes)
    names, units = read_headings(path, titles, {})
    lines = tuple(range(1, len(cells) + 1))
    return Columns(str(path), names, units, cells, lines, titles=titles, row_word="edge")


def _read(path: Path) -> Any:
    """Return a graph; any exception of NetworkX."""
    import networkx

    start = read_start(path)
    if _GML.match(start):
        return networkx.read_gml(path, label="id")
    if not start.lstrip().startswith(b"{"):
        return networkx.read_graphml(path)
    content = parsed(read_bytes(path))
    return networkx.node_link_graph(content, edges="links" if "links" in content else "edges")


NETWORKS.register(
    table_format("graphml", "GraphML, GML or node-link file", (".graphml", ".gml"), is_graph, graph_columns)
)
