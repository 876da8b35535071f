"""Names of animals and of groups, files that are walked, and rows that are made of them: each rule on its edge."""

import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from vasowave.errors import InputError
from vasowave.study import sorting
from vasowave.study.adding import (
    _cells,
    _check_cells,
    _filled,
    _kept_groups,
    _kept_networks,
    _missing,
    _name,
    _once,
    _regrouped,
    _Row,
    _without_copies,
    told_network,
)
from vasowave.study.grouping import is_reference, parsed_groups, proposed_groups, told_group, within, words
from vasowave.study.names import LONGEST, checked_name, plain_name
from vasowave.study.sorting import Recorded, _half, _joined, _longest, files_in, used_block

HERE = Path("/labs/study")
TWO = {"CTL": ("CTL",), "HPH": ("HPH",)}


@pytest.mark.parametrize(
    ("few", "many", "stands"),
    [
        ([], ["a"], False), (["a"], ["a"], True), (["a"], [], False), (["b", "c"], ["a", "b", "c"], True),
        (["a", "b"], ["a", "b", "c"], True), (["a", "c"], ["a", "b", "c"], False), (["a", "b"], ["a"], False),
    ],
)  # fmt: skip
def test_words_stand_in_others_in_one_piece(few, many, stands):
    assert within(few, many) is stands


def test_a_name_falls_into_words_and_numbers():
    assert words("p_C6 Höx.12b") == ["p", "c", "6", "höx", "12", "b"]
    assert words("__") == []


@pytest.mark.parametrize(
    ("file", "marks", "group"),
    [
        ("data/CTL 1.csv", TWO, "CTL"),
        ("data/HPH/CTL 1.csv", TWO, "CTL"),  # the name counts before the folder
        ("HPH/CTL/1.csv", TWO, "CTL"),  # the inner folder before the outer
        ("HPH/day 3/1.csv", TWO, "HPH"),
        ("HPH/CTL and HPH/1.csv", TWO, ""),  # two in one name: none, and no folder further out decides
        ("data/1.csv", TWO, ""),
        ("../HPH/1.csv", TWO, "HPH"),  # a folder beside the study
        ("data/HOX SU 3.csv", {"A": ("HOX",), "B": ("HOX SU",)}, "B"),
        ("data/HOX 3.csv", {"A": ("HOX",), "B": ("HOX SU",)}, "A"),
        ("data/WT HOX SU.csv", {"A": ("WT",), "B": ("HOX SU",)}, ""),  # the longest does not hold the other
        ("data/HOX SU x HOX TX.csv", {"A": ("HOX SU",), "B": ("HOX TX",)}, ""),
        ("data/HOX SU.csv", {"A": ("HOX", "SU"), "B": ("HOX SU",)}, "B"),
        ("data/WT.csv", {"A": ("HOX", "WT"), "B": ("SU",)}, "A"),
    ],
)
def test_the_group_is_told_by_the_innermost_name_that_speaks_of_one(file, marks, group):
    assert told_group(HERE / file, HERE, marks) == group


def test_folders_that_hold_the_study_too_tell_no_group():
    assert told_group(Path("/HPH/study/data/1.csv"), Path("/HPH/study"), TWO) == ""
    assert told_group(Path("/HPH/data/1.csv"), Path("/HPH/study"), TWO) == ""
    assert told_group(Path("/HPH/study/1.csv"), Path("/HPH/study/1.csv"), TWO) == ""


def proposed(*names):
    return proposed_groups([HERE / name for name in names], HERE)


def test_groups_are_proposed_from_words_that_share_the_files():
    found = proposed("HOX_1.csv", "WT_2.csv", "hox_3.csv", "WT_4.csv", "WT_5.csv")
    assert found.marks == {"WT": ("WT",), "HOX": ("HOX",)}  # the reference first
    assert found.sizes == {"WT": 3, "HOX": 2}
    assert str(found) == "names begin with WT (3 of them) and HOX (2 of them)"
    assert proposed("exp_WT_1.csv", "exp_SU_1.csv", "exp_SU_2.csv").where == "names hold"
    assert proposed("WT/1.csv", "WT/2.csv", "SU/1.csv").where == "folders are called"
    assert list(proposed("WT/a/1.csv", "WT/a/2.csv", "SU/a/1.csv").sizes) == ["WT", "SU"]
    ending = proposed("an_old_WT.csv", "an_WT.csv", "an_new_SU.csv", "an_SU.csv")
    assert (ending.where, ending.sizes) == ("names end with", {"WT": 2, "SU": 2})


