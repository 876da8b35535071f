"""The single numbers of an animal, each with its unit, symbol, equation and, where it was fitted, its 95 % interval.

Of one wall law each, and averaged over the laws by their weights.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.descriptions import LEVEL, MAX_LOG_DISTANCE, NORMAL, Parameter, Quantity
from vasowave.base.errors import InputError
from vasowave.pulse.analysis.ejection import cycle_indices
from vasowave.pulse.analysis.ventricle_coupling import Coupling
from vasowave.pulse.analysis.ventricular_function import VentricularFunction
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.cycle.harmonics import harmonic_errors
from vasowave.pulse.inference.known_errors import SHARED_SOURCES, Observed, kinds
from vasowave.pulse.model.laws import bed_factors, parameter_name, parameter_names, wall_parameters
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.names import ParameterName, joined
from vasowave.pulse.model.nominal import Nominal
from vasowave.pulse.model.parameters import with_parameters
from vasowave.pulse.model.walls import VISCOSITY, WALL_VISCOSITY
from vasowave.pulse.quantities import ACROSS_LAWS, COUPLING, LOOPS, QUANTITIES, SHARES, derived
from vasowave.pulse.selection.averaging import averaged, law_weights
from vasowave.pulse.selection.compare import Comparing, compare_models
from vasowave.study.animal.animal import Settings
from vasowave.study.animal.known_errors import effects_on_fit, effects_on_measured, spreads_of
from vasowave.study.animal.signals import Station

_LOG_STEP = 1e-4  # of the central differences, in the logarithm of a parameter
_RADII = "radius_scale"  # error of all radii


def quantities_of(law: Any, bed: Any, viscous: bool = False) -> dict[str, Quantity]:
    """Return all quantities of a model with the wall law and the beds (classes), in the order of tables."""
    described = law.law()
    ratio = {parameter_name(law, described.ratio[0]): described.ratio[1]} if described.ratio else {}
    viscosity = {WALL_VISCOSITY: Quantity(*VISCOSITY[:4])} if viscous else {}
    walls = joined(_as_quantities(wall_parameters(law)), ratio, viscosity)
    beds, ordered = _as_quantities(bed_factors(bed)), dict[str, Quantity]()
    for name, quantity in QUANTITIES.items():  # the wall's parameters stand where β does, the beds' before Δp
        ordered = joined(
            ordered, beds if name == "pressure_drop" else {}, walls if name == "beta" else {name: quantity}
        )
    return ordered


def _as_quantities(parameters: Mapping[ParameterName, Parameter]) -> dict[str, Quantity]:
    return {name: Quantity(*parameter[:4]) for name, parameter in parameters.items()}


def measured_values(
    recording: Recording, nominal: Nominal, station: Station, waves: xr.Dataset, coupled: Coupling | None = None
) -> dict[str, float]:
    """Return what the recording alone says; compliance and stiffness are the nominal ones (eqs. 8 to 12)."""
    R_T, tau = nominal.total_resistance, nominal.time_constant
    of_ventricle = {} if coupled is None else dict(zip(COUPLING, (coupled.elastance, coupled.load, coupled.ratio)))
    of_ventricle |= {} if coupled is None else {"stroke_work": coupled.stroke_work}
    return (
        recording.indices()
        | cycle_indices(recording).values
        | of_ventricle
        | {
            "pPAP_over_SV": recording.pulse_pressure / (recording.cardiac_output * recording.period),
            "Z_c": nominal.characteristic_impedance,
            "Z_0": recording.input_resistance,
            "I_R": float(waves["I_R"]),
            "beta": nominal.beta,
            "stiffness": nominal.beta,
            "wave_speed": float(station.wave_speed),
            "R_T": R_T,
            "C_T": tau / R_T,
            "tau": tau,
        }
    )


def measured_quantities(
    values: Mapping[str, float], station: Station, effects: pd.DataFrame, coupled: Coupling | None = None
) -> xr.Dataset:
    """Return `measured_values` as labelled data, with the errors that `effects_on_measured` tells."""
    errors = {str(name): (0.0, 0.0) for name, row in effects.dropna().iterrows() if row.any()}
    if coupled is not None:
        errors |= dict.fromkeys(("E_es", "coupling"), (coupled.error, NORMAL * coupled.error))
    dataset = quantities_dataset(values, QUANTITIES, errors, effects)
    dataset["wave_speed"].attrs["long_name"] = f"wave speed at {station.taken}, A Z_c/ρ"
    dataset["tau"].attrs |= {"symbol": "τ", "long_name": "time constant of the diastolic decay"}
    dataset["beta"].attrs["long_name"] = "nominal wall stiffness"
    return dataset


def loop_quantities(function: VentricularFunction) -> xr.Dataset:
    """Return what loops of pressure and volume tell by the names of `LOOPS`, with their own intervals."""
    variables = {}
    for name, estimate in function.estimates.items():
        quantity = LOOPS[f"loops_{name}"]
        attrs: dict[str, str | float] = {"units": quantity.unit, "long_name": quantity.meaning,
                                         "symbol": quantity.symbol}  # fmt: skip
        if np.isfinite(estimate.high - estimate.low):
            attrs |= {"standard_error": (estimate.high - estimate.low) / (2 * NORMAL), "interval_low": estimate.low,
                      "interval_high": estimate.high, "interval_level": LEVEL}  # fmt: skip
        variables[f"loops_{name}"] = xr.Variable((), estimate.value, attrs)
    return xr.Dataset(variables)


def model_quantities(
    fit: CalibratedModel,
    station: Station,
    waves: xr.Dataset,
    impedance: xr.Dataset,
    vessels: xr.Dataset,
    settings: Settings,
) -> xr.Dataset:
    """Return what the calibrated model says, with 95 % intervals that allow for the errors that the settings assume."""
    diastolic = vessels["diastolic_pressure"].to_numpy()
    derive = partial(derived_of, fit, diastolic=diastolic)

    def of_model(values: Mapping[str, float], model: Model, mean: float) -> dict[str, float]:
        return _with_ratio(type(model.wall), values) | derived(model, mean, diastolic)

    estimator = {str(name): float(value) for name, value in zip(impedance["estimator"].values, impedance["Z_c"].values)}
    values = station.recording.indices() | {
        **derive(_values(fit)),
        "Z_c": estimator["up-slope"],
        "Z_0": float(impedance["modulus"][0]),
        "I_R": float(waves["I_R"]),
        "pressure_drop": float(vessels["mean_drop"].mean()),
        "S": fit.S,
        "RMSE": fit.rmse,
    }
    described = quantities_of(type(fit.model.wall), type(fit.model.outlets), WALL_VISCOSITY in fit.parameters.index)
    effects = effects_on_fit(fit, settings, of_model)
    errors = errors_of(fit, derive) | errors_by(fit, effects.parameters)
    dataset = quantities_dataset(values, described, errors, effects.errors)
    bounds = _bounds(fit, settings)
    for name, value in dataset.data_vars.items():
        low, high = bounds.get(str(name), (0.0, np.inf))
        if "interval_low" in value.attrs:  # beyond its bounds a parameter is not bounded by the data
            value.attrs["interval_low"] = max(value.attrs["interval_low"], low)
            value.attrs["interval_high"] = min(value.attrs["interval_high"], high)
    return dataset


def sites_within_bounds(fit: CalibratedModel, settings: Settings) -> xr.Dataset | None:
    """Return what further sites add, with intervals that end where those of `model_quantities` do."""
    if fit.sites is None:
        return None
    ends = [_bounds(fit, settings).get(str(name), (0.0, np.inf)) for name in fit.sites["quantity"].values]
    low, high = np.array(ends).T
    bounded = {}
    for suffix in ("", "_without"):
        value, first, last = (fit.sites[f"{name}{suffix}"] for name in ("value", "low", "high"))
        bounded[first.name] = first.copy(data=np.maximum(first.values, np.minimum(low, value.values)))
        bounded[last.name] = last.copy(data=np.minimum(last.values, np.maximum(high, value.values)))
    return fit.sites.assign(bounded)


def _bounds(fit: CalibratedModel, settings: Settings) -> dict[str, tuple[float, float]]:
    """Return between what the interval of a parameter, a share or R_T lies, whatever its normal approximation says."""
    bounds = {str(name): (row["lower"], row["upper"]) for name, row in fit.parameters.iterrows()}
    highest_resistance = max(_most_resistance(fit, settings), fit.total_resistance)
    return bounds | dict.fromkeys(SHARES, (0.0, 1.0)) | {"R_T": (0.0, highest_resistance)}


def _most_resistance(fit: CalibratedModel, settings: Settings) -> float:
    """Return the upper end of the 95 % interval of pressure over flow, mmHg s/ml.

    Passive vessels take pressure: what is left for the beds is no more than all of it. How much that is hangs on
    probe and zero, and on the beats where the flow is not taken for exact: an end without them would cut off what their
    errors have widened.
    """
    observed = Observed(fit.model.network, fit.recording, fit.model.blood)
    spreads = spreads_of(fit.model.network, settings)
    moved = effects_on_measured(
        observed, spreads, lambda moved_reading: {"PVR": moved_reading.recording.vascular_resistance}
    )
    error, recording = float(np.linalg.norm(moved.fillna(0.0).to_numpy())), fit.recording
    if fit.compared.enters != "flow":
        of_flow, of_pressure = (float(harmonic_errors(recording, signal).error[0]) for signal in ("flow", "pressure"))
        shares = of_flow / recording.cardiac_output, of_pressure / (recording.mean_pressure - recording.wedge_pressure)
        error = float(np.hypot(error, np.hypot(*shares)))
    return float(recording.vascular_resistance * np.exp(NORMAL * error))


def derived_of(fit: CalibratedModel, values: Mapping[str, float], diastolic: np.ndarray) -> dict[str, float]:
    """Return the parameters `values` of a fit's model, and what follows from them without a simulation."""
    model = with_parameters(fit.model, values, fit.nominal.outlets)
    derived_values = derived(model, fit.recording.mean_pressure, diastolic)
    return _with_ratio(type(fit.model.wall), values) | derived_values


