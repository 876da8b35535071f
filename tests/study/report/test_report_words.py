"""What a report says of groups of any size, of any number of wall laws, and of what went wrong."""

import re
from dataclasses import replace

import numpy as np
import pytest

from made_cohort import changed, made_results, voting
from made_posterior import NAMES, with_posterior
from vasowave.base import as_json
from vasowave.pulse.selection import aicc, bic
from vasowave.pulse.solver import STRAINED
from vasowave.study.cohort import (
    ContrastEstimate,
    ContrastLabel,
    Family,
    GroupEffect,
    Primary,
    Untested,
    ballots,
    differences,
    gathered,
    primary_comparison,
    stored,
)
from vasowave.study.report import (
    Notice,
    Remarks,
    Report,
    explained,
    glossary,
    number,
    probability,
    report_of,
    with_interval,
)
from vasowave.study.report.answer import (
    Crossing,
    Marks,
    answer_sections,
    assumed_errors,
    by_fits,
    decay,
    group_answer,
    group_rows,
    influence,
    model_limits,
    other_laws,
    problem_blocks,
    problems,
    shared_images,
    where,
)
from vasowave.study.report.sections import preference_table, selection_table


def plain(name):
    return name


def test_the_best_law_is_compared_with_the_runner_up_not_with_the_worst(cohort_results):
    close = {"linear": 100.0, "tangent": 101.0, "power": 130.0}
    far = {"linear": 130.0, "tangent": 101.0, "power": 110.0}
    results = [voting(result, {"ARMA": (close, 0), "periodic": (far, 0)}, "ARMA") for result in cohort_results[:2]]
    assert stored(results[0].selection).likeliest == "ARMA"
    assert selection_table(gathered(results)).data["AICc prefers"].tolist() == ["undecided", "tangent"] * 2


def test_discarded_noise_models_stand_last_and_decide_nothing(cohort_results):
    scores = {
        "se": ({"linear": -900.0, "tangent": -800.0}, 1),
        "matern32": ({"linear": -610.0, "tangent": -607.0}, 0),
        "periodic": ({"linear": -500.0, "tangent": -520.0}, 0),
    }
    table = ballots(voting(cohort_results[0], scores, "periodic").selection)
    assert table["covariance"].tolist() == ["matern32", "periodic", "se"]
    assert table["AICc prefers"].tolist() == ["undecided", "tangent", "discarded"]
    assert (table["D linear"].iloc[0], table["D tangent"].iloc[0]) == (4, 5)
    assert stored(voting(cohort_results[0], scores, "periodic").selection).likeliest == "periodic"
    lost = voting(cohort_results[0], {"se": scores["se"]}, "")
    assert ballots(lost.selection)["AICc prefers"].tolist() == ["discarded"]
    assert len(differences([stored(lost.selection)], "linear")) == 0


def test_three_and_three_animals_far_apart_are_told_their_effect_and_that_no_test_could_confirm_it():
    results = made_results({"CTL": 3, "HPH": 3}, walls=())
    resistance = {"CTL": (80.0, 91.0, 100.0), "HPH": (230.0, 262.0, 288.0)}
    results = [
        changed(result, "measured/quantities", PVR=resistance[result.group][int(result.name[-1]) - 1])
        for result in results
    ]
    primary = primary_comparison(gathered(results), Family(quantities=("PVR",)))
    (first,), ((question, said),), (_, said_once) = group_answer(primary, plain)
    assert question == "Pressure and flow"
    (effect,) = primary.effects
    low, high = f"{effect.low:.2f}", f"{effect.high:.2f}"
    p = probability(effect.p)
    text = f"PVR 90.0 → 259 mmHg s/ml (2.88 times [{low}, {high}], {p})"
    higher = "Higher vascular resistance{} in HPH than in CTL"
    assert first == f"{higher.format(' (× 2.88)')} (3 + 3 animals), if logarithms are normal."
    assert said == f"{higher.format('')}. Measured: {text}."
    assert said_once.startswith("A test by ranks cannot come below p = 0.10 with 3 + 3 animals: p and")
    assert "scatter 2.9 times less" in said_once  # 4 degrees of freedom: √(4 / 0.484), a table's quantile of χ²
    assert float(low) > 1