def test_words_that_say_a_reference_are_proposed_before_others_that_stand_earlier():
    found = proposed("abc_WT.csv", "xyz_WT.csv", "abc_SU.csv", "xyz_SU.csv")
    assert (found.where, list(found.marks)) == ("names hold", ["WT", "SU"])
    neither = proposed("abc_UV.csv", "xyz_UV.csv", "abc_SU.csv", "xyz_SU.csv")
    assert (neither.where, list(neither.marks)) == ("names begin with", ["abc", "xyz"])


def test_groups_have_two_files_each_in_the_mean_and_are_six_at_most():
    assert proposed("WT_1.csv", "SU_1.csv") is None
    assert proposed("WT_1.csv", "WT_2.csv", "SU_1.csv") is not None
    assert proposed("WT_1.csv", "WT_2.csv") is None
    kinds = ("qa", "qb", "qc", "qd", "qe", "qf", "qg")
    assert proposed(*(f"{kind}_{n}.csv" for kind in kinds[:6] for n in (1, 2))) is not None
    assert proposed(*(f"{kind}_{n}.csv" for kind in kinds for n in (1, 2))) is None
    assert proposed("male_1.csv", "male_2.csv", "female_1.csv", "female_2.csv") is None
    assert proposed("WT 1.csv", "mouse 2.csv", "mouse 1.csv") is None  # one of the words is no group's
    assert proposed() is None
    assert is_reference("wild type")
    assert not is_reference("wilder")


def test_groups_as_typed_have_marks_of_their_own_or_their_label():
    assert parsed_groups("WT, HOX") == {"WT": ("WT",), "HOX": ("HOX",)}
    assert parsed_groups("control=WT,hypoxic=HOX + SU") == {"control": ("WT",), "hypoxic": ("HOX", "SU")}
    with pytest.raises(InputError, match="group 'WT' stands twice in 'WT,A,WT'; keep one"):
        parsed_groups("WT,A,WT")


def test_a_name_has_sixty_characters_at_most():
    assert LONGEST == 60
    assert checked_name("a" * 60) == "a" * 60
    with pytest.raises(InputError, match=r"^'aaaaaaaaaaaaaaaaaaaa…' has 61 characters; at most 60 fit"):
        checked_name("a" * 61)
    for wrong in ("", " a", "-a", "a/b", "a\n"):
        with pytest.raises(InputError, match="a name consists of letters, digits, blanks and"):
            checked_name(wrong)
    assert plain_name("b" * 70) == "b" * 60


@pytest.mark.parametrize(
    ("stem", "name"),
    [
        ("(3) CTL", "3) CTL"), ("CTL 3)", "CTL 3"), ("CTL (3)", "CTL (3)"), ("CTL_3_", "CTL_3"), ("a*b", "a b"),
        ("?!", "animal"),        ("CTL (3) -", "CTL (3)"), ("mu\u0308de", "müde"), ("a" * 59 + " b", "a" * 59),
    ],
)  # fmt: skip
def test_a_stem_becomes_a_plain_name(stem, name):
    assert plain_name(stem) == name


def test_folders_are_walked_without_what_is_hidden_left_or_reached_twice(tmp_path):
    for name in ("a.csv", ".b.csv", "in/c.csv", ".in/d.csv", "in/results/e.csv", "f.jpg", "in/G.CSV", "left.csv"):
        (tmp_path / name).parent.mkdir(exist_ok=True, parents=True)
        (tmp_path / name).write_text("x")
    (tmp_path / "in" / "loop").symlink_to(tmp_path, target_is_directory=True)
    (tmp_path / "again.csv").symlink_to(tmp_path / "a.csv")
    leave = {(tmp_path / "in/results").resolve(), (tmp_path / "left.csv").resolve()}
    found = files_in([tmp_path], leave)
    assert sorted(os.path.relpath(one, tmp_path) for one in found) == ["a.csv", "in/G.CSV", "in/c.csv"]
    assert [one.name for one in files_in([tmp_path / "f.jpg", tmp_path / ".b.csv"])] == ["f.jpg", ".b.csv"]
    assert [one.name for one in files_in([tmp_path / "a.csv", tmp_path / "again.csv"])] == ["a.csv"]
    assert len(files_in([tmp_path / "in"])) == len(files_in([tmp_path])) == 5
    with pytest.raises(InputError, match=r"nothing: there is no such file or folder"):
        files_in([tmp_path / "nothing"])
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match=r"empty, .*empty: no file there ends in \.\w+, \.\w+"):
        files_in([tmp_path / "empty", tmp_path / "empty"])