def _with_ratio(law: Any, values: Mapping[str, float]) -> dict[str, float]:
    """Return parameters, and the ratio of those of the wall that its law names."""
    ratio, wall = law.law().ratio, [values[name] for name in parameter_names(law)]
    return {**values, **({parameter_name(law, ratio[0]): wall[0] / wall[1]} if ratio else {})}


def errors_of(
    fit: CalibratedModel, derive: Callable[[Mapping[str, float]], dict[str, float]]
) -> dict[str, tuple[float, float]]:
    """Standard errors of the logarithms of all derived quantities and the half widths of their 95 % intervals.

    By the delta method from those of the parameters.
    """
    values, slopes = _values(fit), {}
    for name in fit.correlation.index:
        up, down = (derive(values | {name: values[name] * np.exp(step)}) for step in (_LOG_STEP, -_LOG_STEP))
        slopes[name] = {key: np.log(up[key] / down[key]) / (2 * _LOG_STEP) for key in up}
    return errors_by(fit, pd.DataFrame(slopes))


def errors_by(fit: CalibratedModel, slopes: pd.DataFrame) -> dict[str, tuple[float, float]]:
    """Return the same from the derivatives of the quantities' logarithms by those of the free parameters."""
    if slopes.empty:
        return {}
    names = list(fit.correlation.index)
    table = fit.parameters.loc[names]
    spread = (table["standard_error_correlated"] / table["value"]).to_numpy(float)
    cov = fit.correlation.to_numpy(float) * np.outer(spread, spread)
    slope = slopes[names].to_numpy(float)
    errors = np.sqrt(np.maximum(0.0, np.einsum("qi,ij,qj->q", slope, cov, slope)))
    return {str(name): (float(error), float(NORMAL * error)) for name, error in zip(slopes.index, errors, strict=True)}


