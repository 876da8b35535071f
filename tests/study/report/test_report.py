import re
from dataclasses import replace
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest

from made_cohort import FAILURE, PLANTED, made_results
from vasowave.base import InputError
from vasowave.study.animal import Failure, Stage
from vasowave.study.cohort import (
    Assurance,
    Design,
    Family,
    Primary,
    Variable,
    cohort_table,
    compare,
    contrasts,
    gathered,
    holm,
    importance,
    primary_comparison,
)
from vasowave.study.figures import new_figure, style
from vasowave.study.report import (
    SUPPLEMENT,
    Answers,
    Drawing,
    Fold,
    Paragraph,
    Report,
    ReportSettings,
    Section,
    SideBySide,
    markup,
    number,
    report_of,
    supplement_of,
    write_report,
)
from vasowave.study.report.sections import data, groups, groups_section, median_iqr, methods_section, models

NOTHING = Primary("linear", (), (), ())


class Tables(HTMLParser):
    """Collects the rows of every table of a page by the table's id."""

    def __init__(self, text):
        super().__init__()
        self.tables, self.name, self.cell = {}, None, None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        if tag == "div" and values.get("class") == "table":
            self.name = values.get("id", f"unnamed {len(self.tables)}")
            self.tables[self.name] = []
        elif tag == "tr":
            self.tables[self.name].append([])
        elif tag in ("td", "th"):
            self.cell = tag
            self.tables[self.name][-1].append("")

    def handle_endtag(self, tag):
        if tag in ("td", "th"):
            self.cell = None

    def handle_data(self, text):
        if self.cell:
            self.tables[self.name][-1][-1] += text


@pytest.fixture(scope="module")
def tables(cohort_page):
    return Tables(cohort_page).tables


@pytest.fixture
def results(cohort_results):
    return cohort_results


@pytest.fixture
def folder(cohort_report):
    return cohort_report


@pytest.fixture
def page(cohort_page):
    return cohort_page


def column_of(rows, start):
    return next(place for place, cell in enumerate(rows[0]) if cell.startswith(start))


def test_the_values_of_the_page_come_from_the_trees(results, tables):
    rows = tables["table-Parameters-linear"]
    place = column_of(rows, "RT")
    assert rows[2][0] == "CTL 2"
    assert rows[2][place] == "98.8"
    for row, result in zip(rows[1:], results, strict=True):
        assert row[0] == result.name
        assert float(row[column_of(rows, "β")]) == pytest.approx(
            float(result.laws["linear"].quantities["beta"]), rel=5e-3
        )
    start = {row[0]: row for row in tables["table-ParNom"][1:]}
    for result in results:
        assert float(start[result.name][3]) == pytest.approx(float(result.nominal["beta"]), rel=5e-3)


def test_a_value_at_its_bound_is_marked_where_it_stands(tables):
    rows = tables["table-Parameters-tangent"]
    assert rows[1][column_of(rows, "p₁ ")].endswith("†")
    assert not rows[2][column_of(rows, "p₁ ")].endswith("†")


def test_eta_and_p_of_the_page_are_those_of_the_cohort_functions(results, tables):
    table = cohort_table(results)
    linear = table[table["source"] == "linear"]
    found = contrasts(linear, ["R_T [mmHg s/ml]", "C_T [ml/mmHg]"], "CTL", "HPH")
    rows = {row[0].split(" [")[0]: row for row in tables["table-Contrasts-linear"][1:]}
    for name, (_, expected) in zip(("RT", "CT"), found.iterrows(), strict=True):
        assert rows[name][1] == number(expected["eta"], 2)
        assert float(rows[name][2].split()[0]) == pytest.approx(expected["ratio"], rel=0.05)
        assert rows[name][4] == number(expected["p"], 2)
    ctl, hph = (linear.loc[linear["group"] == group, "R_T [mmHg s/ml]"].mean() for group in ("CTL", "HPH"))
    drawn = importance(gathered(results), "linear", {"R_T": "R_T"})
    assert drawn["eta"].tolist() == [pytest.approx((hph - ctl) / ctl)]


