"""Centerlines of other programs: VMTK and Slicer (.vtp, .vtk, .dat, .csv) and SWC in; .vtp and tables out."""

import csv
from pathlib import Path
from typing import Literal

import numpy as np

from vasowave.columns import read_columns
from vasowave.errors import InputError
from vasowave.imaging.extraction import RELIABLE, Extraction
from vasowave.imaging.merging import merged
from vasowave.imaging.polydata import PolyLines, read_polydata, write_vtp
from vasowave.imaging.tree import Tree, cut_at_junctions, free_length, network_of
from vasowave.network import Network

RADIUS_NAMES = ("MaximumInscribedSphereRadius", "Radius")
"""The radius array as VMTK's command line and as Slicer call it."""

_LEAST = 1e-6
"""Radius, cm, that is written where an axis ends at the surface; readers refuse 0."""

_ALIASES = {
    "points:0": "x", "points:1": "y", "points:2": "z", "points_0": "x", "points_1": "y", "points_2": "z",
    "maximuminscribedsphereradius": "radius", "r": "radius",
}  # fmt: skip


def read_centerlines(
    path: str | Path, unit: float, cut: Literal["tube", "identical"] = "tube", collapse: float = 0.0
) -> Tree:
    """Return the tree of vessels in a file of centerlines; `network_of` makes it a network.

    Parameters
    ----------
    path : path
        .vtp or .vtk (VMTK, Slicer: one line from the root to each terminal), .dat or .csv (the same points as a flat
        table x, y, z, radius), or .swc.
    unit : float
        Unit of length of the file, cm: 0.1 for mm, 1e-4 for µm, the voxel size for voxels. Not used for table
        columns whose header names a unit.
    cut : "tube" or "identical"
        Where lines part, see `merged`; "identical" is the authors' rule.
    collapse : float
        Inner vessels shorter than this many radii + the point distance become one junction (extraction uses 0.6).

    Raises
    ------
    InputError
        Unreadable file, no radius array, a radius that is not positive, lines without a common root.

    Warns
    -----
    VasowaveWarning
        Loops, which are opened.
    """
    path = Path(path)
    if not (np.isfinite(unit) and unit > 0):
        raise InputError(f"unit {unit} cm: give the file's unit of length as a positive number of cm (mm: 0.1)")
    if path.suffix.lower() == ".swc":
        points, above = _swc(path, unit)
    else:
        lines = _lines_of_polydata(path, unit) if path.suffix.lower() in (".vtp", ".vtk") else _flat(path, unit)
        for line in lines:
            _require_radii(path, line)
        points, above = merged(lines, cut)
    try:
        return cut_at_junctions(points, above, collapse)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def as_extraction(tree: Tree) -> Extraction:
    """Return imported centerlines as an `Extraction`: inscribed radii alone, their spread unknown."""
    network = network_of(tree)
    unknown = np.full(len(network), np.nan)
    reliable = free_length(tree) >= RELIABLE * network.radius
    return Extraction(network, tree, network.radius, unknown, unknown, reliable, 1.0)


def _require_radii(path: Path, line: np.ndarray) -> None:
    if not (np.isfinite(line).all() and (line[:, 3] > 0).all()):
        raise InputError(f"{path}: a point whose position or radius is not finite or not positive; repair the line")


def _lines_of_polydata(path: Path, unit: float) -> list[np.ndarray]:
    data = read_polydata(path)
    name = next((name for name in RADIUS_NAMES if name in data.fields), None)
    if name is None:
        there = ", ".join(sorted(data.fields)) or "none"
        raise InputError(f"{path}: no array {' or '.join(RADIUS_NAMES)} at the points; there are: {there}")
    table = unit * np.column_stack([data.points[:, ::-1], data.fields[name]])
    return [table[line] for line in data.lines]


def _flat(path: Path, unit: float) -> list[np.ndarray]:
    """Return the lines of a flat table, which has lost them: a jump longer than both radii starts a new line."""
    table = read_columns(path, _ALIASES)
    found = []
    for axis in ("z", "y", "x", "radius"):
        column = table.require(axis)
        given = bool(table.units and table.units[column])
        found.append(table.numbers(column, "length", "cm") * (1.0 if given else unit))
    points = np.column_stack(found)
    jumps = np.linalg.norm(np.diff(points[:, :3], axis=0), axis=1)
    lines = np.split(points, 1 + np.flatnonzero(jumps > points[1:, 3] + points[:-1, 3]))
    return [line for line in lines if len(line) > 1]


