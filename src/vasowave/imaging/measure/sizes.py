"""Lengths and inscribed radii of the vessels: the network of a tree."""

import numpy as np

from vasowave.imaging.axes.stretches import clear_stretches
from vasowave.imaging.tree import Tree
from vasowave.network.network import Network


def network_of(tree: Tree) -> Network:
    """Return lengths and mean radii of `tree` (eq. 1); vessels are numbered from 1 in the order of the tree.

    The radius is the mean over the points outside the junctions' inscribed balls and sisters' tubes and farther than
    a radius from a free end; the median of all points where no such point exists.

    Raises
    ------
    InputError
        As `Network`.
    """
    radius = []
    for line, (begin, end) in zip(tree.lines, clear_stretches(tree), strict=True):
        away = (line.run > begin) & (line.run < end)
        radius.append(float(line.radius[away].mean()) if away.any() else line.typical_radius)
    names = tuple(str(row + 1) for row in range(len(tree)))
    return Network(names, tree.parent, np.array([line.length for line in tree.lines]), np.array(radius))