def test_no_group_is_set_against_another_than_the_reference_where_that_lacks_a_law():
    results = made_results({"CTL": 2, "HPH": 2, "drug": 2})
    lacking = [replace(one, laws={"linear": one.laws["linear"]}) if one.group == "CTL" else one for one in results]
    assert importance(gathered(results), "tangent", {"R_T": "R_T"})["group"].tolist() == ["HPH", "drug"]
    assert len(importance(gathered(lacking), "tangent", {"R_T": "R_T"})) == 0


def test_the_indices_of_the_groups_are_mean_and_sd_of_their_animals(results, tables):
    rows = {row[0]: row for row in tables["table-HemoStats"][1:]}
    for place, group in ((1, "CTL"), (2, "HPH")):
        values = [float(t.measured.quantities["mPAP"]) for t in results if t.group == group]
        mean, deviation = map(float, rows["mPAP [mmHg]"][place].split(" ± "))
        assert mean == pytest.approx(np.mean(values), rel=5e-3)
        assert deviation == pytest.approx(np.std(values, ddof=1), rel=0.05)


def test_every_figure_and_table_of_the_paper_is_there(page, folder, tables):
    figures = "hemoData Network parEst PQsim-1 PAsim ParOpt WIA-1 WIA-2 Impd ParAll_change Residuals Waterfall beats-1"
    for name in figures.split():
        assert f'id="figure-{name}"' in page
        letters = "".join(ElementTree.parse(folder / "figures" / f"{name}.svg").getroot().itertext())
        assert re.search(r"\[|%", letters), f"{name} has no editable letters"
        assert (folder / "figures" / f"{name}.pdf").read_bytes().startswith(b"%PDF")
    names_of_tables = ("HemoStats", "Network", "ParNom", "Bounds", "Parameters-linear",
                       "Parameters-tangent", "Groups", "Starts")  # fmt: skip
    for name in names_of_tables:
        assert f"table-{name}" in tables
        assert (folder / "tables" / f"{name}.tex").is_file()
        assert len(pd.read_csv(folder / "tables" / f"{name}.csv"))


def test_tables_on_disk_keep_full_precision_and_units(results, folder):
    table = pd.read_csv(folder / "tables" / "Parameters-linear.csv").set_index("animal")
    assert table.loc["CTL 2", "R_T [mmHg s/ml]"] == PLANTED
    assert float(results[5].laws["linear"].quantities["beta"]) == table.loc["HPH 3", "beta [mmHg]"]


def test_failed_animals_stand_on_the_first_page_notes_and_settings_behind_it(page, cohort_answer):
    answer = cohort_answer
    assert f"HPH 9 failed, computing: {FAILURE}" in answer
    assert "the flow &lt;ends&gt; late &amp; is odd" in page
    assert "Synthetic data." in page
    assert "Synthetic data." in answer
    assert "bounded least squares" in page
    assert "A test by ranks cannot come below p = 0.10 with 3 + 3 animals" in answer


def test_the_pages_load_nothing_and_their_ids_are_unique(page, cohort_answer, folder):
    for text, least in ((page, 500), (cohort_answer, 50)):
        assert not re.search(
            r'https?:|@import|<script (?!type="application/json">)\w|<link|<iframe|fetch\(|url\((?!#)', text
        )
        ids = re.findall(r'\bid="([^"]+)"', text)
        assert len(ids) == len(set(ids)) > least
        assert set(re.findall(r'(?:href="#|url\(#)([^")]+)', text)) <= set(ids)
        assert all((folder / name).is_file() for name in re.findall(r'<a href="([^"#]+)"', text))
        assert len(text) < 5_000_000


def test_other_files_of_the_folder_stay_and_foreign_reports_are_not_replaced(results, folder, tmp_path):
    assert (folder / "results.nc").read_bytes() == b"not ours to touch"
    names = "figures report.html report.pdf results.nc supplement.html supplement.pdf tables"
    assert sorted(path.name for path in folder.iterdir()) == names.split()
    (tmp_path / "report.html").write_text("a thesis")
    with pytest.raises(InputError, match="not of an earlier vasowave report"):
        write_report(results, tmp_path, pdf=False)
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]