def block(samples, *quantities):
    return SimpleNamespace(
        samples=samples, duration=samples / 1000, channels=[SimpleNamespace(quantity=one) for one in quantities]
    )


def test_the_block_that_is_read_is_the_one_named_or_the_longest():
    blocks = [block(1000), block(3000.4), block(2000)]
    described = SimpleNamespace(blocks=blocks)
    used = [blocks.index(used_block(described, number)) for number in (None, 0, 1, 2, 3, 4, -1)]
    assert used == [1, 1, 0, 1, 2, 1, 1]
    assert _longest(described, blocks[1]) == (
        "block 2 of 3 is read, the longest (blocks last 1 s, 3 s, 2 s); --block takes another"
    )


@pytest.mark.parametrize(
    ("file", "quantities", "half"),
    [
        ("x/C6_p.dat", ("time", "other"), ("pressure", "C6")),
        ("x/C6_Flow_2.dat", ("other",), ("flow", "C6_2")),
        ("x/q - C6.dat", ("other",), ("flow", "C6")),
        ("x/C6.dat", ("pressure",), ("pressure", "C6")),
        ("x/C6.dat", ("time", "flow"), ("flow", "C6")),
        ("Pressure/C6.dat", ("other",), ("pressure", "C6")),
        ("p/C6.dat", ("other",), ("", "")),  # a folder's name of one letter says nothing
        ("x/C6.dat", ("other",), ("", "")),
        ("x/C6_p.dat", ("pressure", "flow"), ("", "")),
        ("x/C6_p.dat", ("time",), ("", "")),
        ("x/p.dat", ("other",), ("pressure", "x")),  # nothing else: the folder's name
        ("x/pap_q.dat", ("other",), ("pressure", "q")),
        ("x/pop.dat", ("other",), ("", "")),
    ],
)
def test_a_file_is_half_of_a_cycle_by_its_name_its_title_or_its_folder(file, quantities, half):
    assert _half(Path(file), block(9, *quantities)) == half


def test_pressure_and_flow_are_joined_by_folder_first_and_by_name_where_that_is_one():
    def half(stem, which, place):
        return stem, which, Path(place)

    places = (("pressure", "a/p"), ("pressure", "b/p"), ("flow", "b/q"), ("flow", "a/q"))
    same = [half("C6", which, place) for which, place in places]
    joined, alone = _joined(same)
    assert [[str(file) for file in one.files] for one in joined] == [["a/p", "a/q"], ["b/p", "b/q"]]
    assert alone == []
    joined, alone = _joined([half("C6", "pressure", "p/1"), half("C6", "flow", "q/1"), half("C7", "flow", "q/2")])
    assert [(one.name, one.kind, len(one.files)) for one in joined] == [("C6", "cycle", 2)]
    assert alone == [("flow", Path("q/2"))]
    rivals = [half("C6", "pressure", "a/1"), half("C6", "pressure", "b/1"), half("C6", "flow", "c/1")]
    assert _joined(rivals)[0] == []
    assert len(_joined(rivals)[1]) == 3
    two_flows = [half("C6", "pressure", "a/1"), half("C6", "flow", "a/2"), half("C6", "flow", "a/3")]
    assert _joined(two_flows)[0] == []


@pytest.mark.parametrize(
    ("names", "units", "refused"),
    [
        (("L", "d"), ("mm", "um"), True), (("L", "d", "P"), ("mm", "um", "mmHg"), False), (("L",), ("mm",), False),
        (("L", "d", "Q"), ("mm", "cm", "ml/s"), False), (("L", "d", "x"), ("mm", "cm", ""), True), ((), (), False),
    ],
)  # fmt: skip
def test_a_table_of_two_lengths_without_signals_is_one_of_vessels(monkeypatch, names, units, refused):
    monkeypatch.setattr(sorting, "read_columns", lambda file: SimpleNamespace(names=names, units=units))
    if not refused:
        sorting._refuse_vessels(Path("t.csv"))
        return
    with pytest.raises(InputError, match=r"t.csv: looks like a table of vessels \(L and d are lengths\), .* has: L, d"):
        sorting._refuse_vessels(Path("t.csv"))


