"""What the Explorer shows: the fitted model of an animal, what it does when its parameters are moved, and models that
the data allow: drawn about a fit from its errors, or the draws of its posterior.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vasowave.base.errors import InputError
from vasowave.base.findings import texts
from vasowave.base.io.remembered import remembered
from vasowave.pulse.analysis.impedance_spectrum import fourier_series
from vasowave.pulse.analysis.operating import operating_point
from vasowave.pulse.analysis.prediction import predict
from vasowave.pulse.analysis.waves import wave_intensity
from vasowave.pulse.cycle.cycle import Recording, resample
from vasowave.pulse.model import walls
from vasowave.pulse.model.laws import parameter_names, wall_parameters
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.names import joined
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.outlets import Bed
from vasowave.pulse.model.parameters import changed_model, model_values, with_parameters
from vasowave.pulse.model.walls import WALL_VISCOSITY
from vasowave.pulse.solver.result import Run
from vasowave.pulse.solver.simulation import simulate_run, simulate_runs
from vasowave.study.animal.law_result import PosteriorResult
from vasowave.study.animal.result import AnimalResult
from vasowave.study.animal.stored import stored_fit, stored_law, stored_model, stored_recording
from vasowave.study.figures.matplotlib_style import color_stops
from vasowave.study.figures.network import axes_in_space
from vasowave.study.results.results import read_results
from vasowave.workbench.desk import Desk
from vasowave.workbench.values import INDEX_UNITS, number, numbers

BANDS = ("pressure", "forward", "backward", "modulus")
"""Curves of which a band is drawn."""

_PANELS = {
    "pressure": "pressure [mmHg] at the inlet by time [ms]",
    "flow": "flow [ml/s] at the inlet by time [ms]",
    "loop": "pressure [mmHg] by flow [ml/s]",
    "waves": "forward and backward pressure wave [mmHg]",
    "modulus": "impedance modulus [mmHg s/ml] by harmonic",
}
_COLORS = ("mean pressure [mmHg]", "pulse pressure [mmHg]", "mean flow [ml/s]", "wave speed [cm/s]")  # of vessels
_MOVING_COLORS = ("pressure [mmHg]", "flow [ml/s]")  # of vessels at an instant

_SIZES: dict[Any, str] = {"radius": "factor of all radii", "length": "factor of all lengths"}
_CURVE_SAMPLES = 128  # samples of a curve
_HARMONICS = 10
_SLIDER_FACTOR = 3.0  # a slider reaches so many times down and up from the fit
_MAX_FACTOR, _MAX_SIZE_FACTOR = 1000.0, 10.0  # times; a value beyond is a slip, and a vessel as long takes minutes
_FRAMES = 32  # instants of the tree
_DRAWS = 40  # models about a fit
_PREDICTED_DRAWS = 40  # models that are simulated before and after a change
_SLIP = 1e-9  # of a factor: less is no change
_MAX_WALKED_DRAWS = 100  # draws of a posterior, of all that there are


class _Fitted(NamedTuple):
    result: AnimalResult
    model: Model
    recording: Recording


@remembered
def _fitted_in(_: Path, folder: Path, animal: str, law: str) -> _Fitted:
    result = read_results(folder)[animal]
    return _Fitted(result, stored_model(result, law), stored_recording(result))


class Explorer:
    """Fitted models of a study."""

    def fitted(self, desk: Desk, animal: str, law: str) -> _Fitted:
        """Return the stored result of an animal with its model."""
        return _fitted_in(_file(desk, animal), desk.stored().folder, animal, law)

    def described(self, desk: Desk, animal: str, law: str) -> dict[str, Any]:
        """Return the model of an animal: what can be moved and how far, what was measured, its tree."""
        result, model, recording = self.fitted(desk, animal, law)
        name, _ = stored_law(result, law)
        network = model.network
        return {
            "animal": animal,
            "group": result.group,
            "made": _file(desk, animal).stat().st_mtime_ns,
            "law": name,
            "laws": list(result.laws),
            "formula": result.laws[name].formula,
            "knobs": _knobs(result, model, name),
            "measured": {"pressure": _curve(recording.pressure), "flow": _curve(recording.flow),
                         "period": recording.period, "modulus": _modulus(recording)},
            "tree": {"names": list(network.name), "axes": np.round(axes_in_space(network), 5).tolist(),
                     "radius": numbers(network.radius), "root": network.root},
            "stops": color_stops(9),
            "panels": _PANELS,
            "units": INDEX_UNITS | {"RMSE": "mmHg"},
            "colors": _COLORS,
            "moving": _MOVING_COLORS,
            "moments": _FRAMES,
            "findings": texts(result.laws[name].findings),
        }  # fmt: skip

    def band(self, desk: Desk, animal: str, law: str) -> dict[str, Any]:
        """Return within which curves lie in 95 % of models that the data allow about the fit, and models one by one.

        The models are drawn from the correlated errors of the fit, in logarithms of its parameters and within their
        bounds; there are none where the data determine none. Where a posterior was asked for its own draws are walked
        through, each with the pressure that was simulated with it.
        """
        result, model, recording = self.fitted(desk, animal, law)
        fit = result.laws[stored_law(result, law)[0]]
        models = models_around(model, fit.calibration)
        runs = simulate_runs(models, recording.inflow, Numerics())
        good = [(drawn, waves_of(run, drawn, recording)[0]) for drawn, run in zip(models, runs, strict=True)
                if isinstance(run, Run)]  # fmt: skip
        if len(good) <= len(models) // 2:
            good = []
        stacked = {name: np.array([curves[name] for _, curves in good], dtype=float) for name in BANDS if good}
        walked = posterior_draws(fit.posterior) if fit.posterior is not None else drawn_about_fit(good)
        return {
            "band": {name: np.percentile(values, (2.5, 97.5), axis=0).tolist() for name, values in stacked.items()},
            "draws": walked,
        }

    def simulated(self, desk: Desk, animal: str, law: str, values: Mapping[str, float]) -> dict[str, Any]:
        """Return what the model does with other values of its parameters; the same as `vasowave simulate --set`.

        Raises
        ------
        InputError, NumericalError
            A value that no such parameter can have, or far from the fitted one; a model that cannot be simulated.
        """
        _, fitted, recording = self.fitted(desk, animal, law)
        _require_near(fitted, values)
        model = changed_model(fitted, values)
        run = simulate_run(model, recording.inflow, Numerics())
        shown, indices = waves_of(run, model, recording)
        middle, through = run.pressure[:, 1], run.stations[1][:, :, 1]
        speed = np.asarray(walls.wave_speed(model.wall, middle.mean(axis=0), model.blood.inertia))
        stride = max(1, len(middle) // _FRAMES)
        per_vessel = middle.mean(axis=0), np.ptp(middle, axis=0), through.mean(axis=0), speed
        frames = np.round(middle[::stride], 3), np.round(through[::stride], 5)
        return shown | {
            "period": recording.period,
            "indices": {name: number(value) for name, value in indices.items()},
            "vessels": dict(zip(_COLORS, map(numbers, per_vessel), strict=True)),
            "frames": dict(zip(_MOVING_COLORS, (frame.tolist() for frame in frames), strict=True)),
            "notes": [str(note) for note in run.notes],
        }

    def predicted(self, desk: Desk, animal: str, law: str, values: Mapping[str, float]) -> dict[str, Any]:
        """Return what other values of the parameters change at the inlet, with 95 % intervals; see `predict`.

        Models that the data allow are changed by the factors by which the values differ from the fitted ones.

        Raises
        ------
        InputError, NumericalError
            As of `simulated`; nothing that is moved.
        """
        result, fitted, _ = self.fitted(desk, animal, law)
        _require_near(fitted, values)
        held = _movable(fitted)
        if fixed := [name for name in values if not held.get(name)]:
            raise InputError(f"{fixed[0]}: what the fit holds at 0, or does not know, has no factor; leave it out")
        factors = {name: value / held[name] for name, value in values.items()}
        if not any(abs(factor - 1) > _SLIP for factor in factors.values()):
            raise InputError("nothing differs from the fit; move a slider first")

        def remodel(model: Model) -> Model:
            values_of_model = _movable(model)
            return changed_model(model, {name: factor * values_of_model[name] for name, factor in factors.items()})

        prediction = predict(stored_fit(result, law), {}, remodel=remodel, draws=_PREDICTED_DRAWS)
        table = prediction.table
        rows = {str(name): numbers(row.iloc[1:].to_numpy(float)) for name, row in table.iterrows()}
        labels = {name: name.replace("_", " ") for name in rows}
        units = dict(table["unit"].replace("1", ""))
        return {"labels": labels, "units": units, "rows": rows, "remarks": prediction.remarks}


def _movable(model: Model) -> dict[str, float]:
    """Return the values of the sliders."""
    return parameters_of(model) | dict.fromkeys(_SIZES, 1.0)


def _require_near(fitted: Model, values: Mapping[str, float]) -> None:
    """Raise `InputError` for a value that is far from what the fit holds."""
    viscosity = max(1.0, float(np.median(fitted.wall_viscosity)))  # of most walls it is not known
    fitted_values = _movable(fitted) | {WALL_VISCOSITY: viscosity}
    for name in fitted_values.keys() & values.keys():
        factor = _MAX_SIZE_FACTOR if name in _SIZES else _MAX_FACTOR
        low, high = 0.0 if name == WALL_VISCOSITY else fitted_values[name] / factor, fitted_values[name] * factor
        if fitted_values[name] > 0 and not low <= values[name] <= high:
            raise InputError(f"{name}: {values[name]:.3g} is far from {fitted_values[name]:.3g}, which the fit holds; "
                             f"give a value from {low:.3g} to {high:.3g}")  # fmt: skip


def _file(desk: Desk, animal: str) -> Path:
    stored = desk.stored()
    if animal not in stored:
        raise InputError(f"there is no result of '{animal[:80]}'")
    return stored.folder / stored.file_of(animal)


def waves_of(run: Run, model: Model, recording: Recording) -> tuple[dict[str, list[float | None]], dict[str, float]]:
    """Return the curves of a simulation at the inlet, and its indices."""
    root, period = model.network.root, recording.period
    inlet, into = run.pressure[:, 0, root], run.stations[1][:, root, 0]
    point = operating_point(model, recording.mean_pressure)
    waves = wave_intensity(inlet, into, period, *point, model.blood.inertia)
    simulated = Recording(inlet, into, period, wedge_pressure=recording.wedge_pressure)
    curves = {"pressure": _curve(inlet), "flow": _curve(into), "forward": _curve(waves.forward_pressure),
              "backward": _curve(waves.backward_pressure), "modulus": _modulus(simulated)}  # fmt: skip
    extra_indices = {"I_R": float(waves.reflection_coefficient), "RMSE": _misfit(inlet, recording)}
    return curves, simulated.indices() | extra_indices


def _knobs(result: AnimalResult, model: Model, law: str) -> list[dict[str, Any]]:
    """Return every parameter with its fitted value, its interval, and how far it can be moved."""
    quantities, beds = result.laws[law].quantities, model.outlets
    parameters = wall_parameters(type(model.wall))
    walls = {name: parameter.unit for name, parameter in parameters.items()}
    units = joined(walls, beds.knobs() if isinstance(beds, Bed) else {}, dict.fromkeys(_SIZES, "1"))
    fitted = _movable(model)
    meanings = {name: parameter.meaning for name, parameter in parameters.items()} | _SIZES
    knobs = []
    for name, value in fitted.items():
        attrs = quantities[name].attrs if name in quantities else {}
        reach = 1.3 if name in _SIZES else _SLIDER_FACTOR
        high = min(value * reach, 0.95) if name == "a" else value * reach
        knobs.append({
            "name": name, "symbol": attrs.get("symbol", name), "unit": "" if units[name] == "1" else units[name],
            "meaning": meanings.get(name, str(attrs.get("long_name", ""))), "value": value,
            "low": value / reach, "high": high,
            "interval": [attrs[f"interval_{end}"] for end in ("low", "high")] if "interval_low" in attrs else None,
        })  # fmt: skip
    return knobs


def _misfit(pressure: np.ndarray, recording: Recording) -> float:
    """Return the root-mean-square difference to the measured pressure, mmHg."""
    count = max(len(pressure), len(recording.pressure))
    return float(np.sqrt(np.mean((resample(pressure, count) - resample(recording.pressure, count)) ** 2)))


def _modulus(recording: Recording) -> list[float | None]:
    """Return the modulus of the impedance by harmonic, mmHg s/ml."""
    harmonics = min(_HARMONICS, (min(len(recording.pressure), len(recording.flow)) - 1) // 2)
    up, down = (fourier_series(signal, harmonics) for signal in (recording.pressure, recording.flow))
    return numbers(np.abs(up / np.where(down == 0, np.nan, down)))


def _curve(values: np.ndarray) -> list[float | None]:
    return numbers(resample(np.asarray(values), _CURVE_SAMPLES))


def models_around(model: Model, fit: xr.Dataset) -> list[Model]:
    """Return models drawn from the correlated errors of a fit about it; parameters at a bound stay at it."""
    if "correlation" not in fit or not isinstance(model.outlets, Bed):
        return []
    free = fit.sel(parameter=fit["free_parameter"].values)
    value, low, high = (free[name].values for name in ("value", "lower", "upper"))
    scale = free["standard_error_correlated"].values / value
    loose, held = ~free["at_bound"].values.astype(bool), free["at_bound"].values.astype(bool)
    covariance = fit["correlation"].values * np.outer(scale, scale)
    between = covariance[np.ix_(loose, held)]
    explained = between @ np.linalg.pinv(covariance[np.ix_(held, held)]) @ between.T
    conditional = covariance[np.ix_(loose, loose)] - explained
    if not np.isfinite(conditional).all() or not loose.any():
        return []
    sizes, axes = np.linalg.eigh(conditional)
    normal = np.random.default_rng(0).standard_normal((_DRAWS, len(sizes)))
    moved = np.zeros((_DRAWS, len(value)))
    moved[:, loose] = normal * np.sqrt(np.maximum(sizes, 0.0)) @ axes.T
    drawn = np.clip(value * np.exp(moved), low, high) / value
    names = [str(name) for name in free["parameter"].values]
    fitted: dict[Any, Any] = model_values(model)
    return [with_parameters(model, {name: fitted[name] * factor for name, factor in zip(names, factors, strict=True)})
            for factors in drawn]  # fmt: skip


def total_of(beds: Bed, name: str) -> float:
    """Return what `Bed.with_totals` would change."""
    if name == "R_T":
        return float(beds.total_resistance())
    share = beds.resistance_ratio() if "a" in beds.knobs() else 0.0
    return float(share) if name == "a" else float(np.median(beds.time_constants())) / (1.0 - share)


def drawn_about_fit(drawn: Sequence[tuple[Model, Mapping[str, list[float | None]]]]) -> dict[str, Any]:
    """Return models about a fit one by one: curves, and the values of the parameters that make them."""
    values: dict[str, list[float | None]] = {}
    for model, _ in drawn:
        for name, value in parameters_of(model).items():
            values.setdefault(name, []).append(number(value))
    curves = [{name: waveforms[name] for name in BANDS} for _, waveforms in drawn]
    return {"kind": "models drawn from the errors of the fit", "count": len(curves), "curves": curves, "values": values}


def posterior_draws(posterior: PosteriorResult) -> dict[str, Any]:
    """Return draws of a posterior one by one: the pressure that was simulated, and every unknown and quantity."""
    drawn, predictive = posterior.groups["posterior"], posterior.groups.get("posterior_predictive")
    count = drawn.sizes["chain"] * drawn.sizes["draw"]
    indices = np.unique(np.linspace(0, count - 1, min(count, _MAX_WALKED_DRAWS)).round().astype(int))
    values = {
        str(name): numbers(value.values.reshape(count)[indices])
        for name, value in drawn.data_vars.items() if value.dims == ("chain", "draw")
    }  # fmt: skip
    curves: list[dict[str, Any]] = [{} for _ in indices]
    if predictive is not None and "simulated" in predictive:
        pressures = predictive["simulated"].values.reshape(count, -1)[indices]
        signal = "flow" if "flow" in predictive else "pressure"
        curves = [{signal: numbers(pressure)} for pressure in pressures]
    return {"kind": "draws of the posterior", "count": len(curves), "curves": curves, "values": values}


def parameters_of(model: Model) -> dict[str, float]:
    """Return what the sliders would show of a model."""
    named = zip(parameter_names(type(model.wall)), model.wall, strict=True)
    values = {name: float(np.median(value)) for name, value in named}
    beds = model.outlets
    return values | ({name: total_of(beds, name) for name in beds.knobs()} if isinstance(beds, Bed) else {})
