"""What the pages say of numbers that are made by hand: every branch of a sentence, its numbers, plurals and limits."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from vasowave.cohort.missing import Standing
from vasowave.cohort.planning import Plan, Planning, Spread
from vasowave.cohort.primary import Assurance, Primary
from vasowave.findings import OTHER
from vasowave.report import planned
from vasowave.report.answer import animal as animal_answer
from vasowave.report.answer import effects, forest, groups, limits, page, problems, walls
from vasowave.report.answer.marks import unmarked
from vasowave.report.glossary import explained, symbol, words
from vasowave.report.sections import animals as sections
from vasowave.report.sections import groups as group_sections
from vasowave.report.sections.data import _single_beat
from vasowave.report.wording import (
    column_label,
    friction_words,
    name_and_unit,
    probability,
    table_rows,
    unit,
    value_text,
)

CALLED = "<{}>".format

ROW = {
    "reference": "CTL", "other": "HPH", "question": "Q", "quantity": "R_T", "source": "linear", "n reference": 7,
    "n other": 5, "mean reference": 10.0, "mean other": 20.0, "unit": "mmHg", "ratio": 2.0, "low": 1.5, "high": 2.7,
    "p": 0.01, "untested": "", "smallest p": 0.001, "apart": False, "estimates": "fit", "without": "", "df": 9.0,
    "ratio without": np.nan,
}  # fmt: skip


def rows(*changes):
    return pd.DataFrame([ROW | one for one in changes])


def primary(*changes, others=(), left_out=None, **more):
    return Primary("linear", rows(*changes) if changes else pd.DataFrame(), rows(*others) if others else pd.DataFrame(),
                   left_out or {}, **more)  # fmt: skip


def answered(*changes, mark=unmarked):
    """Return the answer's first sentences, then the text of the only question, then how sure it is."""
    answer = groups.group_answer(primary(*changes), CALLED, mark)
    return " ".join(answer.first), " ".join(text for _, text in answer.questions), " ".join(answer.sureness)


UNTESTED = {"untested": "one image", "p": np.nan}


def test_effects_stand_by_direction_and_those_that_are_not_shown_apart():
    lower = {"quantity": "a", "ratio": 0.5, "low": 0.3, "high": 0.8, "p": 0.0499}
    within = {"quantity": "I_R", "ratio": 1.02, "low": 0.9, "high": 1.16, "p": 0.8}
    first, text, sure = answered(
        {}, lower, {"quantity": "b", "p": 0.06}, within, {"quantity": "c", "mean other": np.nan} | UNTESTED
    )
    assert first == (
        "Higher resistance of the beds (× 2.00 by the model) and smaller proximal resistance share (× 0.50 by the "
        "model) in HPH than in CTL. No effect larger than a factor of 1.16: model wave reflection. Undecided (neither "
        "shown nor excluded): <b>. Without p: <c>."
    )
    assert text == (
        "Higher resistance of the beds and smaller proximal resistance share in HPH than in CTL. "
        "By the model (linear wall): <R_T> 10.0 → 20.0 mmHg (2.00 times [1.50, 2.70], p = 0.010) and <a> 10.0 → 20.0 "
        "mmHg (0.50 times [0.30, 0.80], p ≈ 0.050). "
        "No effect larger than a factor of 1.16, by the model (linear wall): <I_R> 10.0 → 20.0 mmHg (1.02 times "
        "[0.90, 1.16], p = 0.80). "
        "Undecided, by the model (linear wall): <b> 10.0 → 20.0 mmHg (2.00 times [1.50, 2.70], p = 0.060). "
        "Without p, by the model (linear wall): <c> (2.00 times [1.50, 2.70])."
    )
    assert sure == (  # the interval of <b> reaches √(2.70 / 1.50) = 1.34 times either way
        "Brackets are 95 % intervals. They and p are corrected for 4 comparisons. A p near 1 does not say that groups "
        "are equal. With animals that vary as these do, what is undecided would be shown by a found ratio of about "
        "these or more (one over them or less): <b> 1.3. `vasowave plan` says how many animals show smaller ones."
    )
    first, text, _ = answered({"p": 0.05}, UNTESTED | {"quantity": "c"})
    assert first.startswith(
        "No difference between HPH and CTL is shown. Undecided (neither shown nor excluded): resistance of the beds."
    )
    assert text.startswith("Undecided between HPH and CTL, by the model (linear wall): <R_T>")
    assert ". Without p, by the model (linear wall): <c>" in text
    assert groups.group_answer(primary(), CALLED) == ([], [], [])


@pytest.mark.parametrize(
    ("low", "high", "small"), [(0.8, 1.25, True), (0.79, 1.1, False), (0.9, 1.26, False), (0.99, 1.01, True)]
)
def test_an_effect_is_small_where_its_whole_interval_is(low, high, small):
    row = pd.Series(ROW | {"ratio": 1.0, "low": low, "high": high, "p": 0.9})
    assert (effects.standing(row) == effects.Standing.SMALL) is small
    assert effects.standing(row.replace(0.9, 0.01)) == effects.Standing.SHOWN if low != 0.9 else True


def test_what_was_measured_is_told_without_any_image_where_models_answer_too():
    measured = {"source": "measured", "quantity": "Z_c", "question": "Large arteries"}
    _, text, _ = answered(measured, {"quantity": "stiffness", "question": "Large arteries"})
    assert text.startswith("Higher characteristic impedance and stiffer large arteries in HPH than in CTL. Without any "
                           "image: <Z_c> 10.0 → 20.0 mmHg (2.00 times [1.50, 2.70], p = 0.010). By the model (linear "
                           "wall): <stiffness>")  # fmt: skip
    assert ". Measured: <mPAP>" in answered({"source": "measured", "quantity": "mPAP"})[1]


