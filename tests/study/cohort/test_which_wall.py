"""What the page says of the wall law: by evidences, by residuals with the price of parameters apart, by an exponent."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy import stats

from made_cohort import changed, made_results, voting
from vasowave.base import CLEAR_EVIDENCE_RATIO, as_json
from vasowave.pulse.selection import UNDECIDED, aicc
from vasowave.pulse.solver import STRAINED
from vasowave.study.animal import PosteriorResult
from vasowave.study.cohort import (
    DECISIVE_AICC_DIFFERENCE,
    Design,
    Evidence,
    Variable,
    differences,
    evidences,
    exponent_of,
    gathered,
    pooled_censored,
    pooled_mean,
    stored,
)
from vasowave.study.report.answer import wall_answer

PRICE = aicc(0.0, 5, 512) - aicc(0.0, 4, 512)  # of the parameters that `voting` gives the second law


def compared(results, gaps):
    """Return a cohort in which AICc of the tangent wall is higher than that of the linear one by `gaps`."""
    scores = [{"ARMA": ({"linear": 100.0, "tangent": 100.0 + gap}, 0)} for gap in gaps]
    return gathered([voting(result, score, "ARMA") for result, score in zip(results, scores, strict=False)])


def with_evidence(result, trusted=1, **logs):
    """Return a result with stored evidences of its laws."""
    evidence = xr.Dataset({"log_evidence": ("wall", list(logs.values()))}, {"wall": np.array(list(logs), object)})
    none = xr.Dataset(coords={"quantity": np.array([], object)}, attrs={"trusted": trusted})
    drawn = {wall: replace(result.laws[wall], posterior=PosteriorResult(none, {})) for wall in logs}
    return replace(result, evidence=evidence, laws={**result.laws, **drawn})


def weighed(results, ratios):
    """Return a cohort whose recordings are `ratios` times as likely under the linear law as under the tangent one."""
    pairs = zip(results, ratios, strict=False)
    return gathered([with_evidence(result, linear=np.log(ratio), tangent=0.0) for result, ratio in pairs])


def exponents(values, low=0.8, high=1.25, at_bound=()):
    """Return a cohort with these exponents, known within factors, some at a bound of their search."""
    results = made_results({"CTL": len(values)}, walls=("linear", "power"))
    for place, (result, value) in enumerate(zip(results, values, strict=True)):
        data = result.laws["power"].stiffening
        attrs = {"interval_low": value * low, "interval_high": value * high, "at_bound": int(place in at_bound)}
        exponent = data["exponent"].copy(data=value).assign_attrs(data["exponent"].attrs | attrs)
        law = replace(result.laws["power"], stiffening=data.assign(exponent=exponent))
        results[place] = replace(result, laws={**result.laws, "power": law})
    return gathered(results)


def test_the_difference_of_aicc_is_the_price_of_parameters_and_what_the_residuals_say(cohort_results):
    gaps = [1.0, 4.0, 2.5]
    cohort = compared(cohort_results, gaps)
    (row,) = differences([stored(result.selection) for result in cohort.results], "linear").to_dict("records")
    test, own = (stats.ttest_1samp(values, 0).confidence_interval(0.95) for values in (gaps, np.array(gaps) - PRICE))
    assert (row["mean"], row["low"], row["high"], row["sum"]) == pytest.approx((2.5, test.low, test.high, 7.5))
    assert (row["price"], row["residuals"]) == pytest.approx((PRICE, 2.5 - PRICE))
    assert (row["residuals low"], row["residuals high"]) == pytest.approx((own.low, own.high))
    assert row["residuals SD"] == pytest.approx(np.std(gaps, ddof=1))
    said = wall_answer(cohort, "linear")[1]
    assert said.startswith("The residuals do not decide between the linear and the tangent wall (AICc of 3 animals).")
    assert "can look like curvature" in said


def test_a_price_alone_decides_nothing_however_many_animals_pay_it(cohort_results):
    scatter = np.array([-0.6, -0.2, 0.1, 0.2, 0.6])
    (row,) = differences(
        [stored(one.selection) for one in compared(cohort_results, PRICE + scatter).results], "linear"
    ).to_dict("records")
    assert row["low"] > 0  # as AICc by itself would say
    assert row["sum"] > DECISIVE_AICC_DIFFERENCE
    assert row["speaks for"] == ""


@pytest.mark.parametrize(("shift", "law"), [(12.0, "linear"), (-12.0, "tangent")])
def test_residuals_that_say_more_than_the_price_decide_for_either_law(cohort_results, shift, law):
    cohort = compared(cohort_results, shift + np.array([-1.0, 0.0, 1.0]))
    said = wall_answer(cohort, "linear")[1]
    other = {"linear": "tangent", "tangent": "linear"}[law]
    assert said.startswith(f"The residuals speak for the {law} wall against the {other} wall (AICc of 3 animals).")


def test_of_one_animal_the_margin_of_the_comparisons_own_verdicts_decides(cohort_results):
    assert DECISIVE_AICC_DIFFERENCE == UNDECIDED
    just, little = (wall_answer(compared(cohort_results, [PRICE + own]), "linear")[1] for own in (5.1, 4.9))
    assert just.startswith("The residuals speak for the linear wall")
    assert little.startswith("The residuals do not decide")
    assert "per animal" not in just


def test_evidences_answer_where_there_are_posteriors_and_aicc_is_not_asked(cohort_results):
    cohort = weighed(compared(cohort_results, [0.0, 0.0, 0.0]).results, [46.0, 15.0, 400.0])
    said = wall_answer(cohort, "linear")[1]
    assert said.startswith(
        "The posteriors speak for the linear wall against the tangent wall: by their evidences the recording is 46, 15 "
        "and 400 times as likely under the linear law as under the other; 20 times or more for the linear law in 2 of "
        "3 animals."
    )
    assert "AICc" not in said
    assert "a taper can still look like another wall" in said


def overstrained(result, wall):
    """Return a result whose fit with a wall strains a vessel beyond what an artery survives."""
    finding, law = STRAINED(percent=140.0, time=0.02).at(vessel="RPAaa"), result.laws[wall]
    law = replace(law, calibration=law.calibration.assign_attrs(findings=as_json([finding])))
    return replace(result, laws={**result.laws, wall: law})


@pytest.mark.parametrize(("strained", "verdict"), [
    (1, "The residuals speak for the tangent wall against the linear wall (AICc of 5 of 6 animals)."),
    (3, "The residuals speak for the tangent wall against the linear wall (AICc of 3 of 6 animals)."),
    (4, "Not decided between the linear and the tangent wall: a fit of 4 of 6 animals must not be used, for it strains "
        "a vessel beyond what an artery survives or no wall meets the data; the 2 that remain are too few."),
    (6, "Not decided between the linear and the tangent wall: a fit of 6 of 6 animals must not be used, for it strains "
        "a vessel beyond what an artery survives or no wall meets the data; too few remain."),
])  # fmt: skip
def test_walls_are_weighed_by_animals_whose_fits_of_both_may_be_used(cohort_results, strained, verdict):
    results = compared(cohort_results, -12 + np.arange(6.0)).results
    results = [overstrained(result, "tangent") if place < strained else result for place, result in enumerate(results)]
    assert wall_answer(gathered(results), "linear")[1].startswith(verdict)
    weighed_alike = [with_evidence(result, linear=0.0, tangent=np.log(400.0)) for result in results]
    said = wall_answer(gathered(weighed_alike), "linear")[1]
    assert said.startswith(verdict if strained > 3 else "The posteriors speak for the tangent wall against")
    assert strained > 3 or f"Not counted are {strained} of 6 animals with a fit that must not be used." in said


def test_an_animal_whose_data_one_wall_alone_misses_speaks_against_that_wall(cohort_results):
    """Half of the pulse pressure is left by the linear law: that its numbers must not be used is the verdict on it."""
    results = [changed_residual(result, "linear", 0.5) for result in cohort_results]
    cohort = compared(results, [-40.0] * 6)
    assert cohort.forbidden("linear") == cohort.results
    assert wall_answer(cohort, "linear")[1].startswith("The residuals speak for the tangent wall against the linear")
    missed_by_both = compared([changed_residual(result, "tangent", 0.5) for result in results], [-40.0] * 6)
    assert wall_answer(missed_by_both, "linear")[1].startswith("Not decided between the linear and the tangent wall")


def changed_residual(result, wall, share):
    """Return a result whose fit with a wall leaves a share of the pulse pressure."""
    left = share * float(result.measured.quantities["pPAP"])
    return changed(result, f"{wall}/calibration", RMSE=left)


def test_evidences_for_the_other_law_are_told_the_other_way_round(cohort_results):
    said = wall_answer(weighed(cohort_results, [1 / 50, 1 / 30, 1 / 2000]), "linear")[1]
    assert said.startswith("The posteriors speak for the tangent wall against the linear wall")
    assert "50, 30 and over 1000 times as likely under the tangent law" in said


def test_small_ratios_of_many_animals_and_animals_that_differ_decide_nothing(cohort_results):
    small = weighed(cohort_results, [2.0] * 6)
    assert np.prod(list(evidences(small, "linear")[0].ratios.values())) > CLEAR_EVIDENCE_RATIO
    assert wall_answer(small, "linear")[1].startswith("The posteriors do not decide between the linear and the tangent")
    assert "in none of 6 animals" in wall_answer(small, "linear")[1]
    split = wall_answer(weighed(cohort_results, [5000.0, 0.01, 30.0]), "linear")[1]
    assert split.startswith("The animals differ between the linear and the tangent wall")
    assert "for the linear law in 2 of 3 animals and for the tangent law in 1 of 3 animals" in split
    assert Evidence("tangent", {"a": CLEAR_EVIDENCE_RATIO, "b": 0.9}, {}).side == 0  # together just not clear


def test_a_posterior_that_cannot_be_trusted_is_named_and_leaves_the_residuals_to_answer(cohort_results):
    animals = compared(cohort_results, [0.0, 0.0]).results
    good, bad = (with_evidence(one, trusted, linear=4.0, tangent=0.0) for one, trusted in zip(animals, (1, 0)))
    said = wall_answer(gathered([good, bad]), "linear")[1]
    assert "55 times as likely" in said
    assert "Not counted are 1 of 2 animals with a posterior that cannot be trusted." in said
    assert wall_answer(gathered([bad]), "linear")[1].startswith("The residuals do not decide")


def test_exponents_without_errors_and_bounds_pool_to_students_interval():
    logs = np.log([0.7, 1.1, 1.9, 1.2, 0.9])
    found = pooled_censored(logs, np.zeros(5), np.zeros(5, dtype=int))
    student = stats.ttest_1samp(logs, 0).confidence_interval(0.95)
    assert found.value == pytest.approx(logs.mean(), abs=0.01)
    assert (found.low, found.high) == pytest.approx((student.low, student.high), abs=0.02)


def test_animals_beyond_a_bound_are_kept_and_the_truth_is_held_where_leaving_them_out_loses_it():
    rng, held, held_without, count = np.random.default_rng(5), 0, 0, 150
    for _ in range(count):
        logs = 0.4 * rng.standard_normal(8) + 0.2 * rng.standard_normal(8)  # the truth is 0, and so is the bound
        beyond = np.where(logs <= 0, -1, 0)
        if np.sum(beyond == 0) < 2:
            continue
        found = pooled_censored(np.maximum(logs, 0.0), np.full(8, 0.2), beyond)
        held += found.low <= 0 <= found.high
        inside = logs[beyond == 0]
        without = stats.ttest_1samp(inside, 0).confidence_interval(0.95)
        held_without += without.low <= 0 <= without.high
    assert held > 0.93 * count
    assert held_without < 0.7 * count


@pytest.mark.validation
def test_an_exponent_at_its_bound_moves_the_pooled_one_and_is_named():
    values = [0.9, 1.1, 1.0, 1.2]
    bound = float(made_results({"CTL": 1}, walls=("power",))[0].laws["power"].calibration["lower"].sel(parameter="m"))
    free, kept = (
        exponent_of(exponents(values), "power"),
        exponent_of(exponents([*values, bound], at_bound=[4]), "power"),
    )
    assert free.side == 1
    assert (kept.animals, kept.below, kept.above) == (5, 1, 0)
    assert kept.value < free.value
    assert kept.low < free.low
    said = wall_answer(exponents([*values, bound], at_bound=[4]), "linear")[1]
    assert "5 animals pooled, of them 1 beyond the lower bound of the search" in said
    everyone = exponent_of(exponents([bound, bound], at_bound=[0, 1]), "power")
    assert np.isnan(everyone.value)
    assert everyone.side == 0
    said = wall_answer(exponents([bound, bound], at_bound=[0, 1]), "linear")[1]
    assert "m is not determined (power law; 0.5 is linear; 2 animals pooled, of them 2 beyond the lower bound" in said


@pytest.mark.parametrize("animals", [1, 2, 3, 4])
def test_the_exponent_of_posteriors_keeps_the_error_that_animals_share_by_one_image(animals):
    """Scores of a fixed spread, so that every number can be written out."""
    rng = np.random.default_rng(5)
    scores = rng.standard_normal((4, 250))
    logs = np.log(1.4) + 0.1 * (np.arange(animals) - (animals - 1) / 2)
    results = list(exponents([1.4] * animals).results)
    for place, (result, log) in enumerate(zip(results, logs, strict=True)):
        name = str(result.laws["power"].stiffening["exponent"].attrs["parameter"])
        drawn = np.exp(log + 0.2 * (scores - scores.mean()) / scores.std(ddof=1))
        table = xr.Dataset({"share_image": ("quantity", [0.5])}, {"quantity": [name]}, {"trusted": 1})
        posterior = PosteriorResult(table, {"posterior": xr.Dataset({name: (("chain", "draw"), drawn)})})
        results[place] = replace(
            result, laws={**result.laws, "power": replace(result.laws["power"], posterior=posterior)}
        )
    found = exponent_of(gathered(results), "power")
    assert found.drawn
    assert found.value == pytest.approx(1.4)
    reach = np.log(found.high / found.low) / 2
    if animals == 1:
        assert reach == pytest.approx(stats.norm.ppf(0.975) * 0.2, rel=1e-3)
    else:  # the image's half of the variance does not become less with the number of animals
        own = pooled_mean(logs, np.full(animals, 0.2 * np.sqrt(0.5)))
        assert reach == pytest.approx(
            stats.t.ppf(0.975, own.freedom) * np.hypot(own.error, 0.2 * np.sqrt(0.5)), rel=1e-3
        )


def test_the_exponent_of_one_animal_has_its_own_interval():
    one = exponent_of(exponents([1.4]), "power")
    assert (one.value, one.low, one.high) == pytest.approx((1.4, 1.12, 1.75))
    stopped = wall_answer(exponents([0.05], at_bound=[0]), "linear")[1]
    assert "m is not determined (power law; 0.5 is linear; the search stopped at its lower bound)" in stopped


def test_recordings_of_one_animal_are_one_voice_and_are_never_tested_as_animals(cohort_results):
    """Six recordings of three mice: by hand the mean of each mouse, Student's interval of three."""
    results = cohort_results[:6]
    mice = {result.name: f"mouse {place // 2}" for place, result in enumerate(results)}
    gaps = np.array([1.0, 2.0, 5.0, 7.0, 3.0, 3.5])
    cohort = compared(results, gaps)
    again = replace(cohort, design=Design(subject="mouse"), variables={"mouse": Variable.from_cells("mouse", mice)})
    assert (again.repeated, cohort.repeated) == (True, False)
    (row,) = differences(again.ballots, "linear").to_dict("records")
    means = gaps.reshape(3, 2).mean(axis=1)
    low, high = stats.t.interval(0.95, 2, means.mean(), stats.sem(means))
    assert (row["n"], row["mean"], row["low"], row["high"]) == pytest.approx((3, means.mean(), low, high))
    assert cohort.count("CTL") == "n = 3"
    assert again.count("CTL") == "3 recordings, n = 2"


def test_exponents_are_pooled_over_animals_and_not_over_their_recordings():
    cohort = exponents([0.4, 1.1, 0.9, 1.4, 0.7, 2.0])
    mice = {result.name: f"mouse {place // 2}" for place, result in enumerate(cohort.results)}
    again = replace(cohort, design=Design(subject="mouse"), variables={"mouse": Variable.from_cells("mouse", mice)})
    firsts = exponent_of(again, "power")
    alone = exponent_of(gathered(cohort.results[::2]), "power")
    assert firsts.animals == 3
    assert firsts == alone
    assert "3 animals pooled, the first recording of each" in wall_answer(again, "linear")[1]
