"""Tables that describe and compare the groups: the primary comparison, the paper's, and every quantity."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.comparison import SourceComparison
from vasowave.study.cohort.effects import DesignEffect, Effect, RatioEstimate, Untested, as_table
from vasowave.study.cohort.primary import Primary
from vasowave.study.cohort.table import described
from vasowave.study.cohort.two_groups import MAX_EXACT_ANIMALS
from vasowave.study.report.blocks import Table
from vasowave.study.report.tables.cells import interval, mean_sd, median_iqr, source_title, span, symbols, with_unit
from vasowave.study.report.wording import number, p_value, ratio_with_interval, undecided

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
    cells = [
        (
            written.get(effect.quantity, effect.quantity), _source(effect), str(effect.contrast), _animals(effect),
            _ratio(effect), number(effect.standard_error, 2), _degrees(effect), _p(effect),
            number(effect.smallest_p, 2), "yes" if effect.apart else "no", _influence(effect),
        )
        for effect in effects
    ]  # fmt: skip
    header = ("quantity", "source", "groups", "animals", "ratio [95 %, all rows]", "SE of its log", "df", "p, all rows",
              "smallest p by ranks", "groups apart", "ratio without one animal")  # fmt: skip
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
    table = Table("Primary", caption, header, cells, note, primary.table())
    if designed:
        table = table.hiding("smallest p by ranks", "groups apart")
    return [table, _other_laws(primary, written)] if len(primary.others) else [table]


def covariates_table(primary: Primary, written: Mapping[str, str]) -> Table:
    """Return what the covariates of a design do."""
    cells = [
        (written.get(effect.quantity, effect.quantity), effect.source, effect.covariate, _ratio(effect))
        for effect in primary.adjusted
    ]
    note = (
        "By the models of the primary comparison, from which groups are adjusted: of categories the means of animals "
        "of one level over those of the first, of numbers the ratio for one standard deviation. Each interval by "
        "itself, without a test."
    )
    header = ("quantity", "source", "covariate", "ratio [95 %]")
    return Table("Covariates", "Effects of the covariates", header, cells, note, as_table(primary.adjusted))


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


def _source(effect: Effect) -> str:
    return f"{effect.source}, posteriors" if effect.origin == "posterior" else effect.source


def _ratio(estimate: RatioEstimate) -> str:
    return ratio_with_interval(estimate.ratio, estimate.low, estimate.high)


def _degrees(effect: Effect) -> str:
    freedom = effect.freedom
    return number(freedom, 2) if freedom < _MANY else f"{freedom:.0f}" if np.isfinite(freedom) else "∞"


def _p(effect: Effect) -> str:
    return "none: one image" if effect.untested is Untested.ONE_IMAGE else p_value(effect.p)


def _influence(effect: Effect) -> str:
    return f"{number(effect.ratio_without)} ({effect.without})" if effect.without else "–"


def _other_laws(primary: Primary, written: Mapping[str, str]) -> Table:
    cells = [
        (written.get(estimate.quantity, estimate.quantity), estimate.source, str(estimate.contrast), _ratio(estimate))
        for estimate in primary.others
    ]
    note = "Secondary: the same effects, their intervals to the same level, without a test."
    header = ("quantity", "wall", "groups", "ratio [95 %]")
    data = as_table(primary.others)
    return Table("PrimaryOtherLaws", "Ratios by the other wall laws", header, cells, note, data)


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
        source_symbols = written | {"tau": "τ"} if source == "measured" else written
        cells.append((str(source), with_unit(label, source_symbols), *texts))
    return Table("Groups", "All quantities by group", header, cells, _NOTE, data)


def _cells(cohort: Cohort, data: pd.DataFrame) -> Table:
    """Return the same as one row for each cell of groups and levels, which would be too many columns."""
    written = symbols(cohort)
    measured = written | {"tau": "τ"}
    cells = [
        (
            str(row["source"]), with_unit(row["quantity"], written if row["source"] != "measured" else measured),
            str(row["group"]), str(row["n"]), mean_sd(row), median_iqr(row),
        )
        for _, row in data.iterrows()
    ]  # fmt: skip
    again = cohort.second.name if cohort.second else ""
    header = ("source", "quantity", f"group, {again}", "n", "mean ± SD", "median [IQR]")
    note = f"n: recordings. {_NOTE}"
    return Table("Groups", f"All quantities by group and {again}", header, cells, note, data)


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
