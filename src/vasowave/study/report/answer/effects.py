"""One effect of the primary comparison in words: where it is, how large, and what the animals say of it."""

from collections.abc import Callable, Iterable, Sequence
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from vasowave.pulse.quantities import QUANTITIES, described, question_of
from vasowave.study.cohort.effects import ContrastEstimate, ContrastLabel, DesignEffect, Effect, grouped
from vasowave.study.figures.matplotlib_style import short
from vasowave.study.report.answer.marks import Mark
from vasowave.study.report.wording import LIMIT, also_read, listed, number, probability, ratio_with_interval, unit

MAX_LETTERS = 40  # of a name in a sentence
SMALL = 0.8, 1.25
"""Ratios between which an effect is small: those that count as equivalent between two drugs."""
_ALIKE = 2.0
"""Times by which one change must exceed another that goes the other way to be called larger."""
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


class Crossing(NamedTuple):
    """How groups are crossed with a second factor.

    Attributes
    ----------
    levels : str
        The levels in words, where groups may differ in them.
    followed : bool
        Whether animals were recorded at several of them.
    """

    levels: str = ""
    followed: bool = False


def crossing(effects: Sequence[Effect]) -> Crossing:
    """Return how the groups of effects are crossed with a second factor."""
    factors = [effect for effect in effects if effect.contrast.kind == "factor"]
    followed = any(isinstance(effect, DesignEffect) and effect.n_both for effect in factors)
    if not any(effect.contrast.kind == "interaction" for effect in effects):
        return Crossing("", followed)
    levels = dict.fromkeys(level for effect in factors for level in (effect.contrast.reference, effect.contrast.group))
    return Crossing(listed([short(level, MAX_LETTERS) for level in levels]) or "the second factor", followed)


def place_in_lead(effects: Sequence[Effect]) -> Callable[[Effect], int]:
    """Return what orders effects: where animals were followed, how they changed comes before the groups."""
    order = ("interaction", "factor") if crossing(effects).followed else ()
    return lambda effect: order.index(effect.contrast.kind) if effect.contrast.kind in order else len(order)


def where(contrast: ContrastLabel, crossed: Crossing) -> tuple[str, str]:
    """Return where an effect is, as a sentence says it behind a comparative, and of an effect that is not shown.

    Where groups may differ in a second factor, it is averaged over them, and they over its levels, which are named.
    """
    reference, group = short(contrast.reference, MAX_LETTERS), short(contrast.group, MAX_LETTERS)
    within = f" {short(contrast.within, MAX_LETTERS)}" if contrast.within else ""
    match contrast.kind:
        case "factor":
            within = within or (" on average over the groups" if crossed.levels else "")
            return f"at {group} than at {reference}{within}", f"between {group} and {reference}{within}"
        case "trend":
            return f"at {group} than at {reference} by the trend", f"from {reference} to {group} by the trend"
        case "interaction":
            span = _span(contrast.change, crossed)
            return f"in {group} than in {reference} {span}", f"between {group} and {reference} in the change {span}"
        case "contrast":
            return f"by the contrast '{group}'", f"by the contrast '{group}'"
    within = within or (f" on average over {crossed.levels}" if crossed.levels else "")
    return f"in {group} than in {reference}{within}", f"between {group} and {reference}{within}"


def _span(change: str, crossed: Crossing) -> str:
    """Return from what to what a change is: of ``post/pre`` from pre to post."""
    later, _, first = change.partition("/")
    if change.count("/") != 1:
        return f"({short(change, MAX_LETTERS)})"
    later, first = short(later, MAX_LETTERS), short(first, MAX_LETTERS)
    return f"from {first} to {later}" if crossed.followed else f"between {first} and {later}"


