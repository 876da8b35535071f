"""One calibration in sentences."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.animal.result import AnimalResult
from vasowave.report.tables.animal import estimates_frame
from vasowave.report.wording import listed, number, unit, with_error


def fit_sentences(result: AnimalResult, wall: str, written: Mapping[str, str]) -> list[str]:
    """Return stiffness, outlets, quality, determination and agreement of the starts."""
    fit = result.laws[wall].calibration
    table = estimates_frame(result, wall).set_index("parameter")
    return [
        _walls(result, wall, table, written),
        _beds(fit),
        _quality(result, fit),
        *_limits(table, written),
        _starts(fit),
    ]


def _walls(result: AnimalResult, wall: str, table: pd.DataFrame, written: Mapping[str, str]) -> str:
    quantities = result.laws[wall].quantities
    parts = [
        f"{quantities[name].attrs['long_name']} {written.get(name, name)} = {_with_error(table.loc[[name]].iloc[0])}"
        for name in result.laws[wall].parameters
    ]
    speed = number(float(quantities["wave_speed"]))
    return f"Walls: {listed(parts)}; waves run at {speed} cm/s in the root vessel at the measured mean pressure."


def _with_error(row: pd.Series) -> str:
    units = f" {unit(row['unit'])}".rstrip()
    if not row["free"]:
        return f"{number(row['value'])}{units} (held)"
    error = float(row.get("standard_error_correlated", row["standard_error"]))
    return f"{with_error(float(row['value']), error)}{units}"


def _beds(fit: xr.Dataset) -> str:
    proximal = f", of which {number(100 * float(fit['a']))} % proximal (ratio a)" if "a" in fit else ""
    compliance = f", compliance {number(float(fit['C_p']))} ml/mmHg" if "C_p" in fit else ""
    return f"Vascular beds: total resistance R_T = {number(float(fit['R_T']))} mmHg s/ml{proximal}{compliance}."


def _quality(result: AnimalResult, fit: xr.Dataset) -> str:
    share = 100 * float(fit["RMSE"]) / float(result.measured.quantities["pPAP"])
    left = f"{number(float(fit['RMSE']))} mmHg (root mean square), {number(share, 2)} % of the pulse pressure"
    what = "pressure"
    if fit.attrs.get("enters") == "pressure":
        residual, what = fit["flow_residual"], "flow"
        ml_per_s = float(np.sqrt(np.mean(residual.values**2)))
        left = f"{number(ml_per_s)} {residual.attrs['units']} (root mean square), {number(share, 2)} % of its pulse"
    return (
        f"Fit: the {what} differs from the measured one by {left}; "
        f"S = {number(float(fit['S']))} mmHg² over {int(fit['N'])} samples."
    )


def _limits(table: pd.DataFrame, written: Mapping[str, str]) -> list[str]:
    """Say which parameters end at a bound, and which the data do not determine."""
    free = table[table["free"].astype(bool)]
    symbols = {str(name): written.get(str(name), str(name)) for name in free.index}
    stopped = [
        f"{symbols[str(name)]} at its {_nearer_bound(row)} bound ({number(row['value'])})"
        for name, row in free[free["at_bound"].astype(bool)].iterrows()
    ]
    open_ones = [symbols[str(name)] for name in free.index[~free["determined"].astype(bool)]]
    sentences = [f"The search ended with {listed(stopped)}."] if stopped else []
    if open_ones:
        return [*sentences, f"The data do not determine {listed(open_ones)}; other values fit about as well."]
    return [*sentences, "The data determine every free parameter."]


def _nearer_bound(row: pd.Series) -> str:
    return "lower" if row["value"] - row["lower"] < row["upper"] - row["value"] else "upper"


def _starts(fit: xr.Dataset) -> str:
    agree, count = int(fit["start_agrees"].values.astype(bool).sum()), int(fit.sizes["start"])
    if count == 1:
        return "One start was made."
    if agree == count:
        return f"All {count} starts of the optimization came to this optimum, or into its bowl."
    said = f"Only {agree} of {count} starts of the optimization came to this optimum or into its bowl"
    return f"{said}; the others are listed below."
