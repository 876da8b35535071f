"""Where vessels meet: each junction fitted from many starts; all that fit the surface alike say what is left open.

A fit that begins with a junction too early or too late may stay there, where vessels bend within two radii or run on
side by side. So the vessels around every junction are fitted alone, from where they meet now, from nearer to the root
and from farther along each daughter. The start that ends nearest to the surface is taken, and lengths that differ
between those that end about as near are known no better than that.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from vasowave.lung.axes.tubes import fitted_apart
from vasowave.lung.tree import Line, Tree

ARM, MAX_ARM_SHARE, MIN_ARM_POINTS = 5.0, 0.6, 5
"""An arm reaches so many radii from its junction, at most along this share of its vessel; it has so many points."""
AWAY, MAX_START_SHARE = 1.5, 0.4
"""A start lies so many radii from where vessels meet now, at most this share of the arm it lies on."""
FIRST_ROUNDS, MAX_MISFIT_RATIO, MIN_GAP_RADII = 3, 2.0, 0.1
"""After FIRST_ROUNDS soft rounds a start is followed to its end unless its misfit is MAX_MISFIT_RATIO times the least,
or its junction lies within MIN_GAP_RADII of that of a better one."""
MISFIT_SCALE = 0.1
"""A misfit that is larger by this share is less likely by the factor e."""
MOVED_MISFIT_SHARE = 0.95
"""A junction is moved where that brings the misfit below this share of what it was."""
UNSEEN = 0.06
"""Standard deviation of a junction's place that no start shows, radii of the parent."""


@dataclass(frozen=True, eq=False)
class Settled:
    """A tree whose junctions are where they fit the surface best.

    Attributes
    ----------
    tree : Tree
    ends_sd : float array, shape (vessel, 2)
        SD of its lengths, cm, for where each vessel begins and where it ends: between fits that are as good, and what
        none shows; 0 where no vessels meet.
    place_sd : float array, shape (vessel,)
        SD of the place where the daughters of each vessel leave it, cm; 0 for terminals.
    """

    tree: Tree
    ends_sd: np.ndarray
    place_sd: np.ndarray

    @property
    def open_sd(self) -> np.ndarray:
        """SD of the lengths for where vessels meet, cm, shape (vessel,)."""
        return np.hypot(*self.ends_sd.T)


class _Junction(NamedTuple):
    """The vessels that meet, the parent first, which points of each are its arm, and what decides where they meet."""

    rows: list[int]
    cuts: list[slice]
    evidence: "_Evidence"


class _Evidence(NamedTuple):
    """Arms, the radius of the parent, cm, and the points of the surface around them."""

    arms: tuple[Line, ...]
    radius: float
    surface: np.ndarray


class _Fit(NamedTuple):
    """SD of the length of each vessel of a junction and of its place, cm, and its arms where they fit better."""

    length_sd: np.ndarray
    place_sd: float
    arms: tuple[Line, ...] | None


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
    lines, ends, place = [[line, line] for line in tree.lines], np.zeros((len(tree), 2)), np.zeros(len(tree))
    moved = False
    for junction in _junctions(tree, surface, _inner(tree)):
        fit = _fit(junction.evidence, spacing, roughness)
        _note(ends, place, junction.rows, fit.length_sd, fit.place_sd)
        if fit.arms is not None:
            moved = True
            _put(lines, tree, junction, fit.arms)
    return Settled(tree.with_lines([_halves(*pair) for pair in lines]) if moved else tree, ends, place)


def settled_before(
    tree: Tree, before: Settled, surface: np.ndarray, spacing: float, roughness: float, recalled: Callable[..., Any]
) -> Settled:
    """Return `tree`, made of `before` by hand, as it is, and what is open of its lengths; see `settled`.

    A junction whose arms are those of `before` keeps what was open there; the others are fitted anew. `recalled` is
    called with what decides a value and what makes it, and returns the value, made now or earlier.
    """
    ends, place, refit_rows = np.zeros((len(tree), 2)), np.zeros(len(tree)), []
    was = {before.tree.lines[row].points[-1].tobytes(): row for row in _inner(before.tree)}
    for row in _inner(tree):
        rows = [row, *tree.daughters(row).tolist()]
        old = _as_before(tree, rows, before.tree, was.get(tree.lines[row].points[-1].tobytes()))
        if old:
            sd = [before.ends_sd[old[0], 1], *before.ends_sd[old[1:], 0]]
            _note(ends, place, rows, np.array(sd), before.place_sd[old[0]])
        else:
            refit_rows.append(row)
    for junction in _junctions(tree, surface, refit_rows):
        arguments = junction.evidence, spacing, roughness
        _note(
            ends,
            place,
            junction.rows,
            *recalled(("junction", arguments), lambda arguments=arguments: _fit(*arguments)[:2]),
        )
    return Settled(tree, ends, place)


