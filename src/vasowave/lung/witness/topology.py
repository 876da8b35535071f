"""What speaks against a tree's vessels: ends and junctions that the skeleton has otherwise, vessels that only pass by,
pieces of lumen that hang together with nothing.
"""

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from vasowave.base.findings import FindingKind, Value, note_kind, warn
from vasowave.lung.lumen.segmentation import Segmentation
from vasowave.lung.places import written
from vasowave.lung.tree import Line, Tree, clear_stretches
from vasowave.lung.witness.doubts import Doubt, Grade, doubt_kind
from vasowave.lung.witness.skeleton import Branches

NEAR = 2.0, 4.0
"""Two ends are one if they lie within so many radii + voxels."""
LONG = 1.5
"""An inner vessel shorter than so many radii, within its uncertainty, may be no vessel but one junction; one that is
shorter for sure is one for the witness."""

_SECOND = "a second, independent tree of the lumen"
NOT_SEEN = doubt_kind(
    "witness.not-seen",
    Grade.LOOK,
    f"{_SECOND} does not have vessel(s) {{vessels}}: {{remedy}}",
    "look whether they are there",
)
MORE_ENDS = doubt_kind(
    "witness.more-ends",
    Grade.LOOK,
    f"{_SECOND} has {{ends}} more end(s), at (x,y,z, cm) {{places}}: a vessel may be missing there; {{remedy}}",
    "look, and give outlets or edits",
)
OTHER_JOINTS = doubt_kind(
    "witness.other-joints",
    Grade.LOOK,
    f"{_SECOND} joins other vessels than vessel(s) {{vessels}} do: {{remedy}}",
    "look at their ends",
)
SHORT = doubt_kind(
    "witness.short-vessel",
    Grade.LOOK,
    "vessel(s) {vessels}: perhaps shorter than {radii:g} radii between two junctions, which may be one that more than "
    "two vessels leave: {remedy}",
    "look, and merge what is not a vessel",
)
STRAIGHT = 150.0
"""Two vessels that leave a junction in directions so far apart (degrees) may be one that passes: daughters lie within
about 130 degrees of one another."""
BEGINS, OVER = 2.0, 3.0
"""Their beginnings lie within so many times the sum of their radii; directions are taken over so many radii from where
they have left their junction and their sisters: before, they bend toward the vessel that they only cross."""
PASSING = doubt_kind(
    "witness.passing-vessel",
    Grade.LOOK,
    "vessel(s) {vessels}: run on straight into one another, as one vessel does that touches or crosses another: "
    "{remedy}",
    "if it is not of this tree, remove both",
)
GAP = 2.0
"""A piece may begin so many radii of the nearest vessel away from its wall: a bubble is no wider than the vessel."""
END_RADII, ENDS = 4.0, 0.43
"""Within so many radii of its nearest place the middle of a piece lies farther away than this share of them, if the
piece ends there: half of the distance for the end of a tube, a quarter for its side."""
APART = doubt_kind(
    "witness.separate-piece",
    Grade.LOOK,
    "vessel(s) {vessels}: a separate piece of lumen ({share:.0%} of the tree's) begins {gap:.2g} cm away, which a "
    "bubble, a gap or low contrast may have cut off; it is not in the network: {remedy}",
    "look there, and lower the threshold or mend the mask if it belongs to the tree",
)
ELSEWHERE = note_kind(
    "image.separate-pieces",
    "{count} separate piece(s) of the image are as bright as the vessels ({share:.0%} of their voxels), as bones and "
    "other trees are, and not in the network",
)


def topology_doubts(
    tree: Tree, skeleton: Branches, spacing: float, all_ends: bool, min_lengths: np.ndarray | None = None
) -> list[Doubt]:
    """Return where the tree's ends and junctions differ from those of the skeleton.

    Parameters
    ----------
    tree : Tree
    skeleton : Branches
    spacing : float
        Voxel size, cm.
    all_ends : bool
        Whether the tree should have every end of the lumen; not so where the user chose outlets or edited.
    min_lengths : float array, shape (vessel,), optional
        How short each vessel may be, cm; else it is as long as its line.
    """
    tips = np.setdiff1d(np.arange(len(skeleton.parent)), skeleton.parent)
    pairs = _paired(tree, skeleton, tips, spacing)
    lost = [row for row in tree.terminals if row not in pairs]
    spare = [tip for tip in tips.tolist() if tip not in pairs.values()]
    doubts = []
    if lost:
        doubts.append(_doubt(NOT_SEEN, tree, lost))
    if spare and all_ends:
        places = skeleton.end[spare]
        finding = MORE_ENDS(ends=len(spare), places="; ".join(map(written, places)))
        doubts.append(Doubt("topology", finding, _names(_nearest(tree, places)), places))
    lengths = np.array([line.length for line in tree.lines]) if min_lengths is None else min_lengths
    return doubts + _junction_doubts(tree, skeleton, pairs) + _short_doubts(tree, lengths)


def _paired(tree: Tree, skeleton: Branches, tips: np.ndarray, spacing: float) -> dict[int, int]:
    """Return the skeleton's tip of each terminal vessel that has one."""
    ends = np.array([tree.lines[row].points[-1] for row in tree.terminals])
    reach = [NEAR[0] * tree.lines[row].typical_radius + NEAR[1] * spacing for row in tree.terminals]
    gap = np.linalg.norm(ends[:, None] - skeleton.end[tips][None], axis=2) / np.array(reach)[:, None]
    rows, columns = linear_sum_assignment(np.minimum(gap, 10.0))
    return {
        tree.terminals[row]: int(tips[column])
        for row, column in zip(rows, columns, strict=True)
        if gap[row, column] < 1
    }


