"""Text tables, lines of files and folders by hand: separators, heads, marks, units, and what every refusal names."""

import io
import os
import zipfile

import numpy as np
import pytest

from vasowave.errors import InputError, VasowaveWarning
from vasowave.io import textfile
from vasowave.io.columns import (
    Columns,
    NoRowsError,
    head_of,
    is_numeric,
    number,
    plain_title,
    read_columns,
    read_titles,
    split_cells,
    split_unit,
    spreadsheet_cell,
)
from vasowave.io.files import check_file, check_folder, made_inside, write_file
from vasowave.io.spreadsheet import _column, _value, is_workbook
from vasowave.io.textfile import Lines, _cell, look, read_bytes, read_lines, read_start, regular_file


def said(function, *given):
    with pytest.raises(InputError) as error:
        function(*given)
    return str(error.value)


def file(tmp_path, text, name="a.csv"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    ("text", "names", "units", "cells", "lines"),
    [
        ("a [s],b\n1,2\n", ("a", "b"), ("s", ""), (("1", "2"),), (2,)),
        ("# x\n\nA (s);B [mm]\n\n1,5;2\n#\n3;4\n", ("a", "b"), ("s", "mm"), (("1.5", "2"), ("3", "4")), (5, 7)),
        ("a/s\tb\n1\t2\n", ("a", "b"), ("s", ""), (("1", "2"),), (2,)),
        ("1 2\n3 4\n", (), (), (("1", "2"), ("3", "4")), (1, 2)),
        ("1,5\t2\n", (), (), (("1.5", "2"),), (1,)),
        ("time [s] p [mmHg]\n1 2\n", ("time", "p"), ("s", "mmHg"), (("1", "2"),), (2,)),
        ("a,b\n[s],[mmHg]\n1,2\n", ("a", "b"), ("s", "mmHg"), (("1", "2"),), (3,)),
        ("my lung\nof May\na,b\n1,2\n3,4\n", ("a", "b"), ("", ""), (("1", "2"), ("3", "4")), (4, 5)),
        ('"a b","c"\n"1","x, y"\n', ("a b", "c"), ("", ""), (("1", "x, y"),), (2,)),
        ("the flow\n1\n2\n", ("the flow",), ("",), (("1",), ("2",)), (2, 3)),
    ],
)
def test_tables_are_read_whatever_separates_them(tmp_path, text, names, units, cells, lines):
    table = read_columns(file(tmp_path, text))
    assert (table.names, table.units, table.cells, table.lines) == (names, units, cells, lines)
    assert table.suspicions == ()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ": the file is empty"),
        ("# a\n \n", ": the file is empty"),
        ("a,b\n1,2\n3\n", ", line 3: 1 columns where 2 were expected"),
        ("a,b\n1,2\n1,5,2,5\n", ", line 3: 4 columns where 2 were expected; if the comma is a decimal mark too,"),
        ("a,b\n1,2\n1,x,2,5\n", ", line 3: 4 columns where 2 were expected"),
        ("1;2\n3;4;5\n", ", line 2: 3 columns where 2 were expected"),
        ("a;b\n1,5;2\n\n1;2.5\n", ": a number with a comma in line 2, one with a point in line 4; write all"),
        ("a;b\n1.5;2\n1;2,5\n", ": a number with a comma in line 3, one with a point in line 2; write all"),
        ('a,b\n1,"2\n', ", line 2: a quotation mark is opened and not closed on its line"),
        ("a [s,b\n1,2\n", ": cannot read the column title 'a [s'; write 'name [unit]'"),
        (b"a,b\n1,\0\n", ": not a text file; export it as CSV first"),
    ],
)
def test_a_table_that_cannot_be_read_is_refused_with_its_line(tmp_path, text, words):
    found = said(read_columns, file(tmp_path, text)).partition("a.csv")[2]
    assert found.startswith(words)
    with pytest.raises(NoRowsError, match="a header and no data"):
        read_columns(file(tmp_path, "a,b\n", "h.csv"))


TABLE = Columns("f", ("time", "p_mmhg", "q"), ("s", "", "ml/min"), (("1", " 2.5", "60"), ("3", "x", "")), (2, 4),
                titles=("Time [s]", "p_mmhg", "q"))  # fmt: skip


def test_columns_are_found_and_missed_in_words():
    assert (TABLE.find("q"), TABLE.find("x"), TABLE.find("x", ("q",))) == (2, None, 2)
    assert (TABLE.unit_of("q"), TABLE.unit_of("x")) == ("ml/min", "")
    assert said(TABLE.require, "p").startswith("f: no column 'p'; write 'p_mmhg' as 'p [mmhg]'; the header has: time,")
    assert said(TABLE.require, "tme").startswith("f: no column 'tme' (did you mean 'time'?); the header has")
    assert said(TABLE.require, "length", (), "length [cm]").endswith("; such a table has the titles length [cm]")
    assert said(Columns("f", (), (), (("1",),), (1,)).require, "p") == "f: no column 'p'; the header has: nothing"
    assert TABLE.numbers(0, "time").tolist() == [1, 3]
    part = Columns("f", ("q",), ("ml/min",), (("60",), ("-120",)), (2, 3))
    assert part.numbers(0, "flow") == pytest.approx([1, -2])
    assert Columns("f", (), (), (("60",),), (1,)).numbers(0, "flow", "ml/min") == pytest.approx([1])


