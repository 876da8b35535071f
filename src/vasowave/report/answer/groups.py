"""How the groups differ: one sentence for each question, every effect with its interval and p."""

from collections.abc import Callable

import numpy as np
import pandas as pd

from vasowave.cohort.primary import Primary
from vasowave.figures.style import short
from vasowave.report.wording import listed, number, probability, with_interval

CLEAR = 0.05
"""Family-wise p below which a difference is said to be shown."""

_LONGEST = 40  # letters of a name in a sentence
Called = Callable[[str], str]
"""Returns a quantity in words with its symbol."""


def group_answers(primary: Primary, called: Called) -> list[tuple[str, str]]:
    """Return question and answer; the answer goes through the groups, each against the first."""
    answers: dict[str, list[str]] = {}
    pairs = primary.rows["other"].nunique() if len(primary.rows) else 0
    for (question, _), rows in primary.rows.groupby(["question", "other"], sort=False) if pairs else ():
        answers.setdefault(str(question), []).append(_answer(rows, called, pairs))
    return [(question, " ".join(texts)) for question, texts in answers.items()]


def _answer(rows: pd.DataFrame, called: Called, pairs: int) -> str:
    untestable = rows["smallest p"] >= CLEAR
    if untestable.all():
        return _too_few(rows, called, pairs)
    tested, clear = rows["untested"] == "", rows["p"] < CLEAR
    higher, lower = rows[clear & (rows["ratio"] > 1)], rows[clear & (rows["ratio"] < 1)]
    reference, other = (short(rows.iloc[0][which], _LONGEST) for which in ("reference", "other"))
    parts = [
        f"{way} in {other} than in {reference}: {listed([_effect(row, called) for _, row in some.iterrows()])}"
        for way, some in (("higher", higher), ("lower", lower))
        if len(some)
    ]
    if (tested & ~clear).any():
        where = "" if parts else f" between {other} and {reference}"
        parts.append(
            f"not shown{where}: {listed([_effect(row, called) for _, row in rows[tested & ~clear].iterrows()])}"
        )
    if (~tested).any():
        effects = listed([_effect(row, called, p=False) for _, row in rows[~tested].iterrows()])
        parts.append(f"without p, since animals of a group have one image, which fits take as exact: {effects}")
    text = "; ".join(parts)
    return f"{text[0].upper()}{text[1:]}."


def _effect(row: pd.Series, called: Called, p: bool = True) -> str:
    size = with_interval(row["ratio"], row["low"], row["high"])
    return f"{called(row['quantity'])} {size} times{f' ({probability(row.p)})' if p else ''}"


def _too_few(rows: pd.DataFrame, called: Called, pairs: int) -> str:
    """Give the effects, and say in the same sentence that no test could confirm them."""
    row = rows.iloc[0]
    n, m = int(row["n reference"]), int(row["n other"])
    effects = listed([_effect(one, called, p=False) for _, one in rows.iterrows()])
    counted = f" that counts for {pairs} pairs of groups" if pairs > 1 else ""
    return (
        f"{short(row['other'], _LONGEST)} against {short(row['reference'], _LONGEST)}: {effects}"
        f"{_separated(rows, called)}; with {n} + {m} animals no rank or permutation test{counted} can fall below p = "
        f"{number(float(row['smallest p']), 2)}."
    )


def _separated(rows: pd.DataFrame, called: Called) -> str:
    apart = rows[rows["apart"]]
    if not len(apart):
        return ""
    which = "all" if len(apart) == len(rows) > 1 else listed([called(name) for name in apart["quantity"]])
    return f" (the groups do not overlap in {which})"


def influence(primary: Primary, called: Called) -> list[str]:
    """Say which animal carries most of any effect."""
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
    return [
        f"One animal moves an effect most: without {short(row['without'], _LONGEST)}, {called(row['quantity'])} is "
        f"{number(float(row['ratio without']))} times instead of {number(float(row['ratio']))}{end}."
    ]


def other_laws(primary: Primary, called: Called) -> list[str]:
    """Say where another wall law gives another effect."""
    if not len(primary.others):
        return []
    keys = ["reference", "other", "quantity"]
    both = primary.others.merge(primary.rows, on=keys, suffixes=("", " primary"))
    outside = both[(both["ratio"] < both["low primary"]) | (both["ratio"] > both["high primary"])]
    laws = listed([f"the {law} wall" for law in primary.others["source"].unique()])
    if not len(outside):
        return [f"By {laws} every ratio lies inside the intervals of the {primary.law} wall."]
    parts = [
        f"{called(row['quantity'])} {number(float(row['ratio']))} times ({row['source']})"
        for _, row in outside.iterrows()
    ]
    return [f"Outside the intervals of the {primary.law} wall lie {listed(parts)}."]
