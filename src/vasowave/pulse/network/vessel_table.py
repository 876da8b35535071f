"""The table of vessels: a network as CSV, one row a vessel, units in the header."""

import csv
import io
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from vasowave.base.cures import Tidy
from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import Finding, look_kind
from vasowave.base.io.cells import is_row, separator_of, split_cells
from vasowave.base.io.columns import Columns, read_columns, read_headings, read_titles
from vasowave.base.io.files import write_file
from vasowave.base.io.headings import split_title
from vasowave.base.io.layout import head_of
from vasowave.base.io.spreadsheet import is_workbook, read_sheets
from vasowave.base.io.textfile import look, read_lines
from vasowave.base.units import CANONICAL, is_of
from vasowave.pulse.network.network import Network, image_pressure
from vasowave.pulse.network.remarks import UNUSED
from vasowave.pulse.network.titles import canonical_title, ends_by_places, require_width, topology_of, understood
from vasowave.pulse.network.topology import joined_vessels

_END = "radius end"
_WIDTHS = ("area", "radius start", _END, "diameter start", "diameter end")
_TITLES = "name, parent, length [cm], radius [cm] or diameter [cm]"
_ORDER = re.compile(r"\border\b|strahler|horsfield|generation", re.IGNORECASE)
_QUANTITIES = {"radius_sd": "length", "taper": "slope", "taper_sd": "slope", "radius_scale_sd": "slope"}

_MAX_TITLES = 256  # of a table of vessels; a row a signal has more
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
    "Put the row back, or let the two vessels be joined in a new file.",
    Tidy(),
)


def is_vessel_table(path: Path, start: bytes) -> bool:
    """Return whether a file is a table with a column `parent`, or lengths and others that say what joins vessels."""
    if len(re.findall(rb"[,;\t]", start.partition(b"\n")[0])) > _MAX_TITLES:
        return False
    if is_workbook(start):
        return bool(_vessel_sheet(path))
    return _are_of_vessels(
        read_titles(path, start) or _commented_titles(path, start.decode("utf-8", errors="replace").split("\n"))
    )


def _vessel_sheet(path: Path) -> str:
    """Return the name of the first sheet with a table of vessels: that of nodes may stand before it, and no recording.

    Empty if there is none.
    """
    for sheet in read_sheets(path):
        titles = read_titles(path, look(path).start, sheet.name)
        if _are_of_vessels(titles):
            return sheet.name
        unit_names = [(split_title(title) or ("", ""))[1] or "" for title in titles]
        if sum(any(is_of(unit, kind) for unit in unit_names) for kind in ("pressure", "flow", "time")) > 1:
            return ""
    return ""


def _are_of_vessels(titles: Sequence[str]) -> bool:
    names = {canonical_title(title)[0] for title in titles}
    topology = topology_of(list(names)) or tuple(map(str, ends_by_places(titles)))
    return bool(topology) and ("length" in names or topology in (("parent",), ("from", "to")))


def vessel_columns(path: str | Path) -> Columns:
    """Read a table of vessels as it is; a comment above its first row may hold its titles."""
    path = Path(path)
    table = read_columns(path, sheet=_vessel_sheet(path) if is_workbook(look(path).start) else "")
    if not table.names and (titles := _commented_titles(path, next(iter(read_lines(path))).texts)):
        names, column_units = read_headings(path, titles, {})
        table = replace(table, names=names, units=column_units, titles=titles)
    if not table.names:
        raise InputError(f"{path}: no header; the first line must read: {_TITLES}")
    return table


def _commented_titles(path: Path, texts: Sequence[str]) -> tuple[str, ...]:
    """Return the words of the comment above the first row of a table, if they are as many as its cells."""
    first = next((line for line, text in enumerate(texts) if is_row(text)), 0)
    comment = texts[first - 1].strip() if first else ""
    if not comment.startswith("#"):
        return ()
    try:
        titles = head_of(path, [(first, comment.lstrip("#"))]).titles
        width = len(split_cells(path, first + 1, texts[first], separator_of(texts[first])))
    except InputError:
        return ()
    return titles if len(titles) == width else ()


def recognized(table: Columns) -> tuple[Columns, list[Finding]]:
    """Return a table with our titles and how its own were read; `InputError` unless it has what a network needs."""
    table, findings = understood(table)
    topology = topology_of(table.names)
    if not topology and (orders := [name for name in table.names if _ORDER.search(name)]):
        raise InputError(
            f"{table.source}: '{orders[0]}' does not say what joins vessels; a network has a row a vessel: {_TITLES}"
        )
    if topology in ((), ("parent",), ("daughters",)):  # edges may go without a name
        table.require("name", titles=_TITLES)
    table.require("length", titles=_TITLES)
    require_width(table, _TITLES)
    if not topology:
        table.require("parent", titles=_TITLES)
    return table, findings


