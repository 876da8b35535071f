"""How well the calibrated laws meet their data: against the beats' scatter, the pulse, and each other."""

import numpy as np
import pandas as pd

from vasowave.animal.result import AnimalResult
from vasowave.cohort.cohort import Cohort

WORSE_THAN_BEST = 2.0
"""A law that leaves more than this times the residual of the animal's best law misses its data."""

WORST_SHARE = 0.1
"""So does one that leaves more than this share of the pulse pressure."""


def misfits(cohort: Cohort) -> pd.DataFrame:
    """Return one row for every animal and wall law: what its fit leaves, and whether it misses the data.

    Columns ``animal, group, wall, RMSE, error, share, over best, missed``: the root-mean-square residual, mmHg; the
    standard error of the averaged cycle, mmHg (NaN if a cycle was given); the residual over the pulse pressure and over
    that of the animal's best law; whether it exceeds `WORSE_THAN_BEST` or `WORST_SHARE`, and the error of the cycle.
    """
    rows = []
    for result in cohort.results:
        left = {wall: float(result.laws[wall].calibration["RMSE"]) for wall in result.laws}
        pulse, error = float(result.measured.quantities["pPAP"]), _cycle_error(result)
        for wall, rmse in left.items():
            share, over = rmse / pulse, rmse / min(left.values())
            missed = (over > WORSE_THAN_BEST or share > WORST_SHARE) and not rmse < error
            rows.append((result.name, result.group, wall, rmse, error, share, over, missed))
    return pd.DataFrame(rows, columns=["animal", "group", "wall", "RMSE", "error", "share", "over best", "missed"])


def _cycle_error(result: AnimalResult) -> float:
    """Return the standard error of the averaged pressure from the scatter of its beats, mmHg."""
    recording = result.recording
    if "pressure_sd" not in recording.data_vars or result.beats is None:
        return np.nan
    beats = int(result.beats["kept"].sum())
    return float(np.sqrt((recording["pressure_sd"] ** 2).mean() / max(beats, 1)))
