"""What a report says of groups of any size, and of any number of wall laws."""

import numpy as np
import xarray as xr

from made_cohort import made_trees
from vasowave.cohort import compare, gathered
from vasowave.cohort.votes import ballots, vote
from vasowave.report.sections.differences import differences, limits
from vasowave.report.sections.summary import summary_section
from vasowave.report.tables.cells import symbols
from vasowave.report.tables.selection import selection_table
from vasowave.selection.criteria import verdicts


def voting(tree, scores, likeliest):
    """Return a tree with a stored comparison: score of every law by noise model, the third place says discarded."""
    columns = {name: [] for name in ("covariance", "wall", "AICc", "BIC", "AICc_verdict", "BIC_verdict", "lambda",
                                     "D", "N", "discarded")}  # fmt: skip
    for covariance, (by_law, discarded) in scores.items():
        says = {law: verdict for law, _, verdict in verdicts(by_law)}
        for place, (law, score) in enumerate(by_law.items()):
            row = (covariance, law, score, score, says[law], says[law], 0.01, 4.0 + place, 512.0, discarded)
            for name, value in zip(columns, row, strict=True):
                columns[name].append(value)
    selection = xr.Dataset({name: ("candidate", np.array(values)) for name, values in columns.items()})
    voter = tree.copy()
    voter["selection"] = xr.DataTree(selection.assign_attrs(preferred_covariance=likeliest))
    return voter


def test_the_best_law_is_compared_with_the_runner_up_not_with_the_worst(cohort_trees):
    close = {"linear": 100.0, "tangent": 101.0, "power": 130.0}
    far = {"linear": 130.0, "tangent": 101.0, "power": 110.0}
    trees = [voting(tree, {"ARMA": (close, 0), "periodic": (far, 0)}, "ARMA") for tree in cohort_trees[:2]]
    assert vote(trees[0]) == "undecided"
    cohort = gathered(trees)
    assert selection_table(cohort).data["AICc prefers"].tolist() == ["undecided", "tangent"] * 2
    (said,) = [text for text in summary_section(cohort, {}, {}, {}).blocks[0].items if "AICc" in text]
    assert "the linear wall in 0 and the tangent wall in 0 of 2 animals and leaves 2 undecided" in said


def test_discarded_noise_models_stand_last_and_decide_nothing(cohort_trees):
    scores = {
        "se": ({"linear": -900.0, "tangent": -800.0}, 1),
        "matern32": ({"linear": -610.0, "tangent": -607.0}, 0),
        "periodic": ({"linear": -500.0, "tangent": -520.0}, 0),
    }
    table = ballots(voting(cohort_trees[0], scores, "periodic"))
    assert table["covariance"].tolist() == ["matern32", "periodic", "se"]
    assert table["AICc prefers"].tolist() == ["undecided", "tangent", "discarded"]
    assert (table["D linear"].iloc[0], table["D tangent"].iloc[0]) == (4, 5)
    assert vote(voting(cohort_trees[0], scores, "periodic")) == "tangent"
    assert vote(voting(cohort_trees[0], {"se": scores["se"]}, "")) == "discarded"


def test_groups_too_small_for_a_test_are_told_their_effects_and_why_no_test_confirms_them(cohort_trees):
    cohort = gathered(cohort_trees)
    comparison = compare(cohort, "measured")
    (said,) = differences(cohort, "measured", comparison, symbols(cohort.trees))
    row = comparison.contrasts.set_index("quantity").loc["mPAP [mmHg]"]
    assert row["p Holm"] > 0.05
    assert row["ratio low"] > 1
    assert f"mPAP {row['ratio']:.1f} times [{row['ratio low']:.1f}, {row['ratio high']:.1f}]" in said
    assert f"3 + 3 animals are too few for {len(comparison.contrasts)} exact tests" in said
    assert "no difference" not in said


def test_groups_large_enough_are_told_what_is_clear():
    cohort = gathered(made_trees({"CTL": 6, "HPH": 6}, walls=()))
    comparison = compare(cohort, "measured")
    clear = comparison.contrasts.loc[comparison.contrasts["p Holm"] < 0.05, "quantity"]
    assert 0 < len(clear) < len(comparison.contrasts)
    (said,) = differences(cohort, "measured", comparison, {})
    told, _, rest = said.partition("; not clear: ")
    assert told.startswith(f"HPH against CTL, measured: clear after Holm (over {len(comparison.contrasts)} tests) are ")
    assert all(f"{label.split(' [')[0]} " in told for label in clear)
    assert rest == "CO."
    assert any("With 6 + 6 animals" in text for text in limits(cohort, {"measured": comparison}))
