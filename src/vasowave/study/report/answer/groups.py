"""The differences of the groups: who differs how in one sentence, the numbers for each question, how sure they are."""

from collections.abc import Sequence
from math import comb
from typing import NamedTuple

import numpy as np
import pandas as pd

from vasowave.base.errors import InputError
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.contrast import MIN_FREEDOM
from vasowave.study.cohort.design import laid_out
from vasowave.study.cohort.guard import RULES, PopulationShape, doubts_of
from vasowave.study.cohort.primary import Primary
from vasowave.study.figures.matplotlib_style import short
from vasowave.study.report.answer.effects import (
    MAX_LETTERS,
    Called,
    EffectVerdict,
    by_standing,
    comparatives,
    effect_of,
    limit,
    names,
    numbers,
    plain,
    sentence,
    separated,
    where,
)
from vasowave.study.report.answer.marks import Mark, unmarked
from vasowave.study.report.tables.cells import span
from vasowave.study.report.wording import LIMIT, listed, number, ratio_with_interval, unlimited

CLEAR = LIMIT
"""Family-wise p below which a difference is said to be shown."""

THE_ANSWER = "The answer"
"""What stands before the sentence that answers the question of a study."""
_KEYS = ("what", "change", "within")


class StudyAnswer(NamedTuple):
    """The answer to the question of a study.

    Attributes
    ----------
    first : sequence of str
        Who differs how, a sentence or two for each effect.
    questions : sequence of (str, str)
        Each question with the numbers of its effects.
    sureness : sequence of str
        What limits the p and intervals.
    """

    first: list[str]
    questions: list[tuple[str, str]]
    sureness: list[str]

    def items(self, rests_on: Sequence[str] = (), sure: Sequence[str] = ()) -> list[tuple[str, str]]:
        """Return questions with their answers, the whole first; with what all rests on, and more of how sure it is."""
        basis, sureness = " ".join(rests_on), " ".join([*self.sureness, *sure])
        ends = [("What does this rest on?", basis), ("How sure is this?", sureness)]
        first = [(THE_ANSWER, " ".join(self.first))] if self.first else []
        return [*first, *self.questions, *(end for end in ends if end[1])]


def group_answer(primary: Primary, called: Called, mark: Mark = unmarked) -> StudyAnswer:
    """Return the answer to what differs between the groups, each against the first; `mark` marks numbers."""
    rows = primary.rows
    if not len(rows):
        return StudyAnswer([], [], [])
    keys = ["other", *(_KEYS if "what" in rows else ())]
    averaged = "what" in rows and "interaction" in set(rows["what"])
    first = [_first(effect_rows, called, averaged) for _, effect_rows in rows.groupby(keys, sort=False)]
    questions: dict[str, list[str]] = {}
    for (question, *_), effect_rows in rows.groupby(["question", *keys], sort=False):
        questions.setdefault(str(question), []).append(_numbers(effect_rows, called, mark, averaged))
    answers = [(question, " ".join(texts)) for question, texts in questions.items()]
    sure = [*_corrected(rows), *sureness(rows, rows["other"].nunique()), *_least_shown(rows, called)]
    return StudyAnswer(first, answers, sure)


def _first(rows: pd.DataFrame, called: Called, averaged: bool) -> str:
    """Return what is higher and lower in one sentence, and what is not shown in another."""
    place, between = where(rows.iloc[0], averaged)
    rows_by_standing = by_standing(rows)
    normal = "if logarithms are normal, " if (rows["smallest p"] >= CLEAR).any() else ""
    shown = rows_by_standing.pop(EffectVerdict.SHOWN, None)
    clauses = [] if shown is None else [f"{normal}{comparatives(shown, called, sized=True)} {place}"]
    if shown is None and {*rows_by_standing} != {EffectVerdict.UNTESTED}:
        clauses.append(f"no difference {between} is shown")
    for evidence, standing_rows in rows_by_standing.items():
        details = {EffectVerdict.SMALL: f" {limit(standing_rows)}", EffectVerdict.OPEN: " (neither shown nor excluded)"}
        clauses.append(f"{evidence}{details.get(evidence, '')}: {names(standing_rows, called)}")
    return " ".join(map(sentence, clauses))


