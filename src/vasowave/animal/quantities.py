"""The single numbers of an animal, each with its unit, symbol, equation and, where it was fitted, its 95 % interval."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from vasowave.analysis import compliance
from vasowave.animal.signals import Station
from vasowave.calibration import Fit
from vasowave.descriptions import Quantity
from vasowave.model import Model
from vasowave.noise.spectrum import LEVEL, NORMAL
from vasowave.nominal import Nominal
from vasowave.outlets import Windkessel
from vasowave.recording import Recording
from vasowave.walls import area_compliance, stiffness, wave_speed

_RESISTANCE, _COMPLIANCE = "mmHg s/ml", "ml/mmHg"

QUANTITIES: dict[str, Quantity] = {
    "HR": Quantity("beats/min", "HR", "heart rate", "Table 1"),
    "CO": Quantity("ml/s", "CO", "cardiac output", "Table 1"),
    "mPAP": Quantity("mmHg", "mPAP", "mean pressure", "Table 1"),
    "sPAP": Quantity("mmHg", "sPAP", "systolic pressure", "Table 1"),
    "dPAP": Quantity("mmHg", "dPAP", "diastolic pressure", "Table 1"),
    "pPAP": Quantity("mmHg", "pPAP", "pulse pressure", "Table 1"),
    "PVR": Quantity(_RESISTANCE, "PVR", "total pulmonary vascular resistance, mean pressure over mean flow", "Table 1"),
    "Z_c": Quantity(_RESISTANCE, "Z_c", "characteristic impedance, up-slope", "8"),
    "Z_0": Quantity(_RESISTANCE, "Z_0", "impedance at zero frequency", "19"),
    "I_R": Quantity("1", "I_R", "wave reflection coefficient", "17"),
    "beta": Quantity("mmHg", "β", "wall stiffness", "3"),
    "stiffness": Quantity("mmHg", "β(0)", "stiffness β of the linear law with the same slope at zero pressure", "24"),
    "wave_speed": Quantity("cm/s", "c", "wave speed in the root at the measured mean pressure", "31, 32"),
    "area_compliance": Quantity(
        "cm2/mmHg", "dA/dp", "area compliance of the root at the measured mean pressure", "26, 27"
    ),
    "R_T": Quantity(_RESISTANCE, "R_T", "total resistance of the vascular beds", "11"),
    "a": Quantity("1", "a = R_1/R_T", "resistance ratio", "7"),
    "C_p": Quantity(_COMPLIANCE, "C_p", "weighted compliance of the vascular beds", "30"),
    "C_v": Quantity(_COMPLIANCE, "C_v", "compliance of the network, series/parallel rule", "28, 29"),
    "C_v_plain": Quantity(_COMPLIANCE, "ΣC", "compliance of the network, sum over vessels", "25"),
    "C_T": Quantity(_COMPLIANCE, "C_T", "total compliance, with C_v by the series/parallel rule", "30"),
    "C_T_plain": Quantity(_COMPLIANCE, "C_T (sum)", "total compliance, with the sum over vessels", "30"),
    "C_p_over_C_T": Quantity("1", "C_p/C_T", "share of the beds in the total compliance", "30"),
    "C_p_over_C_T_plain": Quantity("1", "C_p/C_T (sum)", "share of the beds, with the sum over vessels", "30"),
    "tau": Quantity("s", "τ", "time constant: of the diastolic decay if measured, R_T C_T of a model", "12"),
    "tau_plain": Quantity("s", "τ (sum)", "time constant R_T C_T, with the sum over vessels", "12"),
    "pressure_drop": Quantity("mmHg", "Δp", "fall of the mean pressure to the terminals, their average"),
    "S": Quantity("mmHg2", "S", "objective at the optimum", "14"),
    "RMSE": Quantity("mmHg", "RMSE", "root-mean-square pressure residual"),
}
"""All quantities by the name of their variable; a wall law and the outlets own theirs, see `quantities_of`."""

_LOG_STEP = 1e-4  # of the central differences, in the logarithm of a parameter
_FARTHEST = 200.0  # in the logarithm: an endless interval stays a finite number


SHARES = ("a", "C_p_over_C_T", "C_p_over_C_T_plain")
"""Quantities that cannot exceed 1."""


def quantities_of(law: Any) -> dict[str, Quantity]:
    """Return all quantities of a model with the wall law (its class), in the order of tables."""
    said = law.law()
    own = {name: Quantity(*one[:4]) for name, one in zip(law._fields, said.parameters, strict=True)}
    factors = {name: Quantity(*one[:4]) for name, one in Windkessel.factors().items()}
    names = list(QUANTITIES)
    before, after = names[: names.index("beta")], names[names.index("stiffness") : names.index("pressure_drop")]
    known = {name: QUANTITIES[name] for name in names if name != "beta"}
    ordered = [*before, *own, *dict([said.ratio] if said.ratio else []), *after, *factors, *names]
    every = known | own | dict([said.ratio] if said.ratio else []) | factors
    return {name: every[name] for name in dict.fromkeys(ordered) if name in every}


def measured_quantities(recording: Recording, nominal: Nominal, station: Station, waves: xr.Dataset) -> xr.Dataset:
    """Return what the recording alone says; compliance and stiffness are the nominal ones (eqs. 8 to 12)."""
    R_T, tau = nominal.total_resistance, nominal.time_constant
    values = recording.indices() | {
        "Z_c": nominal.characteristic_impedance,
        "Z_0": recording.vascular_resistance,
        "I_R": float(waves["I_R"]),
        "beta": nominal.beta,
        "stiffness": nominal.beta,
        "wave_speed": float(station.wave_speed),
        "R_T": R_T,
        "C_T": tau / R_T,
        "tau": tau,
    }
    dataset = quantities_dataset(values, QUANTITIES)
    dataset["wave_speed"].attrs["long_name"] = f"wave speed at {station.taken}, A Z_c/ρ"
    dataset["beta"].attrs["long_name"] = "nominal wall stiffness"
    return dataset


def model_quantities(
    fit: Fit, station: Station, waves: xr.Dataset, impedance: xr.Dataset, vessels: xr.Dataset
) -> xr.Dataset:
    """Return what the calibrated model says; what follows from the parameters alone carries its 95 % interval."""
    diastolic, mean = vessels["diastolic_pressure"].to_numpy(), fit.recording.mean_pressure

    def derive(values: Mapping[str, float]) -> dict[str, float]:
        return derived(model_of(fit, values), values, diastolic, mean)

    parameters = _values(fit)
    estimator = {str(name): float(value) for name, value in zip(impedance["estimator"].values, impedance["Z_c"].values)}
    values = station.recording.indices() | {
        **derive(parameters),
        "Z_c": estimator["up-slope"],
        "Z_0": float(impedance["modulus"][0]),
        "I_R": float(waves["I_R"]),
        "pressure_drop": float(vessels["mean_drop"].mean()),
        "S": fit.S,
        "RMSE": fit.rmse,
    }
    dataset = quantities_dataset(values, quantities_of(type(fit.model.wall)), errors_of(fit, derive))
    bounds = {str(name): (row["lower"], row["upper"]) for name, row in fit.parameters.iterrows()}
    for name, value in dataset.data_vars.items():
        low, high = bounds.get(str(name), (0.0, 1.0 if name in SHARES else np.inf))
        if "interval_low" in value.attrs:  # beyond its bounds a parameter is not bounded by the data
            value.attrs["interval_low"] = max(value.attrs["interval_low"], low)
            value.attrs["interval_high"] = min(value.attrs["interval_high"], high)
    return dataset


def derived(model: Model, values: Mapping[str, float], diastolic: np.ndarray, mean: float) -> dict[str, float]:
    """Return the parameters and what follows from them without a simulation.

    Parameters
    ----------
    model : Model
        With one value of every wall parameter for all vessels.
    values : mapping
        Its parameters.
    diastolic : array, shape (vessel,)
        Diastolic pressure of the vessels, mmHg, at which their compliance is taken.
    mean : float
        Pressure at which the wave speed is taken, mmHg.
    """
    quantities = dict(values)
    at_diastole = compliance(model, diastolic)
    speed = np.asarray(wave_speed(model.wall, mean, model.blood.inertia))
    slope = np.asarray(area_compliance(model.wall, mean, model.area0))
    if ratio := model.wall.law().ratio:
        first, second = model.wall._fields
        quantities[ratio[0]] = values[first] / values[second]
    return quantities | {
        "stiffness": float(np.broadcast_to(stiffness(model.wall), len(model.network))[model.network.root]),
        "wave_speed": float(speed[model.network.root]),
        "area_compliance": float(slope[model.network.root]),
        "R_T": model.outlets.total_resistance(),
        "a": model.outlets.resistance_ratio(),
        "C_p": at_diastole.peripheral,
        "C_v": at_diastole.network_published,
        "C_v_plain": at_diastole.network_sum,
        "C_T": at_diastole.total(),
        "C_T_plain": at_diastole.total(published=False),
        "C_p_over_C_T": at_diastole.peripheral_share(),
        "C_p_over_C_T_plain": at_diastole.peripheral_share(published=False),
        "tau": at_diastole.time_constant(),
        "tau_plain": at_diastole.time_constant(published=False),
    }


def model_of(fit: Fit, values: Mapping[str, float]) -> Model:
    """Return the model of a fit with other values of its parameters."""
    wall = type(fit.model.wall)(*(values[name] for name in fit.model.wall._fields))
    outlets = fit.nominal.outlets.scaled(*(values[name] for name in Windkessel.factors()))
    return Model(fit.model.network, wall, outlets, fit.model.blood)


def errors_of(fit: Fit, derive: Callable[[Mapping[str, float]], dict[str, float]]) -> dict[str, tuple[float, float]]:
    """Standard errors of the logarithms of all derived quantities and the half widths of their 95 % intervals.

    By the delta method from those of the parameters.
    """
    names = list(fit.correlation.index)
    table = fit.parameters.loc[names]
    spread = (table["standard_error_correlated"] / table["value"]).to_numpy(float)
    cov = fit.correlation.to_numpy(float) * np.outer(spread, spread)
    values = _values(fit)
    up = [derive(values | {name: values[name] * np.exp(_LOG_STEP)}) for name in names]
    down = [derive(values | {name: values[name] * np.exp(-_LOG_STEP)}) for name in names]
    errors = {}
    for key in up[0]:
        slope = np.array([np.log(one[key] / other[key]) / (2 * _LOG_STEP) for one, other in zip(up, down)])
        error = float(np.sqrt(max(0.0, slope @ cov @ slope)))
        errors[key] = (error, NORMAL * error)
    return errors


def _values(fit: Fit) -> dict[str, float]:
    return {str(name): float(value) for name, value in fit.parameters["value"].items()}


def quantities_dataset(
    values: Mapping[str, float],
    quantities: Mapping[str, Quantity],
    errors: Mapping[str, tuple[float, float]] | None = None,
) -> xr.Dataset:
    """Return the values as labelled scalars, in the order of `quantities`; `errors` as from `errors_of`."""
    variables = {}
    for name, what in quantities.items():
        if name not in values:
            continue
        value = float(values[name])
        attrs: dict[str, str | float] = {"units": what.unit, "long_name": what.meaning, "symbol": what.symbol}
        if what.equation:
            attrs["equation"] = what.equation
        error, reach = (errors or {}).get(name, (np.nan, np.nan))
        if np.isfinite(error) and np.isfinite(reach):
            factor = float(np.exp(min(reach, _FARTHEST)))
            attrs |= {"standard_error": value * error, "interval_low": value / factor, "interval_high": value * factor}
            attrs["interval_level"] = LEVEL
        variables[name] = xr.Variable((), value, attrs)
    return xr.Dataset(variables)
