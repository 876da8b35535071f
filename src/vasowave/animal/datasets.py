"""Calibrations as labelled data: one netCDF-4 file with groups, every variable with its unit.

::

    /                        provenance
    ├── network              topology and morphometry, by vessel
    ├── recording            measured pressure and flow, hemodynamic indices
    ├── nominal              what the fit started from
    └── linear, tangent, …   one group per wall law
        ├── calibration      parameters, correlations, starts, residuals, outlets
        └── simulation       pressure, flow, area by time, vessel, station; numerics in the attributes
"""

import json
from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.calibration.parameters import fitted_parameters
from vasowave.calibration.result import Fit
from vasowave.columns import split_unit
from vasowave.findings import as_json
from vasowave.network import MEASURED, Network
from vasowave.nominal import Nominal
from vasowave.outlets import Windkessel
from vasowave.recording import Recording
from vasowave.recording.cycle import INDEX_UNITS

OUTLET_UNITS = {name: what.unit for name, what in Windkessel.quantities().items()}

_KNOWN = {
    "radius_sd": ("cm", "standard deviation of the radius, NaN where not known"),
    "taper": ("1", "fall of the radius along the vessel, NaN where not measured"),
    "taper_sd": ("1", "standard deviation of the taper"),
}


def network_dataset(network: Network) -> xr.Dataset:
    """Return topology and morphometry by vessel; the root's parent is empty."""
    parents = [network.name[row] if row >= 0 else "" for row in network.parent]
    known = {field: getattr(network, field) for field in MEASURED if getattr(network, field) is not None}
    return xr.Dataset(
        {
            "parent": ("vessel", np.array(parents, dtype=object), {"long_name": "name of the parent vessel"}),
            "length": _variable("vessel", network.length, "cm", "length"),
            "radius": _variable("vessel", network.radius, "cm", "radius at the pressure of the image"),
            "image_pressure": _variable((), network.pressure, "mmHg", "pressure of the image, 0 where not known"),
            "flow_fraction": _variable("vessel", network.flow_fraction, "1", "share of the root's mean flow (eq. 11)"),
            **{field: _variable("vessel", values, *_KNOWN[field]) for field, values in known.items()},
        },
        coords={"vessel": np.array(network.name, dtype=object)},
    )


def recording_dataset(recording: Recording) -> xr.Dataset:
    """Return measured pressure and flow on their own time axes, and the indices of Table 1."""
    flow_time = np.arange(len(recording.flow)) * (recording.period / len(recording.flow))
    measured = {
        "pressure": _variable("time", recording.pressure, "mmHg", "measured pressure"),
        "flow": _variable("flow_time", recording.flow, "ml/s", "measured flow"),
    }
    for name, unit in (("pressure", "mmHg"), ("flow", "ml/s")):
        if (error := getattr(recording, f"{name}_error")) is not None:
            words = f"standard error of the amplitude of each harmonic of the {name}, the mean first"
            measured[f"{name}_error"] = _variable(f"{name}_harmonic", error, unit, words)
    indices = {name: _variable((), value, INDEX_UNITS[name], name) for name, value in recording.indices().items()}
    return xr.Dataset(
        measured | indices,
        coords={
            "time": _variable("time", recording.time, "s", "time of the pressure samples"),
            "flow_time": _variable("flow_time", flow_time, "s", "time of the flow samples"),
        },
        attrs={"period": recording.period, "source": recording.source, "findings": as_json(recording.notes)},
    )


def nominal_dataset(nominal: Nominal, network: Network) -> xr.Dataset:
    """Return the nominal parameters and the samples behind Z_c and τ."""
    (flow, pressure), (time, falling) = nominal.upstroke, nominal.decay
    return xr.Dataset(
        {
            "Z_c": _variable((), nominal.characteristic_impedance, "mmHg s/ml", "characteristic impedance (eq. 8)"),
            "beta": _variable((), nominal.beta, "mmHg", "nominal stiffness (eq. 9)"),
            "R_T": _variable((), nominal.total_resistance, "mmHg s/ml", "nominal total resistance"),
            "tau": _variable((), nominal.time_constant, "s", "time constant of the diastolic decay (eq. 12)"),
            "upstroke_flow": _variable("upstroke", flow, "ml/s", "flow of the samples behind Z_c"),
            "upstroke_pressure": _variable("upstroke", pressure, "mmHg", "pressure of the samples behind Z_c"),
            "decay_time": _variable("decay", time, "s", "time of the samples behind tau"),
            "decay_pressure": _variable("decay", falling, "mmHg", "pressure of the samples behind tau"),
            **_outlets(nominal.outlets),
        },
        coords=_terminals(network),
    )


def calibration_dataset(fit: Fit) -> xr.Dataset:
    """Return everything a fit found but its simulation."""
    units = dict(fit.parameters["unit"])
    starts = table_dataset(fit.starts, "start", units).drop_vars("start", errors="ignore")
    starts = starts.rename({str(name): f"start_{name}" for name in starts.data_vars})
    parameters = table_dataset(fit.parameters.rename_axis("parameter").reset_index(), "parameter")
    correlation = xr.Dataset(
        {"correlation": (("free_parameter", "other_parameter"), fit.correlation.to_numpy(float), {"units": "1"})},
        coords={
            "free_parameter": np.array(fit.correlation.index, dtype=object),
            "other_parameter": np.array(fit.correlation.columns, dtype=object),
        },
    )
    for name in ("symbol", "meaning"):
        kept = [getattr(one, name) for one in fitted_parameters(type(fit.model.wall)).values()]
        parameters[name] = ("parameter", np.array(kept, dtype=object))
    parts = [_fitted(fit), parameters, correlation, starts, harmonics_dataset(fit)]
    return xr.merge(parts, combine_attrs="override", join="exact")


