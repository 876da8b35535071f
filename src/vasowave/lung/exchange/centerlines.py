"""Centerlines of other programs: VMTK and Slicer (.vtp, .vtk, .dat, .csv), SWC and TubeTK in; .vtp out."""

from pathlib import Path
from typing import Literal

import numpy as np
from scipy.spatial import cKDTree

from vasowave.base.errors import InputError, of_file
from vasowave.base.findings import look_kind, note_kind, warn
from vasowave.base.io.columns import read_columns
from vasowave.base.io.spreadsheet import WORKBOOKS
from vasowave.lung.axes.skeleton import Skeleton, cut_at_junctions
from vasowave.lung.exchange.convention import Ends, as_extracted
from vasowave.lung.exchange.formats import LINES, LinesFormat
from vasowave.lung.exchange.legacy_vtk import PolyLines
from vasowave.lung.exchange.merging import merged, rooted
from vasowave.lung.exchange.polydata import read_polydata, write_vtp
from vasowave.lung.exchange.section_areas import (
    AREA,
    AREAS_ALONE,
    BRANCHING,
    CLOSED,
    Sections,
    area_radii,
    sections_of,
    with_section_radii,
)
from vasowave.lung.exchange.swc import LEAST, require_radii
from vasowave.lung.exchange.triangles import read_surface_points
from vasowave.lung.measure.measurement import Measurement, measured_alone
from vasowave.lung.places import written
from vasowave.lung.tree import Line, Tree

RADIUS_NAMES = ("MaximumInscribedSphereRadius", "Radius")
"""The radius array as VMTK's command line and as Slicer call it."""

LEAP = 4.0
"""A step of so many usual ones, and longer than both radii, is none between neighbors."""

_ALIASES = {
    "points:0": "x", "points:1": "y", "points:2": "z", "points_0": "x", "points_1": "y", "points_2": "z",
    "maximuminscribedsphereradius": "radius", "r": "radius",
}  # fmt: skip

_BOOKKEEPING = (AREA, CLOSED, BRANCHING, *RADIUS_NAMES, "CenterlineId", "GlobalNodeId", "BranchId", "BranchIdTmp",
                "BifurcationId", "BifurcationIdTmp", "Path", "EdgeArray", "EdgePCoordArray", "Abscissas",
                "ParallelTransportNormals", "CostFunctionValue")  # fmt: skip

UNUSED = note_kind("lines.unused", "{what}: given and not used; a tree needs places and radii")
LEAPS = look_kind(
    "lines.leaps",
    "{points} point(s) far from their neighbors, as at {place} cm; were numbers lost or exchanged?",
    "Export the lines again.",
)


def read_centerlines(
    path: str | Path, unit: float, cut: Literal["tube", "identical"] = "tube", collapse: float = 0.0
) -> Tree:
    """Return the tree of vessels in a file of centerlines; `network_of` makes it a network.

    Parameters
    ----------
    path : path
        .vtp or .vtk (VMTK, Slicer: one line from the root to each terminal, also as vmtkbranchextractor cuts them;
        SimVascular: pairs of points), .dat or .csv (the same points as a flat table x, y, z, radius), .swc, TubeTK's
        tubes (.tre), or Slicer's curves (.mrk.json).
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
        Loops, which are opened; separate trees, of which the largest is taken; a root that had to be found; points far
        from their neighbors; a file that seems cut off.
    """
    path = Path(path)
    if not (np.isfinite(unit) and unit > 0):
        raise InputError(f"unit {unit} cm: give the file's unit of length as a positive number of cm (mm: 0.1)")
    skeleton = LINES.of(path).read(path, unit, cut)
    _warn_of_leaps(path, skeleton)
    with of_file(path):
        return cut_at_junctions(skeleton, collapse)


