"""Which wall law the residuals of one animal prefer, as labelled data."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.calibration import Fit


def selection_dataset(fits: Sequence[Fit]) -> xr.Dataset:
    """Return AICc and BIC of every wall law under every noise model (eqs. 21 to 23), one candidate per pair."""
    from vasowave.selection import compare_models

    residuals = {fit.wall: fit.pressure_residual for fit in fits}
    count = {fit.wall: int(fit.parameters["free"].sum()) for fit in fits}
    table = compare_models(residuals, count, fits[0].recording.period)
    rows = [_candidate(table[(table["noise"] == noise) & (table["model"] == wall)]) for noise, wall in _pairs(table)]
    frame = pd.DataFrame(rows)
    text = {"covariance": object, "wall": object}
    variables = {
        str(name): ("candidate", frame[name].to_numpy(text.get(str(name), float)), {"units": "1"}) for name in frame
    }
    return xr.Dataset(variables, attrs={"sharing": str(table["sharing"].iloc[0])})


def _pairs(table: pd.DataFrame) -> list[tuple[str, str]]:
    return list(dict.fromkeys(zip(table["noise"], table["model"], strict=True)))


def _candidate(rows: pd.DataFrame) -> dict[str, object]:
    scores = rows.set_index("criterion")["score"]
    one = rows.iloc[0]
    return {
        "covariance": one["noise"],
        "wall": one["model"],
        "loglik": one["log likelihood"],
        "D": one["D"],
        "N": one["N"],
        "AICc": scores["AICc"],
        "BIC": scores["BIC"],
        "lambda": one["lambda"],
        "discarded": float(np.any(rows["verdict"] == "discarded")),
    }
