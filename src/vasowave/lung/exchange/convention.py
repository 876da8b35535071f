"""Lines of other programs by the convention of an extraction: vessels meet where their axes do, and end at the wall.

Other programs let lines run side by side before they share points, cut them where tubes part, and end them a ball's
radius before the wall. Here the tubes of an extraction are fitted to the surface that the lines were drawn in or,
without one, to that of the balls along them.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from vasowave.base.errors import InputError
from vasowave.lung.axes.junctions import (
    to_the_surface,
    with_ends_at_the_surface,
    with_met_axes,
    without_short_vessels,
)
from vasowave.lung.axes.starts import settled
from vasowave.lung.axes.tubes import fitted
from vasowave.lung.sections import across, tangents
from vasowave.lung.tree import Line, Tree

Ends = Literal["auto", "ball", "wall"]

VOXELS_PER_RADIUS = 3.0
"""The fit's voxel without an image: so many in a vessel's median radius."""
RING_POINTS, RING_STEP_RADII = 16, 0.4
"""Points of a ball's ring, and the distance of rings, radii."""
COVERED_SHARE = 0.97
"""What lies within this share of another ball's radius is no surface."""
TOUCHING_TOLERANCE, LAST_STEP_RATIO, THIN_END_SHARE, STEP_SCATTER_SHARE, SMOOTH_RADIUS_SHARE = 0.02, 1.3, 0.5, 0.5, 1e-4
"""How the end of a line is told: a last step that is its ball's radius, within the first share, and the second number
times as long as the others, leads to the wall, in one piece or in several (`CAP_STEP`); a line thinner there than the
third share of its vessel ends at the wall; steps that scatter by the fourth share of their mean are those of a Voronoi
diagram, whose last ball touches the wall; radii that run smooth within the fifth were drawn, and no ball was laid into
a surface."""


@dataclass(frozen=True)
class CapStepRules:
    """How the last stretch of a line is known for one step from a ball to the cap that was cut into pieces.

    Attributes
    ----------
    shortest : float
        Its length that must lie on whole pieces, radii: a ball between two points hides the rest.
    whole : float
        Its length with the piece in which the ball lies, radii; less than 1, as caps are not flat.
    straight : float
        How far points may lie beside it, share of its length; radii change evenly within `SMOOTH_RADIUS_SHARE`.
    """

    shortest: float = 0.45
    whole: float = 0.9
    straight: float = 2e-3


CAP_STEP = CapStepRules()
PLACE_SD_RADII = 0.14
"""SD of a junction's place without the surface, radii, besides what the fits show."""
RADIUS_STEP, STEPPED_SD_RADII = 0.05, 0.5
"""Radii of balls in a surface differ by no more than their distance; where they step by RADIUS_STEP radii more, they
were drawn, and the balls show no junction: SD of its place, radii."""
PLACE_SD_STEPS = 0.3
"""SD of a junction's place where points lie far apart and no surface is given, mean distances of points."""
END_SD_RADII = 0.15
"""SD of an end whose place is known, radii of its ball."""
ENDS = 0.3
"""SD of an end at a surface, voxels of the fit."""


class Alike(NamedTuple):
    """A tree by the convention of an extraction.

    Attributes
    ----------
    tree : Tree
    length_sd : float array, shape (vessel,)
        How much its lengths are left open, cm: by where the fit begins, and by where lines end.
    """

    tree: Tree
    length_sd: np.ndarray


