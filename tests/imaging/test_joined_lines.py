"""Lines of other programs joined to trees, on lines that are made by hand."""

import json
import warnings

import numpy as np
import pytest
from made_tree import straight

from vasowave.errors import InputError, VasowaveWarning
from vasowave.imaging.axes.skeleton import Skeleton, cut_at_junctions, shortest
from vasowave.imaging.exchange import merging
from vasowave.imaging.exchange.markups import read_markups
from vasowave.imaging.exchange.merging import rooted
from vasowave.imaging.exchange.swc import read_swc
from vasowave.imaging.tree import Line

STEM = straight((0, 0, 0), (2, 0, 0), 0.1, 21)


def swc(path, rows, head=""):
    path.write_text(head + "".join(" ".join(map(str, row)) + "\n" for row in rows))
    return path


def test_points_of_an_swc_file_may_be_numbered_from_0(tmp_path):
    rows = [(0, 0, 0, 0, 0, 1, -1), (1, 0, 1, 0, 0, 1, 0), (2, 0, 2, 0, 0, 1, 1), (3, 0, 2, 1, 0, 1, 1)]
    found = read_swc(swc(tmp_path / "a.swc", rows), 0.1)
    assert found.above.tolist() == [-1, 0, 1, 1]
    assert found.line.points == pytest.approx(0.1 * np.array([[0, 0, 0], [0, 0, 1], [0, 0, 2], [0, 1, 2]]))
    assert found.line.radius == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("rows", "head", "said"),
    [
        ([(1, 0, 0, 0, 0, 1, -1), (1, 0, 1, 0, 0, 1, 1)], "", "a point number is used twice"),
        ([(1, 0, 0, 0, 0, 1, -1), (2, 0, 1, 0, 0, 0, 1)], "", "not finite or not positive"),
        ([(1, 0, 0, 0, 0, 1), (2, 0, 1, 0, 0, 1)], "", "has seven columns"),
    ],
)
def test_an_swc_file_that_contradicts_itself_is_refused(tmp_path, rows, head, said):
    with pytest.raises(InputError, match=said):
        read_swc(swc(tmp_path / "a.swc", rows, head), 0.1)


def test_a_line_joins_the_tree_where_it_enters_half_its_radius():
    way = straight((0, 0, 0), (0.9, 0, 0), 0.1, 10).then(straight((1.0, 0, 0), (1.0, 0.9, 0), 0.05, 19))
    found = merging.merged([STEM, way])
    joined = int(found.above[len(STEM)])
    assert STEM.points[joined] == pytest.approx([0, 0, 1.0])
    first = found.line.points[len(STEM)]
    assert first == pytest.approx([0, 0.1, 1.0])  # 0.05 is half the radius: it still is inside
    assert found.above[len(STEM) + 1 :].tolist() == list(range(len(STEM), len(found.line) - 1))
    exact = merging.merged([STEM, way], "identical")
    assert exact.line.points[len(STEM)] == pytest.approx([0, 0.05, 1.0])
    back = merging.merged([STEM[::-1], way[::-1]])
    assert np.array_equal(back.line.points, found.line.points)


def test_lines_that_share_no_end_or_do_not_meet_are_refused():
    with pytest.raises(InputError, match="share neither their first nor their last point"):
        merging.merged([STEM, straight((0, 1, 0), (2, 1, 0), 0.1, 21)])
    with pytest.raises(InputError, match="no centerline has two points"):
        merging.merged([STEM[:1]])
    with pytest.raises(InputError, match="line 1 does not meet the others"):
        merging.merged([STEM, Line(STEM.points + np.array([0, 0.09, 0]), STEM.radius)])


def test_a_line_that_runs_beside_the_tree_closes_a_loop():
    """Up to 1.5 radii beside the tree it is the same vessel."""

    def beside(gap):
        inner = STEM.points[1:20] + np.array([0, gap, 0])
        end = straight((2, 0, 0), (2, 1, 0), 0.1, 11)
        return Line(np.concatenate([STEM.points[:1], inner, STEM.points[20:]]), STEM.radius).then(end[1:])

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        merging.merged([STEM.then(straight((2, 0, 0), (4, 0, 0), 0.1, 21)[1:]), beside(0.149)])
    with pytest.warns(VasowaveWarning, match="beyond it runs up to 1.6 radii beside the tree"):
        merging.merged([STEM.then(straight((2, 0, 0), (4, 0, 0), 0.1, 21)[1:]), beside(0.16)])


