"""Places as they are written and read, lines of them, and the tables that hold them."""

import numpy as np
import pytest

from made_tree import forked_tree
from vasowave.base import InputError
from vasowave.base.io import read_columns
from vasowave.lung import Frame, Line, parse_place, parse_places, parse_region, places, read_places, written
from vasowave.lung.exchange import write_author_tables, write_network_table, write_points
from vasowave.lung.measure import measured_alone
from vasowave.pulse.network import Network

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
