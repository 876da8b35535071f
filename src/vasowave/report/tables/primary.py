"""Tables of the primary comparison: effects, family-wise p, influence of single animals; the same by other laws."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from vasowave.cohort.primary import Primary, Untested
from vasowave.report.answer.groups import effect_of
from vasowave.report.blocks import Table
from vasowave.report.wording import number, p_value, ratio_with_interval, undecided

_MANY = 10  # degrees of freedom whose decimals say nothing


def primary_tables(primary: Primary, written: Mapping[str, str]) -> list[Table]:
    """Return the primary comparison, and the effects that other laws give."""
    rows = primary.rows
    cells = [
        (
            written.get(row["quantity"], row["quantity"]), _source(row), effect_of(row),
            _animals(row), _effect(row), number(float(row["standard error"]), 2), _degrees(row), _p(row),
            number(float(row["smallest p"]), 2), "yes" if row["apart"] else "no", _influence(row),
        )
        for _, row in rows.iterrows()
    ]  # fmt: skip
    header = ("quantity", "source", "groups", "animals", "ratio [95 %, all rows]", "SE of its log", "df", "p, all rows",
              "smallest p by ranks", "groups apart", "ratio without one animal")  # fmt: skip
    designed = "what" in rows
    if designed:
        note = (
            "Ratio: of means on logarithms by one mixed model for each quantity, the animals' known errors in it "
            "(restricted maximum likelihood, Kenward and Roger's standard errors and degrees of freedom); of an "
            f"interaction a ratio of ratios. Interval and p: for all {len(rows)} rows together, from one distribution, "
            "so that an interval excludes 1 exactly if p < 0.05; logarithms are taken as normal. Without: the one "
            "animal, with all its recordings, that moves the ratio most when it is left out."
        )
    else:
        note = _note(len(rows))
    note += " SE: of the ratio's natural logarithm; df: its degrees of freedom."
    if rows["p"].map(undecided).any():
        note += " ≈: other draws may put this p on the other side of 0.05."
    if primary.assurance:
        note += (
            f" Of cohorts without any effect, of these sizes, spreads and correlations, "
            f"{100 * primary.assurance.rate:.1f} % have a row with p < 0.05; it should be 5 %."
        )
    if (rows["untested"] == Untested.ONE_IMAGE).any():
        note += (
            " No p: animals of a group have one image, and a fit takes it as exact; the interval is without its error. "
            "Posteriors contain it."
        )
    if "posterior" in set(rows["estimates"]):
        note += (
            " From posteriors: values and errors of the animals are the means and SD of the logarithms of their draws, "
            "and the error of an image that several animals have is not averaged away."
        )
    table = Table("Primary", "Primary comparison, of the family that the settings name", header, cells, note, rows)
    if designed:
        table = table.hiding("smallest p by ranks", "groups apart")
    return [table, _others(primary, written)] if len(primary.others) else [table]


def covariates_table(primary: Primary, written: Mapping[str, str]) -> Table:
    """Return what the covariates of a design do."""
    rows = primary.adjusted
    cells = [
        (written.get(row["quantity"], row["quantity"]), str(row["source"]), str(row["covariate"]), _effect(row))
        for _, row in rows.iterrows()
    ]
    note = (
        "By the models of the primary comparison, from which groups are adjusted: of categories the means of animals "
        "of one level over those of the first, of numbers the ratio for one standard deviation. Each interval by "
        "itself, without a test."
    )
    header = ("quantity", "source", "covariate", "ratio [95 %]")
    return Table("Covariates", "Effects of the covariates", header, cells, note, rows)


def _note(count: int) -> str:
    return (
        "Ratio: of the groups' means on logarithms, each animal weighted by its error and by what the animals of its "
        "group differ (random effects, restricted maximum likelihood; standard errors after Hartung and Knapp, without "
        f"known errors Welch's). Interval and p: for all {count} rows together, from one distribution, "
        "so that an interval excludes 1 exactly if p < 0.05; logarithms are taken as normal. Smallest p: of any test "
        "by ranks or relabelings, which asks for no distribution. Apart: no animal of one group lies among the other. "
        "Without: the one animal that moves the ratio most when it is left out."
    )


def _animals(row: pd.Series) -> str:
    """Return how many animals each side has, once where all of them are on both."""
    other, reference, both = row["n other"], row["n reference"], row.get("n both", 0)
    if both and other == reference == both:
        return f"{both}, each at both"
    return f"{other}, {reference}" + (f" ({both} at both)" if both else "")


def _source(row: pd.Series) -> str:
    return f"{row['source']}, posteriors" if row["estimates"] == "posterior" else str(row["source"])


def _effect(row: pd.Series) -> str:
    return ratio_with_interval(float(row["ratio"]), float(row["low"]), float(row["high"]))


def _degrees(row: pd.Series) -> str:
    freedom = float(row["df"])
    return number(freedom, 2) if freedom < _MANY else f"{freedom:.0f}" if np.isfinite(freedom) else "∞"


def _p(row: pd.Series) -> str:
    return "none: one image" if row["untested"] == Untested.ONE_IMAGE else p_value(float(row["p"]))


def _influence(row: pd.Series) -> str:
    return f"{number(float(row['ratio without']))} ({row['without']})" if row["without"] else "–"


def _others(primary: Primary, written: Mapping[str, str]) -> Table:
    rows = primary.others
    cells = [
        (
            written.get(row["quantity"], row["quantity"]),
            str(row["source"]),
            effect_of(row),
            _effect(row),
        )
        for _, row in rows.iterrows()
    ]
    note = "Secondary: the same effects, their intervals to the same level, without a test."
    header = ("quantity", "wall", "groups", "ratio [95 %]")
    return Table("PrimaryOtherLaws", "Ratios by the other wall laws", header, cells, note, rows)
