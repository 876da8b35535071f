"""Rules of comparisons by arithmetic on few animals: shares of errors, degrees of freedom, plans, designs, limits."""

from math import comb
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy import stats

from vasowave.cohort import (
    balanced,
    comparison,
    planning,
    pooling,
    power,
    primary,
    simultaneous,
    table,
    two_groups,
    walls,
)
from vasowave.cohort.cohort import Cohort, typical_animal
from vasowave.cohort.contrast import Cells, Contrast, Untold, told_and_not, untold_findings
from vasowave.cohort.design import Design, covariate_columns
from vasowave.cohort.designed import Modeled, _codes, _image_unknown, _subjects
from vasowave.cohort.estimates import Estimates, _estimates, image_unknown, shared_error
from vasowave.cohort.mixed import Effect, MixedFit, is_diagonal
from vasowave.cohort.planning import Planning, Spread
from vasowave.cohort.power import PlannedStudies
from vasowave.cohort.variables import Variable
from vasowave.cohort.votes import Ballots, differences
from vasowave.cohort.walls import evidences
from vasowave.errors import InputError

RNG = np.random.default_rng(3)


def estimates(logs, errors, image, label, told=False):
    """Return estimates of which only the image is shared."""
    count = len(logs)
    shared = np.array([image, np.zeros(count), np.zeros(count)])
    labels = np.array([label, np.arange(count), np.arange(count)])
    return Estimates(np.array(logs, float), np.array(errors, float), shared, labels, "fit", told, np.zeros(len(logs)))


ONE = estimates([1.0, 2.0, 4.0, 5.0, 9.0], [0.1, 0.2, 0.3, 0.4, 0.5], [0.3, 0.5, 0.2, 0.4, 0.6], [0, 0, 1, 1, 1])
OTHER = np.array([False, False, False, True, True])


def test_what_animals_share_counts_by_how_it_moves_the_groups_apart():
    zero = (0 - 2 / 3) ** 2 * (0.09 + 0.25) / 2
    one = (1 - 1 / 3) ** 2 * (0.04 + 0.16 + 0.36) / 3
    assert shared_error(ONE, OTHER) == pytest.approx(np.sqrt(zero + one))
    expected = np.diag([0.01, 0.04, 0.09, 0.16, 0.25])
    expected[:2, :2] += np.outer([0.3, 0.5], [0.3, 0.5])
    expected[2:, 2:] += np.outer([0.2, 0.4, 0.6], [0.2, 0.4, 0.6])
    assert ONE.covariance == pytest.approx(expected)
    part = ONE.of(np.array([True, False, True, False, True]))
    assert (part.logs.tolist(), part.shared[0].tolist(), part.label[0].tolist()) == (
        [1, 4, 9],
        [0.3, 0.2, 0.6],
        [0, 1, 1],
    )
    mean = ONE.by_animal(["b", "a", "b", "c", "b"])
    assert mean.logs == pytest.approx([2.0, 14 / 3, 5.0])
    assert mean.errors == pytest.approx([0.2, np.sqrt(0.01 + 0.09 + 0.25) / 3, 0.4])
    assert mean.shared[0] == pytest.approx([0.5, 1.1 / 3, 0.4])
    assert mean.label[0].tolist() == [0, 0, 1]


def test_an_image_is_unknown_where_it_moves_groups_more_than_animals_of_their_own_would():
    assert image_unknown(ONE, OTHER, "linear")  # twice (2/3)² against 1/2 + 1/3
    assert not image_unknown(ONE, OTHER, "measured")
    assert not image_unknown(ONE._replace(image_error_known=True), OTHER, "linear")
    own = estimates([1.0] * 4, [0.1] * 4, [0.1] * 4, [0, 1, 2, 3])
    assert not image_unknown(own, np.array([False, False, True, True]), "linear")
    group = estimates([1.0] * 4, [0.1] * 4, [0.1] * 4, [0, 0, 1, 1])
    assert image_unknown(group, np.array([False, False, True, True]), "linear")
    both = estimates([1.0] * 4, [0.1] * 4, [0.1] * 4, [0, 0, 0, 0])
    assert not image_unknown(both, np.array([False, False, True, True]), "linear")


def test_an_error_is_divided_into_what_is_shared_by_several_and_the_rest():
    label = np.array([[0, 0, 1], [0, 1, 2], [0, 1, 2]])
    share = np.array([[0.64, 0.36, 0.5], [0.1, 0.1, 0.1], [0, 0, 0]])
    found = _estimates((np.zeros(3), np.array([0.5, 1.0, 2.0]), np.ones(3)), share, label, "fit", True)
    assert found.shared[0] == pytest.approx([0.4, 0.6, 0.0])
    assert found.shared[1:] == pytest.approx(np.zeros((2, 3)))
    assert found.errors == pytest.approx([0.3, 0.8, 2.0])


