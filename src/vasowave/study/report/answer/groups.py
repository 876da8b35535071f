"""The differences of the groups: who differs how in one sentence, the numbers for each question, how sure they are."""

from collections.abc import Sequence
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, Value
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.contrast import MIN_FREEDOM
from vasowave.study.cohort.design import laid_out
from vasowave.study.cohort.effects import DesignEffect, Effect, GroupEffect, grouped
from vasowave.study.cohort.guard import RULES, PopulationShape, doubts_of
from vasowave.study.cohort.primary import Missed, Primary
from vasowave.study.figures.matplotlib_style import short
from vasowave.study.report.answer.effects import (
    MAX_LETTERS,
    Called,
    Crossing,
    EffectVerdict,
    by_standing,
    crossing,
    labels,
    limit,
    names,
    numbers,
    place_in_lead,
    plain,
    sentence,
    standing,
    verdict_on,
    where,
)
from vasowave.study.report.answer.marks import Mark, unmarked
from vasowave.study.report.wording import LIMIT, listed, number, ratio_with_interval, some_of, span, unlimited

CLEAR = LIMIT
"""Family-wise p below which a difference is said to be shown."""

_MAX_NAMED = 3  # undecided quantities in the lead of several comparisons, and those shown alone

THE_ANSWER, RESTS_ON, HOW_SURE = "The answer", "What does this rest on?", "How sure is this?"
"""The titles of the sentence that answers the question of a study, and of what is read after its numbers."""
ONE_QUESTION = "What if one quantity had been the question?"


class StudyAnswer(NamedTuple):
    """The answer to the question of a study."""

    first: list[str]
    """Who differs how, a sentence or two for each effect."""
    questions: list[tuple[str, str]]
    """Each question with the numbers of its effects."""
    sureness: list[str]
    """What limits the p and intervals."""

    def items(self, rests_on: Sequence[str] = (), sure: Sequence[str] = ()) -> list[tuple[str, str]]:
        """Return questions with their answers, the whole first; with what all rests on, and more of how sure it is."""
        basis, sureness = " ".join(rests_on), " ".join([*self.sureness, *sure])
        ends = [(RESTS_ON, basis), (HOW_SURE, sureness)]
        first = [(THE_ANSWER, " ".join(self.first))] if self.first else []
        return [*first, *self.questions, *(end for end in ends if end[1])]


def group_answer(primary: Primary, called: Called, mark: Mark = unmarked) -> StudyAnswer:
    """Return the answer to what differs between the groups, each against the first; `mark` marks numbers."""
    effects = primary.effects
    if not effects:
        return StudyAnswer([], [], [])
    crossed = crossing(effects)
    effects = tuple(sorted(effects, key=place_in_lead(effects)))
    by_contrast = grouped(_leading(effects), lambda effect: effect.contrast)
    brief = len(grouped(effects, lambda effect: effect.contrast)) > 1
    first = [_first(of_contrast, called, crossed, brief) for of_contrast in by_contrast.values()]
    questions: dict[str, list[str]] = {}
    for (question, _), asked in grouped(effects, lambda effect: (effect.question, effect.contrast)).items():
        questions.setdefault(question, []).append(_numbers(asked, called, mark, crossed, brief))
    questions |= {ONE_QUESTION: texts} if (texts := shown_alone(primary, called)) else {}
    answers = [(question, " ".join(texts)) for question, texts in questions.items()]
    count = tested(effects)
    many = f"Those of ratios and p are corrected for {count} comparisons, all others hold alone. " if count > 1 else ""
    corrected = f"Brackets are 95 % intervals. {many}A p near 1 does not say that groups are equal."
    sure = [*([corrected] if count else []), *sureness(effects), *_least_shown(effects, called)]
    return StudyAnswer(first, answers, sure)


def shown_alone(primary: Primary, called: Called) -> list[str]:
    """Say what would have been shown as the only question, where the study names none, and what that is worth."""
    alone = [] if primary.stated else primary.shown_alone
    if not alone:
        return []
    several = len(labels(primary.effects)) > 1
    named = some_of([f"{called(effect.quantity)} ({f'{effect.contrast}, ' if several else ''}p = {number(p, 2)})"
                     for effect, p in sorted(alone, key=itemgetter(1))], _MAX_NAMED)  # fmt: skip
    count = len({effect.quantity for effect in primary.effects if not effect.untested})
    subject = "each of these" if len(alone) > 1 else "it"
    return [
        f"The study names none, so that {count} quantities were tested together. Tested alone, {subject} would have "
        f"been shown: {named}. Such a p holds only where that question was fixed before anybody saw the results; "
        "else it is a plan for the next study (`report.quantities` in study.yaml)."
    ]


def _leading(effects: Sequence[Effect]) -> Sequence[Effect]:
    """Return the effects of the lead: where followed groups are shown to change unlike, their averages stand below."""
    unlike = [effect for effect in effects if effect.contrast.kind == "interaction"]
    followed = bool(effects) and effects[0].contrast.kind == "interaction"
    return unlike if followed and EffectVerdict.SHOWN in by_standing(unlike) else effects


