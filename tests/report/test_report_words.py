"""What a report says of groups of any size, of any number of wall laws, and of what went wrong."""

import re
from dataclasses import replace

import numpy as np
import pytest

from made_cohort import changed, made_results, voting
from made_posterior import NAMES, with_posterior
from vasowave.cohort import Family, gathered, primary_comparison
from vasowave.cohort.votes import ballots, differences, stored
from vasowave.findings import as_json
from vasowave.report.answer.forest import group_rows
from vasowave.report.answer.groups import group_answer, influence, other_laws
from vasowave.report.answer.limits import model_limits, shared_images
from vasowave.report.answer.marks import Marks
from vasowave.report.answer.page import answer_sections
from vasowave.report.answer.problems import problem_blocks, problems
from vasowave.report.blocks import Report
from vasowave.report.documents import report_of
from vasowave.report.glossary import _OWN, explained
from vasowave.report.tables.models import selection_table
from vasowave.report.wording import friction_words, probability, ratio_with_interval, with_error, with_interval
from vasowave.selection.criteria import aicc, bic
from vasowave.solver.validity import STRAINED


def plain(name):
    return name


@pytest.mark.parametrize(
    ("p", "said"), [(0.5, "p = 0.50"), (0.0302, "p = 0.030"), (0.0002, "p = 0.00020"), (1e-4, "p ≤ 0.0001"),
                  (0.049, "p ≈ 0.049"), (0.0451, "p = 0.045"), (0.0539, "p ≈ 0.054"), (0.055, "p = 0.055")]
)  # fmt: skip
def test_a_p_that_no_drawn_cohort_reaches_is_said_as_a_bound(p, said):
    """10 000 cohorts, the observed one among them: 0.0001 is the least that there can be."""
    assert probability(p) == said


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
    row = primary.rows.iloc[0]
    low, high = (f"{row[end]:.2f}" for end in ("low", "high"))
    p = probability(row["p"])
    effect = f"PVR 90.0 → 259 mmHg s/ml (2.88 times [{low}, {high}], {p})"
    apart = "The groups do not overlap, which chance alone does in 10 % of quantities."
    higher = "igher vascular resistance{} in HPH than in CTL."
    assert first == f"If logarithms are normal, h{higher.format(' (× 2.88)')}"
    assert said == f"H{higher.format('')} Measured: {effect}. {apart}"
    assert said_once.startswith("A test by ranks cannot come below p = 0.10 with 3 + 3 animals: p and")
    assert float(low) > 1


def test_what_is_shown_stands_apart_from_what_is_not_and_every_effect_has_interval_and_p():
    primary = primary_comparison(
        gathered(made_results({"CTL": 6, "HPH": 6}, walls=())), Family(quantities=("mPAP", "CO", "PVR"))
    )
    _, ((_, said),), _ = group_answer(primary, plain)
    shown, _, rest = said.partition(" No effect larger than a factor of ")
    clear = set(primary.rows.loc[primary.rows["p"] < 0.05, "quantity"])
    assert re.match("Higher .* in HPH than in CTL. Measured: ", shown)
    assert {name for name in ("mPAP", "CO", "PVR") if name in shown} == clear
    effect = r"[\d.]+ → [\d.]+ (?:mmHg|ml/s|mmHg s/ml) \([\d.]+ times \[[\d.]+, [\d.]+\], p [=<] [\d.]+\)"
    assert len(re.findall(effect, shown)) == len(clear)
    ends = primary.rows.set_index("quantity").loc["CO", ["low", "high"]]
    assert rest.startswith(f"{max(1 / ends['low'], ends['high']):.2f}: CO ")
    assert re.fullmatch(rf"[\d.]+: CO {effect}\.", rest)


def test_the_animal_that_moves_an_effect_most_is_named_and_other_laws_only_where_they_differ(cohort_results):
    cohort = gathered([changed(cohort_results[5], "measured/quantities", PVR=9000.0), *cohort_results[:5]])
    primary = primary_comparison(cohort)
    (said,) = influence(primary, plain)
    assert "without HPH 3, PVR is " in said
    modeled = primary.rows[primary.rows["source"] == "linear"].assign(source="tangent").reset_index(drop=True)
    (same,) = other_laws(replace(primary, others=modeled), plain)
    assert same == "By the tangent wall every ratio lies inside the intervals of the linear wall."
    modeled.loc[0, "ratio"] = 40.0
    (other,) = other_laws(replace(primary, others=modeled), plain)
    assert other == "Outside the intervals of the linear wall lie stiffness 40.0 times (tangent)."