def measured_lines(
    path: str | Path,
    unit: float,
    cut: Literal["axes", "tube", "identical"] = "axes",
    collapse: float = 0.6,
    surface: str | Path | None = None,
    ends: Ends = "auto",
) -> Measurement:
    """Return the vessels in a file of centerlines, with the lengths that an extraction would give them.

    Parameters
    ----------
    path, unit, collapse
        See `read_centerlines`.
    cut : "axes", "tube" or "identical"
        Vessels meet where their axes do (see `as_extracted`), or lines are cut as they are, see `merged`.
    surface : path, optional
        The surface that the lines were drawn in, see `read_surface_points`, in the same unit.
    ends : "auto", "ball" or "wall"
        See `as_extracted`; the curves of Slicer end a ball before the wall.

    Raises
    ------
    InputError
        As `read_centerlines`, `read_surface_points`; a surface that lies elsewhere than the lines.

    Warns
    -----
    VasowaveWarning
        As `read_centerlines`; how radii by areas of sections, which are taken where a file has them, compare with those
        of the balls.
    """
    if cut != "axes":
        return _with_sections(measured_alone(read_centerlines(path, unit, cut, collapse)), path, unit)
    tree = read_centerlines(path, unit, "tube", collapse)
    points = None if surface is None else read_surface_points(surface, unit)
    if points is not None:
        gap = cKDTree(points).query(tree.line.points)[0] / np.maximum(tree.line.radius, 1e-12)
        if not 0.5 < np.median(gap) < 2:
            raise InputError(
                f"{surface}: the surface is {np.median(gap):.2g} radii from the lines of {path} in the middle, not 1; "
                "are its unit and its place theirs?"
            )
    alike = as_extracted(tree, points, LINES.of(path).ends if ends == "auto" else ends, collapse)
    return _with_sections(measured_alone(alike.tree, alike.length_sd), path, unit)


def _with_sections(measured: Measurement, path: str | Path, unit: float) -> Measurement:
    form = LINES.of(Path(path))
    sections = form.sections(Path(path), unit) if form.sections else None
    if sections is None:
        return measured
    measured, finding = with_section_radii(measured, sections)
    warn(finding.at(str(path)), stacklevel=3)
    return measured


def _warn_of_leaps(path: Path, skeleton: Skeleton) -> None:
    """Warn if neighbors lie far apart where nearly all others lie close: numbers that were exchanged or damaged.

    Only lines whose points follow each other within their radii can tell; those of VMTK and of vasowave do.
    """
    below = np.flatnonzero(skeleton.above >= 0)
    line, above = skeleton.line, skeleton.above[below]
    step = np.linalg.norm(line.points[below] - line.points[above], axis=1)
    tube = line.radius[below] + line.radius[above]
    if np.quantile(step / tube, 0.9) > 1:
        return
    leaps = np.flatnonzero((step > tube) & (step > LEAP * np.median(step)))
    if len(leaps):
        row = below[leaps[0]]
        warn(LEAPS(points=len(leaps), place=written(line.points[row])).at(str(path)), stacklevel=3)


def _polydata(path: Path, unit: float, cut: Literal["tube", "identical"]) -> Skeleton:
    data = read_polydata(path)
    points = _points(path, data, unit)
    if not {*RADIUS_NAMES} & set(data.fields):
        closed = int(np.isfinite(area_radii(data)).sum())
        warn(AREAS_ALONE(closed=closed, points=len(points)).at(str(path)), stacklevel=4)
    if unused := sorted(set(data.fields) - {*_BOOKKEEPING}):
        warn(UNUSED(what=f"arrays {', '.join(unused)}").at(str(path)), stacklevel=4)
    if all(len(line) == 2 for line in data.lines):  # SimVascular: one line for each pair of neighbors
        require_radii(path, points)
        with of_file(path):
            return rooted(points, np.array(data.lines))
    return _merged(path, [points[line] for line in _whole_lines(data)], cut)


def _sections(path: Path, unit: float) -> Sections | None:
    data = read_polydata(path)
    return sections_of(data, _points(path, data, unit), unit) if {*RADIUS_NAMES} & set(data.fields) else None


def _merged(path: Path, lines: list[Line], cut: Literal["tube", "identical"]) -> Skeleton:
    for line in lines:
        require_radii(path, line)
    with of_file(path):
        return merged(lines, cut)