def verdict_on(effects: Sequence[Effect], called: Called, crossed: Crossing, sized: bool = False) -> str:
    """Return who is higher and lower in what, of one contrast; of changes who changed more and less."""
    place, _ = where(effects[0].contrast, crossed)
    if effects[0].contrast.kind != "interaction" or not all(np.isfinite(effect.mean_group) for effect in effects):
        return f"{comparatives(effects, called, sized)} {place}"
    verb, clauses = "changed" if crossed.followed else "differs", []
    for size, of_size in grouped(effects, _size_of_change).items():
        sizes = [f"{plain(effect.quantity, called)}{_both_changes(effect) if sized else ''}" for effect in of_size]
        clauses.append(f"{verb} {size} {place}: {listed(sizes)}")
    return "; ".join(clauses)


def _size_of_change(effect: Effect) -> str:
    """Return whether the group of an interaction changes by a larger factor, up or down, than the reference."""
    group, reference = np.log([effect.mean_group, effect.mean_reference])
    small, large = sorted((abs(group), abs(reference)))
    if group * reference < 0 and large < _ALIKE * small:
        return "otherwise"
    return "more" if abs(group) == large else "less"


def _both_changes(effect: Effect) -> str:
    whence = "" if effect.source == "measured" else " by the model"
    return f" (× {number(effect.mean_group, 2)} against × {number(effect.mean_reference, 2)}{whence})"


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
    """Return the means of the two groups with their unit, ``13.5 → 21.5 mmHg``, or by what factor each changed."""
    means = effect.mean_reference, effect.mean_group
    if effect.contrast.kind == "interaction":
        sides = effect.contrast.reference, effect.contrast.group
        return ", ".join(f"× {number(mean)} in {short(side)}" for mean, side in zip(means, sides, strict=True))
    units = [(unit(effect.unit), 1.0), *also_read(effect.unit)]
    return " = ".join(" → ".join(number(factor * mean) for mean in means) + f" {name}".rstrip()
                      for name, factor in units)  # fmt: skip


def limit(effects: Sequence[Effect]) -> str:
    """Return the factor that small effects do not exceed either way, rounded up."""
    factor = max(*(effect.high for effect in effects), 1 / min(effect.low for effect in effects))
    return f"a factor of {np.ceil(round(100 * factor, 6)) / 100:.2f}"


def numbers(effects: Sequence[Effect], called: Called, mark: Mark, between: str, brief: bool = False) -> list[str]:
    """Return the sentences on the effects of one question: each standing, and of each what takes no image first.

    `between` what they are stands in the first one. Where `brief`, what is undecided is named alone: its numbers stand
    in the figure.
    """
    sentences: list[str] = []
    for verdict, of_verdict in by_standing(effects).items():
        for source, of_source in grouped(of_verdict, lambda effect: effect.source).items():
            alone = brief and verdict is EffectVerdict.OPEN
            texts = listed([called(effect.quantity) if alone else effect_text(effect, called, mark)
                            for effect in of_source])  # fmt: skip
            sentences.append(f"{_headed(verdict, of_source, source, '' if sentences else between)}: {texts}.")
    return sentences


def _headed(verdict: EffectVerdict, effects: Sequence[Effect], source: str, between: str) -> str:
    whence = f"by the model ({source} wall)"
    if source == "measured":
        whence = "" if effects[0].question == question_of("mPAP") else "without any image"
    bound = f" {limit(effects)}" if verdict is EffectVerdict.SMALL else ""
    start = "" if verdict is EffectVerdict.SHOWN else f"{verdict}{bound}"
    modeled = isinstance(effects[0], DesignEffect) and effects[0].contrast.kind != "interaction"
    means = "means by the design" if modeled and verdict is not EffectVerdict.OPEN else ""
    heads = [f"{start} {between}".strip() if start else "", whence]
    text = ", ".join(filter(None, (*(heads if any(heads) else ["measured"]), means)))
    return f"{text[0].upper()}{text[1:]}"


def names(effects: Sequence[Effect], called: Called) -> str:
    """Return the quantities of effects in words."""
    return listed(list(dict.fromkeys(plain(effect.quantity, called) for effect in effects)))


def sentence(text: str) -> str:
    """Return a text as a sentence."""
    return f"{text[0].upper()}{text[1:]}."
