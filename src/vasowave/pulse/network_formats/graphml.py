"""GraphML, as NetworkX, igraph, Gephi and VesselVio write it: edges with lengths and radii as attributes."""

from pathlib import Path
from xml.etree.ElementTree import ParseError

from vasowave.base.errors import InputError
from vasowave.base.io.columns import Columns, read_headings
from vasowave.pulse.network_formats import NETWORKS, table_format

_LARGEST = 64 << 20  # bytes; a hundred thousand edges have 30 MB
_MARK = b"graphml.graphdrawing.org"


def is_graphml(path: Path, start: bytes) -> bool:
    """Return whether a file is GraphML, by its first element."""
    return _MARK in start or b"<graphml" in start


def graphml_columns(path: Path) -> Columns:
    """Return the edges of a GraphML file as a table; nodes are named as in the file.

    Edges have a direction where the file says so of all.

    Raises
    ------
    InputError
        A file that is no GraphML, or has no edge.
    """
    import networkx

    if path.stat().st_size > _LARGEST:
        raise InputError(f"{path}: larger than {_LARGEST >> 20} MB; take out what is no vessel")
    try:
        graph = networkx.read_graphml(path)
    except (networkx.NetworkXException, ParseError, LookupError, ValueError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: not GraphML, or damaged ({' '.join(str(error).split())[:200]})") from None
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


NETWORKS.register(table_format("graphml", "GraphML file", (".graphml",), is_graphml, graphml_columns))
