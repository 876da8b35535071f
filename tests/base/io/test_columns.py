"""Text tables: separators, heads, marks and units, lines of files, and what every refusal names."""

import hashlib

import numpy as np
import pytest

from vasowave.base import InputError, VasowaveWarning
from vasowave.base.io import NoRowsError, look, read_columns, read_lines


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


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("PAP [mmHg],LAP [mmHg]", r"'LAP \[mmHg\]' and 'PAP \[mmHg\]' are both read as pressure; leave out or rename"),
        ("PAP [mmHg],PAP [mmHg]", r"two columns are called 'PAP \[mmHg\]'; keep one of them"),
    ],
)
def test_two_columns_that_are_read_as_one_quantity_are_named_as_they_are_written(tmp_path, header, message):
    table = read_columns(file(tmp_path, f"{header}\n1,2\n"), {"pap": "pressure", "lap": "pressure"})
    with pytest.raises(InputError, match=message):
        table.find("pressure")


def test_a_column_that_is_missed_is_guessed_at(tmp_path):
    table = read_columns(file(tmp_path, "Time [s],p_bar,q [ml/min]\n1,2.5,60\n3,x,-120\n"))
    assert said(table.require, "p").partition("a.csv")[2].startswith(": no column 'p'; write 'p_bar' as 'p [bar]';")
    assert ": no column 'tme' (did you mean 'time'?); the header has" in said(table.require, "tme")
    assert table.numbers(table.require("q"), "flow") == pytest.approx([1, -2])


def test_a_file_without_a_last_line_end_is_suspected(tmp_path):
    table = read_columns(file(tmp_path, "a,b\n1,2"))
    assert len(table.suspicions) == 1
    with pytest.warns(VasowaveWarning, match="no line end; was the file cut off"):
        table.warn()


def test_lines_come_in_blocks_with_their_numbers_and_progress(tmp_path):
    """Three million letters, of which a million are held at a time."""
    written = [str(number) * 10 for number in range(50_000)]
    told = []
    found = list(read_lines(file(tmp_path, "\r\n".join(written)), told.append))
    assert len(found) > 1
    assert [text for block in found for text in block.texts] == written
    assert [block.first for block in found] == list(np.cumsum([1, *(len(block.texts) for block in found[:-1])]))
    assert [block.cut for block in found] == [False] * (len(found) - 1) + [True]
    assert told == sorted(told)
    assert told[-1] == 1.0


@pytest.mark.parametrize("content", [b"\xef\xbb\xbf\xc3\xa4\n", b"\xe4\n", "ä\n".encode("utf-16")])
def test_letters_are_those_of_whatever_encoding(tmp_path, content):
    assert [block.texts for block in read_lines(file(tmp_path, content))] == [["ä"]]


def test_a_look_holds_the_first_bytes_and_the_digest_of_all(tmp_path):
    content = bytes(range(256)) * 2000
    found = look(file(tmp_path, content))
    assert content.startswith(found.start)
    assert (found.size, found.whole) == (512_000, False)
    assert found.sha256 == hashlib.sha256(content).hexdigest()
    short = look(file(tmp_path, b"abc", "s"))
    assert (short.start, short.whole, short.size) == (b"abc", True, 3)
