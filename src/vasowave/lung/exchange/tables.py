"""Tables of a network: ours, one row a vessel and one a point; and the two of the paper."""

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from vasowave.base.io.files import write_file
from vasowave.lung.measure.measurement import Measurement
from vasowave.lung.tree import Tree
from vasowave.lung.witness.doubts import Doubt
from vasowave.pulse.network.network import Network
from vasowave.pulse.network.vessel_table import counted, measured_columns

_SIZES = ("length", "radius", "radius_inscribed", "radius_densitometric")


def write_network_table(measured: Measurement, path: str | Path, doubts: Sequence[Doubt] = ()) -> None:
    """Write one row a vessel: sizes, both radii, spread, taper, whether reliable, doubts; `read_network` reads it."""
    network = measured.network
    doubted = {name: sorted({doubt.about for doubt in doubts if name in doubt.vessels}) for name in network.name}
    names = [network.name[p] if p >= 0 else "" for p in network.parent]
    columns = (network.length, network.radius, measured.inscribed, measured.densitometric)
    pressure_column = {"pressure [mmHg]": repr(network.pressure)} if network.pressure else {}
    errors, counts = measured_columns(network), counted(network)
    heads = [*(f"{head} [cm]" for head in _SIZES), *errors, *pressure_column, *counts]
    rows = []
    for row, name in enumerate(network.name):
        cells = [repr(float(column[row])) if np.isfinite(column[row]) else "" for column in columns]
        cells += [column[row] for column in errors.values()]
        reliable = "yes" if measured.reliable[row] else "no"
        cells += [*pressure_column.values(), *counts.values(), reliable, "; ".join(doubted[name])]
        rows.append([name, names[row], *cells])
    _write(path, ["name", "parent", *heads, "radius_reliable", "doubts"], rows)


def write_points(tree: Tree, names: tuple[str, ...], path: str | Path) -> None:
    """Write the points of every axis with their inscribed radii: vessel, x, y, z, radius in cm."""
    rows = [
        [name, *(f"{value:.10g}" for value in (x, y, z, r))]
        for name, line in zip(names, tree.lines, strict=True)
        for (z, y, x), r in zip(line.points, line.radius, strict=True)
    ]
    _write(path, ["vessel", "x [cm]", "y [cm]", "z [cm]", "radius [cm]"], rows)


def write_author_tables(network: Network, connectivity: str | Path, dimensions: str | Path) -> None:
    """Write the two tables of the paper: vessel and its daughters; vessel, r0 and L in cm (Table 1).

    Vessels carry their names; vessels without daughters are not in the first table.
    """
    width = max(2, *(len(rows) for rows in network.daughters))
    heads = ["left", "right", *(f"daughter{k}" for k in range(3, width + 1))]
    joined = [
        [name, *(network.name[row] for row in rows), *[""] * (width - len(rows))]
        for name, rows in zip(network.name, network.daughters, strict=True)
        if rows
    ]
    _write(connectivity, ["vessel", *heads], joined)
    sizes = zip(network.name, map(repr, network.radius.tolist()), map(repr, network.length.tolist()), strict=True)
    _write(dimensions, ["vessel", "r0 [cm]", "L [cm]"], sizes)


def _write(path: str | Path, heads: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    text = io.StringIO()
    csv.writer(text).writerows([heads, *rows])
    write_file(Path(path), text.getvalue())