def test_a_law_that_misses_its_data_is_a_problem_and_one_among_equals_is_none(cohort_results):
    none = gathered(cohort_results)
    primary = primary_comparison(none)
    assert problems(none, primary) == []
    bad = changed(
        cohort_results[1], "tangent/calibration", RMSE=3.1 * float(cohort_results[1].laws["linear"].calibration["RMSE"])
    )
    cohort = gathered([cohort_results[0], bad, *cohort_results[2:]])
    table = cohort.misfits
    assert table.loc[table["missed"], ["animal", "wall"]].to_numpy().tolist() == [["CTL 2", "tangent"]]
    (said,) = problems(cohort, primary)
    assert "The tangent wall misses the data of CTL 2" in said
    assert "3.1 times what the best law leaves" in said
    assert problem_blocks(cohort, primary)[0].kind == "notice"
    assert [block.kind for block in problem_blocks(none, primary)] == ["remarks"]


def test_a_law_that_leaves_just_twice_what_the_best_leaves_is_not_said_to_miss(cohort_results):
    best = float(cohort_results[1].laws["linear"].calibration["RMSE"])
    twice = changed(cohort_results[1], "tangent/calibration", RMSE=2.0 * best)
    cohort = gathered([cohort_results[0], twice, *cohort_results[2:]])
    assert not cohort.misfits["missed"].any()


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
    said = page_of(torn.results, Family("tangent", NAMES))
    problem = "vessels of CTL 2 are strained beyond what an artery survives: an area grows by up to 928 %. Do not use"
    assert problem in " ".join(problems(torn, primary_comparison(torn, Family("tangent", NAMES))))
    assert not problems(torn, primary_comparison(torn, Family("linear", NAMES)))
    assert said.count(problem) == page_of(torn.results).count(problem) == 1
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
    marks = {row["quantity"]: Marks(cohort, "linear").of_row(row) for _, row in primary.rows.iterrows()}
    assert marks == {"mPAP": "", "stiffness": "", "tau": "†", "I_R": "†"}
    drawn = {row.label: row.effect for row in group_rows(cohort, primary, str, Marks(cohort, "linear").of_row)}
    assert {name for name, text in drawn.items() if text.endswith("]†")} == {"tau", "I_R"}
    assert Marks(cohort, "linear").of("tau", cohort_results[:3]) == ""
    said = dict(answers_of(results, family))
    meant = "† rests on a value at a bound of the search (c₁ (factor of the nominal C of all beds) in 1 of 6)"
    assert said["What do marks mean?"].startswith(meant)
    drawn = [with_posterior(result) for result in results]
    assert Marks(gathered(drawn), "linear").of("tau", drawn) == ""  # draws do not stop at a search's bound


def answers_of(results, family):
    """Return the answers of the first page."""
    cohort = gathered(results)
    (section, *_) = answer_sections(cohort, primary_comparison(cohort, family), family)
    return Report("report", "", "", "", [section]).answers()


def test_the_models_time_constant_is_not_called_that_of_the_measured_decay(cohort_results):
    """Of a Windkessel with a decay of 0.22 s the linear wall's R_T C_T is 0.124 s, by the rule for C_v."""

    def modeled(times):
        scattered = zip(cohort_results, (0.9, 1.0, 1 / 0.9) * 2, strict=True)  # the groups' geometric means stay
        return [
            changed(result, "linear/quantities", tau=times * own * float(result.measured.quantities["tau"]))
            for result, own in scattered
        ]

    alike, far = modeled(1.1), modeled(0.56)
    family = Family("linear", ("mPAP", "tau"))
    said = dict(answers_of(far, family))["Small vessels"]
    assert "model time constant R_T C_T" in said
    measured = [float(one.measured.quantities["tau"]) for one in cohort_results[:3]]
    assert f"falls in diastole with τ = {np.exp(np.log(measured).mean()):.3g} s in CTL and " in said
    assert "The model's R_T C_T is not the time of this decay" in said
    (alone,) = (text for question, text in answers_of(far[1:2], family) if question == "Small vessels")
    assert f"falls in diastole with τ = {measured[1]:.3g} s. The model's R_T C_T is not the time of this decay" in alone
    alike = dict(answers_of(alike, family))["Small vessels"]
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