def _swc(path: Path, unit: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points and the next point toward the root from SWC: number, type, x, y, z, radius, parent."""
    table = read_columns(path)
    cells = table.cells if not table.names else None
    if cells is None or len(cells[0]) != 7:
        raise InputError(f"{path}: an SWC file has seven columns of numbers: number, type, x, y, z, radius, parent")
    values = np.array(cells, dtype=float)
    points = unit * values[:, [4, 3, 2, 5]]
    _require_radii(path, points)
    row = {int(number): index for index, number in enumerate(values[:, 0])}
    if len(row) < len(values):
        raise InputError(f"{path}: a point number is used twice")
    above = np.full(len(values), -1)
    for index, parent in enumerate(values[:, 6].astype(int)):
        if parent >= 0:
            if parent not in row:
                raise InputError(f"{path}, line {table.lines[index]}: parent {parent} is not in the file")
            above[index] = row[parent]
    depth = above.copy()
    for _ in range(len(above).bit_length() + 1):  # pointer doubling: after log2(n) rounds everyone is at a root
        depth = np.where(depth >= 0, depth[depth], -1)
    if (depth >= 0).any():
        raise InputError(f"{path}: the parents of line {table.lines[int(np.argmax(depth >= 0))]} form a cycle")
    return points, above


def write_centerlines(tree: Tree, path: str | Path, unit: float = 1.0) -> None:
    """Write `tree` as .vtp as VMTK does: one line from the root to each terminal, x, y, z in `unit` (cm).

    `read_centerlines(path, unit, cut="identical")` reads the same vessels back. Slicer and ITK-SNAP expect mm: 0.1.
    """
    numbers: list[np.ndarray] = []
    points: list[np.ndarray] = []
    count = 0
    for line, parent in zip(tree.lines, tree.parent, strict=True):
        new = line if parent < 0 else line[1:]
        own = count + np.arange(len(new))
        numbers.append(own if parent < 0 else np.append(numbers[parent][-1], own))
        points.append(new)
        count += len(new)
    lines = []
    for terminal in sorted(set(range(len(tree.lines))) - set(tree.parent.tolist())):
        way, row = [numbers[terminal]], int(tree.parent[terminal])
        while row >= 0:
            way.append(numbers[row][:-1])
            row = int(tree.parent[row])
        lines.append(np.concatenate(way[::-1]))
    table = np.concatenate(points) / unit
    radius = np.maximum(table[:, 3], _LEAST / unit)
    write_vtp(PolyLines(table[:, 2::-1], tuple(lines), {RADIUS_NAMES[0]: radius}), path)


def write_swc(tree: Tree, path: str | Path) -> None:
    """Write `tree` as SWC in µm, x, y, z: `read_centerlines(path, unit=1e-4)` reads the same vessels back."""
    last: list[int] = []
    count = 0
    with Path(path).open("w", encoding="utf-8") as file:
        file.write("# number type x y z radius parent, micrometers\n")
        for line, parent in zip(tree.lines, tree.parent, strict=True):
            above = -1 if parent < 0 else last[parent]
            for z, y, x, r in 1e4 * (line if parent < 0 else line[1:]):
                count += 1
                file.write(f"{count} 0 {x:.9g} {y:.9g} {z:.9g} {max(r, 1e4 * _LEAST):.9g} {above}\n")
                above = count
            last.append(count)


def write_author_tables(network: Network, connectivity: str | Path, dimensions: str | Path) -> None:
    """Write the two tables of the paper: vessel and its daughters; vessel, r0 and L in cm (Table 1).

    Vessels carry their names; vessels without daughters are not in the first table.
    """
    width = max(2, *(len(rows) for rows in network.daughters))
    heads = ["left", "right", *(f"daughter{k}" for k in range(3, width + 1))]
    with Path(connectivity).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["vessel", *heads])
        for name, rows in zip(network.name, network.daughters, strict=True):
            if rows:
                writer.writerow([name, *(network.name[row] for row in rows), *[""] * (width - len(rows))])
    with Path(dimensions).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["vessel", "r0 [cm]", "L [cm]"])
        for row, name in enumerate(network.name):
            writer.writerow([name, repr(float(network.radius[row])), repr(float(network.length[row]))])
