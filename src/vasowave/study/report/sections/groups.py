"""The groups compared."""

from collections.abc import Mapping

import pandas as pd

from vasowave.pulse.quantities import COMPARED, INDICES
from vasowave.study.cohort.attribution import attribution_table
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.comparison import SourceComparison, importance
from vasowave.study.cohort.primary import Primary
from vasowave.study.figures.compared import importance_figure, ratios_figure
from vasowave.study.report.answer.problem_list import missing_text
from vasowave.study.report.blocks import Block, Drawing, Fold, Heading, Paragraph, Remarks, Section, Table
from vasowave.study.report.tables import groups as tables
from vasowave.study.report.tables.cells import source_title
from vasowave.study.report.tables.groups import covariates_table, primary_tables
from vasowave.study.report.wording import column_label, listed, name_and_unit, number

_SHARES_NOTE = (
    "Each component of the fitted model is exchanged between two states (occasions, or animals of two groups), in "
    "every order; its column is the mean of what that does, in the unit of the row. Heart: flow and rate; geometry: "
    "the image."
)


def groups_section(
    cohort: Cohort, primary: Primary, comparisons: Mapping[str, SourceComparison], written: dict[str, str]
) -> Section:
    """The primary comparison; what is secondary folded away; all quantities described."""
    blocks: list[Block] = []
    if primary.effects:
        first, *further_tables = primary_tables(primary, written)
        missing = [missing_text(group_missing, primary.law, cohort.repeated) for group_missing in primary.missing]
        blocks += [Heading("Primary comparison"), first, *_remarks(primary)]
        blocks += [Remarks("Missing animals", missing)] if missing else []
        blocks += [Fold("Secondary: the same effects by the other wall laws", further_tables)] if further_tables else []
        if primary.adjusted:
            blocks.append(Fold("Secondary: effects of the covariates", [covariates_table(primary, written)]))
    if len(shares := attribution_table(cohort.changes)):
        table = Table.from_frame("Attribution", "What made each change or difference", shares, _SHARES_NOTE)
        blocks.append(Fold("What made the change", [table]))
    if cohort.repeated:
        blocks.append(Paragraph(
            "The paper's tests and importance indices are not made: they take every recording for an animal of its own."
        ))  # fmt: skip
    elif len(cohort.groups) > 1:
        blocks.append(Fold("Secondary: importance indices of the paper", [_importance(cohort, written)]))
        blocks += _secondary(comparisons, written)
    else:
        blocks.append(Paragraph("There is one group; importance indices and tests need two."))
    blocks.append(Fold("Every quantity of every source", [tables.groups(cohort)]))
    return Section("groups", "Groups", blocks)


def _remarks(primary: Primary) -> list[Block]:
    """Say where p and intervals of the primary comparison cannot be relied on."""
    sure = primary.assurance
    if sure is None or not sure.doubtful:
        return []
    text = (
        f"The groups differ in spread by up to a factor of {number(sure.spread_ratio, 2)}, and the smallest has "
        f"{sure.smallest} animals: cohorts like this one without any effect have a row with p < 0.05 in "
        f"{100 * sure.rate:.0f} % of cases instead of 5 %."
    )
    return [Remarks("p of the primary comparison", [text])]


def _secondary(comparisons: Mapping[str, SourceComparison], written: dict[str, str]) -> list[Block]:
    """Return the paper's comparison, each source by itself, folded away."""
    return [
        Fold(f"Secondary: the paper's comparison, {source_title(source)}", blocks)
        for source, comparison in comparisons.items()
        if (blocks := _compared(comparison, source, written))
    ]


def _importance(cohort: Cohort, written: Mapping[str, str]) -> Drawing:
    measured = importance(cohort, "measured", {name: name for name in INDICES})
    called = {name: written.get(name, name) for name in COMPARED}
    stiffness = {wall: cohort.law(wall).stiffness for wall in cohort.walls}
    modeled = [importance(cohort, wall, {stiffness[wall]: "stiffness"} | called) for wall in cohort.walls]
    stiffness_text = listed([f"{written.get(name, name)} of the {wall} wall" for wall, name in stiffness.items()])
    caption = (
        "Importance index η (eq. 20) of the measured indices and of the models' quantities, relative to "
        f"{cohort.reference}: 1 is an increase by 100 %, -1 a fall to zero. Bars: 95 % intervals, each by itself "
        "(Fieller's, Welch's degrees of freedom)."
        + (f" Stiffness: {stiffness_text}; walls differ by hollow and full points." if stiffness_text else "")
    )
    drawn = importance_figure(cohort, measured, pd.concat(modeled) if modeled else pd.DataFrame())
    return Drawing("ParAll_change", caption, drawn)


def _compared(comparison: SourceComparison, source: str, written: dict[str, str]) -> list[Block]:
    blocks: list[Block] = []
    contrasts = comparison.contrasts
    if len(contrasts):
        blocks += [tables.contrasts(comparison, source, written)]
        if len(contrasts[["reference", "other"]].drop_duplicates()) == 1:
            names = [name_and_unit(label)[0] for label in contrasts["quantity"]]
            drawn = ratios_figure(contrasts.assign(quantity=[written.get(name, name) for name in names]))
            caption = "Ratio of geometric means with its 95 % interval (Welch, on logarithms)."
            blocks.append(Drawing(f"Ratios-{source}", caption, drawn))
    if len(comparison.without_one):
        blocks.append(Fold("One animal left out", [tables.without_one(comparison, source, written)]))
    if comparison.left_out:
        reasons = [f"{column_label(quantity)}: {reason}" for quantity, reason in comparison.left_out.items()]
        blocks.append(Remarks(f"Not compared ({source})", reasons))
    return blocks
