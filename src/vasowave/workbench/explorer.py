"""What the Explorer shows: the fitted model of an animal, and what it does when its parameters are moved."""

import threading
from collections import OrderedDict
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vasowave.analysis import fourier_series, operating_point, wave_intensity
from vasowave.animal.files import read_result
from vasowave.animal.result import AnimalResult
from vasowave.animal.stored import stored_law, stored_model, stored_recording
from vasowave.errors import InputError
from vasowave.figures.space import axes_in_space
from vasowave.figures.style import color_stops, group_looks
from vasowave.findings import texts
from vasowave.model import walls
from vasowave.model.laws import bed_factors, parameter_names
from vasowave.model.model import Model
from vasowave.model.outlets import Bed
from vasowave.recording import Recording
from vasowave.solver import Numerics
from vasowave.solver.result import Run
from vasowave.solver.simulate import simulate_run, simulate_runs
from vasowave.solver.sweep import changed_model
from vasowave.study.results import Results, read_results
from vasowave.workbench.desk import Desk

_SHOWN = 128  # samples of a curve
_HARMONICS = 10
_AROUND = 3.0  # a slider reaches so many times down and up from the fit
_KEPT = 8  # models in memory
_FRAMES = 32  # instants of the tree
_DRAWS = 40  # models that the band is made of
_BANDS = ("pressure", "forward", "backward", "modulus")


class _Fitted(NamedTuple):
    result: AnimalResult
    model: Model
    recording: Recording


