"""The answer's tree beside the skeleton's: ends that only one has, and junctions that join other vessels."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from vasowave.imaging.places import written
from vasowave.imaging.tree import Tree
from vasowave.imaging.witness.doubts import Doubt, Grade, doubt_kind
from vasowave.imaging.witness.skeleton import Branches

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
    "look, and merge what is no vessel",
)


def topology_doubts(
    tree: Tree, skeleton: Branches, spacing: float, all_ends: bool, least: np.ndarray | None = None
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
    least : float array, shape (vessel,), optional
        How short each vessel may be, cm; else it is as long as its line.
    """
    tips = np.setdiff1d(np.arange(len(skeleton.parent)), skeleton.parent)
    pairs = _paired(tree, skeleton, tips, spacing)
    lost = [row for row in tree.terminals if row not in pairs]
    spare = [tip for tip in tips.tolist() if tip not in pairs.values()]
    doubts = []
    if lost:
        names = ", ".join(str(row + 1) for row in lost)
        places = np.array([tree.lines[row].points[-1] for row in lost])
        doubts.append(Doubt("topology", NOT_SEEN(vessels=names), _names(lost), places))
    if spare and all_ends:
        places = skeleton.end[spare]
        more = MORE_ENDS(ends=len(spare), places="; ".join(map(written, places)))
        doubts.append(Doubt("topology", more, _names(_nearest(tree, places)), places))
    lengths = np.array([line.length for line in tree.lines]) if least is None else least
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
    other = [row for row, ends in ours.items() if len(ends) > 1 and ends not in theirs and not _is_short(tree, row)]
    if not other:
        return []
    names = ", ".join(str(row + 1) for row in other)
    places = np.array([tree.lines[row].points[-1] for row in other])
    return [Doubt("topology", OTHER_JOINTS(vessels=names), _names(other), places)]


def _short_doubts(tree: Tree, lengths: np.ndarray) -> list[Doubt]:
    """Return a doubt about inner vessels so short that their two junctions may be one, whatever the witness sees."""
    inner = [row for row in range(len(tree)) if row not in tree.terminals and row != tree.root]
    short = [row for row in inner if lengths[row] <= LONG * tree.lines[row].typical_radius]
    if not short:
        return []
    found = SHORT(vessels=", ".join(str(row + 1) for row in short), radii=LONG)
    return [Doubt("topology", found, _names(short), np.array([tree.lines[row].points[-1] for row in short]))]


def _is_short(tree: Tree, row: int) -> bool:
    return tree.lines[row].length <= LONG * tree.lines[row].typical_radius


def _beyond(parent: np.ndarray, names: dict[int, int]) -> dict[int, frozenset[int]]:
    """Return the names of the named rows at or beyond each row."""
    ends_beyond: dict[int, set[int]] = {row: set() for row in range(len(parent))}
    for row, name in names.items():
        at = row
        while at >= 0:
            ends_beyond[at].add(name)
            at = int(parent[at])
    return {row: frozenset(ends) for row, ends in ends_beyond.items()}


def _nearest(tree: Tree, places: np.ndarray) -> list[int]:
    """Return the vessels nearest to `places`."""
    gaps = [np.linalg.norm(tree.line.points - place, axis=1).argmin() for place in places]
    return sorted({int(tree.owner[at]) for at in gaps})


def _names(rows: list[int]) -> tuple[str, ...]:
    """Return the names that a measured tree gives to its `rows`."""
    return tuple(str(row + 1) for row in rows)
