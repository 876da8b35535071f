"""Where vessels meet: the least-squares meeting point of their axes, not where their paths part."""

import numpy as np

from vasowave.imaging.axes.skeleton import shortest
from vasowave.imaging.axes.starts import rerouted
from vasowave.imaging.axes.stretches import clear_stretch, free_stretch
from vasowave.imaging.tree import Line, Tree

REACH = 2.5
"""An axis is fitted over so many junction radii: farther out, a vessel's curvature misleads."""


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
        now = tree.with_lines(lines)
        clear = {
            one: clear_stretch(now, one, free_stretch(lines[one], one in tree.terminals)) for one in (row, *daughters)
        }
        radius, length = float(lines[row].radius[-1]), lines[row].length
        arms = [lines[row][::-1], *(lines[d] for d in daughters)]
        stretches = [(length - clear[row][1], length - clear[row][0]), *(clear[d] for d in daughters)]
        meeting = _meeting_point(arms, stretches, radius)
        if meeting is None:
            continue
        lines[row] = rerouted(arms[0], meeting, radius)[::-1]
        for daughter, arm in zip(daughters, arms[1:], strict=True):
            lines[daughter] = rerouted(arm, meeting, radius)
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
