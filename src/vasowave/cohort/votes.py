"""Which wall law each noise model prefers, animal by animal, as the stored comparison says."""

from collections.abc import Hashable

import pandas as pd
import xarray as xr

from vasowave.animal.reading import data_of

UNDECIDED, DISCARDED = "undecided", "discarded"
NOISE = ("covariance", "sharing", "optimum")
"""Columns that tell one noise model, and the optimum at which it was asked, from another."""
CRITERIA = ("AICc", "BIC")


def ballots(tree: xr.DataTree) -> pd.DataFrame:
    """Return one row per noise model of one animal, in the order stored, discarded ones last.

    Columns: those of `NOISE` that there are; ``CRITERION LAW`` and ``CRITERION prefers`` (a law, "undecided" where
    the runner-up is too close, or "discarded"); ``λ``, ``N``, and ``D LAW``.
    """
    candidates = data_of(tree, "selection").to_dataframe().reset_index(drop=True)
    keys = [key for key in NOISE if key in candidates.columns]
    rows = []
    for which, laws in candidates.groupby(keys, sort=False):
        by_law = laws.set_index("wall")
        row: dict[Hashable, object] = dict(zip(keys, which, strict=True))
        for criterion in CRITERIA:
            row |= {f"{criterion} {wall}": float(score) for wall, score in by_law[criterion].items()}
            row[f"{criterion} prefers"] = _preferred(by_law, criterion)
        row |= {"λ": float(by_law["lambda"].max()), "N": int(by_law["N"].iloc[0])}
        rows.append(row | {f"D {wall}": int(count) for wall, count in by_law["D"].items()})
    table = pd.DataFrame(rows)
    return table.iloc[(table["AICc prefers"] == DISCARDED).argsort(kind="stable")]


def vote(tree: xr.DataTree) -> str:
    """Return the law that AICc prefers under the likeliest noise model at the least-squares optimum.

    "undecided" where the runner-up is too close, "discarded" where no noise model is kept.
    """
    table, likeliest = ballots(tree), data_of(tree, "selection").attrs.get("preferred_covariance")
    if likeliest is None:
        likeliest = table["covariance"].iloc[0]
    for key, value in zip(NOISE, (likeliest, "joint", "OLS"), strict=True):
        if key in table:
            table = table[table[key] == value]
    return str(table["AICc prefers"].iloc[0]) if len(table) else DISCARDED


def _preferred(by_law: pd.DataFrame, criterion: str) -> str:
    if by_law["discarded"].astype(bool).any():
        return DISCARDED
    verdicts = by_law[f"{criterion}_verdict"]
    return next((str(wall) for wall, verdict in verdicts.items() if verdict == "preferred"), UNDECIDED)
