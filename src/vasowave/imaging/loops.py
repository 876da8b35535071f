"""Loops of the lumen: a tree has none, touching vessels and smeared gaps make them."""

import numpy as np
from scipy.spatial import cKDTree

from vasowave.imaging.segmentation import Segmentation
from vasowave.imaging.tree import Tree


def loop_count(lumen: Segmentation) -> int:
    """Return the number of tunnels through the lumen: 1 - its Euler number (it is one piece without cavities)."""
    from skimage.measure import euler_number

    return 1 - int(euler_number(np.pad(lumen.mask, 1), connectivity=3))


def loop_places(tree: Tree) -> np.ndarray:
    """Return where loops were probably opened: ends of terminals that touch a vessel other than their kin.

    Around a loop the paths meet head on, so both end there, blind inside the lumen.

    Returns
    -------
    float array, shape (place, 3)
        z, y, x, cm.
    """
    points = np.concatenate([line[:, :4] for line in tree.lines])
    owner = np.repeat(np.arange(len(tree.lines)), [len(line) for line in tree.lines])
    places: list[np.ndarray] = []
    index = cKDTree(points[:, :3])
    for row in sorted(set(range(len(tree.lines))) - set(tree.parent.tolist())):
        end, radius = tree.lines[row][-1, :3], float(np.median(tree.lines[row][:, 3]))
        near = np.array(index.query_ball_point(end, 3.0 * radius))
        near = near[(owner[near] != row) & (owner[near] != tree.parent[row])]
        if len(near) and not any(np.linalg.norm(end - place) < 6 * radius for place in places):
            places.append(end)
    return np.array(places).reshape(-1, 3)
