"""From a lumen to the vessels in it: which there are, and where their axes run."""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from vasowave.imaging.axes.ends import with_ends_at_half_grey, with_ends_at_the_surface
from vasowave.imaging.axes.junctions import (
    with_earlier_junctions,
    with_later_junctions,
    with_met_axes,
    without_short_vessels,
)
from vasowave.imaging.axes.paths import MinimalPaths, long_tips, minimal_paths, outlet_tips, paths_to
from vasowave.imaging.axes.protrusions import tips_outside
from vasowave.imaging.axes.skeleton import cut_at_junctions
from vasowave.imaging.axes.tubes import fitted, misfit_around
from vasowave.imaging.lumen.segmentation import Segmentation
from vasowave.imaging.lumen.surface import surface_points
from vasowave.imaging.tree import Line, Tree, with_inscribed_radii

ROUNDS = 8
"""Automatic mode looks at most so often for vessels that stick out of the tubes of those found."""
AROUND, AS_WELL = 4.0, 1.3
"""Two fits are as good around a junction, within so many radii, if their misfits differ by at most this factor: two
places that the image does not decide between differ by a twentieth, a fit that went astray doubles the misfit."""
BETTER = 0.6
"""A junction is moved where that brings the misfit below this share of what it was: a fit that had gone astray
leaves 0.3 to 0.5, one that goes astray itself may leave 0.8 where vessels are not round."""


def tree_of(lumen: Segmentation, root: np.ndarray, outlets: np.ndarray | None = None) -> Tree:
    """Return the vessels of `lumen`, the cannula being part of the root.

    Parameters
    ----------
    lumen : Segmentation
    root : float array, shape (3,)
        A point in or at the lumen where the blood enters (z, y, x, cm).
    outlets : float array, shape (outlet, 3), optional
        Guided mode: one path to each of these and no other; without them the tips are found (automatic mode).

    Raises
    ------
    InputError
        The root or an outlet farther than 5 voxels from the lumen, an outlet on the way to another; each is named.
    """
    ways = minimal_paths(lumen, root)
    if outlets is None:
        tree = _straight_ended(_to_surface(ways, _tips(ways)), ways)
    else:
        tree = _to_surface(ways, outlet_tips(ways, outlets))
    # A junction that the paths put many voxels too far is not brought back by one fit.
    tree = _refitted(tree, lumen, ways.surface)
    whole = without_short_vessels(tree)
    tree = tree if len(whole) == len(tree) else _refitted(whole, lumen, ways.surface)
    return _with_better_junctions(tree, lumen, ways.surface)


def in_another_lumen(tree: Tree, lumen: Segmentation) -> Tree:
    """Return the vessels of `tree` with their axes and radii in `lumen`, that of another threshold."""
    return _refitted(tree, lumen, surface_points(lumen))


def begun_elsewhere(tree: Tree, lumen: Segmentation, surface: np.ndarray) -> Tree:
    """Return the vessels of `tree`, fitted anew from junctions that begin elsewhere, see `with_earlier_junctions`.

    Where the surface decides where vessels meet, they meet there again. Where daughters run on side by side before
    they part, the fit may settle in either of two places that fit the surface as well, and the image does not say
    which. At a junction that fits worse, all its vessels stay as they are.

    Parameters
    ----------
    tree : Tree
    lumen : Segmentation
    surface : float array, shape (corner, 3)
        Points of the surface of `lumen`, cm.
    """
    again = _begun(with_earlier_junctions(tree), lumen, surface)
    return _joined(tree, again, _fits(again, tree, surface, lumen.spacing) <= AS_WELL)


def _with_better_junctions(tree: Tree, lumen: Segmentation, surface: np.ndarray) -> Tree:
    """Return `tree` with those junctions later that fit the surface clearly better there.

    Where vessels bend within two radii, or run on side by side, a fit that begins too early may stay there.
    """
    again = _begun(with_later_junctions(tree), lumen, surface)
    better = _fits(again, tree, surface, lumen.spacing) < BETTER
    return _refitted(_joined(tree, again, better), lumen, surface) if better.any() else tree


