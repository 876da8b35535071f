"""Lines of other programs joined to trees, on lines that are made by hand."""

import warnings

import numpy as np
import pytest

from made_tree import straight
from vasowave.base import InputError, VasowaveWarning
from vasowave.lung import Line
from vasowave.lung.exchange import merging, read_swc

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


def test_lines_from_one_junction_to_the_next_are_a_tree_from_its_widest_end():
    left, right = straight((2, 0, 0), (3, 1, 0), 0.06, 11), straight((3, -1, 0), (2, 0, 0), 0.05, 11)
    last = straight((3, 1, 0), (4, 1, 0), 0.04, 11)
    with pytest.warns(VasowaveWarning, match="the 4 lines run from one junction to the next"):
        tree = merging.merged([right, last, STEM, left])
    assert len(tree.line) == 21 + 30
    assert tree.line.points[0] == pytest.approx([0, 0, 0])
    steps = np.linalg.norm(tree.line.points[1:] - tree.line.points[tree.above[1:]], axis=1)
    assert steps.sum() == pytest.approx(2 + 2 * np.sqrt(2) + 1)
    with pytest.raises(InputError, match="share neither"):
        merging.merged([right, last, STEM, straight((7, 7, 7), (8, 8, 8), 0.1, 5)])


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