def _whole_lines(data: PolyLines) -> list[np.ndarray]:
    """Return the lines from the root to the terminals; those that vmtkbranchextractor has cut are joined again."""
    if not {"CenterlineIds", "TractIds"} <= set(data.cells):
        return list(data.lines)
    order = np.lexsort([data.cells["TractIds"], data.cells["CenterlineIds"]])
    ids = data.cells["CenterlineIds"][order]
    groups = np.split(order, 1 + np.flatnonzero(np.diff(ids)))
    return [np.concatenate([data.lines[row] for row in rows]) for rows in groups]


def _points(path: Path, data: PolyLines, unit: float) -> Line:
    name = next((name for name in RADIUS_NAMES if name in data.fields), None)
    by_area = area_radii(data) if name is None else np.array([])
    if np.isfinite(by_area).any():
        places, closed = data.points, np.isfinite(by_area)
        nearest = cKDTree(places[closed]).query(places)[1]
        return Line(unit * places[:, ::-1], unit * by_area[closed][nearest])
    if name is None:
        available = ", ".join(sorted(data.fields)) or "none"
        raise InputError(f"{path}: no array {' or '.join(RADIUS_NAMES)} at the points; there are: {available}")
    return Line(unit * data.points[:, ::-1], unit * data.fields[name])


def _flat(path: Path, unit: float, cut: Literal["tube", "identical"]) -> Skeleton:
    """Return the lines of a flat table, which has lost them: a jump longer than both radii starts a new line."""
    table = read_columns(path, _ALIASES)
    table.warn()
    values = []
    columns = [
        table.require(axis, titles="x [mm], y [mm], z [mm] and radius [mm]") for axis in ("z", "y", "x", "radius")
    ]
    bookkeeping = {name.casefold() for name in (*_BOOKKEEPING, "vessel")} - {AREA.casefold()}
    if unused := [name for row, name in enumerate(table.names) if row not in columns and name not in bookkeeping]:
        warn(UNUSED(what=f"columns {', '.join(unused)}").at(str(path)), stacklevel=4)
    if len(written := {table.units[column] for column in columns[:3]} if table.units else set()) > 1:
        raise InputError(f"{path}: x, y and z are in different units ({', '.join(sorted(written))}); write one for all")
    for column in columns:
        has_unit = bool(table.units and table.units[column])
        values.append(table.numbers(column, "length", "cm") * (1.0 if has_unit else unit))
    points = Line.of(np.column_stack(values))
    jumps = np.diff(points.run) > points.radius[1:] + points.radius[:-1]
    lines = (points[rows] for rows in np.split(np.arange(len(points)), 1 + np.flatnonzero(jumps)))
    return _merged(path, [line for line in lines if len(line) > 1], cut)


def write_centerlines(tree: Tree, path: str | Path, unit: float = 1.0) -> None:
    """Write `tree` as .vtp as VMTK does: one line from the root to each terminal, x, y, z in `unit` (cm).

    `read_centerlines(path, unit, cut="identical")` reads the same vessels back. Slicer and ITK-SNAP expect mm: 0.1.
    """
    numbers: list[np.ndarray] = []
    points: list[Line] = []
    count = 0
    for line, parent in zip(tree.lines, tree.parent, strict=True):
        new = line if parent < 0 else line[1:]
        indices = count + np.arange(len(new))
        numbers.append(indices if parent < 0 else np.append(numbers[parent][-1], indices))
        points.append(new)
        count += len(new)
    lines = []
    for terminal in tree.terminals:
        route, row = [numbers[terminal]], int(tree.parent[terminal])
        while row >= 0:
            route.append(numbers[row][:-1])
            row = int(tree.parent[row])
        lines.append(np.concatenate(route[::-1]))
    all_points = points[0].then(*points[1:])
    radius = np.maximum(all_points.radius, LEAST) / unit
    write_vtp(PolyLines(all_points.points[:, ::-1] / unit, tuple(lines), {RADIUS_NAMES[0]: radius}), path)


LINES.register(
    LinesFormat("flat table", "flat table of points", (".csv", ".dat", ".txt", ".tsv", *WORKBOOKS), None, _flat)
)
LINES.register(LinesFormat("polydata", "VTK PolyData", (".vtp", ".vtk"), None, _polydata, sections=_sections))
