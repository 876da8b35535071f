"""Effects pooled over animals and one p for a whole family: against brute force, published numbers and counts."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from made_cohort import changed, made_results
from relabelings import family_p
from vasowave.base import InputError
from vasowave.pulse.examples import published_table
from vasowave.study.cohort import (
    ContrastEstimate,
    ContrastLabel,
    Declaration,
    DesignEstimate,
    Family,
    Omission,
    Untested,
    as_table,
    contrasts,
    gathered,
    pooled_mean,
    pooled_ratio,
    primary_comparison,
    smallest_p,
)
from vasowave.study.report import caller
from vasowave.study.report.answer import group_answer

LABELS = np.arange(7) >= 4


def brute_force(values, labels):
    """Step-down max-|t|, one relabeling and one SciPy test after the other."""

    def t(chosen):
        return np.abs(stats.ttest_ind(values[list(chosen)], np.delete(values, list(chosen), axis=0)).statistic)

    observed = t(np.flatnonzero(labels))
    every = np.array([t(chosen) for chosen in combinations(range(len(labels)), int(labels.sum()))])
    p = {}
    order = np.argsort(-observed)
    for place, quantity in enumerate(order):
        share = np.mean(every[:, order[place:]].max(axis=1) >= observed[quantity] - 1e-9)
        p[quantity] = max([share, *p.values()])
    return np.array([p[quantity] for quantity in range(values.shape[1])])


def test_the_family_p_is_that_of_all_relabelings_one_by_one():
    values = np.random.default_rng(4).standard_normal((7, 3)) + np.outer(LABELS, [2.5, 0.0, 1.2])
    np.testing.assert_allclose(family_p(values, LABELS), brute_force(values, LABELS))


def test_the_pooled_mean_is_the_published_one_of_the_vaccine_trials():
    """BCG trials (Colditz 1994); metafor 4.4: tau² 0.3132, mean -0.7145, se by Knapp and Hartung 0.1807."""
    effects = [-0.8893, -1.5854, -1.3481, -1.4416, -0.2175, -0.7861, -1.6209, 0.0120, -0.4694, -1.3713, -0.3394, 0.4459,
               -0.0173]  # fmt: skip
    variances = [0.3256, 0.1946, 0.4154, 0.0200, 0.0512, 0.0069, 0.2230, 0.0040, 0.0564, 0.0730, 0.0124, 0.5325, 0.0714]
    found = pooled_mean(np.array(effects), np.sqrt(variances))
    assert found.between**2 == pytest.approx(0.3132, abs=1e-4)
    assert (found.value, found.error) == pytest.approx((-0.7145, 0.1807), abs=1e-4)
    assert found.freedom == 12


def test_animals_known_alike_pool_to_their_mean_and_what_is_left_of_their_variance():
    y = np.array([1.0, 2.0, 4.0, 7.0])
    found = pooled_mean(y, np.full(4, 0.8))
    assert found.value == pytest.approx(y.mean())
    assert found.between**2 == pytest.approx(y.var(ddof=1) - 0.64, rel=1e-4)
    assert found.error == pytest.approx(y.std(ddof=1) / 2, rel=1e-6)
    alike = pooled_mean(np.array([1.0, 1.1, 0.9]), np.full(3, 0.8))  # scatter less than their errors: those decide
    assert alike.between < 0.01
    assert alike.error == pytest.approx(0.8 / np.sqrt(3), rel=1e-3)


def test_without_errors_the_ratio_is_welchs():
    table = published_table("optimized_linear")
    x, y = (np.log(table.loc[table.group == group, "beta [mmHg]"].to_numpy()) for group in ("CTL", "HPH"))
    welch = contrasts(table, ["beta [mmHg]"], "CTL", "HPH").iloc[0]
    found = pooled_ratio((x, np.zeros(7)), (y, np.zeros(5)))
    assert found[:3] == pytest.approx(welch[["ratio", "ratio low", "ratio high"]].tolist())
    with pytest.raises(InputError, match="two animals"):
        pooled_ratio((x[:1], np.zeros(1)), (y, np.zeros(5)))


def test_the_truth_lies_in_the_pooled_interval_as_often_as_it_says_and_welchs_is_wider():
    """Kinds unlike those on which the method was chosen (docs/comparisons.md): errors known from few degrees."""
    rng, inside, widths = np.random.default_rng(11), 0, []
    for _ in range(300):
        groups = [_estimates(rng, n, mean) for n, mean in ((7, 0.0), (5, 0.9))]
        ratio = pooled_ratio(*groups)
        plain = pooled_ratio(*((logs, np.zeros(len(logs))) for logs, _ in groups))
        inside += ratio.low <= np.exp(0.9) <= ratio.high
        widths.append(np.log(ratio.high / ratio.low) / np.log(plain.high / plain.low))
    # Binomial standard error of 95 % in 300: 1.3 %; three of them.
    assert 0.91 < inside / 300 < 0.99
    assert np.median(widths) < 1


def _estimates(rng, n, mean):
    """Animals that differ by 25 %, known to 10 … 100 %, their errors estimated with six degrees of freedom."""
    error = 0.3 * np.exp(0.6 * rng.standard_normal(n))
    said = error * np.sqrt(rng.chisquare(6, n) / 6)
    return mean + 0.25 * rng.standard_normal(n) + error * rng.standard_normal(n), said


@pytest.fixture(scope="module")
def cohort():
    return gathered(made_results({"CTL": 5, "HPH": 4}))


def test_the_primary_rows_carry_the_effects_of_the_declared_law_and_the_others_stand_beside(cohort):
    found = primary_comparison(cohort)
    assert found.law == "linear"
    assert set(found.table()["source"]) == {"measured", "linear"}
    assert {estimate.source for estimate in found.others} == {"tangent"}
    row = found.table().set_index("quantity").loc["mPAP"]
    logs = {group: np.log([float(result.measured.quantities["mPAP"]) for result in results])
            for group, results in cohort.groups.items()}  # fmt: skip
    assert np.log(row["ratio"]) == pytest.approx(logs["HPH"].mean() - logs["CTL"].mean())
    left = {name: np.delete(logs["HPH"], int(name[-1]) - 1) for name in ("HPH 1", "HPH 2", "HPH 3", "HPH 4")}
    if row["without"] in left:
        assert np.log(row["ratio without"]) == pytest.approx(left[row["without"]].mean() - logs["CTL"].mean())
    assert primary_comparison(cohort, Family("tangent")).law == "tangent"


def test_error_and_degrees_of_freedom_of_a_measured_ratio_are_welchs(cohort):
    rows = primary_comparison(cohort).table().set_index("quantity")
    logs = {group: np.log([float(result.measured.quantities["mPAP"]) for result in results])
            for group, results in cohort.groups.items()}  # fmt: skip
    welch = stats.ttest_ind(logs["HPH"], logs["CTL"], equal_var=False)
    row = rows.loc["mPAP"]
    assert np.log(row["ratio"]) / row["standard error"] == pytest.approx(welch.statistic)
    assert row["df"] == pytest.approx(welch.df)


def test_the_means_of_the_groups_stand_in_the_unit_of_the_table_and_make_the_ratio(cohort):
    rows = primary_comparison(cohort).table()
    np.testing.assert_allclose(rows["mean other"] / rows["mean reference"], rows["ratio"])
    row = rows.set_index("quantity").loc["mPAP"]
    values = {group: [float(result.measured.quantities["mPAP"]) for result in results]
              for group, results in cohort.groups.items()}  # fmt: skip
    assert row["mean reference"] == pytest.approx(stats.gmean(values["CTL"]))
    assert row["mean other"] == pytest.approx(stats.gmean(values["HPH"]))
    stored = rows["quantity"].str.removeprefix("measured_")
    assert set(stored + " [" + rows["unit"] + "]") <= set(cohort.table.columns)


def test_an_interval_excludes_one_exactly_where_p_is_below_its_level(cohort):
    rows = primary_comparison(cohort, Family(quantities=("mPAP", "CO", "PVR", "HR"))).table()
    outside = (rows["low"] > 1) | (rows["high"] < 1)
    assert outside.tolist() == (rows["p"] < 0.05).tolist()
    assert 0 < outside.sum() < len(rows)


def test_with_one_image_a_group_the_models_quantities_have_no_p_from_fits(cohort):
    rows = primary_comparison(cohort).table()
    modeled = rows["source"] == "linear"
    assert modeled.any()
    assert set(rows["untested"][modeled]) == {Untested.ONE_IMAGE}
    assert rows["p"][modeled].isna().all()
    assert set(rows["untested"][~modeled]) == {""}
    assert rows["p"][~modeled].notna().all()
    own = [
        replace(result, network=replace(result.network, length=result.network.length * (1 + 0.01 * number)))
        for number, result in enumerate(cohort.results)
    ]
    rows = primary_comparison(gathered(own)).table()
    assert rows["p"].notna().all()
    assert set(rows["untested"]) == {""}


def test_rows_without_a_test_make_the_tested_no_wider_and_hold_by_themselves(cohort):
    tested = ("mPAP", "CO", "PVR")
    alone = primary_comparison(cohort, Family(quantities=tested)).table()
    found = primary_comparison(cohort, Family(quantities=(*tested, "stiffness", "C_p", "I_R"))).table()
    pd.testing.assert_frame_equal(found[found["quantity"].isin(tested)].reset_index(drop=True), alone)
    row = found.set_index("quantity").loc["I_R"]
    logs = {group: np.log([float(result.laws["linear"].quantities["I_R"]) for result in results])
            for group, results in cohort.groups.items()}  # fmt: skip
    interval = stats.ttest_ind(logs["HPH"], logs["CTL"], equal_var=False).confidence_interval()
    assert np.isnan(row["p"])
    np.testing.assert_allclose(np.log([row["low"], row["high"]]), [interval.low, interval.high])
    none = primary_comparison(cohort, Family(quantities=("stiffness",)))
    assert none.assurance is None
    assert len(none.table()) == 1


def test_what_the_recording_alone_tells_stands_beside_the_models_with_a_p(cohort):
    names = ("measured_Z_c", "measured_C_T", "measured_tau", "measured_I_R", "pPAP_over_SV", "I_R", "tau")
    results = [changed(one, "measured/quantities", tau=0.2 + 0.01 * place, I_R=0.3 - 0.02 * place)
               for place, one in enumerate(cohort.results)]  # fmt: skip
    cohort = gathered(results)
    found = primary_comparison(cohort, Family(quantities=names))
    rows = found.table().set_index("quantity")
    assert rows["source"].tolist() == [*["measured"] * 5, "linear", "linear"]
    assert rows["p"].notna().tolist() == [*[True] * 5, False, False]

    def pulse_over_stroke(result):  # the stroke volume is the integral of the flow over a beat
        pressure, flow = (result.recording[one].values for one in ("pressure", "flow"))
        return np.ptp(pressure) / (flow.mean() * result.period)

    values = {f"measured_{name}": lambda one, name=name: float(one.measured.quantities[name])
              for name in ("Z_c", "C_T", "tau", "I_R")}  # fmt: skip
    for name, value in (values | {"pPAP_over_SV": pulse_over_stroke}).items():
        means = {group: stats.gmean([value(one) for one in results]) for group, results in cohort.groups.items()}
        assert rows["ratio"][name] == pytest.approx(means["HPH"] / means["CTL"], rel=1e-6)
    assert {estimate.quantity for estimate in found.others} == {"I_R", "tau"}


def test_an_effect_by_itself_has_the_p_of_a_study_that_asks_for_nothing_else():
    """In the family of six the output is not shown; as the only question, by the same bootstrap, it is."""
    results = [changed(result, "measured/quantities", CO=float(result.measured.quantities["CO"]) * factor)
               for result in made_results({"CTL": 5, "HPH": 5}, walls=())
               for factor in [1.16 if result.group == "HPH" else 1.0]]  # fmt: skip
    cohort = gathered(results)
    found = primary_comparison(cohort)
    [(effect, p)] = found.shown_alone
    assert (effect.quantity, effect.p > 0.05, found.stated) == ("CO", True, False)
    values = [[float(result.measured.quantities["CO"]) for result in group] for group in cohort.groups.values()]
    assert p == pytest.approx(stats.ttest_ind(*map(np.log, values), equal_var=False).pvalue)
    named = primary_comparison(cohort, Family(quantities=("CO",)))
    assert named.stated
    assert named.effects[0].p == pytest.approx(p, abs=0.01)
    said, said_of_named = (str(group_answer(one, caller(cohort))) for one in (found, replace(found, stated=True)))
    assert "Tested alone, it would have been shown: cardiac output CO (p = 0.019)" in said
    assert "Tested alone" not in said_of_named


def test_a_family_says_how_far_it_can_be_relied_on(cohort):
    found = primary_comparison(cohort)
    assert found.assurance.smallest == 4
    # Nine thousand cohorts of normal logarithms, by another count: docs/comparisons.md has 0.03 to 0.06 for such sizes.
    assert 0.03 < found.assurance.rate < 0.07
    assert 0.95 < found.assurance.alone < 1
    logs = [np.log([float(one.measured.quantities["CO"]) for one in of]) for of in cohort.groups.values()]
    ratio = np.std(logs[0], ddof=1) / np.std(logs[1], ddof=1)
    assert found.assurance.spread_ratio >= max(ratio, 1 / ratio) * (1 - 1e-9)


def test_a_family_that_nothing_has_is_refused_with_the_nearest_name(cohort):
    with pytest.raises(InputError, match=r"'stifness' \(did you mean 'stiffness'\?\)"):
        primary_comparison(cohort, Family(quantities=("stifness",)))
    with pytest.raises(InputError, match="primary law 'power'"):
        primary_comparison(cohort, Family("power"))


def test_more_pairs_of_groups_cost_no_more_than_their_number():
    three = gathered(made_results({"CTL": 3, "early": 3, "late": 3}, walls=()))
    two = gathered([result for result in three.results if result.group != "late"])
    both, one = primary_comparison(three).table(), primary_comparison(two).table()
    early = both[both["other"] == "early"]
    assert np.all(early["p"].to_numpy() > one["p"].to_numpy() - 0.02)  # four standard errors of a share of draws
    assert np.all(early["p"].to_numpy() < 2 * one["p"].to_numpy() + 0.04)
    assert set(early["smallest p"]) == {2 * smallest_p((3, 3))}


def test_groups_of_one_and_quantities_that_are_negative_or_do_not_scatter_are_named_not_compared():
    found = primary_comparison(gathered(made_results({"CTL": 3, "HPH": 1}, walls=())))
    assert found.effects == ()
    assert Omission("a group has fewer than two animals with it", "mPAP", "HPH") in found.left_out
    results = made_results({"CTL": 3, "HPH": 3}, walls=())
    equal = [changed(one, "measured/quantities", mPAP=15.0, CO=-1.0) for one in results]
    found = primary_comparison(gathered(equal), Family(quantities=("mPAP", "CO", "PVR")))
    assert found.table()["quantity"].tolist() == ["PVR"]
    reasons = {omission.describe(): omission.reason for omission in found.left_out}
    assert reasons["mPAP (HPH)"].startswith("the values hardly vary within a group")
    assert reasons["CO (HPH)"] == "a value is not positive; a ratio needs positive values"


def test_a_later_declaration_tells_what_it_changed_and_in_which_animals():
    first = Declaration("1", False, {"law": "linear", "animals": {"a": {"group": "CTL"}, "b": {"group": "HPH"}}})
    later = Declaration("2", True, {"law": "tangent", "animals": {"a": {"group": "HPH"}, "c": {}}, "family": 1})
    assert later.changes(first) == ["law", "animals"]
    assert later.first_said(first) == ["family"]
    assert later.rows(first) == (("c",), ("b",), (("a", "group", "CTL", "HPH"),))
    more = Declaration("3", False, {"animals": {"a": {"group": "CTL", "sex": "f"}, "b": {"group": "HPH"}}})
    assert more.changes(first) == []


def test_a_table_of_estimates_has_the_columns_of_their_class_and_none_without_any():
    label = ContrastLabel("HPH", "CTL", "interaction", "after/before", "in f")
    values = {"contrast": label, "quantity": "mPAP", "source": "linear", "ratio": 2.0, "low": 1.5, "high": 2.7}
    assert str(label) == "after/before: HPH / CTL in f"
    assert as_table([ContrastEstimate(**values)]).to_dict("records") == [
        {"reference": "CTL", "other": "HPH", "quantity": "mPAP", "source": "linear", "ratio": 2.0, "low": 1.5,
         "high": 2.7}
    ]  # fmt: skip
    of_design = as_table([DesignEstimate(**values)])
    assert of_design.columns.tolist() == list(DesignEstimate.columns)
    assert of_design.loc[0, ["change", "within"]].tolist() == ["after/before", "in f"]
    assert as_table(()).empty