def network_of(table: Columns, scale: float | None = None) -> tuple[Network, list[Finding]]:
    """Return the network of a table, with titles as in `SYNONYMS`, and why it may not be whole.

    `scale` turns lengths without a unit into cm; without it, every column of sizes must have one.

    Columns: ``name, parent, length [cm], radius [cm], radius_sd [cm], taper [cm/cm], taper_sd [cm/cm], pressure [mmHg],
    vessels, outlets``; where vessels form loops or have several inlets, ``from, to`` in place of ``parent``, and
    ``inlets`` beside ``outlets``.

    The root's parent is empty. ``from`` and ``to`` name the nodes in which a vessel begins and ends, in any words;
    vessels with a node in common meet there. Sizes and pressure may be in any unit that the header names. The pressure
    is that of the image, the same in every row; without the column it is not known. ``radius_sd``, ``taper``,
    ``taper_sd`` and ``radius_scale_sd`` are those of `Network`; their columns may be left out, and their cells be
    empty. In place of a taper, ``radius end`` may hold the radius at the outlet: ``radius`` is then that at the inlet.
    ``diameter`` may stand in place of ``radius``, as may ``area``. Other columns are not used, and named.

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
    table, findings = recognized(table)

    def where(row: int) -> str:
        return f"{table.source}, {table.row_word} {table.lines[row]}"

    name, topology = table.find("name"), topology_of(table.names)
    names = [str(row + 1) if name is None else cells[name] for row, cells in enumerate(table.cells)]
    length = _size(table, "length", scale)
    radius, end = _radii(table, scale)
    spread, taper, taper_sd, common = (
        _known_in(table, field, quantity, scale) for field, quantity in _QUANTITIES.items()
    )
    if end is not None:
        if taper is not None:
            raise InputError(
                f"{table.source}: both '{_END}' and 'taper' say how vessels narrow; keep one of the two columns"
            )
        with np.errstate(divide="ignore"):  # a length of zero is refused by its line
            taper = (radius - end) / length
        radius = np.where(np.isnan(end), radius, 0.5 * (radius + end))
    parent, nodes, rooting = joined_vessels(table, names, radius, where)
    network = Network(
        tuple(names), parent, length, radius, where, _pressure_in(table, where), spread, taper, taper_sd, nodes, common
    )
    used = {"name", *topology, "length", "radius", "diameter", "pressure", *_WIDTHS, *_QUANTITIES, *COUNTED, *_OURS}
    return network, [*table.suspicions, *findings, *rooting, *_lost(table, network), *_unused(table, used)]


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


def _size(table: Columns, name: str, scale: float | None, quantity: str = "length") -> np.ndarray:
    """Return a column in cm or cm²; `scale` turns lengths without a unit into cm."""
    column = table.require(name, titles=_TITLES)
    if scale is None or table.units[column]:
        return table.numbers(column, quantity)
    return table.numbers(column, quantity, CANONICAL[quantity]) * (scale**2 if quantity == "area" else scale)


def _radii(table: Columns, scale: float | None) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the radius of every vessel, and that at its end where it is known; the first is then that at its inlet."""
    for width, share in (("radius", 1.0), ("diameter", 0.5)):
        if f"{width} start" in table.names:
            return share * _size(table, f"{width} start", scale), share * _size(table, f"{width} end", scale)
    end = _known_in(table, _END, "length", scale)
    if table.find("diameter") is not None:
        if table.find("radius") is not None:
            raise InputError(f"{table.source}: both 'radius' and 'diameter' say how wide vessels are; keep one of them")
        return 0.5 * _size(table, "diameter", scale), end
    if table.find("radius") is None:
        with np.errstate(invalid="ignore"):  # a negative area has no radius, which its line is refused for
            return np.sqrt(_size(table, "area", scale, "area") / np.pi), end
    return _size(table, "radius", scale), end


def _known_in(table: Columns, field: str, quantity: str, scale: float | None) -> np.ndarray | None:
    """Return a column whose cells may be empty, NaN where they are; None without the column, or with nothing in it."""
    column = table.find(field)
    filled = [] if column is None else [i for i, row in enumerate(table.cells) if row[column].strip()]
    if column is None or not filled:
        return None
    filled_rows = replace(
        table, cells=tuple(table.cells[i] for i in filled), lines=tuple(table.lines[i] for i in filled)
    )
    values = np.full(len(table.cells), np.nan)
    values[filled] = _size(filled_rows, field, scale if quantity == "length" else None, quantity)
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
    places = {column for end in ends_by_places(table.names) for column in end}
    unused = [name for column, name in enumerate(table.names)
              if name and name not in taken and column not in places
              and any(row[column].strip() for row in table.cells)]  # fmt: skip
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
