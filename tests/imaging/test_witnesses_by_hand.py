"""What contradicts a tree, on trees that are made by hand: pieces apart, vessels that pass by, junctions that move."""

import warnings

import numpy as np
import pytest
from made_tree import forked_tree, straight

from vasowave.errors import VasowaveWarning
from vasowave.imaging.axes.junctions import _meeting_point, without_short_vessels
from vasowave.imaging.lumen.segmentation import Segmentation
from vasowave.imaging.tree import Line, Tree
from vasowave.imaging.witness.topology import (
    BEGINS,
    GAP,
    OVER,
    STRAIGHT,
    _direction,
    _is_beyond,
    apart_doubts,
    crossing_doubts,
)

NAMES = ("1", "2", "3", "4", "5")


def lumen(*pieces):
    mask = np.zeros((10, 10, 10), bool)
    mask[:5, :5, :4] = True  # a hundred voxels
    grey = np.where(mask, 100.0, 0.0)
    return Segmentation(mask, grey, np.zeros(3, int), 0.01, np.zeros(3), 50.0, 0.0, 1.0, tuple(pieces))


def piece(gap, length=0.5, count=25):
    """A straight piece, z y x, that begins `gap` beyond the wall at the end of vessel 5, at (3, 1, 0), along x."""
    x = 3 + 0.03 + gap + np.linspace(0, length, count)
    return np.column_stack([np.zeros(count), np.ones(count), x])


def told(*pieces):
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        return apart_doubts(forked_tree(), NAMES, lumen(*pieces)), [str(one.message) for one in heard]


def test_a_piece_that_ends_near_a_vessel_may_belong_to_it():
    assert told() == ([], [])
    nearest = GAP * 0.03 + 0.02  # two radii and two voxels
    (doubt,), heard = told(piece(0.99 * nearest))
    assert heard == []
    assert (doubt.about, doubt.vessels) == ("topology", ("5",))
    values = dict(doubt.finding.values)
    assert values["gap"] == pytest.approx(0.99 * nearest)
    assert values["share"] == pytest.approx(0.25)
    none, (said,) = told(piece(1.01 * nearest))
    assert none == []
    assert "1 separate piece(s)" in said
    assert "25%" in said.replace(" ", "")


def test_a_piece_that_runs_past_a_vessel_is_elsewhere():
    """Its nearest place is its middle: it ends nowhere near."""
    count = 41
    past = np.column_stack([np.linspace(-0.4, 0.4, count), np.ones(count), np.full(count, 3.05)])
    none, heard = told(past, piece(0.01))
    assert [doubt.vessels for doubt in none] == [("5",)]
    assert len(heard) == 1
    with pytest.warns(VasowaveWarning, match=r"2 separate piece\(s\)"):
        apart_doubts(forked_tree(), NAMES, lumen(past, past + np.array([5.0, 0, 0])))


def passing(turn, apart=0.0):
    """Two daughters that leave a stem one opposite the other, but for `turn` degrees and `apart` cm."""
    angle = np.radians(turn)
    stem = straight((0, -1, 0), (0, 0, 0), 0.05)
    one = straight((0, 0, 0), (2, 0, 0), 0.05, 81)
    other = straight((-apart, 0, 0), (-apart - 2 * np.cos(angle), 2 * np.sin(angle), 0), 0.05, 81)
    return Tree((stem, one, other), np.array([-1, 0, 0]))


def test_vessels_that_run_straight_into_one_another_are_doubted():
    within, beyond = 180 - STRAIGHT - 1, 180 - STRAIGHT + 1
    (doubt,) = crossing_doubts(passing(within))
    assert doubt.vessels == ("2", "3")
    assert crossing_doubts(passing(beyond)) == []
    assert len(crossing_doubts(passing(0.0, 0.99 * BEGINS * 0.1))) == 1
    assert crossing_doubts(passing(0.0, 1.01 * BEGINS * 0.1)) == []


def test_the_direction_of_a_vessel_is_taken_over_some_radii_from_where_it_is_clear():
    line = straight((0, 0, 0), (1, 0, 0), 0.1, 41).then(straight((1, 0.025, 0), (1, 1, 0), 0.1, 40))
    begin = 0.9
    near, far = np.searchsorted(line.run, [begin, begin + OVER * 0.1])
    way = line.points[min(far, 80)] - line.points[near]
    assert _direction(line, begin) == pytest.approx(way / np.linalg.norm(way))
    assert _direction(line, 9.0) == pytest.approx([0, 1, 0])  # beyond its end: its last step
    tree = forked_tree()
    assert [_is_beyond(tree, 3, other) for other in range(5)] == [True, True, False, True, False]
    assert not _is_beyond(tree, 0, 3)


def test_axes_meet_where_they_are_nearest_unless_they_hardly_cross():
    """Three axes through (0.02, 0.01, 0), whose paths end at the origin."""
    at = np.array([0.0, 0.01, 0.02])
    ways = [np.array([0.0, 0, -1]), np.array([0.0, 0.8, 0.6]), np.array([0.0, -0.8, 0.6])]
    arms = []
    for way in ways:
        run = np.linspace(0.1, 1.0, 46)
        points = np.vstack([np.zeros((1, 3)), at + run[:, None] * way])
        arms.append(Line(points, np.full(47, 0.1)))
    stretches = [(0.1, 0.9)] * 3
    assert _meeting_point(arms, stretches, 0.1) == pytest.approx(at, abs=1e-9)
    assert _meeting_point(arms[:1], stretches[:1], 0.1) is None
    assert _meeting_point([arms[0], arms[0]], stretches[:2], 0.1) is None  # one axis twice
    assert _meeting_point(arms, [(0.1, 0.15)] * 3, 0.1) is None  # fewer than four points each
    shifted = [Line(np.vstack([one.points[:1] - [0, 0, 0.3], one.points[1:]]), one.radius) for one in arms]
    assert _meeting_point(shifted, stretches, 0.1) is None  # farther than two and a half radii


def test_an_inner_vessel_shorter_than_its_radii_is_merged():
    """0.6 radii of 0.08 and the distance of points, a quarter of the length: 0.064 cm."""
    tree = forked_tree()
    assert len(without_short_vessels(tree)) == 5
    short = straight((1, 0, 0), (1.045, 0.045, 0), 0.08, 5)
    merged = without_short_vessels(tree.with_lines([tree.lines[0], short, *tree.lines[2:]]))
    assert merged.parent.tolist() == [-1, 0, 0, 0]
    longer = straight((1, 0, 0), (1.047, 0.047, 0), 0.08, 5)
    assert len(without_short_vessels(tree.with_lines([tree.lines[0], longer, *tree.lines[2:]]))) == 5
