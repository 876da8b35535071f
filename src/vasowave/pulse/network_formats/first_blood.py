"""FirstBlood's table of edges between nodes, SI units in its header."""

import csv
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding
from vasowave.base.io.columns import NO_END
from vasowave.base.io.textfile import read_lines
from vasowave.pulse.network.graph import numbered
from vasowave.pulse.network.network import Network
from vasowave.pulse.network.remarks import LEFT_OUT, UNUSED
from vasowave.pulse.network_formats import NETWORKS, NetworkFormat, number_in, taper_of

_VESSELS = ("vis", "vis_f")
_NODES = ("heart", "node", "perif")
_TITLE = "type"  # the nodes have a header of their own
_SIZES = ("start_diameter[SI]", "end_diameter[SI]", "length[SI]")
_COLUMNS = ("type", "ID", "start_node", "end_node", *_SIZES)
_WORDS = ("name", "division_points")  # of a table of edges, that no network needs
_CM = 100.0  # a meter


def is_edges(path: Path, start: bytes) -> bool:
    """Return whether a file is such a table, by its header."""
    head = start.split(b"\n", 1)[0]
    return all(title.encode() in head for title in _COLUMNS)


def read_edges(path: Path, scale: float) -> tuple[Network, list[Finding]]:
    """Read the rows of vessels; beds, the heart and what nodes leak are left out.

    The rows of nodes tell whether a vessel is missing: those of type perif, and no others, have no vessel behind them.
    """
    titles: list[str] = []
    lines, cells, nodes = list[int](), list[dict[str, str]](), dict[str, str]()
    looks: list[Finding] = []
    for block in read_lines(path):
        looks += [NO_END()] if block.cut else []
        for line, row in enumerate(csv.reader(block.texts), block.first):
            if not titles:
                titles = [title.strip() for title in row]
                if missing := [title for title in _COLUMNS if title not in titles]:
                    raise InputError(f"{path}, line {line}: no column '{missing[0]}'; the columns of a table of edges "
                                     f"are {', '.join(_COLUMNS)}")  # fmt: skip
            elif row and row[0].strip() in _VESSELS:
                if len(row) < len(titles):
                    raise InputError(f"{path}, line {line}: {len(row)} cells for {len(titles)} columns")
                cells.append(dict(zip(titles, (cell.strip() for cell in row[: len(titles)]), strict=True)))
                lines.append(line)
            elif len(row) > 1 and row[0].strip() in _NODES:
                nodes[row[1].strip()] = row[0].strip()
            elif any(cell.strip() for cell in row) and row[0].strip() != _TITLE:
                types = ", ".join((*_VESSELS, *_NODES))
                raise InputError(f"{path}, line {line}: a row of type '{row[0].strip()[:40]}'; known are {types}")
    if not cells:
        raise InputError(f"{path}: has no vessel (a row of type {' or '.join(_VESSELS)})")
    first, last, length = np.array([[number_in(path, line, row_cells[title]) for title in _SIZES]
                                    for line, row_cells in zip(lines, cells, strict=True)]).T * _CM  # fmt: skip
    joined = numbered([(row_cells["start_node"], row_cells["end_node"]) for row_cells in cells])
    _check_ends(path, cells, nodes)
    network = Network(
        tuple(row_cells["ID"] for row_cells in cells), None, length, 0.25 * (first + last),
        lambda row: f"{path}, line {lines[row]}", nodes=joined, taper=taper_of(0.5 * first, 0.5 * last, length),
    )  # fmt: skip
    other_types = ", ".join(sorted(set(nodes.values())))
    unused = [
        title for title in titles if title not in (*_COLUMNS, *_WORDS) and any(row_cells[title] for row_cells in cells)
    ]
    looks += [UNUSED(what=f"columns {', '.join(unused)}")] if unused else []
    return network, [
        *looks,
        LEFT_OUT(what=f"rows of the types {other_types}, walls and beds" if other_types else "walls and beds"),
    ]


def _check_ends(path: Path, cells: list[dict[str, str]], nodes: dict[str, str]) -> None:
    """Refuse vessels that end elsewhere than in the beds that the rows of nodes name, if they name any."""
    beds = {name for name, kind in nodes.items() if kind == "perif"}
    ends = {row["end_node"] for row in cells} - {row["start_node"] for row in cells}
    if beds and (wrong := sorted(beds ^ ends)):
        fault = "is a bed in which no vessel ends" if wrong[0] in beds else "has no vessel or bed behind it"
        raise InputError(f"{path}: node '{wrong[0]}' {fault}; a row of the table is missing or damaged")


NETWORKS.register(NetworkFormat("first blood", "FirstBlood table of edges", (), is_edges, read_edges))
