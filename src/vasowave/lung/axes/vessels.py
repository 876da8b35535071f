"""From a lumen to the vessels in it: which there are, and where their axes run."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from vasowave.lung.axes.junctions import (
    with_ends_at_half_grey,
    with_ends_at_the_surface,
    with_met_axes,
    without_short_vessels,
)
from vasowave.lung.axes.paths import (
    MinimalPaths,
    long_tips,
    minimal_paths,
    outlet_tips,
    paths_to,
    require_slender,
    without_horns,
)
from vasowave.lung.axes.protrusions import tips_outside
from vasowave.lung.axes.skeleton import cut_at_junctions
from vasowave.lung.axes.starts import Settled, settled
from vasowave.lung.axes.tubes import fitted
from vasowave.lung.lumen.segmentation import Segmentation
from vasowave.lung.lumen.surface import surface_points
from vasowave.lung.tree import Line, Tree, with_inscribed_radii

ROUNDS = 8
"""Automatic mode looks at most so often for vessels that stick out of the tubes of those found."""


def tree_of(lumen: Segmentation, root: np.ndarray, outlets: np.ndarray | None = None) -> Settled:
    """Return the vessels of `lumen`, the cannula being part of the root, and what of their lengths is left open.

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
        Without outlets, a lumen most of whose ends are edges of plates.
    """
    paths = minimal_paths(lumen, root)
    if outlets is None:
        tree = _straight_ended(_to_surface(paths, _tips(paths)), paths)
    else:
        tree = _to_surface(paths, outlet_tips(paths, outlets))
    collapsed = without_short_vessels(tree)
    if len(collapsed) < len(tree):
        tree = without_short_vessels(fitted(collapsed, paths.surface, lumen.spacing, lumen.roughness))
    settled_tree = settled(tree, paths.surface, lumen.spacing, lumen.roughness)
    return replace(settled_tree, tree=_refitted(settled_tree.tree, lumen, paths.surface))


def in_another_lumen(tree: Tree, lumen: Segmentation) -> Tree:
    """Return the vessels of `tree` with their axes and radii in `lumen`, that of another threshold."""
    return _refitted(tree, lumen, surface_points(lumen))


def _refitted(tree: Tree, lumen: Segmentation, surface: np.ndarray) -> Tree:
    again = with_ends_at_the_surface(fitted(tree, surface, lumen.spacing, lumen.roughness, begin=1.0), surface)
    return with_ends_at_half_grey(again, lumen)


def _tips(paths: MinimalPaths) -> list[int]:
    """Return the tips of all vessels: the long ones, then what sticks out of their tubes, until nothing does."""
    tips = long_tips(paths)
    require_slender(paths, tips)
    tips = without_horns(paths, tips)
    for _ in range(ROUNDS):
        new_tips = tips_outside(_to_surface(paths, tips), paths)
        if not new_tips:
            break
        tips += new_tips
    return tips


def _straight_ended(tree: Tree, paths: MinimalPaths) -> Tree:
    """Return the vessels with paths drawn anew to where the axes of `tree` meet the surface.

    The tips are the farthest corners of flat ends, and a path to a corner leaves the axis early.
    """
    ends = np.array([tree.lines[row].points[-1] for row in tree.terminals])
    again = _to_surface(paths, sorted(set(cKDTree(paths.points).query(ends)[1].tolist())))
    return again if len(again) == len(tree) else tree


def _to_surface(paths: MinimalPaths, tips: Sequence[int]) -> Tree:
    """Return the vessels on the minimal paths to `tips`, their axes fitted to the surface and ending there."""
    rough = with_met_axes(without_stairs(cut_at_junctions(paths_to(paths, tips)), paths.surface, paths.spacing))
    return with_ends_at_the_surface(fitted(rough, paths.surface, paths.spacing, paths.roughness), paths.surface)


def without_stairs(tree: Tree, surface: np.ndarray, spacing: float) -> Tree:
    """Return `tree` smoothed over three points at equal steps of about a voxel, inscribed radii measured anew."""
    return with_inscribed_radii([_smoothed(line, spacing) for line in tree.lines], tree.parent, surface)


def _smoothed(line: Line, spacing: float) -> np.ndarray:
    """Return the points of `line` at equal steps of about a voxel, without stairs; its ends stay."""
    run = np.linspace(0, line.length, max(round(line.length / spacing), 3) + 1)
    points = line.at(run).points
    straight = np.linspace(points[0], points[-1], len(points))
    middle = straight + gaussian_filter1d(points - straight, min(3.0, len(points) / 6), axis=0, mode="mirror")
    middle[[0, -1]] = points[[0, -1]]
    return middle
