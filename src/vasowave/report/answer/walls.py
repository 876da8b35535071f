"""Which wall law: what the residuals prefer, pooled over animals, and what can look like it."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.animal.reading import data_of
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.pooling import pooled_mean
from vasowave.cohort.votes import differences
from vasowave.report.wording import number, with_interval

_LOOKS_LIKE = "Errors of the geometry, a taper or a stiffness that changes along the tree can look like curvature."
DECISIVE = 2.0
"""Difference of AICc below which one animal does not tell two laws apart."""


def wall_answer(cohort: Cohort, law: str) -> tuple[str, str]:
    """Return question and answer."""
    question, exponents = "Which wall?", _exponents(cohort)
    caveat = [_LOOKS_LIKE] if exponents else []
    if len(cohort.walls) < 2:
        return question, " ".join([*exponents, f"Only the {law} wall was fitted; nothing is known of others.", *caveat])
    if not cohort.compared:
        return question, " ".join([*exponents, "The laws were not compared by their residuals.", *caveat])
    table = differences(cohort.ballots, law)
    if not len(table):
        lost = "No noise model of the residuals could be kept, so they prefer no law."
        return question, " ".join([*exponents, lost])
    said = [_one(row, law) if cohort.single else _pooled(row, law) for _, row in table.iterrows()]
    return question, " ".join([*exponents, *said, _LOOKS_LIKE])


def _exponents(cohort: Cohort) -> list[str]:
    """Say how the wall stiffens where a law has a parameter for it, pooled over animals."""
    said = []
    for wall in cohort.walls:
        results = [result for result in cohort.calibrated(wall) if "stiffening" in result[wall].children]
        exponents = [data_of(result, f"{wall}/stiffening")["exponent"] for result in results]
        inside = [one for one in exponents if not int(one.attrs["at_bound"])]
        if inside:
            said.append(_exponent(wall, inside, len(exponents)))
    return said


def _exponent(wall: str, exponents: Sequence[xr.DataArray], count: int) -> str:
    name, linear = exponents[0].attrs["parameter"], float(exponents[0].attrs["linear_at"])
    value, low, high = _pooled_exponent(exponents)
    verdict = "stiffens more than" if low > linear else "stiffens less than" if high < linear else ""
    start = f"The wall {verdict}" if verdict else "Open is whether the wall stiffens more or less than"
    animals = "" if count == 1 else f"; {len(exponents)} animals pooled"
    others = f", {count - len(exponents)} at a bound left out" if len(exponents) < count else ""
    size = with_interval(value, low, high)
    return f"{start} a linear one: {name} = {size} ({wall} law; {linear:g} is linear{animals}{others})."


def _pooled_exponent(exponents: Sequence[xr.DataArray]) -> tuple[float, float, float]:
    """Return the exponent with the ends of its 95 % interval; of several animals, pooled on logarithms."""
    from scipy.special import stdtrit

    ends = np.log([(float(one.attrs["interval_low"]), float(one.attrs["interval_high"])) for one in exponents])
    logs = np.log([float(one) for one in exponents])
    if len(exponents) == 1:
        return float(exponents[0]), float(np.exp(ends[0, 0])), float(np.exp(ends[0, 1]))
    mean = pooled_mean(logs, np.diff(ends)[:, 0] / (2 * stdtrit(np.inf, 0.975)))
    reach = float(stdtrit(mean.freedom, 0.975)) * mean.error
    low, high = np.exp([mean.value - reach, mean.value + reach]).tolist()
    return float(np.exp(mean.value)), low, high


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
