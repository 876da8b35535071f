"""The page of a plan: how many animals, what they show, and what would save some."""

from pathlib import Path

import numpy as np

from vasowave.base.io.files import write_file
from vasowave.base.software import provenance
from vasowave.pulse.quantities import short_symbol
from vasowave.study.cohort.planning import Plan
from vasowave.study.cohort.power import Spread
from vasowave.study.report.blocks import Block, Drawing, Paragraph, Report, Section, SideBySide, Table
from vasowave.study.report.html import page
from vasowave.study.report.terms import words
from vasowave.study.report.wording import listed, number


def write_plan(plan: Plan, path: Path) -> Path:
    """Write a plan as one page and return it.

    Raises
    ------
    InputError
        It cannot be written.
    """
    caption = _CAPTION.format("pairs" if plan.settings.pairs is not None else "animals in each of two groups")
    blocks: list[Block] = [Paragraph(text) for text in plan_texts(plan)]
    blocks += [SideBySide([_needed(plan)], [Drawing("Power", caption, plan.figure())]), _spreads(plan)]
    section = Section("plan", "How many animals", blocks)
    title = f"Plan: a ratio of {plan.settings.effect:g} between two groups"
    document = Report("plan", title, f"Spreads of {plan.source}", "", [section], provenance())
    return write_file(path, page(document, {}))


_CAPTION = "Power of each quantity by the number of {}; grey: what is asked for."


def plan_texts(plan: Plan) -> list[str]:
    """Return what a plan comes to, in sentences."""
    settings, needed = plan.settings, plan.needed["as it is"]
    shown = needed[np.isfinite(needed)]
    enumeration = listed(
        [f"{count:.0f} for {words(str(name), {})} {short_symbol(str(name))}" for name, count in shown.items()]
    )
    largest_size = plan.powers.index[-1]
    aim = f"a ratio of {settings.effect:g} with a power of {number(settings.power, 2)}"
    paired = settings.pairs is not None
    need = f"To show {aim}, {'pairs are needed' if paired else 'each of two groups needs'}: {enumeration}."
    unit = "pairs" if paired else "animals in each group"
    none = f"No quantity shows a ratio of {settings.effect:g} with {largest_size} {unit}."
    sentences = [need if len(shown) else none]
    beyond = [short_symbol(str(name)) for name in needed.index[~np.isfinite(needed)]]
    if beyond and len(shown):
        sentences.append(f"More than {plan.powers.index[-1]} for {listed(beyond)}.")
    measures = f"more beats; {'' if paired else _OWN}{_AGAIN[paired]}"
    sentences.append(
        f"Each quantity is judged in the family of all {len(needed)}, with the p of the primary comparison; logarithms "
        "are taken as normal. A column of the table that needs fewer animals is what that change would save: errors "
        f"halved, as by a better image or {measures}."
    )
    if paired:
        pair_text = "littermates, one in each group" if settings.littermates else "one animal on two occasions"
        sentences.append(
            f"A pair is {pair_text}; its two true values are taken as correlated by {settings.pairs:g}. The mixed "
            "model of the design judges it; errors that a pair shares cancel."
        )
    repeated_spreads = [spread for spread in plan.spreads if spread.within]
    if repeated_spreads:
        enumeration = listed([f"{short_symbol(spread.quantity)} {spread.alike:.2f}" for spread in repeated_spreads])
        sentences.append(f"In this study true values of one animal on two occasions are correlated by: {enumeration}.")
    elif not paired:
        sentences.append(
            "How far an animal differs from day to day is not known apart from how far animals differ: a second "
            "occasion may save more than the table says. A pilot with a subject in its design tells it."
        )
    if not any(spread.error for spread in plan.spreads):
        sentences.append(
            "How much of the spread is error of measurement is not known here, so that the table cannot say what "
            "smaller errors would save."
        )
    return sentences


_OWN = "images of one's own in place of shared ones; "
_AGAIN = {
    False: "a second occasion of each animal, which lessens errors and what an animal differs from day to day",
    True: "two recordings of each animal on each occasion, which lessen errors alone",
}
"""What more recordings do, of groups and of pairs."""


def _needed(plan: Plan) -> Table:
    frame = plan.needed.reset_index(names="quantity")
    frame["quantity"] = [short_symbol(str(name)) for name in frame["quantity"]]
    cells = [
        (row[0], *("more" if not np.isfinite(count) else f"{count:.0f}" for count in row[1:]))
        for row in frame.itertuples(index=False)
    ]
    note = f"more: more than {plan.powers.index[-1]}."
    return Table(
        "Needed",
        "Pairs" if plan.settings.pairs is not None else "Animals of each group",
        tuple(map(str, frame.columns)),
        cells,
        note,
        plan.needed.reset_index(),
    )


def _spreads(plan: Plan) -> Table:
    has_occasions = any(spread.within for spread in plan.spreads)

    def cells_of(spread: Spread) -> tuple[str, ...]:
        values = (*spread.between, spread.within if has_occasions else None, spread.error, spread.shared)
        return short_symbol(spread.quantity), *(
            "not known" if value is None else f"{100 * value:.0f} %" for value in values
        )

    header = ("quantity", "between animals, first group", "second group", "one animal between occasions",
              "error of one", "shared error of the ratio")  # fmt: skip
    return Table(
        "Spreads", "What the plan rests on: SD of logarithms", header, [cells_of(spread) for spread in plan.spreads]
    )