def test_the_animal_that_moves_an_effect_most_is_named_and_other_laws_only_where_they_differ(cohort_results):
    cohort = gathered([changed(cohort_results[5], "measured/quantities", PVR=9000.0), *cohort_results[:5]])
    primary = primary_comparison(cohort)
    (said,) = influence(primary, plain)
    assert "without HPH 3, PVR is " in said
    modeled = [
        ContrastEstimate(contrast=effect.contrast, quantity=effect.quantity, source="tangent", ratio=effect.ratio,
                         low=effect.low, high=effect.high)
        for effect in primary.effects if effect.source == "linear"
    ]  # fmt: skip
    (same,) = other_laws(replace(primary, others=tuple(modeled)), plain)
    assert same == "By the tangent wall every ratio lies inside the intervals of the linear wall."
    modeled[0] = replace(modeled[0], ratio=40.0)
    (other,) = other_laws(replace(primary, others=tuple(modeled)), plain)
    assert other == "Outside the intervals of the linear wall lie stiffness 40.0 times (tangent)."


def test_a_law_that_misses_its_data_is_a_problem_and_one_among_equals_is_none(cohort_results):
    none = gathered(cohort_results)
    primary = primary_comparison(none)
    assert problems(none, primary) == []
    best = float(cohort_results[1].laws["linear"].calibration["RMSE"])
    twice, bad = (changed(cohort_results[1], "tangent/calibration", RMSE=times * best) for times in (2.0, 3.1))
    assert not gathered([cohort_results[0], twice, *cohort_results[2:]]).misfits["missed"].any()
    cohort = gathered([cohort_results[0], bad, *cohort_results[2:]])
    table = cohort.misfits
    assert table.loc[table["missed"], ["animal", "wall"]].to_numpy().tolist() == [["CTL 2", "tangent"]]
    (said,) = problems(cohort, primary)
    assert "The tangent wall misses the data of CTL 2" in said
    assert "3.1 times what the best law leaves" in said
    assert isinstance(problem_blocks(cohort, primary)[0], Notice)
    assert [type(block) for block in problem_blocks(none, primary)] == [Remarks]


def overstrained(result, wall, percent=928.0):
    finding = STRAINED(value=percent / 100, time=0.05, percent=percent).at(vessel="RPAaa")
    law = result.laws[wall]
    law = replace(law, calibration=law.calibration.assign_attrs(findings=as_json([finding])))
    return replace(result, laws={**result.laws, wall: law})


def test_a_law_of_arteries_that_no_animal_survives_is_a_problem_and_no_yardstick_for_others(cohort_results):
    rmse = float(cohort_results[1].laws["linear"].calibration["RMSE"])
    better = changed(cohort_results[1], "tangent/calibration", RMSE=rmse / 8)
    others = (cohort_results[0], *cohort_results[2:])
    assert gathered([better, *others]).misfits["missed"].any()  # the tangent wall is the best law
    torn = gathered([overstrained(better, "tangent"), *others])
    assert not torn.misfits["missed"].any()
    problem = "vessels of CTL 2 are strained beyond what an artery survives: an area grows by up to 928 %. Do not use"
    assert problem in " ".join(problems(torn, primary_comparison(torn, Family("tangent", NAMES))))
    assert not problems(torn, primary_comparison(torn, Family("linear", NAMES)))
    quiet = str(problem_blocks(torn, primary_comparison(torn, Family("linear", NAMES))))
    assert "by the linear wall no problem was found; what another law has stands beside" in quiet
    assert "no law misses" not in quiet


def test_numbers_that_are_not_to_be_used_are_marked(cohort_results):
    bad = [overstrained(cohort_results[1], "tangent"), cohort_results[0], *cohort_results[2:]]
    marked = dict(answers_of(bad, Family("tangent", ("mPAP", "stiffness"))))
    assert re.search(r"wall stiffness β\(0\) .*\)\*†\.", marked["Large arteries"])
    assert "*" not in marked["Pressure and flow"]
    assert marked["What do marks mean?"] == (
        "* rests on the tangent wall's numbers of CTL 2, and these must not be used: see Problems. † rests on a value "
        "at a bound of the search (p₁ (half-width pressure of the wall) in 1 of 6): it may lie beyond."
    )
    assert "*" not in str(answers_of(bad, Family("linear", ("mPAP", "stiffness"))))
    alone = dict(answers_of(bad[:1], Family("tangent", ("mPAP", "stiffness"))))
    assert re.search(r"all stiffness β\(0\) \S+ \[\S+ \S+\] mmHg\*", alone["Large arteries"])
    assert "*" not in alone["Pressure and flow"]


