"""Columns of a lab's own in the table of animals, and a design of them: from the file to results, tables and pages."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from made_cohort import made_results
from vasowave.base import InputError
from vasowave.study.animal import to_bytes
from vasowave.study.cohort import PopulationShape, doubts_of, laid_out, primary_comparison
from vasowave.study.folder import understood
from vasowave.study.report import Notice, Paragraph, Report, report_of, supplement_of
from vasowave.study.report.answer import answer_sections, group_answer
from vasowave.study.report.sections import methods_section
from vasowave.study.results import ResultStore, animal_key, read_results, write_results
from vasowave.study.running import RECORD, declare, inspect_study, read_study

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
    store = ResultStore(study.results)
    pieces = {(one.name, one.group): store.keep(one.name, to_bytes(one.to_datatree())) for one in results}
    write_results(study.results, pieces, [], study.settings, study.variables, declare(study))
    return read_results(study.folder)


@pytest.fixture(scope="module")
def results():
    return made_results({"CTL": 10, "HPH": 10}, walls=())


@pytest.fixture(scope="module")
def stored(tmp_path_factory, results):
    """Return what a run of the study stored."""
    return run(make(tmp_path_factory.mktemp("columns"), results), results)


@pytest.fixture
def ran(stored, tmp_path):
    """Return a copy of the study that was run."""
    return read_study(shutil.copytree(stored.folder.parent, tmp_path / "ran"))


@pytest.fixture(scope="module")
def cohort(stored):
    return stored.gathered(stored.in_order(), "CTL")


@pytest.fixture(scope="module")
def primary(cohort, stored):
    return primary_comparison(cohort, stored.settings.report)


@pytest.fixture(scope="module")
def report(cohort, primary, stored):
    return report_of(cohort, primary, stored.settings.report)


@pytest.fixture(scope="module")
def supplement(cohort, primary):
    return supplement_of(cohort, primary)


def test_columns_of_ones_own_come_back_typed_from_results_and_stand_in_their_tables(stored, supplement):
    kinds = {one.label: one.kind for one in stored.variables}
    assert kinds == {"sex": "category", "litter": "category", "mouse": "category", "time": "category",
                     "weight [g]": "number", "born": "date"}  # fmt: skip
    table = stored.table().query("quantity == 'mPAP'").set_index("animal")
    assert table.loc["CTL 3", ["sex", "mouse", "time", "born"]].tolist() == ["m", "M1", "before", "2024-03-02"]
    assert table["weight [g]"].dtype == float
    (columns,) = [one for one in supplement.tables() if one.name == "Columns"]
    assert columns.data["weight [g]"].tolist() == [20 + place // 2 % 4 for place in range(20)]


def test_a_change_of_such_a_column_asks_for_no_new_analysis(tmp_path, results):
    study = make(tmp_path, results)
    keys = [animal_key(row, study.settings, study.folder) for row in study.animals]
    text = (tmp_path / "animals.csv").read_text(encoding="utf-8").replace(",f,", ",m,")
    (tmp_path / "animals.csv").write_text(text, encoding="utf-8")
    again = read_study(tmp_path)
    assert again.variables != study.variables
    assert [animal_key(row, again.settings, again.folder) for row in again.animals] == keys


def test_the_page_says_what_the_design_says(stored, report, supplement):
    said = dict(report.answers())
    assert said["How were animals compared?"] == (
        "Ratios and means of groups are adjusted for sex: they are those of groups with the same mean of it (of a "
        "category: with as many animals of each kind); animals of one "
        "litter (of 3: L0, L1 and L2) may be alike (random effects); "
        "the 20 recordings are of 10 animals (column mouse), whose own level is a "
        "random effect; time (before and after; compared with before) is a second factor, its effect in each group of "
        "its own."
    )
    assert "between HPH and CTL" in said["Pressure and flow"] or "in HPH than in CTL" in said["Pressure and flow"]
    assert "from before to after" in said["Pressure and flow"]
    assert "time after and time before on average over the groups" in said["Pressure and flow"]
    assert report.subtitle == "20 recordings of 10 animals in 2 groups: CTL, HPH"
    rows = stored.compare("HPH").table
    assert set(rows["what"]) == {"groups", "interaction"}
    methods = " ".join(block.text for block in walk(supplement) if isinstance(block, Paragraph))
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
    assert "when results were there already: quantities." in methods_of(stored)
    cohort, family = stored.gathered(stored.in_order(), "CTL"), stored.settings.report
    (section, *_) = answer_sections(cohort, primary_comparison(cohort, family), family)
    assert "Changed when results were there already: quantities (" in str(Report("", "", "", "", [section]).answers())
    (tmp_path / RECORD).write_text("{", encoding="utf-8")
    with pytest.raises(InputError, match=r"declared\.json: damaged"):
        declare(study)


def methods_of(stored):
    cohort = stored.gathered(stored.in_order(), "CTL")
    section = methods_section(cohort, primary_comparison(cohort, stored.settings.report), {})
    return " ".join(block.text for block in section.blocks if isinstance(block, Paragraph))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        pytest.param(
            lambda study: with_cell(study, "sex", lambda row: "m" if row["mouse"] == "M2" else row["sex"]),
            "animals (changed: CTL 5, sex f → m and CTL 6, sex f → m).",
            marks=pytest.mark.validation,
        ),
        (
            lambda study: study.table.write_text(
                "\n".join(one for one in study.table.read_text(encoding="utf-8").splitlines() if "HPH 10," not in one),
                encoding="utf-8",
            ),
            "animals (dropped: HPH 10).",
        ),
    ],
)
def test_a_row_that_changes_once_results_are_there_is_said_in_methods(ran, supplement, results, change, words):
    before = " ".join(block.text for block in walk(supplement) if isinstance(block, Paragraph))
    assert "Groups, family, law, design and animals were declared on" in before
    assert "They were not changed since." in before
    change(ran)
    after = read_study(ran.folder)
    of = {row.animal: row.group for row in after.animals}
    said = methods_of(run(after, [replace(one, group=of[one.name]) for one in results if one.name in of]))
    assert f", when results were there already: {words}" in said
    assert "not changed since" not in said


@pytest.mark.validation
def test_an_order_of_rows_that_turns_the_reference_round_is_said_in_methods(tmp_path, results):
    study = make(tmp_path, results)
    week = {"before": "w1", "after": "w2"}  # none of which says that it came first, as 'before' does
    with_cell(study, "time", lambda row: week[row["time"]])
    study = read_study(tmp_path)
    run(study, results)
    rows = study.table.read_text(encoding="utf-8").splitlines()
    study.table.write_text("\n".join(rows[:1] + rows[2:] + rows[1:2]), encoding="utf-8")
    said = methods_of(run(read_study(tmp_path), results))
    assert ", when results were there already: reference (w1 → w2)." in said


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
    assert [(one.finding.code, one.error) for one in problems] == [
        ("variable.same-word", False), ("design.varies-within", True)
    ]  # fmt: skip
    assert "line 4, column 'sex': 'M' in M1 and 'm' in 5 count as two" in str(problems[0])
    study.table.write_text(text.replace(",m,", ",,", 2), encoding="utf-8")
    _, problems = inspect_study(tmp_path)
    gaps = [one for one in problems if one.finding.code == "variable.gaps"]
    assert [(one.place.line, one.same) for one in gaps] == [(4, (5,))]


def with_cell(study, column, cell):
    """Write another text into the cells of a column: `cell` takes a row, as a dict, and returns it."""
    head, *rows = study.table.read_text(encoding="utf-8").splitlines()
    titles = head.split(",")
    lines = [dict(zip(titles, row.split(","), strict=True)) for row in rows]
    lines = [row | {column: cell(row)} for row in lines]
    study.table.write_text("\n".join([head, *(",".join(row.values()) for row in lines)]) + "\n", encoding="utf-8")


def found(folder, room="design"):
    """Return the findings of one room in the study's files, by code."""
    _, problems = inspect_study(folder)
    return {one.finding.code: one for one in problems if one.finding.room == room}