def test_effects_that_no_test_by_ranks_could_show_are_told_with_whether_groups_overlap():
    few = {"smallest p": 0.1, "n reference": 3, "n other": 3}
    first, text, sure = answered(few | {"apart": True}, few | {"quantity": "a"})
    assert first.startswith("If logarithms are normal, higher resistance of the beds (× 2.00 by the model)")
    assert text.endswith(" The groups do not overlap in <R_T>, which chance alone does in 10 % of quantities.")
    assert sure.startswith(
        "Brackets are 95 % intervals. They and p are corrected for 2 comparisons. A p near 1 does not say that groups "
        "are equal. A test by ranks cannot come below p = 0.10 with 3 + 3 animals: p and intervals rest on logarithms"
    )
    assert "The groups do not overlap, which chance" in answered(few | {"apart": True})[1]
    assert "overlap" not in answered(few)[1]
    assert answered(few | {"smallest p": 0.05})[0].startswith("If logarithms are normal")
    assert answered(few | {"smallest p": 0.0499})[0].startswith("Higher resistance")


def test_several_groups_are_counted_in_what_tests_can_reach():
    few = {"smallest p": 0.2, "n reference": 3, "n other": 3}
    first, text, sure = answered(few, few | {"other": "SU", "n other": 2, "smallest p": 0.4})
    assert (
        "A test by ranks that counts for 2 pairs of groups cannot come below p = 0.20 with 3 + 3 animals and "
        "0.40 with 3 + 2 animals:"
    ) in sure
    for said in (first, text):
        assert "in HPH than in CTL" in said
        assert "in SU than in CTL" in said


def test_numbers_that_are_doubted_carry_a_mark():
    mark = lambda row: "†" if row["quantity"] == "a" else ""  # noqa: E731
    text = answered({}, {"quantity": "a"}, mark=mark)[1]
    assert "], p = 0.010) and <a>" in text
    assert text.endswith("], p = 0.010)†.")


DESIGN = {"what": "groups", "change": "", "within": ""}


@pytest.mark.parametrize(
    ("row", "where", "between"),
    [
        ({}, "in HPH than in CTL", "between HPH and CTL"),
        ({"within": "at w1"}, "in HPH than in CTL at w1", "between HPH and CTL at w1"),
        ({"what": "factor"}, "at HPH than at CTL on average over the groups",
         "between HPH and CTL on average over the groups"),
        ({"what": "factor", "within": "in A"}, "at HPH than at CTL in A", "between HPH and CTL in A"),
        ({"what": "trend"}, "at HPH than at CTL by the trend", "from CTL to HPH by the trend"),
        ({"what": "interaction", "change": "2/1"}, "in HPH than in CTL, in the ratio 2/1",
         "between HPH and CTL in the ratio 2/1"),
        ({"what": "contrast"}, "by the contrast 'HPH'", "by the contrast 'HPH'"),
    ],
)  # fmt: skip
def test_where_an_effect_is(row, where, between):
    assert effects.where(pd.Series(ROW | DESIGN | row), True) == (where, between)
    if row == {"what": "factor"}:
        assert effects.where(pd.Series(ROW | DESIGN | row), False)[0] == "at HPH than at CTL"


def test_an_effect_is_called_by_its_sides_its_change_and_where_it_is():
    assert effects.effect_of(pd.Series(ROW)) == "HPH / CTL"
    assert effects.effect_of(pd.Series(ROW | DESIGN | {"reference": "", "within": "at w1"})) == "HPH at w1"
    assert effects.effect_of(pd.Series(ROW | DESIGN | {"change": "2/1"})) == "2/1: HPH / CTL"
    assert effects.change(pd.Series(ROW | {"unit": "1"})) == "10.0 → 20.0"


def test_ratios_of_few_degrees_of_freedom_are_counted_with_what_they_can_show():
    wide, wider = {"df": 3.9, "low": 1.0, "high": 4.0}, {"df": 2.0, "low": 1.0, "high": 2.25, "quantity": "a"}
    found = rows(DESIGN | wide, DESIGN | wider, DESIGN | {"df": 4.0, "quantity": "b"})
    (text,) = groups._few_degrees(found)
    assert text.startswith("HPH / CTL: 2 of 3 ratios rest on 2.0 to 3.9 degrees of freedom. Beside all other rows such")
    assert "by about 50 to 100 % or more" in text
    assert groups._few_degrees(rows({"df": 2.0})) == []
    assert groups._few_degrees(rows(DESIGN | {"df": 4.0})) == []


def test_the_animal_that_moves_an_effect_most_and_the_ratios_that_leave_their_intervals():
    found = primary({"without": "m1", "ratio without": 2.5}, {"quantity": "a", "without": "m2", "ratio without": 1.0},
                    {"quantity": "b", "without": "m3", "ratio without": 2.8}, {"quantity": "c"})  # fmt: skip
    assert groups.influence(found, CALLED) == [
        "One animal moves an effect most: without m2, <a> is 1.00 times instead of 2.00; leaving out one animal "
        "takes 2 "
        "ratios out of their intervals."
    ]
    inside = primary({"without": "m1", "ratio without": 2.7}, {"other": "SU", "without": "m2", "ratio without": 1.9})
    assert groups.influence(inside, CALLED) == [
        "One animal moves an effect most: without m1, <R_T> (HPH / CTL) is 2.70 times instead of 2.00; without any one "
        "animal every ratio stays inside its interval."
    ]
    assert groups.influence(primary({}), CALLED) == []
    low = groups.influence(primary({"without": "m1", "ratio without": 1.5}), CALLED)
    assert "stays inside" in low[0]