@pytest.mark.parametrize(
    ("cell", "unit", "words"),
    [
        ("x", "s", "f, line 7, column 'a': 'x' is not a number"),
        ("1,5", "s", "f, line 7, column 'a': '1,5' is not a number; is its comma a decimal mark? write a point"),
        (" ", "s", "f, line 7, column 'a': the cell is empty"),
        ("nan", "s", "f, line 7, column 'a': nan is no finite number (a gap?); fill it"),
        ("inf", "s", "f, line 7, column 'a': inf is no finite number"),
        ("1_0", "s", "f, line 7, column 'a': '1_0' is not a number"),
        ("1", "", "f: column 'a' has no unit; write it in the header, for example 'a [s]'"),
        ("1", "mmHg", "f: column 'a': 'mmHg' is not a unit of time"),
    ],
)
def test_a_cell_that_is_no_number_is_named_with_line_and_column(cell, unit, words):
    assert said(Columns("f", ("a",), (unit,), ((cell,),), (7,)).numbers, 0, "time").startswith(words)
    if not unit:
        assert "column 'column 1' has no unit" in said(Columns("f", (), (), ((cell,),), (7,)).numbers, 0, "time")


def test_a_file_without_a_last_line_end_is_suspected(tmp_path):
    table = read_columns(file(tmp_path, "a,b\n1,2"))
    assert len(table.suspicions) == 1
    with pytest.warns(VasowaveWarning, match="no line end; was the file cut off"):
        table.warn()


def test_parts_of_titles_and_cells():
    assert split_unit("S [mmHg2]") == ("S", "mmHg2")
    assert split_unit("S") == ("S", "")
    assert plain_title("PAP / Flow [ml/s]") == "PAP / Flow"
    assert plain_title("a [") == "a ["
    assert (number("1e3"), is_numeric("1,5"), is_numeric("1,5,6"), is_numeric("1_0"), is_numeric(",5e-3")) == (
        1000.0, True, False, False, True
    )  # fmt: skip
    assert [spreadsheet_cell(one) for one in ("=1", " @x", "-1.5", "-a", "a=")] == ["'=1", "' @x", "-1.5", "'-a", "a="]
    assert split_cells("f", 1, "1 2,5", None) == ["1", "2,5"]
    assert split_cells("f", 1, "a b", None) == ["a b"]
    assert head_of("f", [(1, "a;b"), (2, "1;2")]) == (("a", "b"), ";", 1)
    assert head_of("f", [(1, "1;2")]) == ((), ";", 0)
    assert head_of("f", [(1, "a;b"), (2, "s;-"), (3, "1;2")]).titles == ("a [s]", "b")
    assert head_of("f", [(1, "a;b"), (2, "s;x"), (3, "1;2")]).first == 1  # half of the words are no units


def test_titles_are_told_by_the_first_bytes(tmp_path):
    path = tmp_path / "a.csv"
    assert read_titles(path, b"# c\nA [s],b\n1,2\n") == ("a", "b")
    assert read_titles(path, "A,b\n1,2\n".encode("utf-16")) == ("a", "b")
    assert read_titles(path, b"1,2\n") == ()
    assert read_titles(path, b"") == ()
    assert read_titles(path, b"a [,b\n1,2\n") == ()


def test_lines_come_in_blocks_with_their_numbers_and_progress(tmp_path, monkeypatch):
    monkeypatch.setattr(textfile, "_BLOCK", 8)
    path = file(tmp_path, "ab\ncdef\r\n\nghijklmnop\nq")
    told = []
    found = list(read_lines(path, told.append))
    texts = [text for block in found for text in block.texts]
    assert texts == ["ab", "cdef", "", "ghijklmnop", "q"]
    assert [block.first for block in found] == list(np.cumsum([1, *(len(block.texts) for block in found[:-1])]))
    assert [block.cut for block in found] == [False] * (len(found) - 1) + [True]
    assert told == sorted(told)
    assert told[-1] == 1.0
    assert Lines(1, ["a", "b#"]).hold("#")
    assert not Lines(1, ["a", "b"]).hold("#")
    for content, text in ((b"\xef\xbb\xbf\xc3\xa4\n", "ä"), (b"\xe4\n", "ä"), ("ä\n".encode("utf-16"), "ä")):
        assert [block.texts for block in read_lines(file(tmp_path, content, "e.txt"))] == [[text]]


def test_lines_that_are_too_long_are_named(tmp_path, monkeypatch):
    monkeypatch.setattr(textfile, "LONGEST_LINE", 10)
    path = file(tmp_path, "a\n" + "b" * 10 + "\nc\n" + "d" * 11 + "\n")
    assert said(lambda: list(read_lines(path))).endswith(
        "a.csv, line 4: longer than 10 characters; not a table, export it again"
    )
    assert _cell('a\t "b"\n c') == '"a ""b"" c"'
    assert _cell("a b") == "a b"


