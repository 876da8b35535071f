"""Vessel axes to a fraction of a voxel: tubes that meet at their junctions, fitted together to the lumen's surface.

An axis follows the wall that its vessel has of its own, and goes on as an arc without it: third differences of the
nodes, which an arc has not, are penalized. Where all of a node's wall is seen its place is known to some hundredths of
a voxel and the penalty only quiets noise; where a wider sister hides the vessel nothing is seen, and the penalty alone
says how the axis goes on. One weight for both either bends axes that should be straight or straightens axes that bend
within two radii, which misplaces their junctions.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import spsolve

from vasowave.lung.axes.feet import BEYOND, Feet, Tubes, feet_on, near_points
from vasowave.lung.kernels import summed_on_pieces
from vasowave.lung.tree import Line, Tree, distance_along, with_inscribed_radii

FREE_WEIGHT, HIDDEN_WEIGHT = 0.35, 4.0
"""Weights of a changing curvature against the points of the surface, with a wall of its own all around and without."""
ROUGHNESS_RISE = 0.18, 4
"""Where noise over contrast exceeds the first number, FREE_WEIGHT rises with this power of their ratio."""
SWELLING, TAPER = 20.0, 0.05
"""Weights of a changing taper and of a taper."""
MAX_ORDER = 3
"""No difference is of a higher order."""
FULL_WALL_QUANTILE = 0.6
"""A node has all its wall if it has as many points for its size as this quantile of all nodes."""
MIN_POINTS = 4
"""A difference weighs as much as a node has points, at least so many."""
STEP_RADII, MIN_STEP_VOXELS, MIN_PIECES = 0.4, 2.0, 4
"""Nodes of an axis lie STEP_RADII apart, at least MIN_STEP_VOXELS; a vessel has at least MIN_PIECES."""
DENSITY = 62
"""So many points of the surface a node are enough; the rest is left out."""
OUTLIER, SHAPE = 0.5, 0.1
"""A point this far from all tubes, OUTLIER voxels + SHAPE radii, counts half: noise, fillets of junctions."""
MIN_RADIUS_VOXELS = 0.5
"""Least radius, voxels."""
DAMPING = 0.3
"""Holds what the surface does not decide, as where along an axis its nodes lie; points of the surface a node."""
FIRST_STIFFNESS = 32.0
"""The fit begins so much stiffer and softens by half a round: a bend that a hidden stretch has first straightens."""
ROUNDS, SETTLED_MOVE_VOXELS, MAX_MOVE_VOXELS = 7, 0.05, 2.0
"""Soft, the fit ends after ROUNDS, or when no node moves by SETTLED_MOVE_VOXELS; none moves farther than
MAX_MOVE_VOXELS at once."""


@dataclass(frozen=True, eq=False)
class Differences:
    """What is kept small: differences along each vessel of the unknowns (nodes' coordinates, then radii).

    Attributes
    ----------
    columns : int array, shape (difference, MAX_ORDER + 1)
        The unknowns that each difference spans; the last one again where it spans fewer.
    stencil : float array, shape (difference, MAX_ORDER + 1)
        Their factors; 0 where an unknown stands again.
    vessel : int array, shape (difference,)
    weight : float array, shape (difference,)
        NaN for the differences of positions, whose weight depends on the wall.
    window : int array, shape (difference, 2)
        First and last place (see `Tubes`) that the difference spans.
    """

    columns: np.ndarray
    stencil: np.ndarray
    vessel: np.ndarray
    weight: np.ndarray
    window: np.ndarray

    def of(self, state: np.ndarray) -> np.ndarray:
        """Return the differences of the unknowns' values, shape (difference,)."""
        return np.asarray((self.stencil * state[self.columns]).sum(axis=1))


def differences(tubes: Tubes) -> Differences:
    """Return the differences of the unknowns of `tubes`."""
    vessel, blocks = np.repeat(np.arange(len(tubes.parent)), np.diff(tubes.begins)), []
    beyond = tubes.begins[vessel + 1] - 1 - np.arange(len(vessel))  # places of its vessel beyond each
    radius = tubes.nodes.size + np.arange(len(vessel)), ((2, SWELLING), (1, TAPER))
    for unknowns, orders in (*((3 * tubes.place_nodes + k, ((3, np.nan),)) for k in range(3)), radius):
        for order, weight in orders:
            first = np.flatnonzero(beyond >= order)
            spans = first[:, None] + np.minimum(np.arange(MAX_ORDER + 1), order)
            stencil = np.append(np.diff(np.eye(order + 1), order, axis=0)[0], np.zeros(MAX_ORDER - order))
            about = np.tile(stencil, (len(first), 1)), vessel[first], np.full(len(first), weight)
            blocks.append((unknowns[spans], *about, spans[:, [0, -1]]))
    return Differences(*(np.concatenate(arrays) for arrays in zip(*blocks, strict=True)))


def strengths(tubes: Tubes, feet: Feet, penalties: Differences, roughness: float) -> np.ndarray:
    """Return the weight of each difference against points of the surface that weigh 1; of roughness see `fitted`."""
    free = min(FREE_WEIGHT * max(roughness / ROUGHNESS_RISE[0], 1.0) ** ROUGHNESS_RISE[1], HIDDEN_WEIGHT)
    wall = _own_wall(tubes, feet)
    first, last = penalties.window.T
    min_wall = np.min([wall[np.minimum(first + step, last)] for step in range(MAX_ORDER + 1)], axis=0)
    bending = HIDDEN_WEIGHT + (free - HIDDEN_WEIGHT) * min_wall
    # A difference weighs as much as a node has points, so that neither resolution nor width changes the balance.
    points = np.bincount(feet.vessel, minlength=len(tubes.parent)) / np.diff(tubes.begins)
    return (
        np.where(np.isnan(penalties.weight), bending, penalties.weight)
        * np.maximum(points, MIN_POINTS)[penalties.vessel]
    )


def _own_wall(tubes: Tubes, feet: Feet) -> np.ndarray:
    """Return the share of its wall that each node has for itself, shape (place,)."""
    size = tubes.radius.size
    count = np.bincount(feet.place, 1 - feet.share, size) + np.bincount(feet.place + 1, feet.share, size)
    half = tubes.lengths / 2
    length = np.bincount(tubes.pieces, half, size) + np.bincount(tubes.pieces + 1, half, size)
    density = count / np.maximum(tubes.radius * length, 1e-9)
    return np.asarray(np.clip(density / max(float(np.quantile(density, FULL_WALL_QUANTILE)), 1e-9), 0, 1))


def fitted(
    tree: Tree, surface: np.ndarray, spacing: float, roughness: float = 0.0, begin: float = FIRST_STIFFNESS
) -> Tree:
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
    axes = [_even(tubes.nodes[rows] * spacing, spacing) for rows in np.split(tubes.place_nodes, tubes.begins[1:-1])]
    return with_inscribed_radii(axes, tree.parent, surface)


def fitted_apart(
    trees: Sequence[Tree],
    surfaces: Sequence[np.ndarray],
    spacing: float,
    roughness: float,
    begin: float = FIRST_STIFFNESS,
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
    vessel_tubes = zip(
        np.split(tubes.place_nodes, tubes.begins[1:-1]), np.split(tubes.radius, tubes.begins[1:-1]), strict=True
    )
    lines = (_tube_line(tubes.nodes[rows], radius, spacing) for rows, radius in vessel_tubes)
    misfits = _misfits(tubes, points, roughness).tolist()
    return [
        (tree.with_lines(list(islice(lines, len(tree)))), misfit) for tree, misfit in zip(trees, misfits, strict=True)
    ]


def _fitted(
    tubes: Tubes, surfaces: Sequence[np.ndarray], roughness: float, begin: float, rounds: int = ROUNDS
) -> Tubes:
    """Return the tubes where they fit best, each tree to its own of the `surfaces` (voxels)."""
    equations = _Equations(tubes)
    stiff = begin / 2.0 ** np.arange(np.ceil(np.log2(begin)))
    for schedule, power in ((stiff, 1), (np.ones(rounds), 2)):
        points, candidates, _ = _thinned(tubes, surfaces)
        for stiffness in schedule:
            feet = feet_on(tubes, points, candidates)
            # Cauchy's weight finds the wall from far; Geman and McClure's keeps it, whatever bulges from it.
            weight = 1 / (1 + (2 ** (1 / power) - 1) * _outlying(tubes, feet) ** 2) ** power
            closer = equations.solved(tubes, feet, weight, stiffness, roughness)
            moved = np.abs(closer.nodes - tubes.nodes).max()
            tubes = closer
            if moved < SETTLED_MOVE_VOXELS:
                break
    return tubes


def _thinned(
    tubes: Tubes, surfaces: Sequence[np.ndarray]
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray], np.ndarray]:
    """Return `DENSITY` points of the surfaces a node, which of them lie near each vessel, and the tree of each."""
    nodes = np.bincount(tubes.tree, np.diff(tubes.begins))
    samples = [points[:: max(1, int(len(points) / (DENSITY * n)))] for points, n in zip(surfaces, nodes, strict=True)]
    begins = np.cumsum([0, *map(len, samples)])
    points = np.concatenate(samples)
    return points, near_points(tubes, points, begins), np.repeat(np.arange(len(samples)), np.diff(begins))


def _misfits(tubes: Tubes, surfaces: Sequence[np.ndarray], roughness: float) -> np.ndarray:
    """Return what the fit makes small of each tree; a point near no tube counts as one as far as `feet_on` looks."""
    points, candidates, owner = _thinned(tubes, surfaces)
    feet, small = feet_on(tubes, points, candidates), differences(tubes)
    size = OUTLIER + SHAPE * tubes.radius[feet.place]
    gaps = np.bincount(tubes.tree[feet.vessel], _loss(feet.gap, size), len(surfaces))
    lost = np.bincount(owner[feet.lost], minlength=len(surfaces)) * _loss(BEYOND, OUTLIER)
    bending = strengths(tubes, feet, small, roughness) * small.of(tubes.state) ** 2
    return gaps + lost + np.bincount(tubes.tree[small.vessel], bending, len(surfaces))


def _loss(gap: Any, size: Any) -> Any:
    """Return Geman and McClure's loss: the square of a small gap; a gap of `size` weighs half in the fit."""
    return gap**2 / (1 + (np.sqrt(2) - 1) * (gap / size) ** 2)


def _outlying(tubes: Tubes, feet: Feet) -> np.ndarray:
    return np.asarray(feet.gap / (OUTLIER + SHAPE * tubes.radius[feet.place]))


def _tubes(trees: Sequence[Tree], spacing: float) -> Tubes:
    """Return the tubes that the fit begins with."""
    nodes, radius = [], []
    rows: list[np.ndarray] = []
    parents: list[int] = []
    node = 0
    for tree in trees:
        above = len(rows)
        for line, parent in zip(tree.lines, tree.parent.tolist(), strict=True):
            run, wide = line.run, line.typical_radius
            pieces = max(MIN_PIECES, round(float(run[-1]) / max(STEP_RADII * wide, MIN_STEP_VOXELS * spacing)))
            stations = np.linspace(0, run[-1], pieces + 1)[int(parent >= 0) :]
            nodes.append(line.at(stations).points)
            indices = node + np.arange(len(stations))
            rows.append(indices if parent < 0 else np.append(rows[above + parent][-1], indices))
            radius.append(np.full(pieces + 1, wide))
            parents.append(parent if parent < 0 else above + parent)
            node += len(stations)
    positions, radii = np.concatenate(nodes) / spacing, np.concatenate(radius) / spacing
    return Tubes(positions, radii, np.concatenate(rows), np.cumsum([0, *map(len, rows)]), np.array(parents))


def _tube_line(nodes: np.ndarray, radius: np.ndarray, spacing: float) -> Line:
    """Return the axis through `nodes` with the radii of its tube, cm."""
    points, node_run = _even(nodes * spacing, spacing), distance_along(nodes)
    run = distance_along(points)
    return Line(points, spacing * np.interp(run * node_run[-1] / max(float(run[-1]), 1e-12), node_run, radius))


def _even(nodes: np.ndarray, spacing: float) -> np.ndarray:
    """Return the curve through `nodes` at equal steps of about a voxel."""
    from scipy.interpolate import CubicSpline  # slow to import, and not needed where the axes are kept

    run, first = np.unique(distance_along(nodes), return_index=True)
    if len(run) < 2:
        return nodes[[0, -1]]
    return np.asarray(CubicSpline(run, nodes[first])(np.linspace(0, run[-1], max(round(run[-1] / spacing), 3) + 1)))


class _Equations:
    """The normal equations of a step of Gauss and Newton: which unknowns meet in them is the same at every step."""

    def __init__(self, tubes: Tubes) -> None:
        self._small, self._size = differences(tubes), len(tubes.state)
        self._stencils = self._small.stencil[:, :, None] * self._small.stencil[:, None]
        # What a foot depends on: two nodes' coordinates and two radii.
        before, after = (_coordinates(tubes.place_nodes[tubes.pieces + end]) for end in (0, 1))
        self._piece = np.hstack([before, after, tubes.nodes.size + tubes.pieces[:, None] + np.arange(2)])
        ends, roots = np.setdiff1d(np.arange(len(tubes.parent)), tubes.parent), np.flatnonzero(tubes.parent < 0)
        first, last = tubes.begins[roots], tubes.begins[ends + 1] - 1
        self._ends = tubes.place_nodes[np.append(first, last)], tubes.place_nodes[np.append(first + 1, last - 1)]
        groups = self._piece, self._small.columns, _coordinates(self._ends[0]), np.arange(self._size)[:, None]
        entries = np.concatenate([(self._size * group[:, :, None] + group[:, None]).ravel() for group in groups])
        entries, self._slot = np.unique(entries, return_inverse=True)
        self._rows, begins = entries % self._size, self._size * np.arange(self._size + 1)
        self._begins = np.searchsorted(entries, begins)

    def solved(self, tubes: Tubes, feet: Feet, weight: np.ndarray, stiffness: float, roughness: float) -> Tubes:
        """Return the tubes after one step toward the feet's points, each of its `weight`."""
        small, size = self._small, self._size
        sums = summed_on_pieces(feet.place, feet.normal, feet.share, feet.gap, weight, tubes.radius.size)
        walls, pull = (block[tubes.pieces] for block in sums)
        strength = stiffness * strengths(tubes, feet, small, roughness)
        held, damping = self._held(tubes.nodes), np.full(size, DAMPING)
        groups = walls, strength[:, None, None] * self._stencils, held[:, :, None] * held[:, None], damping
        entries = np.bincount(self._slot, np.concatenate([block.ravel() for block in groups]))
        bent = (strength * small.of(tubes.state))[:, None] * small.stencil
        right = np.bincount(self._piece.ravel(), pull.ravel(), size)
        right -= np.bincount(small.columns.ravel(), bent.ravel(), size)
        matrix = csc_array((entries, self._rows, self._begins), shape=(size, size))
        step = np.clip(spsolve(matrix, right, permc_spec="MMD_AT_PLUS_A"), -MAX_MOVE_VOXELS, MAX_MOVE_VOXELS)
        nodes, radius = np.split(step, [tubes.nodes.size])
        wide = np.maximum(tubes.radius + radius, MIN_RADIUS_VOXELS)
        return replace(tubes, nodes=tubes.nodes + nodes.reshape(-1, 3), radius=wide)

    def _held(self, nodes: np.ndarray) -> np.ndarray:
        """Return the direction in which no wall decides where a free end lies: it is held; weighted as `DENSITY`."""
        along = nodes[self._ends[0]] - nodes[self._ends[1]]
        return along * np.sqrt(DENSITY) / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)


def _coordinates(nodes: np.ndarray) -> np.ndarray:
    """Return where the coordinates of `nodes` stand among the unknowns, shape (node, 3)."""
    return 3 * nodes[:, None] + np.arange(3)
