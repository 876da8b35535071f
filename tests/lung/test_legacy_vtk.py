"""Legacy VTK files by hand, after the format's description: every kind of array, and every count that can be wrong."""

import numpy as np
import pytest

from vasowave.base import InputError
from vasowave.lung.exchange import parse_legacy

POINTS = np.array([[0.0, 0, 0], [1, 2, 3], [4, 5, 6]])
HEAD = "# vtk DataFile Version {}\ntitle\n{}\nDATASET POLYDATA\n"
BODY = "POINTS 3 float\n0 0 0 1 2 3\n4 5 6\n"
LINES = "LINES 2 5\n2 0 1\n1 2\n"


def parsed(rest, version="3.0", body=BODY):
    return parse_legacy((HEAD.format(version, "ASCII") + body + rest).encode())


def test_lines_of_old_and_of_new_files_are_lists_of_points():
    old = parsed(LINES)
    assert np.array_equal(old.points, POINTS)
    assert [line.tolist() for line in old.lines] == [[0, 1], [2]]
    new = parsed("LINES 3 3\nOFFSETS vtktypeint64\n0 2 3\nCONNECTIVITY vtktypeint64\n0 1 2\n", "5.1")
    assert [line.tolist() for line in new.lines] == [[0, 1], [2]]
    assert [line.tolist() for line in parsed(LINES, "4.2").lines] == [[0, 1], [2]]
    assert old.fields == {}


def test_arrays_of_every_kind_have_their_widths_and_belong_to_points_or_cells():
    found = parsed(
        LINES + "\nPOINT_DATA 3\n"
        "SCALARS r float\nLOOKUP_TABLE default\n1 2 3\n"
        "SCALARS two double 2\nLOOKUP_TABLE default\n1 2 3 4 5 6\n"
        "LOOKUP_TABLE mine 2\n0 0 0 1 1 1 1 1\n"
        "COLOR_SCALARS c 2\n0 0 1 1 0 1\n"
        "NORMALS n float\n1 2 3 4 5 6 7 8 9\n"
        "TENSORS t float\n" + " ".join(map(str, range(27))) + "\n"
        "TEXTURE_COORDINATES x 2 float\n1 2 3 4 5 6\n"
        "METADATA\nINFORMATION 0\n\n"
        "CELL_DATA 2\nFIELD FieldData 3\n"
        "id 1 2 int\n7 8\n"
        "METADATA\nINFORMATION 1\nNAME x\n\n"
        "name 1 2 string\nabc\ndef\n"
        "pair 2 2 float\n1 2 3 4\n"
    )
    assert {name: values.shape for name, values in found.fields.items()} == {
        "r": (3,), "two": (3, 2), "n": (3, 3), "t": (3, 9), "x": (3, 2)}  # fmt: skip
    assert found.fields["two"].tolist() == [[1, 2], [3, 4], [5, 6]]
    assert {name: values.tolist() for name, values in found.cells.items()} == {
        "id": [7, 8], "pair": [[1, 2], [3, 4]]}  # fmt: skip


def test_binary_numbers_are_big_endian_and_end_where_their_count_ends():
    packed = np.array([2, 0, 1, 1, 2], ">i4").tobytes()
    raw = HEAD.format("3.0", "BINARY").encode() + b"POINTS 3 double\n" + POINTS.astype(">f8").tobytes()
    raw += b"\nLINES 2 5\n" + packed + b"\nPOINT_DATA 3\nSCALARS r float\nLOOKUP_TABLE default\n"
    raw += np.array([0.5, 1.5, 2.5], ">f4").tobytes() + b"\nCOLOR_SCALARS c 2\n" + bytes(6)
    raw += b"\nLOOKUP_TABLE mine 2\n" + bytes(8)
    raw += b"\nVECTORS v float\n" + np.arange(9, dtype=">f4").tobytes() + b"\n"
    found = parse_legacy(raw)
    assert np.array_equal(found.points, POINTS)
    assert [line.tolist() for line in found.lines] == [[0, 1], [2]]
    assert found.fields["r"].tolist() == [0.5, 1.5, 2.5]
    assert np.array_equal(found.fields["v"], np.arange(9).reshape(3, 3))
    assert "c" not in found.fields


@pytest.mark.parametrize(
    ("rest", "said"),
    [
        ("", "no POINTS or no LINES"),
        ("LINES 2 5\n2 0 1\n1\n", "truncated: 4 numbers where 5 were announced"),
        ("LINES 2 5\n2 0 1\n1 2 2\n", "surplus numbers: 6 numbers where 5 were announced"),
        ("LINES 2 6\n2 0 1\n1 2 0\n", "the lines fill 5 of 6 numbers"),
        ("LINES 2 5\n2 0 1\n3 2\n", "the lines fill 7 of 5 numbers"),
        (LINES + "POINT_DATA 2\n", "POINT_DATA for 2, but there are 3"),
        (LINES + "CELL_DATA 3\n", "CELL_DATA for 3, but there are 2"),
        (LINES + "SCALARS r float\nLOOKUP_TABLE default\n1 2\n", "array 'r' belongs neither to points nor to cells"),
        (LINES + "POINT_DATA 3\nSCALARS r float\n1 2 3\n", "SCALARS without LOOKUP_TABLE"),
        (LINES + "POINT_DATA 3\nNONSENSE r float\n1 2 3\n", "'NONSENSE' where a key word should stand"),
        (LINES + "POINT_DATA 3\nFIELD F 1\nr 1 2 float\n1 2\n", "array 'r' has 2 rows for 3"),
    ],
)
def test_a_count_that_does_not_agree_is_named(rest, said):
    with pytest.raises(InputError, match=said):
        parsed(rest)


@pytest.mark.parametrize(
    ("cells", "said"),
    [
        ("OFFSETS int\n0 2 4\nCONNECTIVITY int\n0 1 2\n", "hold 3 point numbers, their offsets say otherwise"),
        ("OFFSETS int\n1 2 3\nCONNECTIVITY int\n0 1 2\n", "their offsets say otherwise"),
        ("OFFSETS int\n0 4 3\nCONNECTIVITY int\n0 1 2\n", "their offsets say otherwise"),
        ("OFFSETS int\n0 2 3\nNOTHING int\n0 1 2\n", "cells without OFFSETS and CONNECTIVITY"),
        ("OFFSETS\n0 2 3\nCONNECTIVITY int\n0 1 2\n", "cells without OFFSETS and CONNECTIVITY"),
    ],
)
def test_offsets_that_do_not_agree_are_refused(cells, said):
    with pytest.raises(InputError, match=said):
        parsed("LINES 3 3\n" + cells, "5.1")


def test_other_data_than_lines_are_refused():
    with pytest.raises(InputError, match="not PolyData"):
        parse_legacy(b"# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET STRUCTURED_POINTS\n")
    with pytest.raises(ValueError, match="'-1' is not a count"):
        parsed("LINES -1 5\n")
