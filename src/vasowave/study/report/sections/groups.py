"""The groups compared: the primary comparison, the paper's, and every quantity, with their tables."""

from collections.abc import Callable, Mapping

import numpy as np
import pandas as pd

from vasowave.pulse.quantities import COMPARED, INDICES
from vasowave.study.cohort.attribution import attribution_table
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.comparison import SourceComparison, importance
from vasowave.study.cohort.effects import (
    ContrastEstimate,
    CovariateEffect,
    DesignEffect,
    Effect,
    RatioEstimate,
    Untested,
    as_table,
)
from vasowave.study.cohort.primary import Primary
from vasowave.study.cohort.table import described
from vasowave.study.cohort.two_groups import MAX_EXACT_ANIMALS
from vasowave.study.figures.compared import importance_figure, ratios_figure
from vasowave.study.report.answer.problem_list import missing_text
from vasowave.study.report.blocks import Block, Drawing, Fold, Heading, Paragraph, Remarks, Section, Table
from vasowave.study.report.wording import (
    column_label,
    interval,
    listed,
    mean_sd,
    median_iqr,
    name_and_unit,
    number,
    p_value,
    ratio_with_interval,
    source_title,
    span,
    symbols,
    undecided,
    with_unit,
)

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
        blocks += [
            Fold(f"Secondary: the paper's comparison, {source_title(source)}", of_source)
            for source, comparison in comparisons.items()
            if (of_source := _compared(comparison, source, written))
        ]
    else:
        blocks.append(Paragraph("There is one group; importance indices and tests need two."))
    blocks.append(Fold("Every quantity of every source", [groups(cohort)]))
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
    table = comparison.contrasts
    if len(table):
        blocks += [contrasts(comparison, source, written)]
        if len(table[["reference", "other"]].drop_duplicates()) == 1:
            names = [name_and_unit(label)[0] for label in table["quantity"]]
            drawn = ratios_figure(table.assign(quantity=[written.get(name, name) for name in names]))
            caption = "Ratio of geometric means with its 95 % interval (Welch, on logarithms)."
            blocks.append(Drawing(f"Ratios-{source}", caption, drawn))
    if len(comparison.without_one):
        blocks.append(Fold("One animal left out", [without_one(comparison, source, written)]))
    if comparison.left_out:
        reasons = [f"{column_label(quantity)}: {reason}" for quantity, reason in comparison.left_out.items()]
        blocks.append(Remarks(f"Not compared ({source})", reasons))
    return blocks


_MANY = 10  # degrees of freedom whose decimals say nothing
_NOTE = (
    "IQR: from the first to the third quartile. A symbol means what its source can know: measured β, c and τ "
    "follow from the up-slope (at zero pressure) and from the diastolic decay, measured R_T is mean pressure "
    "(above the wedge's) over mean flow; those of a wall law are its calibrated stiffness, the wave speed at mean "
    "pressure, R_T of the vascular beds alone."
)


