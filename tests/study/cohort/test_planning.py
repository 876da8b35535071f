"""How many animals a study needs: against theory, and against studies that are drawn and judged as real ones."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import planning
from approval import PAPER, approve, figure, page
from made_cohort import made_results
from vasowave.base import InputError
from vasowave.study.cohort import (
    GROUP_SIZES,
    ComparedQuantity,
    Design,
    Family,
    Plan,
    Planning,
    Spread,
    Structure,
    Variable,
    changes_of,
    effects_of_repeated,
    fit_mixed,
    gathered,
    laid_out,
    plan_of,
    simultaneous,
    spreads_of,
    with_occasions,
)
from vasowave.study.figures import svg
from vasowave.study.report import plan_texts, write_plan

ALIKE = 0.6 + 0.4 * np.eye(3)
SPREADS = [Spread("mPAP", (0.2, 0.3), 0.1), Spread("a", (0.5, 0.5), 0.3), Spread("R_T", (0.3, 0.2))]


@pytest.fixture(scope="module")
def planned():
    return plan_of(SPREADS, ALIKE, "theory", Planning(effect=1.6))


@pytest.fixture(scope="module")
def planned_by_bonferroni():
    """Return the plan of a family whose critical p are not drawn from studies, which takes seconds."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(
            "vasowave.study.cohort.planning._criticals", lambda *arguments: np.full((len(GROUP_SIZES), 1), 0.05 / 3)
        )
        return plan_of(SPREADS, ALIKE, "theory", Planning(effect=1.6))


def test_one_quantity_alone_has_the_power_of_the_t_test():
    found = plan_of([Spread("mPAP", (0.3, 0.3))], np.eye(1), "theory", Planning(effect=1.5))
    for size in (5, 10, 20):
        away = np.log(1.5) / (0.3 * np.sqrt(2 / size))
        t = stats.t.ppf(0.975, 2 * size - 2)
        expected = stats.nct.sf(t, 2 * size - 2, away) + stats.nct.cdf(-t, 2 * size - 2, away)
        # Welch's test has a little less; four standard errors of 4 000 draws are 0.03.
        assert found.powers.loc[size, "mPAP"] == pytest.approx(expected, abs=0.035)
    enough = found.needed.loc["mPAP", "as it is"]
    assert enough == np.ceil(np.interp(0.8, found.powers["mPAP"], found.powers.index))


@pytest.mark.parametrize("alike", [0.0, 0.9])
def test_pairs_of_one_quantity_have_the_power_of_the_paired_t_test(alike):
    """Pairs that hardly resemble each other have more: a variance of subjects is none where it would be negative."""
    found = plan_of([Spread("mPAP", (0.3, 0.2))], np.eye(1), "theory", Planning(effect=1.3, pairs=alike))
    change = np.sqrt(0.3**2 + 0.2**2 - 2 * alike * 0.3 * 0.2)
    for pairs in (5, 10, 20):
        away, t = np.log(1.3) / (change / np.sqrt(pairs)), stats.t.ppf(0.975, pairs - 1)
        expected = stats.nct.sf(t, pairs - 1, away) + stats.nct.cdf(-t, pairs - 1, away)
        power = found.powers.loc[pairs, "mPAP"]
        if alike:
            assert power == pytest.approx(expected, abs=0.045)  # four standard errors of 2 000 draws
        else:
            assert expected - 0.045 < power < expected + 0.12


@pytest.mark.weekly
def test_what_animals_keep_between_occasions_saves_pairs_and_images_that_they_share_cost_none():
    shared = [one._replace(shared=0.3) for one in SPREADS]
    little, much = (
        plan_of(shared, ALIKE, "theory", Planning(effect=1.5, pairs=r)).needed["as it is"] for r in (0, 0.8)
    )
    own = plan_of(SPREADS, ALIKE, "theory", Planning(effect=1.5, pairs=0.8)).needed["as it is"]
    assert (much < little).all()
    assert list(much) == list(own)


@pytest.mark.parametrize("kind", ["mice", "litters"])
def test_pairs_that_are_judged_by_thousands_are_judged_as_the_model_of_their_design_judges_one(kind):
    rng, size = np.random.default_rng(4), 7
    what = planning.layout(size, kind)
    (contrast,) = [(one.second - one.first) @ what.means for one in what.contrasts]
    common, own = rng.normal(size=(20, 1, size)), rng.normal(size=(20, 2, size))
    for spread, error in ((0.3, 0.0), (0.3, 0.3), (0.05, 0.4)):  # the last: components at their limits
        values = spread * (common + own) + error * rng.normal(size=own.shape)
        found = changes_of(values, error, kind == "litters")
        known = error**2 * np.eye(2 * size)
        for study, y in enumerate(values.reshape(20, -1)):
            one = fit_mixed(y, Structure(what.fixed, list(what.random.values()), known)).effect(contrast)
            assert found.value[study] == pytest.approx(one.value)
            assert (found.error[study], found.freedom[study]) == pytest.approx((one.error, one.freedom), rel=1e-4)