def test_means_without_errors_are_plain_and_a_difference_has_welchs_freedom():
    first, second = (
        pooling.pooled_means(np.array([1.0, 2, 6]), np.zeros(3)),
        pooling.pooled_means(np.array([4.0, 8]), np.zeros(2)),
    )
    assert (first.value, first.error, first.freedom, first.between) == pytest.approx(
        (3.0, np.sqrt(7 / 3), 2.0, np.sqrt(7))
    )
    apart = pooling.difference(first, second, 0.5)
    assert float(apart.value) == 3.0
    variance = 7 / 3 + 4.0 + 0.25
    assert float(apart.error) == pytest.approx(np.sqrt(variance))
    assert float(apart.freedom) == pytest.approx(variance**2 / ((7 / 3) ** 2 / 2 + 16 / 1))
    assert float(apart.p) == pytest.approx(2 * stats.t.sf(3 / np.sqrt(variance), apart.freedom))
    for values, errors in (([1.0], [0.1]), ([2.0, 2.0], [0.0, 0.0])):
        with pytest.raises(InputError, match=r"needs two animals|nothing to pool"):
            pooling.pooled_mean(np.array(values), np.array(errors))
    scale = pooling.pooled_mean(np.array([1.0, 1.1, 0.9, 5.0]), np.array([0.1, 0.1, 0.1, 4.0]))
    weights = 1 / (scale.between**2 + np.array([0.01, 0.01, 0.01, 16.0]))
    assert scale.value == pytest.approx((weights * [1.0, 1.1, 0.9, 5.0]).sum() / weights.sum())


def test_an_effect_has_students_p_and_interval():
    one = Effect(0.5, 0.2, 7.5)
    assert one.p == pytest.approx(2 * stats.t.sf(2.5, 7.5))
    reach = stats.t.ppf(0.995, 7.5) * 0.2
    assert one.ratio(0.01) == pytest.approx((np.exp(0.5), np.exp(0.5 - reach), np.exp(0.5 + reach)))
    assert Effect(-0.5, 0.2, np.inf).p == pytest.approx(2 * stats.norm.sf(2.5))
    assert is_diagonal(np.diag([1.0, 0.0, 2.0]))
    assert not is_diagonal(np.array([[1.0, 0.1], [0.1, 1.0]]))


def mixed(coefficients, plain, slopes, uncertainty, ignorant=None):
    none = np.zeros(0)
    plain = np.array(plain)
    inference = (none, 2 * plain, plain, np.array(slopes), np.array(uncertainty))
    return MixedFit(np.array(coefficients), *inference, none, none, none, 0.0, ignorant)


def test_the_freedom_of_an_effect_is_satterthwaites_and_no_less_than_without_errors():
    plain = [[0.5, 0.1], [0.1, 0.4]]
    slopes = [[[1.0, 0.2], [0.2, 0.5]], [[0.3, 0.0], [0.0, 0.1]]]
    uncertainty = [[0.02, 0.01], [0.01, 0.05]]
    c = np.array([1.0, -2.0])
    slope = np.array([c @ np.array(one) @ c for one in slopes])
    variance = c @ np.array(plain) @ c
    freedom = 2 * variance**2 / (slope @ np.array(uncertainty) @ slope)
    one = mixed([2.0, 0.5], plain, slopes, uncertainty)
    found = one.effect(c)
    assert (found.value, found.error, found.freedom) == pytest.approx((1.0, np.sqrt(2 * variance), freedom))
    assert mixed([2.0, 0.5], plain, slopes, np.zeros((2, 2))).effect(c).freedom == np.inf
    wide = one._replace(ignorant=mixed([0, 0], plain, slopes, np.array(uncertainty) / 4))
    assert wide.effect(c).freedom == pytest.approx(4 * freedom)
    assert (
        one._replace(ignorant=mixed([0, 0], plain, slopes, 4 * np.array(uncertainty))).effect(c).freedom
        == found.freedom
    )


def test_corrected_p_count_how_often_chance_is_judged_as_small():
    once, twice = np.array([0.1, 0.2, 0.3, 0.4]), np.array([0.05, 0.15, 0.25, 0.35])
    found = simultaneous._corrected(np.array([0.05, 0.2, 0.45, 0.9]), once, twice)
    assert found == pytest.approx([(1 + 0) / 5, (1 + 2) / 5, 1.0, 1.0])
    many = np.linspace(0.001, 1, 999)
    assert simultaneous._critical(many, many) == pytest.approx(many[47])
    assert simultaneous._critical(np.array([0.5]), np.array([0.5])) == 0.0


def test_correlations_are_shrunk_by_their_error():
    residuals = RNG.normal(size=(9, 3)) @ np.array([[1, 0.8, 0], [0, 1, 0], [0, 0, 1]])
    scaled = residuals / np.sqrt((residuals**2).sum(axis=0))
    raw = scaled.T @ scaled
    apart = ~np.eye(3, dtype=bool)
    error = ((1 - raw[apart] ** 2) ** 2).sum() / (7 - 1)
    shrunk = min(1.0, error / (raw[apart] ** 2).sum())
    expected = (1 - shrunk) * raw * apart + (1 + 1e-9) * np.eye(3)
    assert simultaneous.correlation_of(residuals, 7) == pytest.approx(expected)
    assert simultaneous.correlation_of(residuals, 1)[0, 0] == pytest.approx(1.0)


def spreads():
    return (Spread("a", (0.3, 0.5), 0.2, 0.1, 0.25), Spread("b", (0.4, 0.1)))


def asked(size=3, **settings):
    return PlannedStudies(spreads(), np.linalg.cholesky(np.array([[1.0, 0.5], [0.5, 1.0]])), Planning(**settings), size)


