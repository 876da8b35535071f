"""Places as they are written and read, lines and trees of them, and the tables that hold them."""

import numpy as np
import pytest
from made_tree import forked_tree

from vasowave.errors import InputError
from vasowave.imaging import matching, places
from vasowave.imaging.exchange.centerlines import read_centerlines
from vasowave.imaging.exchange.tables import write_author_tables, write_network_table, write_points
from vasowave.imaging.measure.measurement import measured_alone
from vasowave.imaging.places import Frame, parse_place, parse_places, parse_region, read_places, written
from vasowave.imaging.tree import (
    Line,
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