class Explorer:
    """Fitted models that were looked at last."""

    def __init__(self) -> None:
        self._fitted: OrderedDict[Any, _Fitted] = OrderedDict()
        self._numbered: dict[str, tuple[int, dict[str, Any]]] = {}
        self._lock = threading.Lock()

    def animals(self, desk: Desk) -> dict[str, Any]:
        """Return who has results, and the numbers of every animal and law."""
        stored = read_results(desk.folder)
        groups = {one.animal: one.group for one in stored.animals}
        looks = group_looks(stored.settings.groups)
        numbers = [self._numbers(stored, name) for name in stored]
        return {
            "animals": [
                {"name": name, "group": groups[name], **more} for name, more in zip(stored, numbers, strict=True)
            ],
            "groups": {label: looks[label].color for label in stored.settings.groups},
            "quantities": {name: what for one in reversed(numbers) for name, what in one.pop("described").items()},
            "failures": [f"{one.animal}: {one}" for one in stored.failures],
        }

    def _numbers(self, stored: Results, name: str) -> dict[str, Any]:
        """Return all numbers of an animal; a file is read once, as long as it stays as it is."""
        path = stored.folder / stored.file_of(name)
        mark = path.stat().st_mtime_ns
        if self._numbered.get(name, (0,))[0] != mark:
            self._numbered[name] = mark, _numbers_of(read_result(path))
        return dict(self._numbered[name][1])

    def fitted(self, desk: Desk, animal: str, law: str) -> _Fitted:
        """Return the stored result of an animal with its model."""
        stored = read_results(desk.folder)
        if animal not in stored:
            raise InputError(f"there is no result of '{animal[:80]}'")
        path = stored.folder / stored.file_of(animal)
        key = (str(path), path.stat().st_mtime_ns, law)
        with self._lock:
            if key not in self._fitted:
                result = stored[animal]
                self._fitted[key] = _Fitted(result, stored_model(result, law), stored_recording(result))
                while len(self._fitted) > _KEPT:
                    self._fitted.popitem(last=False)
            self._fitted.move_to_end(key)
            return self._fitted[key]

    def described(self, desk: Desk, animal: str, law: str) -> dict[str, Any]:
        """Return the model of an animal: what can be moved and how far, what was measured, its tree."""
        result, model, recording = self.fitted(desk, animal, law)
        name, _ = stored_law(result, law)
        network = model.network
        return {
            "animal": animal,
            "group": result.group,
            "law": name,
            "laws": list(result.laws),
            "formula": result.laws[name].formula,
            "knobs": _knobs(result, model, name),
            "measured": {"pressure": _curve(recording.pressure), "flow": _curve(recording.flow),
                         "period": recording.period, "modulus": _modulus(recording)},
            "tree": {"names": list(network.name), "axes": np.round(axes_in_space(network), 5).tolist(),
                     "radius": [_number(one) for one in network.radius], "root": network.root},
            "stops": color_stops(9),
            "findings": texts(result.laws[name].findings),
        }  # fmt: skip

    def band(self, desk: Desk, animal: str, law: str) -> dict[str, Any]:
        """Return within which pressure, waves and impedance lie in 95 % of models that the data allow about the fit.

        Models are drawn from the correlated errors of the fit, in logarithms of its parameters and within their
        bounds; there is no band where the data determine none.
        """
        result, model, recording = self.fitted(desk, animal, law)
        models = _around(model, result.laws[stored_law(result, law)[0]].calibration)
        runs = simulate_runs(models, recording.inflow, Numerics()) if models else []
        good = [_waves(run, one, recording)[0] for one, run in zip(models, runs, strict=True) if isinstance(run, Run)]
        if len(good) <= _DRAWS // 2:
            return {}
        stacked = {name: np.array([one[name] for one in good], dtype=float) for name in _BANDS}
        return {name: np.percentile(values, (2.5, 97.5), axis=0).tolist() for name, values in stacked.items()}

    def simulated(self, desk: Desk, animal: str, law: str, values: Mapping[str, float]) -> dict[str, Any]:
        """Return what the model does with other values of its parameters; the same as `vasowave simulate --set`.

        Raises
        ------
        InputError, NumericalError
            A value that no such parameter can have, or a model that cannot be simulated.
        """
        _, fitted, recording = self.fitted(desk, animal, law)
        model = changed_model(fitted, values)
        run = simulate_run(model, recording.inflow, Numerics())
        shown, indices = _waves(run, model, recording)
        middle, through = run.pressure[:, 1], run.stations[1][:, 1]
        speed = np.asarray(walls.wave_speed(model.wall, middle.mean(axis=0), model.blood.inertia))
        every = max(1, len(middle) // _FRAMES)
        return shown | {
            "period": recording.period,
            "indices": {name: _number(value) for name, value in indices.items()},
            "vessels": {
                "mean pressure [mmHg]": [_number(one) for one in middle.mean(axis=0)],
                "pulse pressure [mmHg]": [_number(one) for one in np.ptp(middle, axis=0)],
                "mean flow [ml/s]": [_number(one) for one in through.mean(axis=0)],
                "wave speed [cm/s]": [_number(one) for one in speed],
            },
            "frames": {
                "pressure [mmHg]": np.round(middle[::every], 3).tolist(),
                "flow [ml/s]": np.round(through[::every], 5).tolist(),
            },
            "notes": [str(note) for note in run.notes],
        }


def _waves(run: Run, model: Model, recording: Recording) -> tuple[dict[str, list[float | None]], dict[str, float]]:
    """Return the curves of a simulation at the inlet, and its indices."""
    root, period = model.network.root, recording.period
    inlet, into = run.pressure[:, 0, root], run.stations[1][:, 0, root]
    point = operating_point(model, recording.mean_pressure)
    waves = wave_intensity(inlet, into, period, *point, model.blood.inertia)
    simulated = Recording(inlet, into, period, wedge_pressure=recording.wedge_pressure)
    curves = {"pressure": _curve(inlet), "flow": _curve(into), "forward": _curve(waves.forward_pressure),
              "backward": _curve(waves.backward_pressure), "modulus": _modulus(simulated)}  # fmt: skip
    more = {"I_R": float(waves.reflection_coefficient), "RMSE": _misfit(inlet, recording)}
    return curves, simulated.indices() | more


def _around(model: Model, fit: xr.Dataset) -> list[Model]:
    """Return models drawn from the errors of a fit about it; parameters at a bound stay at it."""
    if "correlation" not in fit or not isinstance(model.outlets, Bed):
        return []
    free = fit.sel(parameter=fit["free_parameter"].values)
    value, low, high = (free[name].values for name in ("value", "lower", "upper"))
    scale = free["standard_error_correlated"].values / value
    loose, held = ~free["at_bound"].values.astype(bool), free["at_bound"].values.astype(bool)
    covariance = fit["correlation"].values * np.outer(scale, scale)
    between = covariance[np.ix_(loose, held)]
    known = between @ np.linalg.pinv(covariance[np.ix_(held, held)]) @ between.T
    conditional = covariance[np.ix_(loose, loose)] - known
    if not np.isfinite(conditional).all() or not loose.any():
        return []
    sizes, axes = np.linalg.eigh(conditional)
    normal = np.random.default_rng(0).standard_normal((_DRAWS, len(sizes)))
    moved = np.zeros((_DRAWS, len(value)))
    moved[:, loose] = normal * np.sqrt(np.maximum(sizes, 0.0)) @ axes.T
    drawn = np.clip(value * np.exp(moved), low, high) / value
    names = [str(one) for one in free["parameter"].values]
    return [_scaled(model, dict(zip(names, one, strict=True))) for one in drawn]


def _scaled(model: Model, factors: Mapping[str, float]) -> Model:
    """Return a model whose fitted parameters are multiplied by factors."""
    fields = zip(parameter_names(type(model.wall)), model.wall._fields, strict=True)
    wall = model.wall._replace(**{field: np.asarray(getattr(model.wall, field)) * factors[name]
                                  for name, field in fields if name in factors})  # fmt: skip
    beds = model.outlets
    if isinstance(beds, Bed):
        beds = beds.scaled(*(factors.get(name, 1.0) for name in bed_factors(type(beds))))
    return model.changed(wall=wall, outlets=beds)


def _numbers_of(result: AnimalResult) -> dict[str, Any]:
    """Return the numbers of an animal by source, what they mean, and its findings."""
    laws = {
        source: {
            str(quantity): [_number(float(value)), *(
                _number(float(value.attrs[f"interval_{end}"])) if f"interval_{end}" in value.attrs else None
                for end in ("low", "high"))]
            for quantity, value in one.quantities.data_vars.items()
        }
        for source, one in result.sources.items()
    }  # fmt: skip
    described = {
        str(name): [value.attrs.get("symbol", str(name)), value.attrs["units"], value.attrs["long_name"]]
        for one in reversed(result.sources.values())
        for name, value in one.quantities.data_vars.items()
    }
    return {"laws": laws, "findings": texts(result.findings), "described": described}


def _knobs(result: AnimalResult, model: Model, law: str) -> list[dict[str, Any]]:
    """Return every parameter with its fitted value, its interval, and how far it can be moved."""
    quantities, beds = result.laws[law].quantities, model.outlets
    parameters = dict(zip(parameter_names(type(model.wall)), model.wall.law().parameters, strict=True))
    fitted = {name: float(np.median(value)) for name, value in zip(parameters, model.wall, strict=True)}
    units = {name: one.unit for name, one in parameters.items()}
    meanings = {name: one.meaning for name, one in parameters.items()}
    if isinstance(beds, Bed):
        units |= beds.knobs()
        fitted |= {name: _of_beds(beds, name) for name in beds.knobs()}
    units |= {"radius": "1", "length": "1"}
    fitted |= {"radius": 1.0, "length": 1.0}
    meanings |= {"radius": "factor of all radii", "length": "factor of all lengths"}
    knobs = []
    for name, value in fitted.items():
        attrs = quantities[name].attrs if name in quantities else {}
        reach = 1.3 if name in ("radius", "length") else _AROUND
        high = min(value * reach, 0.95) if name == "a" else value * reach
        knobs.append({
            "name": name, "symbol": attrs.get("symbol", name), "unit": "" if units[name] == "1" else units[name],
            "meaning": meanings.get(name, str(attrs.get("long_name", ""))), "value": value,
            "low": value / reach, "high": high,
            "interval": [attrs[f"interval_{end}"] for end in ("low", "high")] if "interval_low" in attrs else None,
        })  # fmt: skip
    return knobs


def _of_beds(beds: Bed, name: str) -> float:
    """Return what `Bed.with_totals` would change."""
    if name == "R_T":
        return float(beds.total_resistance())
    share = beds.resistance_ratio() if "a" in beds.knobs() else 0.0
    return float(share) if name == "a" else float(np.median(beds.time_constants())) / (1.0 - share)


def _misfit(pressure: np.ndarray, recording: Recording) -> float:
    """Return the root-mean-square difference to the measured pressure, mmHg."""
    from vasowave.recording import resample

    count = max(len(pressure), len(recording.pressure))
    return float(np.sqrt(np.mean((resample(pressure, count) - resample(recording.pressure, count)) ** 2)))


def _modulus(recording: Recording) -> list[float | None]:
    """Return the modulus of the impedance by harmonic, mmHg s/ml."""
    most = min(_HARMONICS, (min(len(recording.pressure), len(recording.flow)) - 1) // 2)
    up, down = (fourier_series(one, most) for one in (recording.pressure, recording.flow))
    return [_number(float(one)) for one in np.abs(up / np.where(down == 0, np.nan, down))]


def _curve(values: np.ndarray) -> list[float | None]:
    from vasowave.recording import resample

    return [_number(float(one)) for one in resample(np.asarray(values), _SHOWN)]


def _number(value: float) -> float | None:
    return float(f"{value:.6g}") if np.isfinite(value) else None