def test_other_laws_are_told_where_they_lie_outside():
    beside = {"source": "tangent", "ratio": 3.0}
    found = primary({}, {"quantity": "a"}, others=(beside, beside | {"quantity": "a", "ratio": 2.7}))
    assert groups.other_laws(found, CALLED) == [
        "Outside the intervals of the linear wall lie <R_T> 3.00 times (tangent)."
    ]
    inside = primary({}, others=(beside | {"ratio": 1.5}, beside | {"source": "power", "ratio": 2.7}))
    assert groups.other_laws(inside, CALLED) == [
        "By the tangent wall and the power wall every ratio lies inside the intervals of the linear wall."
    ]
    assert groups.other_laws(primary({}), CALLED) == []
    two = primary({}, {"other": "SU"}, others=(beside, beside | {"other": "SU", "ratio": 1.4}))
    assert groups.other_laws(two, CALLED) == [
        "Outside the intervals of the linear wall lie <R_T> 3.00 times (tangent; HPH / CTL) and <R_T> 1.40 "
        "times (tangent; "
        "SU / CTL)."
    ]


def test_fits_that_judge_otherwise_than_posteriors_are_told():
    fits = {"estimates": "posterior", "fits ratio": 2.9, "fits low": 1.35, "fits high": 6.4}
    wide = {"fits ratio": 2.0, "fits low": 0.9, "fits high": 4.4}
    (said,) = groups.by_fits(primary(fits | {"quantity": "a", "p": 0.13}, fits, fits | wide), CALLED)
    assert said == (
        "Fits of the same animals judge otherwise of <a> in HPH, which they show (2.9 times [1.4, 6.4]) and <R_T> in "
        "HPH, which they do not show (2.0 times [0.9, 4.4]). Posteriors decide: they follow errors that are too large "
        "for a straight line."
    )
    untested = fits | {"fits low": 0.0, "fits high": np.inf}
    assert "do not show (2.90 times [no limits])" in groups.by_fits(primary(untested), CALLED)[0]
    assert groups.by_fits(primary(fits, fits | wide | {"p": 0.3}), CALLED) == [
        "Fits of the same animals show the same effects as their posteriors."
    ]
    assert groups.by_fits(primary({}, {"fits ratio": np.nan}), CALLED) == groups.by_fits(primary({}), CALLED) == []
    assert groups.beside(primary(), CALLED) == []


def test_what_could_not_be_told_is_told_once_and_of_what():
    missed = SimpleNamespace(finding=OTHER(text="no cell"), quantities=("R_T",))
    assert groups.not_told(primary({}, untold=(missed,)), CALLED) == ["no cell"]
    assert groups.not_told(primary({}, {"quantity": "a"}, untold=(missed,)), CALLED) == ["no cell (of <R_T>)"]
    left = page._not_compared(primary({}, left_out={"a": "too few", "b": "no animal", "c": "too few"}), CALLED)
    assert left == [("Not compared", "<a>, <c>: too few; <b>: no animal.")]
    assert page._not_compared(primary({}), CALLED) == []


def test_headings_of_the_forest_name_the_effect_where_there_are_several():
    row = pd.Series(ROW)
    assert forest._heading(row, False) == "Q"
    assert forest._heading(row, True) == "Q: HPH"
    assert forest._heading(pd.Series(ROW | {"other": "h" * 30}), True) == f"Q: {'h' * 19}…"
    assert forest._heading(pd.Series(ROW | DESIGN), True) == "HPH / CTL"
    assert forest._heading(pd.Series(ROW | DESIGN | {"reference": ""}), True) == "HPH"
    assert forest._heading(pd.Series(ROW | DESIGN | {"change": "w2/w1"}), True) == "w2/w1: HPH / CTL"
    long = forest._heading(pd.Series(ROW | DESIGN | {"other": "o" * 38, "reference": "r" * 39}), True)
    assert long == f"{'o' * 38}\n/\n{'r' * 37}…"


def dose_cohort(order, levels, subjects, groups_of, occasion=None):
    results = [SimpleNamespace(name=name, group=group) for name, group in groups_of.items()]
    second = SimpleNamespace(name="week", order=order, levels=levels)
    design = SimpleNamespace(occasion=occasion)
    return SimpleNamespace(second=second, subjects=subjects, results=results, design=design, reference="CTL")


