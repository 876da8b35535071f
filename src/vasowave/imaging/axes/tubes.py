"""Vessel axes to a fraction of a voxel: tubes that meet at their junctions, fitted together to the lumen's surface."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, eye_array
from scipy.sparse.linalg import spsolve

from vasowave.imaging.axes.feet import BEYOND, Feet, Tubes, feet_on, near_points
from vasowave.imaging.axes.stiffness import Differences, differences, strengths
from vasowave.imaging.tree import Line, Tree, distance_along, with_inscribed_radii

STEP, SHORTEST, PIECES = 0.4, 2.0, 4
"""Nodes of an axis lie STEP radii apart, at least SHORTEST voxels; a vessel has at least PIECES pieces."""
DENSITY = 62
"""So many points of the surface a node are enough; the rest is left out."""
OUTLIER, SHAPE = 0.5, 0.1
"""A point this far from all tubes, OUTLIER voxels + SHAPE radii, counts half: noise, fillets of junctions."""
NARROWEST = 0.5
"""Least radius, voxels."""
DAMPING = 0.3
"""Holds what the surface does not decide, as where along an axis its nodes lie; points of the surface a node."""
STIFF = 32.0
"""The fit begins so much stiffer and softens by half a round: a bend that a hidden stretch has first straightens."""
ROUNDS, ENOUGH, FARTHEST = 7, 0.05, 2.0
"""Soft, the fit ends after ROUNDS, or when no node moves by ENOUGH voxels; none moves farther than FARTHEST at once."""


def fitted(tree: Tree, surface: np.ndarray, spacing: float, roughness: float = 0.0, begin: float = STIFF) -> Tree:
    """Return `tree` with its axes where tubes around them fit the lumen's `surface` best, inscribed radii anew.

    All tubes are fitted at once, each point of the surface to the tube that it lies nearest to. What a vessel hides
    within a wider sister's tube has no surface: there its axis leads on along an arc to the junction, whose place
    all its vessels decide.

    Parameters
    ----------
    tree : Tree
        Without stairs.
    surface : float array, shape (corner, 3)
        Points of the lumen's surface, cm.
    spacing : float
        Voxel size, cm.
    roughness : float
        Noise over the contrast between wall and background: how much the surface may mislead.
    begin : float
        How much stiffer the fit begins; 1 where the axes are nearly right already.
    """
    tubes = _fitted(_tubes([tree], spacing), [surface / spacing], roughness, begin)
    axes = [_even(tubes.nodes[rows] * spacing, spacing) for rows in tubes.rows]
    return with_inscribed_radii(axes, tree.parent, surface)


def fitted_apart(
    trees: Sequence[Tree],
    surfaces: Sequence[np.ndarray],
    spacing: float,
    roughness: float,
    begin: float = STIFF,
    rounds: int = ROUNDS,
) -> list[tuple[Tree, float]]:
    """Return each of `trees` fitted to its own surface, with the radii of its tubes, and what the fit made small.

    That is, voxels², how far the surface lies from the tubes, of which a few outliers do not make much, and how much
    the tubes bend, which decides where vessels meet that hide one another. Many small trees together are fitted in a
    fraction of the time that each alone takes.

    Parameters
    ----------
    trees : sequence of Tree
    surfaces : sequence of float array, shape (corner, 3)
        Of each tree, cm.
    spacing, roughness, begin : float
        See `fitted`.
    rounds : int
        Of the soft fit.
    """
    points = [surface / spacing for surface in surfaces]
    tubes = _fitted(_tubes(trees, spacing), points, roughness, begin, rounds)
    misfits, found, first = _misfits(tubes, points, roughness), [], 0
    for tree, misfit in zip(trees, misfits.tolist(), strict=True):
        own = zip(tubes.rows[first : first + len(tree)], tubes.places[first:], strict=False)
        lines = [_tube_line(tubes.nodes[rows], tubes.radius[places], spacing) for rows, places in own]
        found.append((tree.with_lines(lines), misfit))
        first += len(tree)
    return found


def _fitted(
    tubes: Tubes, surfaces: Sequence[np.ndarray], roughness: float, begin: float, rounds: int = ROUNDS
) -> Tubes:
    """Return the tubes where they fit best, each tree to its own of the `surfaces` (voxels)."""
    kept = differences(tubes)
    stiff = begin / 2.0 ** np.arange(np.ceil(np.log2(begin)))
    for schedule, power in ((stiff, 1), (np.ones(rounds), 2)):
        points, near, _ = _thinned(tubes, surfaces)
        for stiffness in schedule:
            feet = feet_on(tubes, points, near)
            # Cauchy's weight finds the wall from far; Geman and McClure's keeps it, whatever bulges from it.
            weight = 1 / (1 + (2 ** (1 / power) - 1) * _outlying(tubes, feet) ** 2) ** power
            closer = _closer(tubes, feet, weight, kept, stiffness * strengths(tubes, feet, kept, roughness))
            moved = np.abs(closer.nodes - tubes.nodes).max()
            tubes = closer
            if moved < ENOUGH:
                break
    return tubes


def _thinned(tubes: Tubes, surfaces: Sequence[np.ndarray]) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
    """Return `DENSITY` points of the surfaces a node, which of them lie near each vessel, and the tree of each."""
    nodes = np.bincount(tubes.tree, [len(rows) for rows in tubes.rows])
    few = [points[:: max(1, int(len(points) / (DENSITY * n)))] for points, n in zip(surfaces, nodes, strict=True)]
    begins = np.cumsum([0, *map(len, few)])
    near = [begins[tree] + near_points(tubes, row, few[tree]) for row, tree in enumerate(tubes.tree)]
    return np.concatenate(few), near, np.repeat(np.arange(len(few)), np.diff(begins))


def _misfits(tubes: Tubes, surfaces: Sequence[np.ndarray], roughness: float) -> np.ndarray:
    """Return what the fit makes small of each tree; a point near no tube counts as one as far as `feet_on` looks."""
    points, near, owner = _thinned(tubes, surfaces)
    feet, kept = feet_on(tubes, points, near), differences(tubes)
    size = OUTLIER + SHAPE * tubes.radius[feet.places[:, 0]]
    gaps = np.bincount(tubes.tree[feet.vessel], _loss(feet.gap, size), len(surfaces))
    lost = np.bincount(owner[feet.lost], minlength=len(surfaces)) * _loss(BEYOND, OUTLIER)
    bending = strengths(tubes, feet, kept, roughness) * (kept.matrix @ tubes.state) ** 2
    return gaps + lost + np.bincount(tubes.tree[kept.vessel], bending, len(surfaces))


def _loss(gap: Any, size: Any) -> Any:
    """Return Geman and McClure's loss: the square of a small gap; a gap of `size` weighs half in the fit."""
    return gap**2 / (1 + (np.sqrt(2) - 1) * (gap / size) ** 2)