def as_extracted(tree: Tree, surface: np.ndarray | None = None, ends: Ends = "auto", collapse: float = 0.6) -> Alike:
    """Return `tree` with its junctions where the axes of its vessels meet, and its ends at the wall; its radii stay.

    Parameters
    ----------
    tree : Tree
        Cut anywhere near its junctions.
    surface : float array, shape (corner, 3), optional
        Points of the surface that the lines were drawn in, z, y, x, cm.
    ends : "auto", "ball" or "wall"
        Whether lines end where a ball touches the wall (VMTK, Slicer) or at the wall; "auto" looks at each end, and
        takes the middle where it cannot tell.
    collapse : float
        Inner vessels shorter than so many radii, before or after the fit, become one junction, as in an extraction.

    Raises
    ------
    InputError
        A vessel without length.
    """
    if min(line.length for line in tree.lines) <= 0:
        raise InputError("a vessel without length: two junctions, or an end, lie at the same place; repair the lines")
    longer, end_sd = _to_the_wall(without_short_vessels(tree, collapse), ends)
    spacing = float(np.median([line.typical_radius for line in longer.lines])) / VOXELS_PER_RADIUS
    points = _ball_surface(longer) if surface is None else surface
    first = fitted(with_met_axes(_even(longer, spacing)), points, spacing)
    collapsed = without_short_vessels(first, collapse)
    if len(collapsed) < len(first):
        end_sd = end_sd[[any(line is remaining for remaining in collapsed.lines) for line in first.lines]]
        first = fitted(collapsed, points, spacing)
    settled_tree = settled(first, points, spacing)
    first = settled_tree.tree
    if surface is not None:
        first = _ending_at(first, surface)
        end_sd = np.where(_at(first, surface), ENDS * spacing, end_sd)
    nearest = cKDTree(longer.line.points)  # the radii are the file's: a surface may be coarser than they are
    lines = [Line(line.points, longer.line.radius[nearest.query(line.points)[1]]) for line in first.lines]
    again = first.with_lines(lines)
    place = np.zeros(len(again))
    if surface is None:
        share = STEPPED_SD_RADII if _stepped(tree) else PLACE_SD_RADII
        step = float(np.mean([np.median(np.diff(line.run)) for line in tree.lines]))
        place = np.hypot(share * _junction_radius(again), PLACE_SD_STEPS * step)
    return Alike(again, np.sqrt(settled_tree.open_sd**2 + place**2 + end_sd**2))


def _stepped(tree: Tree) -> bool:
    """Return whether radii step where vessels meet, as those that were drawn do and those of balls cannot."""
    for row, parent in enumerate(tree.parent.tolist()):
        if parent >= 0:
            passage = tree.lines[parent][-3:].then(tree.lines[row][:3])
            excess = np.abs(np.diff(passage.radius)) - np.linalg.norm(np.diff(passage.points, axis=0), axis=1)
            if excess.max() > RADIUS_STEP * passage.radius.max():
                return True
    return False


def _to_the_wall(tree: Tree, ends: Ends) -> tuple[Tree, np.ndarray]:
    """Return `tree` with root and terminals prolonged to the wall, and the SD of their ends, cm, shape (vessel,)."""
    lines, variance = list(tree.lines), np.zeros(len(tree))
    for row, back in [(tree.root, True), *((row, False) for row in tree.terminals)]:
        line = lines[row][::-1] if back else lines[row]
        share, sd = _missing(line, ends)
        variance[row] += (sd * line.radius[-1]) ** 2
        line = _prolonged(line, share * float(line.radius[-1]))
        lines[row] = line[::-1] if back else line
    return tree.with_lines(lines), np.sqrt(variance)