def test_points_of_occasions_are_ratios_of_an_animals_own_means():
    levels = {"a": "1", "b": "2", "b2": "2", "c": "1", "d": "3", "e": "1", "f": "2"}
    subjects = {"a": "m1", "b": "m1", "b2": "m1", "c": "m2", "d": "m2", "e": "m3", "f": "m3"}
    group = dict.fromkeys("abcd", "CTL") | {"b2": "CTL", "e": "HPH", "f": "HPH"}
    cohort = dose_cohort(["1", "2", "3"], levels, subjects, group, "week")
    values = pd.Series({"a": 2.0, "b": 4.0, "b2": 16.0, "c": 3.0, "d": 6.0, "e": 1.0, "f": 9.0, "g": 5.0})
    row = {"other": "week 2", "reference": "week 1", "change": "", "what": "factor"}
    assert forest._changes(cohort, pd.Series(row), values) == pytest.approx({"m1": 4.0, "m3": 9.0})
    later = row | {"other": "week 3"}
    assert forest._changes(cohort, pd.Series(later), values) == pytest.approx({"m2": 2.0})
    dots = forest._of_occasions(cohort, pd.Series(row), values)
    assert [(round(one[0], 9), one[1], one[2], one[3]) for one in dots] == [
        (4.0, "CTL", "m1", "m1: 4.00"), (9.0, "HPH", "m3", "m3: 9.00")
    ]  # fmt: skip
    between = row | {"other": "HPH", "reference": "CTL", "change": "2/1", "what": "interaction"}
    dots = forest._of_occasions(cohort, pd.Series(between), values)
    assert [round(one[0], 9) for one in dots] == [1.0, 2.25]
    assert forest._of_occasions(cohort, pd.Series(between | {"reference": "SU"}), values) == []
    assert forest._changes(SimpleNamespace(second=None), pd.Series(row), values) == {}


def test_points_of_groups_are_animals_over_the_mean_of_the_reference():
    group = {"a": "CTL", "b": "CTL", "b2": "CTL", "c": "HPH", "d": "SU"}
    cohort = dose_cohort([], {}, {"a": "a", "b": "b", "b2": "b", "c": "c", "d": "d"}, group)
    values = pd.Series({"a": 1.0, "b": 2.0, "b2": 8.0, "c": 6.0, "d": 9.0})
    dots = forest._of_groups(cohort, pd.Series(ROW), values, "mmHg")
    assert [(round(one[0], 9), one[1], one[2], one[3]) for one in dots] == [
        (0.5, "CTL", "a", "a: 1.00 mmHg"), (2.0, "CTL", "b", "b: 4.00 mmHg"), (3.0, "HPH", "c", "c: 6.00 mmHg")
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("standing", "animals", "others", "words_"),
    [
        (Standing.UNKNOWN, 1, (9.0,), "Whether it was sicker than the others cannot be said: its pressure is not"),
        (Standing.UNKNOWN, 2, (9.0,), "Whether they were sicker than the others cannot be said: their pressures are"),
        (Standing.UNKNOWN, 2, (), "they were sicker than the others cannot be said: no animal of the group is left."),
        (Standing.ABOVE, 1, (9.0, 12.0), "HPH looks healthier there than it is"),
        (Standing.HIGHER, 1, (9.0, 12.0), "HPH looks healthier there than it is"),
        (Standing.BELOW, 1, (9.0, 12.0), "HPH looks sicker there than it is"),
    ],
)  # fmt: skip
def test_missing_animals_are_told_with_what_that_may_do(standing, animals, others, words_):
    names = tuple(f"m{n}" for n in range(animals))
    missing = SimpleNamespace(
        standing=standing, animals=names, others=others, pressures=(20.0,) * animals, group="HPH", count=7, lost=False
    )
    text = problems.missing_text(missing, "linear", False)
    assert text.startswith(f"The comparison by the linear wall misses {animals} of 7 animals of HPH (m0")
    assert words_ in text
    if others and standing is not Standing.UNKNOWN:
        assert f"Measured mPAP 20.0 mmHg, {standing} (9.00 to 12.0 mmHg):" in text
    missing.lost = True
    assert problems.missing_text(missing, "linear", True).startswith(
        f"The comparison of the groups misses {animals} of 7 recordings of HPH"
    )
    assert problems.missing_text(missing, "", False).startswith("The comparison of the groups misses")


def test_findings_of_one_kind_are_joined_where_more_than_four_have_them():
    kind = OTHER(text="late")
    few = {f"m{n}": [kind] for n in range(4)}
    assert problems._looks(few) == [f"m{n}: late" for n in range(4)]
    many = {f"m{n}": [kind] for n in range(5)} | {"m0": [kind, kind]}
    assert problems._looks(many) == ["m0, m1, m2, m3 and m4; of m0: late"]
    assert problems._looks({f"m{n}": [kind] for n in range(7)}) == ["m0, m1, m2, m3 and 3 more; of m0: late"]
    assert problems._looks({}) == []


@pytest.mark.parametrize(
    ("over", "share", "said"),
    [(2.5, 0.2, "2.5 times what the best law leaves"), (2.0, 0.2, "20 % of the pulse pressure")],
)
def test_a_law_that_misses_is_told_against_the_best_or_the_pulse(over, share, said):
    table = pd.DataFrame({"animal": ["a", "b"], "RMSE": [1.0, 3.0], "over best": [9.0, over], "share": [0.9, share]})
    text = problems._miss("linear", table, " of flow")
    assert text.startswith(
        f"The linear wall misses the data of a and b: it leaves up to 3.0 mmHg of flow, {said}. Do not use"
    )


def fit(**variables):
    names = variables.pop("names")
    return xr.Dataset({key: ("parameter", np.array(value)) for key, value in variables.items()}, {"parameter": names})


