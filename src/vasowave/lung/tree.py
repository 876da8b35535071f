"""Vessels in space: an axis with its radii, the tree of them, and where along a vessel its lumen is its own."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial import cKDTree


@dataclass(frozen=True, eq=False)
class Line:
    """An axis and how wide the lumen is along it.

    Attributes
    ----------
    points : float array, shape (point, 3)
        z, y, x, cm, from the end nearer to the root.
    radius : float array, shape (point,)
        Radius of the inscribed ball at each point, cm.
    """

    points: np.ndarray
    radius: np.ndarray

    @classmethod
    def of(cls, table: np.ndarray) -> "Line":
        """Return the line in a table with the columns z, y, x, radius."""
        table = np.asarray(table, dtype=float)
        return cls(table[:, :3], table[:, 3])

    @cached_property
    def run(self) -> np.ndarray:
        """Distance of each point from the first, along the line, cm, shape (point,)."""
        return distance_along(self.points)

    @property
    def length(self) -> float:
        """Sum of the distances of successive points, cm (eq. 1)."""
        return float(self.run[-1])

    @property
    def tortuosity(self) -> float:
        """Length over the distance of the ends; 1 for a straight line."""
        return self.length / max(float(np.linalg.norm(self.points[-1] - self.points[0])), 1e-12)

    @cached_property
    def typical_radius(self) -> float:
        """Median inscribed radius without the first third, which is often wider, cm."""
        return float(np.median(self.radius[len(self) // 3 :]))

    def __len__(self) -> int:
        return len(self.radius)

    def __getitem__(self, rows: Any) -> "Line":
        """Return the part of the line that a slice, a mask or a list of rows selects."""
        return Line(self.points[rows], self.radius[rows])

    def at(self, run: np.ndarray) -> "Line":
        """Return the places of the line at distances `run` from its first point, cm, shape (place,)."""
        columns = (*self.points.T, self.radius)
        return Line.of(np.column_stack([np.interp(run, self.run, column) for column in columns]))

    def then(self, *successors: "Line") -> "Line":
        """Return this line and its `successors` after it as one."""
        lines = (self, *successors)
        return Line(np.concatenate([line.points for line in lines]), np.concatenate([line.radius for line in lines]))


@dataclass(frozen=True, eq=False)
class Tree:
    """Vessels in space; row i of every field is the same vessel, parents before daughters.

    Attributes
    ----------
    lines : tuple of Line
        Each vessel from its junction to its end.
    parent : int array, shape (vessel,)
        Row of the parent, -1 for the root.
    """

    lines: tuple[Line, ...]
    parent: np.ndarray

    def __len__(self) -> int:
        return len(self.lines)

    @cached_property
    def root(self) -> int:
        """Row of the vessel without a parent."""
        return int(np.flatnonzero(self.parent < 0)[0])

    @cached_property
    def terminals(self) -> tuple[int, ...]:
        """Rows of the vessels without daughters, ascending."""
        return tuple(sorted(set(range(len(self))) - set(self.parent.tolist())))

    def daughters(self, row: int) -> np.ndarray:
        """Return the rows of the daughters of vessel `row`."""
        return np.flatnonzero(self.parent == row)

    @cached_property
    def line(self) -> Line:
        """The points of all vessels, one vessel after the other."""
        return self.lines[0].then(*self.lines[1:])

    @cached_property
    def owner(self) -> np.ndarray:
        """The vessel of each point of `line`, int array, shape (point,)."""
        return np.repeat(np.arange(len(self)), [len(line) for line in self.lines])

    def with_lines(self, lines: Sequence[Line]) -> "Tree":
        """Return the same tree along other lines."""
        return replace(self, lines=tuple(lines))

    def merged(self, row: int) -> "Tree":
        """Return the tree whose inner vessel `row` is a point: its daughters leave its parent."""
        parents = self.parent.copy()
        parents[self.daughters(row)] = self.parent[row]
        return without(self.lines, parents, {row})

    def moved(self, move: Callable[[np.ndarray], np.ndarray]) -> "Tree":
        """Return the tree with every point where `move` puts it; radii stay."""
        return self.with_lines([Line(move(line.points), line.radius) for line in self.lines])

    def times(self, factor: float) -> "Tree":
        """Return the tree with every coordinate and radius times `factor`."""
        return self.with_lines([Line(line.points * factor, line.radius * factor) for line in self.lines])


def without(lines: Sequence[Line], parents: np.ndarray, gone: set[int]) -> Tree:
    """Return the tree of the rows that are not `gone`, parents before daughters again."""
    new = {-1: -1}
    order: list[int] = []
    waiting = [row for row in range(len(lines)) if row not in gone]
    while waiting:  # a daughter may have moved to a parent that stands after it
        ready = [row for row in waiting if int(parents[row]) in new]
        for row in ready:
            new[row] = len(order)
            order.append(row)
        waiting = [row for row in waiting if row not in new]
    return Tree(tuple(lines[row] for row in order), np.array([new[int(parents[row])] for row in order]))


def distance_along(points: np.ndarray) -> np.ndarray:
    """Return the distance of each of `points`, shape (point, 3), from the first, along them."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def with_inscribed_radii(axes: Sequence[np.ndarray], parent: np.ndarray, surface: np.ndarray) -> Tree:
    """Return the tree of `axes` (z, y, x, cm), their radii the distances to the nearest of the surface's points."""
    index = cKDTree(surface)
    return Tree(tuple(Line(axis, index.query(axis)[0]) for axis in axes), parent)


def free_length(tree: Tree) -> np.ndarray:
    """Return the length of each vessel in its clear stretch (see `clear_stretches`), cm, shape (vessel,)."""
    return np.array([max(end - begin, 0.0) for begin, end in clear_stretches(tree)])


def free_stretches(tree: Tree) -> list[tuple[float, float]]:
    """Return where each vessel leaves its first junction's ball and where it enters the last or nears its end, cm."""
    return [free_stretch(line, row in tree.terminals) for row, line in enumerate(tree.lines)]


def free_stretch(line: Line, is_terminal: bool) -> tuple[float, float]:
    """Return where one vessel leaves its first junction's ball and where it enters the last or nears its end, cm."""
    tail = line.typical_radius if is_terminal else line.radius[-1]
    return float(line.radius[0]), float(line.length - tail)


def clear_stretches(tree: Tree) -> list[tuple[float, float]]:
    """Return the free stretches of `tree` without what lies in the tube of a sister, cm, see `clear_stretch`."""
    return [clear_stretch(tree, row, stretch) for row, stretch in enumerate(free_stretches(tree))]


def clear_stretch(tree: Tree, row: int, free: tuple[float, float]) -> tuple[float, float]:
    """Return the `free` stretch of one vessel without what lies in the tube of a sister, cm.

    A thin vessel runs on in the wide tube of its sister long after it has left the junction's ball, and its center
    path there is not its axis. At most half a vessel's length is given up to its sisters.
    """
    line, (begin, end) = tree.lines[row], free
    for sister in np.flatnonzero((tree.parent == tree.parent[row]) & (tree.parent >= 0)):
        if sister != row:
            distance = cKDTree(tree.lines[sister].points).query(line.points)[0]
            in_tube = distance < tree.lines[sister].typical_radius + 0.5 * line.typical_radius
            first = len(line) - 1 if in_tube.all() else int(np.argmin(in_tube))
            begin = max(begin, min(float(line.run[first]), 0.5 * line.length))
    return begin, end
