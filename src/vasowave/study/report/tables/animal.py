"""Tables of one animal: its values beside what was measured, estimates, correlations, starts, numerics."""

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.pulse.inference.known_errors import SOURCES
from vasowave.study.animal.law_result import PosteriorResult
from vasowave.study.animal.result import AnimalResult
from vasowave.study.report.blocks import Table
from vasowave.study.report.tables.cells import with_unit
from vasowave.study.report.tables.models import MARKS, mark
from vasowave.study.report.wording import Row, number, unit, value_text

_NUMERICS = {
    "period": ("period", "s"),
    "cycles": ("simulated cycles", ""),
    "change": ("largest change over the last cycle", "mmHg"),
    "tolerance": ("change that counts as periodic", "mmHg"),
    "converged": ("periodic", ""),
    "courant": ("largest Courant number", ""),
    "steps_per_cycle": ("time steps per cycle", ""),
    "cell_size": ("longest cell", "cm"),
    "volume_error": ("volume out of balance over a cycle, relative", ""),
}


def values(result: AnimalResult, written: dict[str, str]) -> Table:
    """Return every single number: measured, and of each wall law with its 95 % interval where it is known."""
    by_source = {source: result.sources[source].quantities for source in result.sources}
    fits = {wall: result.laws[wall].calibration for wall in result.laws}
    rows: list[Row] = []
    for name in dict.fromkeys(str(name) for data in by_source.values() for name in data.data_vars):
        units = next(str(data.variables[name].attrs.get("units", "1")) for data in by_source.values() if name in data)
        cells = [_value(data[name], fits.get(source)) if name in data else "" for source, data in by_source.items()]
        rows.append((with_unit(f"{name} [{units}]", written), *cells))
    header = ("quantity", "measured", *(f"{wall} wall" for wall in result.laws))
    note = (
        "Measured: the indices, and nominal values; β and c follow from the up-slope, τ of the diastolic decay stands "
        f"in the row of R_T C_T, R_T is mean pressure (above the wedge's) over mean flow. {MARKS}"
    )
    return Table("", "Values, measured and calibrated [95 % interval]", header, rows, note)


def estimates(result: AnimalResult, wall: str, written: dict[str, str]) -> Table:
    """Return what the search for the parameters of one wall law came to."""
    data = estimates_frame(result, wall)
    symbols = data["parameter"].map(lambda name: written.get(name, name))
    shown = data.assign(parameter=symbols, unit=data["unit"].map(unit))
    shown = shown.drop(columns=["symbol", "meaning"], errors="ignore")
    shown.columns = shown.columns.str.replace("_", " ")
    return Table.from_frame("", f"{wall.capitalize()} wall: the parameters and their search", shown)


def posterior(wall: str, posterior_result: PosteriorResult, written: dict[str, str]) -> Table:
    """Return what the posterior of one wall law says of every quantity, and where its uncertainty comes from."""
    data = posterior_result.table
    header = (
        "quantity",
        "median [95 %]",
        "assumed before [95 %]",
        *(f"from {source}" if source != "prior" else "assumed" for source in SOURCES),
    )
    rows: list[Row] = []
    for name in data["quantity"].values:
        row = data.sel(quantity=name)
        value, before = f"{number(float(row['median']))} {_ends(row, 'interval')}", _ends(row, "prior")
        shares = [float(row.get(f"share_{source}", np.nan)) for source in SOURCES]
        cells = ["" if np.isnan(share) else f"{100 * share:.0f} %" for share in shares]
        rows.append((with_unit(f"{name} [{row['unit'].item()}]", written), value, before, *cells))
    trusted = "the sampling succeeded" if posterior_result.trusted else "do not believe these numbers"
    note = (
        "Parameters, geometry and the model's own error are unknown together; the shares say where the variance comes "
        f"from. Pareto k {float(data['k_hat']):.2f}, {float(data['effective']):.0f} effective draws, two halves "
        f"{float(data['halves_apart']):.1f} SD apart: {trusted}."
    )
    return Table("", f"{wall.capitalize()} wall: posterior", header, rows, note)


def _ends(row: xr.Dataset, prefix: str) -> str:
    return f"[{number(float(row[f'{prefix}_low']))}, {number(float(row[f'{prefix}_high']))}]"


def correlations(result: AnimalResult, wall: str, written: dict[str, str]) -> Table:
    """Return the correlation of the estimates of one wall law."""
    matrix = result.laws[wall].calibration["correlation"]
    names = [written.get(str(name), str(name)) for name in matrix["free_parameter"].values]
    rows = [(name, *(f"{value:.2f}" for value in row)) for name, row in zip(names, matrix.values, strict=True)]
    return Table("", f"{wall.capitalize()} wall: correlation of the estimates", (" ", *names), rows)


def starts(result: AnimalResult, wall: str) -> Table:
    """Return where every start of the search ended."""
    return Table.from_frame("", f"{wall.capitalize()} wall: starts of the search", starts_frame(result, wall), digits=4)


def numerics(result: AnimalResult) -> Table:
    """Return settings and checks of the simulations, one column per wall law."""
    by_wall = {wall: result.laws[wall].simulation.attrs for wall in result.laws}
    rows: list[Row] = []
    for key in dict.fromkeys(str(key) for attrs in by_wall.values() for key in attrs if key != "wall"):
        cells = [_setting(key, attrs.get(key)) for attrs in by_wall.values()]
        rows.append((*_NUMERICS.get(key, (key.replace("_", " "), "")), *cells))
    header = ("setting", "unit", *(f"{wall} wall" for wall in by_wall))
    return Table("", "Settings and checks of the simulations", header, rows)


def estimates_frame(result: AnimalResult, wall: str) -> pd.DataFrame:
    """Return parameters, bounds, values and errors of one calibration in full precision."""
    fit = result.laws[wall].calibration
    along = [
        str(name) for name, value in fit.variables.items() if value.dims == ("parameter",) and name in fit.data_vars
    ]
    order = ["unit", *(name for name in along if name != "unit")]
    return pd.DataFrame({"parameter": fit["parameter"].values, **{name: fit.variables[name].values for name in order}})


def starts_frame(result: AnimalResult, wall: str) -> pd.DataFrame:
    """Return where every start ended in full precision, units in the column names."""
    fit = result.laws[wall].calibration
    count = {"start": np.arange(fit.sizes["start"])}
    columns = {}
    for name, value in fit.variables.items():
        if value.dims == ("start",) and name in fit.data_vars:
            units = value.attrs.get("units", "")
            label = str(name).removeprefix("start_")
            columns[f"{label} [{units}]" if units else label] = value.values
    return pd.DataFrame(count | columns)


def _value(value: xr.DataArray, fit: xr.Dataset | None) -> str:
    return value_text(value, with_unit=False) + ("" if fit is None else mark(fit, str(value.name)))


def _setting(key: str, value: object) -> str:
    return ("yes" if value else "no") if key == "converged" else number(value)
