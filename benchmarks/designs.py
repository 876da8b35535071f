"""How often the model of a design finds what is not there, holds what is, and finds it: beside a lab's usual tests.

Run: python benchmarks/designs.py [--cohorts 500] [--draws 999] [--only NAME] [--guard] [--docs]

Cohorts are drawn at the level of logarithms, each animal's known error emulating its posterior's. Three quantities,
correlated by 0.6 in animals, litters and errors of images alike. The method was chosen on the rows that are not called
unseen; those were looked at once, after that. With --guard: what the page says of animals that are not what the test
takes them for, beside what the method does with such animals. They are drawn here in another way than there: skewed
quantities are often the same value, responders respond in all quantities at once.
"""

import argparse
import zlib
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy import stats

from robustness_page import put
from vasowave.study.cohort import (
    RULES,
    Design,
    Fitted,
    Layout,
    PopulationShape,
    Structure,
    Variable,
    doubts_of,
    fit_mixed,
    holm,
    joint,
    laid_out,
)

COUNT = 3  # quantities
ROOT = np.linalg.cholesky(0.6 + 0.4 * np.eye(COUNT))
_AGAIN = (
    "sex, 8 + 8", "litters across groups, 9 + 9", "two factors, 4 × 6", "before and after, 7 + 6", "four doses of 5",
)  # fmt: skip
PAGE = Path(__file__).parents[1] / "docs" / "comparisons.md"
Noise = Callable[[np.random.Generator, tuple[int, ...]], np.ndarray]


class Kind(NamedTuple):
    """One kind of study.

    Attributes
    ----------
    design : Design
    table : DataFrame
        The columns of its animals, `group` among them.
    effect : array
        What the first quantity has of an effect, by animal, in SD of the animals.
    spread : array
        SD of the animals' true values (1 in the reference).
    litter, subject : float
        SD of the random effects.
    error : float
        Median of the known errors.
    unlike : float
        Factor by which these differ between animals.
    image : float
        SD of the error of an image that a group shares.
    serial : float
        Correlation of a subject's true values from one time to the next, beside what they have in common; 1: a random
        walk. Rows stand time by time.
    usual : callable
        Returns p of each quantity and effect from table and values, as a lab computes them.
    noise : callable
        Draws scores of variance 1.
    """

    design: Design
    table: pd.DataFrame
    effect: np.ndarray
    spread: np.ndarray
    litter: float
    subject: float
    error: float
    unlike: float
    image: float
    serial: float
    usual: Callable[[pd.DataFrame, np.ndarray], np.ndarray]
    noise: Noise


