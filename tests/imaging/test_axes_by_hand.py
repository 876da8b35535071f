"""Lines, trees, sections, junctions and ends on straight made vessels, whose answers are arithmetic."""

from itertools import product

import numpy as np
import pytest
from made_tree import forked_tree, straight

from vasowave.errors import InputError
from vasowave.imaging import matching, places
from vasowave.imaging.axes.junctions import _half_grey, _meeting_point, to_the_surface, with_met_axes
from vasowave.imaging.axes.protrusions import _calm, _highest, _outline, _prolonged, _stub_radius, _tube_radius
from vasowave.imaging.exchange.centerlines import read_centerlines, write_centerlines
from vasowave.imaging.exchange.swc import write_swc
from vasowave.imaging.exchange.tables import write_author_tables, write_network_table, write_points
from vasowave.imaging.kernels import ahead_of, encloses, in_tube, summed_on_pieces
from vasowave.imaging.lumen.segmentation import Segmentation
from vasowave.imaging.measure.measurement import measured_alone
from vasowave.imaging.places import Frame, parse_place, parse_places, parse_region, read_places, written
from vasowave.imaging.revise.edits import edited, read_edits
from vasowave.imaging.sections import across, carried, disc, medians, sampled, tangents
from vasowave.imaging.tree import (
    Line,
    Tree,
    clear_stretch,
    clear_stretches,
    free_length,
    free_stretch,
    with_inscribed_radii,
    without,
)
from vasowave.io.columns import read_columns
from vasowave.network.network import Network

TREE = forked_tree()


def said(function, *given, **more):
    with pytest.raises(InputError) as error:
        function(*given, **more)
    return str(error.value)


def test_a_line_knows_its_length_its_bends_and_its_typical_radius():
    line = Line.of(np.array([[0, 0, 0, 9.0], [0, 0, 3, 8], [0, 4, 3, 1], [0, 4, 6, 2], [0, 4, 6, 4], [0, 4, 6, 7]]))
    assert line.run.tolist() == [0, 3, 7, 10, 10, 10]
    assert line.tortuosity == pytest.approx(10 / np.hypot(4, 6))
    assert line.typical_radius == 3.0  # the median of 1, 2, 4, 7
    assert line.at(np.array([1.5, 5.0])).points.tolist() == [[0, 0, 1.5], [0, 2, 3]]
    assert line.at(np.array([5.0])).radius.tolist() == [4.5]
    assert len(line.then(line[:2], line[[0]])) == 9
    assert Line(np.zeros((2, 3)), np.ones(2)).tortuosity == 0.0


def test_rows_of_a_tree_and_what_is_merged_moved_or_scaled():
    assert (TREE.root, TREE.terminals, TREE.daughters(1).tolist()) == (0, (2, 3, 4), [3, 4])
    assert np.bincount(TREE.owner).tolist() == [41] * 5
    merged = TREE.merged(1)
    assert merged.parent.tolist() == [-1, 0, 0, 0]
    twice = TREE.times(2.0)
    assert twice.lines[1].points[-1].tolist() == [0, 2, 4]
    assert twice.lines[1].radius[0] == pytest.approx(0.16)
    there = TREE.moved(lambda points: points + 1)
    assert there.lines[1].points[-1].tolist() == [1, 2, 3]
    assert there.lines[1].radius[0] == 0.08
    backward = without(TREE.lines, np.array([-1, 3, 0, 0, 3]), {4})
    assert backward.parent.tolist() == [-1, 0, 0, 2]
    assert backward.lines[3] is TREE.lines[1]
    inscribed = with_inscribed_radii([TREE.lines[0].points], np.array([-1]), np.array([[0.0, 0.3, 0.0], [0, -0.1, 1]]))
    assert inscribed.lines[0].radius[[0, -1]] == pytest.approx([0.3, 0.1])


