"""Graphs as NetworkX, igraph, Gephi and VesselVio write them: edges with lengths and radii, in one of eight forms."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.io.cells import is_numeric
from vasowave.base.io.columns import Columns, read_headings
from vasowave.base.io.headings import has_unit
from vasowave.base.io.textfile import read_bytes, read_start
from vasowave.base.stores import parsed
from vasowave.pulse.network.titles import is_size
from vasowave.pulse.network_formats import NETWORKS, table_format

_UNIT_KEYS = ("unit", "units", "length_unit", "unit_length", "spatial_unit", "units_length")
_LARGEST = 64 << 20  # bytes; a hundred thousand edges have 30 MB
_GML = re.compile(rb"(?:\s*(?:#[^\n]*\n|(?:Creator|Version|comment)\b[^\n]*\n))*\s*graph\s*\[")
_GXL, _VASCUSYNTH, _GEXF = b"<gxl", b"nodeType", b"<gexf"
_EDGE_LIST = re.compile(rb"(?:\s*#[^\n]*\n)*\s*[^\s{,;]+[ \t]+[^\s{,;]+[ \t]+\{\s*['\"]")  # as NetworkX writes it
_BELOW = ("children", "daughters", "branches")
_NESTED = re.compile(rb'\s*[\[{](?s:.*?)"(?:' + "|".join(_BELOW).encode() + rb')"\s*:\s*\[')
"""What holds the daughters of a vessel in a tree of objects within objects."""
_NODE_LINK = (
    b'"directed"',
    b'"source"',
    b'"elements"',
)  # beside the nodes, of which thousands may come before the edges


def is_graph(path: Path, start: bytes) -> bool:
    """Return whether a file is GraphML, GEXF, GXL, GML, JSON of Cytoscape, NetworkX or a tree, or list of edges."""
    if _GXL in start:
        return _VASCUSYNTH not in start
    if _EDGE_LIST.match(start) or _NESTED.match(start):
        return True
    is_json = start.lstrip().startswith(b"{") and b'"nodes"' in start and any(key in start for key in _NODE_LINK)
    is_xml = any(mark in start for mark in (b"graphml.graphdrawing.org", b"<graphml", _GEXF))
    return is_xml or bool(_GML.match(start)) or is_json


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
        raise InputError(f"{path}: larger than {_LARGEST >> 20} MB; take out what is not a vessel")
    try:
        graph = _read(path)
    except (networkx.NetworkXException, ElementTree.ParseError, LookupError, ValueError, TypeError, AttributeError,
            RuntimeError) as error:  # fmt: skip
        raise InputError(f"{path}: not a graph, or damaged ({' '.join(str(error).split())[:200]})") from None
    edges = list(graph.edges(data=True))
    if not edges:
        raise InputError(f"{path}: has no edge; export the graph with its edges")
    attributes = sorted({str(key) for _, _, values in edges for key in values} - {"id", "source", "target"})
    ends = ("source", "target") if graph.is_directed() else ("node 1", "node 2")
    cells = tuple(
        (str(first), str(last), *(str(values.get(name, "")) for name in attributes)) for first, last, values in edges
    )
    written = (name if has_unit(name) or not is_size(name) else f"{name}{_stated_unit(graph.graph, name)}"
               for name in attributes)  # fmt: skip
    titles = (*ends, *written)
    names, units = read_headings(path, titles, {})
    lines = tuple(range(1, len(cells) + 1))
    return Columns(str(path), names, units, cells, lines, titles=titles, row_word="edge")


def _read(path: Path) -> Any:
    """Return a graph; any exception of NetworkX."""
    import networkx

    start = read_start(path)
    if _EDGE_LIST.match(start):
        graph = networkx.read_edgelist(path, create_using=networkx.MultiGraph, encoding="utf-8-sig")
        count = sum(bool(line.partition(b"#")[0].strip()) for line in read_bytes(path).splitlines())
        return _complete(graph, count, "a line is no edge; was the file cut off?")
    if _GML.match(start):
        text = read_bytes(path).decode("utf-8-sig")
        several = "" if re.search(r"\bmultigraph\s+1\b", text) else " multigraph 1"  # NetworkX asks for the word
        graph = networkx.parse_gml(re.sub(r"\bgraph\s*\[", lambda match: match[0] + several, text, count=1), label="id")
        return _complete(graph, len(re.findall(r"\bedge\s*\[", text)), "an edge stands outside the graph")
    is_json = start.lstrip().startswith((b"{", b"["))
    if not is_json and ElementTree.fromstring(read_bytes(path)).find(".//{*}edge//{*}edge") is not None:
        raise ValueError("an edge stands within another")  # NetworkX passes over it
    if _GXL in start:
        return _of_gxl(path)
    if _GEXF in start:
        return networkx.read_gexf(path)
    if not is_json:
        return networkx.read_graphml(path)
    content = parsed(read_bytes(path))
    if _NESTED.match(start) and "nodes" not in content:
        return _of_nested(content)
    if "elements" in content:  # as Cytoscape writes it
        content |= {kind: [entry["data"] for entry in content["elements"][kind]] for kind in ("nodes", "edges")}
    content["multigraph"] = True  # of two edges between the same nodes a plain graph would hold the last alone
    return networkx.node_link_graph(content, edges="links" if "links" in content else "edges")


def _complete(graph: Any, edges: int, fault: str) -> Any:
    """Return a graph; `ValueError` with the fault where NetworkX passed over some of the edges that are written."""
    if graph.number_of_edges() != edges:
        raise ValueError(fault)
    return graph


def _of_gxl(path: Path) -> Any:
    """Return the graph of a file in the Graph eXchange Language (Winter et al. 2002)."""
    import networkx

    drawn = ElementTree.fromstring(read_bytes(path)).find("{*}graph")
    if drawn is None:
        raise ValueError("no graph in it")
    graph = networkx.MultiGraph() if "undirected" in drawn.get("edgemode", "") else networkx.MultiDiGraph()
    graph.graph.update(_attributes(drawn))
    edges = drawn.findall("{*}edge")
    graph.add_edges_from((edge.attrib["from"], edge.attrib["to"], _attributes(edge)) for edge in edges)
    return graph


def _of_nested(content: Any) -> Any:
    """Return the graph of a tree whose vessels hold their daughters: an edge each, from where its mother ends."""
    import networkx

    graph, waiting = networkx.MultiDiGraph(), [("0", content)]
    while waiting:
        node, entry = waiting.pop()
        if isinstance(entry, list):
            waiting += [(node, item) for item in reversed(entry)]
            continue
        if not isinstance(entry, dict):
            raise ValueError("a daughter is named where her mother should hold her; write a column 'parent'")
        values = {key: value for key, value in entry.items() if isinstance(value, str | int | float)}
        held = {key: value for key, value in entry.items() if isinstance(value, list | dict)}
        if not any(is_size(key) and is_numeric(str(value)) for key, value in values.items()):
            if node != "0":
                raise ValueError(f"an object among the vessels has no size, only {', '.join(entry)}")
            graph.graph.update(values | held)  # what holds the tree, with its units
            waiting += [(node, value) for key, value in held.items() if key != "units"]
        elif unknown := sorted(held.keys() - set(_BELOW)):
            raise ValueError(f"'{unknown[0]}' of a vessel is not read; daughters are its {' or '.join(_BELOW)}")
        else:
            end = str(graph.number_of_edges() + 1)
            values["name"] = values.get("name", values.get("id", end))
            graph.add_edge(node, end, **{key: value for key, value in values.items() if key != "parent"})
            waiting += [(end, value) for value in held.values()]
    return graph


def _attributes(element: ElementTree.Element) -> dict[str, str]:
    """Return the attributes of an element of GXL that have one value, as text."""
    pairs = ((child.get("name", "").strip(), list(child)) for child in element.findall("{*}attr"))
    return {name: (values[0].text or "").strip() for name, values in pairs if len(values) == 1 and not len(values[0])}


def _stated_unit(attributes: Mapping[str, Any], name: str) -> str:
    """Return the unit that a graph says of a size, or of all lengths, in brackets; empty without one."""
    if isinstance(of_each := attributes.get("units"), dict):
        attributes = {"unit": of_each.get(name, "")}
    words = {str(key).casefold(): str(value).strip() for key, value in attributes.items()}
    unit = next((words[key] for key in _UNIT_KEYS if key in words), "")
    return f" [{unit}]" if units.is_of(unit, "length") else ""


NETWORKS.register(
    table_format("graphml", "graph file", (".graphml", ".gexf", ".gml", ".gxl", ".edgelist"), is_graph, graph_columns)
)