def _first(effects: Sequence[Effect], called: Called, crossed: Crossing, brief: bool) -> str:
    """Return what is higher and lower in one sentence, and what is not shown in another, counted where `brief`."""
    _, between = where(effects[0].contrast, crossed)
    effects_by_standing = by_standing(effects)
    shown = effects_by_standing.pop(EffectVerdict.SHOWN, None)
    clauses = [] if shown is None else [f"{verdict_on(shown, called, crossed, sized=True)}{_condition(effects)}"]
    if shown is None and {*effects_by_standing} != {EffectVerdict.UNTESTED}:
        clauses.append(f"no difference {between} is shown")
    for verdict, of_verdict in effects_by_standing.items():
        detail = " (neither shown nor excluded)" if verdict is EffectVerdict.OPEN else ""
        detail = f" {limit(of_verdict)}" if verdict is EffectVerdict.SMALL else detail
        detail = " (animals share an image of unknown error)" if verdict is EffectVerdict.UNTESTED else detail
        counted = brief and verdict is EffectVerdict.OPEN and len(of_verdict) > _MAX_NAMED
        named = f"{len(of_verdict)} quantities, see below" if counted else names(of_verdict, called)
        clauses.append(f"{verdict}{detail}: {named}")
    return " ".join(map(sentence, clauses))


def _condition(effects: Sequence[Effect]) -> str:
    """Return of how many animals and on which condition effects are shown, if these are too few for ranks."""
    sizes = [f"{effect.n_reference} + {effect.n_group}" for effect in effects if effect.smallest_p >= CLEAR]
    return f" ({listed([*dict.fromkeys(sizes)])} animals), if logarithms are normal" if sizes else ""


def _numbers(effects: Sequence[Effect], called: Called, mark: Mark, crossed: Crossing, brief: bool) -> str:
    """Return the verdict on one question and the numbers behind it, where `brief` of what is decided."""
    _, between = where(effects[0].contrast, crossed)
    shown = by_standing(effects).get(EffectVerdict.SHOWN)
    sentences = [] if shown is None else [sentence(verdict_on(shown, called, crossed))]
    sentences += numbers(effects, called, mark, "" if shown is not None else between, brief)
    return " ".join(sentences)


def not_told(primary: Primary, called: Called) -> list[str]:
    """Return what a design does not tell and why; of which quantities where it tells it of others."""
    quantities = {effect.quantity for effect in primary.effects}
    quantities |= {name for missed in primary.untold for name in missed.quantities}
    texts = []
    for (code, values, untold), alike in grouped(primary.untold, _reason).items():
        effects = listed(["{effect}{instead}".format_map(dict(missed.finding.values)) for missed in alike])
        of_some = "" if quantities == {*untold} else f" (of {listed([*map(called, untold)])})"
        texts.append(f"{Finding(code, (('effect', effects), ('instead', ''), *values))}{of_some}")
    return texts


def _reason(missed: Missed) -> tuple[str, tuple[tuple[str, Value], ...], tuple[str, ...]]:
    """Return why an effect is not told, and of which quantities: what is the same of several effects is said once."""
    values = tuple((name, value) for name, value in missed.finding.values if name not in ("effect", "instead"))
    return missed.finding.code, values, missed.quantities


def sureness(effects: Sequence[Effect]) -> list[str]:
    """Say what limits p and intervals: too few animals, few degrees of freedom."""
    sentences = []
    limits = {
        (effect.n_reference, effect.n_group, effect.smallest_p): None
        for effect in effects
        if effect.smallest_p >= CLEAR
    }
    if limits:
        pairs = len(labels(effects))
        counted = f" that counts for {pairs} pairs of groups" if pairs > 1 else ""
        texts = listed([f"{number(smallest, 2)} with {a} + {b} animals" for a, b, smallest in limits])
        sentences.append(
            f"A test by ranks{counted} cannot come below p = {texts}: p and intervals rest on logarithms being normal. "
            f"So few animals may by chance scatter {_hidden_scatter([a + b for a, b, _ in limits])} times less than "
            "all such animals do; p and intervals allow for that, but not for animals chosen alike, as litter mates "
            "or one animal recorded twice."
        )
    return [*sentences, *_few_degrees(effects)]


def _hidden_scatter(animals: Sequence[int]) -> str:
    """Return how many times the scatter of all animals may exceed that of the fewest in two groups (97.5 %)."""
    from scipy.stats import chi2

    freedom = max(1, min(animals) - 2)
    return number(float(np.sqrt(freedom / chi2.ppf(0.025, freedom))), 2)


def doubts_text(cohort: Cohort, primary: Primary) -> list[str]:
    """Say how often chance alone shows something if animals are of a shape that so few do not show."""
    if not primary.effects:
        return []
    try:
        layout = laid_out(cohort.design, cohort.variables, cohort.members, list(cohort.groups))
    except InputError:  # though some quantities are compared, whose animals are fewer
        return []
    kinds = []
    for doubt in doubts_of(layout, len({effect.quantity for effect in primary.effects})):
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


def tested(effects: Sequence[Effect]) -> int:
    """Return the number of effects that have a p, for which p and intervals are corrected."""
    return sum(not effect.untested for effect in effects)