def test_free_stretches_leave_balls_and_ends_and_the_tubes_of_sisters():
    """2 and 3 leave each other at a right angle: 3 lies in the tube of 2 within 0.08 + 0.025 of it."""
    assert free_stretch(TREE.lines[0], False) == pytest.approx((0.1, 0.9))
    assert free_stretch(TREE.lines[2], True) == pytest.approx((0.05, np.sqrt(2) - 0.05))
    tapered = Line(TREE.lines[0].points, np.linspace(0.2, 0.1, 41))
    assert free_stretch(tapered, False) == pytest.approx((0.2, 0.9))
    assert free_stretch(tapered, True)[1] == pytest.approx(1 - np.median(tapered.radius[13:]))
    begin, end = clear_stretch(TREE, 2, (0.05, 1.3))
    step = np.sqrt(2) / 40
    assert begin == pytest.approx(step * np.ceil(0.105 / step))
    assert end == 1.3
    assert clear_stretches(TREE)[0] == pytest.approx((0.1, 0.9))
    beside = Tree((TREE.lines[0], straight((1, 0, 0), (2, 0, 0), 0.1), straight((1, 0.05, 0), (2, 0.05, 0), 0.1)),
                  np.array([-1, 0, 0]))  # fmt: skip
    assert clear_stretch(beside, 2, (0.1, 0.9))[0] == pytest.approx(0.5)  # no more than half is given up
    assert free_length(beside)[2] == pytest.approx(0.4)
    short = Tree((straight((0, 0, 0), (0.1, 0, 0), 0.1),), np.array([-1]))
    assert free_length(short).tolist() == [0.0]


def test_vectors_across_an_axis_and_along_it():
    points = np.array([[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 2, 1], [0, 3, 1.0]])
    assert tangents(points, 1)[[0, 1, 4]] == pytest.approx(
        np.array([[0, 0, 1], [0, 0.70710678, 0.70710678], [0, 1, 0]])
    )
    assert tangents(points)[0] == pytest.approx(np.array([0, 2, 1]) / np.sqrt(5))
    axes = np.array([[0, 0.6, 0.8], [1, 0, 0], [0.36, 0.48, 0.8]])
    for u, v in (across(axes), carried(axes)):
        assert np.einsum("ij,ij->i", u, axes) == pytest.approx(0, abs=1e-12)
        assert np.linalg.norm(u, axis=1) == pytest.approx(1)
        assert v == pytest.approx(np.cross(axes, u))
    small = np.array([[0, 0, 1], [0, 0.01, 1.0], [0.01, 0.01, 1.0]])
    u, _ = carried(small / np.linalg.norm(small, axis=1, keepdims=True))
    assert (np.einsum("ij,ij->i", u[1:], u[:-1]) > 0.999).all()


def test_a_disc_is_the_grid_within_its_reach():
    found = {tuple(one) for one in disc(1.0, 0.5).tolist()}
    assert found == {(a / 2, b / 2) for a, b in product(range(-2, 3), repeat=2) if a * a + b * b <= 4}
    grey = np.arange(60.0).reshape(3, 4, 5)
    places = np.array([[1.0, 2.0, 3.25], [9, 9, 9]])
    assert sampled(grey, 0.1 * places + 1, np.ones(3), 0.1) == pytest.approx([33.25, 59])
    values = np.array([[5.0, 1, 9, 3], [5, 1, 9, 3]])
    assert medians(values, np.array([[True] * 4, [True, True, True, False]])).tolist() == [4, 5]


def test_axes_meet_where_their_lines_do():
    """Three arms whose lines meet at (0, 0.02, -0.01), though they begin at the origin."""
    at = np.array([0.0, 0.02, -0.01])
    ways = np.array([[0, 0, -1.0], [0, 0.6, 0.8], [0.6, 0, 0.8]])
    arms = []
    for way in ways:
        points = np.vstack([np.zeros(3), at + way * np.linspace(0.1, 1, 46)[:, None]])
        arms.append(Line(points, np.full(47, 0.1)))
    stretches = [(0.12, 0.9)] * 3
    assert _meeting_point(arms, stretches, 0.1) == pytest.approx(at, abs=1e-9)
    assert _meeting_point(arms, [(0.12, 0.14), (0.12, 0.9), (0.12, 0.9)], 0.1) == pytest.approx(at, abs=1e-9)
    assert _meeting_point(arms, [(0.12, 0.14), (0.12, 0.14), (0.12, 0.9)], 0.1) is None
    alike = [arms[0], Line(-arms[0].points, arms[0].radius)]
    assert _meeting_point(alike, stretches[:2], 0.1) is None  # two on one line meet everywhere
    far = [Line(arm.points + np.array([0, 0.3, 0]) * (np.arange(47) > 0)[:, None], arm.radius) for arm in arms]
    assert _meeting_point(far, stretches, 0.1) is None  # beyond 2.5 radii
    moved = with_met_axes(TREE)
    assert moved.lines[0].points[-1] == pytest.approx([0, 0, 1], abs=1e-6)
    assert moved.lines[3].points[0] == pytest.approx([0, 1, 2], abs=1e-6)