def _missing(line: Line, ends: Ends) -> tuple[float, float]:
    """Return how much of its last ball's radius a line lacks to the wall, and the SD of that."""
    step = np.diff(line.run)
    unlike = len(step) < 3 or step[-1] > LAST_STEP_RATIO * np.median(step[:-1])
    touching = unlike and abs(step[-1] / line.radius[-1] - 1) < TOUCHING_TOLERANCE
    if ends == "wall" or touching or line.radius[-1] < THIN_END_SHARE * line.typical_radius:
        return 0.0, END_SD_RADII
    if ends == "auto" and _steps_to_the_cap(line):
        return 0.0, END_SD_RADII
    last_steps, radius = step[len(step) // 2 :], line.radius[len(step) // 2 :]
    if ends == "auto" and len(radius) > 2 and np.abs(np.diff(radius, 2)).max() < SMOOTH_RADIUS_SHARE * radius.max():
        return 0.0, END_SD_RADII
    if ends == "ball" or last_steps.std() > STEP_SCATTER_SHARE * last_steps.mean():
        return 1.0, END_SD_RADII
    return 0.5, 1 / np.sqrt(12)


def _steps_to_the_cap(line: Line) -> bool:
    """Return whether the last pieces of a line are one straight step of a radius: points and radii in even change.

    Balls in a surface scatter from point to point; what was put between the last of them and the cap does not.
    """
    reverse, back = line[::-1], 2
    columns = np.column_stack([reverse.points, reverse.radius])
    while back < len(reverse):
        between = reverse.run[: back + 1, None] / max(float(reverse.run[back]), 1e-12)
        deviation = np.abs(columns[: back + 1] - columns[0] - between * (columns[back] - columns[0])).max(axis=0)
        if (
            deviation[:3].max() > CAP_STEP.straight * reverse.run[back]
            or deviation[3] > SMOOTH_RADIUS_SHARE * reverse.radius[0]
        ):
            break
        back += 1
    last = back - 1
    pieces = last >= 2 and reverse.run[last] >= CAP_STEP.shortest * reverse.radius[0]
    return bool(pieces and reverse.run[min(back, len(reverse) - 1)] >= CAP_STEP.whole * reverse.radius[0])


def _prolonged(line: Line, extension: float) -> Line:
    """Return `line` prolonged by `extension`, in the direction of its last radius."""
    back = min(int(np.searchsorted(line.run, line.length - line.radius[-1])), len(line) - 2)
    along = line.points[-1] - line.points[back]
    end = line.points[-1:] + extension * along / max(float(np.linalg.norm(along)), 1e-12)
    return line.then(Line(end, line.radius[-1:])) if extension else line


def _even(tree: Tree, step: float) -> Tree:
    """Return `tree` with points at equal steps of about `step`, as the fit expects them."""
    return tree.with_lines([_at_steps(line, step) for line in tree.lines])


def _at_steps(line: Line, step: float) -> Line:
    return line.at(np.linspace(0, line.length, max(4, round(line.length / step)) + 1))


def _ball_surface(tree: Tree) -> np.ndarray:
    """Return points of the surface of all balls along the lines, shape (point, 3)."""
    angle = np.linspace(0, 2 * np.pi, RING_POINTS, endpoint=False)
    rings = []
    for line in tree.lines:
        balls = _at_steps(line, RING_STEP_RADII * line.typical_radius)
        along = tangents(balls.points, 1)
        along[np.linalg.norm(along, axis=1) < 0.5] = [0.0, 0.0, 1.0]  # where a line turns back on itself
        u, v = across(along)
        direction = np.cos(angle)[:, None] * u[:, None] + np.sin(angle)[:, None] * v[:, None]
        rings.append((balls.points[:, None] + balls.radius[:, None, None] * direction).reshape(-1, 3))
    points = np.concatenate(rings)
    outside = np.ones(len(points), dtype=bool)
    for line in tree.lines:
        balls = _at_steps(line, 0.25 * RING_STEP_RADII * line.typical_radius)
        reach = balls.radius.max()
        candidates = np.flatnonzero(
            ((points > balls.points.min(0) - reach) & (points < balls.points.max(0) + reach)).all(axis=1)
        )
        distance, nearest = cKDTree(balls.points).query(points[candidates])
        outside[candidates[distance < COVERED_SHARE * balls.radius[nearest]]] = False
    return points[outside]


def _ending_at(tree: Tree, surface: np.ndarray) -> Tree:
    """Return `tree` with the begin of its root and its ends on the `surface`, where it is closed there."""
    ended = with_ends_at_the_surface(tree, surface)
    root = to_the_surface(ended.lines[tree.root][::-1], surface)[::-1]
    return ended.with_lines([root if row == tree.root else line for row, line in enumerate(ended.lines)])


def _at(tree: Tree, surface: np.ndarray) -> np.ndarray:
    """Return whether each vessel's free ends lie on the `surface`, shape (vessel,); true for inner vessels."""
    index, on = cKDTree(surface), np.ones(len(tree), dtype=bool)
    for row, end in [(tree.root, 0), *((row, -1) for row in tree.terminals)]:
        line = tree.lines[row]
        on[row] &= bool(index.query(line.points[end])[0] < THIN_END_SHARE * line.typical_radius)
    return on


def _junction_radius(tree: Tree) -> np.ndarray:
    """Return the radius that a vessel's junctions are placed against: its parent's, and its own where it branches."""
    radius = np.array([line.typical_radius for line in tree.lines])
    begin = np.where(tree.parent >= 0, radius[tree.parent], 0.0)
    inner = np.isin(np.arange(len(tree)), tree.parent)
    return np.hypot(begin, np.where(inner, radius, 0.0))
