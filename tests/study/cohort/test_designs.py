"""Designs of a lab: against Welch, paired t, statsmodels and lme4, and by counts of what is found where nothing is."""

import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from made_cohort import made_results
from vasowave.base import InputError
from vasowave.study.cohort import (
    DRIFT,
    Design,
    Family,
    Fitted,
    Omission,
    Structure,
    Variable,
    degrees_left,
    fit_mixed,
    gathered,
    joint,
    known_values,
    laid_out,
    modeled,
    primary_comparison,
)
from vasowave.study.report.answer import not_told


def variables(table):
    """Return the columns of a table, `group` left out, by name."""
    names = [f"mouse {row}" for row in range(len(table))]
    return {
        label: Variable.from_cells(label, dict(zip(names, map(str, table[label]), strict=True)))
        for label in table
        if label != "group"
    }


def layout(design, table):
    names = [f"mouse {row}" for row in range(len(table))]
    return laid_out(
        design, variables(table), dict(zip(names, table["group"], strict=True)), [*dict.fromkeys(table["group"])]
    )


def fitted(found, y, errors=None):
    known = np.diag(np.zeros(len(y)) if errors is None else errors**2)
    return fit_mixed(y, Structure(found.fixed, list(found.random.values()), known))


def effects(found, fit):
    return {
        (one.label.kind, one.label.group): fit.effect((one.second - one.first) @ found.means) for one in found.contrasts
    }


def test_two_groups_of_a_model_without_errors_are_welchs():
    rng = np.random.default_rng(1)
    table = pd.DataFrame({"group": ["A"] * 7 + ["B"] * 5})
    y = np.append(rng.normal(size=7), rng.normal(1, 2.5, 5))
    found = layout(Design(), table)
    (effect,) = effects(found, fitted(found, y)).values()
    welch = stats.ttest_ind(y[7:], y[:7], equal_var=False)
    assert (effect.p, effect.freedom) == pytest.approx((welch.pvalue, welch.df), rel=1e-6)


def test_an_empty_design_is_the_comparison_of_independent_groups_exactly():
    results = made_results({"CTL": 4, "HPH": 4}, walls=())
    one = Variable.from_cells("sex", {result.name: "fm"[place % 2] for place, result in enumerate(results)})
    plain, designed = (
        primary_comparison(gathered(results, **more)).table() for more in ({}, {"variables": [one], "design": Design()})
    )
    pd.testing.assert_frame_equal(plain, designed)


def test_pairs_are_the_paired_t_test():
    rng = np.random.default_rng(2)
    level = 1.5 * rng.normal(size=9)
    y = np.append(level + 0.5 * rng.normal(size=9), level + 0.6 + 0.5 * rng.normal(size=9))
    table = pd.DataFrame({"group": "A", "mouse": [*range(9)] * 2, "time": ["before"] * 9 + ["after"] * 9})
    found = layout(Design(subject="mouse", occasion="time"), table)
    (effect,) = effects(found, fitted(found, y)).values()
    paired = stats.ttest_rel(y[9:], y[:9])
    assert effect.value == pytest.approx(np.mean(y[9:] - y[:9]))
    assert (effect.p, effect.freedom) == pytest.approx((paired.pvalue, 8), rel=1e-5)


def test_changes_of_two_groups_are_welchs_test_of_the_differences():
    rng = np.random.default_rng(3)
    table = pd.DataFrame({"group": (["A"] * 6 + ["B"] * 5) * 2, "mouse": [*range(11)] * 2,
                          "time": ["before"] * 11 + ["after"] * 11})  # fmt: skip
    change = np.append(0.4 * rng.normal(size=6), 1 + 0.9 * rng.normal(size=5))
    first = 3 * rng.normal(size=11)
    found = layout(Design(subject="mouse", occasion="time"), table)
    effect = effects(found, fitted(found, np.append(first - change / 2, first + change / 2)))["interaction", "B"]
    welch = stats.ttest_ind(change[6:], change[:6], equal_var=False)
    assert (effect.p, effect.freedom) == pytest.approx((welch.pvalue, welch.df), rel=1e-4)


def before_and_after(sex, rows=slice(None)):
    """Return 5 + 6 mice before and after, their values, and those of the first and second occasion."""
    rng = np.random.default_rng(31)
    table = pd.DataFrame({"group": (["A"] * 5 + ["B"] * 6) * 2, "mouse": [*range(11)] * 2, "sex": [*sex] * 2,
                          "time": ["before"] * 11 + ["after"] * 11})  # fmt: skip
    first = rng.normal(size=11)
    second = first + 0.4 + 0.3 * rng.normal(size=11) + 0.5 * np.repeat([0, 1], [5, 6])
    return table.iloc[rows].reset_index(drop=True), np.append(first, second)[rows], first, second


_BY_TIME = Design(covariates=("sex",), subject="mouse", occasion="time")


