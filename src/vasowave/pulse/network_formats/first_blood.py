"""FirstBlood's table of edges between nodes, SI units in its header."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

from vasowave.base.errors import InputError
from vasowave.base.io.columns import NO_END, Columns
from vasowave.base.io.textfile import read_lines
from vasowave.pulse.network.remarks import LEFT_OUT
from vasowave.pulse.network_formats import NETWORKS, table_format

_VESSELS = ("vis", "vis_f")
_NODES = ("heart", "node", "perif")
_TITLE = "type"  # the nodes have a header of their own
_COLUMNS = {
    "ID": "name", "start_node": "from", "end_node": "to", "start_diameter[SI]": "diameter start",
    "end_diameter[SI]": "diameter end", "length[SI]": "length",
}  # fmt: skip
_WORDS = (_TITLE, "name", "division_points")  # of a table of edges, that no network needs


def is_edges(path: Path, start: bytes) -> bool:
    """Return whether a file is such a table, by its header."""
    head = start.split(b"\n", 1)[0]
    return all(title.encode() in head for title in (_TITLE, *_COLUMNS))


def edge_columns(path: Path) -> Columns:
    """Return the rows of vessels as a table; beds, the heart and what nodes leak are left out.

    The rows of nodes tell whether a vessel is missing: those of type perif, and no others, have no vessel behind them.
    """
    titles: list[str] = []
    lines, cells, nodes, cut = list[int](), list[list[str]](), dict[str, str](), False
    for block in read_lines(path):
        cut = block.cut
        for line, written in enumerate(csv.reader(block.texts), block.first):
            row = [cell.strip() for cell in written]
            if not titles:
                titles = row
                if missing := [title for title in _COLUMNS if title not in titles]:
                    raise InputError(f"{path}, line {line}: no column '{missing[0]}'; the columns of a table of edges "
                                     f"are {_TITLE}, {', '.join(_COLUMNS)}")  # fmt: skip
            elif row and row[0] in _VESSELS:
                if len(row) < len(titles):
                    raise InputError(f"{path}, line {line}: {len(row)} cells for {len(titles)} columns")
                cells.append(row)
                lines.append(line)
            elif len(row) > 1 and row[0] in _NODES:
                nodes[row[1]] = row[0]
            elif any(row) and row[0] != _TITLE:
                types = ", ".join((*_VESSELS, *_NODES))
                raise InputError(f"{path}, line {line}: a row of type '{row[0][:40]}'; known are {types}")
    if not cells:
        raise InputError(f"{path}: has no vessel (a row of type {' or '.join(_VESSELS)})")
    used = [i for i, title in enumerate(titles) if title not in _WORDS and any(row[i] for row in cells)]
    names = tuple(_COLUMNS.get(titles[i], titles[i]) for i in used)
    _check_ends(path, [(row[titles.index("start_node")], row[titles.index("end_node")]) for row in cells], nodes)
    sized = tuple("m" if titles[i] in _COLUMNS and "[SI]" in titles[i] else "" for i in used)
    content = tuple(tuple(row[i] for i in used) for row in cells)
    return Columns(str(path), names, sized, content, tuple(lines), (NO_END(),) if cut else (), names)


def _check_ends(path: Path, edges: Sequence[tuple[str, str]], nodes: Mapping[str, str]) -> None:
    """Refuse vessels that end elsewhere than in the beds that the rows of nodes name, if they name any."""
    beds = {name for name, kind in nodes.items() if kind == "perif"}
    ends = {end for _, end in edges} - {start for start, _ in edges}
    if beds and (wrong := sorted(beds ^ ends)):
        fault = "is a bed in which no vessel ends" if wrong[0] in beds else "has no vessel or bed behind it"
        raise InputError(f"{path}: node '{wrong[0]}' {fault}; a row of the table is missing or damaged")


NETWORKS.register(
    table_format("first blood", "FirstBlood table of edges", (), is_edges, edge_columns,
                 (LEFT_OUT(what="rows of nodes, walls and beds"),)))  # fmt: skip