def _numbers(rows: pd.DataFrame, called: Called, mark: Mark, averaged: bool) -> str:
    """Return the verdict on one question and the numbers behind it."""
    place, between = where(rows.iloc[0], averaged)
    shown = by_standing(rows).get(EffectVerdict.SHOWN)
    sentences = [] if shown is None else [sentence(f"{comparatives(shown, called)} {place}")]
    sentences += numbers(rows, called, mark, "" if shown is not None else between)
    disjoint = rows[(rows["smallest p"] >= CLEAR) & rows["apart"]]
    if len(disjoint):
        sizes = disjoint[["n reference", "n other"]].to_numpy(int).tolist()
        sentences.append(separated(rows, called, [2 / comb(a + b, a) for a, b in sizes]))
    return " ".join(sentences)


def not_told(primary: Primary, called: Called) -> list[str]:
    """Return what a design does not tell and why; of which quantities where it tells it of others."""
    quantities = {*primary.rows["quantity"]} if len(primary.rows) else set()
    quantities |= {name for missed in primary.untold for name in missed.quantities}
    return [
        f"{missed.finding}"
        + ("" if quantities == {*missed.quantities} else f" (of {listed([*map(called, missed.quantities)])})")
        for missed in primary.untold
    ]


def sureness(rows: pd.DataFrame, pairs: int) -> list[str]:
    """Say what limits p and intervals: too few animals, few degrees of freedom."""
    sentences = []
    limited_rows = rows[rows["smallest p"] >= CLEAR].drop_duplicates(["n reference", "n other", "smallest p"])
    if len(limited_rows):
        counted = f" that counts for {pairs} pairs of groups" if pairs > 1 else ""
        limits = listed([
            f"{number(float(row['smallest p']), 2)} with {row['n reference']} + {row['n other']} animals"
            for _, row in limited_rows.iterrows()
        ])  # fmt: skip
        sentences.append(
            f"A test by ranks{counted} cannot come below p = {limits}: p and intervals rest on logarithms being normal."
        )
    return [*sentences, *_few_degrees(rows)]


def doubts_text(cohort: Cohort, primary: Primary) -> list[str]:
    """Say how often chance alone shows something if animals are of a shape that so few do not show."""
    if not len(primary.rows):
        return []
    try:
        layout = laid_out(cohort.design, cohort.variables, cohort.members, list(cohort.groups))
    except InputError:  # though some quantities are compared, whose animals are fewer
        return []
    kinds = []
    for doubt in doubts_of(layout, primary.rows["quantity"].nunique()):
        cells = listed([short(cell, MAX_LETTERS) for cell in doubt.cells])
        studies = " to ".join(dict.fromkeys(f"{100 * rate:.0f}" for rate in (min(doubt.rates), max(doubt.rates))))
        if doubt.shape is PopulationShape.SKEWED:
            times = " to ".join(f"{ratio:g}" for ratio in RULES.spread_ratios)
            kinds.append(f"{studies} if they are skewed and {cells} varies {times} times as much")
        else:
            kinds.append(f"{studies} if {10 * RULES.respond:g} in 10 animals of {cells} lie apart from the others")
    if not kinds:
        return []
    return [
        "So few animals do not show how their values are distributed. Of 100 such studies without any effect, chance "
        f"shows something in 5 if their logarithms are normal, in {' and in '.join(kinds)}."
    ]


def _corrected(rows: pd.DataFrame) -> list[str]:
    """Say what intervals and p are, and what p is not."""
    count = tested(rows)
    many = f"They and p are corrected for {count} comparisons. " if count > 1 else ""
    return [f"Brackets are 95 % intervals. {many}A p near 1 does not say that groups are equal."] if count else []


def tested(rows: pd.DataFrame) -> int:
    """Return the number of rows that have a p, for which p and intervals are corrected."""
    return int((~rows["untested"].astype(bool)).sum())


def _least_shown(rows: pd.DataFrame, called: Called) -> list[str]:
    """Say how large undecided effects must be to be shown by animals that vary as these do."""
    several = rows["other"].nunique() > 1 or "what" in rows
    sizes = []
    for _, row in by_standing(rows).get(EffectVerdict.OPEN, rows[:0]).iterrows():
        if not unlimited(row["low"], row["high"]):
            scope = f" ({effect_of(row)})" if several else ""
            sizes.append(
                f"{plain(row['quantity'], called)}{scope} {number(float(np.sqrt(row['high'] / row['low'])), 2)}"
            )
    if not sizes:
        return []
    return [
        f"With animals that vary as these do, what is undecided would be shown by a found ratio of about these or more "
        f"(one over them or less): {listed(sizes)}. `vasowave plan` says how many animals show smaller ones."
    ]


