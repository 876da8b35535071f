"""An image is of one lung: what its animals share with it, when an effect goes, and weights that know no values."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from made_cohort import changed, made_results
from vasowave.study.animal import PosteriorResult
from vasowave.study.cohort import (
    Estimates,
    Family,
    estimates_of,
    gathered,
    lungs_of,
    pooled_ratio,
    primary_comparison,
    shared_error,
    tipping_radius,
    typical_errors,
)
from vasowave.study.cohort.lungs import RULES

OTHER = np.arange(7) >= 4
SLOPE = 2.5  # of the stiffness, per change of the radius


def estimates(images, slope=SLOPE):
    label = np.array([images, np.arange(7), np.arange(7)])
    none = np.zeros(7)
    return Estimates(none, none + 0.1, np.zeros((3, 7)), label, "fit", True, none + slope)


def told(results, slope=SLOPE):
    """Return results whose stiffness has an error of which half is the image's, and moves with the radii."""
    rng = np.random.default_rng(5)
    found = []
    for result in results:
        value = float(result.laws["linear"].quantities["stiffness"]) * np.exp(0.05 * rng.standard_normal())
        one = changed(result, "linear/quantities", stiffness=value)
        attrs = {"standard_error": 0.1 * value, "share_image": 0.5, "per_radius": slope}
        one.laws["linear"].quantities["stiffness"].attrs.update(attrs)
        found.append(one)
    return found


def test_the_lung_of_an_image_moves_all_its_animals_and_an_image_of_ones_own_moves_none():
    of_groups = estimates([0, 0, 0, 0, 1, 1, 1])
    assert shared_error(of_groups.of_lungs(0.1), OTHER) == pytest.approx(np.sqrt(2) * 0.1 * SLOPE)
    assert shared_error(of_groups.of_lungs(0.1).of_lungs(0.04), OTHER) == pytest.approx(np.sqrt(2) * 0.04 * SLOPE)
    assert shared_error(estimates(np.zeros(7, int)).of_lungs(0.1), OTHER) == pytest.approx(0.0)  # one lung for both
    assert shared_error(estimates(np.arange(7)).of_lungs(0.1), OTHER) == pytest.approx(0.0)
    two = estimates([0, 0, 2, 2, 1, 1, 1])  # two lungs of the first group
    assert shared_error(two.of_lungs(0.1), OTHER) == pytest.approx(np.sqrt(0.5 + 1) * 0.1 * SLOPE)


def test_how_much_lungs_differ_is_usual_told_or_seen_in_the_roots_of_several_lungs():
    results = made_results({"CTL": 4, "HPH": 3}, walls=())
    cohort = gathered(results)
    assert cohort.lungs == (RULES.usual_sd, "usual", {"CTL": 1, "HPH": 1})
    assert lungs_of(cohort.groups, {}, 0.2)[:2] == (0.2, "lab")
    wider = replace(results[0].network, radius=results[0].network.radius * np.exp(0.4))
    several = gathered([replace(one, network=wider) if one.name in ("CTL 1", "CTL 2") else one for one in results])
    expected = np.sqrt((4 * RULES.usual_sd**2 + 0.4**2 / 2) / 5)  # one degree of freedom beside four
    assert several.lungs == (pytest.approx(expected), "imaged", {"CTL": 2, "HPH": 1})


def test_animals_whose_errors_are_not_known_have_those_of_the_others_as_long_as_they_are_the_fewer():
    made = made_results({"CTL": 4, "HPH": 3}, walls=("linear",))

    def without(count):
        results = told(made)
        for result in results[:count]:
            value = result.laws["linear"].quantities["stiffness"]
            value.attrs = {"standard_error": 0.01 * float(value)}
        return estimates_of(results, "linear", "stiffness")

    whole, one, most = without(0), without(1), without(4)
    assert one.image_error_known
    assert one.covariance == pytest.approx(whole.covariance)
    assert one.per_radius == pytest.approx(whole.per_radius)
    assert not most.image_error_known
    unknown = told(made)
    value = unknown[0].laws["linear"].quantities["stiffness"]
    value.attrs = {"standard_error": 2.0 * float(value)}  # the data tell nothing of it, whatever the others' errors are
    known = estimates_of(unknown, "linear", "stiffness")
    assert known.covariance[0, 0] == pytest.approx(4.0)


def test_intervals_allow_for_the_lung_and_its_tipping_point_is_where_the_effect_goes():
    cohort = gathered(told(made_results({"CTL": 5, "HPH": 4}, walls=("linear",))))

    def row(sd):
        family = Family(quantities=("stiffness",), lung_sd=sd)
        return primary_comparison(cohort, family).table().iloc[0]

    alike, usual = row(0.0), row(None)
    assert alike["p"] < 0.05
    assert np.hypot(alike["standard error"], np.sqrt(2) * RULES.usual_sd * SLOPE) == pytest.approx(
        usual["standard error"]
    )
    tips = alike["tipping lung sd"]
    below, above = row(0.9 * tips), row(1.1 * tips)
    assert below["p"] < 0.05 < above["p"]
    assert usual["tipping lung sd"] == pytest.approx(tips, abs=0.02)
    assert np.isnan(above["tipping radius"])


