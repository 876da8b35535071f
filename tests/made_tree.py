"""A tree of five straight vessels, made by hand."""

import numpy as np

from vasowave.lung import Line, Tree


def straight(start, end, radius, points=41):
    """A vessel from `start` to `end`, x y z in cm; the tree holds z y x."""
    way = np.linspace(start, end, points)[:, ::-1]
    return Line(way, np.full(points, radius))


def forked_tree():
    """Root 1 forks into 2 and 3; 2 forks into 4 and 5; all in the plane z = 0.

    ::   1: (0,0)-(1,0)   2: (1,0)-(2,1)   3: (1,0)-(2,-1)   4: (2,1)-(3,2)   5: (2,1)-(3,1)
    """
    lines = (
        straight((0, 0, 0), (1, 0, 0), 0.10),
        straight((1, 0, 0), (2, 1, 0), 0.08),
        straight((1, 0, 0), (2, -1, 0), 0.05),
        straight((2, 1, 0), (3, 2, 0), 0.04),
        straight((2, 1, 0), (3, 1, 0), 0.03),
    )
    return Tree(lines, np.array([-1, 0, 0, 1, 1]))
