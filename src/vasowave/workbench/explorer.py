"""What the Explorer shows: the fitted model of an animal, and what it does when its parameters are moved."""

import threading
from collections import OrderedDict
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vasowave.analysis import fourier_series, operating_point, wave_intensity
from vasowave.animal.result import AnimalResult
from vasowave.animal.stored import stored_law, stored_model, stored_recording
from vasowave.errors import InputError
from vasowave.figures.network import axes_in_space
from vasowave.figures.style import color_stops
from vasowave.findings import texts
from vasowave.model import walls
from vasowave.model.laws import parameter_names
from vasowave.model.model import Model
from vasowave.model.outlets import Bed
from vasowave.recording import Recording
from vasowave.solver import Numerics
from vasowave.solver.result import Run
from vasowave.solver.simulate import simulate_run, simulate_runs
from vasowave.solver.sweep import changed_model
from vasowave.study.results import INDEX, Results, read_results
from vasowave.workbench.desk import Desk
from vasowave.workbench.draws import BANDS, drawn_about_fit, models_around, parameters_of, posterior_draws
from vasowave.workbench.values import number

_SHOWN = 128  # samples of a curve
_HARMONICS = 10
_AROUND = 3.0  # a slider reaches so many times down and up from the fit
_KEPT = 8  # models in memory
_FRAMES = 32  # instants of the tree


class _Fitted(NamedTuple):
    result: AnimalResult
    model: Model
    recording: Recording


