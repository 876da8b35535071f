"""The first page: answers beside the forest plot, the waveforms and the network, what is not known, what is wrong."""

from collections.abc import Mapping

import numpy as np

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.primary import Family, Primary
from vasowave.cohort.table import column, rows_of
from vasowave.figures.forest import NARROW, WIDE, forest_figure
from vasowave.figures.overview import tree_figure, waveforms_figure
from vasowave.figures.style import group_looks, short, source_looks
from vasowave.io.columns import split_unit
from vasowave.quantities import question_of
from vasowave.report.answer.animal import animal_answers
from vasowave.report.answer.comparison import groups_figure
from vasowave.report.answer.forest import animal_rows
from vasowave.report.answer.groups import Called, design_answer, group_answers, influence, not_told, other_laws
from vasowave.report.answer.limits import model_limits, no_wedge, one_geometry
from vasowave.report.answer.problems import marked, marker, overstrained, problem_blocks
from vasowave.report.answer.walls import wall_answer
from vasowave.report.blocks import Answers, Block, Bullets, Columns, Drawing, Section
from vasowave.report.glossary import caller
from vasowave.report.tables.cells import nearest, symbols
from vasowave.report.wording import UNLIMITED, listed, number, undecided, unlimited

_NEAR = "≈: other draws may put this p on the other side of 0.05."
UNLIKE = 0.15
"""Share of the measured decay by which R_T C_T may differ before the page says that the two are not the same."""


def answer_sections(cohort: Cohort, primary: Primary, family: Family) -> list[Section]:
    """Return the sections of the one result."""
    written, called = symbols(cohort), caller(cohort)
    forest = _forest(cohort, primary, family, called)
    return [
        Section("answer", "The answer", [Columns([Answers(_answers(cohort, primary, family, called))], forest)]),
        Section("animals", "What was measured", [Columns(*_pictures(cohort, primary.law))]),
        Section("open", "What is not known", _open(cohort, primary, written, called)),
    ]


def _answers(cohort: Cohort, primary: Primary, family: Family, called: Called) -> list[tuple[str, str]]:
    wall = [wall_answer(cohort, primary.law)] if primary.law else []
    legend, mark = marked(cohort, primary.law), marker(cohort, primary.law)
    if cohort.single:
        one = cohort.results[0]
        said = animal_answers(one, primary.law, family, called, mark([one.group]))
        return [*_with_decay(said, cohort, primary.law, family), *legend, *wall]
    design = design_answer(cohort)
    if len(cohort.groups) < 2 and not design:
        return [("Groups", "There is one group; nothing is compared between groups."), *wall]
    said = _with_decay(group_answers(primary, called, mark), cohort, primary.law, family)
    return [*design, *said, *legend, *_not_compared(primary, called), *wall]


def _with_decay(said: list[tuple[str, str]], cohort: Cohort, law: str, family: Family) -> list[tuple[str, str]]:
    """Return the answers with the measured decay beside the model's time constant."""
    beside = decay(cohort, law) if law and "tau" in family.quantities else ""
    question = question_of("tau")
    return [(one, f"{text} {beside}" if beside and one == question else text) for one, text in said]


def _not_compared(primary: Primary, called: Called) -> list[tuple[str, str]]:
    reasons: dict[str, list[str]] = {}
    for what, why in primary.left_out.items():
        reasons.setdefault(why, []).append(short(called(what), 60))
    said = [*not_told(primary, called), *(f"{', '.join(names)}: {why}" for why, names in reasons.items())]
    return [("Not compared", f"{'; '.join(said)}.")] if said else []


def _forest(cohort: Cohort, primary: Primary, family: Family, called: Called) -> list[Block]:
    if cohort.single:
        rows = animal_rows(cohort.results[0], primary.law, family, called) if primary.law else []
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
    elif len(primary.rows):
        wide, narrow = (groups_figure(cohort, primary, form) for form in (WIDE, NARROW))
        near = primary.rows["p"].map(undecided).any()
        caption = _ratios_caption(cohort, primary) + (f" {_NEAR}" if near else "")
    else:
        return []
    return [Drawing("Forest", caption, wide, narrow)]


def _ratios_caption(cohort: Cohort, primary: Primary) -> str:
    reference = short(cohort.reference, 40)
    model = f"; of the model by the {primary.law} wall" if primary.law else ""
    walls = "the other walls (grey) and " if len(cohort.walls) > 1 else ""
    if not cohort.design.plain:
        return (
            f"Ratios by the model of the design (diamonds{model}). 95 % intervals and p hold for all "
            f"{len(primary.rows)} rows together. {_below(cohort, primary, reference)}"
        ).strip()
    open_ended = any(unlimited(low, high) for low, high in primary.rows[["low", "high"]].to_numpy(float))
    return (
        f"Ratio to {reference} (diamonds{model}), animals weighted by how well each is known; the answers' numbers of "
        f"groups are geometric means. 95 % intervals and p hold for all {len(primary.rows)} rows together. Below stand "
        f"{walls}every animal over the mean of {reference}."
        + (f" {UNLIMITED}: the data say nothing of that ratio." if open_ended else "")
    )