def test_a_sex_that_is_the_group_is_named_with_what_it_hides_and_is_an_error_where_it_hides_all(tmp_path, results):
    study = make(tmp_path, results, DESIGN.replace("blocks: [litter], ", ""))
    with_cell(study, "sex", lambda row: "mf"[row["group"] == "HPH"])
    one = found(tmp_path)["design.confounded"]
    assert not one.error
    assert dict(one.finding.values) == {"effect": "HPH against CTL", "columns": "sex", "instead": ""}
    said = read_study(tmp_path).layout.text
    assert said.endswith("compared: time after against time before; HPH against CTL in the change after/before.")
    study.path.write_text("design: {covariates: [sex]}\n", encoding="utf-8")
    one = found(tmp_path)["design.nothing-told"]
    assert one.error
    assert "sex cannot be told apart from HPH against CTL" in str(one)
    with pytest.raises(InputError, match="nothing can be compared by this design"):
        read_study(tmp_path)
    study.path.write_text("design: {blocks: [group of]}\n", encoding="utf-8")
    table = study.table.read_text(encoding="utf-8").replace("sex", "group of")
    study.table.write_text(table, encoding="utf-8")
    with pytest.raises(InputError, match="'group of' cannot be told apart from the groups"):
        read_study(tmp_path)