def test_images_that_are_wrong_against_each_other_by_the_tipping_radius_take_the_effect_away():
    rng = np.random.default_rng(1)
    reference, other = (
        (0.1 * rng.standard_normal(6), np.full(6, 0.1)),
        (0.7 + 0.1 * rng.standard_normal(5), np.full(5, 0.1)),
    )
    ratio = pooled_ratio(reference, other)
    wrong = tipping_radius(ratio.low, ratio.high, SLOPE)
    moved = pooled_ratio(reference, (other[0] - SLOPE * np.log1p(wrong), other[1]))
    assert moved.low == pytest.approx(1.0)
    assert tipping_radius(1 / ratio.high, 1 / ratio.low, -SLOPE) == pytest.approx(wrong)
    assert np.isnan(tipping_radius(0.9, 1.3, SLOPE))
    assert tipping_radius(1.1, 1.3, 0.0) == np.inf


def test_lungs_that_differ_bring_false_positives_which_go_once_they_are_told():
    rng, shown = np.random.default_rng(2), {0.0: 0, 0.1: 0}
    for _ in range(400):
        lung = 0.1 * SLOPE * rng.standard_normal(2)
        groups = [(lung[place] + 0.25 * rng.standard_normal(12), np.zeros(12)) for place in range(2)]
        for sd in shown:
            ratio = pooled_ratio(*groups, shared=np.sqrt(2) * sd * SLOPE)
            shown[sd] += not ratio.low <= 1 <= ratio.high
    assert shown[0.0] > 400 * 0.3
    assert shown[0.1] < 400 * 0.08  # 0.05 and three standard errors


def test_the_weight_of_an_animal_is_the_typical_error_of_its_group():
    errors = np.array([0.1, 0.4, 0.2, 1.5, 0.3, 0.5])
    cell = ["CTL", "CTL", "CTL", "HPH", "HPH", "HPH"]
    np.testing.assert_allclose(typical_errors(errors, cell), [0.2, 0.2, 0.2, 1.5, 0.5, 0.5])
    assert typical_errors(np.zeros(0), []).shape == (0,)


@pytest.mark.parametrize("power", [1, -1])
def test_errors_that_are_constant_in_a_unit_or_in_its_inverse_leave_a_ratio_where_it_is(power):
    """True ratio 3; a value, or its inverse, is known to 0.3 of the reference mean. Own errors as weights miss it."""
    rng, found, plain, outside = np.random.default_rng(3), [], [], 0
    for _ in range(250):
        groups = []
        for place, count in enumerate((7, 5)):
            true = 3.0**place * np.exp(0.3 * rng.standard_normal(count))
            seen = np.maximum(true + 0.3 * rng.standard_normal(count), 0.05)
            groups.append((power * np.log(seen), 0.3 / seen))
        ratio = pooled_ratio(*((logs, typical_errors(own, ["one"] * len(own))) for logs, own in groups))
        found.append(power * np.log(ratio.value))
        plain.append(power * np.log(pooled_ratio(*groups).value))
        outside += not ratio.low <= 3.0**power <= ratio.high
    assert np.exp(np.median(plain)) < 2.75
    assert np.exp(np.median(found)) == pytest.approx(3.0, rel=0.05)
    assert outside < 250 * 0.09


def test_a_posterior_tells_how_a_quantity_moves_with_the_radii_by_its_draws():
    rng, results = np.random.default_rng(4), made_results({"CTL": 2, "HPH": 2}, walls=("linear",))
    drawn = []
    for result in results:
        radii = np.exp(0.05 * rng.standard_normal((4, 200)))
        stiffness = 100 * radii**SLOPE * np.exp(0.02 * rng.standard_normal(radii.shape))
        draws = xr.Dataset({"stiffness": (("chain", "draw"), stiffness), "radius_scale": (("chain", "draw"), radii)})
        table = xr.Dataset({"share_image": ("quantity", [0.8, 1.0])}, {"quantity": ["stiffness", "radius_scale"]})
        posterior = PosteriorResult(table.assign_attrs(trusted=1), {"posterior": draws})
        law = replace(result.laws["linear"], posterior=posterior)
        drawn.append(replace(result, laws={**result.laws, "linear": law}))
    assert estimates_of(drawn, "linear", "stiffness").per_radius == pytest.approx(np.full(4, SLOPE), rel=0.05)