def test_what_is_open_held_or_at_a_bound_is_counted_over_fits():
    fits = [
        fit(names=["R1", "c"], free=[True, False], determined=[False, False], at_bound=[True, False], value=[1.0, 2.0]),
        fit(names=["R1", "c"], free=[True, False], determined=[True, False], at_bound=[False, False], value=[1.0, 2.5]),
        fit(names=["R1", "c"], free=[True, False], determined=[False, False], at_bound=[True, False], value=[1.0, 2.0]),
    ]  # fmt: skip
    cohort = SimpleNamespace(walls=["linear"], calibrations=lambda wall: fits, single=False)
    assert limits._open(cohort, "linear", {"R1": "R₁"})[0].startswith(
        "The data do not determine R₁ in 2 of 3 (linear wall;"
    )
    held, stopped = limits._held(cohort, {"R1": "R₁"})
    assert held == "Held, not fitted (linear wall): c = 2.00 and c = 2.50; its results hold for that value."
    assert stopped.startswith("Stopped at a bound of the search: R₁ in 2 of 3 (linear wall);")
    one = SimpleNamespace(walls=["linear"], calibrations=lambda wall: fits[:1], single=True)
    assert limits._open(one, "linear", {})[0].startswith("The data do not determine R1 (linear wall;")
    assert limits._open(SimpleNamespace(calibrations=lambda wall: fits[1:2], single=True), "linear", {}) == []


def imaged(*pressures, repeated=False):
    results = [SimpleNamespace(network=SimpleNamespace(pressure=one)) for one in pressures]
    return limits._image_pressure(SimpleNamespace(results=results, repeated=repeated))[0]


def test_the_pressures_of_images_are_told_with_how_many_are_unknown():
    assert imaged(0.0, 0.0).startswith("The image's pressure is not known;")
    assert imaged(6.3, 6.3) == "Radii are those at the image's pressure, 6.30 mmHg."
    assert imaged(6.3, 10.0, 0.0) == (
        "Radii are those at the image's pressure, 6.30 to 10.0 mmHg. Of 1 of 3 animals it is "
        "not known: "
        "their radii are taken as those at 0 mmHg."
    )
    assert "Of 2 of 3 recordings" in imaged(0.0, 10.0, 0.0, repeated=True)


@pytest.mark.parametrize(
    ("left", "error", "said"),
    [
        (1.0, 0.5, "2.0 times the error of the averaged cycle (0.50 mmHg): what the beats' scatter explains"),
        (1.01, 0.5, "2.0 times the error of the averaged cycle (0.50 mmHg): not noise but the model's error"),
    ],
)
def test_what_a_law_leaves_is_set_against_the_error_of_the_cycle(left, error, said):
    table = pd.DataFrame(
        {"wall": ["linear", "tangent", "linear"], "RMSE": [left, 9.0, left], "error": [error, 1.0, error]}
    )
    cohort = SimpleNamespace(misfits=table, single=False, law=lambda wall: SimpleNamespace(compared="pressure"))
    assert limits._residual(cohort, "linear") == [f"The linear wall leaves 1.0 mmHg (median), {said}."]
    cohort.single, cohort.law = True, lambda wall: SimpleNamespace(compared="flow")
    assert limits._residual(cohort, "linear")[0].startswith(
        "The linear wall leaves 1.0 mmHg of flow (its pulse counted"
    )
    table["error"] = np.nan
    assert limits._residual(cohort, "linear")[0].endswith("; how well the cycle itself is known is not.")


def wedged(*known, single=False):
    results = [SimpleNamespace(recording={"wedge_pressure": 1.0} if one else {}) for one in known]
    return limits.no_wedge(SimpleNamespace(results=results, single=single))


def test_recordings_without_a_wedge_pressure_are_counted():
    assert wedged(True, True) == []
    assert wedged(False, single=True) == []
    assert wedged(False, False)[0].startswith("No wedge pressure is given: PVR")
    assert wedged(False, True, False)[0].startswith("No wedge pressure of 2 of 3 recordings is given: PVR")


def test_evidence_is_told_for_either_law_and_where_animals_differ():
    def said(single=False, untrusted=(), **ratios):
        one = walls.Evidence("tangent", ratios, list(untrusted))
        cohort = SimpleNamespace(single=single, results=[None] * (len(ratios) + len(untrusted)))
        return walls._evidence(one, "linear", cohort)

    assert said(a=30.0, b=25.0) == (
        "The posteriors speak for the linear wall against the tangent wall: by their evidences the recording is "
        "30 and 25 "
        "times as likely under the linear law as under the other; 20 times or more for the linear law in 2 of 2 "
        "animals."
    )
    against = said(a=1 / 30, b=1 / 40)
    assert against.startswith(
        "The posteriors speak for the tangent wall against the linear wall: by their evidences the"
    )
    assert " is 30 and 40 times as likely under the tangent law" in against
    assert against.endswith("20 times or more for the tangent law in 2 of 2 animals.")
    differ = said(a=30.0, b=1 / 40)
    assert differ.startswith("The animals differ between the linear and the tangent wall:")
    assert differ.endswith("for the linear law in 1 of 2 animals and for the tangent law in 1 of 2 animals.")
    open_ = said(a=2.0, b=3.0)
    assert open_.startswith("The posteriors do not decide between the linear and the tangent wall:")
    assert open_.endswith("20 times or more in none of 2 animals.")
    assert said(single=True, a=2.0).endswith("as under the other.")
    assert said(a=2.0, untrusted=["b", "c"]).endswith(
        " Not counted are 2 of 3 animals with a posterior that cannot be trusted."
    )


def differences(*changes):
    row = {"wall": "tangent", "n": 5, "mean": 12.0, "low": 8.0, "high": 16.0, "price": 2.5, "residuals": 9.5,
           "residuals low": 5.5, "residuals high": 13.5, "speaks for": "linear"}  # fmt: skip
    return pd.DataFrame([row | one for one in changes])