def _inner(tree: Tree) -> list[int]:
    return [row for row in range(len(tree)) if row not in tree.terminals]


def _note(ends: np.ndarray, place: np.ndarray, rows: list[int], length_sd: np.ndarray, place_sd: float) -> None:
    """Note what is open of the lengths of vessels that meet, where the parent ends and its daughters begin."""
    ends[rows[0], 1], ends[rows[1:], 0] = length_sd[0], length_sd[1:]
    place[rows[0]] = place_sd


def _as_before(tree: Tree, rows: list[int], before: Tree, parent: int | None) -> list[int]:
    """Return the rows of the vessels of `before` whose arms at the end of `parent` those of `rows` have, [] if none."""
    if parent is None:
        return []
    old = [parent, *before.daughters(parent).tolist()]
    if len(old) != len(rows):
        return []
    arms = [before.lines[row][cut] for row, cut in zip(old, _cuts(before, old), strict=True)]
    if not _is_same(tree.lines[rows[0]][-len(arms[0]) :], arms[0]):
        return []
    matches = [parent]
    for row in rows[1:]:
        line = tree.lines[row]
        same = (candidate for candidate, arm in zip(old[1:], arms[1:], strict=True) if _is_same(line[: len(arm)], arm))
        matches.append(next(same, -1))
    return matches if min(matches) >= 0 else []


def _is_same(stretch: Line, arm: Line) -> bool:
    return np.array_equal(stretch.points, arm.points) and np.array_equal(stretch.radius, arm.radius)


def _cuts(tree: Tree, rows: list[int]) -> list[slice]:
    """Return which points of the vessels that meet, the parent first, are their arms."""
    parent, reach = tree.lines[rows[0]], ARM * tree.lines[rows[0]].typical_radius
    back = int(np.searchsorted(parent.run, parent.length - min(reach, MAX_ARM_SHARE * parent.length)))
    cuts = [slice(min(back, max(len(parent) - MIN_ARM_POINTS, 0)), len(parent))]
    for line in (tree.lines[daughter] for daughter in rows[1:]):
        cuts.append(
            slice(0, max(int(np.searchsorted(line.run, min(reach, MAX_ARM_SHARE * line.length))), MIN_ARM_POINTS))
        )
    return cuts


def _junctions(tree: Tree, surface: np.ndarray, parents: list[int]) -> list[_Junction]:
    if not parents:
        return []
    nearest = cKDTree(tree.line.points).query(surface)[1]
    begins = np.cumsum([0, *map(len, tree.lines)])
    junctions = []
    for row in parents:
        rows = [row, *tree.daughters(row).tolist()]
        cuts, in_arms = _cuts(tree, rows), np.zeros(begins[-1], dtype=bool)
        for vessel, cut in zip(rows, cuts, strict=True):
            in_arms[begins[vessel] : begins[vessel + 1]][cut] = True
        arms = tuple(tree.lines[vessel][cut] for vessel, cut in zip(rows, cuts, strict=True))
        junctions.append(
            _Junction(rows, cuts, _Evidence(arms, tree.lines[row].typical_radius, surface[in_arms[nearest]]))
        )
    return junctions


def _fit(evidence: _Evidence, spacing: float, roughness: float) -> _Fit:
    """Return what the fits of a junction say of it."""
    fits = _fits(evidence, spacing, roughness)
    misfit = np.array([misfit for _, misfit in fits])
    best = int(np.argmin(misfit)) if misfit.min() < MOVED_MISFIT_SHARE * misfit[0] else 0
    likely = np.exp(-(misfit / max(misfit[best], 1e-12) - 1) / MISFIT_SCALE)
    likely /= likely.sum()
    lengths = np.array([[arm.length for arm in tree.lines] for tree, _ in fits])
    places = np.array([_place(tree) for tree, _ in fits])
    unseen = (UNSEEN * evidence.radius) ** 2
    length_sd = np.sqrt(likely @ (lengths - lengths[best]) ** 2 + unseen)
    place_sd = float(np.sqrt(likely @ ((places - places[best]) ** 2).sum(axis=1) + unseen))
    return _Fit(length_sd, place_sd, fits[best][0].lines if best else None)