def test_a_report_that_fails_midway_leaves_the_earlier_one_as_it_was(results, folder, monkeypatch):
    before = {path: path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}

    def full(*arguments):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("vasowave.study.report.write.write_tables", full)
    monkeypatch.setattr("vasowave.study.report.write.write_figures", lambda *arguments: None)
    with pytest.raises(InputError, match="no space left"):
        write_report(results[:1], folder, pdf=False)
    assert {path: path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()} == before


def test_the_methods_say_of_how_many_recordings_a_drift_was_removed():
    one = made_results({"CTL": 1}, raw=1, walls=())[0]
    drifting, steady = (
        replace(one, name=name, beats=one.beats.assign_attrs(drift_size=size, drift_removed=removed))
        for name, size, removed in (("a", -0.8, 1), ("b", 0.05, 0))
    )
    said = methods_section(gathered([drifting, steady]), NOTHING, {}).blocks[0].text
    assert "The drift of the diastolic pressure of 1 of 2 recordings was removed (0.80 mmHg over a recording)." in said
    assert "drift" not in methods_section(gathered([steady]), NOTHING, {}).blocks[0].text


def test_recordings_of_the_same_animals_are_not_tested_as_if_they_were_independent():
    """Two recordings of each of two mice: the paper's tests would count four."""
    cohort = gathered(made_results({"CTL": 2, "HPH": 2}, walls=("linear",)))
    mice = Variable.from_cells("mouse", {"CTL 1": "A", "CTL 2": "A", "HPH 1": "B", "HPH 2": "B"})
    again = replace(cohort, design=Design(subject="mouse"), variables={"mouse": mice})
    folds = [[one.title for one in groups_section(each, NOTHING, {}, {}).blocks if isinstance(one, Fold)]
             for each in (cohort, again)]  # fmt: skip
    assert folds[0] == ["Secondary: importance indices of the paper", *folds[1]]
    assert "Mann-Whitney" not in methods_section(again, NOTHING, {}).blocks[0].text


def test_no_table_of_the_supplement_takes_the_file_of_one_of_the_first_page():
    cohort = gathered(made_results({"CTL": 2, "HPH": 2}, walls=("linear",)))
    weight = Variable.from_cells("weight [g]", {"CTL 1": "21", "CTL 2": "23", "HPH 1": "20", "HPH 2": "22"})
    cohort = replace(cohort, variables={weight.name: weight})
    primary = primary_comparison(cohort, ReportSettings(quantities=("mPAP",)))
    documents = report_of(cohort, primary, ReportSettings()), supplement_of(cohort, primary)
    names = [table.name for document in documents for table in document.tables()]
    assert {"Animals", "Columns"} <= set(names)
    assert len(names) == len(set(names))


def test_the_first_table_describes_the_animals_by_what_their_lab_writes_in_its_language():
    cohort = gathered(made_results({"CTL": 2, "HPH": 2}, walls=()))
    cells = {"Gewicht [g]": ("21", "23", "20", "22"), "sexo": ("m", "f", "m", "m"), "chip": ("a", "b", "c", "d"),
             "born": ("2024-01-01", "2024-01-02", "2024-01-03", "2024-01-04")}  # fmt: skip
    animals = ("CTL 1", "CTL 2", "HPH 1", "HPH 2")
    columns = [Variable.from_cells(title, dict(zip(animals, texts, strict=True))) for title, texts in cells.items()]
    (table,) = data.animals_table(replace(cohort, variables={column.name: column for column in columns}))
    rows = {row[0]: row[1:] for row in table.rows}
    assert rows["Gewicht [g]"] == ("22.0 ± 1.4", "21.0 ± 1.4")
    assert rows["sexo"] == ("1 m, 1 f", "2 m")
    assert not {"chip", "born"} & {*rows}


@pytest.mark.parametrize(("rate", "said"), [(0.0612, 1), (0.06, 0)])
def test_p_that_come_too_often_are_remarked_with_their_rate(rate, said):
    cohort = gathered(made_results({"CTL": 2, "HPH": 2}, walls=()))
    found = primary_comparison(cohort, Family(quantities=("mPAP",)))
    doubted = replace(found, assurance=Assurance(rate, 0.99, 3.2, 3))
    text = str(groups_section(cohort, doubted, {}, {}))
    assert text.count("in spread by up to a factor of 3.2, and the smallest has 3 animals") == said
    assert text.count("a row with p < 0.05 in 6 % of cases instead of 5 %") == said