def test_animals_are_as_alike_as_their_spreads_say_and_a_plan_asks_for_an_effect():
    one = spreads()[0]
    animals = (0.09 + 0.25) / 2
    assert one.alike == pytest.approx(animals / (animals + 0.0625))
    assert Spread("x", (0.0, 0.0)).alike == 0.0
    assert one.on_one_occasion(1) == pytest.approx(np.hypot(0.5, 0.25))
    for effect in (1.0, 1.0009, 0.9991):
        with pytest.raises(InputError, match="a ratio of 1 is no effect"):
            Planning(effect=effect)
    assert Planning(effect=1.002).effect == 1.002
    with pytest.raises(InputError, match="littermates: say how far"):
        Planning(littermates=True)


def test_what_would_save_animals_is_tried_on_their_errors_images_and_occasions():
    plain = planning._scenarios(spreads(), Planning(occasions=2))
    assert list(plain) == ["as it is", "errors halved", "own images", "a second occasion"]
    assert [one.error for one in plain["errors halved"][0]] == [0.1, 0.0]
    own = plain["own images"][0][0]
    assert (own.shared, own.error) == (0.0, pytest.approx(np.hypot(0.2, 0.1 / np.sqrt(2))))
    assert plain["a second occasion"][1].occasions == 4
    pairs = planning._scenarios(spreads(), Planning(pairs=0.5))
    assert list(pairs) == ["as it is", "errors halved", "two recordings each time"]
    unknown = planning._scenarios([Spread("b", (0.4, 0.1))], Planning())
    assert unknown["a second occasion"][1].occasions == 1


def test_drawn_studies_scatter_as_their_spreads_say():
    a, b = power._groups(asked(), 20_000)
    assert (a[1], b[1]) == (0.2, 0.0)
    assert a[0].shape == (20_000, 2, 3)
    assert a[0].std(axis=(0, 2)) == pytest.approx(np.hypot(np.hypot([0.3, 0.5], 0.25), 0.2), rel=0.02)
    assert a[2].std() == pytest.approx(0.1, rel=0.02)
    assert np.corrcoef(a[0][:, 0, 1], b[0][:, 0, 1])[0, 1] == pytest.approx(0.5, abs=0.02)
    a, _ = power._repeated(asked(occasions=2), 20_000)
    assert a[0].shape == (20_000, 2, 3, 2)
    assert a[0].std(axis=(0, 2, 3)) == pytest.approx(np.sqrt(np.array([0.09, 0.25]) + 0.0625 + 0.04), rel=0.02)
    pair = a[0][:, 1, 0]
    assert np.cov(pair.T)[0, 1] == pytest.approx(0.25, rel=0.05)
    a, b = power._pairs(asked(occasions=4, pairs=0.7), 20_000)
    assert a[1] == 0.1
    assert a[0].std(axis=(0, 2)) == pytest.approx(np.sqrt(np.array([0.09, 0.25]) + 0.0625 + 0.01), rel=0.02)
    assert np.cov(b[0][:, :, 0].T)[0, 1] == pytest.approx(0.7 * 0.4 * 0.1, rel=0.1)
    assert not a[2].any()


def test_repeated_studies_are_judged_as_two_halves_of_their_occasions(monkeypatch):
    seen = []

    def critical(*given):
        seen.append(given)
        return [0.3, 0.1]

    monkeypatch.setattr(power, "_critical_of_models", critical)
    monkeypatch.setattr(power, "_repeated", lambda planned, count: (planned, count))
    assert power.critical_of_studies(asked(2, occasions=8)).tolist() == [0.1, 0.3]
    (planned, count), fixed, random, own = seen[0]
    assert count == 40
    assert (planned.settings.occasions, planned.size) == (2, 2)
    assert [one.error for one in planned.spreads] == pytest.approx([0.1, 0.0])
    assert [one.within for one in planned.spreads] == pytest.approx([0.125, 0.0])
    assert [one.between for one in planned.spreads] == [(0.3, 0.5), (0.4, 0.1)]
    assert own == spreads()
    assert fixed.tolist() == [[1, 0]] * 4 + [[0, 1]] * 4
    animal = np.arange(8) // 2
    group = np.arange(8) // 4
    expected = [
        np.equal.outer(which, which) & np.logical_and.outer(group == number, group == number)
        for number in (0, 1)
        for which in (np.arange(8), animal)
    ]
    assert len(random) == 4
    for one, other in zip(random, expected, strict=True):
        assert np.array_equal(one, other)


def test_models_of_planned_pairs_have_two_means_and_what_pairs_share():
    fixed, random = balanced.structure_of_pairs(3, littermates=False)
    assert fixed.tolist() == [[1, 0]] * 3 + [[0, 1]] * 3
    pair = np.arange(6) % 3
    assert np.array_equal(random[0], np.eye(6))
    assert np.array_equal(random[1], np.equal.outer(pair, pair))
    _, random = balanced.structure_of_pairs(2, littermates=True)
    assert [np.diag(one).tolist() for one in random] == [[1, 1, 0, 0], [0, 0, 1, 1], [1, 1, 1, 1]]