def test_a_value_at_a_bound_of_the_search_is_marked_beside_each_number_that_rests_on_it(cohort_results):
    """A compliance of the beds at its bound says nothing wrong of stiffness, and of R_T C_T it does."""
    fit = cohort_results[3].laws["linear"].calibration
    stopped = changed(cohort_results[3], "linear/calibration", at_bound=fit["parameter"].values == "c1")
    results = [*cohort_results[:3], stopped, *cohort_results[4:]]
    family = Family("linear", ("mPAP", "stiffness", "tau", "I_R"))
    cohort = gathered(results)
    primary = primary_comparison(cohort, family)
    marks = {effect.quantity: Marks(cohort, "linear").of_effect(effect) for effect in primary.effects}
    assert marks == {"mPAP": "", "stiffness": "", "tau": "†", "I_R": "†"}
    drawn = {row.label: row.effect for row in group_rows(cohort, primary, str, Marks(cohort, "linear").of_effect)}
    assert {name for name, text in drawn.items() if text.endswith("]†")} == {"tau", "I_R"}
    assert Marks(cohort, "linear").of_quantity("tau", cohort_results[:3]) == ""
    said = dict(answers_of(results, family))
    meant = "† rests on a value at a bound of the search (c₁ (factor of the nominal C of all beds) in 1 of 6)"
    assert said["What do marks mean?"].startswith(meant)
    drawn = [with_posterior(result) for result in results]
    assert Marks(gathered(drawn), "linear").of_quantity("tau", drawn) == ""  # draws do not stop at a search's bound


def answers_of(results, family):
    """Return the answers of the first page."""
    cohort = gathered(results)
    (section, *_) = answer_sections(cohort, primary_comparison(cohort, family), family)
    return Report("report", "", "", "", [section]).answers()


def test_the_models_time_constant_is_not_called_that_of_the_measured_decay(cohort_results):
    """Of a Windkessel with a decay of 0.22 s the linear wall's R_T C_T is 0.124 s, by the rule for C_v."""

    def said(times):
        scattered = zip(cohort_results, (0.9, 1.0, 1 / 0.9) * 2, strict=True)  # the groups' geometric means stay
        return decay(gathered([
            changed(result, "linear/quantities", tau=times * own * float(result.measured.quantities["tau"]))
            for result, own in scattered
        ]), "linear")  # fmt: skip

    far, alike = said(0.56), said(1.1)
    measured = [float(one.measured.quantities["tau"]) for one in cohort_results[:3]]
    assert f"falls in diastole with τ = {np.exp(np.log(measured).mean()):.3g} s in CTL and " in far
    assert "The model's R_T C_T is not the time of this decay" in far
    assert "falls in diastole with τ" in alike
    assert "not the time of this decay" not in alike


def test_a_held_parameter_and_one_at_its_bound_are_called_so(cohort_results):
    fit = cohort_results[1].laws["tangent"].calibration
    gamma = fit["parameter"].values == "gamma"
    held = changed(cohort_results[1], "tangent/calibration", free=~gamma, value=np.where(gamma, 2.0, fit["value"]))
    said = " ".join(model_limits(gathered([cohort_results[0], held]), "linear", {"gamma": "γ"}))
    assert "Held, not fitted (tangent wall): γ = 2.00" in said
    assert "Stopped at a bound of the search: p1 in 1 of 2 (tangent wall); there" in said
    assert "do not determine r1 in 2 of 2" in said


def test_the_pressure_of_the_image_is_said_or_that_nobody_knows_it(cohort_results):
    def said(*pressures):
        animals = [
            changed(result, "network", image_pressure=pressure)
            for result, pressure in zip(cohort_results, pressures, strict=False)
        ]
        return " ".join(model_limits(gathered(animals), "linear", {}))

    assert "The image's pressure is not known" in said(0.0, 0.0)
    assert "at the image's pressure, 6.30 mmHg." in said(6.3, 6.3)
    assert "at the image's pressure, 6.30 to 17.2 mmHg" in said(6.3, 17.2)
    assert "6.30 mmHg. Of 1 of 2 animals it is not known: their radii" in said(0.0, 6.3)