def test_an_occasion_that_a_group_lacks_is_named_and_the_page_compares_what_is_left(tmp_path, results):
    kept = [one for place, one in enumerate(results) if one.group == "HPH" or not place % 2]
    study = make(tmp_path, results, DESIGN.replace("covariates: [sex], blocks: [litter], ", ""))
    table = study.table.read_text(encoding="utf-8").splitlines()
    names = {one.name for one in kept}
    study.table.write_text(
        "\n".join([table[0], *(row for row in table[1:] if row.split(",")[0] in names)]) + "\n", encoding="utf-8"
    )
    _, problems = inspect_study(tmp_path)
    lost = [dict(one.finding.values) for one in problems if one.finding.code == "design.no-cell"]
    assert [one["cells"] for one in lost] == ["CTL, after"] * 3
    assert lost[0]["instead"] == " (compared is HPH against CTL at time before)"
    stored = run(read_study(tmp_path), kept)
    cohort = stored.gathered(stored.in_order(), "CTL")
    primary = primary_comparison(cohort, stored.settings.report)
    assert set(primary.table()["within"]) == {"at time before", "in HPH"}
    said = dict(report_of(cohort, primary, stored.settings.report).answers())
    assert (
        "HPH against CTL in the change after/before: not compared, for nothing is known of CTL, after"
        in (said["Left out"])
    )
    assert said["Left out"].count("not compared") == 1
    assert "HPH against CTL (compared is HPH against CTL at time before)" in said["Left out"]
    assert "CTL at time before" in said["Pressure and flow"]
    assert "time before in HPH" in said["Pressure and flow"]


def test_a_property_of_a_mouse_that_differs_between_its_rows_is_an_error_with_their_lines(tmp_path, results):
    study = make(tmp_path, results)
    with_cell(study, "sex", lambda row: "m" if row["animal"] == "CTL 2" else row["sex"])
    one = found(tmp_path)["design.varies-within"]
    assert one.error
    assert (one.place.line, one.place.part) == (2, "column 'sex'")
    assert "mouse M0 has sex 'f' in line 2 and sex 'm' in line 3" in str(one)
    study = make(tmp_path, results)
    with_cell(study, "litter", lambda row: "L1" if row["animal"] == "CTL 2" else row["litter"])
    assert "litter 'L0' in line 2 and litter 'L1' in line 3" in str(found(tmp_path)["design.varies-within"])


