"""Animals that were recorded more than once are told by names of files and folders: `add` says so, or asks."""

from pathlib import Path

import numpy as np
import pytest

import vasowave as vw
from vasowave.pulse.network import write_network
from vasowave.study.entering import add_files, check_study, new_study, read_rows, told_occasions
from vasowave.study.folder import read_settings

HERE = Path("/labs/study")


def reading(*names, subjects=None):
    files = [HERE / f"{name}.csv" for name in names]
    return told_occasions(files, HERE, subjects or [""] * len(files))


def times(occasions):
    return list(zip(occasions.subjects, occasions.levels, strict=True))


@pytest.mark.parametrize(
    ("names", "column", "expected"),
    [
        (("Rat 3 pre", "R3_post", "Rat 10 pre", "R10_POST"), "occasion",
         [("Rat 3", "pre"), ("Rat 3", "post"), ("Rat 10", "pre"), ("Rat 10", "post")]),
        (("m1_w0", "m1_w4", "m2_w0", "m2_w4"), "week", [("m1", "0"), ("m1", "4"), ("m2", "0"), ("m2", "4")]),
        (("m1 baseline", "m1 week 4", "m2 baseline", "m2 week4"), "occasion",
         [("m1", "baseline"), ("m1", "week 4"), ("m2", "baseline"), ("m2", "week 4")]),
        (("vor/R1", "nach/R1", "vor/R2", "nach/R2"), "occasion",
         [("R1", "vor"), ("R1", "nach"), ("R2", "vor"), ("R2", "nach")]),
        (("CTL/1 before", "CTL/1 after", "HPH/1 before", "HPH/1 after"), "occasion",
         [("CTL 1", "before"), ("CTL 1", "after"), ("HPH 1", "before"), ("HPH 1", "after")]),
        (("20260301_Ratte03_vor", "20260322_Ratte03_nach", "20260302_Ratte04_vor", "20260323_Ratte04_nach"), "occasion",
         [("Ratte03", "vor"), ("Ratte03", "nach"), ("Ratte04", "vor"), ("Ratte04", "nach")]),
        (("Rat 1/day 0", "Rat 1/day 21", "Rat 2/day 0", "Rat 2/day 21"), "day",
         [("Rat 1", "0"), ("Rat 1", "21"), ("Rat 2", "0"), ("Rat 2", "21")]),
        (("rat1_baseline", "rat1_sildenafil", "rat2_baseline", "rat2_sildenafil"), "occasion",
         [("rat1", "baseline"), ("rat1", "sildenafil"), ("rat2", "baseline"), ("rat2", "sildenafil")]),
        (("Ratte 1 (vor)", "Ratte 1 (sildenafil)", "Ratte 2 (vor)", "Ratte 2 (sildenafil)"), "occasion",
         [("Ratte 1", "vor"), ("Ratte 1", "sildenafil"), ("Ratte 2", "vor"), ("Ratte 2", "sildenafil")]),
        (("rat1 pre", "rat1 SNP (i.v.)", "rat2 pre", "rat2 SNP (i.v.)"), "occasion",
         [("rat1", "pre"), ("rat1", "snp (i.v.)"), ("rat2", "pre"), ("rat2", "snp (i.v.)")]),
        (("vorher m12", "Y27632 m12", "vorher m14", "Y27632 m14", "vorher m15"), "occasion",
         [("m12", "vorher"), ("m12", "y27632"), ("m14", "vorher"), ("m14", "y27632"), ("m15", "vorher")]),
        (("2026-03-01_Rat1Base", "2026-03-02_Rat1Iloprost 2mg", "2026-03-01_Rat11Base", "2026-03-02_Rat11Iloprost 2mg"),
         "occasion", [("Rat1", "base"), ("Rat1", "iloprost 2mg"), ("Rat11", "base"), ("Rat11", "iloprost 2mg")]),
        (("CTL1-pre", "CTL1-NO", "CTL1-washout", "HPH1-pre", "HPH1-NO", "HPH1-washout"), "occasion",
         [(animal, level) for animal in ("CTL1", "HPH1") for level in ("pre", "no", "washout")]),
    ],
)  # fmt: skip
def test_what_stands_beside_the_occasion_is_the_animal(names, column, expected):
    occasions = reading(*names)
    assert (occasions.column, times(occasions), occasions.clear) == (column, expected, True)


