"""Points joined by edges, in any order, as one tree seen from its root."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from vasowave.errors import InputError
from vasowave.findings import look_kind, warn
from vasowave.imaging.axes.skeleton import Skeleton
from vasowave.imaging.places import written
from vasowave.imaging.tree import Line

SEPARATE_TREES = look_kind(
    "lines.separate-trees",
    "{trees} separate trees: the largest is taken, {left} of {points} points are left",
    "Join the trees where they are drawn, if they are one.",
)
ROOT_INSIDE = look_kind(
    "lines.root-inside",
    "the first point lies inside the tree: the widest end, {place} cm, is the root",
    "Begin the lines at the root.",
)
LINES_LOOP = look_kind(
    "lines.loops", "the lines close {loops} loop(s); each is cut farthest from the root", "Cut them where they touch."
)


def rooted(points: Line, edges: np.ndarray, root: int | None = None) -> Skeleton:
    """Return the tree of the largest piece of `points`, from `root` or else from its widest end.

    Parameters
    ----------
    points : Line
    edges : int array, shape (edge, 2)
    root : int, optional
        A point; if it is no end of its piece, the widest end is taken instead.

    Raises
    ------
    InputError
        No edge.

    Warns
    -----
    VasowaveWarning
        Pieces that are left out; a root inside the tree; loops, which are cut.
    """
    if len(edges) == 0:
        raise InputError("no two points are joined; are these centerlines?")
    size = len(points)
    ways = coo_array((np.ones(len(edges)), edges.T), shape=(size, size)).tocsr()
    ways = (ways + ways.T).astype(bool)
    pieces, label = connected_components(ways, directed=False)
    largest = int(np.bincount(label).argmax())
    if pieces > 1:
        warn(SEPARATE_TREES(trees=int(pieces), left=int((label != largest).sum()), points=int(size)))
    degree = np.asarray(ways.sum(axis=1)).ravel()
    ends = np.flatnonzero((label == largest) & (degree == 1))
    if root is None or label[root] != largest or degree[root] != 1:
        if len(ends) == 0:
            raise InputError("the lines close a ring without an end; cut it")
        inner, root = root, int(ends[np.argmax(points.radius[ends])])
        if inner is not None:
            warn(ROOT_INSIDE(place=written(points.points[root])))
    order, above = breadth_first_order(ways, root, directed=False)
    loops = int(ways[label == largest][:, label == largest].nnz // 2 - len(order) + 1)
    if loops:
        warn(LINES_LOOP(loops=loops))
    new = np.full(size, -1)
    new[order] = np.arange(len(order))
    return Skeleton(points[order], np.where(above[order] < 0, -1, new[np.maximum(above[order], 0)]))
