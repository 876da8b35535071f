"""Names of animals and of groups, files that are walked, and rows that are made of them: each rule on its edge."""

import os
from pathlib import Path

import pytest

from vasowave.base import InputError
from vasowave.study.entering import files_in, is_reference, parsed_groups, proposed_groups, told_group, told_network
from vasowave.study.folder import MAX_NAME_LETTERS, checked_name, plain_name

HERE = Path("/labs/study")
TWO = {"CTL": ("CTL",), "HPH": ("HPH",)}


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


def test_genotypes_are_words_that_tell_groups():
    files = [f"Bmpr2{genotype}_{n}.csv" for genotype in ("--", "+-", "++") for n in (1, 2)]
    found = proposed(*files)
    assert str(found) == "names begin with Bmpr2++ (2 of them), Bmpr2-- (2 of them) and Bmpr2+- (2 of them)"
    typed = parsed_groups("WT=Bmpr2++,HET=Bmpr2+-,KO=Bmpr2--")
    assert [told_group(HERE / name, HERE, typed) for name in files] == ["KO", "KO", "HET", "HET", "WT", "WT"]
    assert parsed_groups("HET=Bmpr2+-+Smad1+-")["HET"] == ("Bmpr2+-", "Smad1+-")
    plain = parsed_groups("WT,KO=Bmpr2")
    assert [told_group(HERE / name, HERE, plain) for name in ("WT++_2.csv", "Bmpr2--_1.csv")] == ["WT", "KO"]
    assert list(proposed("WT--1.csv", "WT--2.csv", "SU-+3.csv").sizes) == ["WT", "SU"]  # signs that part words


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
    assert MAX_NAME_LETTERS == 60
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
