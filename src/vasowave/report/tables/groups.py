"""Tables that describe and compare the groups."""

import numpy as np
import pandas as pd

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.comparison import Comparison
from vasowave.cohort.description import described
from vasowave.cohort.rank_tests import MOST_EXACT
from vasowave.report.blocks import Table
from vasowave.report.tables.cells import interval, mean_sd, median_iqr, source_title, span, symbols, with_unit
from vasowave.report.wording import number

_NOTE = (
    "IQR: from the first to the third quartile. A symbol means what its source can know: measured β, c and τ "
    "follow from the up-slope (at zero pressure) and from the diastolic decay, measured R_T is mean pressure "
    "(above the wedge's) over mean flow; those of a wall law are its calibrated stiffness, the wave speed at mean "
    "pressure, R_T of the vascular beds alone."
)


def groups(cohort: Cohort) -> Table:
    """Every single number of every source, described by group; by group and level, one below the other, if crossed."""
    data = pd.concat([described(cohort.described, source) for source in cohort.table["source"].unique()])
    if cohort.crossed:
        return _cells(cohort, data)
    header = (
        "source",
        "quantity",
        *(f"{group}: {what}" for group in cohort.groups for what in ("mean ± SD", "median [IQR]")),
    )
    written, cells = symbols(cohort), []
    for (source, label), part in data.groupby(["source", "quantity"], sort=False):
        by_group = {str(row["group"]): row for _, row in part.iterrows()}
        texts = [
            text
            for group in cohort.groups
            for text in ((mean_sd(by_group[group]), median_iqr(by_group[group])) if group in by_group else ("–", "–"))
        ]
        own = written | {"tau": "τ"} if source == "measured" else written
        cells.append((str(source), with_unit(label, own), *texts))
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


def contrasts(comparison: Comparison, source: str, written: dict[str, str]) -> Table:
    """The comparison of the groups by one source of numbers."""
    data = comparison.contrasts
    several = data[["reference", "other"]].drop_duplicates().shape[0] > 1
    pair = data.iloc[0]
    header = ("quantity", *(("groups",) if several else ()), "η", "ratio [95 %]", "Hedges g [95 %]", "p", "p Holm")
    cells = []
    for _, row in data.iterrows():
        between = (f"{row['other']} / {row['reference']}",) if several else ()
        intervals = (interval(row, "ratio", "ratio"), interval(row, "Hedges g", "g"))
        cells.append((with_unit(row["quantity"], written), *between, number(row["eta"], 2), *intervals,
                      number(row["p"], 2), number(row["p Holm"], 2)))  # fmt: skip
    who = "every pair of groups" if several else f"{pair['other']} against {pair['reference']}"
    note = (
        "η: relative change of the mean (eq. 20), never below -1 for a positive quantity; ratio: of geometric means, "
        f"Welch interval; p: Mann-Whitney test, exact up to {MOST_EXACT} animals; Holm over these {len(data)} tests."
    )
    return Table(f"Contrasts-{source}", f"{source_title(source)}: {who}", header, cells, note, data)


def without_one(comparison: Comparison, source: str, written: dict[str, str]) -> Table:
    """The shifts of the ratios when any one animal is left out."""
    data, cells = comparison.without_one, []
    for (reference, other, label), part in data.groupby(["reference", "other", "quantity"], sort=False):
        farthest = part.loc[np.log(part["ratio shift"]).abs().idxmax()]
        cells.append((f"{other} / {reference}", with_unit(label, written), span(part["ratio"].to_numpy()),
                      str(farthest["left out"]), number(farthest["ratio shift"], 3)))  # fmt: skip
    header = ("groups", "quantity", "ratio", "moved most without", "by a factor of")
    note = "Smallest and largest ratio over all ways of leaving one animal out, and the animal that moves it most."
    return Table(f"LeaveOneOut-{source}", f"{source_title(source)}, one animal left out", header, cells, note, data)
