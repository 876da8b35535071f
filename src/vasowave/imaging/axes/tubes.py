"""Vessel axes to a fraction of a voxel: tubes that meet at their junctions, fitted together to the lumen's surface."""

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, eye_array
from scipy.sparse.linalg import spsolve

from vasowave.imaging.axes.feet import Feet, Tubes, feet_on
from vasowave.imaging.axes.stiffness import Differences, differences, strengths
from vasowave.imaging.tree import Tree, distance_along, with_inscribed_radii

STEP, SHORTEST, PIECES = 0.4, 2.0, 4
"""Nodes of an axis lie STEP radii apart, at least SHORTEST voxels; a vessel has at least PIECES pieces."""
DENSITY = 60
"""So many points of the surface a node are enough; the rest of a finer surface is left out."""
OUTLIER, SHAPE = 0.5, 0.1
"""A point this far from all tubes, OUTLIER voxels + SHAPE radii, counts half: noise, fillets of junctions."""
NARROWEST = 0.5
"""Least radius, voxels."""
DAMPING = 0.3
"""Holds what the surface does not decide, as where along an axis its nodes lie; points of the surface a node."""
STIFF = 32.0
"""The fit begins so much stiffer and softens by half a round: a bend that a hidden stretch has first straightens."""
ROUNDS, ENOUGH, FARTHEST = 12, 0.05, 2.0
"""The fit ends after ROUNDS, or when no node moves by ENOUGH voxels; in a round none moves by more than FARTHEST."""


def fitted(tree: Tree, surface: np.ndarray, spacing: float, roughness: float = 0.0) -> Tree:
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
    """
    tubes = _tubes(tree, spacing)
    few = surface[:: max(1, len(surface) // (DENSITY * len(tubes.nodes)))]
    points = np.asfortranarray(few / spacing)  # each round looks for those near each vessel, axis by axis
    kept = differences(tubes)
    for stiffness in np.maximum(STIFF / 2.0 ** np.arange(ROUNDS), 1.0):
        feet = feet_on(tubes, points)
        closer = _closer(tubes, feet, kept, stiffness * strengths(tubes, feet, kept, roughness))
        moved = np.abs(closer.nodes - tubes.nodes).max()
        tubes = closer
        if moved < ENOUGH and stiffness == 1.0:
            break
    lines = [_even(tubes.nodes[rows] * spacing, spacing) for rows in tubes.rows]
    return with_inscribed_radii(lines, tree.parent, surface)


def misfit_around(tree: Tree, surface: np.ndarray, spacing: float, place: np.ndarray, reach: float) -> float:
    """Return how badly the tubes of `tree` fit the `surface` within `reach` (cm) of `place`: what `fitted` makes small.

    The mean of log(1 + (gap / outlier)²), of which a few outliers do not make much.
    """
    tubes = _tubes(tree, spacing)
    near = surface[np.linalg.norm(surface - place, axis=1) < reach] / spacing
    feet = feet_on(tubes, near)
    return float(np.mean(np.log1p(_outlying(tubes, feet) ** 2))) if len(feet.gap) else 0.0


def _outlying(tubes: Tubes, feet: Feet) -> np.ndarray:
    return np.asarray(feet.gap / (OUTLIER + SHAPE * tubes.radius[feet.places[:, 0]]))


def _tubes(tree: Tree, spacing: float) -> Tubes:
    """Return the tubes that the fit begins with."""
    nodes, radius = [tree.lines[0].points[:1]], []
    rows: list[np.ndarray] = []
    places: list[np.ndarray] = []
    node, place = 1, 0
    for line, parent in zip(tree.lines, tree.parent, strict=True):
        run, wide = line.run, line.typical_radius
        pieces = max(PIECES, round(float(run[-1]) / max(STEP * wide, SHORTEST * spacing)))
        at = np.linspace(0, run[-1], pieces + 1)[1:]
        nodes.append(np.stack([np.interp(at, run, line.points[:, k]) for k in range(3)], axis=1))
        rows.append(np.append(0 if parent < 0 else rows[parent][-1], node + np.arange(pieces)))
        radius.append(np.full(pieces + 1, wide))
        places.append(place + np.arange(pieces + 1))
        node, place = node + pieces, place + pieces + 1
    positions, radii = np.concatenate(nodes) / spacing, np.concatenate(radius) / spacing
    return Tubes(positions, radii, tuple(rows), tuple(places), tree.parent)


def _even(nodes: np.ndarray, spacing: float) -> np.ndarray:
    """Return the curve through `nodes` at equal steps of about a voxel."""
    from scipy.interpolate import CubicSpline  # slow to import, and not needed where the axes are kept

    run, first = np.unique(distance_along(nodes), return_index=True)
    if len(run) < 2:
        return nodes[[0, -1]]
    return np.asarray(CubicSpline(run, nodes[first])(np.linspace(0, run[-1], max(round(run[-1] / spacing), 3) + 1)))


def _closer(tubes: Tubes, feet: Feet, kept: Differences, strength: np.ndarray) -> Tubes:
    """Return the tubes after one weighted step of Gauss and Newton toward the feet's points."""
    state = np.concatenate([tubes.nodes.ravel(), tubes.radius])
    weight = 1 / (1 + _outlying(tubes, feet) ** 2)
    jacobian = _jacobian(tubes, feet)
    smooth = kept.matrix.T @ diags_array(strength) @ kept.matrix
    held = _free_ends(tubes)
    matrix = jacobian.T @ diags_array(weight) @ jacobian + smooth + DAMPING * eye_array(len(state)) + held.T @ held
    step = spsolve(matrix.tocsc(), -jacobian.T @ (weight * feet.gap) - smooth @ state)
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
    pairs = np.array([tubes.rows[0][:2], *(tubes.rows[row][:-3:-1] for row in ends)])
    along = tubes.nodes[pairs[:, 0]] - tubes.nodes[pairs[:, 1]]
    along *= np.sqrt(DENSITY) / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    rows, columns = np.repeat(np.arange(len(pairs)), 3), (3 * pairs[:, :1] + np.arange(3)).ravel()
    return coo_array((along.ravel(), (rows, columns)), shape=(len(pairs), tubes.nodes.size + tubes.radius.size)).tocsr()