def test_a_sex_that_is_the_group_takes_the_groups_comparison_alone_and_leaves_changes_as_paired_tests_have_them():
    table, y, first, second = before_and_after("mmmmmffffff")
    found = layout(_BY_TIME, table)
    of = effects(found, fitted(found, y))
    assert set(of) == {("factor", "time after"), ("interaction", "B")}
    welch = stats.ttest_ind((second - first)[5:], (second - first)[:5], equal_var=False)
    assert (of["interaction", "B"].p, of["interaction", "B"].freedom) == pytest.approx((welch.pvalue, welch.df), 1e-4)
    mean = np.mean([(second - first)[:5].mean(), (second - first)[5:].mean()])
    assert of["factor", "time after"].value == pytest.approx(mean)
    (lost,) = found.untold
    assert (lost.contrast.label.kind, lost.columns, lost.cells) == ("groups", ("sex",), ())
    assert lost.finding.code == "design.confounded"
    assert found.text.endswith("compared: time after against time before; B against A in the change after/before.")


def test_an_occasion_that_one_group_lacks_leaves_the_groups_at_the_other_and_the_change_within_the_other_group():
    rows = np.r_[0:11, 16:22]  # group A was recorded before alone
    table, y, first, second = before_and_after("mfmfmfmfmfm", rows)
    found = layout(replace(_BY_TIME, covariates=()), table)
    of = effects(found, fitted(found, y))
    where = {one.label.kind: one.label.within for one in found.contrasts}
    assert where == {"groups": "at time before", "factor": "in B"}
    assert of["groups", "B"].value == pytest.approx(first[5:].mean() - first[:5].mean())
    paired = stats.ttest_rel(second[5:], first[5:])
    change = of["factor", "time after"]
    assert (change.p, change.freedom) == pytest.approx((paired.pvalue, 5), rel=1e-4)
    assert [(one.contrast.label.kind, one.cells) for one in found.untold] == [
        (what, ("A, after",)) for what in ("groups", "factor", "interaction")
    ]
    assert {one.contrast.label.kind: bool(one.instead) for one in found.untold} == {
        "groups": True, "factor": True, "interaction": False
    }  # fmt: skip


def test_a_contrast_of_ones_own_on_cells_that_sex_decides_is_told_where_it_cancels():
    """The mean of a cell is not known without sex, but the change in a group is, by whatever name."""
    table, y, first, second = before_and_after("mmmmmffffff")
    own = {"in B": {"B, after": 1, "B, before": -1}, "after": {"B, after": 1, "A, after": -1}}
    found = layout(replace(_BY_TIME, contrasts=own), table)
    assert [one.label.group for one in found.contrasts] == ["in B"]
    assert [one.contrast.label.group for one in found.untold] == ["after"]
    change = effects(found, fitted(found, y))["contrast", "in B"].value
    assert change == pytest.approx((second - first)[5:].mean())
    (side,) = {tuple(one.second) for one in found.contrasts}
    assert not found.has_mean(np.array(side))


def test_known_errors_leave_no_fewer_degrees_of_freedom_than_there_are_without_them():
    """Eight mice of four litters before and after, all that they differ by known; an error that is ten times larger."""
    rng = np.random.default_rng(9)
    table = pd.DataFrame({"group": (["A"] * 4 + ["B"] * 4) * 2, "mouse": [*range(8)] * 2, "litter": [*"KLMN"] * 4,
                          "time": ["before"] * 8 + ["after"] * 8})  # fmt: skip
    found = layout(Design(blocks=("litter",), subject="mouse", occasion="time"), table)
    errors = np.where(np.arange(16) == 3, 1.0, 0.1)
    y = errors * rng.normal(size=16)
    fit = fitted(found, y, errors)
    for one in found.contrasts:
        weights = (one.second - one.first) @ found.means
        assert fit.effect(weights).freedom >= fitted(found, y).effect(weights).freedom


def litters():
    rng = np.random.default_rng(7)
    table = pd.DataFrame(
        {"group": ["A", "B"] * 15, "sex": rng.choice(["f", "m"], 30), "litter": [f"L{i % 6}" for i in range(30)]}
    )
    y = 0.9 * rng.normal(size=6)[np.arange(30) % 6] + rng.normal(size=30) + 0.5 * (table["group"] == "B")
    return table, y.to_numpy()


def one_spread(found):
    """Return a layout whose animals all differ alike, as other programs have them."""
    return replace(found, random={"all": np.eye(len(found.animals)), "litter": found.random["litter"]})


def test_litters_and_sex_are_statsmodels_mixed_model():
    smf = pytest.importorskip("statsmodels.formula.api")
    table, y = litters()
    other = smf.mixedlm("y ~ group + C(sex, Sum)", table.assign(y=y), groups="litter").fit(
        reml=True, method=["powell", "lbfgs"]
    )
    found = one_spread(layout(Design(covariates=("sex",), blocks=("litter",)), table))
    fit = fitted(found, y)
    contrast = (found.contrasts[0].second - found.contrasts[0].first) @ found.means
    assert contrast @ fit.coefficients == pytest.approx(other.params["group[T.B]"], abs=1e-4)
    assert np.sqrt(contrast @ fit.plain @ contrast) == pytest.approx(other.bse["group[T.B]"], abs=1e-4)
    assert fit.components == pytest.approx([other.scale, float(other.cov_re.iloc[0, 0])], abs=1e-4)