def _outlying(tubes: Tubes, feet: Feet) -> np.ndarray:
    return np.asarray(feet.gap / (OUTLIER + SHAPE * tubes.radius[feet.places[:, 0]]))


def _tubes(trees: Sequence[Tree], spacing: float) -> Tubes:
    """Return the tubes that the fit begins with."""
    nodes, radius = [], []
    rows: list[np.ndarray] = []
    places: list[np.ndarray] = []
    parents: list[int] = []
    node, place = 0, 0
    for tree in trees:
        above = len(rows)
        for line, parent in zip(tree.lines, tree.parent.tolist(), strict=True):
            run, wide = line.run, line.typical_radius
            pieces = max(PIECES, round(float(run[-1]) / max(STEP * wide, SHORTEST * spacing)))
            at = np.linspace(0, run[-1], pieces + 1)[int(parent >= 0) :]
            nodes.append(np.stack([np.interp(at, run, line.points[:, k]) for k in range(3)], axis=1))
            own = node + np.arange(len(at))
            rows.append(own if parent < 0 else np.append(rows[above + parent][-1], own))
            radius.append(np.full(pieces + 1, wide))
            places.append(place + np.arange(pieces + 1))
            parents.append(parent if parent < 0 else above + parent)
            node, place = node + len(at), place + pieces + 1
    positions, radii = np.concatenate(nodes) / spacing, np.concatenate(radius) / spacing
    return Tubes(positions, radii, tuple(rows), tuple(places), np.array(parents))