def test_what_is_said_of_one_image_is_what_intervals_and_p_do():
    """Of fits no p where a group has one image, and no interval with its error; posteriors contain it in both."""
    results = made_results({"CTL": 4, "HPH": 3}, walls=("linear",))
    by_fits, by_draws = page_of(results), page_of([with_posterior(result) for result in results])
    assert "Without p between HPH and CTL, by the model (linear wall)" in by_fits
    assert "Without p" not in by_draws
    for said in (by_fits, by_draws):
        assert (
            "Each group has one imaged lung, which stands for all its animals; how lungs differ is not measured."
            in said
        )
        assert "ourth power" not in said


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


def page_of(results, family=None):
    """Return the sentences of the page, of which the model's quantities are two."""
    cohort, family = gathered(results), family or Family("linear", NAMES)
    sections = report_of(cohort, primary_comparison(cohort, family), family).sections
    return " ".join(text for section in sections for text in texts(section.blocks))


def test_an_interval_that_excludes_one_is_written_so():
    assert ratio_with_interval(2.17, 1.023, 4.53) == "2.2 [1.02, 4.5]"
    assert ratio_with_interval(0.42, 0.18, 0.9996) == "0.42 [0.18, 0.9996]"
    assert ratio_with_interval(0.874, 0.7612, 1.004) == "0.87 [0.76, 1.004]"
    assert ratio_with_interval(2.10, 1.31, 3.37) == "2.10 [1.31, 3.37]"
    assert ratio_with_interval(4.0, 1.9, 10.0) == "4.0 [1.9, 10.0]"
    assert ratio_with_interval(0.558, 1e-9, 1e9) == "0.558 [no limits]"


def test_errors_have_two_digits_and_values_end_where_they_do():
    assert [with_error(0.18, 0.0297), with_error(76.9, 21.3), with_error(5.0, 0.0996)] == [
        "0.180 ± 0.030", "77 ± 21", "5.00 ± 0.10",
    ]  # fmt: skip
    assert with_interval(57.8, 26.2, 126.4) == "58 [26, 126]"
    assert with_interval(2.733, 1.742, 4.289) == "2.73 [1.74, 4.29]"
    assert with_interval(0.22, 0.0032, 15.2) == "0.22 [0.0032, 15]"
    assert with_interval(1.7e-5, 1.1e-5, 2.4e-5) == "1.70 [1.10, 2.40]·10⁻⁵"
    assert with_error(2.0, float("nan")) == "2.00"
    assert with_error(1 / 3, 4e-16) == with_interval(1 / 3, 1 / 3 - 6e-17, 1 / 3 + 6e-17) == "0.333"


def test_a_symbol_carries_its_meaning_and_a_word_stays_a_word():
    mark = explained({"a": "resistance ratio", "R_T": "total <resistance>", "β": "stiffness"})
    assert 'title="total &lt;resistance&gt;">R_T</abbr> of a mouse' in mark("R_T of a mouse")
    assert "abbr" not in mark("a mouse")
    assert mark("a [1]").startswith('<abbr tabindex="0" title="resistance ratio">a</abbr>')
    assert mark("R_T1 & <b>") == "R_T1 &amp; &lt;b&gt;"


@pytest.mark.parametrize("sizes", [{"WT": 3, "HOX": 2}, {"CTL": 6, "HPH": 5}])
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


@pytest.mark.parametrize(
    ("law", "settings", "words"),
    [
        ("BoundaryLayer", {"reference_radius": None}, "a boundary layer (local radius)"),
        ("BoundaryLayer", {"reference_radius": 0.047}, "a boundary layer (fixed radius 0.0470 cm)"),
        ("Poiseuille", {}, "Poiseuille flow"),
        ("PowerLaw", {"exponent": 9.0}, "a power-law profile (exponent 9.00)"),
        ("PowerLaw", {}, "a power-law profile"),
        ("Ours", {"first_part": 2.5, "second": 3.0}, "Ours (first part 2.50, second 3.00)"),
    ],
)
def test_a_friction_is_called_by_its_law_and_its_settings(law, settings, words):
    assert friction_words(law, settings) == words


def test_the_glossary_names_the_equations_of_the_criteria():
    for said, criterion in (("AICc", aicc), ("BIC", bic)):
        (equation,) = re.findall(r"eq\. \d+", criterion.__doc__)
        assert f"({equation})" in _OWN[said]