def test_changes_of_pairs_without_errors_are_the_paired_t_test():
    values = RNG.normal(size=(4, 2, 6))
    found = balanced.changes_of(values, 0.0, littermates=False)
    for place, (first, second) in enumerate(values):
        test = stats.ttest_rel(second, first)
        if np.cov(first, second)[0, 1] > 0:
            assert found.value[place] == pytest.approx((second - first).mean())
            assert found.error[place] == pytest.approx((second - first).std(ddof=1) / np.sqrt(6), rel=1e-4)
            assert found.p[place] == pytest.approx(test.pvalue, rel=1e-3)
    repeated = RNG.normal(size=(3, 2, 5, 2)) + 3 * RNG.normal(size=(3, 2, 5, 1))
    effect = balanced.effects_of_repeated(repeated, 0.0, 0.3)
    own = repeated.mean(axis=3)
    variance = own.var(axis=2, ddof=1).sum(axis=1) / 5 + 0.09
    assert effect.value == pytest.approx(own[:, 1].mean(axis=1) - own[:, 0].mean(axis=1))
    assert effect.error == pytest.approx(np.sqrt(variance))
    squares = ((own.var(axis=2, ddof=1) / 5) ** 2).sum(axis=1)
    assert effect.freedom == pytest.approx(variance**2 * 4 / squares)


def test_the_pooled_mean_of_a_group_keeps_what_its_animals_share():
    known = estimates([1.0, 1.4, 0.8], [0.0, 0.0, 0.0], [0.3, 0.3, 0.3], [0, 0, 0])
    found = comparison.pooled(known)
    own = np.var([1.0, 1.4, 0.8], ddof=1) / 3
    variance = own + 0.09
    reach = stats.t.ppf(0.975, 2 * (variance / own) ** 2) * np.sqrt(variance)
    mean = np.mean([1.0, 1.4, 0.8])
    assert tuple(found) == pytest.approx(tuple(np.exp([mean, mean - reach, mean + reach])))
    alone = comparison.pooled(known.of(np.array([True, False, False])))
    assert alone.value == pytest.approx(np.e)
    assert np.isnan(alone.low)
    assert np.isnan(comparison.pooled(estimates([1.0, 1.0], [0, 0], [0, 0], [0, 1])).high)
    assert np.isfinite(comparison.pooled(estimates([1.0, 1.0], [0.1, 0.1], [0, 0], [0, 1])).high)


@pytest.mark.parametrize(("sizes", "pairs"), [((3, 3), 1), ((3, 4), 1), ((4, 4), 3), ((2, 2), 4), ((20, 20), 1)])
def test_no_rank_test_falls_below_the_share_of_one_arrangement(sizes, pairs):
    ways = min(comb(sum(sizes), sizes[0]), 200_000)
    assert primary.smallest_p(sizes, pairs) == min(1.0, pairs * (2 if sizes[0] == sizes[1] else 1) / ways)


def compared(logs, other):
    logs = np.asarray(logs, float)
    known = estimates(logs, np.zeros(len(logs)), np.zeros(len(logs)), range(len(logs)))
    results = [SimpleNamespace(name=f"m{n}") for n in range(len(logs))]
    return primary.Compared("x", "measured", "1", results, known, np.asarray(other, bool))


def test_what_cannot_be_compared_is_refused_and_groups_apart_do_not_touch():
    assert primary._refusal(compared([1, 2, 3], [0, 0, 1])) == "a group has fewer than two animals with it"
    assert primary._refusal(compared([1, 2, 3, np.nan], [0, 0, 1, 1])).startswith("a value is not positive")
    assert primary._refusal(compared([1, 2, 3, 3 + 1e-10], [0, 0, 1, 1])).startswith("the values hardly vary")
    assert primary._refusal(compared([1, 1, 3, 4], [0, 0, 1, 1])).startswith("the values hardly vary")
    assert primary._refusal(compared([1, 2, 3, 4], [0, 0, 1, 1])) == ""
    assert primary._apart(compared([1, 2, 3, 4], [0, 0, 1, 1]))
    assert primary._apart(compared([1, 2, 3, 4], [1, 1, 0, 0]))
    assert not primary._apart(compared([1, 3, 3, 4], [0, 0, 1, 1]))
    one = compared([1.0, 1.2, 2.0, 3.0, 3.1, 3.2], [0, 0, 0, 1, 1, 1])
    found = primary._influence(one, one.ratio())
    assert found["without"] == "m2"
    assert found["ratio without"] == pytest.approx(np.exp(3.1 - 1.1))
    few = compared([1.0, 1.2, 3.0, 3.1, 3.2], [0, 0, 1, 1, 1])
    assert primary._influence(few, few.ratio())["without"] == ""
    rows = primary._joint([one, one._replace(name="y")])
    assert [row.quantity for row in rows] == [0, 1]
    assert rows[1].animals.tolist() == list(range(6))


