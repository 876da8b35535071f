"""Where vessels meet: each junction fitted from many starts; all that fit the surface alike say what is left open.

A fit that begins with a junction too early or too late may stay there, where vessels bend within two radii or run on
side by side. So the vessels around every junction are fitted alone, from where they meet now, from nearer to the root
and from farther along each daughter. The start that ends nearest to the surface is taken, and lengths that differ
between those that end about as near are known no better than that.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from vasowave.imaging.axes.tubes import fitted_apart
from vasowave.imaging.tree import Line, Tree

ARM, MOST, FEWEST = 5.0, 0.6, 5
"""An arm reaches so many radii from its junction, at most along this share of its vessel; it has FEWEST points."""
AWAY, LEAST = 1.5, 0.4
"""A start lies so many radii from where vessels meet now, at most this share of the arm it lies on."""
FIRST, WORTH, SAME = 3, 2.0, 0.1
"""After FIRST soft rounds a start is followed to its end unless its misfit is WORTH times the least, or its junction
lies within SAME radii of that of a better one."""
ALIKE = 0.1
"""A misfit that is larger by this share is less likely by the factor e."""
BETTER = 0.95
"""A junction is moved where that brings the misfit below this share of what it was."""
UNSEEN = 0.06
"""Standard deviation of a junction's place that no start shows, radii of the parent."""
TOGETHER = 16
"""So many junctions are fitted at once."""


@dataclass(frozen=True, eq=False)
class Settled:
    """A tree whose junctions are where they fit the surface best.

    Attributes
    ----------
    tree : Tree
    open_sd : float array, shape (vessel,)
        SD of its lengths, cm, for where its vessels meet: between fits that are as good, and what none shows.
    place_sd : float array, shape (vessel,)
        SD of the place where the daughters of each vessel leave it, cm; 0 for terminals.
    """

    tree: Tree
    open_sd: np.ndarray
    place_sd: np.ndarray


class _Junction(NamedTuple):
    """The vessels that meet, the parent first, which points of each are its arm, and the surface around the arms."""

    rows: list[int]
    cuts: list[slice]
    surface: np.ndarray


def settled(tree: Tree, surface: np.ndarray, spacing: float, roughness: float = 0.0) -> Settled:
    """Return `tree` with each junction from the start that fits best, and what the other starts say of its lengths.

    Parameters
    ----------
    tree : Tree
        Fitted to the surface.
    surface : float array, shape (corner, 3)
        Points of the lumen's surface, cm.
    spacing, roughness : float
        See `fitted`.
    """
    junctions = _junctions(tree, surface)
    lines, variance, place = [[line, line] for line in tree.lines], np.zeros(len(tree)), np.zeros(len(tree))
    moved = False
    for first in range(0, len(junctions), TOGETHER):
        some = junctions[first : first + TOGETHER]
        for junction, fits in zip(some, _fits(tree, some, spacing, roughness), strict=True):
            misfit = np.array([misfit for _, misfit in fits])
            best = int(np.argmin(misfit)) if misfit.min() < BETTER * misfit[0] else 0
            likely = np.exp(-(misfit / max(misfit[best], 1e-12) - 1) / ALIKE)
            likely /= likely.sum()
            lengths = np.array([[arm.length for arm in one.lines] for one, _ in fits])
            places = np.array([_place(one) for one, _ in fits])
            unseen = (UNSEEN * tree.lines[junction.rows[0]].typical_radius) ** 2
            variance[junction.rows] += likely @ (lengths - lengths[best]) ** 2 + unseen
            place[junction.rows[0]] = likely @ ((places - places[best]) ** 2).sum(axis=1) + unseen
            if best:
                moved = True
                _put(lines, tree, junction, fits[best][0].lines)
    best_tree = tree.with_lines([_halves(*pair) for pair in lines]) if moved else tree
    return Settled(best_tree, np.sqrt(variance), np.sqrt(place))


def _junctions(tree: Tree, surface: np.ndarray) -> list[_Junction]:
    nearest = cKDTree(tree.line.points).query(surface)[1]
    begins = np.cumsum([0, *map(len, tree.lines)])
    found = []
    for row in range(len(tree)):
        if row in tree.terminals:
            continue
        rows, reach = [row, *tree.daughters(row).tolist()], ARM * tree.lines[row].typical_radius
        parent = tree.lines[row]
        back = int(np.searchsorted(parent.run, parent.length - min(reach, MOST * parent.length)))
        cuts = [slice(min(back, max(len(parent) - FEWEST, 0)), len(parent))]
        for line in (tree.lines[one] for one in rows[1:]):
            cuts.append(slice(0, max(int(np.searchsorted(line.run, min(reach, MOST * line.length))), FEWEST)))
        own = np.zeros(begins[-1], dtype=bool)
        for one, cut in zip(rows, cuts, strict=True):
            own[begins[one] : begins[one + 1]][cut] = True
        found.append(_Junction(rows, cuts, surface[own[nearest]]))
    return found


