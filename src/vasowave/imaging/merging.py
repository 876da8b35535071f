"""Root-to-terminal lines, as VMTK writes them, merged into one tree of points."""

import warnings
from collections.abc import Sequence
from typing import Literal

import numpy as np
from scipy.spatial import cKDTree

from vasowave.errors import InputError, VasowaveWarning

TUBE = 0.5
"""A line joins the tree where it comes nearer to it than TUBE inscribed radii."""


def merged(lines: Sequence[np.ndarray], cut: Literal["tube", "identical"] = "tube") -> tuple[np.ndarray, np.ndarray]:
    """Return the points of the tree, shape (point, 4), and for each the next point toward the root (-1 there).

    Parameters
    ----------
    lines : sequence of float array, shape (point, 4)
        Position and inscribed radius from the root to a terminal (or all from the terminal to the root).
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


def _moves(line: np.ndarray) -> np.ndarray:
    return np.append(True, np.abs(np.diff(line[:, :3], axis=0)).max(axis=1) > 0)


def _from_root(lines: list[np.ndarray]) -> list[np.ndarray]:
    if not lines:
        raise InputError("no centerline has two points")
    first, last = (np.array([line[end] for line in lines]) for end in (0, -1))
    spread = [np.linalg.norm(ends[:, :3] - ends[0, :3], axis=1).max() for ends in (first, last)]
    if min(spread) > max(first[0, 3], last[0, 3]):
        raise InputError(
            "the lines share neither their first nor their last point; each must run from the root to a terminal"
        )
    return lines if spread[0] <= spread[1] else [line[::-1] for line in lines]


def _joined(lines: list[np.ndarray], tube: float) -> tuple[np.ndarray, np.ndarray]:
    longest = np.argsort([-np.linalg.norm(np.diff(line[:, :3], axis=0), axis=1).sum() for line in lines], kind="stable")
    points = lines[longest[0]]
    above = np.arange(len(points)) - 1
    for number in longest[1:]:
        line = lines[number]
        distance, nearest = cKDTree(points[:, :3], balanced_tree=False, compact_nodes=False).query(line[:, :3])
        inside = np.flatnonzero(distance <= tube * points[nearest, 3])
        if len(inside) == 0:
            raise InputError(f"line {number} does not meet the others; is its root the same?")
        join = int(inside[-1])
        _warn_of_loop(line[: join + 1], points, above, int(nearest[join]), int(number))
        if join < len(line) - 1:
            added = len(points) + np.arange(len(line) - join - 1)
            above = np.concatenate([above, [nearest[join]], added[:-1]])
            points = np.concatenate([points, line[join + 1 :]])
    return points, above


def _warn_of_loop(rest: np.ndarray, points: np.ndarray, above: np.ndarray, at: int, number: int) -> None:
    """Warn if `rest`, the part of a line that is left out, is not the tree's own way from point `at` to the root."""
    way = [at]
    while above[way[-1]] >= 0:
        way.append(int(above[way[-1]]))
    distance, nearest = cKDTree(points[way, :3]).query(rest[:, :3])
    excess = distance / points[way, 3][nearest]
    if excess.max() > 1.5:
        place = ", ".join(f"{value:.4g}" for value in points[at, :3])
        warnings.warn(
            f"line {number} closes a loop at ({place}): beyond it runs up to {excess.max():.1f} radii beside the tree; "
            "opened there",
            VasowaveWarning,
            stacklevel=5,
        )