@pytest.mark.parametrize(
    ("name", "group", "networks", "every", "told"),
    [
        ("CTL 3", "CTL", ("a CTL 3 b", "CTL 4"), True, "a CTL 3 b"),  # holds the name of the animal
        ("CTL 3", "CTL", ("CTL 3", "CTL 3 b"), True, "CTL 3"),  # two hold it; the one it begins with
        ("CTL 3 late", "CTL", ("CTL 3", "CTL"), True, "CTL 3"),  # the longest that it begins with
        ("CTL 3 late", "HPH", ("CTL 3", "HPH"), True, "HPH"),  # not one of another group
        ("m1", "CTL", ("CTL", "HPH"), True, "CTL"),
        ("m1", "CTL", ("CTL a", "CTL b"), True, None),
        ("m1", "", ("net",), True, "net"),
        ("m1", "CTL", ("net",), False, None),
        ("m1", "CTL", ("HPH",), True, None),
        ("m1", "CTL", ("net", "other"), True, None),
        ("m1", "", ("CTL", "HPH"), True, None),
    ],
)  # fmt: skip
def test_a_network_is_told_by_the_animals_name_then_its_group_then_being_alone(name, group, networks, every, told):
    files = [HERE / f"networks/{one}.csv" for one in networks]
    found = told_network(name, group, TWO, files, HERE, every)
    assert (found and found.stem) == told


def test_groups_that_are_given_replace_the_others_or_join_them():
    given = {"A": ("x",), "B": ("y",)}
    assert _regrouped(["CTL", "HPH"], set(), given) == given
    assert _regrouped(["CTL", "HPH"], {"HPH"}, given) == {"HPH": ("HPH",), **given}
    assert _regrouped(["A", "HPH"], {"A"}, given) == given
    assert list(_regrouped(["CTL", "B"], {"CTL"}, given)) == ["CTL", "B", "A"]
    assert _regrouped(["CTL", "HPH"], set(), {"A": ("x",)}) == {"CTL": ("CTL",), "HPH": ("HPH",), "A": ("x",)}
    assert _regrouped(["CTL", "HPH"], {"HPH"}, {"HPH": ("x",)}) == {"CTL": ("CTL",), "HPH": ("x",)}


def row(name, *, cells=None, old=None, files=None, said=()):
    recorded = Recorded(name, tuple(files or (HERE / f"data/{name}.csv",)), "raw", remarks=said)
    return _Row(recorded, dict(cells or {}), old)


def test_animals_are_called_by_their_files_and_by_folders_or_numbers_where_names_are_taken():
    new = [
        row("C1"),
        row("x", files=[HERE / "one/x.csv"]),
        row("X", files=[HERE / "two/X.csv"]),
        row("C2"),
        row("y", files=[HERE / "one/y.csv"]),
        row("y", files=[HERE / "a/one/y.csv"]),
        row("y", files=[HERE / "b/one/y.csv"]),
    ]
    _name(new, ["c2", "Z"])
    names = [one.cells["animal"] for one in new]
    assert names == ["C1", "one x", "two X", "data C2", "one y", "one y (2)", "one y (3)"]


def test_what_is_unknown_of_rows_is_said_with_its_remedy():
    rows = [{"animal": "a", "group": "", "network": "n"}, {"animal": "b", "group": "", "network": ""}]
    group = "neither name nor folder tells the group of a, b; the study has CTL, HPH: give --group or --groups, or write it into the column 'group'"  # noqa: E501
    rest = "b; give --network, or write it into the column 'network'"
    one, two = (Path("x/one.csv"),), (Path("x/one.csv"), Path("two.csv"))
    assert _missing(rows, TWO, (), False) == [group, f"there is no network: {rest}"]
    assert _missing(rows, TWO, two, True)[1] == f"none of 2 networks carries their name or group: {rest}"
    assert _missing(rows, TWO, one, False)[1] == f"one.csv carries neither their name nor their group: {rest}"
    unread = "one.csv carries neither their name nor their group, and some files could not be read"
    assert _missing(rows, TWO, one, True)[1] == f"{unread}: {rest}"
    assert _missing([{"animal": "a", "group": "CTL", "network": "n"}], TWO, two, True) == []


def test_rows_keep_their_group_and_network_and_say_so():
    touched = [
        row("a", cells={"network": "n/2.csv"}, old={"animal": "A", "group": "HPH", "network": "n/1.csv"}),
        row("b", cells={"network": "n/./1.csv"}, old={"animal": "B", "group": "CTL", "network": "n/1.csv"}),
        row("c", cells={"network": "n/2.csv"}, old={"animal": "C", "group": "", "network": ""}),
        row("d", cells={"network": ""}, old={"animal": "D", "group": "HPH", "network": "n/1.csv"}),
        row("e", cells={"network": "n/2.csv"}),
    ]
    nets = [Path("n/1.csv"), Path("n/2.csv")]
    assert _kept_networks(touched, nets) == [
        "A: the table keeps n/1.csv (not n/2.csv); to change that, empty the cells 'network' or give --network"
    ]
    assert _kept_networks(touched, nets[:1]) == []
    assert _kept_networks(touched[1:], nets) == []
    stays = "in the table already, with another group than CTL, and stays there; to change it, write it into the column 'group'"  # noqa: E501
    assert _kept_groups(touched, "CTL") == [f"A and D: {stays}"]
    assert _kept_groups(touched[1:2], "CTL") == []
    assert _kept_groups(touched, "") == []