def _junction_doubts(tree: Tree, skeleton: Branches, pairs: dict[int, int]) -> list[Doubt]:
    """Return a doubt about inner vessels that carry blood to other ends than any branch of the skeleton does."""
    ours = _beyond(tree.parent, {row: row for row in pairs})
    theirs = set(_beyond(skeleton.parent, {tip: row for row, tip in pairs.items()}).values())
    differing_rows = [
        row for row, ends in ours.items() if len(ends) > 1 and ends not in theirs and not _is_short(tree, row)
    ]
    return [_doubt(OTHER_JOINTS, tree, differing_rows)] if differing_rows else []


def _short_doubts(tree: Tree, lengths: np.ndarray) -> list[Doubt]:
    """Return a doubt about inner vessels so short that their two junctions may be one, whatever the witness sees."""
    inner = [row for row in range(len(tree)) if row not in tree.terminals and row != tree.root]
    short = [row for row in inner if lengths[row] <= LONG * tree.lines[row].typical_radius]
    return [_doubt(SHORT, tree, short, radii=LONG)] if short else []


def _is_short(tree: Tree, row: int) -> bool:
    return tree.lines[row].length <= LONG * tree.lines[row].typical_radius


def _beyond(parent: np.ndarray, names: dict[int, int]) -> dict[int, frozenset[int]]:
    """Return the names of the named rows at or beyond each row."""
    ends_beyond: dict[int, set[int]] = {row: set() for row in range(len(parent))}
    for row, name in names.items():
        ancestor = row
        while ancestor >= 0:
            ends_beyond[ancestor].add(name)
            ancestor = int(parent[ancestor])
    return {row: frozenset(ends) for row, ends in ends_beyond.items()}


def _nearest(tree: Tree, places: np.ndarray) -> list[int]:
    """Return the vessels nearest to `places`."""
    gaps = [np.linalg.norm(tree.line.points - place, axis=1).argmin() for place in places]
    return sorted({int(tree.owner[point]) for point in gaps})


def _doubt(kind: FindingKind, tree: Tree, rows: list[int], **values: Value) -> Doubt:
    """Return a doubt about the vessels in `rows`, which are shown by their ends."""
    finding = kind(vessels=", ".join(_names(rows)), **values)
    return Doubt("topology", finding, _names(rows), np.array([tree.lines[row].points[-1] for row in rows]))


def _names(rows: list[int]) -> tuple[str, ...]:
    """Return the names that a measured tree gives to its `rows`."""
    return tuple(str(row + 1) for row in rows)


def crossing_doubts(tree: Tree) -> list[Doubt]:
    """Return a doubt for each pair of vessels, neither beyond the other, that could be one vessel passing by."""
    directions = np.array(
        [_direction(line, begin) for line, (begin, _) in zip(tree.lines, clear_stretches(tree), strict=True)]
    )
    begins = np.array([line.points[0] for line in tree.lines])
    reach = BEGINS * np.add.outer(*[[line.typical_radius for line in tree.lines]] * 2)
    passing = (directions @ directions.T < np.cos(np.radians(STRAIGHT))) & (cdist(begins, begins) < reach)
    doubts = []
    for first, second in np.argwhere(np.triu(passing, 1)).tolist():
        if not (_is_beyond(tree, first, second) or _is_beyond(tree, second, first)):
            doubts.append(_doubt(PASSING, tree, [first, second]))
    return doubts


def _direction(line: Line, begin: float) -> np.ndarray:
    """Return the unit vector in which a vessel goes on from `begin`, cm along it."""
    start_index, end_index = np.searchsorted(line.run, [begin, begin + OVER * line.typical_radius])
    direction = line.points[min(end_index, len(line) - 1)] - line.points[min(start_index, len(line) - 2)]
    return np.asarray(direction / max(float(np.linalg.norm(direction)), 1e-12))


def _is_beyond(tree: Tree, row: int, ancestor: int) -> bool:
    """Whether `row` lies beyond `ancestor`."""
    while row >= 0 and row != ancestor:
        row = int(tree.parent[row])
    return row == ancestor


def apart_doubts(tree: Tree, names: tuple[str, ...], lumen: Segmentation) -> list[Doubt]:
    """Return a doubt for each piece beside the lumen that ends near a vessel of the tree.

    Warns
    -----
    VasowaveWarning
        Of all other pieces, as a note.
    """
    if not lumen.apart:
        return []
    axes, doubts, voxels, elsewhere = cKDTree(tree.line.points), [], max(int(lumen.mask.sum()), 1), []
    for piece in lumen.apart:
        away, nearest = axes.query(piece)
        gap = away - tree.line.radius[nearest]
        first = int(np.argmin(gap))
        row = tree.owner[nearest[first]]
        radius = tree.lines[row].typical_radius
        if gap[first] < GAP * radius + 2 * lumen.spacing and _ends_at(piece, piece[first], radius):
            finding = APART(vessels=names[row], share=len(piece) / voxels, gap=max(float(gap[first]), 0.0))
            doubts.append(Doubt("topology", finding, (names[row],), piece[first : first + 1]))
        else:
            elsewhere.append(len(piece))
    if elsewhere:
        warn(ELSEWHERE(count=len(elsewhere), share=sum(elsewhere) / voxels))
    return doubts


def _ends_at(piece: np.ndarray, place: np.ndarray, radius: float) -> bool:
    """Whether a piece ends at a place of it, cm, as a tube of about that radius would."""
    neighborhood = piece[np.linalg.norm(piece - place, axis=1) < END_RADII * radius]
    return bool(np.linalg.norm(neighborhood.mean(axis=0) - place) > ENDS * END_RADII * radius)
