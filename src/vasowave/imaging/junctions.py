"""Where vessels meet: the least-squares meeting point of their axes, not where their paths part."""

from dataclasses import replace

import numpy as np

from vasowave.imaging.tree import Tree, clear_stretches, distance_along

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
        daughters = np.flatnonzero(tree.parent == row)
        if len(daughters) == 0:
            continue
        clear = clear_stretches(replace(tree, lines=tuple(lines)))
        radius, length = float(lines[row][-1, 3]), float(distance_along(lines[row])[-1])
        arms = [lines[row][::-1], *(lines[d] for d in daughters)]
        stretches = [(length - clear[row][1], length - clear[row][0]), *(clear[d] for d in daughters)]
        meeting = _meeting_point(arms, stretches, radius)
        if meeting is None:
            continue
        junction = np.append(meeting, radius)
        lines[row] = _rerouted(arms[0], junction, radius)[::-1]
        for daughter, arm in zip(daughters, arms[1:], strict=True):
            lines[daughter] = _rerouted(arm, junction, radius)
    return replace(tree, lines=tuple(lines))


def _meeting_point(arms: list[np.ndarray], stretches: list[tuple[float, float]], radius: float) -> np.ndarray | None:
    """Return the point nearest to the axes of `arms`, which all begin at the junction; None if undetermined."""
    matrix, right, used = np.zeros((3, 3)), np.zeros(3), 0
    for arm, (begin, end) in zip(arms, stretches, strict=True):
        run, begin = distance_along(arm), max(begin, radius)
        straight = arm[(run > begin) & (run < min(begin + REACH * radius, end)), :3]
        if len(straight) < 4:
            continue
        middle = straight.mean(axis=0)
        axis = np.linalg.svd(straight - middle, full_matrices=False)[2][0]
        across = np.eye(3) - np.outer(axis, axis)
        matrix, right, used = matrix + across, right + across @ middle, used + 1
    if used < 2 or np.linalg.cond(matrix) > 100:
        return None
    meeting = np.linalg.solve(matrix, right)
    return meeting if np.linalg.norm(meeting - arms[0][0, :3]) < 2.5 * radius else None


def _rerouted(arm: np.ndarray, junction: np.ndarray, within: float) -> np.ndarray:
    """Return `arm` from `junction` on, straight to where it leaves the ball `within`, at most half its length."""
    run = distance_along(arm)
    kept = arm[run >= min(within, 0.5 * run[-1])]
    count = max(2, int(np.linalg.norm(kept[0, :3] - junction[:3]) / max(run[1], 1e-9)))
    way = np.linspace(junction, kept[0], count, endpoint=False)
    return np.concatenate([way, kept])