def _values(fit: CalibratedModel) -> dict[str, float]:
    return {str(name): float(value) for name, value in fit.parameters["value"].items()}


def quantities_dataset(
    values: Mapping[str, float],
    quantities: Mapping[str, Quantity],
    errors: Mapping[str, tuple[float, float]] | None = None,
    effects: pd.DataFrame | None = None,
) -> xr.Dataset:
    """Return the values as labelled scalars, in the order of `quantities`.

    `errors` are as from `errors_of`; `effects`, by quantity and unknown, are what one SD of each known error moves in
    its logarithm. Of these come the shares of the variance that animals may share, and ``per_radius``, the change of
    the logarithm per change of the logarithm of all radii.
    """
    variables = {}
    known_effects = pd.DataFrame() if effects is None or effects.empty else effects.dropna()
    for name, quantity in quantities.items():
        if name not in values:
            continue
        value = float(values[name])
        attrs: dict[str, str | float] = {
            "units": quantity.unit,
            "long_name": quantity.meaning,
            "symbol": quantity.symbol,
        }
        if quantity.equation:
            attrs["equation"] = quantity.equation
        error, reach = (errors or {}).get(name, (np.nan, np.nan))
        if name in known_effects.index:
            squares = pd.Series(known_effects.loc[name].to_numpy(float) ** 2, known_effects.columns)
            variance = float(squares.to_numpy().sum())
            error, reach = float(np.sqrt(error**2 + variance)), float(np.sqrt(reach**2 + NORMAL**2 * variance))
            sources = np.array([kinds()[str(unknown)].source for unknown in squares.index])
            shared = {source: float(squares[sources == source].to_numpy().sum()) for source in SHARED_SOURCES}
            attrs |= {f"share_{source}": share / error**2 for source, share in shared.items() if error > 0}
            if spread := known_effects.attrs.get("sd", {}).get(_RADII):
                attrs["per_radius"] = float(known_effects[_RADII][name]) / spread
        if np.isfinite(error) and np.isfinite(reach):
            factor = float(np.exp(min(reach, MAX_LOG_DISTANCE)))
            attrs |= {"standard_error": value * error, "interval_low": value / factor, "interval_high": value * factor}
            attrs["interval_level"] = LEVEL
        variables[name] = xr.Variable((), value, attrs)
    return xr.Dataset(variables)