def test_a_tree_is_the_largest_piece_from_its_root_or_widest_end():
    points = Line(np.column_stack([np.zeros((6, 2)), np.arange(6.0)]), np.array([1.0, 1, 1, 2, 5, 5]))
    chain = np.array([[0, 1], [1, 2], [2, 3]])
    whole = rooted(points[:4], chain, 0)
    assert (whole.line.points[0, 2], whole.above.tolist()) == (0.0, [-1, 0, 1, 2])
    widest = rooted(points[:4], chain)
    assert widest.line.points[:, 2].tolist() == [3, 2, 1, 0]
    with pytest.warns(VasowaveWarning, match=r"2 .*"):
        apart = rooted(points, np.vstack([chain, [[4, 5]]]))
    assert len(apart.line) == 4
    with pytest.warns(VasowaveWarning, match="root"):
        assert rooted(points[:4], chain, 1).line.points[0, 2] == 3.0  # no end: the widest end
    with pytest.raises(InputError, match="no two points are joined"):
        rooted(points, np.empty((0, 2), int))
    with pytest.raises(InputError, match="a ring without an end"):
        rooted(points[:3], np.array([[0, 1], [1, 2], [2, 0]]))
    with pytest.warns(VasowaveWarning, match="1 ") as told:
        rooted(points[:4], np.vstack([chain, [[1, 3]]]), 0)
    assert len(told) == 1


def markups(path, curves):
    path.write_text(json.dumps({"markups": curves}))
    return path


def curve(points, radius, system="LPS"):
    values = {"name": "Radius", "controlPointValues": list(radius)}
    return {"type": "Curve", "coordinateSystem": system, "measurements": [values],
            "controlPoints": [{"position": list(point)} for point in points]}  # fmt: skip


def test_a_curve_joins_an_earlier_one_within_its_radius(tmp_path):
    first = curve([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [0.3, 0.3, 0.3])
    joined = read_markups(markups(tmp_path / "a.json", [first, curve([(1, 0.3, 0), (1, 1, 0)], [0.1, 0.1])]), 0.1)
    assert len(joined.line) == 5
    with pytest.warns(VasowaveWarning, match="2 "):
        apart = read_markups(markups(tmp_path / "b.json", [first, curve([(1, 0.31, 0), (1, 1, 0)], [0.1, 0.1])]), 0.1)
    assert len(apart.line) == 3
    turned = read_markups(markups(tmp_path / "c.json", [curve([(0, 0, 5), (1, 2, 5)], [0.3, 0.2], "RAS")]), 0.1)
    assert turned.line.points == pytest.approx(0.1 * np.array([[5, 0, 0], [5, -2, -1.0]]))
    for wrong in (
        curve([(0, 0, 0)], [1.0]),
        curve([(0, 0, 0), (1, 0, 0)], [1.0]),
        curve([(0, 0, 0), (1, 0, 0)], [1.0, 0.0]),
    ):
        with pytest.raises(InputError, match="without a positive radius"):
            read_markups(markups(tmp_path / "d.json", [wrong]), 0.1)


def test_an_inner_vessel_shorter_than_its_collapse_is_none():
    def tree_of(inner):
        """A stem of 10 points, an inner vessel of `inner` points, and ends of 10."""
        count = 10 + inner + 30
        above = np.arange(count) - 1
        above[10 + inner] = 9  # a side branch before the inner vessel, two ends beyond it
        above[10 + inner + 10] = above[10 + inner + 20] = 9 + inner
        return Skeleton(
            Line(np.column_stack([np.zeros((count, 2)), 0.1 * np.arange(count)]), np.full(count, 0.5)), above
        )

    line = Line(np.column_stack([np.zeros((4, 2)), 0.1 * np.arange(4)]), np.full(4, 0.5))
    assert shortest(line, 0.6) == pytest.approx(0.4)
    kept, collapsed = cut_at_junctions(tree_of(5), 0.6), cut_at_junctions(tree_of(3), 0.6)
    assert (len(kept), len(collapsed)) == (5, 4)
    assert collapsed.parent.tolist() == [-1, 0, 0, 0]
    assert len(cut_at_junctions(tree_of(3), 0.0)) == 5
    point = Line(np.zeros((1, 3)), np.ones(1))
    for wrong in (Skeleton(point, np.array([-1])), Skeleton(line, np.array([-1, 0, -1, 2]))):
        with pytest.raises(InputError, match="one root is needed"):
            cut_at_junctions(wrong)
    with pytest.raises(InputError, match="2 vessels leave the first point"):
        cut_at_junctions(Skeleton(line, np.array([-1, 0, 0, 1])))


def test_an_swc_file_whose_root_forks_or_stands_twice_begins_at_an_end(tmp_path):
    """A root in the middle of a vessel, and a second tree of one point fewer."""
    fork = [(1, 0, 0, 0, 0, 1, -1), (2, 0, 1, 0, 0, 2, 1), (3, 0, -1, 0, 0, 1, 1), (4, 0, -2, 0, 0, 1, 3)]
    with pytest.warns(VasowaveWarning, match="root"):
        found = read_swc(swc(tmp_path / "a.swc", fork), 0.1)
    assert found.line.points[:, 2] == pytest.approx([0.1, 0.0, -0.1, -0.2])  # from the widest end
    with pytest.warns(VasowaveWarning, match="2 "):
        two = read_swc(
            swc(tmp_path / "b.swc", [*fork[:1], *fork[2:], (7, 0, 9, 0, 0, 1, -1), (8, 0, 9, 1, 0, 1, 7)]), 0.1
        )
    assert two.line.points[:, 2] == pytest.approx([0.0, -0.1, -0.2])