def test_residuals_speak_for_laws_or_leave_them_open():
    table = differences({}, {"wall": "power", "speaks for": "power", "mean": -12.0, "low": -16.0, "high": -8.0},
                        {"wall": "vein", "speaks for": "", "n": 4})  # fmt: skip
    assert walls._residuals(table, "linear") == [
        "The residuals speak for the linear wall against the tangent wall (AICc).",
        "The residuals speak for the power wall against the linear wall (AICc).",
        "The residuals do not decide between the linear and the vein wall (AICc).",
    ]


@pytest.mark.parametrize(
    ("weighed", "residuals", "compared", "drawn", "caveat"),
    [
        (False, [], False, [], []),
        (False, [], False, [False], ["looks"]),
        (False, [], False, [True], ["still"]),
        (False, [], False, [True, False], ["looks"]),
        (True, [], True, [], ["still"]),
        (True, [], False, [True], ["still"]),
        (False, ["R"], False, [], []),
        (False, ["R"], True, [], ["looks"]),
        (True, ["R"], True, [True], ["looks"]),
    ],
)
def test_the_answer_to_which_wall_ends_with_what_can_look_like_one(
    monkeypatch, weighed, residuals, compared, drawn, caveat
):
    laws = ["linear", "power", "tangent"]
    exponents = dict(zip(laws, [SimpleNamespace(drawn=one) for one in drawn], strict=False))
    found = [walls.Evidence("power", {"a": 2.0}, []), walls.Evidence("tangent", {}, ["a"])][not weighed :]
    monkeypatch.setattr(walls, "evidences", lambda cohort, law: found)
    monkeypatch.setattr(walls, "_evidence", lambda one, law, cohort: f"E {one.wall} {law}.")
    asked = []
    monkeypatch.setattr(walls, "_by_residuals", lambda cohort, law, known: asked.append((law, known)) or residuals)
    monkeypatch.setattr(walls, "exponent_of", lambda cohort, wall: exponents.get(wall))
    monkeypatch.setattr(walls, "_exponent", lambda wall, one, repeated: f"X {wall} {repeated}.")
    cohort = SimpleNamespace(walls=laws, compared=compared, repeated=True)
    texts = {"looks": walls._LOOKS_LIKE, "still": walls._STILL_LOOKS_LIKE}
    expected = ["E power linear."] * weighed + residuals + [f"X {wall} True." for wall in exponents]
    assert walls.wall_answer(cohort, "linear") == (
        "Which wall?", " ".join([*expected, *(texts[one] for one in caveat)])
    )  # fmt: skip
    assert asked == [("linear", {"power"} if weighed else set())]
    cohort = SimpleNamespace(walls=["linear"], compared=(), repeated=False)
    told = "Only the linear wall was fitted; nothing is known of others."
    assert (told in walls.wall_answer(cohort, "linear")[1]) is True
    assert told not in walls.wall_answer(SimpleNamespace(walls=laws, compared=(), repeated=False), "linear")[1]


def test_exponents_say_their_side_animals_and_bounds():
    def said(repeated=False, **changes):
        one = SimpleNamespace(
            **{"name": "m", "linear": 0.5, "value": 0.8, "low": 0.6, "high": 1.0, "side": 1, "below": 0, "above": 0,
               "drawn": False, "animals": 5} | changes
        )  # fmt: skip
        return walls._exponent("power", one, repeated)

    assert said() == (
        "The wall stiffens more than a linear one: m = 0.80 [0.60, 1.00] (power law; 0.5 is linear; 5 animals pooled)."
    )
    assert said(side=-1).startswith("The wall stiffens less than a linear one: ")
    assert said(side=0).startswith("It is open whether the wall stiffens more or less than a linear one: ")
    assert said(repeated=True, drawn=True, below=2, above=1).endswith(
        "(power law, posteriors; 0.5 is linear; 5 animals pooled, the first recording of each, of them 2 beyond "
        "the lower "
        "bound of the search and 1 beyond the upper bound of the search)."
    )
    assert said(animals=1, above=1).endswith("(power law; 0.5 is linear; the search stopped at its upper bound).")


def value(size, **attrs):
    return xr.DataArray(size, attrs=attrs)


def test_values_are_written_with_intervals_and_units():
    assert value_text(value(2.0, units="mmHg")) == "2.00 mmHg"
    assert value_text(value(2.0, units="1")) == "2.00"
    assert value_text(value(2.0, units="cm", interval_low=1.0, interval_high=3.0)) == "2.0 [1.0, 3.0] cm"
    assert value_text(value(2.0, units="cm", interval_low=1.0)) == "2.00 cm"
    assert value_text(value(2.0, units="cm"), with_unit=False) == "2.00"
    assert probability(0.2) == "p = 0.20"
    assert probability(1e-9).startswith("p ≤ 0.000")
    assert unit("mmHg2 s2/cm2") == "mmHg² s²/cm²"
    assert unit("1") == ""
    assert (name_and_unit("R_T [mmHg s/ml]"), name_and_unit("a")) == (("R_T", "mmHg s/ml"), ("a", ""))
    assert column_label("a [1]") == "a"
    assert table_rows(pd.DataFrame({"a [cm2]": [1.23456], "b": [True]})) == (("a [cm²]", "b"), [("1.235", "yes")])
    assert table_rows(pd.DataFrame({"a": [1.23456]}), 2)[1] == [("1.2",)]


def test_frictions_are_called_by_their_law():
    assert friction_words("BoundaryLayer", {}) == "a boundary layer (local radius)"
    assert friction_words("BoundaryLayer", {"reference_radius": 0.05}) == "a boundary layer (fixed radius 0.0500 cm)"
    assert friction_words("Poiseuille", {"x": 1}) == "Poiseuille flow"
    assert friction_words("PowerLaw", {"profile_power": 2.0, "b": 3}) == "a power-law profile (profile power 2.00, b 3)"
    assert friction_words("Own", {}) == "Own"


