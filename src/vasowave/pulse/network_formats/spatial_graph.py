"""Spatial graphs of Amira and Avizo (.am, ASCII, or a spreadsheet): vessels as edges with points that have radii."""

import re
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.columns import Columns, read_columns
from vasowave.base.io.spreadsheet import is_workbook, read_sheets
from vasowave.base.io.textfile import read_lines, read_start
from vasowave.base.units import is_of
from vasowave.pulse.network.titles import UNDERSTOOD, canonical_title
from vasowave.pulse.network_formats import NETWORKS, table_format

_COUNT = re.compile(r"define\s+(VERTEX|EDGE|POINT)\s+(\d{1,9})\b")
_ARRAY = re.compile(r"(VERTEX|EDGE|POINT)\s*\{\s*\w+\s*(?:\[(\d)\])?\s+(\w+)\s*\}\s*=?\s*@(\d+)")
_UNIT = re.compile(r'Coordinates\s+"([^"]*)"')
_DATA = re.compile(r"^\s*@(\d+)\s*$", re.MULTILINE)
_CONNECTIVITY, _POINTS_OF_EDGE, _POINTS = "EdgeConnectivity", "NumEdgePoints", "EdgePointCoordinates"
_THICKNESS = "thickness"
"""What Amira's skeletons call the distance from each point to the wall: a radius."""


Arrays = dict[tuple[str, str], np.ndarray]
"""The arrays of a file, by the kind of what they belong to and their name."""


def is_spatial_graph(path: Path, start: bytes) -> bool:
    """Return whether a file of Amira is a spatial graph, and no image or surface."""
    first = start[:40].lower()
    return (b"amiramesh" in first or b"avizo" in first) and (b"HxSpatialGraph" in start or b"define EDGE" in start)


def spatial_graph_columns(path: Path) -> Columns:
    """Return the edges of a spatial graph as a table: length along the points, mean radius over that length.

    Raises
    ------
    InputError
        A binary file, one that is cut off, or one without radii.
    """
    graph, unit = read_spatial_graph(path)
    nodes = _array(path, graph, "EDGE", _CONNECTIVITY).astype(int)
    counts = _array(path, graph, "EDGE", _POINTS_OF_EDGE).astype(int).ravel()
    points = _array(path, graph, "POINT", _POINTS)
    if nodes.shape[1] != 2 or points.shape[1] != 3 or counts.min(initial=2) < 2 or counts.sum() != len(points):
        raise InputError(f"{path}: {_POINTS_OF_EDGE} and {_POINTS} do not fit; every edge has two points or more")
    kind_and_title, values = _width(path, graph)
    return _of_edges(path, nodes, np.split(points, np.cumsum(counts)[:-1]), kind_and_title, values, unit)


def _of_edges(path: Path, nodes: np.ndarray, points: list[np.ndarray], kind_and_title: tuple[str, str],
              values: np.ndarray, unit: str) -> Columns:  # fmt: skip
    """Return edges between nodes as a table: their points, and widths at these, one after the other, or of each."""
    (kind, title), counts = kind_and_title, np.array([len(of_edge) for of_edge in points])
    cells = []
    for row, (first, last) in enumerate(zip(np.cumsum(counts) - counts, np.cumsum(counts), strict=True)):
        step = np.linalg.norm(np.diff(points[row], axis=0), axis=1)
        along = values[first:last] if kind == "POINT" else values[[row, row]]
        middle = 0.5 * (along[1:] + along[:-1])
        width = float(np.average(middle, weights=step if kind == "POINT" and step.any() else None))
        cells.append((*map(str, nodes[row].tolist()), repr(float(step.sum())), repr(width)))
    width_name = canonical_title(title)[0] if title.lower() != _THICKNESS else "radius"
    names, units = ("node 1", "node 2", "length", width_name), ("", "", unit, unit)
    suffix = f" in {unit}" if unit else ""
    remark = UNDERSTOOD(columns=f"'{title}' ({kind}) → {width_name}{suffix}, '{_POINTS}' → length{suffix}")
    lines = tuple(range(1, len(cells) + 1))
    return Columns(str(path), names, units, tuple(cells), lines, (remark,), names, "edge")