def wall(length=2.3, radius=0.1):
    """Return points of a tube along x with a flat end."""
    x, turn = np.meshgrid(np.linspace(0, length, 120), np.linspace(0, 2 * np.pi, 24, endpoint=False), indexing="ij")
    side = np.column_stack([radius * np.cos(turn).ravel(), radius * np.sin(turn).ravel(), x.ravel()])
    a, b = (0.02 * one.ravel() for one in np.meshgrid(np.arange(-4, 5), np.arange(-4, 5)))
    cap = np.column_stack([a, b, np.full(81, length)])[np.hypot(a, b) < radius]
    return np.concatenate([side, cap])


def test_an_end_goes_straight_on_to_the_surface_ahead():
    line = straight((0, 0, 0), (2.2, 0, 0), 0.1, 111)
    bent = Line(line.points + np.where(line.run > 2.12, line.run - 2.12, 0)[:, None] * [0, 1, 0], line.radius)
    found = to_the_surface(bent, wall())
    assert found.points[-1] == pytest.approx([0, 0, 2.3], abs=0.01)
    assert found.radius[-1] == 0.0
    assert found.radius[-2] <= 0.1
    assert found.length == pytest.approx(2.3, abs=0.02)
    assert to_the_surface(line, np.array([[0.0, 0, 9]])) is line
    assert to_the_surface(line[::55], wall()) is not None


def test_an_end_moves_to_where_the_grey_falls_to_half():
    """A tube of grey 100 on 20 whose end is smeared over four voxels about x = 60.5 voxels."""
    z, y, x = np.indices((21, 21, 80))
    inside = np.hypot(z - 10, y - 10) < 6
    grey = 20 + 80 * inside * np.clip(0.5 + (60.5 - x) / 4, 0, 1)
    lumen = Segmentation(inside, grey, np.zeros(3, int), 0.01, np.zeros(3), 60.0, 20.0, 1.0)

    def moved(end):
        return _half_grey(straight((0.05, 0.1, 0.1), (0.01 * end, 0.1, 0.1), 0.05, 81), lumen)

    assert moved(59.5).points[-1] == pytest.approx([0.1, 0.1, 0.605], abs=2e-3)
    assert moved(61.9).points[-1] == pytest.approx([0.1, 0.1, 0.605], abs=3e-3)
    far = moved(50.0)
    assert far.points[-1] == pytest.approx([0.1, 0.1, 0.5])  # farther than two voxels


def test_own_radii_are_those_beside_junctions_and_before_flat_ends():
    line = straight((0, 0, 0), (1, 0, 0), 0.05, 101)
    radius = line.radius.copy()
    radius[:10], radius[95:] = 0.2, 0.01
    wide = Line(line.points, radius)
    assert _tube_radius(wide, (0.2, 0.9), False) == pytest.approx(0.05)
    assert _tube_radius(wide, (0.2, 0.21), False) == pytest.approx(0.05)  # its second half's largest ball
    assert _stub_radius(Line(line.points, np.linspace(0, 1, 101))) == 1.0
    grows = Line(line.points, 0.05 + 0.05 * line.run)
    at_end = _tube_radius(grows, (0.1, 0.95), True)
    assert at_end[-1] < _tube_radius(grows, (0.1, 0.95), False)[-1]
    axis, radii = _prolonged(line.points, line.radius, 0.01)
    assert len(axis) == 101 + 8
    assert axis[-1] == pytest.approx([0, 0, 1.08])
    assert radii[-1] == 0.05


def test_the_highest_of_near_tips_is_taken_first():
    points = np.array([[0.0, 0, 0], [0, 0, 1], [0, 0, 3], [0, 0, 9]])
    height = np.array([1.0, 2.0, 1.5, 0.5])
    assert _highest([0, 1, 2, 3], points, height, np.full(4, 1.5)) == [1, 2, 3]
    assert _highest([0, 1, 2, 3], points, height, np.array([0.5, 0.5, 2.5, 0.5])) == [1, 0, 3]
    assert _highest([0, 1], points, height, np.full(4, 1.0)) == [1]
    assert _outline(np.append(np.full(20, 0.3), [np.inf, -np.inf])) == pytest.approx(0.3)
    assert _outline(np.full(19, 0.3)) == 0.0
    arc = np.column_stack([np.zeros(60), 0.001 * np.arange(60.0) ** 2, np.arange(60.0)])
    assert _calm(arc) == pytest.approx(arc, abs=1e-6)
    assert _calm(arc[:3]) is not None
    bump = arc + np.exp(-0.5 * ((np.arange(60) - 30) / 2) ** 2)[:, None] * [0, 1, 0]
    assert np.abs(_calm(bump) - arc).max() < 0.5