class Explorer:
    """Fitted models that were looked at last."""

    def __init__(self) -> None:
        self._fitted: OrderedDict[Any, _Fitted] = OrderedDict()
        self._results: tuple[int, Results] | None = None
        self._lock = threading.Lock()

    def fitted(self, desk: Desk, animal: str, law: str) -> _Fitted:
        """Return the stored result of an animal with its model."""
        with self._lock:
            path = self._file(desk, animal)
            key = (str(path), path.stat().st_mtime_ns, law)
            if key not in self._fitted:
                result = self._stored(desk)[animal]
                self._fitted[key] = _Fitted(result, stored_model(result, law), stored_recording(result))
                while len(self._fitted) > _KEPT:
                    self._fitted.popitem(last=False)
            self._fitted.move_to_end(key)
            return self._fitted[key]

    def _stored(self, desk: Desk) -> Results:
        """Return the results of the study; their index is read anew only where it changed."""
        index = desk.results / INDEX
        mark = index.stat().st_mtime_ns if index.is_file() else 0
        if self._results is None or self._results[0] != mark or not mark:
            self._results = mark, read_results(desk.folder)
        return self._results[1]

    def _file(self, desk: Desk, animal: str) -> Path:
        stored = self._stored(desk)
        if animal not in stored:
            raise InputError(f"there is no result of '{animal[:80]}'")
        return stored.folder / stored.file_of(animal)

    def described(self, desk: Desk, animal: str, law: str) -> dict[str, Any]:
        """Return the model of an animal: what can be moved and how far, what was measured, its tree."""
        result, model, recording = self.fitted(desk, animal, law)
        name, _ = stored_law(result, law)
        network = model.network
        return {
            "animal": animal,
            "group": result.group,
            "made": self._file(desk, animal).stat().st_mtime_ns,
            "law": name,
            "laws": list(result.laws),
            "formula": result.laws[name].formula,
            "knobs": _knobs(result, model, name),
            "measured": {"pressure": _curve(recording.pressure), "flow": _curve(recording.flow),
                         "period": recording.period, "modulus": _modulus(recording)},
            "tree": {"names": list(network.name), "axes": np.round(axes_in_space(network), 5).tolist(),
                     "radius": [number(one) for one in network.radius], "root": network.root},
            "stops": color_stops(9),
            "findings": texts(result.laws[name].findings),
        }  # fmt: skip

    def band(self, desk: Desk, animal: str, law: str) -> dict[str, Any]:
        """Return within which curves lie in 95 % of models that the data allow about the fit, and models one by one.

        The models are drawn from the correlated errors of the fit, in logarithms of its parameters and within their
        bounds; there are none where the data determine none. Where a posterior was asked for its own draws are walked
        through, each with the pressure that was simulated with it.
        """
        result, model, recording = self.fitted(desk, animal, law)
        one = result.laws[stored_law(result, law)[0]]
        models = models_around(model, one.calibration)
        runs = simulate_runs(models, recording.inflow, Numerics())
        good = [(drawn, waves_of(run, drawn, recording)[0]) for drawn, run in zip(models, runs, strict=True)
                if isinstance(run, Run)]  # fmt: skip
        if len(good) <= len(models) // 2:
            good = []
        stacked = {name: np.array([curves[name] for _, curves in good], dtype=float) for name in BANDS if good}
        walked = posterior_draws(one.posterior) if one.posterior is not None else drawn_about_fit(good)
        return {
            "band": {name: np.percentile(values, (2.5, 97.5), axis=0).tolist() for name, values in stacked.items()},
            "draws": walked,
        }

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
        shown, indices = waves_of(run, model, recording)
        middle, through = run.pressure[:, 1], run.stations[1][:, :, 1]
        speed = np.asarray(walls.wave_speed(model.wall, middle.mean(axis=0), model.blood.inertia))
        every = max(1, len(middle) // _FRAMES)
        return shown | {
            "period": recording.period,
            "indices": {name: number(value) for name, value in indices.items()},
            "vessels": {
                "mean pressure [mmHg]": [number(one) for one in middle.mean(axis=0)],
                "pulse pressure [mmHg]": [number(one) for one in np.ptp(middle, axis=0)],
                "mean flow [ml/s]": [number(one) for one in through.mean(axis=0)],
                "wave speed [cm/s]": [number(one) for one in speed],
            },
            "frames": {
                "pressure [mmHg]": np.round(middle[::every], 3).tolist(),
                "flow [ml/s]": np.round(through[::every], 5).tolist(),
            },
            "notes": [str(note) for note in run.notes],
        }


def waves_of(run: Run, model: Model, recording: Recording) -> tuple[dict[str, list[float | None]], dict[str, float]]:
    """Return the curves of a simulation at the inlet, and its indices."""
    root, period = model.network.root, recording.period
    inlet, into = run.pressure[:, 0, root], run.stations[1][:, root, 0]
    point = operating_point(model, recording.mean_pressure)
    waves = wave_intensity(inlet, into, period, *point, model.blood.inertia)
    simulated = Recording(inlet, into, period, wedge_pressure=recording.wedge_pressure)
    curves = {"pressure": _curve(inlet), "flow": _curve(into), "forward": _curve(waves.forward_pressure),
              "backward": _curve(waves.backward_pressure), "modulus": _modulus(simulated)}  # fmt: skip
    more = {"I_R": float(waves.reflection_coefficient), "RMSE": _misfit(inlet, recording)}
    return curves, simulated.indices() | more


def _knobs(result: AnimalResult, model: Model, law: str) -> list[dict[str, Any]]:
    """Return every parameter with its fitted value, its interval, and how far it can be moved."""
    quantities, beds = result.laws[law].quantities, model.outlets
    parameters = dict(zip(parameter_names(type(model.wall)), model.wall.law().parameters, strict=True))
    fitted = parameters_of(model)
    units = {name: one.unit for name, one in parameters.items()}
    meanings = {name: one.meaning for name, one in parameters.items()}
    if isinstance(beds, Bed):
        units |= beds.knobs()
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


def _misfit(pressure: np.ndarray, recording: Recording) -> float:
    """Return the root-mean-square difference to the measured pressure, mmHg."""
    from vasowave.recording import resample

    count = max(len(pressure), len(recording.pressure))
    return float(np.sqrt(np.mean((resample(pressure, count) - resample(recording.pressure, count)) ** 2)))


def _modulus(recording: Recording) -> list[float | None]:
    """Return the modulus of the impedance by harmonic, mmHg s/ml."""
    most = min(_HARMONICS, (min(len(recording.pressure), len(recording.flow)) - 1) // 2)
    up, down = (fourier_series(one, most) for one in (recording.pressure, recording.flow))
    return [number(float(one)) for one in np.abs(up / np.where(down == 0, np.nan, down))]


def _curve(values: np.ndarray) -> list[float | None]:
    from vasowave.recording import resample

    return [number(float(one)) for one in resample(np.asarray(values), _SHOWN)]
