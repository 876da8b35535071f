"""The first page: answers beside the forest plot, the waveforms and the network, what is not known, what is wrong."""

from collections.abc import Mapping
from operator import attrgetter

import numpy as np

from vasowave.base.io.columns import split_unit
from vasowave.pulse.quantities import question_of
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.effects import grouped
from vasowave.study.cohort.primary import Family, Primary
from vasowave.study.cohort.table import column, rows_of
from vasowave.study.figures.forest import NARROW, WIDE, forest_figure
from vasowave.study.figures.matplotlib_style import group_looks, short, source_looks
from vasowave.study.figures.overview import impedances_figure, tree_figure, waveforms_figure
from vasowave.study.report.answer.animal import animal_answers
from vasowave.study.report.answer.attribution import attribution_answer, attribution_summary
from vasowave.study.report.answer.changes import change_table
from vasowave.study.report.answer.comparison import groups_figure
from vasowave.study.report.answer.design import design_answer
from vasowave.study.report.answer.effects import Called
from vasowave.study.report.answer.forest import animal_rows
from vasowave.study.report.answer.groups import (
    HOW_SURE,
    RESTS_ON,
    THE_ANSWER,
    doubts_text,
    group_answer,
    not_told,
    sensitivity,
    tested,
)
from vasowave.study.report.answer.limits import basis, model_limits, shared_images
from vasowave.study.report.answer.marks import Marks
from vasowave.study.report.answer.problem_list import overstrained, problem_blocks
from vasowave.study.report.answer.walls import wall_answer
from vasowave.study.report.blocks import Answers, Block, Bullets, Drawing, Section, SideBySide
from vasowave.study.report.sections.data import animals_table, wedge_pressures
from vasowave.study.report.terms import caller, defined
from vasowave.study.report.wording import UNLIMITED, listed, nearest, number, undecided, unlimited

_NEAR = "≈: other draws may put this p on the other side of 0.05."
BASES = {RESTS_ON, HOW_SURE}
"""What is read after the results, below their figure."""
UNLIKE = 0.15
"""Share of the measured decay by which R_T C_T may differ before the page says that the two are not the same."""


def answer_sections(cohort: Cohort, primary: Primary, family: Family) -> list[Section]:
    """Return the sections of the one result."""
    written, called = defined(cohort), caller(cohort)
    forest = _forest(cohort, primary, family, called)
    answers = _answers(cohort, primary, family, written, called)
    lead = [Answers(answers[:1])] if answers[0][0] == THE_ANSWER else []
    results = [item for item in answers[len(lead) :] if item[0] not in BASES]
    bases = [item for item in answers if item[0] in BASES]
    answer_and_forest = SideBySide([Answers(results)], [*forest, *([Answers(bases)] if bases else [])])
    waves, network = _pictures(cohort, primary.law)
    return [
        Section(
            "answer",
            "The answer",
            [*lead, *change_table(primary, called), answer_and_forest, *attribution_summary(cohort)],
        ),
        Section("animals", "What was measured", [*animals_table(cohort), SideBySide(waves, network)]),
        Section("open", "What is not known", _open(cohort, primary, written, called)),
    ]


def _answers(
    cohort: Cohort, primary: Primary, family: Family, written: Mapping[str, str], called: Called
) -> list[tuple[str, str]]:
    wall = [wall_answer(cohort, primary.law)] if primary.law else []
    marks = Marks(cohort, primary.law)
    if cohort.single:
        answers = animal_answers(cohort.results[0], primary.law, family, called, marks)
        return [*_with_decay(answers, cohort, primary.law, family), *marks.legend(answers, written), *wall]
    design = design_answer(cohort)
    if len(cohort.groups) < 2 and not design:
        return [("Groups", "There is one group; nothing is compared between groups."), *wall]
    answer = group_answer(primary, called, marks.of_effect)
    answer = answer._replace(questions=_with_decay(answer.questions, cohort, primary.law, family))
    first, *answers = answer.items(basis(cohort, primary, called), doubts_text(cohort, primary)) or [
        (THE_ANSWER, "Nothing could be compared.")
    ]
    without, count = len(cohort.results) - len(wedge_pressures(cohort)), len(cohort.results)
    if without and any(effect.quantity in ("PVR", "R_T", "tau") for effect in primary.effects):
        whose = "" if without == count else f" of {without} of {count} recordings"
        first = first[0], f"{first[1]} Vascular resistance{whose} is over an assumed outflow pressure of 0 mmHg."
    return [
        first,
        *design,
        *attribution_answer(cohort, tested(primary.effects)),
        *answers,
        *marks.legend(answers, written),
        *_not_compared(primary, called),
        *wall,
    ]


