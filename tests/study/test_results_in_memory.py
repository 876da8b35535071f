"""Results of a study that were read already: what they say of themselves, their table, and a plan made of them."""

from pathlib import Path

import numpy as np
import pytest

from made_cohort import crossed_cohort
from vasowave.animal.failure import Failure, Stage
from vasowave.cohort import Design, Variable, gathered
from vasowave.cohort.planning import spreads_of, with_occasions
from vasowave.datasets import published_table
from vasowave.errors import InputError
from vasowave.study import planning
from vasowave.study.results import Results, StoredAnimal
from vasowave.study.settings import StudyFile

LOST = Failure("HPH 9", "HPH", "", Stage.COMPUTING, "no beats", 61.2)


class Read(Results):
    """Results of which every animal was read already."""

    def __getitem__(self, animal):
        return self._light[animal]


def results_of(results, groups, variables=(), design=None):
    animals = tuple(StoredAnimal(one.name, one.group, f"{one.name}.nc", "") for one in results)
    settings = StudyFile(title="Mice", groups=list(groups), **({"design": design} if design else {}))
    made = Read(Path("nowhere"), animals, (LOST,), settings, {"vasowave": "1", "numpy": "2"}, variables)
    made._light.update((one.name, one) for one in results)
    return made


@pytest.fixture(scope="module")
def made(cohort_results):
    return results_of(cohort_results, ["CTL", "HPH"], (Variable.of("sex", {"CTL 1": "f", "HPH 1": "m"}),))


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
    assert "vasowave 1, numpy 2" in page
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
    empty = results_of([], ["CTL"]).table()
    assert (len(empty), empty.columns.tolist()) == (0, table.columns.tolist()[:-1])


def test_a_group_is_compared_with_another_one(made):
    with pytest.raises(InputError, match="'CTL' is the reference itself; compare one of the others with it: HPH"):
        made.compare("CTL")
    with pytest.raises(InputError, match="'HPX'"):
        made.compare("HPX")


@pytest.fixture
def planned(monkeypatch):
    """Return what a plan is made of."""
    found = []
    monkeypatch.setattr(planning, "plan_of", lambda *given: found.append(given))
    return found


def test_a_plan_is_made_of_the_first_recording_of_each_subject_and_knows_how_occasions_differ(planned):
    cohort = crossed_cohort(2, ())
    names = [one.name for one in cohort.results]
    variables = [Variable.of("mouse", {name: name.rpartition(" ")[0] for name in names}),
                 Variable.of("time", {name: name.rpartition(" ")[2] for name in names})]  # fmt: skip
    design = Design(subject="mouse", occasion="time")
    study = results_of(cohort.results, cohort.groups, tuple(variables), design)
    planning.plan(study, effect=1.4)
    ((spreads, correlation, title, asked),) = planned
    assert (title, asked.effect) == ("Mice", 1.4)
    firsts = [one for one in cohort.results if one.name.endswith("vor")]
    alone = gathered(firsts, "Kontrolle Süd", variables=variables, design=design)
    expected, together = spreads_of(alone, study.settings.report)
    everything = gathered(cohort.results, "Kontrolle Süd", variables=variables, design=design)
    expected = with_occasions(expected, everything, study.settings.report)
    assert [one.quantity for one in spreads] == [one.quantity for one in expected]
    for one, other in zip(spreads, expected, strict=True):
        found, wanted = ((*each.between, each.error, each.within) for each in (one, other))
        assert found == pytest.approx(wanted)
    assert correlation == pytest.approx(together)


def test_a_plan_without_a_study_is_made_of_the_published_spreads(planned):
    """The SD of a logarithm whose values have a mean and an SD is √ln(1 + (SD/mean)²)."""
    planning.plan()
    ((spreads, correlation, title, _),) = planned
    assert title == "the published mice"
    assert np.array_equal(correlation, np.eye(5))
    by_name = {one.quantity: one.between for one in spreads}
    assert list(by_name) == ["mPAP", "CO", "stiffness", "R_T", "a"]
    rows = published_table("hemodynamics").set_index("quantity")
    for place, group in enumerate(("CTL", "HPH")):
        share = float(rows.loc["CO", f"{group} SD"]) / float(rows.loc["CO", f"{group} mean"])
        assert by_name["CO"][place] == pytest.approx(np.sqrt(np.log(1 + share**2)))
        table = published_table("optimized_linear").query("group == @group")
        logs = np.log(table["R_T [mmHg s/ml]"].to_numpy(float))
        assert by_name["R_T"][place] == pytest.approx(np.sqrt(((logs - logs.mean()) ** 2).sum() / (len(logs) - 1)))