def _fits(evidence: _Evidence, spacing: float, roughness: float) -> list[tuple[Tree, float]]:
    """Return the fits of a junction's arms, that from where they meet now first, and their misfits.

    What is far from the surface after a few rounds, or at the place of another, is not followed to its end.
    """
    starts = _starts(evidence.arms)
    begun = fitted_apart(starts, [evidence.surface] * len(starts), spacing, roughness, rounds=FIRST_ROUNDS)
    min_misfit, min_gap = min(misfit for _, misfit in begun), MIN_GAP_RADII * evidence.radius
    followed = begun[:1]
    for tree, misfit in sorted(begun[1:], key=lambda fit: fit[1]):
        gap = min(np.linalg.norm(_place(tree) - _place(rival)) for rival, _ in followed)
        if misfit < MAX_MISFIT_RATIO * min_misfit and gap > min_gap:
            followed.append((tree, misfit))
    return fitted_apart([tree for tree, _ in followed], [evidence.surface] * len(followed), spacing, roughness, 1.0)


def _place(tree: Tree) -> np.ndarray:
    """Return where the arms of a junction meet."""
    return np.asarray(tree.lines[0].points[-1])


def _starts(arms: tuple[Line, ...]) -> list[Tree]:
    """Return the arms as they are, with their junction nearer to the root, and farther along each daughter."""
    radius, parent = arms[0].typical_radius, np.append(-1, np.zeros(len(arms) - 1, dtype=int))
    later = (_later(arms, daughter, radius) for daughter in range(1, len(arms)))
    return [Tree(start, parent) for start in (arms, _earlier(arms, radius), *later)]


def _earlier(arms: tuple[Line, ...], radius: float) -> tuple[Line, ...]:
    """Return the arms with their junction nearer to the root: the daughters share the stretch beyond."""
    parent = arms[0]
    back = min(AWAY * radius, MAX_START_SHARE * parent.length)
    point = max(int(np.searchsorted(parent.run, parent.length - back)), 1)
    return parent[: point + 1], *(parent[point:-1].then(arm) for arm in arms[1:])


def _later(arms: tuple[Line, ...], daughter: int, radius: float) -> tuple[Line, ...]:
    """Return the arms with their junction farther along the `daughter`, to which its sisters lead."""
    along = arms[daughter]
    point = min(
        max(int(np.searchsorted(along.run, min(AWAY * radius, MAX_START_SHARE * along.length))), 1), len(along) - 3
    )
    shared = along[: point + 1]
    moved = [arms[0][:-1].then(shared)]
    for row, arm in enumerate(arms[1:], 1):
        moved.append(arm[point:] if row == daughter else rerouted(arm, shared.points[-1], float(along.run[point])))
    return tuple(moved)


def rerouted(arm: Line, junction: np.ndarray, within: float) -> Line:
    """Return `arm` from `junction` on, straight to where it leaves the ball `within`, at most half its length."""
    remainder = arm[arm.run >= min(within, 0.5 * arm.length)]
    count = max(2, int(np.linalg.norm(remainder.points[0] - junction) / max(arm.run[1], 1e-9)))
    detour = np.linspace(junction, remainder.points[0], count, endpoint=False)
    return Line(detour, np.linspace(within, remainder.radius[0], count, endpoint=False)).then(remainder)


def _put(lines: list[list[Line]], tree: Tree, junction: _Junction, arms: tuple[Line, ...]) -> None:
    """Put the arms of a junction into its vessels: the line that counts at a vessel's begin, and that at its end."""
    (row, *daughters), (cut, *daughter_cuts) = junction.rows, junction.cuts
    lines[row][1] = tree.lines[row][: cut.start].then(arms[0])
    for daughter, daughter_cut, arm in zip(daughters, daughter_cuts, arms[1:], strict=True):
        lines[daughter][0] = arm.then(tree.lines[daughter][daughter_cut.stop :])


def _halves(begin: Line, end: Line) -> Line:
    """Return the first half of one line of a vessel and, from there, the rest of the other."""
    if begin is end:
        return begin
    middle = int(np.searchsorted(begin.run, begin.length / 2))
    split = int(np.linalg.norm(end.points - begin.points[middle], axis=1).argmin()) + 1
    return begin[: middle + 1].then(end[min(split, len(end) - 1) :])