def test_a_tree_matches_itself_whatever_the_order_of_its_daughters():
    first = Network(tuple("abcde"), [-1, 0, 0, 1, 1], [1.0, 2, 3, 4, 5], [0.1, 0.08, 0.07, 0.06, 0.05])
    turned = Network(tuple("vwxyz"), [-1, 0, 0, 2, 2], [1.0, 3, 2, 5, 4], [0.1, 0.07, 0.08, 0.05, 0.06])
    pairs = matching.match(first, turned)
    assert pairs == {0: 0, 1: 2, 2: 1, 3: 4, 4: 3}
    assert matching.unmatched(first, turned, pairs) == ([], [])
    fewer = Network(tuple("vwx"), [-1, 0, 0], [1.0, 3, 2], [0.1, 0.07, 0.08])
    some = matching.match(first, fewer)
    assert some == {0: 0, 1: 2, 2: 1}
    assert matching.unmatched(first, fewer, some) == (["d", "e"], [])
    back = matching.match(fewer, first)
    assert back == {0: 0, 2: 1, 1: 2}
    assert matching.unmatched(fewer, first, back) == ([], ["d", "e"])


@pytest.mark.parametrize(
    ("text", "zyx"),
    [
        ("1,2,3", [3, 2, 1]),
        ("1 2 3 mm", [0.3, 0.2, 0.1]),
        (" 1, 2 ,3 um", [3e-4, 2e-4, 1e-4]),
        ("-1,0,1e1", [10, 0, -1]),
    ],
)
def test_places_are_written_x_y_z_and_held_z_y_x(text, zyx):
    assert parse_place(text) == pytest.approx(zyx)


def test_what_is_no_place_is_refused(tmp_path):
    for text in ("1,2", "1,2,3,4", "1,2,x", "nan,1,2", ""):
        assert said(parse_place, text).startswith(f"'{text}' is not a place; write three numbers x,y,z and perhaps")
    assert "s" in said(parse_place, "1,2,3 s")
    assert said(places.place, [1.0, np.inf, 2]) == "the place (1.0, inf, 2) is not finite"
    assert said(parse_region, "1,2,3").startswith("region '1,2,3': no such file, and no box x,y,z:x,y,z")
    low, high = parse_region("1,2,3:4,5,6 mm")
    assert (low.tolist(), high == pytest.approx([0.6, 0.5, 0.4])) == ([3, 2, 1], True)
    (tmp_path / "p.csv").write_text("x [mm],y [mm],z [cm]\n1,2,3\n4,5,6\n")
    assert read_places(tmp_path / "p.csv") == pytest.approx(np.array([[3, 0.2, 0.1], [6, 0.5, 0.4]]))
    assert parse_places(["1,2,3", str(tmp_path / "p.csv")]).shape == (3, 3)
    assert parse_places([]) is None
    assert parse_region(str(tmp_path / "p.csv")) == tmp_path / "p.csv"
    assert written(np.array([0.1, -2.00004, 3.000004])) == "3,-2.00004,0.1"
    turn = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, 1]])
    with places.written_in_the_world(Frame(np.zeros(3), turn)):
        assert written(np.array([0.1, 0.2, 0.3])) == "0.3,0.1,0.2"
    assert written(np.array([0.1, 0.2, 0.3])) == "0.3,0.2,0.1"