def test_cells_that_are_empty_or_asked_for_are_filled_and_the_stretch_of_a_person_stays():
    def filled(cells, old, *explicit):
        one = row("a", cells=cells, old=dict(old))
        return _filled(one, set(explicit)), one.old

    old = {"animal": "A", "recording": "r", "group": "CTL", "network": ""}
    assert filled({"animal": "B", "recording": "s", "group": "HPH", "network": ""}, old) == (False, old)
    assert filled({"network": "n"}, old) == (True, {**old, "network": "n"})
    assert filled({"group": "HPH"}, old, "group") == (True, {**old, "group": "HPH"})
    assert filled({"group": ""}, old, "group") == (False, old)
    for key in ("start [s]", "end [s]", "block"):
        own = {**old, key: "2"}
        assert filled({"start [s]": "1", "end [s]": "3", "kind": "raw"}, own)[1] == {**own, "kind": "raw"}
    assert filled({"start [s]": "1"}, {**old, "end [s]": "2"}, "start [s]")[1]["start [s]"] == "1"
    assert filled({"start [s]": "1"}, old)[1]["start [s]"] == "1"


def test_cells_of_a_row_hold_what_was_told_of_the_recording_below_what_was_given():
    stretch = sorting.Span(1.25, 7.0)
    whole = Recorded("a", (HERE / "a.txt",), "raw", (("pressure", "PAP"),), stretch)
    assert _cells(whole, HERE, {}) == {
        "animal": "", "group": "", "network": "", "recording": "/labs/study/a.txt", "kind": "raw",
        "pressure channel": "PAP", "start [s]": "1.25", "end [s]": "7",
    }  # fmt: skip
    given = _cells(whole, HERE, {"end [s]": "5", "period [s]": "0.1"})
    assert (given["end [s]"], "start [s]" in given, "period [s]" in given, given["kind"]) == ("5", False, False, "raw")
    assert "end [s]" not in _cells(whole, HERE, {"start [s]": "2"})
    two = Recorded("a", (HERE / "p.csv", HERE / "q.csv"), "unknown")
    made = _cells(two, HERE, {"period [s]": "0.1"})
    assert (made["kind"], made["flow"], made["period [s]"]) == ("cycle", "/labs/study/q.csv", "0.1")
    assert _cells(two, HERE, {})["kind"] == "unknown"


def test_cells_for_all_are_checked_before_anything_is_added():
    _check_cells({"start [s]": "1", "end [s]": "1.5"})
    _check_cells({"end [s]": "0.1"})
    _check_cells({"start [s]": "1e9"})
    with pytest.raises(InputError, match="the stretch from 1 to 1 s ends before it begins; nothing was added"):
        _check_cells({"start [s]": "1", "end [s]": "1"})
    with pytest.raises(InputError, match=r"the stretch from 0 to 0 s ends|is not a positive number"):
        _check_cells({"end [s]": "0"})
    with pytest.raises(InputError, match=r"^wedge \[mmHg\]: 'x' is not a number; block: 1.5 is not a positive whole n"):
        _check_cells({"wedge [mmHg]": "x", "block": "1.5"})


def test_what_was_decided_alike_of_several_files_is_said_once():
    found = [row(name, said=("cut", name) if name == "c" else ("cut",)) for name in "abcde"]
    assert _once(found) == ["a.csv, b.csv, c.csv and 2 more: cut", "c.csv: c"]


def test_copies_are_left_out_and_the_shorter_name_stays():
    seen = {}

    class Known:
        def twin_of(self, recorded):
            twin = seen.get(recorded.kind, "")
            seen.setdefault(recorded.kind, recorded.name)
            return twin

    new = [row("long copy"), row("long"), row("b", files=[HERE / "x/y/b.csv"]), row("c", files=[HERE / "c.csv"])]
    kept, said = _without_copies(new, Known())
    assert [one.recorded.name for one in kept] == ["c"]
    assert said[0] == "/labs/study/x/y/b.csv: holds the same bytes as the recording of c; left out"
    assert len(said) == 3
