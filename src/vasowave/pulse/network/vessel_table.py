"""The table of vessels: a network as CSV, one row a vessel, units in the header."""

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import Finding, look_kind
from vasowave.base.io.columns import Columns, read_columns, read_titles
from vasowave.base.io.files import write_file
from vasowave.base.units import CANONICAL
from vasowave.pulse.network.graph import numbered
from vasowave.pulse.network.network import Network, image_pressure
from vasowave.pulse.network.remarks import UNUSED

_ALIASES = {
    "radius_end": "radius end",
    "vessel": "name",
    "id": "name",
    "l": "length",
    "r0": "radius",
    "r": "radius",
    "d": "diameter",
}
_NO_PARENT = ("0", "-1", "nan", "none", "na", "n/a", "-", "root")  # how other programs write that there is no parent

_END = "radius end"
_TITLES = "name, parent, length [cm], radius [cm] or diameter [cm]"
_QUANTITIES = {"radius_sd": "length", "taper": "slope", "taper_sd": "slope"}

_OURS = ("radius_inscribed", "radius_densitometric", "radius_reliable", "doubts")
"""Columns of an extraction that say where its radii come from."""

COUNTED = ("vessels", "outlets", "inlets")
"""Columns that say in every row how many there are, so that lost rows and changed ends are noticed."""

OTHER_COUNT = look_kind(
    "network.other-count",
    "{found} {column} where the column '{column}' says {count}; was the file cut off, or a cell changed? {remedy}",
    "If rows were added, taken out or joined otherwise on purpose, remove that column",
)
SINGLE_DAUGHTERS = look_kind(
    "network.single-daughters",
    "{count} vessel(s) with one daughter, where nothing divides ({some}); was a row lost?",
    "Put the row back, or join the two vessels with `vasowave tidy`.",
)


def is_vessel_table(path: Path, start: bytes) -> bool:
    """Return whether a file is a table with a column `parent`, or with `from` and `to`."""
    titles = read_titles(path, start)
    return "parent" in titles or {"from", "to"} <= set(titles)


def read_vessel_table(path: str | Path) -> tuple[Network, list[Finding]]:
    """Read a network from CSV, TSV or Excel, and why it may not be whole.

    Columns: ``name, parent, length [cm], radius [cm], radius_sd [cm], taper [cm/cm], taper_sd [cm/cm], pressure [mmHg],
    vessels, outlets``; where vessels form loops or have several inlets, ``from, to`` in place of ``parent``, and
    ``inlets`` beside ``outlets``.

    The root's parent is empty. ``from`` and ``to`` name the nodes in which a vessel begins and ends, in any words;
    vessels with a node in common meet there. Sizes and pressure may be in any unit that the header names. The pressure
    is that of the image, the same in every row; without the column it is not known. ``radius_sd``, ``taper`` and
    ``taper_sd`` are those of `Network`; their columns may be left out, and their cells be empty. In place of a taper,
    ``radius end`` may hold the radius at the outlet: ``radius`` is then that at the inlet. ``diameter`` may stand in
    place of ``radius``. Other columns are not used, and named.

    Raises
    ------
    InputError
        As `Network`, with the line of the file; also for a missing column, a missing unit, one of another quantity,
        pressures that differ, tapers or topology that are given twice.

    Returns
    -------
    network : Network
    found : list of Finding
        What looks like lost rows: other numbers than the columns ``vessels``, ``outlets`` and ``inlets`` say, a vessel
        with one daughter, a last line without an end. Columns that are not used.
    """
    table = read_columns(path, _ALIASES)
    if not table.names:
        raise InputError(f"{path}: no header; the first line must read: {_TITLES}")
    names = [row[table.require("name", titles=_TITLES)] for row in table.cells]
    length = table.numbers(table.require("length", titles=_TITLES), "length")
    radius = _radius(table)

    def where(row: int) -> str:
        return f"{path}, line {table.lines[row]}"

    parent, nodes = _topology(table, names, where)
    quantities = {field: _known_in(table, field, quantity) for field, quantity in _QUANTITIES.items()}
    end = _known_in(table, _END, "length")
    if end is not None:
        if quantities["taper"] is not None:
            raise InputError(f"{path}: both '{_END}' and 'taper' say how vessels narrow; keep one of the two columns")
        with np.errstate(divide="ignore"):  # a length of zero is refused by its line
            quantities["taper"] = (radius - end) / length
        radius = np.where(np.isnan(end), radius, 0.5 * (radius + end))
    network = Network(
        tuple(names), parent, length, radius, where, _pressure_in(table, where), nodes=nodes, **quantities
    )
    topology = ("parent",) if nodes is None else ("from", "to")
    taken = {"name", *topology, "length", "radius", "diameter", "pressure", _END, *_QUANTITIES, *COUNTED, *_OURS}
    return network, [*table.suspicions, *_lost(table, network), *_unused(table, taken)]


def write_network(network: Network, path: str | Path) -> None:
    """Write `network` as CSV with units in the header; `read_vessel_table` reads it back to the last bit.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.write_network(vw.control_network(), "control.csv")
    >>> len(vw.read_network("control.csv"))
    21
    """
    pressure = {"pressure [mmHg]": repr(network.pressure)} if network.pressure else {}
    measured = measured_columns(network)
    text = io.StringIO()
    writer = csv.writer(text)
    topology, counts = network.topology(), counted(network)
    writer.writerow(["name", *topology, "length [cm]", "radius [cm]", *measured, *pressure, *counts])
    for row, name in enumerate(network.name):
        joined = (column[row] for column in topology.values())
        sizes = [repr(float(size)) for size in (network.length[row], network.radius[row])]
        cells = (column[row] for column in measured.values())
        writer.writerow([name, *joined, *sizes, *cells, *pressure.values(), *counts.values()])
    write_file(Path(path), text.getvalue())