def test_a_table_of_animals_has_one_unit_a_quantity_and_is_described_in_quartiles():
    def result(name, unit="mmHg", value=1.0):
        quantities = xr.Dataset({"P": ((), value, {"units": unit}), "k": 2.0})
        return SimpleNamespace(name=name, group="CTL", sources={"measured": SimpleNamespace(quantities=quantities)})

    made = table.cohort_table([result("a"), result("b", value=3.0)])
    assert made.columns.tolist() == ["animal", "group", "source", "P [mmHg]", "k [1]"]
    assert table.column(made, "P") == "P [mmHg]"
    assert table.column(made, "Q") == ""
    with pytest.raises(InputError, match="'P' of animal 'b' is in kPa, before in mmHg"):
        table.cohort_table([result("a"), result("b", "kPa")])
    with pytest.raises(InputError, match="two animals are called 'a'"):
        table.cohort_table([result("a"), result("a")])
    frame = pd.DataFrame({"group": ["x"] * 4 + ["y"], "P": [1.0, 2, 4, 8, 5]})
    rows = table.describe(frame, ["P"]).set_index("group")
    assert rows.loc["x", ["n", "mean", "median", "Q1", "Q3"]].tolist() == [4, 3.75, 3.0, 1.75, 5.0]
    assert rows.loc["x", "SD"] == pytest.approx(np.std([1, 2, 4, 8], ddof=1))
    assert np.isnan(rows.loc["y", "SD"])
    for quantity, group in (("P", "z"), ("Q", "x")):
        with pytest.raises(InputError, match=r"is empty or holds|no column 'Q'"):
            table.values_of(frame, quantity, group)
    with pytest.raises(InputError, match="not finite"):
        table.values_of(frame.assign(P=np.nan), "P", "x")


def test_leaving_one_out_moves_the_mean_of_its_own_group():
    frame = pd.DataFrame(
        {"group": ["x", "y", "x", "y", "x", "y", "y"], "P": [1.0, 8, 2, 10, 4, 9, 30]}, index=list("abcdefg")
    )
    found = two_groups.leave_one_out(frame, ["P"], "x", "y").set_index("left out")
    logs = np.log(frame["P"])
    for animal in frame.index:
        rest = logs.drop(animal)
        kinds = frame["group"].drop(animal)
        expected = np.exp(rest[kinds == "y"].mean() - rest[kinds == "x"].mean())
        assert found.loc[animal, "ratio"] == pytest.approx(expected)
        everyone = np.exp(logs[frame["group"] == "y"].mean() - logs[frame["group"] == "x"].mean())
        assert found.loc[animal, "ratio shift"] == pytest.approx(expected / everyone)
    with pytest.raises(InputError, match="needs three animals in each of 'x' and 'y'"):
        two_groups.leave_one_out(frame.drop("a"), ["P"], "x", "y")
    with pytest.raises(InputError, match="not positive"):
        two_groups.leave_one_out(frame.assign(P=frame["P"] - 1), ["P"], "x", "y")
    with pytest.raises(InputError, match="needs two animals in each"):
        two_groups.contrasts(frame.loc[["a", "b", "d"]], ["P"], "x", "y")
    with pytest.raises(InputError, match="a ratio needs positive"):
        two_groups.contrasts(frame.assign(P=frame["P"] - 1), ["P"], "x", "y")
    row = two_groups.contrasts(frame, ["P"], "x", "y").iloc[0]
    x, y = (logs[frame["group"] == one] for one in "xy")
    welch = stats.ttest_ind(y, x, equal_var=False).confidence_interval(0.95)
    assert (row["ratio low"], row["ratio high"]) == pytest.approx((np.exp(welch.low), np.exp(welch.high)))
    assert row["ratio"] == pytest.approx(np.exp(y.mean() - x.mean()))
    assert row["eta"] == pytest.approx((57 / 4) / (7 / 3) - 1)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"factor": "a", "dose": "b"}, "factor and dose: a design has one of these"),
        ({"occasion": "a", "subject": "m", "factor": "b"}, "occasion and factor: a design has one"),
        ({"occasion": "a"}, "name the column that says which recordings are of one animal as subject"),
        ({"crossover": True}, "crossover: name the column"),
        ({"covariates": ["a"], "blocks": ["a"]}, "'a' stands in two places; keep one"),
        ({"contrasts": {"c": {"x": 1.0}}}, "contrast 'c': its weights must sum to 0"),
        ({"contrasts": {"c": {"x": 1.0, "y": -0.9}}}, "its weights must sum to 0"),
        ({"contrasts": {"c": {"x": 0.0, "y": 0.0}}}, "its weights must sum to 0"),
    ],
)
def test_designs_that_contradict_themselves_are_refused(settings, words):
    with pytest.raises(InputError, match=words):
        Design(**settings)


def test_a_design_knows_its_columns_and_whether_it_is_plain():
    one = Design(covariates=["Sex"], blocks=["litter"], subject="mouse", occasion="week")
    assert one.terms == ("sex", "litter", "mouse", "week")
    assert (one.second, one.plain) == ("week", False)
    assert Design().plain
    assert not Design(contrasts={"c": {"x": 1.0, "y": -1.0}}).plain
    assert (Design(factor="f").second, Design(dose="d").second, Design().second) == ("f", "d", None)


def test_covariates_are_standardized_or_coded_so_that_levels_sum_to_nothing():
    names = list("abcd")
    number = Variable.of("w [g]", dict(zip(names, "1247", strict=True)))
    (column,) = covariate_columns(number, names)
    values = np.array([1.0, 2, 4, 7])
    assert column == pytest.approx((values - 3.5) / values.std())
    assert covariate_columns(Variable.of("w [g]", dict.fromkeys(names, "1")), names) == []
    sex = Variable.of("sex", dict(zip(names, ["f", "m", "x", "f"], strict=True)))
    assert [one.tolist() for one in covariate_columns(sex, names)] == [[1, 0, -1, 1], [0, 1, -1, 0]]
    assert [one.tolist() for one in covariate_columns(sex, ["b", "c"])] == [[1, -1]]
    codes = [(label, code.tolist()) for label, code in _codes(sex, 2, names)]
    assert codes == [("sex: m / f", [-1, 1]), ("sex: x / f", [-2, -1])]
    ((label, code),) = _codes(number, 1, names)
    assert (label, code.tolist()) == (f"w, {values.std():.3g} g more", [1.0])
    days = Variable.of("born", dict(zip(names, ["2024-01-01", "2024-01-03", "2024-01-01", "2024-01-03"], strict=True)))
    assert next(_codes(days, 1, names))[0] == "born, 1 days more"
    assert list(_codes(number, 0, names)) == []


