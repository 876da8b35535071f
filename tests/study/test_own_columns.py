"""Columns of a lab's own in the table of animals, and a design of them: from the file to results, tables and pages."""

import json

import numpy as np
import pytest

from made_cohort import made_results
from vasowave.animal.files import to_bytes
from vasowave.cli.study import _first_word
from vasowave.cohort import primary_comparison
from vasowave.errors import InputError
from vasowave.report.documents import report_of, supplement_of
from vasowave.study.declaring import RECORD, declare
from vasowave.study.loading import animal_key
from vasowave.study.plan import inspect_study, read_study
from vasowave.study.results import read_results, write_results
from vasowave.study.settings import StudyFile
from vasowave.study.store import Store

DESIGN = (
    "design: {covariates: [sex], blocks: [litter], subject: mouse, occasion: time}\nreport: {quantities: [mPAP, CO]}\n"
)


def make(tmp_path, results, design=DESIGN):
    """Write a study of made results: five mice a group, before and after; the files it names are empty."""
    (tmp_path / "n.csv").write_text("", encoding="utf-8")
    (tmp_path / "study.yaml").write_text(design, encoding="utf-8")
    lines = ["animal,group,network,recording,sex,litter,mouse,time,weight [g],born"]
    for place, result in enumerate(results):
        number = place // 2
        lines.append(
            f"{result.name},{result.group},n.csv,n.csv,{'fm'[number % 2]},L{number % 3},M{number},"
            f"{('before', 'after')[place % 2]},{20 + number % 4},2024-03-0{1 + number % 5}"
        )
    (tmp_path / "animals.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return read_study(tmp_path)


def run(study, results):
    """Put made results where a run puts its own."""
    study.results.mkdir(exist_ok=True)
    store = Store(study.results)
    pieces = {(one.name, one.group): store.keep(one.name, to_bytes(one.to_datatree())) for one in results}
    write_results(study.results, pieces, [], study.settings, study.variables, declare(study))
    return read_results(study.folder)


@pytest.fixture(scope="module")
def results():
    return made_results({"CTL": 10, "HPH": 10}, walls=())


def test_columns_of_ones_own_come_back_typed_from_results_and_stand_in_their_tables(tmp_path, results):
    stored = run(make(tmp_path, results), results)
    kinds = {one.label: one.kind for one in stored.variables}
    assert kinds == {"sex": "category", "litter": "category", "mouse": "category", "time": "category",
                     "weight [g]": "number", "born": "date"}  # fmt: skip
    table = stored.table().query("quantity == 'mPAP'").set_index("animal")
    assert table.loc["CTL 3", ["sex", "mouse", "time", "born"]].tolist() == ["m", "M1", "before", "2024-03-02"]
    assert table["weight [g]"].dtype == float
    cohort = stored.gathered(stored.in_order(), "CTL")
    (animals,) = [one for one in supplement_of(cohort, primary_comparison(cohort, stored.settings.report)).tables()
                  if one.name == "Animals"]  # fmt: skip
    assert animals.data["weight [g]"].tolist() == [20 + place // 2 % 4 for place in range(20)]


def test_a_change_of_such_a_column_asks_for_no_new_analysis(tmp_path, results):
    study = make(tmp_path, results)
    keys = [animal_key(row, study.settings, study.folder) for row in study.animals]
    text = (tmp_path / "animals.csv").read_text(encoding="utf-8").replace(",f,", ",m,")
    (tmp_path / "animals.csv").write_text(text, encoding="utf-8")
    again = read_study(tmp_path)
    assert again.variables != study.variables
    assert [animal_key(row, again.settings, again.folder) for row in again.animals] == keys


def test_the_page_says_what_the_design_says(tmp_path, results):
    stored = run(make(tmp_path, results), results)
    cohort = stored.gathered(stored.in_order(), "CTL")
    primary = primary_comparison(cohort, stored.settings.report)
    (answers,) = [
        block for block in walk(report_of(cohort, primary, stored.settings.report)) if block.kind == "answers"
    ]
    said = dict(answers.items)
    assert said["How were animals compared?"] == (
        "Ratios and means of groups are adjusted for sex: they hold at the average of each; animals of one "
        "litter (of 3: L0, L1 and L2) may be alike (random effects); "
        "the 20 recordings are of 10 animals (column mouse), whose own level is a "
        "random effect; time (before and after; compared with before) is a second factor, its effect in each group of "
        "its own."
    )
    assert "between HPH and CTL" in said["Pressure and flow"] or "in HPH than in CTL" in said["Pressure and flow"]
    assert "after/before" in said["Pressure and flow"]
    assert "time after" in said["Pressure and flow"]
    assert (
        report_of(cohort, primary, stored.settings.report).subtitle
        == "20 recordings of 10 animals in 2 groups: CTL, HPH"
    )
    rows = stored.compare("HPH").table
    assert set(rows["what"]) == {"groups", "interaction"}
    methods = " ".join(block.text for block in walk(supplement_of(cohort, primary)) if block.kind == "paragraph")
    assert "Kenward and Roger" in methods
    assert "They were not changed since." in methods


def walk(report):
    """Go through all blocks, those in columns too."""
    waiting = [block for section in report.sections for block in section.blocks]
    while waiting:
        block = waiting.pop(0)
        yield block
        waiting += [*getattr(block, "left", ()), *getattr(block, "right", ())]


def test_what_is_declared_is_kept_with_its_time_and_a_later_change_is_said_in_methods(tmp_path, results):
    study = make(tmp_path, results)
    (first,) = declare(study)
    assert not first.seen
    assert first.content["design"]["covariates"] == ["sex"]
    assert declare(study) == (first,)
    stored = run(study, results)
    (tmp_path / "study.yaml").write_text(DESIGN.replace("mPAP, CO", "CO, PVR"), encoding="utf-8")
    after = read_study(tmp_path)
    stored = run(after, results)
    assert [one.seen for one in stored.declared] == [False, True]
    assert stored.declared[1].changes(stored.declared[0]) == ["quantities"]
    cohort = stored.gathered(stored.in_order(), "CTL")
    supplement = supplement_of(cohort, primary_comparison(cohort, stored.settings.report))
    methods = " ".join(block.text for block in walk(supplement) if block.kind == "paragraph")
    assert "when results were there already: quantities." in methods
    (tmp_path / RECORD).write_text("{", encoding="utf-8")
    with pytest.raises(InputError, match=r"declared\.json: damaged"):
        declare(study)


def test_slips_in_such_columns_and_designs_are_said_with_their_place(tmp_path, results):
    study = make(tmp_path, results)
    text = study.table.read_text(encoding="utf-8")
    for old, new, words in (
        ("sex,litter", "sexx,litter", "study.yaml, line 1, column 1: the table of animals has no column 'sex'"),
        ("weight [g]", "value", "column 'value': is the name of a column of the tables of results"),
        ("weight [g]", "recordin", "unknown column (did you mean 'recording'?)"),
        (",20,", ",2O,", "column 'weight [g]': '2O' of"),
    ):
        study.table.write_text(text.replace(old, new, 1), encoding="utf-8")
        _, problems = inspect_study(tmp_path)
        assert [words in str(one) for one in problems if one.error] == [True]
    study.table.write_text(text.replace(",m,", ",M,", 1), encoding="utf-8")
    _, problems = inspect_study(tmp_path)
    assert [one.finding.code for one in problems] == ["variable.misspelt"]
    assert "column 'sex': 'M' in CTL 3 alone" in str(problems[0])


def test_a_design_says_of_how_many_animals_it_compares_what(tmp_path, results):
    said = make(tmp_path, results).layout.text
    assert said.startswith(f"{len(results)} recordings of {len(results) // 2} animals; compared: HPH against CTL; ")
    assert "time after against time before; HPH against CTL in the change after/before" in said


@pytest.mark.parametrize(("words", "first"), [(("before", "after"), "before"), (("later", "early"), "later")])
def test_check_says_which_word_stands_first_and_so_is_what_others_are_compared_with(tmp_path, results, words, first):
    study = make(tmp_path, results)
    table = study.table.read_text(encoding="utf-8")
    for old, new in zip(("before", "after"), words, strict=True):
        table = table.replace(f",{old},", f",{new},")
    study.table.write_text(table, encoding="utf-8")
    assert f" '{first}' is the first time in the table, so others are compared with it" in _first_word(
        read_study(tmp_path)
    )
    study.path.write_text("design: {covariates: [sex]}\n", encoding="utf-8")
    assert _first_word(read_study(tmp_path)) == ""


@pytest.mark.parametrize(
    ("design", "code", "words"),
    [
        ("subject: born, occasion: time", "design.same-occasion", "born 2024-03-01"),
        ("subject: row, occasion: time", "design.one-occasion", "no row was recorded at two levels of time"),
        ("subject: mouse, occasion: litter", "design.one-occasion", "no mouse was recorded at two levels of litter"),
        ("subject: mouse, occasion: litter", "design.same-occasion", "mouse M0, M1, M2"),
        ("blocks: [group]", "setting.at-odds", "'group' is no column of the lab's own"),
        ("subject: animal", "setting.at-odds", "'animal' names each row; give a column"),
    ],
)
def test_subjects_and_occasions_that_are_not_crossed_are_said(tmp_path, results, design, code, words):
    study = make(tmp_path, results)
    table = study.table.read_text(encoding="utf-8").splitlines()
    rows = ["row", *(f"r{place}" for place in range(len(table) - 1))]
    study.table.write_text("\n".join(f"{line},{row}" for line, row in zip(table, rows, strict=True)), encoding="utf-8")
    study.path.write_text(f"design: {{{design}}}\n", encoding="utf-8")
    _, problems = inspect_study(tmp_path)
    assert any(words in str(one) for one in problems if one.finding.code == code)


def test_a_study_file_stores_its_design_and_reads_it_back():
    design = {"blocks": ["litter"], "dose": "dose", "contrasts": {"high": {"A, 0": -1.0, "A, 3": 1.0}}}
    study = StudyFile(design=design)
    assert json.loads(json.dumps(study.design.contrasts)) == design["contrasts"]
    assert np.isclose(sum(study.design.contrasts["high"].values()), 0)