def normal(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Return normal scores."""
    return rng.standard_normal(shape)


def skewed(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Return scores skewed by 1, as of a gamma distribution."""
    return (rng.gamma(4.0, 1.0, shape) - 4) / 2


def heavy(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Return scores of Student's t with three degrees."""
    return rng.standard_t(3, shape) / np.sqrt(3)


def t_tests(table: pd.DataFrame, values: np.ndarray) -> np.ndarray:
    """Return Student's tests of every group against the first."""
    first, *others = dict.fromkeys(table["group"])
    own = (table["group"] == first).to_numpy()
    return np.array([stats.ttest_ind(values[(table["group"] == one).to_numpy()], values[own]).pvalue for one in others])


def paired(table: pd.DataFrame, values: np.ndarray) -> np.ndarray:
    """Return the paired test of the second occasion against the first."""
    first, second = (values[(table["time"] == one).to_numpy()] for one in ("before", "after"))
    return np.array([stats.ttest_rel(second, first).pvalue])


def of_changes(table: pd.DataFrame, values: np.ndarray) -> np.ndarray:
    """Return tests between groups of means and of changes, and the paired one of all."""
    first, second = (values[(table["time"] == one).to_numpy()] for one in ("before", "after"))
    other = (table["group"] != table["group"].iloc[0]).to_numpy()[(table["time"] == "before").to_numpy()]
    return np.array([
        stats.ttest_ind((first + second)[other], (first + second)[~other]).pvalue,
        stats.ttest_rel(second, first).pvalue,
        stats.ttest_ind((second - first)[other], (second - first)[~other]).pvalue,
    ])  # fmt: skip


def repeated(table: pd.DataFrame, values: np.ndarray) -> np.ndarray:
    """Return tests of the groups' means, of each later time against the first, and of the changes between groups."""
    first, *later = (values[(table["time"] == one).to_numpy()] for one in dict.fromkeys(table["time"]))
    other = (table["group"] != table["group"].iloc[0]).to_numpy()[: len(first)]
    mean = first + sum(later)
    changes = [one - first for one in later]
    return np.array([
        stats.ttest_ind(mean[other], mean[~other]).pvalue,
        *(stats.ttest_1samp(one, 0.0).pvalue for one in changes),
        *(stats.ttest_ind(one[other], one[~other]).pvalue for one in changes),
    ])  # fmt: skip


def anova(formula: str) -> Callable[[pd.DataFrame, np.ndarray], np.ndarray]:
    """Return an analysis of variance by statsmodels, type II, and its p without the residuals' row."""
    import statsmodels.api as sm
    import statsmodels.formula.api as smf

    def of(table: pd.DataFrame, values: np.ndarray) -> np.ndarray:
        return np.column_stack([
            sm.stats.anova_lm(smf.ols(f"y ~ {formula}", table.assign(y=one)).fit(), typ=2)["PR(>F)"].to_numpy()[:-1]
            for one in values.T
        ])  # fmt: skip

    return of


def kind(design: Design, table: pd.DataFrame, effect: Any, **more: Any) -> Kind:
    """Return a kind of study with what is not said left out."""
    given = {
        "spread": 1.0,
        "litter": 0.0,
        "subject": 0.0,
        "error": 0.4,
        "unlike": 1.5,
        "image": 0.0,
        "serial": 0.0,
        "usual": t_tests,
        "noise": normal,
    }
    given |= more
    given["spread"] = np.broadcast_to(given["spread"], len(table))
    return Kind(design, table, np.asarray(effect, float), **given)


def groups(*sizes: int) -> pd.DataFrame:
    """Return a table of groups A, B, … of these sizes."""
    return pd.DataFrame({"group": [label for label, size in zip("ABCDEF", sizes, strict=False) for _ in range(size)]})


def kinds() -> dict[str, Kind]:
    """Return all kinds of study."""
    two, few, large = groups(8, 8), groups(5, 5), groups(14, 9)
    sex = two.assign(sex=["f", "m"] * 3 + ["f"] * 2 + ["f", "m", "m", "m"] * 2)
    other = (two["group"] == "B").to_numpy(float)
    litter = groups(9, 9).assign(litter=[f"L{i % 6}" for i in range(18)])
    nested = groups(12, 12).assign(litter=[f"L{i // 3}" for i in range(24)])
    pairs = pd.DataFrame({"group": ["A"] * 16, "mouse": [*range(8)] * 2, "time": ["before"] * 8 + ["after"] * 8})
    after = (pairs["time"] == "after").to_numpy(float)
    changes = pd.DataFrame({"group": (["A"] * 7 + ["B"] * 6) * 2, "mouse": [*range(13)] * 2,
                            "time": ["before"] * 13 + ["after"] * 13})  # fmt: skip
    changed = ((changes["time"] == "after") & (changes["group"] == "B")).to_numpy(float)
    all_of = changes.assign(sex=[*"fmmffmf", *"mfmfmm"] * 2, litter=[f"L{i % 4}" for i in range(13)] * 2)
    weeks = pd.DataFrame({"group": (["A"] * 6 + ["B"] * 6) * 3, "mouse": [*range(12)] * 3,
                          "time": np.repeat(["0", "3", "6"], 12)})  # fmt: skip
    later = ((weeks["time"] == "6") & (weeks["group"] == "B")).to_numpy(float)
    months = pd.DataFrame({"group": (["A"] * 5 + ["B"] * 5) * 4, "mouse": [*range(10)] * 4,
                           "time": np.repeat(["0", "1", "2", "6"], 10)})  # fmt: skip
    last = ((months["time"] == "6") & (months["group"] == "B")).to_numpy(float)
    twice = pd.concat([groups(7, 5).assign(mouse=range(12))] * 2, ignore_index=True)
    dose = groups(5, 5, 5, 5).assign(dose=np.repeat([0.0, 1, 2, 3], 5))
    both = pd.DataFrame({"group": ["A"] * 12 + ["B"] * 12, "oxygen": (["air"] * 6 + ["low"] * 6) * 2})
    low, mutant = (both["oxygen"] == "low").to_numpy(float), (both["group"] == "B").to_numpy(float)
    image = groups(7, 5).assign(sex=[*"fmfmfmf", *"mfmfm"])
    uneven = groups(7, 5).assign(sex=[*"fmfmfmf", *"mfmfm"])
    second = (uneven["group"] == "B").to_numpy(float)
    few_litters = few.assign(litter=[f"L{i % 3}" for i in range(10)])
    large_sex = large.assign(sex=[*"fmfmfmfmfmfmfm", *"mfmfmfmfm"], litter=[f"L{i % 7}" for i in range(23)])
    of_large = (large["group"] == "B").to_numpy(float)
    mixed = np.sqrt(0.3 / 0.7)  # of litters whose intraclass correlation is 0.3
    by_litter, by_time, by_oxygen = (
        Design(blocks=("litter",)), Design(subject="mouse", occasion="time"), Design(factor="oxygen"),
    )  # fmt: skip
    by_sex, together = Design(covariates=("sex",)), anova("C(group) * C(oxygen)")
    additive = Design(factor="oxygen", interaction=False)
    by_all = Design(covariates=("sex",), blocks=("litter",), subject="mouse", occasion="time")
    sex_and_litter = Design(covariates=("sex",), blocks=("litter",))
    in_second = {"litter": litter["group"] == "B", "nested": nested["group"] == "B", "few": few["group"] == "B"}
    cases = {
        "sex, 8 + 8": kind(by_sex, sex, 1.6 * other),
        "litters across groups, 9 + 9": kind(by_litter, litter, 1.6 * in_second["litter"], litter=mixed),
        "litters within groups, 12 + 12": kind(by_litter, nested, 1.6 * in_second["nested"], litter=mixed),
        "pairs, 8": kind(by_time, pairs, 1.2 * after, subject=1.5, usual=paired),
        "before and after, 7 + 6": kind(by_time, changes, 2.2 * changed, subject=1.5, usual=of_changes),
        "three weeks of the same mice, 6 + 6": kind(by_time, weeks, 2.2 * later, subject=1.5, usual=repeated),
        "three weeks, correlated by 0.8 a time, 6 + 6": kind(
            by_time, weeks, 2.2 * later, subject=1.5, usual=repeated, serial=0.8
        ),
        "three weeks, a random walk, 6 + 6": kind(by_time, weeks, 2.2 * later, subject=1.5, usual=repeated, serial=1.0),
        "two recordings of each mouse, 7 + 5": kind(
            Design(subject="mouse"), twice, 2.2 * (twice["group"] == "B"), spread=0.5, subject=1.0
        ),
        "four doses of 5": kind(Design(dose="dose"), dose, 0.5 * dose["dose"]),
        "two factors, 4 × 6": kind(by_oxygen, both, 2.0 * low * mutant, usual=together),
        "two factors without interaction, 4 × 6": kind(
            additive, both, 1.2 * mutant, usual=anova("C(group) + C(oxygen)")
        ),
        "one image for each group and sex, 7 + 5": kind(by_sex, image, 2.0 * second, image=0.5),
        "SD × 2.5 and sex, 7 + 5": kind(by_sex, uneven, 3.0 * second, spread=1 + 1.5 * second),
        "two factors, SD × 2 with low oxygen": kind(
            by_oxygen, both, 2.5 * low * mutant, spread=1 + low, usual=together
        ),
        "sex, litters, before and after, 7 + 6": kind(
            by_all, all_of, 2.2 * changed, subject=1.0, litter=mixed, usual=of_changes
        ),
        "errors that differ by 2.5, sex, 8 + 8": kind(by_sex, sex, 2.4 * other, error=1.0, unlike=2.5),
        "errors that differ by 2.5, before and after, 7 + 6": kind(
            by_time, changes, 2.8 * changed, subject=1.5, usual=of_changes, spread=0.2, error=0.8, unlike=2.5
        ),
        "unseen: litters across groups, 5 + 5": kind(by_litter, few_litters, 2.2 * in_second["few"], litter=mixed),
        "unseen: sex and litters, 14 + 9, SD × 2": kind(
            sex_and_litter, large_sex, 1.6 * of_large, litter=mixed, spread=1 + of_large
        ),
        "unseen: weeks 0, 1, 2, 6, correlated by 0.6 a time, 5 + 5": kind(
            by_time, months, 2.2 * last, subject=1.0, usual=repeated, serial=0.6
        ),
        "unseen: large errors, sex, 8 + 8": kind(by_sex, sex, 2.4 * other, error=1.2),
    }
    for word, noise in (("skewed", skewed), ("heavy tails", heavy)):
        for name in _AGAIN:
            cases[f"unseen: {word}, {name}"] = cases[name]._replace(noise=noise)
    return cases


def layout_of(one: Kind) -> Layout:
    """Return the layout of a kind of study."""
    names = [str(row) for row in one.table.index]
    variables = {
        str(label): Variable.from_cells(str(label), dict(zip(names, map(str, one.table[label]), strict=True)))
        for label in one.table.columns if label != "group"
    }  # fmt: skip
    members = dict(zip(names, one.table["group"], strict=True))
    return laid_out(one.design, variables, members, [*dict.fromkeys(one.table["group"])])


def drawn(one: Kind, layout: Layout, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return values without an effect, shape (animal, quantity), known errors, and the images' SD by animal."""
    count = len(one.table)

    def scores(labels: Any) -> np.ndarray:
        names, which = np.unique(np.asarray(labels), return_inverse=True)
        return np.asarray((one.noise(rng, (len(names), COUNT)) @ ROOT.T)[which])

    errors = one.error * np.exp(np.log(one.unlike) * rng.standard_normal((count, COUNT)))
    own = scores(range(count)) * one.spread[:, np.newaxis]
    if one.serial:
        times = own.reshape(one.table["time"].nunique(), -1, COUNT)  # a view
        for earlier, later in pairwise(times):
            later *= np.sqrt(1 - one.serial**2) if one.serial < 1 else 1.0
            later += one.serial * earlier
    values = own + errors * rng.standard_normal((count, COUNT))
    if one.litter:
        values += one.litter * scores(one.table["litter"])
    if one.subject:
        values += one.subject * scores(one.table["mouse"])
    if "sex" in one.table:
        values += 0.8 * (one.table["sex"] == "m").to_numpy()[:, np.newaxis]
    values += one.image * (rng.standard_normal((2, COUNT)) @ ROOT.T)[(one.table["group"] == "B").to_numpy(int)]
    return values, errors, np.full(count, one.image)


class Counted(NamedTuple):
    """Of one cohort: whether anything is found without an effect, whether all intervals hold, power; ours and usual."""

    false: bool
    usual_false: bool
    holds: bool
    power: bool
    usual_power: bool


def judged(one: Kind, layout: Layout, rng: np.random.Generator, draws: int, seed: int) -> Counted:
    """Return what is said of one cohort, without an effect and with one."""
    values, errors, image = drawn(one, layout, rng)
    sides = layout.contrasts
    truth = np.linalg.lstsq(layout.fixed, one.effect, rcond=None)[0]
    contrasts = np.array([(c.second - c.first) @ layout.means for c in sides])
    main = int(np.argmax([abs(c @ truth) * (side.label.kind in ("interaction", "trend") or len(sides) < 3)
                          for c, side in zip(contrasts, sides, strict=True)]))  # fmt: skip
    same = np.equal.outer(one.table["group"].to_numpy(), one.table["group"].to_numpy())
    verdicts = []
    for effect in (0.0, 1.0):
        models = []
        for quantity in range(COUNT):
            y = values[:, quantity] + (effect * one.effect if quantity == 0 else 0.0)
            known = np.diag(errors[:, quantity] ** 2) + np.outer(image, image) * same
            fit = fit_mixed(y, Structure(layout.fixed, list(layout.random.values()), known))
            models.append(Fitted(fit, np.arange(len(y)), contrasts))
        found = joint(models, draws, seed)
        true = np.concatenate([effect * (quantity == 0) * contrasts @ truth for quantity in range(COUNT)])
        effects = [each for model in models for each in model.effects]
        away = np.array([abs(each.value - right) / each.error for each, right in zip(effects, true, strict=True)])
        reach = np.array([stats.t.ppf(1 - found.critical / 2, each.freedom) for each in effects])
        shifted = values.copy()
        shifted[:, 0] += effect * one.effect
        usual = one.usual(one.table, shifted)
        verdicts.append((found.p, holm(usual.ravel()).reshape(usual.shape), bool(np.all(away <= reach))))
    (p, usual, _), (q, with_effect, holds) = verdicts
    where = min(main, len(with_effect) - 1) if len(with_effect) == len(sides) else 0
    usual_power = with_effect[:, 0].min() < 0.05 if len(with_effect) != len(sides) else with_effect[where, 0] < 0.05
    return Counted(bool(p.min() < 0.05), bool(usual.min() < 0.05), holds, bool(q[main] < 0.05), bool(usual_power))


def line(name: str, one: Kind, options: argparse.Namespace) -> str:
    """Return one line of the table."""
    rng, layout = np.random.default_rng([options.seed, zlib.crc32(name.encode())]), layout_of(one)
    counted = [judged(one, layout, rng, options.draws, number) for number in range(options.cohorts)]
    shares = np.mean(np.array(counted, float), axis=0)
    return f"| {name} | {shares[0]:.3f} | {shares[1]:.3f} | {shares[2]:.3f} | {shares[3]:.2f} | {shares[4]:.2f} |"


def guarded() -> dict[str, Kind]:
    """Return designs of few animals; the second group varies more, or responds in part."""
    sizes = {"7 + 5": (7, 5), "5 + 5": (5, 5), "3 + 3": (3, 3), "12 + 12": (12, 12)}
    cases = {name: kind(Design(), groups(*each), 0.0) for name, each in sizes.items()}
    for one, other in ((7, 4), (9, 8)):
        table = groups(one, other).assign(sex=[*"fmfmfmffmfmfmfmfm"[: one + other]])
        cases[f"sex, {one} + {other}"] = kind(Design(covariates=("sex",)), table, 0.0)
    return {name: one._replace(error=0.0) for name, one in cases.items()}


def unlike_animals(shape: PopulationShape, one: Kind, ratio: float, rng: np.random.Generator) -> np.ndarray:
    """Return values without an effect, shape (animal, quantity)."""
    second = (one.table["group"] == "B").to_numpy()
    values = rng.standard_normal((len(second), COUNT)) @ ROOT.T
    if shape is PopulationShape.SKEWED:
        shared = rng.random(values.shape) < np.sqrt(0.6)  # correlates exponential values by 0.6
        values = np.where(shared, rng.exponential(size=(len(second), 1)), rng.exponential(size=values.shape)) - 1
        values[second] *= ratio
    else:
        respond = (rng.random(len(second)) < RULES.respond) & second
        values += RULES.shift * (respond - RULES.respond * second)[:, np.newaxis]
    return values + 0.8 * (one.table.get("sex", pd.Series([""] * len(second))) == "m").to_numpy()[:, np.newaxis]


def guard_lines(name: str, one: Kind, options: argparse.Namespace) -> list[str]:
    """Return a line for each shape: what the page says, and how often the method finds what is not there."""
    layout, lines = layout_of(one), []
    doubts = {doubt.shape: doubt for doubt in doubts_of(layout, COUNT)}
    contrasts = np.array([(c.second - c.first) @ layout.means for c in layout.contrasts])
    structure = Structure(layout.fixed, [*layout.random.values()], np.zeros((len(one.table),) * 2))
    skewed = [(PopulationShape.SKEWED, RULES.spread_ratios[place]) for place in (0, -1)]
    for shape, ratio in [*skewed, (PopulationShape.RESPONDERS, 1.0)]:
        rng = np.random.default_rng([options.seed, zlib.crc32(f"{name} {shape} {ratio}".encode())])
        found = 0
        for number in range(options.cohorts):
            values = unlike_animals(shape, one, ratio, rng).T
            models = [Fitted(fit_mixed(y, structure), np.arange(len(y)), contrasts) for y in values]
            found += bool(joint(models, options.draws, number).p.min() < 0.05)
        rates = doubts[shape].rates if shape in doubts else ()
        words = f"{rates[0 if ratio == RULES.spread_ratios[0] else -1]:.3f}" if rates else "nothing"
        kind_of = f"skewed, SD × {ratio:g}" if shape is PopulationShape.SKEWED else "responders"
        lines.append(f"| {name} | {kind_of} | {words} | {found / options.cohorts:.3f} |")
    return lines


def main() -> None:
    """Print the table, and write it into the documentation if asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cohorts", type=int, default=500)
    parser.add_argument("--draws", type=int, default=999)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="Rows whose name contains this; -unseen: the others.")
    parser.add_argument("--guard", action="store_true", help="Rows of the guard, in place of the others.")
    parser.add_argument("--docs", action="store_true")
    options = parser.parse_args()
    if options.guard:
        header = ("design", "animals of the second group", "the page says", "the method")
        lines = [f"| {' | '.join(header)} |", "|---" * len(header) + "|"]
        for name, one in guarded().items():
            if options.only in name:
                lines += guard_lines(name, one, options)
                print(*lines[-3:], sep="\n", flush=True)
        if options.docs:
            put("guard", "\n".join(lines), PAGE)
        return
    header = ("design", "false positives", "usual tests", "holds all truths", "power", "usual tests' power")
    lines = [f"| {' | '.join(header)} |", "|---" * len(header) + "|"]
    for name, one in kinds().items():
        if options.only in name or (options.only == "-unseen" and "unseen" not in name):
            lines.append(line(name, one, options))
            print(lines[-1], flush=True)
    if options.docs:
        put("designs", "\n".join(lines), PAGE)


if __name__ == "__main__":
    main()
