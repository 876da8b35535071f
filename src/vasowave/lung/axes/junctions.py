"""Where vessels meet, at the least-squares meeting point of their axes, and where terminals end, on the surface."""

import numpy as np

from vasowave.lung.axes.skeleton import shortest
from vasowave.lung.axes.starts import rerouted
from vasowave.lung.kernels import ahead_of
from vasowave.lung.lumen.segmentation import Segmentation
from vasowave.lung.sections import STEP, across, disc, sampled
from vasowave.lung.tree import Line, Tree, clear_stretch, free_stretch

REACH = 2.5
"""An axis is fitted over so many junction radii: farther out, a vessel's curvature misleads."""
MAX_MOVE_VOXELS = 2.0
"""An end moves by at most so many voxels from the surface."""
PLATEAU = 1.5, 3.0
"""The vessel's own grey is that on its axis so many voxels before its end; in wide vessels to 1.5 radii before it."""


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
            vessel: clear_stretch(now, vessel, free_stretch(lines[vessel], vessel in tree.terminals))
            for vessel in (row, *daughters)
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


def with_ends_at_the_surface(tree: Tree, surface: np.ndarray) -> Tree:
    """Return `tree` with the last radius of every terminal replaced by its axis, prolonged to the surface.

    Within a radius of a blind end a center path turns to its farthest corner. The end is the median of the
    surface's points (cm, shape (corner, 3)) ahead that lie within half a radius of the axis; a terminal without such
    points keeps its end.
    """
    lines = list(tree.lines)
    for row in tree.terminals:
        lines[row] = to_the_surface(lines[row], surface)
    return tree.with_lines(lines)


def to_the_surface(line: Line, surface: np.ndarray) -> Line:
    """Return `line` with its last radius replaced by its axis, prolonged to the `surface`."""
    run = line.run
    radius = float(np.median(line.radius[run > 0.5 * run[-1]]))
    stem = line[run <= max(run[-1] - radius, 0.5 * run[-1])]
    straight = stem.points[run[: len(stem)] >= run[len(stem) - 1] - 2.5 * radius]
    if len(straight) < 3:
        return line
    axis = np.linalg.svd(straight - straight.mean(axis=0), full_matrices=False)[2][0]
    axis *= np.sign(axis @ (straight[-1] - straight[0]))
    cap = ahead_of(surface, stem.points[-1], axis, 3 * radius, 0.5 * radius)
    if len(cap) < 3:
        return line
    extension = float(np.median(cap))
    steps = max(2, round(extension / (run[-1] / (len(run) - 1))))
    along = np.linspace(0, extension, steps + 1)[1:]
    added = stem.points[-1] + along[:, None] * axis
    return stem.then(Line(added, np.minimum(stem.radius[-1], extension - along)))


def with_ends_at_half_grey(tree: Tree, lumen: Segmentation) -> Tree:
    """Return `tree` with every terminal's end moved along its axis to where the grey falls to half the vessel's own.

    Its ends lie at the surface before. Blur takes the axis of a thin vessel far below the lumen's grey, so that its
    surface at a fixed threshold lies inside of its end; half of what the vessel itself shows above the background does
    not know blur nor threshold.
    """
    lines = list(tree.lines)
    for row in tree.terminals:
        lines[row] = _half_grey(lines[row], lumen)
    return tree.with_lines(lines)


def _half_grey(line: Line, lumen: Segmentation) -> Line:
    """Return `line` shortened or prolonged by at most MAX_MOVE_VOXELS."""
    run, radius = line.run, float(np.median(line.radius[len(line) // 2 :]))
    axis = line.points[-1] - line.points[np.searchsorted(run, run[-1] - radius) - 1]
    axis /= np.linalg.norm(axis)
    (u,), (v,) = across(axis[None])
    grid = disc(0.5 * radius, STEP * lumen.spacing)
    full = PLATEAU[0], max(PLATEAU[1], 1.5 * radius / lumen.spacing)
    offsets = np.arange(-full[1], MAX_MOVE_VOXELS + 0.05, 0.1)
    centers = line.points[-1] + offsets[:, None] * lumen.spacing * axis
    places = centers[:, None] + grid[:, :1] * u + grid[:, 1:] * v
    profile = sampled(lumen.grey, places, lumen.origin, lumen.spacing).mean(axis=1)
    half = (np.median(profile[offsets <= -full[0]]) + lumen.background) / 2
    falls = np.flatnonzero((profile[:-1] >= half) & (profile[1:] < half) & (offsets[:-1] >= -MAX_MOVE_VOXELS))
    if len(falls) == 0:
        return line
    move = float(offsets[falls[np.argmin(np.abs(offsets[falls]))]]) * lumen.spacing
    end = Line(line.points[-1:] + move * axis, line.radius[-1:])
    return line[run < run[-1] + move].then(end)
