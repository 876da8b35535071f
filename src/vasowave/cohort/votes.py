"""Which wall law the residuals prefer, animal by animal and pooled, as the stored comparisons say."""

from collections.abc import Hashable, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.animal.reading import data_of

UNDECIDED, DISCARDED = "undecided", "discarded"
NOISE = ("covariance", "sharing", "optimum")
"""Columns that tell one noise model, and the optimum at which it was asked, from another."""
CRITERIA = ("AICc", "BIC")


def ballots(result: xr.DataTree) -> pd.DataFrame:
    """Return one row per noise model of one animal, in the order stored, discarded ones last.

    Columns: those of `NOISE` that there are; ``CRITERION LAW`` and ``CRITERION prefers`` (a law, "undecided" where
    the runner-up is too close, or "discarded"); ``λ``, ``N``, and ``D LAW``.
    """
    candidates = data_of(result, "selection").to_dataframe().reset_index(drop=True)
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


def vote(result: xr.DataTree) -> str:
    """Return the law that AICc prefers under the likeliest noise model at the least-squares optimum.

    "undecided" where the runner-up is too close, "discarded" where no noise model is kept.
    """
    animal = stored(result)
    return str(_under(animal, animal.likeliest)["AICc prefers"])


class Ballots(NamedTuple):
    """The `ballots` of one animal, and the noise model that is likeliest for it."""

    table: pd.DataFrame
    likeliest: str


def stored(result: xr.DataTree) -> Ballots:
    """Return what the comparison of one animal came to."""
    table = ballots(result)
    return Ballots(
        table, str(data_of(result, "selection").attrs.get("preferred_covariance", table["covariance"].iloc[0]))
    )


def differences(animals: Sequence[Ballots], reference: str, covariance: str = "") -> pd.DataFrame:
    """Return by how much AICc of every other wall law exceeds that of `reference`, pooled over animals.

    Of each animal counts the noise model that is likeliest for it, or the one named, at the least-squares optimum.

    Returns
    -------
    DataFrame
        One row per law: ``wall, n, mean, low, high, sum``. ``mean`` is the criterion of the law minus that of the
        reference, by animal; ``low, high`` are the ends of its 95 % interval (Student) from the scatter of the animals.
        Positive numbers speak for the reference.
    """
    by_wall: dict[str, list[float]] = {}
    for animal in animals:
        scores = _under(animal, covariance or animal.likeliest)
        labels = [label for label in scores.index if label.startswith("AICc ") and label != "AICc prefers"]
        by_law = {label.removeprefix("AICc "): float(scores[label]) for label in labels}
        if reference in by_law and scores["AICc prefers"] != DISCARDED:
            for wall in by_law.keys() - {reference}:
                by_wall.setdefault(wall, []).append(by_law[wall] - by_law[reference])
    rows = [(wall, len(values), *_mean_and_interval(np.array(values)), sum(values)) for wall, values in by_wall.items()]
    return pd.DataFrame(rows, columns=["wall", "n", "mean", "low", "high", "sum"])


def _mean_and_interval(values: np.ndarray) -> tuple[float, float, float]:
    from scipy.special import stdtrit

    mean, n = float(values.mean()), len(values)
    if n < 2:
        return mean, np.nan, np.nan
    reach = float(stdtrit(n - 1, 0.975) * values.std(ddof=1) / np.sqrt(n))
    return mean, mean - reach, mean + reach


def _under(animal: Ballots, covariance: str) -> pd.Series:
    """Return the row of a noise model; it says "discarded" if there is none."""
    table = animal.table
    for key, value in zip(NOISE, (covariance, "joint", "OLS"), strict=True):
        if key in table:
            table = table[table[key] == value]
    return table.iloc[0] if len(table) else pd.Series({f"{one} prefers": DISCARDED for one in CRITERIA})


def _preferred(by_law: pd.DataFrame, criterion: str) -> str:
    if by_law["discarded"].astype(bool).any():
        return DISCARDED
    verdicts = by_law[f"{criterion}_verdict"]
    return next((str(wall) for wall, verdict in verdicts.items() if verdict == "preferred"), UNDECIDED)
