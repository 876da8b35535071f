"""SWC, the table of points of neuron tracing: number, type, x, y, z, radius, parent."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vasowave.base import units
from vasowave.base.errors import InputError, of_file
from vasowave.base.io.columns import read_columns
from vasowave.base.io.files import write_file
from vasowave.base.io.textfile import read_start
from vasowave.lung.axes.skeleton import Skeleton
from vasowave.lung.exchange.formats import LINES, LinesFormat
from vasowave.lung.exchange.merging import rooted
from vasowave.lung.tree import Line, Tree

LEAST = 1e-6
"""Radius, cm, that is written where an axis ends at the surface; readers refuse 0."""

_COUNT = r"^# points: (\d+)\s*$"
_MAX_COORDINATE = 1e5  # cm; no scanner counts from so far away
_MAX_INTEGER = 2.0**53  # above it a number of type double is not a count any more


def read_swc(path: Path, unit: float) -> Skeleton:
    """Return the tree of points in an SWC file whose unit of length is `unit`, cm.

    Several roots, or one in the middle of the tree, are put right with a warning, see `rooted`; a file that seems cut
    off is told, too.
    """
    table = read_columns(path)
    if len(table.cells[0]) != 7 or table.names[2:] not in ((), ("x", "y", "z", "radius", "parent")):
        raise InputError(f"{path}: an SWC file has seven columns of numbers: number, type, x, y, z, radius, parent")
    stated = {word for word in table.units[2:6] if word}
    if len(stated) > 1 or any(not np.isclose(units.factor(word, "length"), unit) for word in stated):
        raise InputError(f"{path}: its titles say {', '.join(sorted(stated))}; give that unit, one for all")
    table.warn()
    values = table.matrix()
    points = Line.of(unit * values[:, [4, 3, 2, 5]])
    require_radii(path, points)
    announced = re.search(_COUNT, read_start(path).decode("utf-8", errors="replace"), re.MULTILINE)
    if announced is not None and int(announced[1]) != len(values):
        raise InputError(f"{path}: {len(values)} points where its first lines announce {announced[1]}; was it cut off?")
    above = _above(path, table.lines, values)
    depth = above.copy()
    for _ in range(len(above).bit_length() + 1):  # pointer doubling: after log2(n) rounds everyone is at a root
        depth = np.where(depth >= 0, depth[depth], -1)
    if (depth >= 0).any():
        raise InputError(f"{path}: the parents of line {table.lines[int(np.argmax(depth >= 0))]} form a cycle")
    roots = np.flatnonzero(above < 0)
    if len(roots) == 1 and (above == roots[0]).sum() == 1:
        return Skeleton(points, above)
    inner = np.flatnonzero(above >= 0)
    with of_file(path):
        return rooted(points, np.column_stack([inner, above[inner]]), int(roots[0]))


def _above(path: Path, lines: Sequence[int], values: np.ndarray) -> np.ndarray:
    """Return for each row that of its parent, -1 for a root."""
    is_integer = np.isfinite(values) & (np.abs(values) < _MAX_INTEGER) & (np.floor(values) == values)
    wrong = np.flatnonzero(~is_integer[:, [0, 6]].all(axis=1))
    if len(wrong):
        raise InputError(f"{path}, line {lines[int(wrong[0])]}: the numbers of a point and its parent must be whole")
    row = {int(number): index for index, number in enumerate(values[:, 0])}
    if len(row) < len(values):
        raise InputError(f"{path}: a point number is used twice")
    above = np.full(len(values), -1)
    for index, parent in enumerate(values[:, 6].astype(int)):
        if parent >= 0:
            if parent not in row:
                raise InputError(f"{path}, line {lines[index]}: parent {parent} is not in the file")
            above[index] = row[parent]
    return above


def require_radii(path: Path, line: Line) -> None:
    """Raise `InputError` unless places are finite and radii positive."""
    if not (np.isfinite(line.points).all() and np.isfinite(line.radius).all() and (line.radius > 0).all()):
        raise InputError(f"{path}: a point whose position or radius is not finite or not positive; repair the line")
    if max(np.abs(line.points).max(initial=0.0), line.radius.max(initial=0.0)) > _MAX_COORDINATE:
        raise InputError(f"{path}: a point or a radius beyond {_MAX_COORDINATE:g} cm; damaged, or the unit is wrong")


def write_swc(tree: Tree, path: str | Path) -> None:
    """Write `tree` as SWC in µm, x, y, z: `read_centerlines(path, unit=1e-4)` reads the same vessels back."""
    last: list[int] = []
    count = 0
    points = sum(map(len, tree.lines)) - len(tree) + 1
    rows = ["# number type x y z radius parent, micrometers", f"# points: {points}"]
    for line, parent in zip(tree.lines, tree.parent, strict=True):
        above = -1 if parent < 0 else last[parent]
        new = line if parent < 0 else line[1:]
        for (z, y, x), r in zip(1e4 * new.points, 1e4 * new.radius, strict=True):
            count += 1
            rows.append(f"{count} 0 {x:.9g} {y:.9g} {z:.9g} {max(r, 1e4 * LEAST):.9g} {above}")
            above = count
        last.append(count)
    write_file(Path(path), "\n".join([*rows, ""]))


LINES.register(LinesFormat("swc", "SWC", (".swc",), None, lambda path, unit, cut: read_swc(path, unit)))