def test_a_group_of_one_animal_has_no_empty_scatter():
    table = models.waves(gathered(made_results({"sham": 1}, walls=("linear",))))
    assert {row[3] for row in table.rows} == {"1"}
    assert not any("±" in cell for row in table.rows for cell in row)


def test_one_animal_has_no_quartiles():
    one = pd.Series({"median": 537.0, "Q1": 537.0, "Q3": 537.0, "SD": np.nan})
    assert median_iqr(one) == "537"
    assert median_iqr(pd.Series({"median": 537.0, "Q1": 530.0, "Q3": 540.0, "SD": 5.0})) == "537.0 [530.0, 540.0]"


def three_groups():
    return made_results({"sham & co": 2, "2 weeks": 2, "4 weeks": 2}, walls=("linear",))


def test_three_groups_of_any_label_are_compared_two_by_two():
    arranged = gathered(three_groups(), "2 weeks")
    assert list(arranged.groups) == ["2 weeks", "sham & co", "4 weeks"]
    found = compare(arranged, "linear")
    pairs = list(zip(found.contrasts["reference"], found.contrasts["other"], strict=True))
    assert set(pairs) == {("2 weeks", "sham & co"), ("2 weeks", "4 weeks"), ("sham & co", "4 weeks")}
    np.testing.assert_allclose(found.contrasts["p Holm"], holm(found.contrasts["p"].to_numpy()))
    assert found.without_one.index.is_unique
    shown = groups.contrasts(found, "linear", {})
    assert shown.rows[0][1] == "sham & co / 2 weeks"
    with pytest.raises(InputError, match="no animal is of the reference group 'CTL'"):
        gathered(three_groups(), "CTL")


def test_contents_and_provenance_stand_in_the_pdf_of_the_supplement_alone():
    origin = {"vasowave": "1.0", "animals.csv": "0f3a"}
    first, second = (markup(Report(name, "Mice", "two", "", [], origin)) for name in ("report", SUPPLEMENT))
    assert "Provenance" not in first
    assert "outline" not in first
    assert "#outline(title: none, target: heading.where(level: 2)" in second  # its own title is no content
    assert all(f'"{word}"' in second.partition("== Provenance")[2] for pair in origin.items() for word in pair)


@pytest.mark.parametrize(("height", "after", "pages"), [(10, 0, 1), (17, 0, 1), (20, 0, 1), (30, 0, 2), (30, 8, 2)])
def test_a_figure_stands_on_the_page_of_its_words_where_it_can(height, after, pages, tmp_path):
    """25.7 cm of a page are for the text, and the words take about 6 of them; a figure shrinks to 0.7 at most.

    The words after one that stands on the next page fill the first.
    """
    with style():
        drawing = Drawing("Forest", "A caption of the figure.", new_figure(17, height))
    answers = Answers([(f"Question {k}?", "An answer of more than one line. " * 6) for k in range(5)])
    blocks = [SideBySide([answers], [drawing]), *[Paragraph("A paragraph of more than one line. " * 6)] * after]
    sections = [Section("answer", "The answer", blocks)]
    (tmp_path / "Forest.svg").write_text(drawing.svg, encoding="utf-8")
    (tmp_path / "page.typ").write_text(markup(Report("report", "Mice", "two", "", sections)), encoding="utf-8")
    typst = pytest.importorskip("typst")
    made = typst.Compiler(root=str(tmp_path)).compile(str(tmp_path / "page.typ"), format="svg")
    assert (len(made) if isinstance(made, list) else 1) == pages


def test_no_animal_and_twins_are_refused(results, tmp_path):
    with pytest.raises(InputError, match="there is no animal to report; a: lost"):
        write_report([], tmp_path, lost=[Failure("a", "CTL", "", Stage.READING, "lost")])
    with pytest.raises(InputError, match="two animals are called 'CTL 1'"):
        write_report([results[0], results[0]], tmp_path)