@pytest.mark.parametrize(("times", "formula"), [(("0", "3", "6"), "y ~ 0 + C(time)"), (("0", "0"), "y ~ 1")])
def test_occasions_and_second_recordings_of_a_mouse_are_statsmodels_random_effects_in_each_group(times, formula):
    """No mouse is in two groups, so that each group has variances of its own: one `MixedLM` for each is the model.

    It takes recordings near in time for no more alike than others; what allows for that is left out here.
    """
    smf = pytest.importorskip("statsmodels.formula.api")
    rng, count = np.random.default_rng(12), len(times)
    table = pd.DataFrame({"group": (["A"] * 7 + ["B"] * 6) * count, "mouse": [*range(13)] * count,
                          "time": np.repeat(times, 13)})  # fmt: skip
    y = 0.8 * rng.normal(size=13)[table["mouse"]] + rng.normal(size=13 * count) * (0.5 + 0.3 * (table["group"] == "B"))
    design = Design(subject="mouse", occasion="time" if len(set(times)) > 1 else None)
    found = layout(design, table)
    found = replace(found, random={name: one for name, one in found.random.items() if name != DRIFT})
    fit = fitted(found, y.to_numpy())
    components = dict(zip(found.random, fit.components, strict=True))
    errors = np.sqrt(np.einsum("ca,ab,cb->c", found.means, fit.plain, found.means))
    for group in ("A", "B"):
        own = table["group"] == group
        other = smf.mixedlm(formula, table.assign(y=y)[own], groups="mouse").fit(reml=True, method=["powell", "lbfgs"])
        cells = [place for place, cell in enumerate(found.cells) if cell.startswith(group)]
        fixed = len(other.fe_params)
        assert found.means[cells] @ fit.coefficients == pytest.approx(other.fe_params.to_numpy(), abs=1e-4)
        assert errors[cells] == pytest.approx(other.bse.to_numpy()[:fixed], abs=1e-4)
        part = found.cell[own.to_numpy()].min()
        of_group = [components[f"{kind} {part}"] for kind in ("animals", "subjects")]
        assert of_group == pytest.approx([other.scale, float(other.cov_re.iloc[0, 0])], abs=1e-4)


def weeks(mice, times):
    """Return a table of two groups of so many mice each, week by week."""
    return pd.DataFrame({"group": (["A"] * mice + ["B"] * mice) * len(times), "mouse": [*range(2 * mice)] * len(times),
                         "time": np.repeat(times, 2 * mice)})  # fmt: skip


@pytest.mark.parametrize("times", [(0, 3, 6), (0, 1, 2, 6)])
def test_standard_errors_of_mice_whose_weeks_are_correlated_are_those_of_the_correlation_that_they_have(times):
    """Drawn with a correlation of 0.8 for each step; without a drift of mice the last change gets 0.8 of its error.

    Twelve mice a group, 8 cohorts: the standard error of a change is itself known within 5 %.
    """
    table, rng = weeks(12, times), np.random.default_rng(21)
    found = layout(Design(subject="mouse", occasion="time"), table)
    steps = np.abs(np.subtract.outer(times, times)) / times[1]
    true = 0.8**steps
    errors = []
    for _ in range(8):
        y = np.linalg.cholesky(true) @ rng.standard_normal((len(times), 24))
        errors.append({name: one.error for name, one in effects_by_time(found, fitted(found, y.ravel())).items()})
    seen = np.sqrt((pd.DataFrame(errors) ** 2).mean())
    last = f"time {times[-1]}"
    change = 2 * (1 - true[0, -1])
    assert seen["groups", "B"] == pytest.approx(np.sqrt(true.mean() * 2 / 12), rel=0.12)
    assert seen["factor", last] == pytest.approx(np.sqrt(change / 24), rel=0.12)
    assert seen["interaction", f"{times[-1]}/{times[0]}"] == pytest.approx(np.sqrt(change * 2 / 12), rel=0.12)


def effects_by_time(found, fit):
    return {(one.label.kind, one.label.change or one.label.group): fit.effect((one.second - one.first) @ found.means)
            for one in found.contrasts}  # fmt: skip


