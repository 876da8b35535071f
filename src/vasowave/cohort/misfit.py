"""How well the calibrated laws meet their data: against the beats' scatter, the pulse, and each other."""

from collections.abc import Iterable

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.animal.result import AnimalResult

WORSE_THAN_BEST = 2.0
"""A law that leaves more than this times the residual of the animal's best law misses its data; a law whose vessels are
strained beyond what an artery survives is no best law."""

WORST_SHARE = 0.1
"""So does one that leaves more than this share of the pulse pressure."""

_COLUMNS = ["animal", "group", "wall", "RMSE", "error", "share", "over best", "missed", "growth"]


def misfits(results: Iterable[AnimalResult]) -> pd.DataFrame:
    """Return one row for every animal and wall law: what its fit leaves, and whether it misses the data.

    Columns ``animal, group, wall, RMSE, error, share, over best, missed, growth``: the root-mean-square residual, mmHg;
    the standard error of the averaged cycle, mmHg (NaN if a cycle was given); the residual over the pulse pressure and
    over that of the animal's best law (NaN if there is none); whether it exceeds `WORSE_THAN_BEST` or `WORST_SHARE`,
    and the error of the cycle; how much a vessel's area grows beyond what an artery survives, % (NaN if none does).
    """
    rows = []
    for result in results:
        left = {wall: float(result.laws[wall].calibration["RMSE"]) for wall in result.laws}
        pulse, error = float(result.measured.quantities["pPAP"]), _cycle_error(result)
        strained = {wall: one for wall, law in result.laws.items() if (one := law.overstrained)}
        best = min((left[wall] for wall in left if wall not in strained), default=np.nan)
        for wall, rmse in left.items():
            share, over = rmse / pulse, rmse / best
            missed = (over > WORSE_THAN_BEST or share > WORST_SHARE) and not rmse < error
            growth = float(dict(strained[wall].values)["percent"]) if wall in strained else np.nan
            rows.append((result.name, result.group, wall, rmse, error, share, over, missed, growth))
    return pd.DataFrame(rows, columns=_COLUMNS)


def is_lone(calibration: xr.Dataset) -> bool:
    """Whether only one of several starts reached the best optimum."""
    return bool(calibration.sizes["start"] > 2 and int(calibration["start_agrees"].sum()) == 1)


def _cycle_error(result: AnimalResult) -> float:
    """Return the standard error of the averaged pressure from the scatter of its beats, mmHg."""
    recording = result.recording
    if "pressure_sd" not in recording.data_vars or result.beats is None:
        return np.nan
    beats = int(result.beats["kept"].sum())
    return float(np.sqrt((recording["pressure_sd"] ** 2).mean() / max(beats, 1)))