def _fits(
    tree: Tree, junctions: Sequence[_Junction], spacing: float, roughness: float
) -> list[list[tuple[Tree, float]]]:
    """Return the fits of each junction's arms, that from where they meet now first, and their misfits.

    What is far from the surface after a few rounds, or at the place of another, is not followed to its end.
    """
    starts = [_starts(tuple(tree.lines[row][cut] for row, cut in zip(*one[:2], strict=True))) for one in junctions]
    owner = np.repeat(np.arange(len(junctions)), [len(own) for own in starts])
    surfaces = [junctions[number].surface for number in owner.tolist()]
    begun = fitted_apart([one for own in starts for one in own], surfaces, spacing, roughness, rounds=FIRST)
    more: list[int] = []
    for number in range(len(junctions)):
        own = np.flatnonzero(owner == number).tolist()
        least = min(begun[one][1] for one in own)
        apart = SAME * tree.lines[junctions[number].rows[0]].typical_radius
        kept = own[:1]
        for one in sorted(own[1:], key=lambda row: begun[row][1]):
            gaps = [np.linalg.norm(_place(begun[one][0]) - _place(begun[other][0])) for other in kept]
            if begun[one][1] < WORTH * least and min(gaps) > apart:
                kept.append(one)
        more += kept
    ends = fitted_apart([begun[one][0] for one in more], [surfaces[one] for one in more], spacing, roughness, 1.0)
    return [[fit for fit, one in zip(ends, more, strict=True) if owner[one] == n] for n in range(len(junctions))]


def _place(tree: Tree) -> np.ndarray:
    """Return where the arms of a junction meet."""
    return np.asarray(tree.lines[0].points[-1])


def _starts(arms: tuple[Line, ...]) -> list[Tree]:
    """Return the arms as they are, with their junction nearer to the root, and farther along each daughter."""
    radius, parent = arms[0].typical_radius, np.append(-1, np.zeros(len(arms) - 1, dtype=int))
    later = (_later(arms, which, radius) for which in range(1, len(arms)))
    return [Tree(start, parent) for start in (arms, _earlier(arms, radius), *later)]


def _earlier(arms: tuple[Line, ...], radius: float) -> tuple[Line, ...]:
    """Return the arms with their junction nearer to the root: the daughters share the stretch beyond."""
    parent = arms[0]
    back = min(AWAY * radius, LEAST * parent.length)
    point = max(int(np.searchsorted(parent.run, parent.length - back)), 1)
    return parent[: point + 1], *(parent[point:-1].then(arm) for arm in arms[1:])


def _later(arms: tuple[Line, ...], which: int, radius: float) -> tuple[Line, ...]:
    """Return the arms with their junction farther along the daughter `which`, to which its sisters lead."""
    along = arms[which]
    point = min(max(int(np.searchsorted(along.run, min(AWAY * radius, LEAST * along.length))), 1), len(along) - 3)
    shared = along[: point + 1]
    moved = [arms[0][:-1].then(shared)]
    for row, arm in enumerate(arms[1:], 1):
        moved.append(arm[point:] if row == which else rerouted(arm, shared.points[-1], float(along.run[point])))
    return tuple(moved)


def rerouted(arm: Line, junction: np.ndarray, within: float) -> Line:
    """Return `arm` from `junction` on, straight to where it leaves the ball `within`, at most half its length."""
    kept = arm[arm.run >= min(within, 0.5 * arm.length)]
    count = max(2, int(np.linalg.norm(kept.points[0] - junction) / max(arm.run[1], 1e-9)))
    way = np.linspace(junction, kept.points[0], count, endpoint=False)
    return Line(way, np.linspace(within, kept.radius[0], count, endpoint=False)).then(kept)


def _put(lines: list[list[Line]], tree: Tree, junction: _Junction, arms: tuple[Line, ...]) -> None:
    """Put the arms of a junction into its vessels: the line that counts at a vessel's begin, and that at its end."""
    (row, *daughters), (cut, *others) = junction.rows, junction.cuts
    lines[row][1] = tree.lines[row][: cut.start].then(arms[0])
    for daughter, other, arm in zip(daughters, others, arms[1:], strict=True):
        lines[daughter][0] = arm.then(tree.lines[daughter][other.stop :])


def _halves(begin: Line, end: Line) -> Line:
    """Return the first half of one line of a vessel and, from there, the rest of the other."""
    if begin is end:
        return begin
    middle = int(np.searchsorted(begin.run, begin.length / 2))
    there = int(np.linalg.norm(end.points - begin.points[middle], axis=1).argmin()) + 1
    return begin[: middle + 1].then(end[min(there, len(end) - 1) :])