def test_a_drift_of_mice_is_that_of_a_restricted_likelihood_by_scipy():
    """Weeks 0, 1 and 6 of nine mice: covariances that fall in a straight line with the weeks between."""
    from scipy.optimize import minimize

    times = np.array([0.0, 1.0, 6.0])
    table = weeks(9, (0, 1, 6))[lambda one: one["group"] == "A"].reset_index(drop=True)
    rng = np.random.default_rng(17)
    y = 0.5 * rng.standard_normal((3, 9)) + np.cumsum(rng.standard_normal((3, 9)), axis=0)  # (week, mouse)

    def of_a_mouse(logs):
        animal, subject, drift = np.exp(logs)
        return animal * np.eye(3) + subject + drift * (1 - np.abs(np.subtract.outer(times, times)) / 6)

    def lost(logs):
        """Nine mice with three means of their own: in differences of mice eight independent ones are left."""
        inside = of_a_mouse(logs)
        centered = y - y.mean(axis=1, keepdims=True)
        return 8 * np.linalg.slogdet(inside)[1] + np.sum(centered * np.linalg.solve(inside, centered))

    best = minimize(lost, np.zeros(3), method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-10, "maxiter": 4000})
    found = layout(Design(subject="mouse", occasion="time"), table)
    fit = fitted(found, y.ravel())
    assert fit.components == pytest.approx(np.exp(best.x), rel=1e-3)
    inside = of_a_mouse(best.x)
    for later in (1, 2):
        weights = np.array([[-1.0, later == 1, later == 2]])
        (one,) = (one for one in found.contrasts if one.label.group == f"time {int(times[later])}")
        contrast = (one.second - one.first) @ found.means
        assert contrast @ fit.plain @ contrast == pytest.approx((weights @ inside @ weights.T).item() / 9, rel=1e-3)


@pytest.mark.parametrize(
    ("design", "table", "freedom"),
    [
        (Design(subject="mouse", occasion="time"), "pairs", {"factor": 8}),
        (Design(blocks=("litter",)), "across", {"groups": 12 - 6 - 1}),
        (Design(blocks=("litter",)), "within", {"groups": 6 - 2}),
        (Design(blocks=("litter",), covariates=("sex",), subject="mouse", occasion="time"), "reviewed",
         {"groups": 8 - 2 - 1 - 3, "factor": 16 - 8 - 2, "interaction": 16 - 8 - 2}),
    ],
)  # fmt: skip
def test_degrees_left_by_a_design_are_those_of_kenward_and_roger_where_it_is_balanced(design, table, freedom):
    """One variance for all rows, blocks that differ more than animals, and animals more than their rows."""
    rows = {
        "pairs": pd.DataFrame({"group": "A", "mouse": [*range(9)] * 2, "time": ["0"] * 9 + ["1"] * 9}),
        "across": pd.DataFrame({"group": ["A", "B"] * 6, "litter": np.repeat([f"L{i}" for i in range(6)], 2)}),
        "within": pd.DataFrame({"group": ["A"] * 9 + ["B"] * 9, "litter": np.repeat([f"L{i}" for i in range(6)], 3)}),
        "reviewed": pd.DataFrame({"group": (["A"] * 4 + ["B"] * 4) * 2, "mouse": [*range(8)] * 2,
                                  "sex": [*"fmfm", *"mfmf"] * 2, "litter": [*"KLMN"] * 4,
                                  "time": ["before"] * 8 + ["after"] * 8}),
    }[table]  # fmt: skip
    found = layout(design, rows)
    left = {one.label.kind: degrees_left(found, design.blocks, one) for one in found.contrasts}
    assert left == freedom
    rng = np.random.default_rng(4)
    y = rng.normal(size=len(rows))
    random = {"all": np.eye(len(rows))}
    for column, size in (("mouse", 3.0), ("litter", 30.0)):
        if column in rows:
            names, which = np.unique(rows[column], return_inverse=True)
            y += size * rng.normal(size=len(names))[which]
            random[column] = np.equal.outer(which, which).astype(float)
    fit = fitted(replace(found, random=random), y)
    assert min(fit.components) > 0
    for one in found.contrasts:
        assert fit.effect((one.second - one.first) @ found.means).freedom == pytest.approx(
            freedom[one.label.kind], rel=1e-3
        )


_SCRIPT = """
suppressMessages({library(lme4); library(pbkrtest)})
options(contrasts = c("contr.treatment", "contr.poly"))
d <- read.csv("data.csv", stringsAsFactors = TRUE)
for (name in c("time", "dose")) if (name %in% names(d)) d[[name]] <- factor(d[[name]])
if ("sex" %in% names(d)) contrasts(d$sex) <- contr.sum(2)
exact <- lmerControl(optCtrl = list(xtol_rel = 1e-12, ftol_abs = 1e-14))
m <- lmer(FORMULA, d, control = exact)
V <- vcovAdj(m)
for (L in list(CONTRASTS))
  cat(sum(L * fixef(m)), sqrt(as.numeric(L %*% as.matrix(V) %*% L)), Lb_ddf(L, vcov(m), V), "\\n")
cat(sigma(m)^2, as.numeric(VarCorr(m)[[1]]), 0, "\\n")
"""