def test_posteriors_that_are_offered_are_of_the_law_that_the_answer_stands_on(cohort_results):
    results = [with_posterior(result) for result in cohort_results]
    said = {law: " ".join(model_limits(gathered(results), law, {})) for law in ("linear", "tangent")}
    assert "Posteriors weigh" not in said["linear"]
    assert "inference: posterior in study.yaml" in said["tangent"]  # `reference` would be of the linear law again


def test_one_network_of_all_animals_is_said_to_move_them_alike(cohort_results):
    same = [replace(result, network=cohort_results[0].network) for result in cohort_results]
    assert shared_images(gathered(same)) == [
        "One imaged lung stands for all animals: errors of its measurement are the same in all; how lungs of "
        "animals differ is not measured."
    ]
    one_group = [replace(result, network=same[0].network) if result.group == "CTL" else
                 replace(result, network=replace(result.network, radius=result.network.radius * (1 + 0.01 * place)))
                 for place, result in enumerate(cohort_results)]  # fmt: skip
    assert shared_images(gathered(one_group))[0].startswith("One imaged lung stands for all animals of CTL: ")
    of_aorta = [replace(result, recording=result.recording.assign_attrs(site="aorta")) for result in same]
    assert shared_images(gathered(of_aorta))[0].startswith("One imaged arterial tree stands for all animals")


def test_an_error_that_differs_between_animals_is_given_as_a_range(cohort_results):
    usual = cohort_results[0].assumed_errors[0]
    results = [replace(result, assumed_errors=(usual._replace(name="flow_delay", sd=delay, unit="s", source="lab"),))
               for result, delay in zip(cohort_results, (0.0031, 0.0036, 0.0033))]  # fmt: skip
    [text] = assumed_errors(results)
    assert "delay of the flow 0.0031 to 0.0036 s (stated)" in text


def test_a_symbol_carries_its_meaning_and_a_word_stays_a_word():
    mark = explained({"a": "resistance ratio", "R_T": "total <resistance>", "β": "stiffness"})
    assert 'title="total &lt;resistance&gt;">R_T</abbr> of a mouse' in mark("R_T of a mouse")
    assert "abbr" not in mark("a mouse")
    assert mark("a [1]").startswith('<abbr tabindex="0" title="resistance ratio">a</abbr>')
    assert mark("R_T1 & <b>") == "R_T1 &amp; &lt;b&gt;"


@pytest.mark.parametrize("sizes", [{"WT": 3, "HOX": 2}, {"CTL": 4, "HPH": 4}])
def test_the_page_says_no_sentence_twice(sizes):
    results = made_results(sizes, walls=("linear", "tangent", "power"))
    for wall in ("tangent", "power"):
        table = results[0].laws[wall].calibration
        results[0] = changed(results[0], f"{wall}/calibration", at_bound=table["parameter"].values == "c1")
    cohort = gathered(results, reference=next(iter(sizes)))
    family = Family(quantities=("mPAP", "CO", "PVR", "stiffness", "wave_speed", "C_p", "tau", "a", "I_R"))
    document = report_of(cohort, primary_comparison(cohort, family), family, {})
    sentences = [
        sentence.strip(" .")
        for section in document.sections
        for text in texts(section.blocks)
        for sentence in re.split(r"(?<=[.;])\s+", text)
        if len(sentence.split()) >= 5
    ]
    assert len(sentences) > 15
    assert [one for one in sentences if sentences.count(one) > 1] == []


def texts(blocks):
    """Return the sentences, captions and answers of blocks."""
    for block in blocks:
        for inner in (getattr(block, "text", ""), getattr(block, "caption", ""), *getattr(block, "items", ())):
            yield inner[1] if isinstance(inner, tuple) else inner
        yield from texts(getattr(block, "blocks", ()))


def test_the_glossary_names_the_equations_of_the_criteria(cohort_results):
    known = glossary(gathered(cohort_results))
    for said, criterion in (("AICc", aicc), ("BIC", bic)):
        (equation,) = re.findall(r"eq\. \d+", criterion.__doc__)
        assert f"({equation})" in known[said]