@pytest.mark.parametrize(
    ("names", "last"),
    [
        (("R1 baseline", "R1 hypoxia", "R2 baseline", "R2 hypoxia", "R3 hypoxia"), ("R3", "hypoxia")),
        (("R1 baseline", "R1 hypoxia", "R2 baseline", "R2 hypoxia", "R3 recovery"), ("R3 recovery", "")),
    ],
)
def test_an_animal_whose_first_occasion_is_missing_is_not_taken_for_one_at_it(names, last):
    occasions = reading(*names)
    assert times(occasions)[-1] == last
    assert not occasions.clear


@pytest.mark.parametrize(
    "names",
    [
        ("CTL_1", "CTL_2", "HPH_1", "HPH_2"),  # groups
        ("before 1", "before 2", "after 3", "after 4"),  # other animals after than before
        ("CTL D1", "CTL D2", "HPH D1", "HPH D2"),  # dogs
        ("M1", "M2", "H1", "H2"),
        ("R1 baseline", "R2 baseline"),
        ("R1 pre", "R1 post", "R2"),  # one animal alone
        ("spread 1", "spread 2", "nappe 1", "nappe 2"),  # words that hold others
        ("CTL1_baseline", "CTL2_baseline", "HPH1_baseline", "HPH2_baseline"),
        ("vehicle1_baseline", "vehicle2_baseline", "sildenafil1_baseline", "sildenafil2_baseline"),
        ("rat1_control", "rat2_control", "rat3_hypoxia", "rat4_hypoxia"),  # controls of their own
        ("rat1_baseline", "rat10_sildenafil", "rat2_baseline", "rat20_sildenafil"),  # other animals
        ("rat1_baseline", "rat1_2", "rat2_baseline", "rat2_2"),  # no word
    ],
)
def test_names_that_speak_of_no_two_occasions_of_animals_tell_none(names):
    assert reading(*names) is None


@pytest.mark.parametrize("drug", ["bosentan", "sildenafill"])
def test_a_drug_of_one_animal_alone_is_not_clear(drug):
    assert not reading("rat1_baseline", "rat1_sildenafil", "rat2_baseline", f"rat2_{drug}").clear


def test_a_pattern_that_many_animals_break_is_not_clear():
    pairs = [f"R{n} {level}" for n in range(1, 5) for level in ("pre", "post")]
    assert reading(*pairs, "R5 pre").clear  # nearly all
    assert reading(*pairs, "R5 pre", "R6 pre").clear  # some once, at the beginning
    assert not reading(*pairs, "R5 post", "R6 post").clear
    assert not reading(*pairs, "Rat 2 post").clear  # twice
    assert reading(*pairs, "Rat 2 post", subjects=[name.split()[0] for name in pairs] + ["R2"]).clear  # a repeat


def test_controls_that_were_recorded_once_count_as_recorded_at_the_beginning():
    treated = [f"hypoxia/P{n}/{level}/P{n}" for n in (6, 8) for level in ("baseline", "iloprost 20min")]
    occasions = reading(*treated, "normoxia/P1/Ausgangswert", "normoxia/2024-03-14_P3_JW/P3")
    assert times(occasions) == [("P6", "baseline"), ("P6", "iloprost 20 min"), ("P8", "baseline"),
                                ("P8", "iloprost 20 min"), ("P1", "baseline"), ("P3", "baseline")]  # fmt: skip
    assert (occasions.clear, occasions.assumed) == (True, ("P3",))
    again = reading(*treated, "hypoxia/P6/P6")  # a third recording of which no name says when
    assert (times(again)[-1], again.assumed) == (("P6", ""), ())
    other_folders = [f"hypoxia/P{n}/{folder}/P{n}" for n in (6, 8) for folder in ("left", "right")]
    assert reading(*other_folders) is None


def test_numbers_of_weeks_without_a_beginning_may_be_groups():
    names = [f"{{}}_{n}".format(week) for week in ("w0", "3w", "5w") for n in (1, 2)]
    assert reading(*names).clear
    assert not reading(*names[2:]).clear


def write_cycle(file, scale=1.0):
    mouse = vw.virtual_mouse()
    rows = np.column_stack([mouse.time, scale * mouse.pressure, mouse.flow])
    file.parent.mkdir(exist_ok=True, parents=True)
    np.savetxt(file, rows, "%.9g", ",", header="time [s],pressure [mmHg],flow [ml/s]", comments="")