def test_the_softness_of_an_artery_is_its_growth_by_the_first_mmhg():
    assert animal_answer._softness(value(50.0)) == " So a large artery grows by 2.0 % in radius with the first mmHg."
    both = animal_answer._softness(value(50.0, interval_low=40.0, interval_high=80.0))
    assert both == " So a large artery grows by 2.00 [1.25, 2.50] % in radius with the first mmHg."
    half = animal_answer._softness(value(50.0, interval_low=40.0))
    assert "2.0 % in radius" in half


def coupled(low, high, findings=()):
    data = xr.Dataset(
        {"E_es": value(2.0), "E_a": value(1.0), "coupling": value(2.0, interval_low=low, interval_high=high)}
    )
    measured = SimpleNamespace(quantities=data)
    return animal_answer._coupled(SimpleNamespace(measured=measured, findings=findings), CALLED)


def test_ventricle_and_load_are_judged_where_their_interval_lies_on_one_side():
    assert coupled(1.001, 3.0)[0][1].endswith("By this beat the ventricle is stiffer than its load.")
    assert coupled(0.2, 0.999)[0][1].endswith("By this beat its load is stiffer.")
    for low, high in ((1.0, 3.0), (0.2, 1.0), (np.nan, np.nan)):
        assert coupled(low, high)[0][1].endswith("Whether it keeps up with its load is open.")
    unlike = SimpleNamespace(code=animal_answer.UNLIKE.code)
    assert coupled(1.1, 3.0, [unlike])[0][1].endswith(
        "No usual heart makes this pressure from this flow, so these numbers may be far off."
    )
    none = SimpleNamespace(measured=SimpleNamespace(quantities=xr.Dataset()), findings=())
    assert animal_answer._coupled(none, CALLED) == []
    assert _single_beat({"single_beat": np.nan}).endswith("finds no E_es/E_a.")
    assert _single_beat({"single_beat": 1.234}).endswith("makes E_es/E_a 1.2.")


def test_starts_of_a_fit_are_told_by_how_many_agree():
    def said(*agree):
        return sections._starts(xr.Dataset({"start_agrees": ("start", np.array(agree))}))

    assert said(True) == "One start was made."
    assert said(True, True).startswith("All 2 starts of the optimization came to this optimum, or into its bowl.")
    assert said(True, False, True) == (
        "Only 2 of 3 starts of the optimization came to this optimum or into its bowl; the others are listed below."
    )


def test_parameters_at_a_bound_and_open_ones_are_named_by_their_symbols():
    table = pd.DataFrame(
        {"free": [True, True, True, False], "at_bound": [True, True, False, True],
         "determined": [True, True, False, False], "value": [1.0, 9.0, 3.0, 1.0], "lower": 1.0, "upper": 9.0},
        index=list("abcd"),
    )  # fmt: skip
    assert sections._limits(table, {"a": "α"}) == [
        "The search ended with α at its lower bound (1.00) and b at its upper bound (9.00).",
        "The data do not determine c; other values fit about as well.",
    ]
    assert sections._limits(table[1:2], {})[1] == "The data determine every free parameter."
    assert sections._nearer_bound(pd.Series({"value": 5.0, "lower": 1.0, "upper": 9.0})) == "upper"
    row = pd.Series({"value": 2.0, "unit": "mmHg", "free": False})
    assert sections._with_error(row) == "2.00 mmHg (held)"
    free = {"value": 2.0, "unit": "1", "free": True, "standard_error": 0.5}
    assert sections._with_error(pd.Series(free)) == "2.00 ± 0.50"
    assert sections._with_error(pd.Series(free | {"standard_error_correlated": 0.25})) == "2.00 ± 0.25"


def test_beds_and_quality_of_a_fit_in_words():
    fitted = xr.Dataset({"R_T": 80.0, "a": 0.25, "C_p": 0.002, "RMSE": 0.5, "S": 32.0, "N": 128})
    assert sections._beds(fitted) == (
        "Vascular beds: total resistance R_T = 80.0 mmHg s/ml, of which 25.0 % proximal (ratio a), compliance 0.00200 "
        "ml/mmHg."
    )
    assert sections._beds(xr.Dataset({"R_T": 80.0})) == "Vascular beds: total resistance R_T = 80.0 mmHg s/ml."
    result = SimpleNamespace(measured=SimpleNamespace(quantities={"pPAP": 12.5}))
    assert sections._quality(result, fitted) == (
        "Fit: the pressure differs from the measured one by 0.500 mmHg (root mean square), 4.0 % of the pulse "
        "pressure; S ="
        " 32.0 mmHg² over 128 samples."
    )
    flow = fitted.assign(flow_residual=("time", [0.03, 0.04], {"units": "ml/s"})).assign_attrs(enters="pressure")
    assert sections._quality(result, flow).startswith(
        "Fit: the flow differs from the measured one by 0.0354 ml/s (root mean square), 4.0 % of its pulse; S = 32.0"
    )


def test_beats_are_told_with_the_causes_of_those_rejected():
    def said(*cause):
        data = {"kept": ("beat", [one == "" for one in cause]), "cause": ("beat", list(cause))}
        return sections._beats_caption(xr.Dataset(data))

    assert said("", "late", "", "odd", "odd").startswith(
        "5 beats detected, 2 averaged; 2 rejected: odd; 1 rejected: late. Above:"
    )
    assert said("", "").startswith("2 beats detected, 2 averaged. Above:")