def contrast(first, second, what="groups", **more):
    return Contrast("HPH", "CTL", np.array(first, float), np.array(second, float), what, **more)


def test_a_contrast_is_worded_by_its_sides_its_change_and_where_it_is():
    one = contrast([1, 0], [0, 1], change="2/1", within="at w1")
    assert one.text == "HPH against CTL in the change 2/1 at w1"
    assert one.worded("ratio") == "HPH against CTL in the ratio 2/1 at w1"
    assert one._replace(reference="", change="", within="").text == "HPH"
    assert one.of_values
    assert not one.of_ratios
    change = contrast([1, -1], [0, 0], change="x")
    assert (change.of_values, change.of_ratios) == (False, True)
    assert not contrast([0, 0], [0, 0]).of_ratios
    assert contrast([0, 1, 0], [0, 0, -1]).cells.tolist() == [False, True, True]


PAIRS = [("CTL", "1"), ("CTL", "2"), ("HPH", "1"), ("HPH", "2")]


def cells(filled, owners=(), column=None):
    means = np.eye(4)
    rows = np.eye(4)[np.flatnonzero(filled)]
    if column is not None:
        means, rows = np.column_stack([means, np.zeros(4)]), np.column_stack([rows, column])
    return Cells(PAIRS, np.array(filled, bool), means, rows, owners, "week")


def test_groups_are_compared_at_the_levels_that_both_have():
    groups = contrast([0.5, 0.5, 0, 0], [0, 0, 0.5, 0.5])
    told, untold = told_and_not([groups], cells([1, 1, 1, 1]))
    assert (told, untold) == ((groups,), ())
    (smaller,), (left,) = told_and_not([groups], cells([1, 1, 1, 0]))
    assert smaller.text == "HPH against CTL at week 1"
    assert (smaller.first.tolist(), smaller.second.tolist()) == ([1, 0, 0, 0], [0, 0, 1, 0])
    assert left.cells == ("HPH, 2",)
    assert "nothing is known of HPH, 2; compared is HPH against CTL at week 1;" in str(left.finding)
    none, (left,) = told_and_not([groups], cells([1, 1, 1, 0]), smaller=False)
    assert (none, left.instead) == ((), "")
    weeks = contrast([0.5, 0, 0.5, 0], [0, 0.5, 0, 0.5], "factor")
    assert told_and_not([weeks], cells([1, 1, 1, 0]))[0][0].text == "HPH against CTL in CTL"
    change = contrast([-1, 1, 0, 0], [0, 0, -1, 1], "interaction")
    assert told_and_not([change], cells([1, 1, 1, 0]))[0] == ()


def test_a_covariate_that_goes_with_the_groups_takes_their_comparison():
    groups = contrast([0.5, 0.5, 0, 0], [0, 0, 0.5, 0.5])
    (told, (left,)) = told_and_not([groups], cells([1, 1, 1, 1], ["sex"], [1.0, 1, -1, -1]))
    assert told == ()
    assert (left.columns, left.cells) == (("sex",), ())
    assert "sex differs just as it does" in str(left.finding)
    assert [one.code for one in untold_findings((), (left,))] == ["design.nothing-told"]
    assert [one.code for one in untold_findings((groups,), (left,))] == ["design.confounded"]
    nobody = Untold(groups, (), ("HPH, 2",))
    assert "would need recordings of HPH, 2" in str(untold_findings((), (nobody, nobody))[0])
    assert untold_findings((), ()) == []


def test_one_image_of_several_animals_leaves_an_effect_unknown_where_it_moves_it():
    layout = SimpleNamespace(subject=("a", "b", "c", "d"), cell=np.array([0, 0, 1, 1]), means=np.eye(2))
    fit = SimpleNamespace(weights=np.array([[0.5, 0.5, 0, 0], [0, 0, 0.5, 0.5]]))
    groups = contrast([1, 0], [0, 1])

    def unknown(label, source="linear", told=False):
        known = SimpleNamespace(image_error_known=told, label=np.array([label]))
        values = SimpleNamespace(source=source, estimates=known)
        return _image_unknown(Modeled(values, layout, None, fit, []), groups)

    assert unknown([0, 0, 1, 1])
    assert not unknown([0, 0, 0, 0])
    assert not unknown([0, 1, 2, 3])
    assert not unknown([0, 0, 1, 1], "measured")
    assert not unknown([0, 0, 1, 1], told=True)
    assert not unknown([0, 1, 0, 1])
    assert _subjects(layout, np.array([0.0, 1.0])) == {"c", "d"}


