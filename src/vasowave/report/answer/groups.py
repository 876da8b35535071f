"""The differences of the groups, one sentence for each question: effects with intervals and p; the design in words."""

from collections.abc import Callable, Mapping
from math import comb

import numpy as np
import pandas as pd

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.contrast import FEW
from vasowave.cohort.primary import Primary
from vasowave.figures.style import short
from vasowave.report.tables.cells import span
from vasowave.report.wording import LIMIT, listed, number, probability, ratio_with_interval, some_of, unit

CLEAR = LIMIT
"""Family-wise p below which a difference is said to be shown."""

_UNEVEN = 1.4  # times as many animals in one group as in the other: 7 + 5, where a skew was seen to matter
_MIN_ANIMALS = 8  # animals of the smaller group, below which it was seen
_MAX_LETTERS = 40  # letters of a name in a sentence
Called = Callable[[str], str]
"""Returns a quantity in words with its symbol."""
Mark = Callable[[list[str]], str]
"""Returns what stands behind a sentence about groups."""
_MAX_LEVELS = 6


def group_answers(primary: Primary, called: Called, mark: Mark = lambda groups: "") -> list[tuple[str, str]]:
    """Return question and answer; the answer goes through the groups, each against the first.

    `mark` returns what stands behind a sentence about fits of two groups.
    What holds for several questions, that too few animals can be tested, stands once, as the last answer.
    """
    answers: dict[str, list[str]] = {}
    pairs = primary.rows["other"].nunique() if len(primary.rows) else 0
    by = ["question", "other", *(["what", "change", "within"] if "what" in primary.rows else [])]
    averaged = "what" in primary.rows and "interaction" in set(primary.rows["what"])
    for (question, *_), rows in primary.rows.groupby(by, sort=False) if pairs else ():
        answers.setdefault(str(question), []).append(_answer(rows, called, averaged) + _marked(rows, mark))
    said = [(question, " ".join(texts)) for question, texts in answers.items()]
    return [*said, *_limits(primary.rows, pairs, called)] if pairs else said


def _marked(rows: pd.DataFrame, mark: Mark) -> str:
    first = rows.iloc[0]
    return mark([first["reference"], first["other"]]) if (rows["source"] != "measured").any() else ""


def _answer(rows: pd.DataFrame, called: Called, averaged: bool) -> str:
    reference, other = (short(rows.iloc[0][which], _MAX_LETTERS) for which in ("reference", "other"))
    where, between = _places(rows.iloc[0], reference, other, averaged)

    def effects(some: pd.DataFrame) -> str:
        return listed([effect(row, called) for _, row in some.iterrows()])

    if (rows["smallest p"] >= CLEAR).all():
        return f"{other} against {reference}: {effects(rows)}{_separated(rows, called)}."
    tested, clear = rows["untested"] == "", rows["p"] < CLEAR
    parts = [
        f"{where.format(way)}: {effects(some)}"
        for way, some in (("higher", rows[clear & (rows["ratio"] > 1)]), ("lower", rows[clear & (rows["ratio"] < 1)]))
        if len(some)
    ]
    between = "" if parts else f" {between}"
    others = {"not shown": rows[tested & ~clear], "not tested": rows[~tested]}
    parts += [f"{what}{between}: {effects(some)}" for what, some in others.items() if len(some)]
    text = "; ".join(parts)
    return f"{text[0].upper()}{text[1:]}."


def _places(row: pd.Series, reference: str, other: str, averaged: bool) -> tuple[str, str]:
    """Return where an effect is, as a sentence says it of one that is shown (`{}` higher or lower), and of another.

    A second factor is `averaged` over the groups where these may differ in it.
    """
    within = f" {short(row['within'], _MAX_LETTERS)}" if row.get("within") else ""
    match row.get("what", "groups"):
        case "factor":
            within = within or (" on average over the groups" if averaged else "")
            return f"{{}} at {other} than at {reference}{within}", f"between {other} and {reference}{within}"
        case "trend":
            return f"{{}} at {other} than at {reference} by the trend", f"from {reference} to {other} by the trend"
        case "interaction":
            change = short(row["change"], _MAX_LETTERS)
            ratio = f"the ratio {change}"
            return f"{ratio} is {{}} in {other} than in {reference}", f"between {other} and {reference} in {ratio}"
        case "contrast":
            return f"{{}} by the contrast '{other}'", f"by the contrast '{other}'"
    return f"{{}} in {other} than in {reference}{within}", f"between {other} and {reference}{within}"


def effect_of(row: pd.Series) -> str:
    """Return which effect a row is of, as a table says it: ``HPH / CTL``."""
    pair = " / ".join(filter(None, (row["other"], row["reference"])))
    pair += f" {row['within']}" if row.get("within") else ""
    return f"{row['change']}: {pair}" if row.get("change") else pair


