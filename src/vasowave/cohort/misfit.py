"""How well the calibrated laws meet their data: against the beats' scatter, the pulse, and each other."""

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.animal.reading import data_of, group_of, name_of, wall_laws
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
        left = {wall: float(data_of(result, f"{wall}/calibration")["RMSE"]) for wall in wall_laws(result)}
        pulse, error = float(data_of(result, "measured/quantities")["pPAP"]), _cycle_error(result)
        for wall, rmse in left.items():
            share, over = rmse / pulse, rmse / min(left.values())
            missed = (over > WORSE_THAN_BEST or share > WORST_SHARE) and not rmse < error
            rows.append((name_of(result), group_of(result), wall, rmse, error, share, over, missed))
    return pd.DataFrame(rows, columns=["animal", "group", "wall", "RMSE", "error", "share", "over best", "missed"])


def _cycle_error(result: xr.DataTree) -> float:
    """Return the standard error of the averaged pressure from the scatter of its beats, mmHg."""
    recording = data_of(result, "recording")
    if "pressure_sd" not in recording.data_vars or "beats" not in result.children:
        return np.nan
    beats = int(data_of(result, "beats")["kept"].sum())
    return float(np.sqrt((recording["pressure_sd"] ** 2).mean() / max(beats, 1)))