def test_one_image_of_animals_does_not_touch_what_changes_within_them():
    layout = SimpleNamespace(subject=("a", "a", "b", "b"), cell=np.array([0, 1, 0, 1]), means=np.eye(2))
    fit = SimpleNamespace(weights=np.array([[0.5, 0, 0.5, 0], [0, 0.5, 0, 0.5]]))
    known = SimpleNamespace(image_error_known=False, label=np.array([[0, 0, 0, 0]]))
    values = SimpleNamespace(source="linear", estimates=known)
    assert not _image_unknown(Modeled(values, layout, None, fit, []), contrast([1, 0], [0, 1]))


def test_how_far_rows_can_be_relied_on_is_of_the_smallest_group_and_the_greatest_ratio_of_spreads():
    rows = [
        compared([1, 2, 3, 1, 7], [0, 0, 0, 1, 1]),
        compared([1, 2, 3, 4, 5, 6], [0] * 3 + [1] * 3),
    ]
    found = primary._assurance(rows, SimpleNamespace(rate=0.06, critical=0.01))
    assert (found.rate, found.alone, found.smallest) == (0.06, 0.99, 2)
    assert found.spread_ratio == pytest.approx(18**0.5)
    turned = [compared([1, 7, 1, 2, 3], [0, 0, 1, 1, 1])]
    assert primary._assurance(turned, SimpleNamespace(rate=0.06, critical=0.01)).spread_ratio == pytest.approx(18**0.5)


def evident(name, logs, trusted):
    laws = {
        wall: SimpleNamespace(posterior=None if one is None else SimpleNamespace(trusted=one))
        for wall, one in trusted.items()
    }
    evidence = xr.Dataset({"log_evidence": ("wall", list(logs.values()))}, {"wall": list(logs)})
    return SimpleNamespace(name=name, evidence=evidence, laws=laws)


def test_evidences_are_ratios_of_trusted_posteriors_to_the_reference():
    both = {"linear": True, "tangent": True}
    results = [
        evident("a", {"linear": 1.0, "tangent": 3.0}, both),
        evident("b", {"linear": 900.0, "tangent": 100.0}, both),
        evident("c", {"linear": -900.0, "tangent": 100.0}, both),
        evident("d", {"linear": 1.0, "tangent": 3.0}, {"linear": True, "tangent": False}),
        evident("e", {"linear": 1.0, "tangent": 3.0}, {"linear": None, "tangent": True}),
        evident("f", {"tangent": 3.0}, {"tangent": True}),
        SimpleNamespace(name="g", evidence=None),
    ]
    (found,) = evidences(SimpleNamespace(results=results), "linear")
    assert found.wall == "tangent"
    assert found.ratios == pytest.approx({"a": np.exp(-2), "b": np.exp(700), "c": np.exp(-700)})
    assert found.untrusted == ["d", "e"]


def test_exponents_of_posteriors_are_pooled_with_what_they_share():
    one = estimates([0.2], [0.3], [0.4], [0])
    found = walls._of_posteriors(one)
    assert tuple(found) == pytest.approx((0.2, 0.2 - 1.959964 * 0.5, 0.2 + 1.959964 * 0.5))
    three = estimates([0.2, 0.5, 0.1], [0.1, 0.1, 0.1], [0.3, 0.5, 0.2], [0, 0, 1])
    found = walls._of_posteriors(three)
    mean = pooling.pooled_mean(three.logs, three.errors)
    common = (2 / 3) ** 2 * (0.09 + 0.25) / 2 + (1 / 3) ** 2 * 0.04
    reach = stats.t.ppf(0.975, 2) * np.sqrt(mean.error**2 + common)
    assert tuple(found) == pytest.approx((mean.value, mean.value - reach, mean.value + reach), rel=1e-5)
    assert walls._crossing(np.array([0.0, 1, 2, 3]), np.array([9.0, 5, 1, 0]), 1, 3.0) == pytest.approx(1.5)
    assert walls._crossing(np.array([0.0, 1, 2, 3]), np.array([0.0, 1, 5, 9]), 1, 3.0) == pytest.approx(1.5)
    none = walls.pooled_censored(np.array([0.1, 0.2, 0.3]), np.full(3, 0.1), np.array([0, 1, 1]))
    assert (none.low, none.high) == (-np.inf, np.inf)
    plain = walls.pooled_censored(np.array([0.1, 0.5]), np.zeros(2), np.zeros(2, int))
    half = stats.t.ppf(0.975, 1) * np.std([0.1, 0.5], ddof=1) / np.sqrt(2)
    assert plain.value == pytest.approx(0.3, abs=2e-3)
    assert plain.high - plain.value == pytest.approx(half, rel=0.02)