def _begun(tree: Tree, lumen: Segmentation, surface: np.ndarray) -> Tree:
    return _refitted(fitted(tree, surface, lumen.spacing, lumen.roughness), lumen, surface)


def _joined(tree: Tree, again: Tree, taken: np.ndarray) -> Tree:
    """Return `tree` with the vessels of `again` around the junctions at the ends of the vessels in `taken`."""
    lines = []
    for row, (old, new) in enumerate(zip(tree.lines, again.lines, strict=True)):
        begin = taken[row if row == 0 else int(tree.parent[row])]
        end = begin if row in tree.terminals else taken[row]
        lines.append(_halves(new if begin else old, new if end else old))
    return tree.with_lines(lines)


def _halves(begin: Line, end: Line) -> Line:
    """Return the first half of one line of a vessel and, from there, the rest of the other."""
    if begin is end:
        return begin
    middle = int(np.searchsorted(begin.run, begin.length / 2))
    there = int(np.linalg.norm(end.points - begin.points[middle], axis=1).argmin()) + 1
    return begin[: middle + 1].then(end[min(there, len(end) - 1) :])


def _fits(again: Tree, tree: Tree, surface: np.ndarray, spacing: float) -> np.ndarray:
    """Return the misfit of `again` over that of `tree` around the end of each vessel; 1 at terminals."""
    ratio = np.ones(len(tree))
    for row in np.setdiff1d(np.arange(len(tree)), tree.terminals).tolist():
        line = tree.lines[row]
        where = spacing, line.points[-1], AROUND * line.typical_radius
        ratio[row] = misfit_around(again, surface, *where) / max(misfit_around(tree, surface, *where), 1e-12)
    return ratio


def _refitted(tree: Tree, lumen: Segmentation, surface: np.ndarray) -> Tree:
    again = with_ends_at_the_surface(fitted(tree, surface, lumen.spacing, lumen.roughness), surface)
    return with_ends_at_half_grey(again, lumen)


def _tips(ways: MinimalPaths) -> list[int]:
    """Return the tips of all vessels: the long ones, then what sticks out of their tubes, until nothing does."""
    tips = long_tips(ways)
    for _ in range(ROUNDS):
        more = tips_outside(_to_surface(ways, tips), ways)
        if not more:
            break
        tips += more
    return tips


def _straight_ended(tree: Tree, ways: MinimalPaths) -> Tree:
    """Return the vessels with paths drawn anew to where the axes of `tree` meet the surface.

    The tips are the farthest corners of flat ends, and a path to a corner leaves the axis early.
    """
    ends = np.array([tree.lines[row].points[-1] for row in tree.terminals])
    again = _to_surface(ways, sorted(set(cKDTree(ways.points).query(ends)[1].tolist())))
    return again if len(again) == len(tree) else tree


def _to_surface(ways: MinimalPaths, tips: Sequence[int]) -> Tree:
    """Return the vessels on the minimal paths to `tips`, their axes fitted to the surface and ending there."""
    rough = with_met_axes(without_stairs(cut_at_junctions(paths_to(ways, tips)), ways.surface, ways.spacing))
    return with_ends_at_the_surface(fitted(rough, ways.surface, ways.spacing, ways.roughness), ways.surface)


def without_stairs(tree: Tree, surface: np.ndarray, spacing: float) -> Tree:
    """Return `tree` smoothed over three points at equal steps of about a voxel, inscribed radii measured anew."""
    return with_inscribed_radii([_smoothed(line, spacing) for line in tree.lines], tree.parent, surface)


def _smoothed(line: Line, spacing: float) -> np.ndarray:
    """Return the points of `line` at equal steps of about a voxel, without stairs; its ends stay."""
    at = np.linspace(0, line.length, max(round(line.length / spacing), 3) + 1)
    points = np.stack([np.interp(at, line.run, line.points[:, k]) for k in range(3)], axis=1)
    straight = np.linspace(points[0], points[-1], len(points))
    middle = straight + gaussian_filter1d(points - straight, min(3.0, len(points) / 6), axis=0, mode="mirror")
    middle[[0, -1]] = points[[0, -1]]
    return middle
