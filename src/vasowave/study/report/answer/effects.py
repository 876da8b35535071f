"""One effect of the primary comparison in words: where it is, how large, and what the animals say of it."""

from collections.abc import Callable, Iterable, Sequence
from enum import StrEnum

import numpy as np

from vasowave.pulse.quantities import QUANTITIES, described, question_of
from vasowave.study.cohort.effects import ContrastEstimate, ContrastLabel, Effect, grouped
from vasowave.study.figures.matplotlib_style import short
from vasowave.study.report.answer.marks import Mark
from vasowave.study.report.wording import LIMIT, listed, number, probability, ratio_with_interval, unit

MAX_LETTERS = 40  # of a name in a sentence
SMALL = 0.8, 1.25
"""Ratios between which an effect is small: those that count as equivalent between two drugs."""
Called = Callable[[str], str]
"""Returns a quantity in words with its symbol."""


class EffectVerdict(StrEnum):
    """What the animals say of an effect."""

    SHOWN = "shown"
    SMALL = "no effect larger than"
    OPEN = "undecided"
    UNTESTED = "without p"


def standing(effect: Effect) -> EffectVerdict:
    """Return what the animals say of an effect."""
    if effect.untested:
        return EffectVerdict.UNTESTED
    if effect.p < LIMIT:
        return EffectVerdict.SHOWN
    return EffectVerdict.SMALL if effect.low >= SMALL[0] and effect.high <= SMALL[1] else EffectVerdict.OPEN


def by_standing(effects: Sequence[Effect]) -> dict[EffectVerdict, list[Effect]]:
    """Return the effects of each standing that has any."""
    standings = grouped(effects, standing)
    return {verdict: standings[verdict] for verdict in EffectVerdict if verdict in standings}


def where(contrast: ContrastLabel, averaged: str) -> tuple[str, str]:
    """Return where an effect is, as a sentence says it behind a comparative, and of an effect that is not shown.

    Where groups may differ in a second factor, it is averaged over them, and they over its levels, which are named.
    """
    reference, group = short(contrast.reference, MAX_LETTERS), short(contrast.group, MAX_LETTERS)
    within = f" {short(contrast.within, MAX_LETTERS)}" if contrast.within else ""
    match contrast.kind:
        case "factor":
            within = within or (" on average over the groups" if averaged else "")
            return f"at {group} than at {reference}{within}", f"between {group} and {reference}{within}"
        case "trend":
            return f"at {group} than at {reference} by the trend", f"from {reference} to {group} by the trend"
        case "interaction":
            ratio = f"in the ratio {short(contrast.change, MAX_LETTERS)}"
            return f"in {group} than in {reference}, {ratio}", f"between {group} and {reference} {ratio}"
        case "contrast":
            return f"by the contrast '{group}'", f"by the contrast '{group}'"
    within = within or (f" on average over {averaged}" if averaged else "")
    return f"in {group} than in {reference}{within}", f"between {group} and {reference}{within}"


def labels(estimates: Iterable[ContrastEstimate]) -> list[str]:
    """Return the contrasts of some estimates, each once: ``HPH / CTL``."""
    return [*dict.fromkeys(str(estimate.contrast) for estimate in estimates)]


def comparatives(effects: Sequence[Effect], called: Called, sized: bool = False) -> str:
    """Return what is higher and lower, ``higher mean pressure and cardiac output, stiffer large arteries``."""
    subjects_by_comparative: dict[str, list[str]] = {}
    for effect in effects:
        higher, less, noun = described(effect.quantity).comparatives
        whence = "" if effect.source == "measured" else " by the model"
        ratio = ratio_with_interval(effect.ratio, effect.low, effect.high).partition(" ")[0]
        size = f" (× {ratio}{whence})" if sized else ""
        subjects_by_comparative.setdefault(higher if effect.ratio > 1 else less, []).append(
            (noun or plain(effect.quantity, called)) + size
        )
    return listed(
        [
            f"{comparative} {listed(list(dict.fromkeys(subjects)))}"
            for comparative, subjects in subjects_by_comparative.items()
        ]
    )


def plain(name: str, called: Called) -> str:
    """Return a quantity in words without its symbol, where it has words."""
    quantity = QUANTITIES.get(name)
    return (quantity and (quantity.words or quantity.meaning.split(",")[0])) or called(name)


def effect_text(effect: Effect, called: Called, mark: Mark) -> str:
    """Return an effect as one writes it: ``mPAP 13.5 → 21.5 mmHg (1.6 times [1.3, 2.0], p = 0.010)``, and its mark."""
    size, _, interval = ratio_with_interval(effect.ratio, effect.low, effect.high).partition(" ")
    of_means = f" {change(effect)}" if np.isfinite(effect.mean_group) else ""
    tested = "" if effect.untested else f", {probability(effect.p)}"
    times = f"{size} times {interval}".rstrip()
    return f"{called(effect.quantity)}{of_means} ({times}{tested}){mark(effect)}"


def change(effect: Effect) -> str:
    """Return the means of the two groups with their unit, ``13.5 → 21.5 mmHg``."""
    return f"{number(effect.mean_reference)} → {number(effect.mean_group)} {unit(effect.unit)}".rstrip()


def limit(effects: Sequence[Effect]) -> str:
    """Return the factor that small effects do not exceed either way, rounded up."""
    factor = max(*(effect.high for effect in effects), 1 / min(effect.low for effect in effects))
    return f"a factor of {np.ceil(round(100 * factor, 6)) / 100:.2f}"


def numbers(effects: Sequence[Effect], called: Called, mark: Mark, between: str) -> list[str]:
    """Return the sentences on the effects of one question: each standing, and of each what takes no image first.

    `between` what they are stands in the first one.
    """
    sentences: list[str] = []
    for verdict, of_verdict in by_standing(effects).items():
        for source, of_source in grouped(of_verdict, lambda effect: effect.source).items():
            texts = listed([effect_text(effect, called, mark) for effect in of_source])
            sentences.append(f"{_headed(verdict, of_source, source, '' if sentences else between)}: {texts}.")
    return sentences


def _headed(verdict: EffectVerdict, effects: Sequence[Effect], source: str, between: str) -> str:
    whence = f"by the model ({source} wall)"
    if source == "measured":
        whence = "" if effects[0].question == question_of("mPAP") else "without any image"
    bound = f" {limit(effects)}" if verdict is EffectVerdict.SMALL else ""
    start = "" if verdict is EffectVerdict.SHOWN else f"{verdict}{bound}"
    text = ", ".join(filter(None, (f"{start} {between}".strip() if start else "", whence))) or "measured"
    return f"{text[0].upper()}{text[1:]}"


def names(effects: Sequence[Effect], called: Called) -> str:
    """Return the quantities of effects in words."""
    return listed(list(dict.fromkeys(plain(effect.quantity, called) for effect in effects)))


def sentence(text: str) -> str:
    """Return a text as a sentence."""
    return f"{text[0].upper()}{text[1:]}."


def separated(effects: Sequence[Effect], called: Called, chances: Sequence[float]) -> str:
    """Name the quantities in which no animal of one group lies among the other, and how often chance does that."""
    disjoint = [called(effect.quantity) for effect in effects if effect.apart]
    scope = "" if len(disjoint) == len(effects) == 1 else f" in {listed(disjoint)}"
    share = number(100 * max(chances), 2)
    return f"The groups do not overlap{scope}, which chance alone does in {share} % of quantities."