def _below(cohort: Cohort, primary: Primary, reference: str) -> str:
    """Say what stands below the effects of a design: other laws, which are adjusted as it is, and animals."""
    what, again = set(primary.rows["what"]), short(cohort.design.occasion or "", 40)
    several = " (of several recordings their mean)" if cohort.repeated else ""
    said = [f"where groups are compared every animal over the mean of {reference}{several}"] if "groups" in what else []
    if again and "factor" in what:
        said.append(f"for {again} every animal's own ratio")
    if again and "interaction" in what:
        said.append(f"where groups differ in it that ratio over its mean in {reference}")
    animals = [f"{listed(said)} (not adjusted)"] if said else []
    beside = ["the other walls (grey)"] if len(cohort.walls) > 1 else []
    return f"Below stand {'; '.join([*beside, *animals])}." if said or beside else ""


def _pictures(cohort: Cohort, law: str) -> tuple[list[Block], list[Block]]:
    scatter = "; grey: SD of the beats" if "pressure_sd" in cohort.results[0].recording else ""
    single = f"Measured (black) and fitted pressure and flow at the inlet{scatter}.{_entered(cohort, law)}"
    apart = f", one panel for each {cohort.second.name}" if cohort.crossed and cohort.second else ""
    every = (
        f"Measured pressure and flow of every {'recording' if cohort.repeated else 'animal'} from the foot of the "
        f"pressure{apart}; thick: mean, band: SD of the group."
    )
    caption = single if cohort.single else every
    waves: list[Block] = [Drawing("Measured", caption, waveforms_figure(cohort))]
    if not law:
        return waves, []
    who = "" if cohort.single else f" of {nearest(cohort)}"
    text = f"The network{who}: width is the radius, color how far the mean pressure falls from the inlet in the model."
    text += " Lengths are not to scale."
    shown = any(law in result.laws for result in cohort.shown.values())
    return waves, [Drawing("Pressures", text, tree_figure(cohort, law))] if shown else []


def _entered(cohort: Cohort, law: str) -> str:
    by_pressure = law and cohort.law(law).compared == "flow"
    return " The measured pressure enters the model; the fit is to the flow." if by_pressure else ""


def _open(cohort: Cohort, primary: Primary, written: Mapping[str, str], called: Called) -> list[Block]:
    known = [*one_geometry(cohort, primary), *no_wedge(cohort), *model_limits(cohort, primary.law, written)]
    known += overstrained(cohort, [wall for wall in cohort.walls if wall != primary.law])
    if len(primary.rows):
        known += [*influence(primary, called), *other_laws(primary, called)]
    left: list[Block] = [Bullets(known)] if known else []
    return [Columns(left, problem_blocks(cohort, primary))]


def decay(cohort: Cohort, law: str) -> str:
    """Say what the measured decay is (of groups: geometric means), and where R_T C_T is far from it."""
    measured, modeled = (_means(cohort, source, "tau") for source in ("measured", law))
    summed = _means(cohort, law, "tau_plain")
    both = [group for group in modeled if group in measured]
    if not both:
        return ""

    def of(cell: str) -> str:
        group, level, _ = cohort.cells[cell]
        return "" if cohort.single else f" in {short(group, 40)}{f' ({short(level, 40)})' if level else ''}"

    values = listed([f"{number(measured[group])} s{of(group)}" for group in both])
    said = f"The measured diastolic decay has τ = {values}."
    times = {group: modeled[group] / measured[group] for group in both}
    far = [f"{number(one, 2)} times it{of(group)}" for group, one in times.items() if abs(one - 1) > UNLIKE]
    if not far:
        return said
    plain = [f"{number(summed[group])} s{of(group)}" for group in both if group in summed]
    also = f" With the compliances of all vessels summed it is {listed(plain)}." if plain else ""
    return (
        f"{said} R_T C_T is {listed(far)}: it holds the beds' resistance and C_v by the paper's series/parallel rule, "
        f"and says nothing of how fast the pressure decays.{also}"
    )


def _means(cohort: Cohort, source: str, name: str) -> Mapping[str, float]:
    """Return the geometric mean of a time constant in every group (at every occasion or level) that has it."""
    rows = rows_of(cohort.described, source)
    if name not in {split_unit(str(label))[0] for label in rows.columns}:
        return {}
    logs = rows[column(rows, name)].astype(float).map(np.log).groupby(rows["group"], sort=False).mean().dropna()
    return {str(group): float(np.exp(logs[group])) for group in cohort.cells if group in logs.index}