def _few_degrees(rows: pd.DataFrame) -> list[str]:
    """Say which effects of a design rest on few degrees of freedom, and how large they must be to be shown."""
    sparse_rows = rows[rows["df"] < MIN_FREEDOM] if "what" in rows else rows[:0]
    if not len(sparse_rows):
        return []
    effects = listed([*dict.fromkeys(effect_of(row) for _, row in sparse_rows.iterrows())])
    high, low = (sparse_rows[end].to_numpy(float) for end in ("high", "low"))
    percents = 100 * (np.sqrt(high / low) - 1)  # of ratios that are shown
    return [
        f"{effects}: {len(sparse_rows)} of {len(rows)} ratios rest on {span(sparse_rows['df'].to_numpy(float), 2)} "
        "degrees of freedom. "
        f"Beside all other rows such a ratio is shown if it differs from 1 by about {span(percents, 2)} % or more; "
        "fewer covariates, blocks, quantities or contrasts would leave more."
    ]


def _by(row: pd.Series, rows: pd.DataFrame) -> str:
    """Return the law of a row, and its effect where rows are of several."""
    effects = {effect_of(law_row) for _, law_row in rows.iterrows()}
    return f"{row['source']}; {effect_of(row)}" if len(effects) > 1 else str(row["source"])


def beside(primary: Primary, called: Called) -> list[str]:
    """Say what one animal, the fits in place of posteriors, and other wall laws would change."""
    if not len(primary.rows):
        return []
    return [*influence(primary, called), *by_fits(primary, called), *other_laws(primary, called)]


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
    effects = {effect_of(effect_row) for _, effect_row in primary.rows.iterrows()}
    scope = f" ({effect_of(row)})" if len(effects) > 1 else ""
    return [
        f"One animal moves an effect most: without {short(row['without'], MAX_LETTERS)}, {called(row['quantity'])}"
        f"{scope} is {number(float(row['ratio without']))} times instead of {number(float(row['ratio']))}{end}."
    ]


def by_fits(primary: Primary, called: Called) -> list[str]:
    """Say where fits judge otherwise than the posteriors that the rows are by."""
    rows = primary.rows[primary.rows["fits ratio"].notna()] if "fits ratio" in primary.rows else primary.rows[:0]
    if not len(rows):
        return []
    differences = []
    for _, row in rows.iterrows():
        ratio, low, high = row["fits ratio"], row["fits low"], row["fits high"]
        shown = not low <= 1 <= high
        if shown != (row["p"] < CLEAR):
            size, _, interval = ratio_with_interval(ratio, low, high).partition(" ")
            judged = f"they {'' if shown else 'do not '}show ({size} times {interval})"
            differences.append(f"{called(row['quantity'])} in {short(row['other'], MAX_LETTERS)}, which {judged}")
    if not differences:
        return ["Fits of the same animals show the same effects as their posteriors."]
    return [
        f"Fits of the same animals judge otherwise of {listed(differences)}. Posteriors decide: they follow errors "
        "that are too large for a straight line."
    ]


def other_laws(primary: Primary, called: Called) -> list[str]:
    """Say where another wall law gives another effect."""
    if not len(primary.others):
        return []
    keys = ["reference", "other", "quantity", *(["change", "within"] if "change" in primary.others else [])]
    merged = primary.others.merge(primary.rows, on=keys, suffixes=("", " primary"))
    outside = merged[(merged["ratio"] < merged["low primary"]) | (merged["ratio"] > merged["high primary"])]
    laws = listed([f"the {law} wall" for law in primary.others["source"].unique()])
    if not len(outside):
        return [f"By {laws} every ratio lies inside the intervals of the {primary.law} wall."]
    ratios = [
        f"{called(row['quantity'])} {number(float(row['ratio']))} times ({_by(row, merged)})"
        for _, row in outside.iterrows()
    ]
    return [f"Outside the intervals of the {primary.law} wall lie {listed(ratios)}."]