@pytest.mark.parametrize("origin", ["posterior", "fit"])
def test_the_exponent_of_a_law_is_pooled_over_the_first_recordings_that_have_one(monkeypatch, origin):
    def one(name, value, at_bound=0):
        exponent = xr.DataArray(value, attrs={"parameter": "m", "linear_at": 0.5, "at_bound": at_bound})
        stiffening = None if value is None else {"exponent": exponent}
        return SimpleNamespace(name=name, laws={"power": SimpleNamespace(stiffening=stiffening)})

    calibrated = [one("a1", 0.6), one("a2", 0.7), one("b", 0.1, 1), one("c", None), one("d", 9.0, 1), one("e", 8.0, 1)]
    subjects = {"a1": "a", "a2": "a"} | {name: name for name in "bcde"}
    asked = []

    def estimates_of(results, wall, name):
        asked.append(([result.name for result in results], wall, name))
        return SimpleNamespace(origin=origin)

    def of_fits(results, wall, each, beyond):
        asked.append(([float(value) for value in each], beyond.tolist()))
        return np.log([0.8, 0.6, 1.0])

    monkeypatch.setattr(walls, "estimates_of", estimates_of)
    monkeypatch.setattr(walls, "_of_fits", of_fits)
    monkeypatch.setattr(walls, "_of_posteriors", lambda drawn: np.log([0.8, 0.6, 1.0]))
    side = {"b": -1, "d": 1, "e": 1}
    monkeypatch.setattr(walls, "_beyond", lambda result, wall, exponent: side.get(result.name, 0))
    found = walls.exponent_of(SimpleNamespace(subjects=subjects, calibrated=lambda wall: calibrated), "power")
    assert (found.name, found.linear, found.animals, found.drawn) == ("m", 0.5, 4, origin == "posterior")
    assert (found.value, found.low, found.high) == pytest.approx((0.8, 0.6, 1.0))
    assert (found.below, found.above) == ((0, 0) if found.drawn else (1, 2))
    assert asked[0] == (["a1", "b", "d", "e"], "power", "m")
    assert asked[1:] == ([] if found.drawn else [([0.6, 0.1, 9.0, 8.0], [0, -1, 1, 1])])
    none = SimpleNamespace(subjects=subjects, calibrated=lambda wall: calibrated[3:4])
    assert walls.exponent_of(none, "power") is None


def test_an_exponent_at_a_bound_stands_beyond_the_nearer_one():
    calibration = xr.Dataset({"lower": ("parameter", [0.1]), "upper": ("parameter", [10.0])}, {"parameter": ["m"]})
    result = SimpleNamespace(laws={"power": SimpleNamespace(calibration=calibration)})

    def beyond(value, at_bound=1):
        return walls._beyond(result, "power", xr.DataArray(value, attrs={"parameter": "m", "at_bound": at_bound}))

    assert [beyond(0.1), beyond(0.99), beyond(1.01), beyond(10.0), beyond(0.1, 0)] == [-1, -1, 1, 1, 0]


def ballot(scores, animal, prefers="linear", count=64):
    row = {"covariance": "white", "N": count, "AICc prefers": prefers, "BIC prefers": prefers}
    row |= {f"AICc {wall}": score for wall, score in scores.items()} | {
        f"D {wall}": 4 + n for n, wall in enumerate(scores)
    }
    return Ballots(pd.DataFrame([row]), "white", animal)


def test_recordings_of_one_animal_are_averaged_before_laws_are_compared():
    votes = [
        ballot({"linear": 10.0, "tangent": 14.0}, "a"),
        ballot({"linear": 10.0, "tangent": 18.0}, "a"),
        ballot({"linear": 10.0, "tangent": 22.0}, "b"),
        ballot({"linear": 10.0, "tangent": 99.0}, "c", "discarded"),
    ]
    row = differences(votes, "linear").iloc[0]
    price = (10 + 60 / 58) - (8 + 40 / 59)
    assert (row["wall"], row["n"], row["sum"], row["mean"]) == ("tangent", 2, 18.0, 9.0)
    assert row["price"] == pytest.approx(price)
    assert row["residuals"] == pytest.approx(9.0 - price)
    assert differences(votes, "power").empty
    assert differences(votes, "linear", "red").empty


def members(*names_and_subjects, cells_of=None):
    results = [SimpleNamespace(name=name, group=group) for name, group, _ in names_and_subjects]
    groups = {}
    for one in results:
        groups.setdefault(one.group, []).append(one)
    column = Variable.of("mouse", {name: mouse for name, _, mouse in names_and_subjects})
    return Cohort(groups, {}, pd.DataFrame(), variables={"mouse": column}, design=Design(subject="mouse"))


def test_recordings_and_animals_are_counted_apart():
    once = members(("a", "CTL", "1"), ("b", "CTL", "2"))
    assert (once.count("CTL"), once.counts("CTL"), once.repeated, once.single) == ("n = 2", "n = 2", False, False)
    twice = members(("a", "CTL", "1"), ("b", "CTL", "1"), ("c", "CTL", "2"))
    assert (twice.count("CTL"), twice.repeated) == ("3 recordings, n = 2", True)
    assert twice.subjects == {"a": "1", "b": "1", "c": "2"}
    assert members(("a", "CTL", "1")).single


def test_the_animal_that_is_shown_is_nearest_to_the_medians_in_deviations():
    rows = pd.DataFrame({
        "animal": list("abcd"), "group": "CTL", "source": "measured", "mPAP [mmHg]": [10.0, 12.0, 14.0, 40.0],
        "CO [ml/s]": [0.1, 0.4, 0.2, 0.2], "HR [beats/min]": 500.0,
    })  # fmt: skip
    values = rows[["mPAP [mmHg]", "CO [ml/s]"]].to_numpy()
    away = (((values - np.median(values, axis=0)) / values.std(axis=0)) ** 2).sum(axis=1)
    assert typical_animal(rows, "CTL") == "abcd"[int(np.argmin(away))]
    assert typical_animal(rows, "CTL", ["a", "d"]) in "ad"