def lme4(folder, table, formula, contrasts):
    """Return value, error and Kenward and Roger's freedom of every contrast, a row each, and the two variances."""
    table.to_csv(folder / "data.csv", index=False)
    rows = ", ".join(f"c({', '.join(map(str, row))})" for row in contrasts)
    (folder / "fit.R").write_text(_SCRIPT.replace("FORMULA", formula).replace("CONTRASTS", rows), encoding="utf-8")
    said = subprocess.run(
        ["Rscript", "fit.R"], cwd=folder, capture_output=True, text=True, encoding="utf-8", check=False
    )
    if "there is no package" in said.stderr:
        pytest.skip("R has no lme4 or pbkrtest")
    assert said.returncode == 0, said.stderr
    *found, variances = np.array([line.split() for line in said.stdout.splitlines()], float)
    return np.array(found), variances[:2]


def made(table, by):
    """Return a table with values that litters or mice have in common, and an effect of the group."""
    rng = np.random.default_rng(11)
    which = np.unique(table[by], return_inverse=True)[1]
    y = 0.9 * rng.normal(size=which.max() + 1)[which] + rng.normal(size=len(table))
    return table.assign(y=y + 0.5 * (table["group"] == table["group"].iloc[-1]))


def litters_of(table, count):
    return table.assign(litter=[f"L{i % count}" for i in range(len(table))])


_TIMES = pd.DataFrame({"group": ["A"] * 27, "mouse": [f"m{i}" for i in range(9)] * 3,
                       "time": np.repeat(["0", "3", "6"], 9)})  # fmt: skip
_WEEKS = pd.DataFrame({"group": (["A"] * 7 + ["B"] * 6) * 3, "mouse": [f"m{i}" for i in range(13)] * 3,
                       "time": np.repeat(["0", "3", "6"], 13)})  # fmt: skip
_DOSES = pd.DataFrame({"group": np.repeat([*"ABCD"], [7, 6, 5, 6]), "dose": np.repeat([0.0, 1, 3, 10], [7, 6, 5, 6])})
_FACTORS = pd.DataFrame(
    {"group": ["A"] * 13 + ["B"] * 12, "oxygen": (["air"] * 6 + ["low"] * 7) + ["air"] * 5 + ["low"] * 7}
)
_SLOPE = 10 * (np.array([0.0, 1, 3, 10]) - 3.5) / np.sum((np.array([0.0, 1, 3, 10]) - 3.5) ** 2)
_SAME = {
    "pairs": (_TIMES[:18], "mouse", Design(subject="mouse", occasion="time"), "y ~ time + (1|mouse)", [(0, 1)]),
    "occasions of one group": (_TIMES, "mouse", Design(subject="mouse", occasion="time"), "y ~ time + (1|mouse)",
                               [(0, 1, 0), (0, 0, 1)]),
    "occasions of two groups": (
        _WEEKS, "mouse", Design(subject="mouse", occasion="time"), "y ~ group * time + (1|mouse)",
        [(0, 1, 0, 0, 1 / 3, 1 / 3), (0, 0, 1, 0, 0.5, 0), (0, 0, 0, 1, 0, 0.5), (0, 0, 0, 0, 1, 0),
         (0, 0, 0, 0, 0, 1)],
    ),
    "litters and sex": (
        litters_of(pd.DataFrame({"group": ["A", "B"] * 15, "sex": [*"fmmfffmfmmfmfmfffmmmmfmfmfffmm"]}), 6), "litter",
        Design(covariates=("sex",), blocks=("litter",)), "y ~ group + sex + (1|litter)", [(0, 1, 0)],
    ),
    "doses and litters": (litters_of(_DOSES, 5), "litter", Design(dose="dose", blocks=("litter",)),
                          "y ~ 0 + dose + (1|litter)", [_SLOPE]),
    "two factors and litters": (
        litters_of(_FACTORS, 6), "litter", Design(factor="oxygen", blocks=("litter",)),
        "y ~ group * oxygen + (1|litter)", [(0, 1, 0, 0.5), (0, 0, 1, 0.5), (0, 0, 0, 1)],
    ),
}  # fmt: skip
"""Table, what its rows have in common, the design, lme4's formula, and our effects by its coefficients."""


@pytest.mark.validation
@pytest.mark.skipif(shutil.which("Rscript") is None, reason="R with lme4 and pbkrtest is not installed")
@pytest.mark.parametrize("name", _SAME)
def test_effects_errors_freedom_and_variances_are_those_of_lme4_and_pbkrtest(name, tmp_path):
    """One variance for all rows, as lme4 has it; ours has one for each cell, or for cells that subjects link."""
    table, by, design, formula, contrasts = _SAME[name]
    table = made(table.reset_index(drop=True), by)
    theirs, variances = lme4(tmp_path, table, formula, contrasts)
    found = layout(design, table.drop(columns="y"))
    alike = np.equal.outer(table[by].to_numpy(), table[by].to_numpy()).astype(float)
    fit = fitted(replace(found, random={"all": np.eye(len(table)), by: alike}), table["y"].to_numpy())
    assert fit.components == pytest.approx(variances, abs=1e-4)
    for one, (value, error, freedom) in zip(found.contrasts, theirs, strict=True):
        ours = fit.effect((one.second - one.first) @ found.means)
        assert (ours.value, ours.error) == pytest.approx((value, error), abs=1e-4), one
        assert ours.freedom == pytest.approx(freedom, rel=1e-4), one


