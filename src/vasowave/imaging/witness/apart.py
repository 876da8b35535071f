"""Pieces of lumen that hang together with nothing, and begin where a vessel of the tree could go on."""

import numpy as np
from scipy.spatial import cKDTree

from vasowave.findings import note_kind, warn
from vasowave.imaging.lumen.segmentation import Segmentation
from vasowave.imaging.tree import Tree
from vasowave.imaging.witness.doubts import Doubt, Grade, doubt_kind

GAP = 2.0
"""A piece may begin so many radii of the nearest vessel away from its wall: a bubble is no wider than the vessel."""
ROUND, ENDS = 4.0, 0.43
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
        away, near = axes.query(piece)
        gap = away - tree.line.radius[near]
        first = int(np.argmin(gap))
        row = tree.owner[near[first]]
        own = tree.lines[row].typical_radius
        if gap[first] < GAP * own + 2 * lumen.spacing and _ends_at(piece, piece[first], own):
            found = APART(vessels=names[row], share=len(piece) / voxels, gap=max(float(gap[first]), 0.0))
            doubts.append(Doubt("topology", found, (names[row],), piece[first : first + 1]))
        else:
            elsewhere.append(len(piece))
    if elsewhere:
        warn(ELSEWHERE(count=len(elsewhere), share=sum(elsewhere) / voxels))
    return doubts


def _ends_at(piece: np.ndarray, place: np.ndarray, radius: float) -> bool:
    """Whether a piece ends at a place of it, cm, as a tube of about that radius would."""
    there = piece[np.linalg.norm(piece - place, axis=1) < ROUND * radius]
    return bool(np.linalg.norm(there.mean(axis=0) - place) > ENDS * ROUND * radius)
