"""The report of one animal: the same page, with nothing about groups."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest

from approval import PAPER, approve, figures
from approval import page as page_of
from made_cohort import changed, made_results
from made_posterior import with_posterior
from vasowave.base import as_json
from vasowave.pulse.inference import HALF_EMPTY
from vasowave.pulse.model import LinearWall
from vasowave.study.cohort import gathered, primary_comparison
from vasowave.study.report import ReportSettings, caller, value_text, write_report
from vasowave.study.report.answer import animal_answers, problem_blocks
from vasowave.study.report.sections import animals as tables
from vasowave.study.report.sections import fit_sentences
from vasowave.study.running import SENTENCE_QUANTITIES


@pytest.fixture(scope="module")
def result(lone_animal):
    return lone_animal


@pytest.fixture(scope="module")
def folder(lone_report):
    return lone_report


@pytest.fixture(scope="module")
def page(folder):
    return (folder / "supplement.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def answer(folder):
    return (folder / "report.html").read_text(encoding="utf-8")


def test_the_page_is_about_one_animal(page, folder):
    assert "<h1>Supplement: Hemodynamic assessment of sham 1</h1>" in page
    assert 'id="groups"' not in page
    assert "±" not in page.split('id="table-HemoStats"')[1].split("</table>")[0]
    drawn = ("hemoData", "Network", "parEst", "PQsim-1", "PAsim", "Waterfall",
             "WIA-1", "Impd", "Residuals", "beats-1", "fit-1")  # fmt: skip
    for name in drawn:
        assert f'id="figure-{name}"' in page
    for name in ("ParOpt", "ParAll_change", "Ratios-linear"):
        assert f'id="figure-{name}"' not in page
    assert not (folder / "report.pdf").exists()
    assert not re.search(r"per animal|every animal|each recording|of 1 ", page)


def test_the_small_vessels_have_their_resistance_and_pvr_says_from_which_pressure_it_counts(result):
    called = caller(gathered([result]))
    answers = dict(animal_answers(result, "linear", SENTENCE_QUANTITIES, called))
    assert f"R_T {value_text(result.laws['linear'].answers['R_T'])}" in answers["Small vessels"]
    assert "counted from 0 mmHg, for no wedge pressure is given" in answers["Pressure and flow"]
    wedged = replace(result, recording=result.recording.assign(wedge_pressure=8.5))
    said = dict(animal_answers(wedged, "linear", SENTENCE_QUANTITIES, called))["Pressure and flow"]
    assert "counted from a wedge pressure of 8.5 mmHg" in said


def test_approved_the_pages_and_the_drawings_of_one_animal(folder):
    approve(
        "one animal, pages", (line for name in ("report.html", "supplement.html") for line in page_of(folder / name))
    )
    of_a_cohort = ("Network", "PQsim-1", "WIA-1", "Impd", "Residuals", "beats-1", "fit-1", "Tree")
    approve("one animal, figures", figures(folder / "figures", without=of_a_cohort), PAPER)


def test_what_was_measured_stands_beside_what_every_wall_law_says(result):
    table = tables.values(result, {})
    assert table.header == ("quantity", "measured", "linear wall", "tangent wall")
    rows = {row[0].split(" [")[0]: row for row in table.rows}
    for place, source in enumerate(("measured", "linear", "tangent"), start=1):
        shown = float(rows["mPAP"][place].split(" [")[0])
        assert shown == pytest.approx(float(result.sources[source].quantities["mPAP"]), rel=5e-3)
    assert rows["p1"][1:3] == ("", "")


def test_disagreeing_starts_bounds_and_undetermined_parameters_are_said_in_words(result):
    tangent, symbols = result, {"gamma": "γ", "p1": "p₁"}
    said = " ".join(fit_sentences(tangent, "tangent", symbols))
    assert "Only 3 of 4 starts" in said
    assert "do not determine r1" in said
    fit = tangent.laws["tangent"].calibration
    gamma, p1 = (fit["parameter"].values == name for name in ("gamma", "p1"))
    ends = {"at_bound": gamma, "free": fit["free"].values & ~p1, "lower": np.where(gamma, fit["value"], fit["lower"])}
    tangent = changed(result, "tangent/calibration", **ends)
    said = " ".join(fit_sentences(tangent, "tangent", symbols))
    assert "The search ended with γ at its lower bound (1.60)." in said
    assert re.search(r"p₁ = [\d.]+ mmHg \(held\)", said)
    assert "All 4 starts" in " ".join(fit_sentences(result, "linear", {}))


def test_the_records_are_tidy_and_whole(result, folder):
    starts = pd.read_csv(folder / "tables" / "EveryStart.csv")
    assert starts.groupby("wall")["start"].count().tolist() == [4, 4]
    outlets = pd.read_csv(folder / "tables" / "Outlets.csv")
    linear = outlets[outlets["wall"] == "linear"]
    np.testing.assert_array_equal(linear["R1 [mmHg s/ml]"], result.laws["linear"].calibration["R1"])
    assert linear["flow fraction [1]"].sum() == pytest.approx(1.0)
    values = pd.read_csv(folder / "tables" / "Values.csv").set_index(["law", "quantity"])
    assert values.loc[("measured", "mPAP"), "value"] == pytest.approx(float(result.recording["pressure"].mean()))
    waves = pd.read_csv(folder / "tables" / "Waveforms.csv")
    measured = waves[waves["source"] == "measured"]
    np.testing.assert_allclose(measured["pressure [mmHg]"], result.recording["pressure"])
    np.testing.assert_allclose(measured["time [s]"], result.recording["time"], atol=1e-12)


def test_an_animal_without_a_model_is_reported_and_called_synthetic_only_where_its_tree_says_so(page, tmp_path):
    assert "Synthetic data." in page
    (lone,) = made_results({"sham": 1}, walls=())
    lone = replace(lone, synthetic=False, name="not_synthetic_<script>alert(1)</script>")
    path = write_report([lone], tmp_path / "lone", pdf=False)
    for text in (path.read_text(encoding="utf-8"), path.with_name("supplement.html").read_text(encoding="utf-8")):
        assert "Synthetic data." not in text
        assert "<script>alert" not in text
        assert 'id="models"' not in text
        assert 'id="figure-hemoData"' in text or 'id="figure-Measured"' in text


def test_the_first_page_of_an_animal_says_how_much_a_mmhg_widens_its_arteries(result, answer):
    beta = float(result.laws["linear"].quantities["beta"])
    wider = np.sqrt(LinearWall(beta).ratio_at(1.0, beta)) - 1
    said = re.search(r"a large artery grows by ([\d.]+) \[[\d.]+, [\d.]+\] % in radius with the first mmHg", answer)
    assert float(said[1]) == pytest.approx(100 * wider, rel=0.02)


def test_a_figure_of_a_file_says_to_screen_readers_what_it_shows(folder):
    root = ElementTree.fromstring((folder / "figures" / "Impd.svg").read_text(encoding="utf-8"))
    (title, description, *_), space = root, "{http://www.w3.org/2000/svg}"
    assert (title.tag, description.tag, root.get("role")) == (f"{space}title", f"{space}desc", "img")
    assert title.text == "Impd"
    assert description.text.startswith("Impedance modulus")


def test_where_there_is_a_posterior_the_answers_are_its_numbers_and_say_so(result):
    drawn, called = with_posterior(result), caller(gathered([result]))
    said, plain = (
        " ".join(text for _, text in animal_answers(one, "linear", SENTENCE_QUANTITIES, called))
        for one in (drawn, result)
    )
    assert "(posterior under the linear wall)" in said
    assert "posterior" not in plain
    assert value_text(drawn.laws["linear"].answers["wave_speed"]) in said
    draws = drawn.laws["linear"].posterior.draws("wave_speed").ravel()
    shown = drawn.laws["linear"].answers["wave_speed"]
    assert float(shown) == pytest.approx(float(np.median(draws)), rel=0.01)
    low, high = np.sort(draws)[[round(0.025 * len(draws)), round(0.975 * len(draws))]]
    assert shown.attrs["interval_low"] == pytest.approx(low, rel=0.03)
    assert shown.attrs["interval_high"] == pytest.approx(high, rel=0.03)
    assert drawn.laws["linear"].answers["R_T"].attrs == result.laws["linear"].quantities["R_T"].attrs


def test_what_asks_for_a_look_in_the_posterior_of_the_answers_stands_on_the_page(result):
    drawn = with_posterior(result, trusted=0)
    table = drawn.laws["linear"].posterior.table
    doubt = HALF_EMPTY()
    posterior = replace(drawn.laws["linear"].posterior, table=table.assign_attrs(findings=as_json([doubt])))
    doubted = replace(drawn, laws={**drawn.laws, "linear": replace(drawn.laws["linear"], posterior=posterior)})
    for one, told in ((doubted, True), (drawn, False)):
        cohort = gathered([one])
        blocks = problem_blocks(cohort, primary_comparison(cohort, ReportSettings()))
        said = " ".join(item for block in blocks for item in block.items)
        assert (str(doubt) in said) is told
        assert ("All fits succeeded" in said) is not told