def test_lines_come_back_from_every_file_they_are_written_to(tmp_path):
    write_centerlines(TREE, tmp_path / "a.vtp", 0.1)
    write_swc(TREE, tmp_path / "a.swc")
    for path, unit in ((tmp_path / "a.vtp", 0.1), (tmp_path / "a.swc", 1e-4)):
        back = read_centerlines(path, unit, cut="identical")
        order = [
            int(np.argmin([np.abs(one.points[-1] - line.points[-1]).sum() for one in back.lines]))
            for line in TREE.lines
        ]
        for row, line in zip(order, TREE.lines, strict=True):
            assert back.lines[row].points == pytest.approx(line.points, abs=1e-6)
            assert back.lines[row].radius[1:] == pytest.approx(line.radius[1:], abs=1e-6)
    assert (tmp_path / "a.swc").read_text().splitlines()[1:4] == [
        "# points: 201", "1 0 0 0 0 1000 -1", "2 0 250 0 0 1000 1"
    ]  # fmt: skip


def test_a_flat_table_of_points_is_cut_where_it_jumps(tmp_path):
    rows = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0), (0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0), (2, 2, 0)]
    text = "x,y,z,r\n" + "".join(f"{x},{y},{z},0.6\n" for x, y, z in rows)
    (tmp_path / "f.csv").write_text(text)
    found = read_centerlines(tmp_path / "f.csv", 0.1)
    assert sorted(round(line.length, 6) for line in found.lines) == pytest.approx([0.1, 0.2, 0.2])
    (tmp_path / "u.csv").write_text(text.replace("x,y,z,r", "x [mm],y [mm],z [mm],r [mm]"))
    again = read_centerlines(tmp_path / "u.csv", 7.0)
    assert sorted(round(line.length, 6) for line in again.lines) == pytest.approx([0.1, 0.2, 0.2])
    (tmp_path / "w.csv").write_text(text.replace("x,y,z,r", "x [mm],y [cm],z [mm],r"))
    assert said(read_centerlines, tmp_path / "w.csv", 1.0).endswith(
        "x, y and z are in different units (cm, mm); write one for all"
    )
    for unit in (0.0, -1.0, np.inf, np.nan):
        assert said(read_centerlines, tmp_path / "f.csv", unit).startswith(f"unit {unit} cm: give the file's unit of")


def test_tables_of_a_network_hold_sizes_points_and_daughters(tmp_path):
    measured = measured_alone(TREE)
    write_network_table(measured, tmp_path / "n.csv")
    table = read_columns(tmp_path / "n.csv")
    assert [row[0] for row in table.cells] == ["1", "2", "3", "4", "5"]
    assert [row[1] for row in table.cells] == ["", "1", "1", "2", "2"]
    assert [float(row[2]) for row in table.cells] == pytest.approx([1, *[np.sqrt(2)] * 3, 1])
    assert {row[table.find("radius_reliable")] for row in table.cells} <= {"yes", "no"}
    write_points(TREE, tuple("abcde"), tmp_path / "p.csv")
    rows = (tmp_path / "p.csv").read_text().splitlines()
    assert rows[:2] == ["vessel,x [cm],y [cm],z [cm],radius [cm]", "a,0,0,0,0.1"]
    assert rows[-1] == "e,3,1,0,0.03"
    assert len(rows) == 1 + 5 * 41
    three = Network(tuple("abcde"), [-1, 0, 0, 0, 1], np.arange(1.0, 6), 0.1 * np.arange(1.0, 6))
    write_author_tables(three, tmp_path / "c.csv", tmp_path / "d.csv")
    assert (tmp_path / "c.csv").read_text().split() == ["vessel,left,right,daughter3", "a,b,c,d", "b,e,,"]
    assert (tmp_path / "d.csv").read_text().splitlines()[:3] == ["vessel,r0 [cm],L [cm]", "a,0.1,1.0", "b,0.2,2.0"]


def edits(tmp_path, text):
    (tmp_path / "e.txt").write_text(text)
    return read_edits(tmp_path / "e.txt")


