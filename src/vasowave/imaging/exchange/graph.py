"""Points joined by edges, in any order, as one tree seen from its root."""

import warnings

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from vasowave.errors import InputError, VasowaveWarning
from vasowave.imaging.axes.skeleton import Skeleton
from vasowave.imaging.places import written
from vasowave.imaging.tree import Line


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
        _warn(
            f"{pieces} separate trees: the largest is taken, {int((label != largest).sum())} of {size} points are left"
        )
    degree = np.asarray(ways.sum(axis=1)).ravel()
    ends = np.flatnonzero((label == largest) & (degree == 1))
    if root is None or label[root] != largest or degree[root] != 1:
        if len(ends) == 0:
            raise InputError("the lines close a ring without an end; cut it")
        inner, root = root, int(ends[np.argmax(points.radius[ends])])
        if inner is not None:
            _warn(
                f"the first point lies inside the tree: the widest end, {written(points.points[root])} cm, is the root"
            )
    order, above = breadth_first_order(ways, root, directed=False)
    loops = int(ways[label == largest][:, label == largest].nnz // 2 - len(order) + 1)
    if loops:
        _warn(f"the lines close {loops} loop(s); each is cut farthest from the root")
    new = np.full(size, -1)
    new[order] = np.arange(len(order))
    return Skeleton(points[order], np.where(above[order] < 0, -1, new[np.maximum(above[order], 0)]))


def _warn(message: str) -> None:
    warnings.warn(message, VasowaveWarning, stacklevel=3)
