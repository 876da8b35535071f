"""The design of a cohort in words."""

from collections.abc import Mapping

from vasowave.study.cohort.cohort import Cohort
from vasowave.study.figures.matplotlib_style import short
from vasowave.study.report.answer.effects import MAX_LETTERS
from vasowave.study.report.wording import listed, some_of

_MAX_LEVELS = 6


def design_answer(cohort: Cohort) -> list[tuple[str, str]]:
    """Return the question and the answer of a design; none for groups of independent animals."""
    text = design_text(cohort)
    return [("How were animals compared?", text)] if text else []


def design_text(cohort: Cohort) -> str:
    """Return the design of a cohort in a sentence or two; empty for groups of independent animals."""
    design = cohort.design
    if design.plain:
        return ""
    clauses = []
    if design.covariates:
        named = listed([*map(_named, design.covariates)])
        clauses.append(
            f"ratios and means of groups are adjusted for {named}: they are those of groups with the same mean of it "
            "(of a category: with as many animals of each kind)"
        )
    if design.blocks:
        levels = [f"{_named(name)}{_levels(cohort, name)}" for name in design.blocks]
        clauses.append(f"animals of one {listed(levels)} may be alike (random effects)")
    if design.subject:
        rows = cohort.variables[design.subject].levels if design.subject in cohort.variables else {}
        clauses.append(
            f"the {len(cohort.results)} recordings are of {len(set(rows.values()))} animals (column "
            f"{_named(design.subject)}), whose own level is a random effect"
            + (", and which may be in several groups, one after the other" if design.crossover else "")
        )
    if design.second and not design.contrasts:
        clauses.append(_second(cohort))
    if design.contrasts:
        defined = [f"{_named(name)} = {_weights(weights)}" for name, weights in design.contrasts.items()]
        clauses.append(f"the comparisons are those that the study names, of means on logarithms: {listed(defined)}")
    text = "; ".join(clauses)
    return f"{text[0].upper()}{text[1:]}."


def _second(cohort: Cohort) -> str:
    design, name = cohort.design, str(cohort.design.second)
    if design.dose:
        return f"compared is the trend with {_named(name)}, by the line through the means"
    order = [*map(_named, cohort.variables[name].order)] if name in cohort.variables else []
    levels = f"{some_of(order, _MAX_LEVELS)}{f'; compared with {order[0]}' if order else ''}"
    several = len(cohort.groups) > 1
    scope = "in each group of its own" if design.interaction else "alike in all groups"
    return f"{_named(name)} ({levels}) is a second factor{f', its effect {scope}' if several else ''}"


def _weights(weights: Mapping[str, float]) -> str:
    """Return a contrast as a sum: ``'HPH, drug' - 'HPH, vehicle'``."""
    terms: list[str] = []
    for cell, weight in sorted(weights.items(), key=lambda pair: pair[1] < 0):
        size = "" if abs(weight) == 1 else f"{abs(weight):.3g} · "
        sign = ("− " if weight < 0 else "+ ") if terms or weight < 0 else ""
        terms += [f"{sign}{size}'{_named(cell)}'"] if weight else []
    return " ".join(terms)


def _named(name: str) -> str:
    return short(name, MAX_LETTERS)


def _levels(cohort: Cohort, name: str) -> str:
    """Return which levels a column has: `` (of 4: A, B, C and D)``."""
    order = [*map(_named, cohort.variables[name].order)] if name in cohort.variables else []
    return f" (of {len(order)}: {some_of(order, _MAX_LEVELS)})" if order else ""
