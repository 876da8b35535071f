"""Lines of a small tree by the convention of an extraction: with balls or a surface, for ends of every kind."""

import numpy as np
import pytest
from test_tubes import walls

from approval import approve, parts
from made_tree import straight
from vasowave.base import InputError
from vasowave.lung import Line, Tree
from vasowave.lung.exchange import as_extracted


def tree(rough=0.0):
    """A stem of 0.1 forks into 0.08 and 0.06, which end in the plane; lines start on its axis."""
    rng = np.random.default_rng(1)
    lines = [
        straight((0, 0, 0), (1, 0, 0), 0.10, 41), straight((1, 0, 0), (1.9, 0.5, 0), 0.08, 41),
        straight((1, 0, 0), (1.8, -0.6, 0), 0.06, 41),
    ]  # fmt: skip
    lines = [Line(one.points, one.radius * (1 + rough * rng.uniform(-1, 1, 41))) for one in lines]
    return Tree(tuple(lines), np.array([-1, 0, 0]))


def test_approved_lines_by_the_convention_of_an_extraction():
    lines = []
    for name, given, surface, ends in (
        ("rough", tree(0.05), None, "auto"),
        ("balls", tree(), None, "ball"),
        ("surface", tree(0.05), walls(tree().lines, (0.10, 0.08, 0.06)), "wall"),
    ):
        found = as_extracted(given, surface, ends)
        lines += parts(f"{name}, SD", found.length_sd)
        for row, line in enumerate(found.tree.lines):
            numbers = [line.length, *line.points[0], *line.points[-1], line.radius[0], line.radius[-1]]
            lines.append(f"{name} {row}: " + " ".join(f"{one:.5f}" for one in numbers))
    approve("convention", lines, 2e-4, 2e-3)


def test_a_vessel_without_length_is_refused():
    point = Tree((Line(np.zeros((2, 3)), np.ones(2)),), np.array([-1]))
    with pytest.raises(InputError, match="a vessel without length: two junctions, or an end, lie at the same place"):
        as_extracted(point)