def effect(row: pd.Series, called: Called) -> str:
    """Return an effect as one writes it: ``mPAP 13.5 → 21.5 mmHg (1.6 times [1.3, 2.0], p = 0.010)``."""
    value, _, interval = ratio_with_interval(row["ratio"], row["low"], row["high"]).partition(" ")
    tested = "" if row["untested"] else f", {probability(row['p'])}"
    times = f"{value} times {interval}".rstrip()
    of_means = f" {change(row)}" if np.isfinite(row["mean other"]) else ""
    return f"{called(row['quantity'])}{of_means} ({times}{tested})"


def change(row: pd.Series) -> str:
    """Return the means of the two groups with their unit, ``13.5 → 21.5 mmHg``."""
    units = unit(str(row["unit"]))
    return f"{number(float(row['mean reference']))} → {number(float(row['mean other']))} {units}".rstrip()


def not_told(primary: Primary, called: Called) -> list[str]:
    """Return what a design does not tell and why; of which quantities where it tells it of others."""
    every = {*primary.rows["quantity"]} if len(primary.rows) else set()
    every |= {name for one in primary.untold for name in one.quantities}
    return [
        f"{one.finding}" + ("" if every == {*one.quantities} else f" (of {listed([*map(called, one.quantities)])})")
        for one in primary.untold
    ]


def _limits(rows: pd.DataFrame, pairs: int, called: Called) -> list[tuple[str, str]]:
    """Say once what holds for the p of several questions: that too few animals are tested, or that there is none."""
    said = []
    few = rows[rows["smallest p"] >= CLEAR].drop_duplicates(["n reference", "n other", "smallest p"])
    if len(few):
        counted = f" that counts for {pairs} pairs of groups" if pairs > 1 else ""
        limits = listed([
            f"{number(float(row['smallest p']), 2)} with {row['n reference']} + {row['n other']} animals"
            for _, row in few.iterrows()
        ])  # fmt: skip
        said.append(
            f"No rank or permutation test{counted} can fall below p = {limits}; p and intervals rest on normal "
            "distributions of logarithms alone."
        )
    sizes = rows.loc[rows["smallest p"].notna(), ["n reference", "n other"]].drop_duplicates()
    uneven = sizes[(sizes.max(axis=1) >= _UNEVEN * sizes.min(axis=1)) & (sizes.min(axis=1) < _MIN_ANIMALS)]
    if len(uneven):
        counts = listed([f"{one} + {other}" for one, other in uneven.itertuples(index=False)])
        said.append(
            f"Groups of {counts} animals cannot show whether logarithms are skewed; if they are, and the smaller group "
            "varies more, p < 0.05 comes without any effect in one of ten studies or more, not in one of twenty."
        )
    said += _few_degrees(rows)
    untested = rows[rows["untested"] != ""]
    if len(untested):
        mixed = "posterior" in set(rows["estimates"])
        which = f" ({listed([called(str(name)) for name in untested['quantity'].unique()])})" if mixed else ""
        said.append(
            f"What follows from fits{which} is not tested where the animals of a group have one image: fits take it as "
            "exact, so that their intervals do not contain its error."
        )
    return [("How sure is this?", " ".join(said))] if said else []


def _few_degrees(rows: pd.DataFrame) -> list[str]:
    """Say which effects of a design rest on few degrees of freedom, and how large they must be to be shown."""
    few = rows[rows["df"] < FEW] if "what" in rows else rows[:0]
    if not len(few):
        return []
    effects = listed([*dict.fromkeys(effect_of(row) for _, row in few.iterrows())])
    least = 100 * (np.sqrt(few["high"].to_numpy(float) / few["low"].to_numpy(float)) - 1)  # %, of ratios that are shown
    return [
        f"{effects}: {len(few)} of {len(rows)} ratios rest on {span(few['df'].to_numpy(float), 2)} degrees of freedom. "
        f"Beside all other rows such a ratio is shown if it differs from 1 by about {span(least, 2)} % or more; fewer "
        "covariates, blocks, quantities or contrasts would leave more."
    ]


def _separated(rows: pd.DataFrame, called: Called) -> str:
    """Name the quantities in which no animal of one group lies among the other, and how often chance does that."""
    apart = rows[rows["apart"]]
    if not len(apart):
        return ""
    names = "" if len(apart) == len(rows) == 1 else f" in {listed([called(name) for name in apart['quantity']])}"
    sizes = apart[["n reference", "n other"]].to_numpy(int).tolist()
    chance = max(2 / comb(one + other, one) for one, other in sizes)  # of all ways to share the animals, two are apart
    return f"; the groups do not overlap{names}, which chance alone does in {number(100 * chance, 2)} % of quantities"


def _by(row: pd.Series, rows: pd.DataFrame) -> str:
    """Return the law of a row, and its effect where rows are of several."""
    effects = {effect_of(one) for _, one in rows.iterrows()}
    return f"{row['source']}; {effect_of(row)}" if len(effects) > 1 else str(row["source"])