def test_a_trend_with_doses_of_equal_groups_is_the_slope_of_their_means():
    rng = np.random.default_rng(5)
    table = pd.DataFrame({"group": np.repeat([*"ABCD"], 5), "dose": np.repeat([0.0, 1, 3, 10], 5)})
    y = rng.normal(size=20) + 0.1 * table["dose"].to_numpy()
    found = layout(Design(dose="dose"), table)
    (effect,) = effects(found, fitted(found, y)).values()
    means = y.reshape(4, 5).mean(axis=1)
    assert effect.value == pytest.approx(10 * np.polyfit([0, 1, 3, 10], means, 1)[0])
    assert found.contrasts[0].label.group == "dose 10"


def test_groups_of_doses_of_their_own_have_a_trend_each_and_the_difference_of_these():
    """WT is 1 + 2 d at doses 0, 1, 4, KO is 3 + 5 d at 0, 2, 4: on 4 of dose 14 in the mean, 12 between the groups."""
    table = pd.DataFrame({"group": ["WT"] * 6 + ["KO"] * 6, "dose": np.repeat([0.0, 1, 4, 0, 2, 4], 2)})
    y = np.repeat([1.0, 3.0, 9.0, 3.0, 13.0, 23.0], 2) + np.tile([0.1, -0.1], 6)
    found = layout(Design(dose="dose"), table)
    values = {key: one.value for key, one in effects(found, fitted(found, y)).items()}
    assert values == pytest.approx(
        {("trend", "dose 4"): 14.0, ("interaction", "KO"): 12.0, ("groups", "KO"): 13 - 13 / 3}
    )
    assert found.contrasts[1].label.change == "dose 4/dose 0"


def test_two_factors_give_main_effects_and_the_difference_of_differences():
    table = pd.DataFrame({"group": ["WT"] * 8 + ["KO"] * 8, "oxygen": (["air"] * 4 + ["low"] * 4) * 2})
    y = np.repeat([1.0, 2.0, 3.0, 7.0], 4) + np.tile([0.1, -0.1, 0.2, -0.2], 4)
    found = layout(Design(factor="oxygen"), table)
    values = {key: one.value for key, one in effects(found, fitted(found, y)).items()}
    assert values == pytest.approx({("groups", "KO"): 3.5, ("factor", "oxygen low"): 2.5, ("interaction", "KO"): 3.0})
    alone = layout(Design(factor="oxygen", interaction=False), table)
    assert {one.label.kind for one in alone.contrasts} == {"groups", "factor"}
    own = layout(Design(factor="oxygen", contrasts={"rescue": {"KO, low": 1, "WT, low": -1}}), table)
    assert effects(own, fitted(own, y))["contrast", "rescue"].value == pytest.approx(5.0)


@pytest.mark.validation
def test_known_errors_are_taken_from_what_animals_differ_and_shared_ones_are_not_averaged_away():
    rng = np.random.default_rng(6)
    table = pd.DataFrame({"group": ["A"] * 400 + ["B"] * 400, "sex": ["f", "m"] * 400})
    errors = np.where(np.arange(800) % 4 < 2, 0.2, 1.0)
    y = 0.5 * rng.normal(size=800) + errors * rng.normal(size=800)
    found = layout(Design(covariates=("sex",)), table)
    fit = fitted(found, y, errors)
    assert fit.components == pytest.approx(0.25, abs=0.06)  # three standard errors of a variance of 400
    image = np.diag(errors**2) + 0.3**2 * np.equal.outer(table["group"].to_numpy(), table["group"].to_numpy())
    shared = fit_mixed(y, Structure(found.fixed, list(found.random.values()), image))
    contrast = (found.contrasts[0].second - found.contrasts[0].first) @ found.means
    assert shared.effect(contrast).error == pytest.approx(
        np.sqrt(2 * 0.3**2 + fit.effect(contrast).error ** 2), rel=0.02
    )


def test_a_column_is_named_with_or_without_its_unit():
    assert Design(covariates=("Weight [g]",), dose="Dose [mg/kg]") == Design(covariates=("weight",), dose="dose")


def test_what_no_design_can_tell_is_refused_with_the_reason():
    table = pd.DataFrame(
        {"group": ["A"] * 6 + ["B"] * 6, "litter": ["L1"] * 6 + ["L2"] * 6, "sex": [*"fm"] * 6, "note": [""] * 12}
    )
    for design, words in (
        (Design(blocks=("litter",)), "'litter' cannot be told apart"),
        (Design(covariates=("sx",)), r"no column 'sx' \(did you mean 'sex'\?\)"),
        (Design(dose="sex"), "a dose needs numbers"),
        (Design(covariates=("note",)), "column 'note' is empty"),
        (Design(contrasts={"x": {"A": 1, "C": -1}}), "no cell 'C'"),
    ):
        with pytest.raises(InputError, match=words):
            layout(design, table)
    for more, words in (
        ({"factor": "a", "dose": "b"}, "a design has one of these"),
        ({"blocks": ("a",), "subject": "a"}, "two places"),
        ({"occasion": "a"}, "which recordings are of one animal as subject"),
        ({"contrasts": {"x": {"A": 1, "B": 1}}}, "sum to 0"),
        ({"crossover": True}, "which recordings are of one animal as subject"),
    ):
        with pytest.raises(InputError, match=words):
            Design(**more)


