"""Vessel axes to a fraction of a voxel: tubes that meet at their junctions, fitted together to the lumen's surface."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.sparse import coo_array, csr_array, diags_array, eye_array
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree

from vasowave.imaging.tree import Tree, distance_along, with_inscribed_radii

STEP, SHORTEST, FEWEST = 0.5, 2.0, 4
"""Nodes of an axis lie STEP radii apart, at least SHORTEST voxels; a vessel has at least FEWEST pieces."""
DENSITY = 60
"""So many points of the surface a node are enough; the rest of a finer surface is left out."""
BENDING, SWELLING, TAPER = 16.0, 20.0, 0.05
"""Weights of a changing curvature, a changing taper and a taper against the points of the surface."""
OUTLIER, SHAPE = 0.5, 0.1
"""A point this far from all tubes, OUTLIER voxels + SHAPE radii, counts half: noise, fillets of junctions."""
NARROWEST = 0.5
"""Least radius, voxels."""
DAMPING = 0.3
"""Holds what the surface does not decide, as where along an axis its nodes lie; points of the surface a node."""
STIFF = 64.0
"""The fit begins so much stiffer and softens by half a round: a bend that a hidden stretch has first straightens."""
ROUNDS, ENOUGH, FARTHEST = 10, 0.05, 2.0
"""The fit ends after ROUNDS, or when no node moves by ENOUGH voxels; in a round none moves by more than FARTHEST."""


@dataclass(frozen=True, eq=False)
class _Tubes:
    """Tubes around polylines whose nodes are shared at junctions; lengths in voxels.

    Attributes
    ----------
    nodes : float array, shape (node, 3)
    radius : float array, shape (place,)
        At the nodes, one vessel after the other: at a junction each has its own.
    rows, places : tuple of int array
        Each vessel's nodes, the first being the last of its parent, and where its radii stand.
    parent : int array, shape (vessel,)
    """

    nodes: np.ndarray
    radius: np.ndarray
    rows: tuple[np.ndarray, ...]
    places: tuple[np.ndarray, ...]
    parent: np.ndarray


@dataclass(frozen=True, eq=False)
class _Feet:
    """Points of the surface and where they stand on the tubes; arrays over the points.

    Attributes
    ----------
    gap : float array
        Distance from the tube, voxels; negative inside.
    normal : float array, shape (point, 3)
        Unit vector from the axis to the point.
    nodes, places : int array, shape (point, 2)
        The nodes before and after the foot, and where their radii stand.
    share : float array
        The foot's position between these, 0 to 1.
    vessel : int array
    """

    gap: np.ndarray
    normal: np.ndarray
    nodes: np.ndarray
    places: np.ndarray
    share: np.ndarray
    vessel: np.ndarray


@dataclass(frozen=True, eq=False)
class _Differences:
    """What is kept small: differences along each vessel of the unknowns (nodes' coordinates, then radii).

    Attributes
    ----------
    matrix : sparse array, shape (difference, unknown)
    vessel : int array, shape (difference,)
    """

    matrix: csr_array
    vessel: np.ndarray


def fitted(tree: Tree, surface: np.ndarray, spacing: float) -> Tree:
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
    """
    tubes = _tubes(tree, spacing)
    points = surface[:: max(1, len(surface) // (DENSITY * len(tubes.nodes)))] / spacing
    index, differences = cKDTree(points), _differences(tubes)
    for stiffness in np.maximum(STIFF / 2.0 ** np.arange(ROUNDS), 1.0):
        closer = _closer(tubes, _feet(tubes, points, index), differences, stiffness)
        moved = np.abs(closer.nodes - tubes.nodes).max()
        tubes = closer
        if moved < ENOUGH and stiffness == 1.0:
            break
    lines = [_even(tubes.nodes[rows] * spacing, spacing) for rows in tubes.rows]
    return with_inscribed_radii(lines, tree.parent, surface)


def _tubes(tree: Tree, spacing: float) -> _Tubes:
    """Return the tubes that the fit begins with."""
    nodes, radius = [tree.lines[0].points[:1]], []
    rows: list[np.ndarray] = []
    places: list[np.ndarray] = []
    node, place = 1, 0
    for line, parent in zip(tree.lines, tree.parent, strict=True):
        run, wide = line.run, line.typical_radius
        pieces = max(FEWEST, round(float(run[-1]) / max(STEP * wide, SHORTEST * spacing)))
        at = np.linspace(0, run[-1], pieces + 1)[1:]
        nodes.append(np.stack([np.interp(at, run, line.points[:, k]) for k in range(3)], axis=1))
        rows.append(np.append(0 if parent < 0 else rows[parent][-1], node + np.arange(pieces)))
        radius.append(np.full(pieces + 1, wide))
        places.append(place + np.arange(pieces + 1))
        node, place = node + pieces, place + pieces + 1
    positions, radii = np.concatenate(nodes) / spacing, np.concatenate(radius) / spacing
    return _Tubes(positions, radii, tuple(rows), tuple(places), tree.parent)


def _even(nodes: np.ndarray, spacing: float) -> np.ndarray:
    """Return the curve through `nodes` at equal steps of about a voxel."""
    run, first = np.unique(distance_along(nodes), return_index=True)
    if len(run) < 2:
        return nodes[[0, -1]]
    return np.asarray(CubicSpline(run, nodes[first])(np.linspace(0, run[-1], max(round(run[-1] / spacing), 3) + 1)))


def _feet(tubes: _Tubes, points: np.ndarray, index: cKDTree) -> _Feet:
    """Return where those of `points` that lie near a tube's wall stand on the tube nearest to them."""
    ends = np.setdiff1d(np.arange(len(tubes.rows)), tubes.parent)
    gap, share = np.full(len(points), np.inf), np.zeros(len(points))
    nodes, places = np.zeros((len(points), 2), dtype=int), np.zeros((len(points), 2), dtype=int)
    vessel, wall, normal = np.full(len(points), -1), np.zeros(len(points), dtype=bool), np.zeros((len(points), 3))
    for row, (own, place) in enumerate(zip(tubes.rows, tubes.places, strict=True)):
        axis, radius = tubes.nodes[own], tubes.radius[place]
        reach = radius + 3 + np.linalg.norm(np.diff(axis, axis=0), axis=1).max()
        near = np.unique(np.concatenate(index.query_ball_point(axis, reach))).astype(int)
        piece, along, away = _projected(axis, points[near])
        held, distance = np.clip(along, 0, 1), np.linalg.norm(away, axis=1)
        beyond = distance - (1 - held) * radius[piece] - held * radius[piece + 1]
        less = beyond < gap[near]
        at, piece, along = near[less], piece[less], along[less]
        gap[at], share[at], vessel[at] = beyond[less], held[less], row
        normal[at] = away[less] / np.maximum(distance[less], 1e-9)[:, None]
        nodes[at] = np.stack([own[piece], own[piece + 1]], axis=1)
        places[at] = np.stack([place[piece], place[piece + 1]], axis=1)
        # No wall: what lies before the root, and a terminal's last radius with its cap.
        wall[at] = along >= 0 if tubes.parent[row] < 0 else True
        if row in ends:
            left = (len(axis) - 1 - piece - along) * np.linalg.norm(axis[-1] - axis[-2])
            wall[at] &= left > radius[-1]
    return _Feet(*(values[wall] for values in (gap, normal, nodes, places, share, vessel)))


def _projected(axis: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return each point's nearest piece of `axis`, where its foot lies along it, and the vector to it from the piece.

    The foot's position is 0 to 1, beyond these past the ends of the axis.
    """
    nearest = cKDTree(axis).query(points)[1]
    sides = []
    for piece in (np.maximum(nearest - 1, 0), np.minimum(nearest, len(axis) - 2)):
        along = axis[piece + 1] - axis[piece]
        foot = ((points - axis[piece]) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-12)
        sides.append((piece, foot, points - axis[piece] - np.clip(foot, 0, 1)[:, None] * along))
    before, after = sides
    nearer = np.linalg.norm(before[2], axis=1) < np.linalg.norm(after[2], axis=1)
    piece, foot = (np.where(nearer, one, other) for one, other in zip(before[:2], after[:2], strict=True))
    return piece, foot, np.where(nearer[:, None], before[2], after[2])


def _closer(tubes: _Tubes, feet: _Feet, differences: _Differences, stiffness: float) -> _Tubes:
    """Return the tubes after one weighted step of Gauss and Newton toward the feet's points."""
    state = np.concatenate([tubes.nodes.ravel(), tubes.radius])
    weight = 1 / (1 + (feet.gap / (OUTLIER + SHAPE * tubes.radius[feet.places[:, 0]])) ** 2)
    jacobian = _jacobian(tubes, feet)
    # A difference weighs as much as a node has points, so that neither resolution nor width changes the balance.
    seen = np.bincount(feet.vessel, minlength=len(tubes.rows)) / [len(rows) for rows in tubes.rows]
    strength = diags_array(stiffness * np.maximum(seen, FEWEST)[differences.vessel])
    smooth = differences.matrix.T @ strength @ differences.matrix
    held = _free_ends(tubes)
    matrix = jacobian.T @ diags_array(weight) @ jacobian + smooth + DAMPING * eye_array(len(state)) + held.T @ held
    step = spsolve(matrix.tocsc(), -jacobian.T @ (weight * feet.gap) - smooth @ state)
    nodes, radius = np.split(np.clip(step, -FARTHEST, FARTHEST), [tubes.nodes.size])
    return replace(tubes, nodes=tubes.nodes + nodes.reshape(-1, 3), radius=np.maximum(tubes.radius + radius, NARROWEST))


def _jacobian(tubes: _Tubes, feet: _Feet) -> csr_array:
    """Return how the gaps change with the nodes and the radii."""
    columns = [3 * feet.nodes[:, end] + k for end in (0, 1) for k in range(3)]
    columns += [tubes.nodes.size + feet.places[:, end] for end in (0, 1)]
    shares = 1 - feet.share, feet.share
    values = [-share * feet.normal[:, k] for share in shares for k in range(3)] + [-share for share in shares]
    count, size = len(feet.gap), tubes.nodes.size + tubes.radius.size
    rows = np.tile(np.arange(count), len(columns))
    return coo_array((np.concatenate(values), (rows, np.concatenate(columns))), shape=(count, size)).tocsr()


def _free_ends(tubes: _Tubes) -> csr_array:
    """Return how far each free end moves along its axis, which no wall decides: it is held; weighted as `DENSITY`."""
    ends = np.setdiff1d(np.arange(len(tubes.rows)), tubes.parent)
    pairs = np.array([tubes.rows[0][:2], *(tubes.rows[row][:-3:-1] for row in ends)])
    along = tubes.nodes[pairs[:, 0]] - tubes.nodes[pairs[:, 1]]
    along *= np.sqrt(DENSITY) / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    rows, columns = np.repeat(np.arange(len(pairs)), 3), (3 * pairs[:, :1] + np.arange(3)).ravel()
    return coo_array((along.ravel(), (rows, columns)), shape=(len(pairs), tubes.nodes.size + tubes.radius.size)).tocsr()


def _differences(tubes: _Tubes) -> _Differences:
    blocks, vessel = [], []
    for row, (own, place) in enumerate(zip(tubes.rows, tubes.places, strict=True)):
        axis, radius = [3 * own + k for k in range(3)], [tubes.nodes.size + place]
        for unknowns, order, weight in ((axis, 3, BENDING), (radius, 2, SWELLING), (radius, 1, TAPER)):
            stencil = np.sqrt(weight) * np.diff(np.eye(order + 1), order, axis=0)[0]
            windows = [
                columns[first : first + order + 1] for columns in unknowns for first in range(len(columns) - order)
            ]
            blocks += [(window, stencil) for window in windows]
            vessel += [row] * len(windows)
    rows = np.repeat(np.arange(len(blocks)), [len(window) for window, _ in blocks])
    columns, values = (np.concatenate(part) for part in zip(*blocks, strict=True))
    shape = len(blocks), tubes.nodes.size + tubes.radius.size
    return _Differences(coo_array((values, (rows, columns)), shape=shape).tocsr(), np.array(vessel))