def test_a_design_that_leaves_few_degrees_of_freedom_says_so_in_check_and_on_the_page(tmp_path, results):
    assert "design.few-degrees" not in found((make(tmp_path, results)).folder)
    study = make(tmp_path, results, DESIGN.replace("[sex]", "[sex, weight, born]"))
    with_cell(study, "weight [g]", lambda row: str(20 + int(row["mouse"][1:]) ** 2 % 7))
    values = dict(found(tmp_path)["design.few-degrees"].finding.values)
    assert (values["effects"], values["freedom"]) == ("HPH against CTL", 10 - 2 - 3 - 2)
    rows = 2 * 3  # quantities and comparisons
    assert values["times"] == pytest.approx(stats.t.ppf(1 - 0.025 / rows, 3))
    assert values["many"] == pytest.approx(stats.norm.ppf(1 - 0.025 / rows))
    stored = run(read_study(tmp_path), results)
    cohort = stored.gathered(stored.in_order(), "CTL")
    primary = primary_comparison(cohort, stored.settings.report)
    few = primary.table()[primary.table()["df"] < 4]
    assert set(few["what"]) == {"groups"}
    said = " ".join(group_answer(primary, str).sureness)
    assert f"HPH / CTL: {len(few)} of 6 ratios rest on" in said


def test_a_covariate_in_which_the_groups_differ_is_named_with_what_it_costs(tmp_path, results):
    """√(1/(1 - r²)) times the interval, r being the correlation of group and weight."""
    study = make(tmp_path, results, "design: {covariates: [weight]}\n")
    weights = {row.animal: 20.0 + place % 10 * 0.5 + 4 * (row.group == "CTL")
               for place, row in enumerate(study.animals)}  # fmt: skip
    with_cell(study, "weight [g]", lambda row: str(weights[row["animal"]]))
    finding = found(tmp_path)["design.costly-covariates"].finding
    r = np.corrcoef([row.group == "CTL" for row in study.animals], [*weights.values()])[0, 1]
    assert dict(finding.values)["factor"] == pytest.approx(np.sqrt(1 / (1 - r**2)))
    with_cell(study, "weight [g]", lambda row: str(weights[row["animal"]] - 4 * (row["group"] == "CTL")))
    assert "design.costly-covariates" not in found(tmp_path)


def test_a_word_of_one_mouse_is_said_with_its_lines_and_the_word_that_is_meant(tmp_path, results):
    study = make(tmp_path, results)
    with_cell(study, "sex", lambda row: "male" if row["mouse"] == "M1" else row["sex"])
    one = found(tmp_path, "variable")["variable.misspelt"]
    assert (one.place.line, one.same) == (4, (5,))
    assert "'male' in M1 alone, 'm' in 4: did you mean 'm'?" in str(one)