def _least_shown(effects: Sequence[Effect], called: Called) -> list[str]:
    """Say how large undecided effects must be to be shown by animals that vary as these do."""
    open_effects = [effect for effect in effects
                    if standing(effect) is EffectVerdict.OPEN and not unlimited(effect.low, effect.high)]  # fmt: skip
    if not open_effects:
        return []
    several = len(labels(effects)) > 1 or isinstance(effects[0], DesignEffect)
    by_subject = grouped(
        open_effects, lambda effect: str(effect.contrast) if several else plain(effect.quantity, called)
    )
    sizes = [f"{subject} {span(np.array([np.sqrt(effect.high / effect.low) for effect in rows]), 2)}"
             for subject, rows in by_subject.items()]  # fmt: skip
    return [
        f"With animals that vary as these do, what is undecided would be shown by a found ratio of about these or more "
        f"(one over them or less): {listed(sizes)}{', by quantity' if several else ''}. "
        "`vasowave plan` says how many animals show smaller ones."
    ]


def _few_degrees(effects: Sequence[Effect]) -> list[str]:
    """Say which effects of a design rest on few degrees of freedom, so that they must be large to be shown."""
    sparse = [effect for effect in effects if isinstance(effect, DesignEffect) and effect.freedom < MIN_FREEDOM]
    if not sparse:
        return []
    freedom = span(np.array([effect.freedom for effect in sparse]), 2)
    return [
        f"{listed(labels(sparse))}: {len(sparse)} of {len(effects)} ratios rest on {freedom} degrees of freedom and "
        "must be large to be shown; fewer covariates, blocks, quantities or contrasts would leave more."
    ]


def sensitivity(primary: Primary, called: Called) -> list[str]:
    """Say what one animal, the fits in place of posteriors, and other wall laws would change."""
    return [*influence(primary, called), *by_fits(primary, called), *other_laws(primary, called)]


def influence(primary: Primary, called: Called) -> list[str]:
    """Say which animal carries most of any effect, and which effect that is where there are several."""
    effects = [effect for effect in primary.effects if effect.without]
    if not effects:
        return []
    ratios, ratios_without = np.array([(effect.ratio, effect.ratio_without) for effect in effects]).T
    moved = np.abs(np.log(ratios_without / ratios))
    effect = effects[int(moved.round(9).argmax())]  # the first of those that round-off alone tells apart
    outside = sum(effect.ratio_without < effect.low or effect.ratio_without > effect.high for effect in effects)
    end = (
        f"; leaving out one animal takes {outside} ratios out of their intervals"
        if outside
        else "; without any one animal every ratio stays inside its interval"
    )
    scope = f" ({effect.contrast})" if len(labels(primary.effects)) > 1 else ""
    return [
        f"One animal moves an effect most: without {short(effect.without, MAX_LETTERS)}, {called(effect.quantity)}"
        f"{scope} is {number(effect.ratio_without)} times instead of {number(effect.ratio)}{end}."
    ]


def by_fits(primary: Primary, called: Called) -> list[str]:
    """Say where fits judge otherwise than the posteriors that the effects are by."""
    effects = [
        effect for effect in primary.effects if isinstance(effect, GroupEffect) and not np.isnan(effect.fits_ratio)
    ]
    if not effects:
        return []
    differences = []
    for effect in effects:
        shown = not effect.fits_low <= 1 <= effect.fits_high
        if shown != (effect.p < CLEAR):
            text = ratio_with_interval(effect.fits_ratio, effect.fits_low, effect.fits_high)
            size, _, interval = text.partition(" ")
            judged = f"they {'' if shown else 'do not '}show ({size} times {interval})"
            group = short(effect.contrast.group, MAX_LETTERS)
            differences.append(f"{called(effect.quantity)} in {group}, which {judged}")
    if not differences:
        return ["Fits of the same animals show the same effects as their posteriors."]
    return [
        f"Fits of the same animals judge otherwise of {listed(differences)}. Posteriors decide: of assumed errors "
        "they take from each recording what it says, and fits count them whole."
    ]


def other_laws(primary: Primary, called: Called) -> list[str]:
    """Say where another wall law gives another effect."""
    if not primary.others:
        return []
    effects = {(effect.contrast, effect.quantity): effect for effect in primary.effects}
    pairs = [
        (estimate, effects[key])
        for estimate in primary.others
        if (key := (estimate.contrast, estimate.quantity)) in effects
    ]
    several = len(labels(estimate for estimate, _ in pairs)) > 1
    ratios = [
        f"{called(estimate.quantity)} {number(estimate.ratio)} times "
        f"({estimate.source}{f'; {estimate.contrast}' if several else ''})"
        for estimate, effect in pairs
        if estimate.ratio < effect.low or estimate.ratio > effect.high
    ]
    laws = listed([f"the {law} wall" for law in dict.fromkeys(estimate.source for estimate in primary.others)])
    if not ratios:
        return [f"By {laws} every ratio lies inside the intervals of the {primary.law} wall."]
    return [f"Outside the intervals of the {primary.law} wall lie {listed(ratios)}."]