def is_spreadsheet(path: Path, start: bytes) -> bool:
    """Return whether a workbook holds the tables of a spatial graph: its nodes, points and segments."""
    return is_workbook(start) and {"nodes", "points", "segments"} <= {
        sheet.name.strip().casefold() for sheet in read_sheets(path)
    }


def spreadsheet_columns(path: Path) -> Columns:
    """Return the segments of the spreadsheet that Amira shows of a spatial graph as a table.

    Raises
    ------
    InputError
        Columns that are lacking; segments whose points are not there.
    """
    table, listed = read_columns(path, sheet="Points"), read_columns(path, sheet="Segments")
    place = {row[0].strip(): i for i, row in enumerate(table.cells)}
    axes = [table.require(f"{axis} coord") for axis in "xyz"]
    width = next((i for i, name in enumerate(table.names) if canonical_title(name)[0] in ("radius", "diameter")
                  or name == _THICKNESS), None)  # fmt: skip
    nodes = [[row[listed.require(f"node id #{end}")] for end in (1, 2)] for row in listed.cells]
    try:
        rows = [
            [place[number] for number in re.findall(r"\d+", row[listed.require("point ids")])] for row in listed.cells
        ]
    except KeyError as missing:
        raise InputError(f"{path}: no point {missing} in the sheet 'Points', which a segment names") from None
    if width is None or min(map(len, rows), default=0) < 2:
        raise InputError(f"{path}: its points have no radius, diameter or thickness, or a segment has fewer than two")
    numbers = np.column_stack([table.numbers(column, "length", "cm") for column in (*axes, width)])
    points = [numbers[row, :3] for row in rows]
    values = np.concatenate([numbers[row, 3] for row in rows])
    return _of_edges(path, np.array(nodes), points, ("POINT", table.titles[width]), values, "")


def read_spatial_graph(path: Path) -> tuple[Arrays, str]:
    """Return the arrays of an ASCII file, and the unit of length that it says, which may be empty."""
    if b"BINARY" in read_start(path, 200).upper():
        raise InputError(f"{path}: is saved in binary; save it as 'Amira ASCII'")
    text = "\n".join(line for block in read_lines(path) for line in block.texts)
    pieces = _DATA.split(text)
    header, data = pieces[0], dict(zip(pieces[1::2], pieces[2::2], strict=True))
    counts = {kind: int(count) for kind, count in _COUNT.findall(header)}
    arrays = {}
    for kind, width, name, place in _ARRAY.findall(header):
        try:
            numbers = np.array(data.get(place, "").split(), dtype=float)
        except ValueError:
            raise InputError(f"{path}: {name} (@{place}) holds what is not a number") from None
        size = counts.get(kind, 0) * int(width or 1)
        if len(numbers) != size or not np.isfinite(numbers).all() or not size:
            raise InputError(f"{path}: {len(numbers)} finite numbers of {name} where {size} belong; was it cut off?")
        arrays[kind, name] = numbers.reshape(-1, int(width or 1))
    unit = (match[1] if (match := _UNIT.search(header)) else "").strip()
    return arrays, unit if is_of(unit, "length") else ""


def _array(path: Path, graph: Arrays, kind: str, name: str) -> np.ndarray:
    if (kind, name) not in graph:
        names = ", ".join(f"{name} ({kind})" for kind, name in graph) or "none"
        raise InputError(f"{path}: no {name} of {kind}, as spatial graphs have it; its arrays: {names}")
    return graph[kind, name]


def _width(path: Path, graph: Arrays) -> tuple[tuple[str, str], np.ndarray]:
    """Return kind and name of the array that says how wide vessels are, and its values; those at points first."""
    widths = [(kind, name) for kind in ("POINT", "EDGE") for holder, name in graph
             if holder == kind and (canonical_title(name)[0] in ("radius", "diameter") or name.lower() == _THICKNESS)
             and graph[kind, name].shape[1] == 1]  # fmt: skip
    if not widths:
        names = ", ".join(name for _, name in graph)
        raise InputError(f"{path}: no radius, diameter or thickness at its points or edges; its arrays: {names}")
    return widths[0], graph[widths[0]].ravel()


NETWORKS.register(table_format("spatial graph table", "spreadsheet of Amira", (), is_spreadsheet, spreadsheet_columns))
NETWORKS.register(
    table_format("spatial graph", "spatial graph of Amira", (".am",), is_spatial_graph, spatial_graph_columns)
)