@pytest.fixture
def lab(tmp_path):
    """Return a folder with a study and eight recordings: two animals a group, before and after."""
    names = [f"{group} {n} {level}" for group in ("veh", "drug") for n in (1, 2) for level in ("pre", "post")]
    for number, name in enumerate(names):
        write_cycle(tmp_path / f"lab/{name}.csv", 1 + 0.05 * number)
    write_network(vw.control_network(), tmp_path / "lab/lung.csv")
    new_study(tmp_path / "study")
    return tmp_path


def table(lab):
    return {row["animal"]: row for row in read_rows(lab / "study/animals.csv").rows}


def design(lab):
    of_study = read_settings(lab / "study/study.yaml")[0].design
    return of_study.subject, of_study.occasion


def test_a_clear_pattern_makes_animals_groups_and_design_and_says_how_to_undo_it(lab):
    added = add_files(lab / "study", [lab / "lab"])
    assert {name: (row["group"], row["subject"], row["occasion"]) for name, row in table(lab).items()} == {
        f"{group} {n} {level}": (group, f"{group} {n}", level)
        for group in ("veh", "drug") for n in (1, 2) for level in ("pre", "post")
    }  # fmt: skip
    assert design(lab) == ("subject", "occasion")
    assert any("4 animals" in text and "at pre (4) and post (4)" in text for text in added.said)
    assert {(cure.key, cure.text) for cure in added.cures if hasattr(cure, "key")} == {
        ("design.subject", "null"), ("design.occasion", "null")
    }  # fmt: skip
    problems, _, _, text, _ = check_study(lab / "study")
    assert not [problem for problem in problems if problem.error]
    assert "compared: drug against veh; post against pre; drug against veh in the change post/pre" in text


def test_a_drug_in_the_names_of_files_is_an_occasion_of_animals_and_of_their_groups(lab):
    for file in (lab / "lab").glob("* p*.csv"):
        file.rename(file.with_name(file.name.replace(" pre", "_baseline").replace(" post", "_iloprost")))
    added = add_files(lab / "study", [lab / "lab"])
    assert {(row["group"], row["subject"], row["occasion"]) for row in table(lab).values()} == {
        (group, f"{group} {n}", level)
        for group in ("veh", "drug") for n in (1, 2) for level in ("baseline", "iloprost")
    }  # fmt: skip
    assert ("design.subject", "null") in {(cure.key, cure.text) for cure in added.cures if hasattr(cure, "key")}


def test_recordings_that_come_later_join_their_animals_and_nothing_is_said_twice(lab):
    later = [*(lab / "lab").glob("* post.csv")]
    add_files(lab / "study", [*(lab / "lab").glob("* pre.csv"), lab / "lab/lung.csv"], groups="veh,drug")
    assert design(lab) == (None, None)
    assert len(add_files(lab / "study", later).updated) == 4  # the rows of 'pre'
    assert {row["subject"] for row in table(lab).values()} == {"veh 1", "veh 2", "drug 1", "drug 2"}
    again = add_files(lab / "study", [lab / "lab"])
    assert (again.rows, again.updated) == ((), ())
    assert not any("animals (" in text for text in again.said)


def test_a_design_without_the_animal_stays_as_somebody_made_it(lab):
    add_files(lab / "study", [lab / "lab"])
    file = lab / "study/study.yaml"
    text = file.read_text("utf-8").replace("subject: subject", "subject:").replace("occasion: occasion", "occasion:")
    file.write_text(text, "utf-8")
    write_cycle(lab / "lab/veh 3 pre.csv", 2.0)
    add_files(lab / "study", [lab / "lab"])
    assert design(lab) == (None, None)


def test_where_animals_differ_in_their_occasions_a_person_is_asked_and_else_told(lab):
    for name in ("veh 2 pre", "drug 2 pre"):
        (lab / f"lab/{name}.csv").unlink()
    added = add_files(lab / "study", [lab / "lab"])
    assert design(lab) == (None, None)
    assert any("every recording counts as an animal" in text for text in added.said)
    assert {row["group"] for row in table(lab).values()} == {"veh", "drug"}
    new_study(lab / "other")
    questions = []

    def ask(question, proposal):
        questions.append(question)
        return "yes" if "itself" in question else proposal

    add_files(lab / "other", [lab / "lab"], ask=ask)
    assert sum("itself" in question for question in questions) == 1
    assert read_settings(lab / "other/study.yaml")[0].design.occasion == "occasion"
