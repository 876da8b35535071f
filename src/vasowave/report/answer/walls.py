"""Which wall law: what the residuals prefer, pooled over animals, and what can look like it."""

import numpy as np
import pandas as pd

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.votes import differences
from vasowave.report.wording import number, with_interval

_LOOKS_LIKE = "Errors of the geometry, a taper or a stiffness that changes along the tree can look like curvature."
DECISIVE = 2.0
"""Difference of AICc below which one animal does not tell two laws apart."""


def wall_answer(cohort: Cohort, law: str) -> tuple[str, str]:
    """Return question and answer."""
    question = "Which wall?"
    if len(cohort.walls) < 2:
        return question, f"Only the {law} wall was fitted; nothing is known of others."
    if not cohort.compared:
        return question, "Several laws were fitted, but not compared by their residuals."
    table = differences(cohort.ballots, law)
    if not len(table):
        return question, "No noise model of the residuals could be kept, so they prefer no law."
    said = [_one(row, law) if cohort.single else _pooled(row, law) for _, row in table.iterrows()]
    return question, " ".join([*said, _LOOKS_LIKE])


def _pooled(row: pd.Series, law: str) -> str:
    mean, low, high = float(row["mean"]), float(row["low"]), float(row["high"])
    sense = "higher" if mean > 0 else "lower"
    size = with_interval(abs(mean), *sorted((np.sign(mean) * low, np.sign(mean) * high)))
    numbers = (
        f"AICc of the {row['wall']} wall is {size} {sense} per animal than that of the {law} wall (n = {row['n']})"
    )
    if not np.isfinite(low) or low <= 0 <= high:
        return f"Open between {law} and {row['wall']}: {numbers}."
    return f"The residuals speak for the {law if mean > 0 else row['wall']} wall: {numbers}."


def _one(row: pd.Series, law: str) -> str:
    mean = float(row["mean"])
    better, worse = (law, row["wall"]) if mean > 0 else (row["wall"], law)
    verdict = "speak for" if abs(mean) > DECISIVE else "hardly decide for"
    return f"The residuals {verdict} the {better} wall: its AICc is {number(abs(mean), 2)} below the {worse} wall's."