def test_repeated_recordings_that_are_judged_by_thousands_are_judged_as_the_model_of_their_design_judges_one():
    rng, size = np.random.default_rng(5), 6
    names = [str(row) for row in range(4 * size)]
    members = {name: "AB"[int(name) // (2 * size)] for name in names}
    mouse = Variable.from_cells("mouse", {name: f"M{int(name) // 2}" for name in names})
    what = laid_out(Design(subject="mouse"), {"mouse": mouse}, members, ["A", "B"])
    (contrast,) = [(one.second - one.first) @ what.means for one in what.contrasts]
    own, each = rng.normal(size=(20, 2, size, 1)), rng.normal(size=(20, 2, size, 2))
    for between, within, error in ((0.3, 0.2, 0.0), (0.2, 0.2, 0.2), (0.05, 0.05, 0.4)):  # the last: at the limits
        values = between * own + np.hypot(within, error) * each
        found = effects_of_repeated(values, error)
        known = error**2 * np.eye(4 * size)
        for study, y in enumerate(values.reshape(20, -1)):
            one = fit_mixed(y, Structure(what.fixed, list(what.random.values()), known)).effect(contrast)
            assert found.value[study] == pytest.approx(one.value)
            assert (found.error[study], found.freedom[study]) == pytest.approx((one.error, one.freedom), rel=1e-3)


@pytest.mark.parametrize(("kind", "occasions"), [("mice", 1), ("litters", 1), ("mice", 2)])
@pytest.mark.weekly
def test_the_promised_power_of_pairs_is_found_again_by_the_model_of_the_design(kind, occasions):
    """As `benchmarks/planning.py`, by fewer studies; recordings of one occasion are averaged."""
    asked = Planning(effect=1.5, pairs=planning.ALIKE, occasions=occasions, littermates=kind == "litters")
    promised = plan_of(planning.SPREADS, planning.CORRELATION, "theory", asked).powers.loc[10]
    found = planning.found_in_pairs(10, 1.5, 150, 499, kind, occasions)
    # Three binomial standard errors of a share in 150 studies.
    np.testing.assert_allclose(found, promised, atol=3 * 0.5 / np.sqrt(150))


@pytest.mark.weekly
def test_the_promised_power_of_two_occasions_is_found_again_by_the_model_of_repeated_recordings():
    asked = Planning(effect=1.7, occasions=2)
    promised = plan_of(planning.TWICE, planning.CORRELATION, "theory", asked).powers.loc[7]
    found = planning.found_twice(7, 1.7, 150, 499)
    np.testing.assert_allclose(found, promised, atol=3 * 0.5 / np.sqrt(150))  # as above


@pytest.mark.weekly
def test_a_second_occasion_saves_animals_where_animals_differ_from_day_to_day_and_none_where_that_is_not_known():
    much = [one._replace(between=(0.1, 0.1), within=0.4) for one in SPREADS]
    needed = plan_of(much, ALIKE, "theory", Planning(effect=1.5)).needed
    assert (needed["a second occasion"] < needed["as it is"] - 2).all()
    known = plan_of([one._replace(error=0.0) for one in SPREADS], ALIKE, "theory", Planning(effect=1.5)).needed
    assert known["a second occasion"].tolist() == known["as it is"].tolist()


def test_what_an_animal_differs_between_occasions_is_taken_from_what_animals_differ():
    """Six mice of three recordings each: by mean squares, balanced, the restricted likelihood's answer."""
    rng, results = np.random.default_rng(9), made_results({"CTL": 9, "HPH": 9}, walls=())
    mouse = {result.name: f"{result.group}{place % 3}" for place, result in enumerate(results)}
    level = {name: 0.3 * rng.standard_normal() for name in set(mouse.values())}
    for result in results:
        value = float(np.exp(level[mouse[result.name]] + 0.1 * rng.standard_normal()))
        result.measured.quantities["mPAP"].values[...] = 15 * value
    columns = [Variable.from_cells("mouse", mouse)]
    cohort = gathered(results, variables=columns, design=Design(subject="mouse"))
    logs = {name: [] for name in level}
    for result in results:
        logs[mouse[result.name]].append(np.log(float(result.measured.quantities["mPAP"])))
    expected = np.sqrt(np.mean([np.var(own, ddof=1) for own in logs.values()]))
    one = Spread("mPAP", (0.35, 0.35))
    (found,) = with_occasions([one], cohort)
    assert found.within == pytest.approx(expected, rel=1e-3)
    assert np.hypot(found.between[0], found.within) == pytest.approx(0.35)
    (small,) = with_occasions([Spread("mPAP", (0.5 * expected, 0.35))], cohort)
    assert np.hypot(*np.array([small.between, [small.within] * 2])) == pytest.approx([0.5 * expected, 0.35])


@pytest.mark.validation
def test_the_promised_power_is_found_again_in_simulated_studies(planned):
    """As `benchmarks/planning.py`, by fewer studies: the page's p, 8 + 8 animals."""
    promised = planned.powers.loc[8]
    rng, root, shown = np.random.default_rng(3), np.linalg.cholesky(ALIKE), np.zeros(3)
    other = np.arange(16) >= 8
    for number in range(150):
        z = rng.standard_normal((16, 3)) @ root.T
        for moved in range(3):
            rows = [
                ComparedQuantity(place, np.arange(16), other,
                    z[:, place] * np.hypot(np.where(other, one.between[1], one.between[0]), one.error)
                    + (np.log(1.6) * other if place == moved else 0.0), np.full(16, one.error), 0.0)
                for place, one in enumerate(SPREADS)
            ]  # fmt: skip
            shown[moved] += simultaneous(rows, 199, number).p[moved] < 0.05
    # Three binomial standard errors of a share in 150 studies.
    np.testing.assert_allclose(shown / 150, promised, atol=3 * 0.5 / np.sqrt(150))


@pytest.mark.validation
def test_what_lessens_errors_saves_animals_only_where_errors_are_what_costs(planned):
    needed = planned.needed
    assert needed.loc["a", "errors halved"] < needed.loc["a", "as it is"]
    assert needed.loc["R_T", "errors halved"] == pytest.approx(needed.loc["R_T", "as it is"], abs=1)
    with pytest.raises(InputError, match="no effect"):
        Planning(effect=1.0)
    with pytest.raises(InputError, match="how far their true values are correlated"):
        Planning(littermates=True)


@pytest.mark.parametrize(("kind", "asked"), [("groups", {}), ("pairs", {"pairs": 0.6}),
                                           ("littermates", {"pairs": 0.6, "littermates": True})])  # fmt: skip
def test_approved_the_page_of_a_plan(kind, asked, planned_by_bonferroni, tmp_path):
    plan = replace(planned_by_bonferroni, settings=replace(planned_by_bonferroni.settings, **asked))
    words = page(write_plan(plan, tmp_path / "plan.html"))
    approve(f"plan, {kind}", [*plan_texts(plan), *words, *figure("power", svg(plan.figure()))], PAPER, 0.01)


def test_animals_are_as_alike_on_two_occasions_as_they_differ_from_each_other():
    """The correlation of two values of one animal is the share of the variance that lies between animals."""
    one = Spread("mPAP", (0.3, 0.4), within=0.25)
    assert one.alike == pytest.approx((0.09 + 0.16) / 2 / ((0.09 + 0.16) / 2 + 0.0625))
    assert (one.on_one_occasion(0), one.on_one_occasion(1)) == pytest.approx((0.3905125, 0.4716991))
    assert Spread("mPAP", (0.3, 0.4)).alike == 1.0
    assert Spread("mPAP", (0.0, 0.0), within=0.2).alike == 0.0


def test_spreads_of_a_study_are_those_of_its_animals_and_a_study_of_one_group_has_none():
    """Without errors the spread of a group is the SD of its logarithms; residuals correlate as these do, shrunk."""
    results = made_results({"CTL": 9, "HPH": 8}, walls=())
    cohort = gathered(results, reference="CTL")
    family = Family(quantities=("mPAP", "CO"))
    found, correlation = spreads_of(cohort, family)
    assert [one.quantity for one in found] == ["mPAP", "CO"]
    centered = []
    for one in found:
        values = [[float(each.measured.quantities[one.quantity]) for each in results if each.group == own]
                  for own in ("CTL", "HPH")]  # fmt: skip
        logs = [np.log(own) for own in values]
        assert one.between == pytest.approx([own.std(ddof=1) for own in logs], rel=1e-3)
        assert (one.error, one.shared, one.within) == (0, 0, 0)
        centered.append(np.concatenate([(own - own.mean()) / own.std(ddof=1) for own in logs]))
    whole = np.corrcoef(centered)[0, 1]
    shrunk = whole * (1 - (1 - whole**2) ** 2 / (17 - 2 - 1) / whole**2)  # by the share of its variance that is error
    assert correlation[0, 1] == pytest.approx(shrunk, rel=1e-3)
    assert np.diag(correlation) == pytest.approx([1, 1])
    with pytest.raises(InputError, match="no two groups that can be compared"):
        spreads_of(gathered(results[:9]), family)


@pytest.mark.parametrize(("needed", "words"), [
    ([7.0, np.nan], "To show a ratio of 1.5 with a power of 0.80, each of two groups needs: 7 for "),
    ([np.nan, np.nan], "No quantity shows a ratio of 1.5 with 60 animals in each group."),
])  # fmt: skip
def test_a_quantity_that_no_tried_size_shows_is_told_to_need_more(needed, words):
    powers = pd.DataFrame({"R_T": [0.5, 0.9], "own": [0.1, 0.2]}, pd.Index([3, 60], name="animals"))
    spreads = (Spread("R_T", (0.2, 0.35)), Spread("own", (0.1, 0.4)))
    frame = pd.DataFrame({"as it is": needed}, ["R_T", "own"])
    said = plan_texts(Plan(Planning(effect=1.5, power=0.8), spreads, "a pilot", powers, frame))
    assert said[0].startswith(words)
    assert ("More than 60 for own." in said) == (needed[0] == 7)
