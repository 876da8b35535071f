"""Labelled data: values with their unit and meaning, and the columns of a table as variables."""

from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.io.columns import split_unit


def labelled(dims: str | tuple[str, ...], values: Any, unit: str, meaning: str) -> xr.Variable:
    """Return values with their unit and what they mean."""
    return xr.Variable(dims, np.asarray(values), {"units": unit, "long_name": meaning})


def table_dataset(frame: pd.DataFrame, dim: str, units: dict[str, str] | None = None) -> xr.Dataset:
    """Return the columns of `frame` as variables along `dim`; a column ``S [mmHg2]`` becomes S with that unit."""
    variables: dict[str, xr.Variable] = {}
    for label in frame.columns:
        name, unit = split_unit(str(label))
        unit = unit or (units or {}).get(name, "")
        variables[name] = xr.Variable(dim, _plain(frame[label]), {"units": unit} if unit else {})
    coordinate = {dim: variables.pop(dim)} if dim in variables else {}
    return xr.Dataset(variables, coords=coordinate)


def _plain(column: pd.Series) -> np.ndarray:
    """Return a column as Boolean, number or text array, the three kinds that netCDF and CSV keep."""
    values = column.to_numpy()
    if values.dtype.kind in "biuf":
        return values
    if all(isinstance(value, bool | np.bool_) for value in values):
        return values.astype(bool)
    return np.array(["" if value is None or value is pd.NA else str(value) for value in values], dtype=object)
