"""Lines of other programs as one tree of points: root-to-terminal lines merged, points joined by edges rooted."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.spatial import cKDTree

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, warn
from vasowave.lung.axes.skeleton import Skeleton
from vasowave.lung.places import written
from vasowave.lung.tree import Line

TUBE = 0.5
"""A line joins the tree where it comes nearer to it than TUBE inscribed radii."""

LINE_LOOPS = look_kind(
    "lines.loop",
    "line {number} closes a loop at ({place}): beyond it runs up to {radii:.1f} radii beside the tree; opened there",
    "Look at the line there, and remove what is not a vessel.",
)
SEPARATE_TREES = look_kind(
    "lines.separate-trees",
    "{trees} separate trees: the largest is taken, {left} of {points} points are left",
    "Join the trees where they are drawn, if they are one.",
)
ROOT_INSIDE = look_kind(
    "lines.root-inside",
    "the first point lies inside the tree: the widest end, {place} cm, is the root",
    "Begin the lines at the root.",
)
PIECES = look_kind(
    "lines.pieces",
    "the {lines} lines run from one junction to the next: blood is taken to enter at the widest end, {place} cm",
    "If it enters elsewhere, draw the lines from the root to each terminal.",
)
LINES_LOOP = look_kind(
    "lines.loops", "the lines close {loops} loop(s); each is cut farthest from the root", "Cut them where they touch."
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
    lines = [line[_moves(line)] for line in lines if len(line) > 1]
    if len(lines) > 2 and (pieces := _of_pieces(lines)) is not None:
        return pieces
    lines = _from_root(lines)
    return _joined(lines, 0.0 if cut == "identical" else TUBE)


def _of_pieces(lines: Sequence[Line]) -> Skeleton | None:
    """Return the tree of lines that run from one junction to the next and have their ends in common, else None."""
    ends = np.concatenate([line.points[[0, -1]] for line in lines])
    places, count = np.unique(ends, axis=0, return_counts=True)
    if len(places) != len(lines) + 1 or (count > 1).sum() < 2:  # a tree has one place more than pieces
        return None
    points, place = np.unique(np.concatenate([line.points for line in lines]), axis=0, return_inverse=True)
    radius = np.zeros(len(points))
    np.maximum.at(radius, place.ravel(), np.concatenate([line.radius for line in lines]))
    numbers = np.split(place.ravel(), np.cumsum([len(line) for line in lines])[:-1])
    tree = rooted(Line(points, radius), np.concatenate([np.column_stack([piece[:-1], piece[1:]]) for piece in numbers]))
    if len(tree.line) < len(points):
        return None
    warn(PIECES(lines=len(lines), place=written(tree.line.points[0])), stacklevel=5)
    return tree


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
    merged_line = lines[longest[0]]
    above = np.arange(len(merged_line)) - 1
    for number in longest[1:]:
        line = lines[number]
        distance, nearest = cKDTree(merged_line.points, balanced_tree=False, compact_nodes=False).query(line.points)
        inside = np.flatnonzero(distance <= tube * merged_line.radius[nearest])
        if len(inside) == 0:
            raise InputError(f"line {number} does not meet the others; is its root the same?")
        join = int(inside[-1])
        _warn_of_loop(line[: join + 1], Skeleton(merged_line, above), int(nearest[join]), int(number))
        if join < len(line) - 1:
            added = len(merged_line) + np.arange(len(line) - join - 1)
            above = np.concatenate([above, [nearest[join]], added[:-1]])
            merged_line = merged_line.then(line[join + 1 :])
    return Skeleton(merged_line, above)


def _warn_of_loop(remainder: Line, tree: Skeleton, junction: int, number: int) -> None:
    """Warn if `remainder`, what is left out of a line, is not the tree's own way from point `junction` to the root."""
    path = [junction]
    while tree.above[path[-1]] >= 0:
        path.append(int(tree.above[path[-1]]))
    distance, nearest = cKDTree(tree.line.points[path]).query(remainder.points)
    excess = distance / tree.line.radius[path][nearest]
    if excess.max() > 1.5:
        place = ", ".join(f"{value:.4g}" for value in tree.line.points[junction])
        warn(LINE_LOOPS(number=number, place=place, radii=float(excess.max())), stacklevel=5)


def rooted(points: Line, edges: np.ndarray, root: int | None = None) -> Skeleton:
    """Return the tree of the largest piece of `points`, from `root` or else from its widest end.

    Parameters
    ----------
    points : Line
    edges : int array, shape (edge, 2)
    root : int, optional
        A point; if it is no end of its piece, the widest end is taken instead.

    Raises
    ------
    InputError
        No edge.

    Warns
    -----
    VasowaveWarning
        Pieces that are left out; a root inside the tree; loops, which are cut.
    """
    if len(edges) == 0:
        raise InputError("no two points are joined; are these centerlines?")
    size = len(points)
    graph = coo_array((np.ones(len(edges)), edges.T), shape=(size, size)).tocsr()
    graph = (graph + graph.T).astype(bool)
    pieces, label = connected_components(graph, directed=False)
    largest = int(np.bincount(label).argmax())
    if pieces > 1:
        warn(SEPARATE_TREES(trees=int(pieces), left=int((label != largest).sum()), points=int(size)))
    degree = np.asarray(graph.sum(axis=1)).ravel()
    ends = np.flatnonzero((label == largest) & (degree == 1))
    if root is None or label[root] != largest or degree[root] != 1:
        if len(ends) == 0:
            raise InputError("the lines close a ring without an end; cut it")
        inner, root = root, int(ends[np.argmax(points.radius[ends])])
        if inner is not None:
            warn(ROOT_INSIDE(place=written(points.points[root])))
    order, above = breadth_first_order(graph, root, directed=False)
    loops = int(graph[label == largest][:, label == largest].nnz // 2 - len(order) + 1)
    if loops:
        warn(LINES_LOOP(loops=loops))
    new = np.full(size, -1)
    new[order] = np.arange(len(order))
    return Skeleton(points[order], np.where(above[order] < 0, -1, new[np.maximum(above[order], 0)]))