def test_a_mouse_without_an_occasion_that_others_have_is_named_with_its_line(tmp_path, results):
    study = make(tmp_path, results)
    lines = study.table.read_text(encoding="utf-8").splitlines()
    study.table.write_text("\n".join([*lines[:4], *lines[5:]]) + "\n", encoding="utf-8")
    one = found(tmp_path)["design.missing-occasion"]
    assert str(one).startswith(f"{study.table}, line 4, column 'time': mouse M1 has no recording at time 'after'")
    assert not found(tmp_path, "variable")
    study = make(tmp_path, results)
    with_cell(study, "time", lambda row: "afetr" if row["animal"] == "CTL 4" else row["time"])
    assert "did you mean 'after'?" in str(found(tmp_path, "variable")["variable.misspelt"])
    assert [dict(found(tmp_path)["design.missing-occasion"].finding.values)[key] for key in ("names", "level")] == [
        "M1", "after"
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("design", "code", "words"),
    [
        (
            "subject: born, occasion: time, crossover: true",
            "design.same-occasion",
            "line 12, column 'time': born '2024-03-01' stands at time before in lines 2 and 12,",
        ),
        (
            "subject: row, occasion: time",
            "design.one-occasion",
            "column 'time': no row was recorded at two levels of time",
        ),
        ("subject: row", "design.subject-once", "column 'row': no row has two rows"),
        ("subject: mouse, occasion: litter", "design.one-occasion", "no mouse was recorded at two levels of litter"),
        (
            "subject: mouse, occasion: litter",
            "design.same-occasion",
            "line 3, column 'litter': mouse 'M0' stands at litter L0 in lines 2 and 3, ",
        ),
        ("blocks: [group]", "setting.at-odds", "'group' is not a column of the lab's own"),
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


def swapped(study, old, new):
    """Write the table of a study with another text; return what is wrong in the study."""
    study.table.write_text(study.table.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    return inspect_study(study.folder)[1]


def test_a_mouse_in_two_groups_is_an_error_at_its_rows_unless_the_design_is_a_crossover(tmp_path, results):
    study = make(tmp_path, results)
    problems = swapped(study, ",M5,", ",M4,")  # M4 is of CTL, in lines 10 and 11; lines 12 and 13 are of HPH
    (wrong,) = [one for one in problems if one.error]
    assert (wrong.finding.code, wrong.place.line) == ("design.several-groups", 12)
    assert "'M4' is in CTL (lines 10 and 11) and HPH (lines 12 and 13)" in str(wrong)
    assert set(wrong.animals) == {"CTL 9", "CTL 10", "HPH 1", "HPH 2"}
    with pytest.raises(InputError, match=r"line 12, column 'mouse'.*\n?.*write crossover: true under design"):
        read_study(tmp_path)
    study.path.write_text(DESIGN.replace("subject: mouse", "subject: mouse, crossover: true"), encoding="utf-8")
    assert "design.several-groups" not in [one.finding.code for one in inspect_study(tmp_path)[1]]


def test_an_animal_that_is_in_both_groups_of_a_crossover_is_compared_with_itself(tmp_path, results):
    study = make(tmp_path, results, "design: {subject: mouse, crossover: true}\n")
    text = study.table.read_text(encoding="utf-8")
    for number in range(5):
        text = text.replace(f",M{number + 5},", f",M{number},")
    swapped(study, study.table.read_text(encoding="utf-8"), text)
    said = understood(read_study(tmp_path), True)
    assert said.startswith("20 recordings of 5 animals; compared: HPH against CTL.")
    assert "A mouse in several groups is compared with itself." in said


def test_litters_that_the_design_does_not_name_are_told_by_check_and_on_the_page(tmp_path, results):
    """Without them two mice of each litter are alike in a group: Welch's test finds too much."""
    study = make(tmp_path, results, "design: {subject: mouse, occasion: time}\nreport: {quantities: [mPAP]}\n")
    with_cell(study, "litter", lambda row: f"L{(int(row['mouse'][1:]) + 1) // 3}")
    with_cell(study, "sex", lambda row: "f" if row["group"] == "CTL" else "m")
    litter, sex = (found(tmp_path)[f"design.{code}"] for code in ("unit-unused", "column-is-group"))
    assert (litter.place.part, sex.place.part) == ("column 'litter'", "column 'sex'")
    assert "5 CTL from 2 (L0, L1), 5 HPH from 2" in str(litter)
    stored = run(read_study(tmp_path), results)
    cohort = stored.gathered(stored.in_order(), "CTL")
    report = report_of(cohort, primary_comparison(cohort, stored.settings.report), stored.settings.report)
    text = str([block.items for block in walk(report) if isinstance(block, Notice)])
    assert "all CTL are f, all HPH are m" in text
    assert "name it under blocks" in text


def test_the_page_says_how_often_few_animals_show_what_is_not_there(cohort, report):
    text = dict(report.answers())["How sure is this?"]
    layout = laid_out(cohort.design, cohort.variables, cohort.members, ["CTL", "HPH"])
    (skewed,) = [doubt for doubt in doubts_of(layout, 2) if doubt.shape is PopulationShape.SKEWED]
    low, high = (f"{100 * rate:.0f}" for rate in (min(skewed.rates), max(skewed.rates)))
    assert f"in {low} to {high} if they are skewed and {skewed.cells[0]}" in text
