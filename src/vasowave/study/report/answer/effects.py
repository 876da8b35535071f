"""One effect of the primary comparison in words: where it is, how large, and what the animals say of it."""

from collections.abc import Callable, Sequence
from enum import StrEnum

import numpy as np
import pandas as pd

from vasowave.pulse.quantities import QUANTITIES, question_of
from vasowave.study.figures.matplotlib_style import short
from vasowave.study.report.answer.marks import Mark
from vasowave.study.report.wording import LIMIT, listed, number, probability, ratio_with_interval, unit

MAX_LETTERS = 40  # of a name in a sentence
SMALL = 0.8, 1.25
"""Ratios between which an effect is small: those that count as equivalent between two drugs."""
Called = Callable[[str], str]
"""Returns a quantity in words with its symbol."""

_COMPARATIVES = {
    "stiffness": ("stiffer", "softer", "large arteries"), "beta": ("stiffer", "softer", "large arteries"),
    "wave_speed": ("faster", "slower", "waves"),
    "I_R": ("stronger", "weaker", ""), "measured_I_R": ("stronger", "weaker", ""),
    "tau": ("longer", "shorter", ""), "tau_plain": ("longer", "shorter", ""), "a": ("larger", "smaller", ""),
}  # fmt: skip
"""How a higher and a lower value are called, and of what where that is not the quantity itself."""


class EffectVerdict(StrEnum):
    """What the animals say of an effect."""

    SHOWN = "shown"
    SMALL = "no effect larger than"
    OPEN = "undecided"
    UNTESTED = "without p"


def standing(row: pd.Series) -> EffectVerdict:
    """Return what the animals say of an effect."""
    if row["untested"]:
        return EffectVerdict.UNTESTED
    if row["p"] < LIMIT:
        return EffectVerdict.SHOWN
    return EffectVerdict.SMALL if row["low"] >= SMALL[0] and row["high"] <= SMALL[1] else EffectVerdict.OPEN


def by_standing(rows: pd.DataFrame) -> dict[EffectVerdict, pd.DataFrame]:
    """Return the rows of each standing that has any."""
    standings = rows.apply(standing, axis=1)
    return {evidence: rows[standings == evidence] for evidence in EffectVerdict if (standings == evidence).any()}


def where(row: pd.Series, averaged: bool) -> tuple[str, str]:
    """Return where an effect is, as a sentence says it behind a comparative, and of an effect that is not shown.

    A second factor is `averaged` over the groups where these may differ in it.
    """
    reference, group = (short(row[side], MAX_LETTERS) for side in ("reference", "other"))
    within = f" {short(row['within'], MAX_LETTERS)}" if row.get("within") else ""
    match row.get("what", "groups"):
        case "factor":
            within = within or (" on average over the groups" if averaged else "")
            return f"at {group} than at {reference}{within}", f"between {group} and {reference}{within}"
        case "trend":
            return f"at {group} than at {reference} by the trend", f"from {reference} to {group} by the trend"
        case "interaction":
            ratio = f"in the ratio {short(row['change'], MAX_LETTERS)}"
            return f"in {group} than in {reference}, {ratio}", f"between {group} and {reference} {ratio}"
        case "contrast":
            return f"by the contrast '{group}'", f"by the contrast '{group}'"
    return f"in {group} than in {reference}{within}", f"between {group} and {reference}{within}"


def effect_of(row: pd.Series) -> str:
    """Return which effect a row is of, as a table says it: ``HPH / CTL``."""
    pair = " / ".join(filter(None, (row["other"], row["reference"])))
    pair += f" {row['within']}" if row.get("within") else ""
    return f"{row['change']}: {pair}" if row.get("change") else pair


def comparatives(rows: pd.DataFrame, called: Called, sized: bool = False) -> str:
    """Return what is higher and lower, ``higher mean pressure and cardiac output, stiffer large arteries``."""
    subjects_by_comparative: dict[str, list[str]] = {}
    for _, row in rows.iterrows():
        higher, less, noun = _COMPARATIVES.get(row["quantity"], ("higher", "lower", ""))
        whence = "" if row["source"] == "measured" else " by the model"
        size = f" (× {_size(row)}{whence})" if sized else ""
        subjects_by_comparative.setdefault(higher if row["ratio"] > 1 else less, []).append(
            (noun or plain(row["quantity"], called)) + size
        )
    return listed(
        [
            f"{comparative} {listed(list(dict.fromkeys(subjects)))}"
            for comparative, subjects in subjects_by_comparative.items()
        ]
    )


