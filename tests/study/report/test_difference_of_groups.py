"""What makes the difference of two groups, against Welch's interval of SciPy and models whose difference is known."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import vasowave as vw
from made_cohort import made_results
from vasowave.study.cohort import (
    ComponentExchange,
    Design,
    GroupAttribution,
    Variable,
    attribution_table,
    difference_of_changes,
    gathered,
)
from vasowave.study.datasets import virtual_cohort
from vasowave.study.report.answer import attribution_answer, attribution_summary
from vasowave.study.results import attributed


@pytest.fixture(scope="module")
def results():
    return made_results({"CTL": 3, "HPH": 3}, walls=("linear",))


@pytest.fixture(scope="module")
def cohort(results):
    return attributed(gathered(results, "CTL"))


def pulse(result):
    fit = vw.stored_fit(result)
    return np.ptp(vw.simulate(fit.model, fit.inflow).pressure.sel(vessel=result.root, station="inlet").values)


def test_the_difference_is_that_of_the_models_of_the_animals(cohort):
    [made] = cohort.changes
    table = attribution_table([made]).query("quantity == 'pPAP'")
    assert len(table) == 9
    for level, group in (("after", "HPH"), ("before", "CTL")):
        values = table.groupby(level)[f"value {level}"].first()
        assert dict(values) == pytest.approx({one.name: pulse(one) for one in cohort.groups[group]}, rel=1e-3)


def test_an_interval_is_that_of_welch_where_pairs_are_all_pairs():
    ill, healthy = {"d": 22.0, "e": 25.5, "f": 31.0}, {"a": 12.0, "b": 13.5, "c": 11.0, "z": 15.0}
    rows = {
        (before, after): pd.DataFrame({"unit": "mmHg", "before": low, "after": high, "change": high - low}, ["mPAP"])
        for before, low in healthy.items()
        for after, high in ill.items()
    }
    made = GroupAttribution(
        "HPH", "CTL", "HPH", {pair: ComponentExchange(row, row) for pair, row in rows.items()}, {}, of_groups=True
    )
    interval = stats.ttest_ind([*ill.values()], [*healthy.values()], equal_var=False).confidence_interval(0.95)
    change = made.means("mPAP").loc["change"]
    assert (change["low"], change["high"]) == pytest.approx((interval.low, interval.high), rel=1e-9)


def test_an_occasion_that_is_called_like_its_group_stays_an_occasion():
    rows = {
        (f"{name} before", f"{name} after"): pd.DataFrame(
            {"unit": "mmHg", "before": 10.0, "after": 10.0 + change, "change": change}, ["mPAP"]
        )
        for name, change in {"a": 1.0, "b": 2.5, "c": 2.0}.items()
    }
    exchanges = {pair: ComponentExchange(row, row) for pair, row in rows.items()}
    made = GroupAttribution("treated", "before", "treated", exchanges, {}, of_groups=False)
    interval = stats.ttest_1samp([1.0, 2.5, 2.0], 0).confidence_interval(0.95)
    assert made.animals() == [3]
    assert made.means("mPAP").loc["change", "high"] == pytest.approx(interval.high, rel=1e-9)


def followed(group, changes):
    """A group whose animals changed by so much in the beds, or in walls and beds."""
    exchanges = {}
    for name, shares in changes.items():
        row = pd.DataFrame({"unit": "mmHg", "before": 0.0, "after": 0.0, "change": sum(shares.values())} | shares,
                           ["mPAP"])  # fmt: skip
        exchanges[f"{name} before", f"{name} after"] = ComponentExchange(row, row)
    return GroupAttribution(group, "before", "after", exchanges, {}, of_groups=False)


def test_an_interval_is_as_wide_as_welchs_where_each_animal_stands_in_two_pairs():
    rng, widths = np.random.default_rng(4), []
    for _ in range(10):
        healthy, ill = rng.standard_normal((2, 10))
        rows = {
            (f"a{(place + shift) % 10}", f"b{place}"): pd.DataFrame(
                {"unit": "mmHg", "before": 0.0, "after": 0.0, "change": ill[place] - healthy[(place + shift) % 10]},
                ["mPAP"],
            )
            for place in range(10)
            for shift in range(2)
        }
        exchanges = {pair: ComponentExchange(row, row) for pair, row in rows.items()}
        made = GroupAttribution("HPH", "CTL", "HPH", exchanges, {}, of_groups=True).means("mPAP").loc["change"]
        interval = stats.ttest_ind(ill, healthy, equal_var=False).confidence_interval(0.95)
        widths.append((made["high"] - made["low"]) / (interval.high - interval.low))
    assert 0.98 < np.mean(widths) < 1.06


def test_what_a_treatment_changed_is_told_against_what_changed_without_it_by_welch():
    vehicle = followed("vehicle", {"a": {"beds": 1.0}, "b": {"beds": 2.5}, "c": {"beds": 2.0}})
    shares = {"d": -4.0, "e": -5.5, "f": -6.0, "g": -4.5}
    treated = followed("treated", {name: {"walls": -1.0, "beds": share} for name, share in shares.items()})
    excess = difference_of_changes(treated, vehicle, "mPAP")
    interval = stats.ttest_ind([*shares.values()], [1.0, 2.5, 2.0], equal_var=False).confidence_interval(0.95)
    assert tuple(excess.loc["beds", ["low", "high"]]) == pytest.approx((interval.low, interval.high))
    assert excess.loc["walls", "mean"] == -1.0
    assert excess.index[0] == "change"
    assert excess["mean"].iloc[1:].sum() == pytest.approx(excess.loc["change", "mean"])


def test_the_change_is_not_mistaken_for_a_share_where_pairs_differ_in_their_components():
    """As where the wedge pressures of some pairs are alike: in the table, and in the sentence of the page."""
    shares = {"a": {"walls": 1.0, "beds": 9.0}, "b": {"walls": 1.2, "beds": 9.5, "pressure behind beds": -0.7},
              "c": {"beds": 8.0}}  # fmt: skip
    made = followed("treated", shares)
    means = made.means("mPAP")
    total = float(np.mean([sum(of_animal.values()) for of_animal in shares.values()]))
    assert means.index[0] == "change"
    assert means["mean"].iloc[0] == pytest.approx(total)
    assert means["mean"].drop("change").sum() == pytest.approx(total)
    rows = {pair: pd.concat([exchange.shares.rename({"mPAP": name}) for name in ("mPAP", "pPAP", "power")])
            for pair, exchange in made.exchanges.items()}  # fmt: skip
    exchanges = {pair: ComponentExchange(of_pair, of_pair) for pair, of_pair in rows.items()}
    changes = (replace(made, exchanges=exchanges),)
    [(_, answer)] = attribution_answer(SimpleNamespace(changes=changes, reference="control"))
    assert f"mean pressure +{total:.2g}" in answer
    assert "(change" not in answer


def test_shares_add_up_and_an_exchange_that_is_undone_takes_them_back(cohort):
    [made] = cohort.changes
    for exchange in made.exchanges.values():
        parts = exchange.shares.columns[4:]
        np.testing.assert_allclose(exchange.shares[parts].sum(axis=1), exchange.shares["change"], rtol=1e-9, atol=1e-12)
        assert np.sign(exchange.undone.loc["mPAP", "beds"]) == -np.sign(exchange.shares.loc["mPAP", "beds"])


def test_the_image_of_a_group_widens_what_its_geometry_and_walls_do_but_not_the_difference(cohort):
    """A fit of wider vessels has stiffer walls: the waves are those of before, to first order."""
    [made] = cohort.changes
    assert len(made.of_images) == 2  # an image of each group
    widened, alone = made.means("pPAP"), replace(made, of_images=()).means("pPAP")
    added = (widened["high"] - widened["low"]) / (alone["high"] - alone["low"])
    assert added["geometry"] > max(1.05, added["change"])


def test_a_second_factor_is_told_at_each_level_and_within_each_group():
    results = made_results({"CTL": 4, "HPH": 4}, walls=("linear",))
    cells = {result.name: ("drug" if result.name[-1] in "34" else "vehicle") for result in results}
    treated = Variable.from_cells("treatment", cells)
    design = Design(factor="treatment")
    made = attributed(gathered(results, "CTL", variables=[treated], design=design))
    assert [(compared.first, compared.last) for compared in made.changes] == [
        ("CTL, vehicle", "HPH, vehicle"),
        ("CTL, drug", "HPH, drug"),
        ("CTL, vehicle", "CTL, drug"),
        ("HPH, vehicle", "HPH, drug"),
    ]
    for compared in made.changes:
        members = [{result.name for result in made.cells[label].results} for label in (compared.first, compared.last)]
        assert all(before in members[0] and after in members[1] for before, after in compared.exchanges)
        assert compared.animals() == [2, 2]
    summary, _ = attribution_summary(made)
    assert "HPH, drug against HPH, vehicle (n = 2 + 2)" in [row[0] for row in summary.rows]


def test_recordings_of_one_animal_without_an_order_are_refused_with_what_to_name():
    results = made_results({"CTL": 4, "HPH": 4}, walls=("linear",))
    mice = Variable.from_cells(
        "mouse", {result.name: f"{result.group} {int(result.name[-1]) % 2}" for result in results}
    )
    made = attributed(gathered(results, "CTL", variables=[mice], design=Design(subject="mouse")))
    [(_, text)] = attribution_answer(made)
    assert text.startswith("HPH against CTL: not told, because animals were recorded more than once")
    assert "`occasion`" in text


def test_a_lung_of_each_animals_own_adds_nothing(results):
    words = Variable.from_cells("image", {result.name: f"lung of {result.name}" for result in results})
    [made] = attributed(gathered(results, "CTL", variables=[words])).changes
    assert made.of_images == ()


def test_an_image_of_some_animals_moves_their_share_of_the_mean_whichever_pair_is_typical(results):
    cells = {result.name: "c" if result.group == "CTL" else "shared" for result in results}
    moved = []
    for single in ("HPH 1", "HPH 2", "HPH 3"):
        words = Variable.from_cells("image", cells | {single: "one"})
        [made] = attributed(gathered(results, "CTL", variables=[words])).changes
        moved.append([of_image.shares.loc["pPAP", "geometry"] for of_image in made.of_images])
    shared = np.abs(moved)[:, 1]
    assert shared.min() > 0
    assert shared.max() < 1.5 * shared.min()


def test_the_page_names_what_is_shown_and_what_is_not(cohort):
    [(question, text)] = attribution_answer(cohort, tested=13)
    assert question == "What makes the difference?"
    assert text.startswith("HPH against CTL (n = 3 + 3): mean pressure ")
    assert "the intervals, each by itself; those of the answer are corrected for 13 comparisons" in text
    shares, undone = attribution_summary(cohort)
    assert {row[0] for row in shares.rows} == {"HPH against CTL (n = 3 + 3)"}
    assert shares.header[:3] == ("group", "quantity", "change")
    assert undone.header[-1] == "power of the heart [mW]"
    assert "beds of CTL" in [row[1] for row in undone.rows]


@pytest.mark.validation
def test_large_groups_are_told_by_some_pairs_in_which_each_animal_stands():
    results = made_results({"CTL": 7, "HPH": 7}, walls=("linear",))
    [made] = attributed(gathered(results, "CTL")).changes
    assert len(made.exchanges) == 35
    assert made.animals() == [7, 7]
    befores = [before for before, _ in made.exchanges]
    assert {befores.count(name) for name in befores} == {5}


@pytest.fixture(scope="module")
def animals():
    groups = [[one for one in virtual_cohort(3) if one.group == group][:3] for group in ("CTL", "HPH")]
    return {one.name: one for group in groups for one in group}


@pytest.mark.validation
@pytest.mark.parametrize("wider", [1.0, 1.08, 0.92])
def test_the_intervals_hold_the_true_shares_where_the_image_of_a_group_is_wrong(animals, wider):
    settings = vw.Settings(walls=("linear",), starts=1)
    results = []
    for one in animals.values():
        seen = one.network.resized(radius=one.network.radius * (wider if one.group == "HPH" else 1.0))
        results.append(vw.analyze(vw.Animal(one.name, one.group, seen, one.cycle, synthetic=True), settings))
    [made] = attributed(gathered(results, "CTL")).changes
    drives = {name: vw.Inflow(one.cycle.flow, one.cycle.period) for name, one in animals.items()}
    truth = [
        vw.attribute_change(animals[before].model, animals[after].model, (drives[before], drives[after])).table
        for before, after in made.exchanges
    ]
    for quantity in ("mPAP", "pPAP", "power"):
        means = made.means(quantity)
        true = pd.DataFrame([table.loc[quantity, means.index] for table in truth]).astype(float).mean()
        inside = (means["low"] <= true) & (true <= means["high"])
        assert inside.all(), f"{quantity}\n{means.assign(true=true)}"


def test_animals_that_were_followed_on_many_occasions_are_told_from_the_first_to_the_last():
    results = made_results({"CTL": 8}, walls=("linear",))
    week = Variable.from_cells("week", {result.name: str(place) for place, result in enumerate(results)})
    mouse = Variable.from_cells("mouse", {result.name: "a mouse" for result in results})
    design = Design(subject="mouse", occasion="week")
    [change] = attributed(gathered(results, "CTL", variables=[week, mouse], design=design)).changes
    assert (change.first, change.last, [*change.exchanges]) == ("0", "7", [("CTL 1", "CTL 8")])