def _with_decay(answers: list[tuple[str, str]], cohort: Cohort, law: str, family: Family) -> list[tuple[str, str]]:
    """Return the answers with the measured decay beside the model's time constant."""
    decay_text = decay(cohort, law) if law and "tau" in family.quantities else ""
    question = question_of("tau")
    return [(title, f"{text} {decay_text}" if decay_text and title == question else text) for title, text in answers]


def _not_compared(primary: Primary, called: Called) -> list[tuple[str, str]]:
    clauses = not_told(primary, called)
    for reason, omissions in grouped(primary.left_out, attrgetter("reason")).items():
        clauses.append(f"{', '.join(short(omission.describe(called), 60) for omission in omissions)}: {reason}")
    return [("Left out", f"{'; '.join(clauses)}.")] if clauses else []


def _forest(cohort: Cohort, primary: Primary, family: Family, called: Called) -> list[Block]:
    if cohort.single:
        marks = Marks(cohort, primary.law)
        rows = animal_rows(cohort.results[0], primary.law, family, called, marks) if primary.law else []
        if not rows:
            return []
        looks, sources = group_looks(cohort.groups), source_looks([*cohort.sources, "data"])
        axis, columns = f"relative to the {primary.law} wall [1]", ("value [95 %]", "")
        wide, narrow = (forest_figure(rows, looks, sources, axis, columns, form) for form in (WIDE, NARROW))
        drawn = cohort.results[0].laws[primary.law].posterior is not None
        whose = f"Posterior medians under the {primary.law} wall" if drawn else f"The {primary.law} wall's values"
        caption = (
            f"{whose} with their 95 % intervals (diamonds), and on the same scale those of "
            "other walls and (data) what the recording alone says by a closed formula, where fits begin. Where it "
            "differs, believe the fit, which follows the whole waveform; the decay's τ and R_T C_T are two numbers."
        )
    elif primary.effects:
        wide, narrow = (groups_figure(cohort, primary, form) for form in (WIDE, NARROW))
        any_undecided = any(undecided(effect.p) for effect in primary.effects)
        caption = _ratios_caption(cohort, primary) + (f" {_NEAR}" if any_undecided else "")
    else:
        return []
    return [Drawing("Forest", caption, wide, narrow)]


def _ratios_caption(cohort: Cohort, primary: Primary) -> str:
    reference = short(cohort.reference, 40)
    model = f"; of the model by the {primary.law} wall" if primary.law else ""
    walls = "the other walls (grey) and " if len(cohort.walls) > 1 else ""
    if not cohort.design.plain:
        return (
            f"Ratios by the model of the design (diamonds{model}). 95 % intervals and p are corrected for testing "
            f"{tested(primary.effects)} rows. {_below(cohort, primary, reference)}"
        ).strip()
    open_ended = any(unlimited(effect.low, effect.high) for effect in primary.effects)
    images = (
        " Errors that animals share, of their image above all, widen intervals and p of the model: dots of two groups "
        "may lie apart and their effect be undecided."
    )
    return (
        f"Ratio to {reference} of geometric means (diamonds{model}); animals with smaller errors count more. 95 % "
        f"intervals and p are corrected for testing {tested(primary.effects)} rows. Below stand {walls}every animal "
        f"over the mean of {reference}."
        + (images if model and shared_images(cohort) else "")
        + (f" {UNLIMITED}: the data say nothing of that ratio." if open_ended else "")
    )