def influence(primary: Primary, called: Called) -> list[str]:
    """Say which animal carries most of any effect, and which effect that is where there are several."""
    rows = primary.rows[primary.rows["without"] != ""]
    if not len(rows):
        return []
    moved = np.abs(np.log(rows["ratio without"].to_numpy(float) / rows["ratio"].to_numpy(float)))
    row = rows.iloc[int(moved.argmax())]
    outside = rows[(rows["ratio without"] < rows["low"]) | (rows["ratio without"] > rows["high"])]
    end = (
        f"; leaving out one animal takes {len(outside)} ratios out of their intervals"
        if len(outside)
        else "; without any one animal every ratio stays inside its interval"
    )
    effects = {effect_of(each) for _, each in primary.rows.iterrows()}
    which = f" ({effect_of(row)})" if len(effects) > 1 else ""
    return [
        f"One animal moves an effect most: without {short(row['without'], _MAX_LETTERS)}, {called(row['quantity'])}"
        f"{which} is {number(float(row['ratio without']))} times instead of {number(float(row['ratio']))}{end}."
    ]


def other_laws(primary: Primary, called: Called) -> list[str]:
    """Say where another wall law gives another effect."""
    if not len(primary.others):
        return []
    keys = ["reference", "other", "quantity", *(["change", "within"] if "change" in primary.others else [])]
    both = primary.others.merge(primary.rows, on=keys, suffixes=("", " primary"))
    outside = both[(both["ratio"] < both["low primary"]) | (both["ratio"] > both["high primary"])]
    laws = listed([f"the {law} wall" for law in primary.others["source"].unique()])
    if not len(outside):
        return [f"By {laws} every ratio lies inside the intervals of the {primary.law} wall."]
    parts = [
        f"{called(row['quantity'])} {number(float(row['ratio']))} times ({_by(row, both)})"
        for _, row in outside.iterrows()
    ]
    return [f"Outside the intervals of the {primary.law} wall lie {listed(parts)}."]


def design_answer(cohort: Cohort) -> list[tuple[str, str]]:
    """Return the question and the answer of a design; none for groups of independent animals."""
    text = design_text(cohort)
    return [("How were animals compared?", text)] if text else []


def design_text(cohort: Cohort) -> str:
    """Return the design of a cohort in a sentence or two; empty for groups of independent animals."""
    design = cohort.design
    if design.plain:
        return ""
    parts = []
    if design.covariates:
        named = listed([*map(_named, design.covariates)])
        parts.append(
            f"ratios and means of groups are adjusted for {named}: they are those of groups with the same mean of it "
            "(of a category: with as many animals of each kind)"
        )
    if design.blocks:
        levels = [f"{_named(name)}{_levels(cohort, name)}" for name in design.blocks]
        parts.append(f"animals of one {listed(levels)} may be alike (random effects)")
    if design.subject:
        rows = cohort.variables[design.subject].levels if design.subject in cohort.variables else {}
        parts.append(
            f"the {len(cohort.results)} recordings are of {len(set(rows.values()))} animals (column "
            f"{_named(design.subject)}), whose own level is a random effect"
            + (", and which may be in several groups, one after the other" if design.crossover else "")
        )
    if design.second and not design.contrasts:
        parts.append(_second(cohort))
    if design.contrasts:
        defined = [f"{_named(name)} = {_weights(weights)}" for name, weights in design.contrasts.items()]
        parts.append(f"the comparisons are those that the study names, of means on logarithms: {listed(defined)}")
    said = "; ".join(parts)
    return f"{said[0].upper()}{said[1:]}."


def _second(cohort: Cohort) -> str:
    design, name = cohort.design, str(cohort.design.second)
    if design.dose:
        return f"compared is the trend with {_named(name)}, by the line through the means"
    order = [*map(_named, cohort.variables[name].order)] if name in cohort.variables else []
    levels = f"{some_of(order, _MAX_LEVELS)}{f'; compared with {order[0]}' if order else ''}"
    several = len(cohort.groups) > 1
    own = "in each group of its own" if design.interaction else "alike in all groups"
    return f"{_named(name)} ({levels}) is a second factor{f', its effect {own}' if several else ''}"


def _weights(weights: Mapping[str, float]) -> str:
    """Return a contrast as a sum: ``'HPH, drug' - 'HPH, vehicle'``."""
    terms: list[str] = []
    for cell, weight in sorted(weights.items(), key=lambda one: one[1] < 0):
        size = "" if abs(weight) == 1 else f"{abs(weight):.3g} · "
        sign = ("− " if weight < 0 else "+ ") if terms or weight < 0 else ""
        terms += [f"{sign}{size}'{_named(cell)}'"] if weight else []
    return " ".join(terms)


def _named(name: str) -> str:
    return short(name, _MAX_LETTERS)


def _levels(cohort: Cohort, name: str) -> str:
    """Return which levels a column has: `` (of 4: A, B, C and D)``."""
    order = [*map(_named, cohort.variables[name].order)] if name in cohort.variables else []
    return f" (of {len(order)}: {some_of(order, _MAX_LEVELS)})" if order else ""
