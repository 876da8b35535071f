"""Loops of the lumen: a tree has none, touching vessels and smeared gaps make them."""

import numpy as np
from scipy.spatial import cKDTree

from vasowave.imaging.lumen.segmentation import Segmentation
from vasowave.imaging.tree import Tree


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


def loop_places(tree: Tree) -> np.ndarray:
    """Return where loops were probably opened: ends of terminals that touch a vessel other than their kin.

    Around a loop the paths meet head on, so both end there, blind inside the lumen.

    Returns
    -------
    float array, shape (place, 3)
        z, y, x, cm.
    """
    places: list[np.ndarray] = []
    index = cKDTree(tree.line.points)
    for row in tree.terminals:
        end, radius = tree.lines[row].points[-1], float(np.median(tree.lines[row].radius))
        near = np.array(index.query_ball_point(end, 3.0 * radius))
        near = near[(tree.owner[near] != row) & (tree.owner[near] != tree.parent[row])]
        if len(near) and not any(np.linalg.norm(end - place) < 6 * radius for place in places):
            places.append(end)
    return np.array(places).reshape(-1, 3)