def _below(cohort: Cohort, primary: Primary, reference: str) -> str:
    """Say what stands below the effects of a design: other laws, which are adjusted as it is, and animals."""
    kinds, again = {effect.contrast.kind for effect in primary.effects}, short(cohort.design.occasion or "", 40)
    several = " (of several recordings their mean)" if cohort.repeated else ""
    clauses = (
        [f"where groups are compared every animal over the mean of {reference}{several}"] if "groups" in kinds else []
    )
    if again and "factor" in kinds:
        clauses.append(f"for {again} every animal's own ratio")
    if again and "interaction" in kinds:
        clauses.append(f"where groups differ in it that ratio over its mean in {reference}")
    animals = [f"{listed(clauses)} (not adjusted)"] if clauses else []
    walls = ["the other walls (grey)"] if len(cohort.walls) > 1 else []
    return f"Below stand {'; '.join([*walls, *animals])}." if clauses or walls else ""


def _pictures(cohort: Cohort, law: str) -> tuple[list[Block], list[Block]]:
    scatter = "; grey: SD of the beats" if "pressure_sd" in cohort.results[0].recording else ""
    by_pressure = law and cohort.law(law).compared == "flow"
    entered = " The measured pressure enters the model; the fit is to the flow." if by_pressure else ""
    single = f"Measured (black) and fitted pressure and flow at the inlet{scatter}.{entered}"
    panels = f", one panel for each {cohort.second.name}" if cohort.crossed and cohort.second else ""
    group_caption = (
        f"Measured pressure and flow of every {'recording' if cohort.repeated else 'animal'} from the foot of the "
        f"pressure{panels}; thick: mean, band: SD of the group."
    )
    caption = single if cohort.single else group_caption
    waves: list[Block] = [Drawing("Measured", caption, waveforms_figure(cohort))]
    if not cohort.single:
        means = (
            "Measured impedance: mean (of the modulus the geometric one) and SD (band) of each group's animals at each "
            "harmonic whose flow is above its noise in all of them, over its mean frequency."
        ) + (f" Drawn are the recordings at {cohort.shown_at}." if cohort.shown_at else "")
        waves.append(Drawing("Impedance", means, impedances_figure(cohort)))
    if not law:
        return waves, []
    owner = "" if cohort.single else f" of {nearest(cohort)}"
    text = (
        f"The network{owner}: width is the radius, color how far the mean pressure falls from the inlet in the model."
    )
    text += " Lengths are not to scale."
    shown = any(law in result.laws for result in cohort.shown.values())
    return waves, [Drawing("Pressures", text, tree_figure(cohort, law))] if shown else []


def _open(cohort: Cohort, primary: Primary, written: Mapping[str, str], called: Called) -> list[Block]:
    statements = model_limits(cohort, primary.law, written)
    statements += overstrained(cohort, [wall for wall in cohort.walls if wall != primary.law])
    statements += sensitivity(primary, called)
    blocks: list[Block] = [Bullets(statements)] if statements else []
    return [SideBySide(blocks, problem_blocks(cohort, primary))]


def decay(cohort: Cohort, law: str) -> str:
    """Say what the measured decay is (of groups: geometric means), and where R_T C_T is far from it."""
    measured, modeled = (_means(cohort, source, "tau") for source in ("measured", law))
    groups = [group for group in modeled if group in measured]
    if not groups:
        return ""

    def place(cell: str) -> str:
        group, level, _ = cohort.cells[cell]
        return "" if cohort.single else f" in {short(group, 40)}{f' ({short(level, 40)})' if level else ''}"

    def times(values: Mapping[str, float]) -> str:
        return listed([f"{number(values[group])} s{place(group)}" for group in groups if group in values])

    text = f"The measured pressure falls in diastole with τ = {times(measured)}."
    if not any(abs(modeled[group] / measured[group] - 1) > UNLIKE for group in groups):
        return text
    return f"{text} The model's R_T C_T is not the time of this decay."


def _means(cohort: Cohort, source: str, name: str) -> Mapping[str, float]:
    """Return the geometric mean of a time constant in every group (at every occasion or level) that has it."""
    rows = rows_of(cohort.described, source)
    if name not in {split_unit(str(label))[0] for label in rows.columns}:
        return {}
    logs = rows[column(rows, name)].astype(float).map(np.log).groupby(rows["group"], sort=False).mean().dropna()
    return {str(group): float(np.exp(logs[group])) for group in cohort.cells if group in logs.index}