def counted(network: Network) -> dict[str, str]:
    """Return what the columns `COUNTED` hold in every row of a network's table; a tree has one inlet by its parents."""
    counts = zip(COUNTED, (len(network), len(network.terminals), len(network.inlets)), strict=True)
    return {title: str(count) for title, count in counts if title != "inlets" or network.nodes is not None}


def measured_columns(network: Network) -> dict[str, list[str]]:
    """Return the cells of what is known of the vessels beside their sizes, by title; empty where it is not known."""
    columns = {}
    for field, quantity in _QUANTITIES.items():
        values = getattr(network, field)
        if values is not None:
            cells = ["" if np.isnan(value) else repr(float(value)) for value in values]
            columns[f"{field} [{CANONICAL[quantity]}]"] = cells
    return columns


def _radius(table: Columns) -> np.ndarray:
    diameter = table.find("diameter")
    if diameter is None:
        return table.numbers(table.require("radius", titles=_TITLES), "length")
    if table.find("radius") is not None:
        raise InputError(f"{table.source}: both 'radius' and 'diameter' say how wide vessels are; keep one of them")
    return 0.5 * table.numbers(diameter, "length")


def _known_in(table: Columns, field: str, quantity: str) -> np.ndarray | None:
    """Return a column whose cells may be empty, NaN where they are; None without the column, or with nothing in it."""
    column = table.find(field)
    filled = [] if column is None else [i for i, row in enumerate(table.cells) if row[column].strip()]
    if column is None or not filled:
        return None
    filled_rows = replace(
        table, cells=tuple(table.cells[i] for i in filled), lines=tuple(table.lines[i] for i in filled)
    )
    values = np.full(len(table.cells), np.nan)
    values[filled] = filled_rows.numbers(column, quantity)
    return values


def _lost(table: Columns, network: Network) -> list[Finding]:
    """Return every sign that rows are missing."""
    counts = counted(network)
    columns = {title: column for title in counts if (column := table.find(title)) is not None}
    if columns:
        return [OTHER_COUNT(found=counts[title], column=title, count=count) for title, column in columns.items()
                for count in sorted({row[column] for row in table.cells} - {counts[title], ""})]  # fmt: skip
    alone = [
        network.name[meeting.ending[0]]
        for meeting in network.junctions
        if len(meeting.ending) == len(meeting.beginning) == 1
    ]
    names = ", ".join(f"'{name}'" for name in alone[:5]) + (", …" if len(alone) > 5 else "")
    return [SINGLE_DAUGHTERS(count=len(alone), some=names)] if alone else []


def _unused(table: Columns, taken: set[str]) -> list[Finding]:
    """Return which columns hold values that nothing takes; what may have been meant stands with them."""
    unused = [name for column, name in enumerate(table.names)
            if name and name not in taken and any(row[column].strip() for row in table.cells)]  # fmt: skip
    words = [f"'{name}'{did_you_mean(name, sorted(taken))}" for name in unused]
    return [UNUSED(what=f"column {', '.join(words)}")] if unused else []


def _pressure_in(table: Columns, where: Callable[[int], str]) -> float:
    column = table.find("pressure")
    if column is None:
        return 0.0
    values = table.numbers(column, "pressure")
    rows = np.flatnonzero(values != values[0])
    if len(rows):
        raise InputError(
            f"{where(int(rows[0]))}: pressure {values[rows[0]]:g} mmHg, but {values[0]:g} mmHg in the first row; all "
            "radii of a network were measured at one pressure"
        )
    try:
        return image_pressure(float(values[0]))
    except InputError as error:
        raise InputError(f"{where(0)}: {error}") from None


def _topology(
    table: Columns, names: Sequence[str], where: Callable[[int], str]
) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Return rows of the parents, or numbers of the nodes in the order in which they are first named."""
    if table.find("from") is None or table.find("to") is None:
        parents = [row[table.require("parent")] for row in table.cells]
        return np.array(_parent_rows(names, parents, where)), None
    if table.find("parent") is not None:
        raise InputError(f"{table.source}: both 'parent' and 'from', 'to' say what joins the vessels; keep one of them")
    ends = [table.require("from"), table.require("to")]
    nodes = [[row[column].strip() for column in ends] for row in table.cells]
    empty = next((row for row, pair in enumerate(nodes) if not all(pair)), None)
    if empty is not None:
        raise InputError(f"{where(empty)} (vessel '{names[empty]}'): no node in 'from' or 'to'; every vessel has two")
    return None, numbered(nodes)


def _parent_rows(names: Sequence[str], parents: Sequence[str], where: Callable[[int], str]) -> list[int]:
    rows = {name: row for row, name in enumerate(names)}
    numbers = []
    for row, parent in enumerate(parents):
        if parent and parent not in rows:
            twice = next((name for name in names if names.count(name) > 1), None)
            hint = f"; '{twice}' stands there twice, is one of them it?" if twice else did_you_mean(parent, rows)
            hint = "; leave the root's parent empty" if parent.lower() in _NO_PARENT else hint
            raise InputError(f"{where(row)} (vessel '{names[row]}'): parent '{parent}' is not in the table{hint}")
        numbers.append(rows[parent] if parent else -1)
    return numbers