def primary_tables(primary: Primary, written: Mapping[str, str]) -> list[Table]:
    """Return the primary comparison, and the effects that other laws give."""
    effects = primary.effects
    columns: dict[str, Callable[[Effect], str]] = {
        "quantity": lambda effect: written.get(effect.quantity, effect.quantity),
        "source": lambda effect: effect.source + (", posteriors" if effect.origin == "posterior" else ""),
        "groups": lambda effect: str(effect.contrast),
        "animals": _animals,
        "ratio [95 %, all rows]": _ratio,
        "SE of its log": lambda effect: number(effect.standard_error, 2),
        "df": _degrees,
        "p, all rows": lambda e: "none: one image" if e.untested is Untested.ONE_IMAGE else p_value(e.p),
        "smallest p by ranks": lambda effect: number(effect.smallest_p, 2),
        "groups apart": lambda effect: "yes" if effect.apart else "no",
        "ratio without one animal": lambda e: f"{number(e.ratio_without)} ({e.without})" if e.without else "–",
    }
    designed = isinstance(effects[0], DesignEffect)
    tested = sum(not np.isnan(effect.p) for effect in effects)
    if designed:
        note = (
            "Ratio: of means on logarithms by one mixed model for each quantity, the animals' known errors in it "
            "(restricted maximum likelihood, Kenward and Roger's standard errors and degrees of freedom); of an "
            f"interaction a ratio of ratios. Interval and p: for all {tested} tested rows together, from one "
            "distribution, so that an interval excludes 1 exactly if p < 0.05; logarithms are taken as normal. "
            "Without: the one animal, with all its recordings, that moves the ratio most when it is left out."
        )
    else:
        note = _note(tested)
    note += " SE: of the ratio's natural logarithm; df: its degrees of freedom."
    if any(undecided(effect.p) for effect in effects):
        note += " ≈: other draws may put this p on the other side of 0.05."
    if primary.assurance:
        note += (
            f" Of cohorts without any effect, of these sizes, spreads and correlations, "
            f"{100 * primary.assurance.rate:.1f} % have a row with p < 0.05; it should be 5 %."
        )
    if any(effect.untested is Untested.ONE_IMAGE for effect in effects):
        note += (
            " No p: animals of a group have one image, and the interval is without its error; it holds in 95 % by "
            "itself. Posteriors contain it."
        )
    if any(effect.origin == "posterior" for effect in effects):
        note += (
            " From posteriors: values and errors of the animals are the means and SD of the logarithms of their draws, "
            "and the error of an image that several animals have is not averaged away."
        )
    caption = "Primary comparison, of the family that the settings name"
    table = Table.from_items("Primary", caption, effects, columns, note, primary.table())
    if designed:
        table = table.hiding("smallest p by ranks", "groups apart")
    return [table, _other_laws(primary, written)] if len(primary.others) else [table]


def covariates_table(primary: Primary, written: Mapping[str, str]) -> Table:
    """Return what the covariates of a design do."""
    columns: dict[str, Callable[[CovariateEffect], str]] = {
        "quantity": lambda effect: written.get(effect.quantity, effect.quantity),
        "source": lambda effect: effect.source,
        "covariate": lambda effect: effect.covariate,
        "ratio [95 %]": _ratio,
    }
    note = (
        "By the models of the primary comparison, from which groups are adjusted: of categories the means of animals "
        "of one level over those of the first, of numbers the ratio for one standard deviation. Each interval by "
        "itself, without a test."
    )
    data = as_table(primary.adjusted)
    return Table.from_items("Covariates", "Effects of the covariates", primary.adjusted, columns, note, data)


def _note(count: int) -> str:
    return (
        "Ratio: of the groups' means on logarithms, each animal weighted by its error and by what the animals of its "
        "group differ (random effects, restricted maximum likelihood; standard errors after Hartung and Knapp, without "
        f"known errors Welch's). Interval and p: for all {count} tested rows together, from one distribution, "
        "so that an interval excludes 1 exactly if p < 0.05; logarithms are taken as normal. Smallest p: of any test "
        "by ranks or relabelings, which asks for no distribution. Apart: no animal of one group lies among the other. "
        "Without: the one animal that moves the ratio most when it is left out."
    )


def _animals(effect: Effect) -> str:
    """Return how many animals each side has, once where all of them are on both."""
    n_both = effect.n_both if isinstance(effect, DesignEffect) else 0
    if n_both and effect.n_group == effect.n_reference == n_both:
        return f"{n_both}, each at both"
    return f"{effect.n_group}, {effect.n_reference}" + (f" ({n_both} at both)" if n_both else "")


def _ratio(estimate: RatioEstimate) -> str:
    return ratio_with_interval(estimate.ratio, estimate.low, estimate.high)


def _degrees(effect: Effect) -> str:
    freedom = effect.freedom
    return number(freedom, 2) if freedom < _MANY else f"{freedom:.0f}" if np.isfinite(freedom) else "∞"


def _other_laws(primary: Primary, written: Mapping[str, str]) -> Table:
    columns: dict[str, Callable[[ContrastEstimate], str]] = {
        "quantity": lambda estimate: written.get(estimate.quantity, estimate.quantity),
        "wall": lambda estimate: estimate.source,
        "groups": lambda estimate: str(estimate.contrast),
        "ratio [95 %]": _ratio,
    }
    note = "Secondary: the same effects, their intervals to the same level, without a test."
    data, caption = as_table(primary.others), "Ratios by the other wall laws"
    return Table.from_items("PrimaryOtherLaws", caption, primary.others, columns, note, data)


