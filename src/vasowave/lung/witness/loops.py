"""Loops of the lumen: a tree has none, touching vessels and smeared gaps make them."""

from typing import Literal, NamedTuple

import numpy as np
from scipy import ndimage
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree
from scipy.spatial import cKDTree

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, warn
from vasowave.lung.lumen.segmentation import Segmentation
from vasowave.lung.places import written
from vasowave.lung.tree import Tree
from vasowave.lung.witness.doubts import Doubt, Grade, doubt_kind
from vasowave.lung.witness.skeleton import skeleton_voxels

MIN_RING_VOXELS = 5.0
"""The least ring of voxels around a hole is longer, voxels; shorter ones are voxels that all touch each other."""
MIN_GAP_VOXELS = 3.0
"""Two rings whose thinnest places lie so many voxels apart are named as one."""

MAX_NAMED_RINGS = 6
"""A message names so many rings."""
GAP = 3
"""Gaps that so many voxels on either side close are as wide as those that noise leaves between spurs."""
CONTRAST_FACTORS, MIN_LUMEN_SHARE = (1.15, 1.3, 1.5), 0.6
"""Multiples of the contrast of the wall at which a higher threshold is tried; so much of the lumen must stay."""

LOOP = doubt_kind(
    "witness.loop",
    Grade.LOOK,
    "vessel(s) {vessels}: the lumen closes a loop here, which the tree cuts",
    "Cut it in the mask, or give the outlets.",
)
LOOPS_CUT = look_kind(
    "image.loops",
    "{loops}. The tree cuts each of them somewhere, so vessels, lengths and flows there may be far off: {ways}",
    "Try the level set where noise makes them, cut the loops in the mask, or give the outlets.",
)


class Loop(NamedTuple):
    """A ring of the lumen.

    Attributes
    ----------
    place : float array, shape (3,)
        The thinnest place of the ring, where touching vessels touch; z, y, x, cm.
    length : float
        Along the middle of the lumen, cm.
    radius : float
        Of the lumen at `place`, cm.
    """

    place: np.ndarray
    length: float
    radius: float


def loop_count(lumen: Segmentation) -> int:
    """Return the number of tunnels through the lumen: 1 - its Euler number (it is one piece without cavities)."""
    return 1 - euler_number(lumen.mask)


def euler_number(mask: np.ndarray) -> int:
    """Return corners - edges + faces - voxels of `mask` (bool, shape (z, y, x)); voxels touch at corners, too."""
    return _counted(np.pad(mask, 1), 0, -1)


def _counted(cells: np.ndarray, axis: int, sign: int) -> int:
    """Return `sign` times the number of `cells`, with what bounds them along the axes from `axis` on."""
    if axis == cells.ndim:
        return sign * int(np.count_nonzero(cells))
    along = np.moveaxis(cells, axis, 0)
    sides = np.moveaxis(along[1:] | along[:-1], 0, axis)  # of one dimension less
    return _counted(cells, axis + 1, sign) + _counted(sides, axis + 1, -sign)


def told_loops(lumen: Segmentation, policy: Literal["refuse", "open"], guided: bool, level_set: bool) -> np.ndarray:
    """Return where the rings of `lumen` are thinnest (place, 3), having warned of them.

    Parameters
    ----------
    lumen : Segmentation
    policy : "refuse" or "open"
        Whether a ring is an error.
    guided, level_set : bool
        Whether outlets were given, and whether the level set may still be tried: what to do next depends on them.

    Raises
    ------
    InputError
        Rings that are to be refused; without the extra 'imaging'.
    """
    count = loop_count(lumen)
    if count <= 0:
        return np.empty((0, 3))
    loops = loops_of(lumen)
    places = [f"{written(loop.place)} (ring of {loop.length:.2g} cm)" for loop in loops[:MAX_NAMED_RINGS]]
    suffix = f"; and {len(loops) - MAX_NAMED_RINGS} more" if len(loops) > MAX_NAMED_RINGS else ""
    text = (
        f"the lumen closes {count} loop(s), thinnest at (x,y,z, cm) {'; '.join(places)}{suffix}: vessels touch, noise "
        "bridges them, the ring of a holder hangs on them, a clot or bubble divides one, or they join again"
    )
    remedies = _ways(lumen, count, level_set)
    outlets = "" if guided else "; give the outlets then, so that each cut leads to them"
    if policy == "refuse":
        raise InputError(
            f"{text}. A tree cannot hold them, and where one is cut decides which vessels there are: {remedies}, or "
            f"accept any cut (loops 'open'){outlets}"
        )
    warn(LOOPS_CUT(loops=text, ways=f"{remedies}{outlets}"))
    return np.array([loop.place for loop in loops])


