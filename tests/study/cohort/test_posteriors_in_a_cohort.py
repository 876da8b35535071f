"""Posteriors of animals as input of the primary comparison: their errors, and an image that animals share."""

from dataclasses import replace

import numpy as np
import pytest

from made_cohort import made_results
from made_posterior import NAMES, SD, SHARE, with_posterior
from vasowave.study.cohort import Family, estimates_of, gathered, pooled_ratio, primary_comparison, shared_error
from vasowave.study.report.sections import primary_tables

FAMILY = Family("linear", NAMES)


@pytest.fixture
def results():
    return made_results({"CTL": 4, "HPH": 3}, walls=("linear",))


def test_the_spread_of_the_draws_is_the_error_of_an_animal(results):
    one = estimates_of([with_posterior(result) for result in results], "linear", "stiffness")
    assert one.origin == "posterior"
    np.testing.assert_allclose(np.exp(one.logs), [float(r.laws["linear"].quantities["stiffness"]) for r in results])
    np.testing.assert_allclose(np.hypot(one.errors, one.shared[0]), SD)
    np.testing.assert_allclose(one.shared[0], SD * np.sqrt(SHARE))  # one image a group, of four and of three animals


def test_the_error_of_an_image_that_a_group_shares_is_not_averaged_away(results):
    cohort = gathered([with_posterior(result) for result in results])
    row = primary_comparison(cohort, FAMILY).table().set_index("quantity").loc["wave_speed"]
    assert row["estimates"] == "posterior"
    of_images = 1.959964 * np.sqrt(2 * SHARE) * SD  # one for each group
    assert np.log(row["high"] / row["low"]) / 2 > of_images


def test_the_supplement_says_which_values_come_from_posteriors(results):
    drawn = primary_comparison(
        gathered([with_posterior(result) for result in results]), Family("linear", (*NAMES, "tau"))
    )
    (table,) = primary_tables(drawn, {})
    assert {row[0]: row[1] for row in table.rows} == {
        "stiffness": "linear, posteriors",
        "wave_speed": "linear, posteriors",
        "tau": "linear",
    }
    assert "From posteriors" in table.note


def test_what_the_fits_say_stands_beside_a_row_by_posteriors(results):
    cohort = gathered([with_posterior(result) for result in results])
    family = Family("linear", (*NAMES, "C_p"))
    by_posterior = primary_comparison(cohort, family).table().set_index("quantity")
    fits = primary_comparison(gathered(results), family).table().set_index("quantity")
    for name in NAMES:
        assert by_posterior["fits ratio"][name] == pytest.approx(fits["ratio"][name])
        assert by_posterior["fits low"][name] < by_posterior["fits ratio"][name] < by_posterior["fits high"][name]
    assert by_posterior["fits ratio"].isna()["C_p"]
    assert fits["fits ratio"].isna().all()


def test_posteriors_give_a_p_where_fits_of_one_image_do_not(results):
    assert primary_comparison(gathered(results), FAMILY).table()["p"].isna().all()
    rows = primary_comparison(gathered([with_posterior(result) for result in results]), FAMILY).table()
    assert rows["p"].notna().all()
    outside = (rows["low"] > 1) | (rows["high"] < 1)
    assert outside.tolist() == (rows["p"] < 0.05).tolist()


def test_an_image_that_both_groups_share_alike_cancels(results):
    one = estimates_of([with_posterior(result) for result in results], "linear", "stiffness")
    other = np.array([result.group == "HPH" for result in results])
    assert shared_error(one, other) == pytest.approx(np.sqrt(2 * SHARE) * SD)
    same = one._replace(label=np.zeros((3, 7), dtype=int))
    assert shared_error(same, other) == 0.0


def test_an_animal_with_an_image_of_its_own_keeps_the_whole_error(results):
    network = results[0].network
    results[0] = replace(results[0], network=replace(network, length=1.01 * network.length))
    one = estimates_of([with_posterior(result) for result in results], "linear", "stiffness")
    assert one.shared[0, 0] == 0.0
    assert one.errors[0] == pytest.approx(SD)
    assert one.errors[1] == pytest.approx(SD * np.sqrt(1 - SHARE))


def test_one_posterior_that_cannot_be_trusted_leaves_all_animals_to_their_fits(results):
    for number, result in enumerate(results):
        with_posterior(result, trusted=int(number != 2))
    one = estimates_of(results, "linear", "stiffness")
    assert one.origin == "fit"
    assert one.shared.max() == 0.0


def test_what_is_shared_adds_to_the_variance_of_a_ratio():
    rng = np.random.default_rng(1)
    groups = [(rng.standard_normal(6), np.full(6, 0.1)) for _ in range(2)]
    alone, shared = pooled_ratio(*groups), pooled_ratio(*groups, shared=0.4)
    assert shared.error**2 == pytest.approx(alone.error**2 + 0.16)
    assert shared.value == alone.value


def test_a_probe_that_animals_share_moves_groups_by_the_animals_that_it_measured(results):
    drawn = [with_posterior(result) for result in results]
    for result in drawn:
        table = result.laws["linear"].posterior.table
        table["share_probe"], table["share_image"] = table["share_image"], 0.0 * table["share_image"]
    other = np.array([result.group == "HPH" for result in drawn])
    names = [result.name for result in drawn]
    alone = estimates_of(drawn, "linear", "stiffness")
    assert shared_error(alone, other) == 0.0
    np.testing.assert_allclose(alone.errors, SD)
    # Probe A measured three of the four controls; all others, and three hypoxic mice, had probe B.
    one = estimates_of(drawn, "linear", "stiffness", {"probe": dict(zip(names, "AAABBBB", strict=True))})
    assert shared_error(one, other) == pytest.approx(np.hypot(3 / 4, 3 / 4) * np.sqrt(SHARE) * SD)
    np.testing.assert_allclose(np.diag(one.covariance), SD**2)
    assert one.covariance[0, 1] == pytest.approx(SHARE * SD**2)
    assert one.covariance[0, 3] == 0.0
    both = estimates_of(drawn, "linear", "stiffness", {"probe": dict.fromkeys(names, "A")})
    assert shared_error(both, other) == 0.0


def test_fits_whose_image_error_is_said_have_a_p_and_share_it(results):
    for result in results:
        for one in result.laws["linear"].quantities.data_vars.values():
            one.attrs |= {"share_image": 0.75, "share_probe": 0.0, "share_calibration": 0.0}
    rows = primary_comparison(gathered(results), FAMILY).table()
    assert rows["p"].notna().all()
    assert (rows["untested"] == "").all()