def _tube_line(nodes: np.ndarray, radius: np.ndarray, spacing: float) -> Line:
    """Return the axis through `nodes` with the radii of its tube, cm."""
    points, at = _even(nodes * spacing, spacing), distance_along(nodes)
    run = distance_along(points)
    return Line(points, spacing * np.interp(run * at[-1] / max(float(run[-1]), 1e-12), at, radius))


def _even(nodes: np.ndarray, spacing: float) -> np.ndarray:
    """Return the curve through `nodes` at equal steps of about a voxel."""
    from scipy.interpolate import CubicSpline  # slow to import, and not needed where the axes are kept

    run, first = np.unique(distance_along(nodes), return_index=True)
    if len(run) < 2:
        return nodes[[0, -1]]
    return np.asarray(CubicSpline(run, nodes[first])(np.linspace(0, run[-1], max(round(run[-1] / spacing), 3) + 1)))


def _closer(tubes: Tubes, feet: Feet, weight: np.ndarray, kept: Differences, strength: np.ndarray) -> Tubes:
    """Return the tubes after one weighted step of Gauss and Newton toward the feet's points."""
    state = tubes.state
    jacobian = _jacobian(tubes, feet)
    smooth = kept.matrix.T @ diags_array(strength) @ kept.matrix
    held = _free_ends(tubes)
    matrix = jacobian.T @ diags_array(weight) @ jacobian + smooth + DAMPING * eye_array(len(state)) + held.T @ held
    right = -jacobian.T @ (weight * feet.gap) - smooth @ state
    step = spsolve(matrix.tocsc(), right, permc_spec="MMD_AT_PLUS_A")
    nodes, radius = np.split(np.clip(step, -FARTHEST, FARTHEST), [tubes.nodes.size])
    return replace(tubes, nodes=tubes.nodes + nodes.reshape(-1, 3), radius=np.maximum(tubes.radius + radius, NARROWEST))


def _jacobian(tubes: Tubes, feet: Feet) -> csr_array:
    """Return how the gaps change with the nodes and the radii."""
    columns = [3 * feet.nodes[:, end] + k for end in (0, 1) for k in range(3)]
    columns += [tubes.nodes.size + feet.places[:, end] for end in (0, 1)]
    shares = 1 - feet.share, feet.share
    values = [-share * feet.normal[:, k] for share in shares for k in range(3)] + [-share for share in shares]
    count, size = len(feet.gap), tubes.nodes.size + tubes.radius.size
    rows = np.tile(np.arange(count), len(columns))
    return coo_array((np.concatenate(values), (rows, np.concatenate(columns))), shape=(count, size)).tocsr()


def _free_ends(tubes: Tubes) -> csr_array:
    """Return how far each free end moves along its axis, which no wall decides: it is held; weighted as `DENSITY`."""
    ends = np.setdiff1d(np.arange(len(tubes.rows)), tubes.parent)
    roots = np.flatnonzero(tubes.parent < 0)
    pairs = np.array([*(tubes.rows[row][:2] for row in roots), *(tubes.rows[row][:-3:-1] for row in ends)])
    along = tubes.nodes[pairs[:, 0]] - tubes.nodes[pairs[:, 1]]
    along *= np.sqrt(DENSITY) / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    rows, columns = np.repeat(np.arange(len(pairs)), 3), (3 * pairs[:, :1] + np.arange(3)).ravel()
    return coo_array((along.ravel(), (rows, columns)), shape=(len(pairs), tubes.nodes.size + tubes.radius.size)).tocsr()