def test_a_litter_that_an_animal_shares_with_none_and_a_covariate_of_one_group_change_no_estimate_of_others():
    table = pd.DataFrame({"group": ["A"] * 6 + ["B"] * 6, "cage": [f"C{i}" for i in range(12)]})
    found = layout(Design(blocks=("cage",)), table)
    assert all(name.startswith("animals") for name in found.random)  # each cage is one animal: nothing to tell it from


@pytest.mark.validation
def test_without_an_effect_a_design_with_sex_and_litters_finds_one_as_often_as_it_says():
    rng, false, covered = np.random.default_rng(8), 0, 0
    table, _ = litters()
    found = layout(Design(covariates=("sex",), blocks=("litter",)), table)
    contrasts = np.array([(one.second - one.first) @ found.means for one in found.contrasts])
    for _ in range(200):
        models = []
        for _ in range(2):
            errors = 0.5 * np.exp(0.4 * rng.normal(size=30))
            y = 0.65 * rng.normal(size=6)[np.arange(30) % 6] + rng.normal(size=30) + errors * rng.normal(size=30)
            models.append(Fitted(fitted(found, y, errors), np.arange(30), contrasts))
        together = joint(models, 399, 0)
        false += together.p.min() < 0.05
        outside = [one.p < together.critical for model in models for one in model.effects]
        assert outside == (together.p < 0.05).tolist()  # an interval excludes 1 exactly if p < 0.05
        covered += not any(outside)
    assert false / 200 < 0.05 + 3 * np.sqrt(0.05 * 0.95 / 200)


def designed(**design):
    """Return a primary comparison of 6 + 6 animals of two litters each, measured values only."""
    results = made_results({"CTL": 6, "HPH": 6}, walls=())
    of = {result.name: place for place, result in enumerate(results)}
    columns = [Variable.from_cells("sex", {name: "fmm"[place % 3] for name, place in of.items()}),
               Variable.from_cells("litter", {name: f"L{place % 4}" for name, place in of.items()
                                              if place != 3})]  # fmt: skip
    return primary_comparison(gathered(results, variables=columns, design=Design(**design)))


def test_a_cohort_of_a_design_has_the_rows_of_its_effects_and_names_who_is_left_out():
    found = designed(covariates=("sex",))
    rows = found.table()
    assert set(rows["what"]) == {"groups"}
    np.testing.assert_allclose(rows["mean other"] / rows["mean reference"], rows["ratio"])
    outside = (rows["low"] > 1) | (rows["high"] < 1)
    assert outside.tolist() == (rows["p"] < 0.05).tolist()
    half = np.log(rows["high"] / rows["low"]) / 2
    level = 2 * stats.t.sf(half / rows["standard error"], rows["df"])  # of each by itself
    np.testing.assert_allclose(level, level[0])
    assert level[0] < 0.05
    row = designed(blocks=("litter",))
    assert Omission("its cell of 'litter' is empty", animal="CTL 4") in row.left_out
    assert {effect.n_reference for effect in row.effects} == {5}


def test_a_cohort_whose_sex_is_its_group_says_what_cannot_be_compared_once_and_why_and_keeps_the_rest():
    results = made_results({"CTL": 8, "HPH": 8}, walls=())
    names = [result.name for result in results]
    columns = [Variable.from_cells("mouse", {name: f"M{place // 2}" for place, name in enumerate(names)}),
               Variable.from_cells("time", {name: ("vor", "nach")[place % 2] for place, name in enumerate(names)}),
               Variable.from_cells("sex", {result.name: "mf"[result.group == "HPH"]
                                           for result in results})]  # fmt: skip
    cohort = gathered(results, variables=columns, design=_BY_TIME)
    found = primary_comparison(cohort)
    assert {effect.contrast.kind for effect in found.effects} == {"factor", "interaction"}
    (missed,) = found.untold
    assert dict(missed.finding.values)["effect"] == "HPH against CTL"
    assert set(missed.quantities) == {effect.quantity for effect in found.effects}
    (said,) = not_told(found, str)
    assert "HPH against CTL: not compared, for sex" in said
    outside = [effect.low > 1 or effect.high < 1 for effect in found.effects]
    assert outside == [effect.p < 0.05 for effect in found.effects]