def groups(cohort: Cohort) -> Table:
    """Every single number of every source, described by group; by group and level, one below the other, if crossed."""
    data = pd.concat([described(cohort.described, source) for source in cohort.table["source"].unique()])
    if cohort.crossed:
        return _cells(cohort, data)
    header = (
        "source",
        "quantity",
        *(f"{group}: {statistic}" for group in cohort.groups for statistic in ("mean ± SD", "median [IQR]")),
    )
    written, cells = symbols(cohort), []
    for (source, label), quantity_rows in data.groupby(["source", "quantity"], sort=False):
        by_group = {str(row["group"]): row for _, row in quantity_rows.iterrows()}
        texts = [
            text
            for group in cohort.groups
            for text in ((mean_sd(by_group[group]), median_iqr(by_group[group])) if group in by_group else ("–", "–"))
        ]
        cells.append((str(source), with_unit(label, _of_source(written, source)), *texts))
    return Table("Groups", "All quantities by group", header, cells, _NOTE, data)


def _cells(cohort: Cohort, data: pd.DataFrame) -> Table:
    """Return the same as one row for each cell of groups and levels, which would be too many columns."""
    written, again = symbols(cohort), cohort.second.name if cohort.second else ""
    columns: dict[str, Callable[[pd.Series], str]] = {
        "source": lambda row: str(row["source"]),
        "quantity": lambda row: with_unit(row["quantity"], _of_source(written, row["source"])),
        f"group, {again}": lambda row: str(row["group"]),
        "n": lambda row: str(row["n"]),
        "mean ± SD": mean_sd,
        "median [IQR]": median_iqr,
    }
    note = f"n: recordings. {_NOTE}"
    rows = (row for _, row in data.iterrows())
    return Table.from_items("Groups", f"All quantities by group and {again}", rows, columns, note, data)


def _of_source(written: Mapping[str, str], source: object) -> dict[str, str]:
    """Return the symbols of one source: the time constant of a measured decay is no R_T C_T."""
    return {**written, "tau": "τ"} if source == "measured" else {**written}


def contrasts(comparison: SourceComparison, source: str, written: dict[str, str]) -> Table:
    """The comparison of the groups by one source of numbers."""
    data = comparison.contrasts
    several = data[["reference", "other"]].drop_duplicates().shape[0] > 1
    pair = data.iloc[0]
    header = ("quantity", *(("groups",) if several else ()), "η", "ratio [95 %]", "Hedges g [95 %]", "p", "p Holm")
    cells = []
    for _, row in data.iterrows():
        between = (f"{row['other']} / {row['reference']}",) if several else ()
        intervals = (
            interval(row, "ratio", "ratio low", "ratio high"), interval(row, "Hedges g", "g low", "g high"),
        )  # fmt: skip
        cells.append((with_unit(row["quantity"], written), *between, number(row["eta"], 2), *intervals,
                      number(row["p"], 2), number(row["p Holm"], 2)))  # fmt: skip
    subject = "every pair of groups" if several else f"{pair['other']} against {pair['reference']}"
    note = (
        "η: relative change of the mean (eq. 20), never below -1 for a positive quantity; ratio: of geometric means, "
        f"Welch interval; p: Mann-Whitney test, exact up to {MAX_EXACT_ANIMALS} animals; "
        f"Holm over these {len(data)} tests."
    )
    return Table(f"Contrasts-{source}", f"{source_title(source)}: {subject}", header, cells, note, data)


def without_one(comparison: SourceComparison, source: str, written: dict[str, str]) -> Table:
    """The shifts of the ratios when any one animal is left out."""
    data, cells = comparison.without_one, []
    for (reference, group, label), quantity_rows in data.groupby(["reference", "other", "quantity"], sort=False):
        farthest = quantity_rows.loc[np.log(quantity_rows["ratio shift"]).abs().idxmax()]
        cells.append((f"{group} / {reference}", with_unit(label, written), span(quantity_rows["ratio"].to_numpy()),
                      str(farthest["left out"]), number(farthest["ratio shift"], 3)))  # fmt: skip
    header = ("groups", "quantity", "ratio", "moved most without", "by a factor of")
    note = "Smallest and largest ratio over all ways of leaving one animal out, and the animal that moves it most."
    return Table(f"LeaveOneOut-{source}", f"{source_title(source)}, one animal left out", header, cells, note, data)