def test_edits_find_the_vessel_within_three_radii(tmp_path):
    assert len(edited(TREE, edits(tmp_path, "remove 0.5 0.299 0\n")[:0])) == 5
    cut = edited(TREE, edits(tmp_path, "# far\nunit mm\ncut 20 -8.6 0\n"))  # 3 has a radius of 0.5 mm
    assert cut.lines[2].points[-1] == pytest.approx([0, -0.925, 1.925], abs=0.03)
    far = edits(tmp_path, "remove 2.5 -1 0\n")
    assert said(edited, TREE, far).endswith(
        "line 1: no vessel at 2.5,-1,0 cm; the nearest axis passes 0.5 cm away at 2,-1,0"
    )
    assert "this is the root; without it there is no tree" in said(edited, TREE, edits(tmp_path, "remove 0.2 0 0\n"))
    assert "the place is where the vessel begins; use 'remove'" in said(edited, TREE, edits(tmp_path, "cut 0 0 0\n"))
    assert "an inner vessel a point, but this is a root" in said(edited, TREE, edits(tmp_path, "merge 0.2 0 0\n"))
    assert "but this is a terminal vessel; use 'remove'" in said(edited, TREE, edits(tmp_path, "merge 3 1 0\n"))
    moved = edited(TREE, edits(tmp_path, "move 0.9 0 0 1 0 0.2\n"))
    assert moved.lines[0].points[20] == pytest.approx([0.1, 0, 0.5])
    assert moved.lines[1].points[20] == pytest.approx([0.1, 0.5, 1.5])
    assert moved.lines[2].points[-1] == pytest.approx([0, -1, 2])
    inlet = edited(TREE, edits(tmp_path, "move 0.4 0 0 0 0.1 0\n"))
    assert inlet.lines[0].points[[0, 20, 40], 1] == pytest.approx([0.1, 0.05, 0])
    said_of_long = said(edited, TREE, edits(tmp_path, "move 0.9 0 0 2.1 0 0\n"))
    assert "the move of 1.1 cm is longer than the shortest vessel that ends there (1 cm)" in said_of_long


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("remove 1 2 3\n\nunit\n", ", line 3: 'unit' takes one word: cm, mm or um"),
        ("unit s\n", ", line 1: 's' is not a unit of length"),
        ("rmove 1 2 3\n", ", line 1: unknown edit 'rmove' (did you mean 'remove'?); there are: unit, "),
        ("root 1 2 3\nroot 1 2 4\n", ", line 2: a second root; a tree has one"),
        ("cut 1 2 3\nmerge 1 2 3\ncut 1 2 3\n", ", line 3: the same edit as "),
        ("cut 1 2\n", ", line 1: 'cut' takes "),
        ("radius 1 2 3 0\n", ", line 1: 'radius' takes "),
        ("move 1 2 3\n", ", line 1: 'move' takes "),
        ("cut\n", ", line 1: 'cut' takes "),
    ],
)  # fmt: skip
def test_an_edit_that_is_none_is_refused_with_its_line(tmp_path, text, words):
    assert said(edits, tmp_path, text).partition("e.txt")[2].startswith(words)


def test_kernels_of_images_do_what_a_few_lines_of_numpy_do():
    rng = np.random.default_rng(7)
    solid = np.pad(np.ones((3, 3, 3), bool), 1)
    hollow = solid.copy()
    hollow[2, 2, 2] = False
    open_ = hollow.copy()
    open_[1, 2, 2] = False
    assert [bool(encloses(one)) for one in (solid, hollow, open_)] == [False, True, False]
    middles, points = rng.normal(size=(5, 3)), rng.normal(size=(30, 3))
    where, reach = middles[:, None] + 0.4 * rng.normal(size=(5, 12, 3)), rng.uniform(0.1, 0.6, 30)
    gaps = np.linalg.norm(where[:, :, None] - points, axis=3)
    nearest = gaps.argmin(axis=2)
    assert np.array_equal(in_tube(where, middles, points, reach), gaps.min(axis=2) < reach[nearest])
    axis = np.array([0.6, 0.0, 0.8])
    along = (points - 0.1) @ axis
    aside = np.linalg.norm(points - 0.1 - along[:, None] * axis, axis=1)
    expected = along[(along > 0) & (along < 1.5) & (aside < 0.9)]
    assert ahead_of(points, np.full(3, 0.1), axis, 1.5, 0.9) == pytest.approx(expected)
    place, share, gap, weight = np.array([0, 2, 0]), rng.uniform(size=3), rng.normal(size=3), rng.uniform(size=3)
    normal = rng.normal(size=(3, 3))
    squares, pull = summed_on_pieces(place, normal, share, gap, weight, 3)
    for piece in range(3):
        one, two = np.zeros((8, 8)), np.zeros(8)
        for foot in np.flatnonzero(place == piece):
            parts = np.array([1 - share[foot], share[foot]])
            change = np.concatenate([-parts[0] * normal[foot], -parts[1] * normal[foot], -parts])
            one, two = one + weight[foot] * np.outer(change, change), two - weight[foot] * change * gap[foot]
        assert squares[piece] == pytest.approx(one)
        assert pull[piece] == pytest.approx(two)