def _ways(lumen: Segmentation, count: int, level_set: bool) -> str:
    """Return what may rid `lumen` of its rings, the likeliest first, in words."""
    remedies = []
    gaps = count - loops_after_closing(lumen)
    if gaps > 0 and level_set:
        remedies.append(
            f"{gaps} of them close with gaps of {2 * GAP} voxels, as noise makes them: try the method 'level-set'"
        )
    level = opening_threshold(lumen)
    remedies += [f"raise the threshold to {level:.4g}, where none is left"] if level else []
    remedies.append("cut them in the mask")
    if gaps <= 0 and level_set:
        remedies.append("try the method 'level-set'")
    return ", ".join(remedies)


def loops_after_closing(lumen: Segmentation) -> int:
    """Return how many tunnels are left where gaps of twice `GAP` voxels are closed."""
    closed = ndimage.binary_closing(np.pad(lumen.mask, GAP + 1), ndimage.generate_binary_structure(3, 1), GAP)
    return 1 - euler_number(closed)


def opening_threshold(lumen: Segmentation) -> float | None:
    """Return the least of a few thresholds at which the largest piece of `lumen` closes no loop; None without one."""
    for raised in CONTRAST_FACTORS:
        level = lumen.background + raised * (lumen.threshold - lumen.background)
        pieces, count = ndimage.label(lumen.grey > level)
        sizes = np.bincount(pieces.ravel())[1:]
        if not count or sizes.max() < MIN_LUMEN_SHARE * lumen.mask.sum():
            return None
        if euler_number(ndimage.binary_fill_holes(pieces == 1 + int(np.argmax(sizes)))) >= 1:
            return float(f"{level:.3g}")
    return None


def loop_doubts(tree: Tree, names: tuple[str, ...], places: np.ndarray) -> list[Doubt]:
    """Return a doubt about the vessels that run through each of the `places` at which the lumen closes a ring."""
    doubts = []
    for place in places:
        gap = np.linalg.norm(tree.line.points - place, axis=1) - 2 * tree.line.radius
        rows = np.unique(tree.owner[gap <= max(float(gap.min()), 0.0)])
        vessels = tuple(names[row] for row in rows)
        doubts.append(Doubt("loop", LOOP(vessels=", ".join(vessels)), vessels, place[None]))
    return doubts


def loops_of(lumen: Segmentation) -> list[Loop]:
    """Return the rings of `lumen`, the longest first, on its skeleton (Lee's thinning, which keeps every ring).

    A spanning tree of the skeleton that prefers what is wide leaves out, of every ring, its thinnest piece.

    Raises
    ------
    InputError
        Without the extra 'imaging'.
    """
    points, pairs = skeleton_voxels(lumen, "the places of loops need")
    wall = np.argwhere(lumen.mask & ~ndimage.binary_erosion(lumen.mask))
    depth = cKDTree(wall).query(points)[0] + 0.5
    thin = depth[pairs].min(axis=1)
    graph = csr_array((1 / thin, pairs.T), shape=(len(points),) * 2)
    tree = minimum_spanning_tree(graph)
    above = breadth_first_order(tree, 0, directed=False)[1]
    inside = set(zip(*map(np.ndarray.tolist, tree.nonzero()), strict=True))
    rings: list[tuple[np.ndarray, float, float]] = []
    for (first, second), narrow in zip(pairs.tolist(), thin.tolist(), strict=True):
        if (first, second) in inside or above[first] == above[second]:
            continue
        length = _ring(first, second, above, points)
        place = (points[first] + points[second]) / 2
        if length > MIN_RING_VOXELS and all(np.linalg.norm(place - center) > MIN_GAP_VOXELS for center, *_ in rings):
            rings.append((place, length, narrow))
    h = lumen.spacing
    loops = [Loop(place * h + lumen.origin, length * h, radius * h) for place, length, radius in rings]
    return sorted(loops, key=lambda loop: -loop.length)


def _ring(first: int, second: int, above: np.ndarray, points: np.ndarray) -> float:
    """Return the length of the ring that a link between two points closes, along the tree, voxels."""
    paths = [[first], [second]]
    for path in paths:
        while above[path[-1]] >= 0:
            path.append(int(above[path[-1]]))
    while len(paths[0]) > 1 and len(paths[1]) > 1 and paths[0][-2] == paths[1][-2]:
        for path in paths:
            path.pop()
    ring = points[paths[0] + paths[1][-2::-1] + [first]]
    return float(np.linalg.norm(np.diff(ring, axis=0), axis=1).sum())
