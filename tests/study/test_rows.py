"""Rows of the table of animals: their words and numbers, how they are read and written, files that moved."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from vasowave.base import InputError, Place
from vasowave.study.entering import RecordingIndex, Rows, read_rows, seen_from, write_virtual_study, written_rows
from vasowave.study.folder import read_row


def test_a_recording_that_was_moved_is_known_by_its_name_and_its_bytes(tmp_path):
    for name in ("here.txt", "twin.txt"):
        (tmp_path / name).write_text("same")
    (tmp_path / "new").mkdir()
    for name in ("gone.txt", "flow.txt", "third.txt"):
        (tmp_path / "new" / name).write_text(name)
    rows = [{"animal": "a", "recording": "here.txt"}, {"animal": "b", "recording": "old/gone.txt", "flow": "old/f.txt"}]
    known = RecordingIndex(tmp_path, rows)

    def recorded(*names):
        return SimpleNamespace(files=[tmp_path / name for name in names], in_file="", sheet="")

    assert known.row_of(recorded("here.txt")) is rows[0]
    assert known.row_of(recorded("new/third.txt")) is None
    assert known.row_of(recorded("new/gone.txt", "new/flow.txt")) is rows[1]
    assert rows[1] == {"animal": "b", "recording": "new/gone.txt", "flow": "new/flow.txt"}
    assert known.row_of(recorded("new/gone.txt")) is None  # it has been found
    assert known.twin_of(recorded("twin.txt")) == "a"
    assert known.twin_of(recorded("new/third.txt")) == ""
    assert known.twin_of(recorded("new/third.txt")) == "third.txt"
    assert seen_from(tmp_path, Path(tmp_path / "new" / "flow.txt")) == "new/flow.txt"


def test_a_demo_goes_into_a_folder_that_is_empty_or_its_own(tmp_path):
    file = tmp_path / "file"
    file.write_text("x")
    with pytest.raises(InputError, match="is a file"):
        write_virtual_study(file)
    full = tmp_path / "full"
    full.mkdir()
    (full / "notes.txt").write_text("x")
    with pytest.raises(InputError, match="is not empty and not the study of virtual mice"):
        write_virtual_study(full)


@pytest.fixture
def folder(tmp_path):
    for name in ("net.csv", "p.csv", "q.csv"):
        (tmp_path / name).write_text("x")
    (tmp_path / "sub").mkdir()
    return tmp_path


def rowed(folder, **cells):
    whole = {"animal": "a", "group": "CTL", "network": "net.csv", "recording": "p.csv"}
    whole |= {name.replace("_", " "): text for name, text in cells.items()}
    row, wrong = read_row(whole, folder, ["CTL", "HPH"], lambda title: Place(part=title), 7)
    return row, [(one.place.part, str(one.finding)) for one in wrong]


def test_words_of_a_row_are_those_that_are_known(folder):
    row, wrong = rowed(folder, kind="RAW", synthetic="Yes", shared_recording="no", **{"period [s]": "0.1"})
    assert (row.kind, row.synthetic, row.shared_recording, row.period) == ("raw", True, False, 0.1)
    assert wrong == [("period [s]", "has no meaning for an animal of kind 'raw' and is ignored")]
    row, wrong = rowed(folder, kind="cycle", block="2", shared_recording="YES", **{"end [s]": "3"})
    assert (row.kind, row.block, row.shared_recording, row.synthetic) == ("cycle", 2, True, False)
    assert [part for part, _ in wrong] == ["block", "end [s]"]
    assert rowed(folder, kind="cylce")[1] == [("kind", "'cylce' (did you mean 'cycle'?); write cycle or raw")]
    assert rowed(folder, synthetic="maybe")[1] == [("synthetic", "'maybe'; write yes or no")]
    assert rowed(folder, group="CTK")[1][0][1].endswith("write one of its groups (CTL, HPH), or add this one to them")
    assert rowed(folder, group="")[1] == [("group", "the cell is empty")]
    assert rowed(folder, network="")[1] == [
        ("network", "the cell is empty: a study fits a model to the vessels of a lung")
    ]
    assert [part for part, _ in rowed(folder, pressure_unit="mlHg", flow_unit="furlong")[1]] == [
        "pressure unit", "flow unit"
    ]  # fmt: skip
    assert rowed(folder)[0].kind == ""


def test_a_table_is_written_with_the_columns_it_had_and_those_that_are_used():
    table = Rows(("# mine",), ("weight [g]", "animal"), ({"weight [g]": "20", "animal": "a"},))
    text = written_rows(table, [{"animal": "b", "recording": "r, s", "block": ""}, {"animal": "c", "end [s]": "3"}])
    assert text.splitlines() == [
        "# mine", "weight [g],animal,group,network,recording,end [s]", "20,a,,,,", ',b,,,"r, s",', ",c,,,,3"
    ]  # fmt: skip


def test_rows_are_read_with_titles_as_the_program_writes_them(tmp_path):
    path = tmp_path / "animals.csv"
    assert read_rows(path) == Rows((), (), ())
    path.write_text("# a\n")
    assert read_rows(path) == Rows(("# a",), (), ())
    path.write_text("# a\nANIMAL;Start [S];mine\n # b\n")
    assert read_rows(path) == Rows(("# a", " # b"), ("animal", "start [s]", "mine"), ())
    path.write_text("Animal,END [s],w [g]\nm,1,2\n")
    assert read_rows(path) == Rows((), ("animal", "end [s]", "w [g]"), ({"animal": "m", "end [s]": "1", "w [g]": "2"},))


@pytest.mark.parametrize(
    ("title", "text", "said"),
    [
        ("zero [mmHg]", "-3", ""),
        ("flow gain [1]", "-1", ""),
        ("wedge [mmHg]", "-0.1", "-0.1 is not a positive number"),
        ("flow gain [1]", "1e-300", "beyond any size that this can have"),
        ("flow gain [1]", "0", "a gain of 0 leaves no flow"),
        ("end [s]", "inf", "inf is not a positive number"),
        ("end [s]", "1,5", "'1,5' is not a number; write a decimal point instead of a comma"),
        ("block", "2.5", "2.5 is not a positive whole number"),
    ],
)
def test_a_number_that_a_cell_cannot_hold_is_refused_with_the_reason(folder, title, text, said):
    problems = [(part, words) for part, words in rowed(folder, kind="raw", **{title: text})[1] if part == title]
    assert [(part, said in words) for part, words in problems] == ([(title, True)] if said else [])