def _fitted(fit: Fit) -> xr.Dataset:
    """Return the model that was fitted, the numbers that sum it up, its residual, and what is said of its law."""
    law, wall = fit.model.wall.law(), fit.model.wall
    walls = {
        name: _variable("vessel", value, what.unit, what.meaning)
        for name, value, what in zip(wall._fields, wall, law.parameters, strict=True)
    }
    return xr.Dataset(
        {
            **walls,
            **_outlets(fit.model.outlets),  # type: ignore[arg-type]
            **scalars(fit),
            "pressure_residual": _variable("time", fit.pressure_residual, "mmHg", "measured minus simulated pressure"),
        },
        coords={
            "vessel": np.array(fit.model.network.name, dtype=object),
            "time": _variable("time", fit.compared.time, "s", "time of the compared pressure samples"),
            **_terminals(fit.model.network),
        },
        attrs={
            "wall": fit.wall,
            "title": law.title,
            "formula": law.formula,
            "equation": law.equation,
            "stiffness": law.stiffness,
            "warnings": json.dumps(fit.warnings),
            **_blood(fit),
        },
    )


def harmonics_dataset(fit: Fit) -> xr.Dataset:
    """Return measured pressure, its error, residual and discrepancy by harmonic, and which were compared and why."""
    meanings = {
        "measured_modulus": "modulus of the measured pressure",
        "measurement_error": "expected modulus of the error of the measurement",
        "residual_modulus": "modulus of the residual",
        "discrepancy": "modulus of the residual beyond the error of the measurement",
    }
    table = fit.harmonics
    variables = {name: _variable("harmonic", table[name].to_numpy(), "mmHg", text) for name, text in meanings.items()}
    compared = fit.compared
    variables["harmonics"] = _variable(
        (), compared.harmonics, "1", "highest harmonic of the pressure that was compared"
    )
    variables["harmonics"].attrs |= {
        "choice": compared.choice,
        "with_signal": compared.errors.with_signal,
        "error_source": compared.errors.source,
        "said": " ".join(compared.sentences()),
    }
    return xr.Dataset(variables, coords={"harmonic": ("harmonic", table.index.to_numpy(), {"units": "1"})})


def scalars(fit: Fit) -> dict[str, xr.Variable]:
    """Return the numbers that sum up a fit: S, N, RMSE, R_T, a, C_p."""
    return {
        "S": _variable((), fit.S, "mmHg2", "objective at the optimum (eq. 14)"),
        "N": _variable((), fit.N, "1", "number of pressure samples compared"),
        "mean_square": _variable((), fit.mean_square, "mmHg2", "S/N, mean square of the pressure residual"),
        "RMSE": _variable((), fit.rmse, "mmHg", "root-mean-square pressure residual"),
        "R_T": _variable((), fit.total_resistance, "mmHg s/ml", "total resistance of the vascular beds"),
        "a": _variable((), fit.resistance_ratio, "1", "resistance ratio R1/R_T"),
        "C_p": _variable((), fit.peripheral_compliance, "ml/mmHg", "weighted compliance of the vascular beds"),
    }


def table_dataset(frame: pd.DataFrame, dim: str, units: dict[str, str] | None = None) -> xr.Dataset:
    """Return the columns of `frame` as variables along `dim`; a column ``S [mmHg2]`` becomes S with that unit."""
    variables: dict[str, xr.Variable] = {}
    for label in frame.columns:
        name, unit = split_unit(str(label))
        unit = unit or (units or {}).get(name, "")
        variables[name] = xr.Variable(dim, plain(frame[label]), {"units": unit} if unit else {})
    coordinate = {dim: variables.pop(dim)} if dim in variables else {}
    return xr.Dataset(variables, coords=coordinate)


def plain(column: pd.Series) -> np.ndarray:
    """Return a column as Boolean, number or text array, the three kinds that netCDF and CSV keep."""
    values = column.to_numpy()
    if values.dtype.kind in "biuf":
        return values
    if all(isinstance(value, bool | np.bool_) for value in values):
        return values.astype(bool)
    return np.array(["" if value is None or value is pd.NA else str(value) for value in values], dtype=object)


def _variable(dims: str | tuple[str, ...], values: Any, unit: str, meaning: str) -> xr.Variable:
    return xr.Variable(dims, values, {"units": unit, "long_name": meaning})


def _terminals(network: Network) -> dict[str, Any]:
    return {"terminal": ("terminal", np.array([network.name[row] for row in network.terminals], dtype=object))}


def _outlets(outlets: Windkessel) -> dict[str, xr.Variable]:
    return {
        name: _variable("terminal", getattr(outlets, name), what.unit, what.meaning)
        for name, what in outlets.quantities().items()
    }


def _blood(fit: Fit) -> dict[str, Any]:
    blood = fit.model.blood
    friction = {"law": type(blood.friction).__name__, **asdict(blood.friction)}  # type: ignore[call-overload]
    return {
        "blood_density_g_per_ml": blood.density,
        "blood_viscosity_cm2_per_s": blood.viscosity,
        "friction": json.dumps(friction),
    }


def _with_plain_attributes(simulation: xr.Dataset) -> xr.Dataset:
    """Return the simulation with Boolean attributes as integers, which netCDF can hold."""
    attributes = {
        key: int(value) if isinstance(value, bool | np.bool_) else value for key, value in simulation.attrs.items()
    }
    return simulation.assign_attrs(attributes)
