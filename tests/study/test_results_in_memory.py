"""Stored results of a study: what they say of themselves, their table, comparisons and a plan made of them."""

import numpy as np
import pytest

from made_cohort import crossed_cohort
from vasowave.base import InputError
from vasowave.pulse.examples import published_table
from vasowave.study.animal import Failure, Stage, to_bytes
from vasowave.study.cohort import Design, Variable, gathered, spreads_of, with_occasions
from vasowave.study.folder import StudyFile
from vasowave.study.results import ResultStore, read_results, write_results
from vasowave.study.running import planning, published_spreads

LOST = Failure("HPH 9", "HPH", "", Stage.COMPUTING, "no beats", 61.2)


def stored(folder, results, groups, variables=(), design=None):
    """Store results as a run does, and read them again."""
    settings = StudyFile(title="Mice", groups=list(groups), **({"design": design} if design else {}))
    store = ResultStore(folder / "results")
    pieces = {(one.name, one.group): store.keep(f"{n}", to_bytes(one.to_datatree())) for n, one in enumerate(results)}
    write_results(folder / "results", pieces, [LOST], settings, variables)
    return read_results(folder)


@pytest.fixture(scope="module")
def made(cohort_results, tmp_path_factory):
    sexes = Variable.from_cells("sex", {"CTL 1": "f", "HPH 1": "m"})
    return stored(tmp_path_factory.mktemp("made"), cohort_results, ["CTL", "HPH"], (sexes,))


def test_a_study_says_who_is_in_it_what_failed_and_what_can_be_typed(made):
    lines = repr(made).splitlines()
    assert lines[:3] == [
        "Study: Mice",
        "  CTL        3  CTL 1, CTL 2 and CTL 3",
        "  HPH        3  HPH 1, HPH 2 and HPH 3",
    ]
    assert lines[3:5] == ["  wall laws  linear, tangent", f"  failed     HPH 9, {LOST}"]
    assert lines[5] == "  next       results['CTL 1'], results.table(), results.compare('HPH')"
    page = made._repr_html_()
    assert "3: HPH 1, HPH 2, HPH 3" in page
    assert f"HPH 9 failed, {LOST}" in page
    assert (len(made), [*made][::5], made.lost) == (6, ["CTL 1", "HPH 3"], (LOST,))


def test_the_table_has_all_numbers_of_all_animals_and_the_labs_own_columns(made, cohort_results):
    table = made.table()
    assert table.columns.tolist() == ["animal", "group", "law", "quantity", "value", "low", "high", "unit", "sex"]
    assert len(table) == sum(len(one.table()) for one in cohort_results)
    assert table.index.tolist() == list(range(len(table)))
    own = table[(table["animal"] == "HPH 1") & (table["law"] == "tangent")].set_index("quantity")["value"]
    assert own["R_T"] == float(cohort_results[3].laws["tangent"].quantities["R_T"])
    assert set(table.loc[table["animal"] == "HPH 1", "sex"]) == {"m"}
    assert table.loc[table["animal"] == "CTL 2", "sex"].isna().all()


def test_a_group_is_compared_with_another_one(made):
    with pytest.raises(InputError, match="'CTL' is the reference itself; compare one of the others with it: HPH"):
        made.compare("CTL")
    with pytest.raises(InputError, match="'HPX'"):
        made.compare("HPX")


def test_an_animal_that_is_not_there_is_told_with_what_is(made):
    with pytest.raises(KeyError, match=r"there is no result of 'TL 1' \(did you mean 'CTL 1'"):
        made["TL 1"]
    with pytest.raises(KeyError, match=r"no result of 'HPH 9': .*no beats; there are: CTL 1"):
        made["HPH 9"]
    assert "CTL 1" in made
    assert "HPH 9" not in made


def test_a_plan_is_made_of_the_first_recording_of_each_subject_and_knows_how_occasions_differ(tmp_path, monkeypatch):
    planned = []
    monkeypatch.setattr(planning, "plan_of", lambda *given: planned.append(given))  # cohorts of half a minute
    cohort = crossed_cohort(2, ())
    names = [one.name for one in cohort.results]
    variables = [
        Variable.from_cells("mouse", {name: name.rpartition(" ")[0] for name in names}),
        Variable.from_cells("time", {name: name.rpartition(" ")[2] for name in names}),
    ]
    design = Design(subject="mouse", occasion="time")
    study = stored(tmp_path, cohort.results, cohort.groups, tuple(variables), design)
    firsts = [one for one in cohort.results if one.name.endswith("vor")]
    alone, everything = (
        gathered(some, "Kontrolle Süd", variables=variables, design=design) for some in (firsts, cohort.results)
    )
    spreads, together = spreads_of(alone, study.settings.report)
    expected = with_occasions(spreads, everything, study.settings.report)
    planning.plan(study, effect=1.4)
    ((found, correlation, title, asked),) = planned
    assert (title, asked.effect) == ("Mice", 1.4)
    assert [one.quantity for one in found] == [one.quantity for one in expected]
    for one, other in zip(found, expected, strict=True):
        values, wanted = ((*each.between, each.error, each.within) for each in (one, other))
        assert values == pytest.approx(wanted)
    assert correlation == pytest.approx(together)


def test_a_plan_without_a_study_is_made_of_the_published_spreads():
    """The SD of a logarithm whose values have a mean and an SD is √ln(1 + (SD/mean)²)."""
    spreads, correlation = published_spreads()
    assert np.array_equal(correlation, np.eye(5))
    by_name = {one.quantity: one.between for one in spreads}
    assert list(by_name) == ["mPAP", "CO", "stiffness", "R_T", "a"]
    rows = published_table("hemodynamics").set_index("quantity")
    for place, group in enumerate(("CTL", "HPH")):
        share = float(rows.loc["CO", f"{group} SD"]) / float(rows.loc["CO", f"{group} mean"])
        assert by_name["CO"][place] == pytest.approx(np.sqrt(np.log(1 + share**2)))
        table = published_table("optimized_linear").query("group == @group")
        logs = np.log(table["R_T [mmHg s/ml]"].to_numpy(float))
        assert by_name["R_T"][place] == pytest.approx(np.std(logs, ddof=1))
