"""Tables of the primary comparison: effects, family-wise p, influence of single animals; the same by other laws."""

from collections.abc import Mapping

import pandas as pd

from vasowave.cohort.primary import Primary
from vasowave.report.blocks import Table
from vasowave.report.wording import number, with_interval


def primary_tables(primary: Primary, written: Mapping[str, str]) -> list[Table]:
    """Return the primary comparison, and the effects that other laws give."""
    rows = primary.rows
    cells = [
        (
            written.get(row["quantity"], row["quantity"]), _source(row), f"{row['other']} / {row['reference']}",
            f"{row['n other']}, {row['n reference']}", _effect(row), number(float(row["p"]), 2),
            number(float(row["smallest p"]), 2), "yes" if row["apart"] else "no", _influence(row),
        )
        for _, row in rows.iterrows()
    ]  # fmt: skip
    header = ("quantity", "source", "groups", "animals", "ratio [95 %]", "p, family-wise", "smallest p possible",
              "groups apart", "ratio without one animal")  # fmt: skip
    note = (
        "Ratio: of the groups' means on logarithms, each animal weighted by its error and by what the animals of its "
        "group differ (random effects, restricted maximum likelihood, interval after Hartung and Knapp; without known "
        f"errors Welch's). p: step-down max-|t| over relabelings, for all {len(rows)} rows together. Apart: no animal "
        "of "
        "one group lies among the other. Without: the one animal that moves the ratio most when it is left out."
    )
    if "posterior" in set(rows["estimates"]):
        note += (
            " From posteriors: values and errors of the animals are the means and SD of the logarithms of their draws, "
            "and the error of an image that several animals have is not averaged away."
        )
    table = Table("Primary", "Primary comparison, declared before", header, cells, note, rows)
    return [table, _others(primary, written)] if len(primary.others) else [table]


def _source(row: pd.Series) -> str:
    return f"{row['source']}, posteriors" if row["estimates"] == "posterior" else str(row["source"])


def _effect(row: pd.Series) -> str:
    return with_interval(float(row["ratio"]), float(row["low"]), float(row["high"]))


def _influence(row: pd.Series) -> str:
    return f"{number(float(row['ratio without']))} ({row['without']})" if row["without"] else "–"


def _others(primary: Primary, written: Mapping[str, str]) -> Table:
    rows = primary.others
    cells = [
        (
            written.get(row["quantity"], row["quantity"]),
            str(row["source"]),
            f"{row['other']} / {row['reference']}",
            _effect(row),
        )
        for _, row in rows.iterrows()
    ]
    note = "The same effects, without a test: they are not primary."
    header = ("quantity", "wall", "groups", "ratio [95 %]")
    return Table("PrimaryOtherLaws", "Ratios by the other wall laws", header, cells, note, rows)