def _size(row: pd.Series) -> str:
    """Return a ratio with the digits that its interval has."""
    return ratio_with_interval(row["ratio"], row["low"], row["high"]).partition(" ")[0]


def plain(name: str, called: Called) -> str:
    """Return a quantity in words without its symbol, where it has words."""
    quantity = QUANTITIES.get(name)
    return (quantity and (quantity.words or quantity.meaning.split(",")[0])) or called(name)


def effect(row: pd.Series, called: Called, mark: Mark) -> str:
    """Return an effect as one writes it: ``mPAP 13.5 → 21.5 mmHg (1.6 times [1.3, 2.0], p = 0.010)``, and its mark."""
    size, _, interval = ratio_with_interval(row["ratio"], row["low"], row["high"]).partition(" ")
    of_means = f" {change(row)}" if np.isfinite(row["mean other"]) else ""
    tested = "" if row["untested"] else f", {probability(row['p'])}"
    times = f"{size} times {interval}".rstrip()
    return f"{called(row['quantity'])}{of_means} ({times}{tested}){mark(row)}"


def change(row: pd.Series) -> str:
    """Return the means of the two groups with their unit, ``13.5 → 21.5 mmHg``."""
    units = unit(str(row["unit"]))
    return f"{number(float(row['mean reference']))} → {number(float(row['mean other']))} {units}".rstrip()


def limit(rows: pd.DataFrame) -> str:
    """Return the factor that small effects do not exceed either way, rounded up."""
    factor = float(max(rows["high"].max(), 1 / rows["low"].min()))
    return f"a factor of {np.ceil(round(100 * factor, 6)) / 100:.2f}"


def numbers(rows: pd.DataFrame, called: Called, mark: Mark, between: str) -> list[str]:
    """Return the sentences on the effects of one question: each standing, and of each what takes no image first.

    `between` what they are stands in the first one.
    """
    sentences: list[str] = []
    for evidence, standing_rows in by_standing(rows).items():
        for source, source_rows in standing_rows.groupby("source", sort=False):
            effects = listed([effect(row, called, mark) for _, row in source_rows.iterrows()])
            sentences.append(f"{_headed(evidence, source_rows, str(source), '' if sentences else between)}: {effects}.")
    return sentences


def _headed(evidence: EffectVerdict, rows: pd.DataFrame, source: str, between: str) -> str:
    whence = f"by the model ({source} wall)"
    if source == "measured":
        whence = "" if question_of(rows.iloc[0]["quantity"]) == question_of("mPAP") else "without any image"
    small = f"{EffectVerdict.SMALL} {limit(rows)}"
    start = {EffectVerdict.SHOWN: "", EffectVerdict.SMALL: small}.get(evidence, str(evidence))
    text = ", ".join(filter(None, (f"{start} {between}".strip() if start else "", whence))) or "measured"
    return f"{text[0].upper()}{text[1:]}"


def names(rows: pd.DataFrame, called: Called) -> str:
    """Return the quantities of rows in words."""
    return listed(list(dict.fromkeys(plain(name, called) for name in rows["quantity"])))


def sentence(text: str) -> str:
    """Return a text as a sentence."""
    return f"{text[0].upper()}{text[1:]}."


def separated(rows: pd.DataFrame, called: Called, chances: Sequence[float]) -> str:
    """Name the quantities in which no animal of one group lies among the other, and how often chance does that."""
    disjoint = rows[rows["apart"]]
    scope = "" if len(disjoint) == len(rows) == 1 else f" in {listed([called(name) for name in disjoint['quantity']])}"
    share = number(100 * max(chances), 2)
    return f"The groups do not overlap{scope}, which chance alone does in {share} % of quantities."
