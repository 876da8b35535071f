"""Root-to-terminal lines, as VMTK writes them, merged into one tree of points."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from scipy.spatial import cKDTree

from vasowave.errors import InputError
from vasowave.findings import look_kind, warn
from vasowave.imaging.axes.skeleton import Skeleton
from vasowave.imaging.tree import Line

TUBE = 0.5
"""A line joins the tree where it comes nearer to it than TUBE inscribed radii."""

LINE_LOOPS = look_kind(
    "lines.loop",
    "line {number} closes a loop at ({place}): beyond it runs up to {radii:.1f} radii beside the tree; opened there",
    "Look at the line there, and remove what is no vessel.",
)


def merged(lines: Sequence[Line], cut: Literal["tube", "identical"] = "tube") -> Skeleton:
    """Return the tree of points in which `lines` share what they have in common.

    Parameters
    ----------
    lines : sequence of Line
        From the root to a terminal (or all from the terminal to the root).
    cut : "tube" or "identical"
        A line ends, coming from its terminal, where it enters the tree's tube of half its radius; or, the authors'
        rule, where coordinates are identical: longer vessels, since lines run side by side before they share points.

    Raises
    ------
    InputError
        Lines that do not share one end; a line that never meets the tree.

    Warns
    -----
    VasowaveWarning
        A line that, beyond where it joins the tree, goes another way to the root: a loop, opened at that place.
    """
    lines = _from_root([line[_moves(line)] for line in lines if len(line) > 1])
    return _joined(lines, 0.0 if cut == "identical" else TUBE)


def _moves(line: Line) -> np.ndarray:
    return np.append(True, np.abs(np.diff(line.points, axis=0)).max(axis=1) > 0)


def _from_root(lines: list[Line]) -> list[Line]:
    if not lines:
        raise InputError("no centerline has two points")
    first, last = (np.array([line.points[end] for line in lines]) for end in (0, -1))
    spread = [np.linalg.norm(ends - ends[0], axis=1).max() for ends in (first, last)]
    if min(spread) > lines[0].radius[[0, -1]].max():
        raise InputError(
            "the lines share neither their first nor their last point; each must run from the root to a terminal"
        )
    return lines if spread[0] <= spread[1] else [line[::-1] for line in lines]


def _joined(lines: list[Line], tube: float) -> Skeleton:
    longest = np.argsort([-line.length for line in lines], kind="stable")
    whole = lines[longest[0]]
    above = np.arange(len(whole)) - 1
    for number in longest[1:]:
        line = lines[number]
        distance, nearest = cKDTree(whole.points, balanced_tree=False, compact_nodes=False).query(line.points)
        inside = np.flatnonzero(distance <= tube * whole.radius[nearest])
        if len(inside) == 0:
            raise InputError(f"line {number} does not meet the others; is its root the same?")
        join = int(inside[-1])
        _warn_of_loop(line[: join + 1], Skeleton(whole, above), int(nearest[join]), int(number))
        if join < len(line) - 1:
            added = len(whole) + np.arange(len(line) - join - 1)
            above = np.concatenate([above, [nearest[join]], added[:-1]])
            whole = whole.then(line[join + 1 :])
    return Skeleton(whole, above)


def _warn_of_loop(rest: Line, tree: Skeleton, at: int, number: int) -> None:
    """Warn if `rest`, the part of a line that is left out, is not the tree's own way from point `at` to the root."""
    way = [at]
    while tree.above[way[-1]] >= 0:
        way.append(int(tree.above[way[-1]]))
    distance, nearest = cKDTree(tree.line.points[way]).query(rest.points)
    excess = distance / tree.line.radius[way][nearest]
    if excess.max() > 1.5:
        place = ", ".join(f"{value:.4g}" for value in tree.line.points[at])
        warn(LINE_LOOPS(number=number, place=place, radii=float(excess.max())), stacklevel=5)