def test_titles_count_notes():
    def title(count, synthetic=False):
        return sections._title(SimpleNamespace(name="m", group="CTL", synthetic=synthetic, findings=[1] * count))

    assert title(0) == "m (CTL)"
    assert title(1) == "m (CTL, 1 note)"
    assert title(2, True) == "m (CTL, synthetic, 2 notes)"


def test_p_that_come_too_often_are_told_in_percent():
    def said(rate):
        return group_sections._remarks(primary({}, assurance=Assurance(rate, 0.99, 2.345, 4)))

    assert said(0.06) == []
    assert (
        said(0.0612)[0]
        .items[0]
        .startswith(
            "The groups differ in spread by up to a factor of 2.3, and the smallest has 4 animals: cohorts like "
            "this one "
            "without any effect have a row with p < 0.05 in 6 % of cases instead of 5 %."
        )
    )
    assert group_sections._remarks(primary({})) == []


def a_plan(needed, pairs=None, **spread):
    settings = Planning(effect=1.5, power=0.8, pairs=pairs)
    spreads = (Spread("R_T", (0.2, 0.35), **spread), Spread("own", (0.123, 0.4)))
    powers = pd.DataFrame({"R_T": [0.5, 0.9], "own": [0.1, 0.2]}, pd.Index([3, 60], name="animals"))
    frame = pd.DataFrame({"as it is": needed, "errors halved": [4.0, np.nan]}, ["R_T", "own"])
    return Plan(settings, spreads, "a pilot", powers, frame)


def test_a_plan_is_told_in_animals_or_pairs_with_what_it_does_not_know():
    said = planned.plan_texts(a_plan([7.0, np.nan]))
    assert said[0].startswith("To show a ratio of 1.5 with a power of 0.80, each of two groups needs: 7 for ")
    assert said[1] == "More than 60 for own."
    assert "the family of all 2, with the p" in said[2]
    assert said[3].startswith("How far an animal differs from day to day is not known")
    assert said[4].startswith("How much of the spread is error of measurement is not known")
    assert len(said) == 5
    none = planned.plan_texts(a_plan([np.nan, np.nan], error=0.1))
    assert none[0] == "No quantity shows a ratio of 1.5 with 60 animals in each group."
    assert len(none) == 3
    pairs = planned.plan_texts(a_plan([7.0, 9.0], pairs=0.5, within=0.1))
    assert ", pairs are needed: 7 for" in pairs[0]
    assert " and 9 for own own." in pairs[0]
    assert "its two true values are taken as correlated by 0.5." in pairs[2]
    animals = (0.2**2 + 0.35**2) / 2
    alike = animals / (animals + 0.01)
    assert pairs[3] == (f"In this study true values of one animal on two occasions are correlated by: R_T {alike:.2f}.")
    table = planned._needed(a_plan([7.0, np.nan]))
    assert table.rows == [("R_T", "7", "4"), ("own", "more", "more")]
    assert table.note == "more: more than 60."
    spreads = planned._spreads(a_plan([7.0, 8.0], error=0.05, shared=0.021, within=0.111))
    assert spreads.rows == [("R_T", "20 %", "35 %", "11 %", "5 %", "2 %"), ("own", "12 %", "40 %", "0 %", "0 %", "0 %")]


def test_symbols_are_explained_where_they_stand_as_words():
    assert symbol("R_T", {"R_T": "R_T = R₁ + R₂"}) == "R_T"
    assert symbol("x", {}) == "x"
    assert words("own", {"own": "my number, per gram"}) == "my number"
    assert words("own", {}) == "own"
    of = explained({"R_T": "resistance", "τ": "time", "a": "share"})
    assert str(of("R_T")) == '<abbr tabindex="0" title="resistance">R_T</abbr>'
    assert str(of("a [1]")) == '<abbr tabindex="0" title="share">a</abbr> [1]'
    assert str(of("of a τ R_T C, xR_T & R_T/2")) == (
        'of a <abbr tabindex="0" title="time">τ</abbr> <abbr tabindex="0" title="resistance">R_T</abbr> C, xR_T '
        "&amp; R_T/2"
    )
    assert str(explained({})("a < b")) == "a &lt; b"


def test_the_decay_is_told_with_how_unlike_the_models_is():
    frames = {
        "measured": pd.DataFrame({"tau [s]": [0.1, 0.4], "group": ["CTL", "CTL"]}),
        "linear": pd.DataFrame({"tau [s]": [0.2, 0.3], "tau_plain [s]": [0.5, 0.5], "group": ["CTL", "CTL"]}),
    }  # fmt: skip
    described = pd.concat([frame.assign(source=name, animal=["a", "b"]) for name, frame in frames.items()])
    cohort = SimpleNamespace(described=described, cells={"CTL": ("CTL", "", [])}, single=False)
    assert page._means(cohort, "measured", "tau") == pytest.approx({"CTL": 0.2})
    assert page._means(cohort, "measured", "none") == {}
    assert page.decay(cohort, "linear") == (
        "The measured pressure falls in diastole with τ = 0.200 s in CTL. The model's R_T C_T is "
        "not the time of this decay."
    )
    near = described.assign(**{"tau [s]": [0.2, 0.2, 0.23, 0.2299]})
    cohort.described, cohort.single = near, True
    assert page.decay(cohort, "linear") == "The measured pressure falls in diastole with τ = 0.200 s."
