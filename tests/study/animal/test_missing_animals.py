"""Animals and laws that failed are named wherever results are read, and the comparison says what it misses."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from made_cohort import made_results
from vasowave.study.animal import Failure, Stage, as_plain, from_plain
from vasowave.study.cohort import Missing, PressureRank, Primary, gathered, missing_animals, primary_comparison
from vasowave.study.report import write_report
from vasowave.study.report.answer import problems

pytestmark = pytest.mark.usefixtures("undrawn")

NO_START = "no start of the fit could be simulated; the first: vessel '1': collapses"


@pytest.fixture(scope="module")
def results():
    """Return 3 + 4 animals; HPH 2 lacks the tangent law and HPH 3 both."""
    found = made_results({"CTL": 3, "HPH": 4})
    for place, laws in ((4, ["tangent"]), (5, ["linear", "tangent"])):
        one = found[place]
        failed = tuple(Failure(one.name, "HPH", law, Stage.FIT, NO_START, 30.0) for law in laws)
        left = {wall: law for wall, law in one.laws.items() if wall not in laws}
        found[place] = replace(one, laws=left, failures=failed)
    return found


def said_of(cohort, law):
    """Return the problems on the page where the primary comparison is by a law."""
    return problems(cohort, Primary(law, (), (), (), missing=missing_animals(cohort, law)))


LOST = Failure("HPH 9", "HPH", "", Stage.COMPUTING, "its process died", 99.5)


def pressure(result):
    return float(result.measured.quantities["mPAP"])


def test_a_comparison_misses_animals_without_a_result_and_without_its_law(results):
    cohort = gathered(results, lost=[LOST])
    (tangent,) = missing_animals(cohort, "tangent")
    assert (tangent.group, tangent.animals, tangent.lost) == ("HPH", ("HPH 9", "HPH 2", "HPH 3"), ("HPH 9",))
    assert tangent.count == 5
    assert tangent.pressures == pytest.approx((99.5, pressure(results[4]), pressure(results[5])))
    assert tangent.others == pytest.approx((pressure(results[3]), pressure(results[6])))
    (linear,) = missing_animals(cohort, "linear")
    assert linear.animals == ("HPH 9", "HPH 3")
    assert missing_animals(gathered(results), "") == ()


def test_the_primary_comparison_itself_tells_whom_it_misses_and_where_their_pressures_lie(results):
    cohort = gathered(results, lost=[LOST])
    primary = primary_comparison(cohort)
    assert primary.missing == missing_animals(cohort, "linear")
    (one,) = json.loads(json.dumps([one.as_plain() for one in primary.missing]))
    assert (one["group"], one["animals"], one["lost"], one["count"]) == ("HPH", ["HPH 9", "HPH 3"], ["HPH 9"], 5)
    assert one["pressures"] == pytest.approx([99.5, pressure(results[5])])
    assert one["standing"] == "above all others"
    linear = primary.table()[primary.table()["source"] == "linear"]
    assert (linear["n other"] + len(one["animals"])).tolist() == [one["count"]] * len(linear)
    assert primary_comparison(gathered(made_results({"CTL": 3, "HPH": 3}))).missing == ()


@pytest.mark.parametrize(
    ("pressures", "others", "standing"),
    [
        ((33.8,), (18.0, 25.0), PressureRank.ABOVE),
        ((24.0,), (18.0, 20.0, 25.0), PressureRank.HIGHER),
        ((19.0,), (18.0, 20.0, 25.0), PressureRank.LOWER),
        ((9.0,), (18.0, 25.0), PressureRank.BELOW),
        ((), (18.0, 25.0), PressureRank.UNKNOWN),
        ((33.8,), (), PressureRank.UNKNOWN),
    ],
)
def test_missing_animals_stand_somewhere_among_the_others_by_their_measured_pressure(pressures, others, standing):
    assert Missing("HPH", ("HPH 3",), (), 4, pressures, others).standing is standing


def test_the_page_says_who_is_missing_and_what_that_may_do(results):
    said = said_of(gathered(results, lost=[LOST]), "linear")
    assert "HPH 9 failed, computing: its process died" in said
    assert f"HPH 2 failed, tangent wall, fit: {NO_START}" in said
    (missing,) = [one for one in said if "misses" in one]
    assert "The comparison of the groups misses 2 of 5 animals of HPH (HPH 9 and HPH 3)." in missing
    higher = np.mean([99.5, pressure(results[5])]) > np.median([pressure(results[i]) for i in (3, 4, 6)])
    assert higher  # by the planted pressure
    assert "HPH looks healthier there than it is" in missing
    low = said_of(gathered(results, lost=[Failure("HPH 9", "HPH", "", Stage.COMPUTING, "died", 1.0)]), "")
    assert "1 of 5 animals of HPH (HPH 9). Measured mPAP 1.00 mmHg, below all others" in " ".join(low)
    unknown = said_of(gathered(results, lost=[Failure("HPH 9", "HPH", "", Stage.READING, "a gap")]), "")
    assert "Whether it was sicker than the others cannot be said" in " ".join(unknown)


@pytest.mark.validation
def test_both_documents_and_the_tables_name_what_failed(results, tmp_path):
    page = write_report(results, tmp_path / "report", lost=[LOST], pdf=False).read_text("utf-8")
    assert "7 of 8 animals in 2 groups" in page
    assert "HPH 9 failed, computing: its process died" in page
    assert "misses 2 of 5 animals of HPH" in page
    supplement = (tmp_path / "report" / "supplement.html").read_text("utf-8")
    assert "of 3 CTL and 4 of 5 HPH animals were analyzed" in supplement
    assert "The comparison of the groups misses 2 of 5 animals of HPH (HPH 9 and HPH 3)." in supplement
    assert "Failed: HPH 9 (computing); HPH 2 and HPH 3 (tangent wall, fit); HPH 3 (linear wall, fit)" in supplement
    table = pd.read_csv(tmp_path / "report" / "tables" / "Failures.csv")
    assert table[["animal", "law", "stage"]].to_numpy().tolist() == [
        ["HPH 9", "–", "computing"],
        ["HPH 2", "tangent", "fit"],
        ["HPH 3", "linear", "fit"],
        ["HPH 3", "tangent", "fit"],
    ]
    assert table["mPAP [mmHg]"].to_numpy() == pytest.approx([99.5, pressure(results[4]), *[pressure(results[5])] * 2])
    assert table["reason"][1] == NO_START


def test_a_group_that_is_lost_as_a_whole_is_counted_in_the_methods(results, tmp_path):
    write_report(results[:2], tmp_path / "report", lost=[LOST], pdf=False)
    supplement = (tmp_path / "report" / "supplement.html").read_text("utf-8")
    assert "of 2 CTL and 0 of 1 HPH animals were analyzed" in supplement


def test_failures_are_the_same_after_they_were_stored():
    lost = (LOST, Failure("b", "CTL", "tangent", Stage.POSTERIOR, "a < b & c"))
    assert from_plain(json.loads(json.dumps(as_plain(lost)))) == lost
    with pytest.raises(ValueError, match="elsewhere"):
        from_plain([{**as_plain([LOST])[0], "stage": "elsewhere"}])