def test_what_a_missing_cell_takes_away_is_said_once_for_all_effects_that_need_it():
    """No animal of HPH was recorded afterwards: neither its change nor that it differs is told."""
    results = made_results({"CTL": 8, "HPH": 4}, walls=())
    names = [result.name for result in results]
    mice = {name: f"M{place // 2 if place < 8 else place}" for place, name in enumerate(names)}
    times = {name: ("vor", "nach")[place % 2 if place < 8 else 0] for place, name in enumerate(names)}
    columns = [Variable.from_cells("mouse", mice), Variable.from_cells("time", times)]
    found = primary_comparison(gathered(results, variables=columns, design=replace(_BY_TIME, covariates=())))
    assert len(found.untold) > 1
    said = not_told(found, str)
    assert len(said) < len(found.untold)
    assert " ".join(said).count("not compared") == len(said)
    for missed in found.untold:
        assert str(dict(missed.finding.values)["effect"]) in " ".join(said)


@pytest.mark.parametrize(
    ("images", "untested"),
    [("of each mouse", False), ("of each group", True), pytest.param("one", False, marks=pytest.mark.validation)],
)
def test_the_recordings_of_one_mouse_have_its_own_image_and_no_shared_one(images, untested):
    """Four mice a group, each recorded twice. One image in both groups cancels out of their ratio."""
    results = made_results({"CTL": 8, "HPH": 8}, walls=("linear",))
    mice, times, seen = {}, {}, []
    for place, result in enumerate(results):
        mice[result.name], times[result.name] = f"mouse {place // 2}", ("before", "after")[place % 2]
        number = {"of each mouse": place // 2, "of each group": place // 8, "one": 0}[images]
        network = results[0].network
        seen.append(replace(result, network=replace(network, length=network.length * (1 + 0.01 * number))))
    columns = [Variable.from_cells("mouse", mice), Variable.from_cells("time", times)]
    design = Design(subject="mouse", occasion="time")
    rows = primary_comparison(gathered(seen, variables=columns, design=design)).table()
    rows = rows[rows["source"] == "linear"].set_index(["quantity", "what"])
    assert (rows.xs("groups", level="what")["untested"] == "one image").all() == untested
    assert (rows.drop("groups", level="what")["untested"] == "").all()  # within each mouse its image cancels


def test_the_effect_of_a_covariate_is_that_of_weighted_least_squares_in_other_coordinates():
    """Columns of 0 and 1 with an intercept, weighted by the variances that the model found: effects do not differ."""
    rng = np.random.default_rng(8)
    results = made_results({"CTL": 9, "HPH": 9}, walls=())
    names = [result.name for result in results]
    sex = {name: "fmd"[place % 3] for place, name in enumerate(names)}
    weight = {name: f"{22 + 3 * rng.standard_normal():.2f}" for name in names}
    known = [Variable.from_cells("sex", sex), Variable.from_cells("weight [g]", weight)]
    cohort = gathered(results, variables=known, design=Design(covariates=("sex", "weight")))
    effects = primary_comparison(cohort, Family(quantities=("CO",))).adjusted
    fit = modeled(cohort, known_values(cohort, "measured", "CO", ["CTL", "HPH"])).fit
    grams = np.array([float(one) for one in weight.values()])
    columns = [[1.0] * 18, [one.group == "HPH" for one in results], *([one == level for one in sex.values()]
               for level in "md"), grams / grams.std()]  # fmt: skip
    X, inverse = np.column_stack(columns).astype(float), np.linalg.inv(fit.root @ fit.root.T)
    y = np.log([float(one.measured.quantities["CO"]) for one in results])
    covariance = np.linalg.inv(X.T @ inverse @ X)
    expected = covariance @ X.T @ inverse @ y
    labels = ["sex: m / f", "sex: d / f", f"weight, {grams.std():.3g} g more"]
    assert [effect.covariate for effect in effects] == labels
    np.testing.assert_allclose(np.log([effect.ratio for effect in effects]), expected[2:], rtol=1e-8)
    # Kenward and Roger's errors are not below those of known variances, and t not below the normal distribution.
    reach = np.log([effect.high / effect.ratio for effect in effects])
    assert (reach > 1.96 * np.sqrt(np.diag(covariance)[2:])).all()


def test_a_covariate_that_says_what_groups_say_has_no_effect_of_its_own():
    results = made_results({"CTL": 5, "HPH": 5}, walls=())
    same = Variable.from_cells("chip", {result.name: result.group for result in results})
    cohort = gathered(results, variables=[same], design=Design(covariates=("chip",)))
    assert primary_comparison(cohort, Family(quantities=("CO",))).adjusted == ()


@pytest.mark.parametrize(("count", "words"), [(1, "1 animal is too few"), (3, "3 animals are too few")])
def test_animals_that_are_too_few_for_a_design_are_counted(count, words):
    table = pd.DataFrame({"group": ["A", "B", "A"][:count], "weight": [1.0, 2.0, 4.0][:count]})
    with pytest.raises(InputError, match=words):
        layout(Design(covariates=("weight",)), table)