def test_a_look_holds_the_first_bytes_and_the_digest_of_all(tmp_path, monkeypatch):
    monkeypatch.setattr(textfile, "_START", 4)
    import hashlib

    found = look(file(tmp_path, b"abcdefghij"))
    assert (found.start, found.size, found.whole) == (b"abcd", 10, False)
    assert found.sha256 == hashlib.sha256(b"abcdefghij").hexdigest()
    short = look(file(tmp_path, b"abc", "s"))
    assert (short.start, short.whole, short.size) == (b"abc", True, 3)
    assert read_start(tmp_path / "a.csv", 3) == b"abc"
    assert read_bytes(tmp_path / "a.csv") == b"abcdefghij"
    assert said(regular_file, tmp_path) == f"{tmp_path}: is a folder"
    assert said(regular_file, tmp_path / "none").endswith("none: no such file or directory")
    assert said(regular_file, "a\0b").endswith("is no name of a file")
    os.mkfifo(tmp_path / "pipe")
    assert "is a pipe or a device, not a file" in said(regular_file, tmp_path / "pipe")


def cell(kind, text, style="0"):
    from xml.etree.ElementTree import fromstring

    return fromstring(f'<c t="{kind}" s="{style}"><v>{text}</v></c>')


def test_cells_of_a_sheet_are_text_as_they_are_meant():
    from datetime import datetime

    epoch = datetime(1899, 12, 30)
    shared, dates = ["zero", "one"], [False, True]

    def value(*given):
        return _value(cell(*given), shared, dates, epoch)

    assert [value("s", "1"), value("s", "-1"), value("b", "1"), value("b", "0")] == ["one", "", "TRUE", "FALSE"]
    assert [value("e", "#DIV/0!"), value("str", "x"), value("n", "2.0"), value("n", "2.5")] == [
        "error DIV/0!",
        "x",
        "2",
        "2.5",
    ]
    assert value("n", "1e15") == "1000000000000000.0"
    assert value("n", "999999999999999") == "999999999999999"
    assert value("n", "1.5", "1") == "1899-12-31 12:00:00"
    assert value("n", "1.5", "2") == "1.5"  # a style that is not there
    assert value("n", "1_0") == "nan"
    assert (_column("C7", 2, 7), _column("AB7", 2, 7), _column(None, 4, 7)) == (3, 28, 5)
    assert _column("XFD1", 2, 1) == 16384
    for place, before in (("C7", 3), ("XFE7", 0)):
        assert said(_column, place, before, 7) == f"row 7: cell {place} is out of place; save the sheet again"
    assert is_workbook(b"PK\x03\x04x")
    assert is_workbook(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1")
    assert not is_workbook(b"PK\x05")


def test_progress_of_a_workbook_ends_at_one(tmp_path):
    held = io.BytesIO()
    sheet = (
        '<worksheet><sheetData><row r="2"><c r="A2"><v>1</v></c><c r="C2"><v>3</v></c></row></sheetData></worksheet>'
    )
    with zipfile.ZipFile(held, "w") as archive:
        archive.writestr("xl/workbook.xml", '<workbook><sheets><sheet name="a" id="r1"/></sheets></workbook>')
        archive.writestr("xl/_rels/workbook.xml.rels", '<R><Relationship Id="r1" Target="s.xml"/></R>')
        archive.writestr("xl/s.xml", sheet)
    told = []
    (lines,) = read_lines(file(tmp_path, held.getvalue(), "a.xlsx"), told.append)
    assert (lines.first, lines.texts) == (2, ["1\t\t3"])
    assert told == [1.0]


def test_folders_and_files_are_checked_before_anything_is_computed(tmp_path):
    marks = {"mark.txt": b"mine"}
    check_folder(tmp_path / "new", marks)
    assert not (tmp_path / "new").exists()
    (tmp_path / "d").mkdir()
    check_folder(tmp_path / "d", marks)
    write_file(tmp_path / "d" / "other", "x")
    assert "d is not empty and not a vasowave result; give another" in said(check_folder, tmp_path / "d", marks)
    write_file(tmp_path / "d" / "mark.txt", "it is mine")
    check_folder(tmp_path / "d", marks)
    assert said(check_folder, tmp_path / "d" / "other", marks).endswith("other is a file; give the name of a folder")
    assert said(check_file, tmp_path / "d").endswith("d is a folder; give the name of a file")
    assert "there is no folder" in said(check_file, tmp_path / "x" / "y.csv")
    assert said(check_file, tmp_path / "y.txt", ".csv", ".tsv").endswith("the name of this file ends in .csv or .tsv")
    check_file(tmp_path / "y.CSV", ".csv")
    inner = made_inside(tmp_path / "d", "inner")
    assert inner.is_dir()
    (tmp_path / "d" / "link").symlink_to(tmp_path)
    assert "is a link that leads out of" in said(made_inside, tmp_path / "d", "link")
