"""Where vessels meet: the least-squares meeting point of their axes, not where their paths part."""

import numpy as np

from vasowave.imaging.axes.skeleton import shortest
from vasowave.imaging.axes.stretches import clear_stretches
from vasowave.imaging.tree import Line, Tree

REACH = 2.5
"""An axis is fitted over so many junction radii: farther out, a vessel's curvature misleads."""
ELSEWHERE, MOST = 1.5, 0.4
"""`with_earlier_junctions` ends a vessel so many of its radii before its end, at most this share of its length;
`with_later_junctions` so many beyond, at most this share of its shortest daughter's length."""


def with_met_axes(tree: Tree) -> Tree:
    """Return `tree` with every junction moved to the meeting point of the axes of its vessels.

    An axis is fitted where its vessel has left the junction's ball and its sisters' tubes; the vessels run straight
    from the ball to the new junction. A junction keeps its place where fewer than two vessels are long enough or the
    move would exceed 2.5 radii.
    """
    lines = list(tree.lines)
    for row in range(len(lines)):
        daughters = tree.daughters(row)
        if len(daughters) == 0:
            continue
        clear = clear_stretches(tree.with_lines(lines))
        radius, length = float(lines[row].radius[-1]), lines[row].length
        arms = [lines[row][::-1], *(lines[d] for d in daughters)]
        stretches = [(length - clear[row][1], length - clear[row][0]), *(clear[d] for d in daughters)]
        meeting = _meeting_point(arms, stretches, radius)
        if meeting is None:
            continue
        lines[row] = _rerouted(arms[0], meeting, radius)[::-1]
        for daughter, arm in zip(daughters, arms[1:], strict=True):
            lines[daughter] = _rerouted(arm, meeting, radius)
    return tree.with_lines(lines)


def with_earlier_junctions(tree: Tree) -> Tree:
    """Return `tree` with every junction 1.5 radii nearer to the root: its daughters share the stretch beyond."""
    lines = list(tree.lines)
    for row, line in enumerate(tree.lines):
        daughters = tree.daughters(row)
        if len(daughters) == 0:
            continue
        back = min(ELSEWHERE * line.typical_radius, MOST * line.length)
        # A vessel's first point may have moved already: its end, at which all is measured, has not.
        point = int(np.searchsorted(lines[row].run, lines[row].length - back))
        shared = lines[row][point:-1]
        lines[row] = lines[row][: point + 1]
        for daughter in daughters:
            lines[daughter] = shared.then(lines[daughter])
    return tree.with_lines(lines)


def with_later_junctions(tree: Tree) -> Tree:
    """Return `tree` with every junction 1.5 radii farther from the root, on the axis of its widest daughter."""
    lines = list(tree.lines)
    for row, line in enumerate(tree.lines):
        daughters = tree.daughters(row).tolist()
        if not daughters:
            continue
        widest = max(daughters, key=lambda one: tree.lines[one].typical_radius)
        ahead = min(ELSEWHERE * line.typical_radius, *(MOST * tree.lines[one].length for one in daughters))
        point = int(np.searchsorted(lines[widest].run, ahead))
        shared, lines[widest] = lines[widest][: point + 1], lines[widest][point:]
        lines[row] = lines[row][:-1].then(shared)
        for daughter in daughters:
            if daughter != widest:
                lines[daughter] = _rerouted(lines[daughter], shared.points[-1], ahead)
    return tree.with_lines(lines)


def without_short_vessels(tree: Tree, collapse: float = 0.6) -> Tree:
    """Return `tree` without inner vessels shorter than `collapse` radii + the point distance: see `cut_at_junctions`.

    Paths part late, and only fitted axes show how near to one another two junctions are.
    """
    for row in range(len(tree)):
        inner = tree.parent[row] >= 0 and len(tree.daughters(row)) > 0
        if inner and tree.lines[row].length < shortest(tree.lines[row], collapse):
            return without_short_vessels(tree.merged(row), collapse)
    return tree


def _meeting_point(arms: list[Line], stretches: list[tuple[float, float]], radius: float) -> np.ndarray | None:
    """Return the point nearest to the axes of `arms`, which all begin at the junction; None if undetermined."""
    matrix, right, used = np.zeros((3, 3)), np.zeros(3), 0
    for arm, (begin, end) in zip(arms, stretches, strict=True):
        begin = max(begin, radius)
        straight = arm.points[(arm.run > begin) & (arm.run < min(begin + REACH * radius, end))]
        if len(straight) < 4:
            continue
        middle = straight.mean(axis=0)
        axis = np.linalg.svd(straight - middle, full_matrices=False)[2][0]
        across = np.eye(3) - np.outer(axis, axis)
        matrix, right, used = matrix + across, right + across @ middle, used + 1
    if used < 2 or np.linalg.cond(matrix) > 100:
        return None
    meeting = np.linalg.solve(matrix, right)
    return meeting if np.linalg.norm(meeting - arms[0].points[0]) < 2.5 * radius else None


def _rerouted(arm: Line, junction: np.ndarray, within: float) -> Line:
    """Return `arm` from `junction` on, straight to where it leaves the ball `within`, at most half its length."""
    kept = arm[arm.run >= min(within, 0.5 * arm.length)]
    count = max(2, int(np.linalg.norm(kept.points[0] - junction) / max(arm.run[1], 1e-9)))
    way = np.linspace(junction, kept.points[0], count, endpoint=False)
    return Line(way, np.linspace(within, kept.radius[0], count, endpoint=False)).then(kept)