def test_laws_are_compared_over_all_animals_by_noise_model_with_what_parameters_cost(cohort_results):
    """Of each animal AICc of the tangent law less that of the linear one: 12, 14 and 16; its price is of one more."""
    open_ = {"linear": 0.0, "tangent": 1.0}
    results = [
        voting(one, {"ARMA": ({"linear": 0.0, "tangent": 12.0 + 2 * place}, 0), "se": (open_, 0)}, "ARMA")
        for place, one in enumerate(cohort_results[:3])
    ]
    table = preference_table(gathered(results), "linear")
    assert [row[:3] for row in table.rows] == [
        ("tangent", noise, "3 of 3") for noise in ("likeliest of each animal", "ARMA", "se")]  # fmt: skip
    reach = 4.302653 * 2 / np.sqrt(3)
    price = aicc(0.0, 5, 512) - aicc(0.0, 4, 512)
    own = 14 - price
    assert table.rows[0][3:] == (
        with_interval(14.0, 14 - reach, 14 + reach), number(price, 2), with_interval(own, own - reach, own + reach),
        "2.0", "linear",
    )  # fmt: skip
    assert table.rows[2][7] == "open"


EFFECT = GroupEffect(
    contrast=ContrastLabel("HPH", "CTL"), quantity="R_T", source="linear", n_reference=7, n_group=5,
    mean_reference=10.0, mean_group=20.0, unit="mmHg", ratio=2.0, low=1.5, high=2.7, p=0.01, smallest_p=0.001,
    origin="fit", without="", ratio_without=np.nan, standard_error=0.1, freedom=9.0,
)  # fmt: skip


def primary_of(*changes):
    return Primary("linear", tuple(replace(EFFECT, **change) for change in changes), (), ())


def test_effects_stand_by_direction_and_those_that_are_not_shown_apart():
    lower = {"quantity": "a", "ratio": 0.5, "low": 0.3, "high": 0.8, "p": 0.0499}
    within = {"quantity": "I_R", "ratio": 1.02, "low": 0.9, "high": 1.16, "p": 0.8}
    untested = {"quantity": "c", "untested": Untested.ONE_IMAGE, "p": np.nan}
    first, _, _ = group_answer(primary_of({}, lower, {"quantity": "b", "p": 0.06}, within, untested), "<{}>".format)
    assert " ".join(first) == (
        "Higher resistance of the beds (× 2.00 by the model) and smaller proximal resistance share (× 0.50 by the "
        "model) in HPH than in CTL. "
        "No effect larger than a factor of 1.16: model wave reflection. Undecided (neither shown nor excluded): <b>. "
        "Without p (animals share an image of unknown error): <c>."
    )


def test_fits_that_judge_otherwise_than_posteriors_are_told():
    fits = {"origin": "posterior", "fits_ratio": 2.9, "fits_low": 1.35, "fits_high": 6.4}
    wide = {"fits_ratio": 2.0, "fits_low": 0.9, "fits_high": 4.4}
    (said,) = by_fits(primary_of(fits | {"quantity": "a", "p": 0.13}, fits, fits | wide), plain)
    assert "of a in HPH, which they show (2.9 times [1.4, 6.4])" in said
    assert "R_T in HPH, which they do not show (2.0 times [0.9, 4.4])" in said
    (same,) = by_fits(primary_of(fits, fits | wide | {"p": 0.3}), plain)
    assert same == "Fits of the same animals show the same effects as their posteriors."


@pytest.mark.parametrize(
    ("contrast", "said"),
    [
        ({"within": "at w1"}, ("in HPH than in CTL at w1", "between HPH and CTL at w1")),
        ({"kind": "factor", "within": "in A"}, ("at HPH than at CTL in A", "between HPH and CTL in A")),
        (
            {"kind": "interaction", "change": "post/pre"},
            ("in HPH than in CTL from pre to post", "between HPH and CTL in the change from pre to post"),
        ),
        ({"kind": "trend"}, ("at HPH than at CTL by the trend", "from CTL to HPH by the trend")),
        ({"kind": "contrast"}, ("by the contrast 'HPH'", "by the contrast 'HPH'")),
    ],
)
def test_an_effect_of_a_design_is_told_with_where_it_is(contrast, said):
    assert where(ContrastLabel("HPH", "CTL", **contrast), Crossing("A and B", followed=True)) == said
