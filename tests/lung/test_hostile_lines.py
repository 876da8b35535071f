"""Centerlines and edits with too many or too few numbers, cut off, or made to fill the memory."""

import json
import os

import numpy as np
import pytest

from fuzzing.vessels import bomb, edits, markups, tree, vtk
from vasowave.base import InputError, VasowaveWarning
from vasowave.lung import Line
from vasowave.lung.exchange import read_centerlines, read_polydata, require_radii, write_swc
from vasowave.lung.revise import read_edits

SWC = "1 3 0 0 0 4 -1\n2 3 3 0 0 4 1\n3 3 6 0 0 4 2\n4 3 6 4 0 3 3\n5 3 6 0 5 2 3\n"


def lines_of(path):
    content = path.read_text().splitlines(keepends=True)
    return next(i for i, line in enumerate(content) if line.startswith("POINTS")), content


def test_a_doubled_line_of_numbers_in_a_vtk_text_shifts_nothing(tmp_path):
    vtk(tmp_path / "c.vtk", binary=False)
    first, content = lines_of(tmp_path / "c.vtk")
    for row in range(first + 1, len(content)):
        if content[row][0].isalpha():
            continue
        (tmp_path / "d.vtk").write_text("".join([*content[: row + 1], *content[row:]]))
        with pytest.raises(InputError, match=r"d\.vtk: surplus numbers"):
            read_polydata(tmp_path / "d.vtk")


def test_a_lost_line_of_a_vtk_text_is_noticed(tmp_path):
    vtk(tmp_path / "c.vtk", binary=False)
    first, content = lines_of(tmp_path / "c.vtk")
    for row in range(first, len(content)):
        (tmp_path / "d.vtk").write_text("".join([*content[:row], *content[row + 1 :]]))
        with pytest.raises(InputError, match=r"d\.vtk"):
            read_centerlines(tmp_path / "d.vtk", unit=0.1)


def test_a_vtp_block_that_says_24_kb_and_unpacks_to_gigabytes_is_stopped(tmp_path):
    (tmp_path / "bomb.vtp").write_bytes(bomb(1 << 28))
    with pytest.raises(InputError, match=r"bomb\.vtp: a block does not hold the 24000 bytes"):
        read_polydata(tmp_path / "bomb.vtp")


def test_an_swc_cut_within_its_last_parent_is_suspected_aloud(tmp_path):
    (tmp_path / "cut.swc").write_text(SWC.removesuffix("3\n") + "2")
    with pytest.warns(VasowaveWarning, match="no line end; was the file cut off"):
        read_centerlines(tmp_path / "cut.swc", unit=1)


def test_an_swc_of_ours_that_lost_points_is_refused_wherever_it_is_cut(tmp_path):
    write_swc(tree(), tmp_path / "c.swc")
    content = (tmp_path / "c.swc").read_text().splitlines(keepends=True)
    for end in range(4, len(content)):
        (tmp_path / "d.swc").write_text("".join(content[:end]))
        with pytest.raises(InputError, match=r"points where its first lines announce 56; was it cut off"):
            read_centerlines(tmp_path / "d.swc", unit=1e-4)


@pytest.mark.parametrize("number", ["nan", "inf", "1e308", "2.5"])
@pytest.mark.parametrize("column", [0, 6])
def test_a_point_of_an_swc_whose_number_is_no_whole_number_is_refused(tmp_path, number, column):
    rows = [line.split() for line in SWC.splitlines()]
    rows[3][column] = number
    (tmp_path / "c.swc").write_text("".join(" ".join(row) + "\n" for row in rows))
    with pytest.raises(InputError, match=r"line 4(: the numbers of a point|, column '\d': (nan|inf) is not a finite)"):
        read_centerlines(tmp_path / "c.swc", unit=1)


def test_a_curve_with_a_position_that_is_no_number_or_nested_without_end_is_refused(tmp_path):
    markups(tmp_path / "c.mrk.json")
    content = json.loads((tmp_path / "c.mrk.json").read_text())
    content["markups"][2]["controlPoints"][3]["position"][1] = float("nan")
    (tmp_path / "c.mrk.json").write_text(json.dumps(content))
    with pytest.raises(InputError, match="position that is not finite"):
        read_centerlines(tmp_path / "c.mrk.json", unit=0.1)
    (tmp_path / "c.mrk.json").write_text("[" * 100_000)
    with pytest.raises(InputError, match="not a markups file"):
        read_centerlines(tmp_path / "c.mrk.json", unit=0.1)


def test_points_that_were_exchanged_or_lost_their_sign_are_told(tmp_path):
    vtk(tmp_path / "c.vtk", binary=False)
    first, content = lines_of(tmp_path / "c.vtk")
    turned = content[first + 9].replace(" ", " -")
    exchanged = [*content[: first + 5], content[first + 25], *content[first + 6 : first + 25], content[first + 5]]
    for rows in ([*content[: first + 9], turned, *content[first + 10 :]], [*exchanged, *content[first + 26 :]]):
        (tmp_path / "d.vtk").write_text("".join(rows))
        with pytest.warns(VasowaveWarning) as told:
            read_centerlines(tmp_path / "d.vtk", unit=0.1)
        assert any("far from their neighbors" in str(one.message) for one in told)


@pytest.mark.parametrize("name", ["c.vtp", "c.vtk", "c.swc", "c.mrk.json", "c.csv"])
def test_a_pipe_is_no_file_of_centerlines(tmp_path, name):
    os.mkfifo(tmp_path / name)
    with pytest.raises(InputError, match="is a pipe or a device"):
        read_centerlines(tmp_path / name, unit=1)


def test_an_edit_that_stands_there_twice_is_refused_and_a_lost_end_is_told(tmp_path):
    edits(tmp_path / "e.txt")
    text = (tmp_path / "e.txt").read_text()
    (tmp_path / "e.txt").write_text(text + "remove 1.40 .62 0.77 \nunit cm\nremove 1.4 0.62 0.77\n")
    with pytest.raises(InputError, match=r"line 8: the same edit as .*, line 3"):
        read_edits(tmp_path / "e.txt")
    (tmp_path / "e.txt").write_text(text.removesuffix("\n"))
    with pytest.warns(VasowaveWarning, match="no line end; was the file cut off"):
        assert len(read_edits(tmp_path / "e.txt")) == 4
    (tmp_path / "e.txt").unlink()
    os.mkfifo(tmp_path / "e.txt")
    with pytest.raises(InputError, match=r"the edits cannot be read .*pipe"):
        read_edits(tmp_path / "e.txt")


def test_points_that_lie_beyond_every_scanner_are_refused_where_numbers_were_deleted(tmp_path):
    """Bytes that are missing shift all numbers after them; what they mean then may be any number."""
    lines = [Line(np.array([[0.0, 0, 0], [0, 0, far]]), np.full(2, 0.1)) for far in (1.0, 1e300)]
    with pytest.raises(InputError, match=r"a point or a radius beyond 100000 cm; damaged, or the unit is wrong"):
        require_radii(tmp_path / "a.vtk", lines[1])
    require_radii(tmp_path / "a.vtk", lines[0])