def compared_laws(
    fits: Sequence[CalibratedModel], settings: Settings, quantities: Mapping[str, xr.Dataset]
) -> dict[str, xr.Dataset | None]:
    """Return AICc and BIC of every wall law, ``selection``, and the ``averages`` of `quantities` over the laws."""
    selection = compare_models(fits, Comparing(settings.noise_models, seed=settings.seed))
    return {"selection": selection, "averages": averages_dataset(selection, quantities)}


def averages_dataset(selection: xr.Dataset, quantities: Mapping[str, xr.Dataset]) -> xr.Dataset | None:
    """Return the quantities averaged over the laws by their weights, None if no noise model gives weights.

    Parameters
    ----------
    selection : Dataset
        From `compare_models`.
    quantities : mapping of str to Dataset
        Those of each wall law.

    Returns
    -------
    Dataset
        ``weight`` by ``covariance`` and ``wall``, and each quantity of `ACROSS_LAWS`, with its 95 % interval and
        ``between_laws`` (the share of its variance that lies between laws) as attributes: the laws weighted under the
        likeliest noise model, which stands first, is named in the attribute ``covariance`` and makes the weights.
    """
    try:
        weights = law_weights(selection)
    except InputError:
        return None
    first = weights.isel(covariance=0)
    laws = [str(wall) for wall in first["wall"].values]
    values: dict[str, xr.Variable | xr.DataArray] = {"weight": weights}
    for name in (quantity for quantity in ACROSS_LAWS if all(quantity in quantities[wall] for wall in laws)):
        law_values = [quantities[wall][name] for wall in laws]
        if all(_log_error(value) is not None for value in law_values):
            values[name] = _mean_of_laws(law_values, first.values)
    scope = "the recording's error and the model's discrepancy within each law, and the choice between these laws"
    return xr.Dataset(values, attrs={"covariance": str(first["covariance"].values), "interval_holds": scope})


def _mean_of_laws(law_values: list[xr.DataArray], weights: np.ndarray) -> xr.Variable:
    errors = [error for value in law_values if (error := _log_error(value)) is not None]
    mean = averaged([float(value) for value in law_values], errors, list(weights))
    attrs = {name: law_values[0].attrs[name] for name in ("units", "long_name", "symbol")}
    high = min(mean.high, 1.0) if law_values[0].name in SHARES else mean.high
    attrs |= {"interval_low": mean.low, "interval_high": high, "interval_level": LEVEL}
    return xr.Variable((), mean.value, attrs | {"between_laws": mean.between})


def _log_error(quantity: xr.DataArray) -> float | None:
    """Standard error of the logarithm of a quantity, None where it is not known."""
    error = quantity.attrs.get("standard_error", 0.0) / float(quantity)
    return float(error) if error > 0 else None
