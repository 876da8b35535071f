"""One model over a grid of parameter values: what each value does to pressure and flow, in bounded memory."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice, product
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.errors import InputError, VasowaveError
from vasowave.base.findings import texts
from vasowave.pulse.cycle.averaged import EnsembleAverage
from vasowave.pulse.cycle.cycle import Recording, resample
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.parameters import changeable, changed_model, checked_values
from vasowave.pulse.model.ventricle import Driven
from vasowave.pulse.solver.result import Run
from vasowave.pulse.solver.simulation import driving, simulate_runs

_AT_ONCE = 64  # models whose waves are in memory together
_MIDDLE = 1  # station in the middle of a vessel

_KEPT = {
    "root_pressure": ("mmHg", "pressure at the inlet of the root"),
    "mean_pressure": ("mmHg", "mean pressure in the middle of the vessel"),
    "pulse_pressure": ("mmHg", "pulse pressure in the middle of the vessel"),
    "mean_flow": ("ml/s", "mean flow in the middle of the vessel"),
    "mach": ("1", "largest |u|/c"),
}


def sweep(
    model: Model,
    inflow: Driven | Recording | EnsembleAverage,
    values: Mapping[str, Sequence[float]],
    numerics: Numerics | None = None,
    *,
    samples: int = 128,
    progress: Callable[[int, int], None] | None = None,
    after: Callable[[Model], Model] | None = None,
) -> xr.Dataset:
    """Simulate a model with every combination of parameter values.

    Parameters
    ----------
    model : Model
        What is not varied stays as it is here.
    inflow : Inflow, Recording, EnsembleAverage, InletPressure or Ventricle
    values : mapping of str to sequence of float
        Parameters of the wall law, for all vessels alike (``beta``, ``p1``, ``gamma``, ``m`` …); of the vascular beds
        ``R_T`` (total resistance, mmHg s/ml), where they have a compliance ``tau`` (s), and of Windkessels ``a``
        (R1/R_T; distributed as the paper does); ``radius``, ``length``: factors of all radii and lengths; and
        ``wall_viscosity`` (mmHg s).
    numerics : Numerics, optional
    after : callable, optional
        What is done to every model once its parameters are set: ``lambda model: vw.narrowed(model, "2", 0.8, 0.05)``.
        A narrowing that is there before would count as a vessel by which total resistance and stiffness are shared.
    samples : int
        Samples of the pressure that is kept.
    progress : callable, optional
        Called with the number of finished and of all simulations.

    Returns
    -------
    Dataset
        One dimension for every parameter, whose coordinate holds the values, with ``root_pressure`` (…, time),
        ``mean_pressure``, ``pulse_pressure``, ``mean_flow`` (…, vessel), ``mach`` (largest |u|/c), ``failure`` (why a
        combination could not be simulated; its numbers are NaN) and ``notes`` (why it should not be believed).

    Raises
    ------
    InputError
        An unknown parameter, no values, values that are not positive.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> nominal = vw.estimate_nominal(network, mouse)
    >>> model = vw.Model(network, nominal.wall(vw.LinearWall), nominal.outlets)
    >>> stiffer = vw.sweep(model, mouse, {"beta": [40.0, 80.0]})
    >>> pulse = stiffer.pulse_pressure.sel(vessel=network.name[network.root])
    >>> bool(pulse.sel(beta=80.0) > pulse.sel(beta=40.0))
    True
    """
    axes = checked_values(model, values)
    if not axes:
        raise InputError("nothing to sweep; name a parameter and its values, as beta: 40, 60, 80")
    flow = driving(inflow)
    numerics = numerics or Numerics()
    count = int(np.prod([len(axis) for axis in axes.values()]))
    records: list[dict[str, Any]] = []
    final_model = after(model) if after is not None else model
    for outcomes in _outcomes(model, flow, numerics, axes, after):
        records += [_reduced(outcome, final_model, samples) for outcome in outcomes]
        if progress is not None:
            progress(len(records), count)
    return _labelled(records, final_model, flow, axes, samples)


def sweep_table(dataset: xr.Dataset) -> pd.DataFrame:
    """Return a sweep as a table: a row for every combination, with the pressure at the root, titles with units.

    Columns: the parameters, ``systolic, diastolic, mean, pulse``, ``mach``, ``failure`` and ``notes``.
    """
    pressure = dataset["root_pressure"]
    columns = {
        "systolic [mmHg]": pressure.max("time", skipna=False),
        "diastolic [mmHg]": pressure.min("time", skipna=False),
        "mean [mmHg]": pressure.mean("time", skipna=False),
        "pulse [mmHg]": pressure.max("time", skipna=False) - pressure.min("time", skipna=False),
        "mach": dataset["mach"],
        "failure": dataset["failure"],
        "notes": dataset["notes"],
    }
    axes = [str(name) for name in dataset["mach"].dims]
    rows = pd.DataFrame({title: values.values.ravel() for title, values in columns.items()})
    grid = list(product(*(dataset[name].values.tolist() for name in axes)))
    units = [dataset[name].attrs.get("units", "1") for name in axes]
    titles = [name if unit == "1" else f"{name} [{unit}]" for name, unit in zip(axes, units, strict=True)]
    return pd.concat([pd.DataFrame(grid, columns=titles), rows], axis=1)


def _outcomes(
    model: Model,
    inflow: Driven,
    numerics: Numerics,
    axes: Mapping[str, np.ndarray],
    after: Callable[[Model], Model] | None,
) -> Iterator[list[Run | VasowaveError]]:
    combinations = product(*axes.values())
    while batch := list(islice(combinations, _AT_ONCE)):
        models: list[Model | VasowaveError] = [
            _made(model, dict(zip(axes, point, strict=True)), after) for point in batch
        ]
        good = [outcome for outcome in models if isinstance(outcome, Model)]
        runs = simulate_runs(good, inflow, numerics)
        yield [next(runs) if isinstance(outcome, Model) else outcome for outcome in models]


def _made(model: Model, values: Mapping[str, float], after: Callable[[Model], Model] | None) -> Model | VasowaveError:
    try:
        changed = changed_model(model, values)
        return after(changed) if after is not None else changed
    except VasowaveError as error:
        return error


def _reduced(outcome: Run | VasowaveError, model: Model, samples: int) -> dict[str, Any]:
    """Return of one simulation what is kept."""
    vessels = len(model.network)
    if isinstance(outcome, VasowaveError):
        empty, lost = np.full(vessels, np.nan), np.full(samples, np.nan)
        numbers = dict.fromkeys(("mean_pressure", "pulse_pressure", "mean_flow"), empty)
        return numbers | {"root_pressure": lost, "mach": np.nan, "failure": str(outcome), "notes": ""}
    pressure, flow = outcome.pressure[:, _MIDDLE], outcome.stations[1, :, :, _MIDDLE]
    return {
        "root_pressure": resample(outcome.inlet_pressure(outcome.steps), samples),
        "mean_pressure": pressure.mean(axis=0),
        "pulse_pressure": np.ptp(pressure, axis=0),
        "mean_flow": flow.mean(axis=0),
        "mach": outcome.mach.value,
        "failure": "",
        "notes": "\n".join(texts(outcome.notes)),
    }


def _labelled(
    records: Sequence[Mapping[str, Any]], model: Model, inflow: Driven, axes: Mapping[str, np.ndarray], samples: int
) -> xr.Dataset:
    shape, units = tuple(len(axis) for axis in axes.values()), changeable(model)
    extra_dims = {"root_pressure": ("time",), "mean_pressure": ("vessel",), "pulse_pressure": ("vessel",),
            "mean_flow": ("vessel",)}  # fmt: skip
    variables: dict[str, Any] = {}
    for name in records[0]:
        values = np.array([record[name] for record in records])
        unit, meaning = _KEPT.get(name, ("", ""))
        attrs = {"units": unit, "long_name": meaning} if unit else {}
        variables[name] = ((*axes, *extra_dims.get(name, ())), values.reshape(*shape, *values.shape[1:]), attrs)
    coords: dict[str, Any] = {name: (name, values, {"units": units[name]}) for name, values in axes.items()}
    coords["time"] = ("time", np.arange(samples) * (inflow.period / samples), {"units": "s"})
    coords["vessel"] = ("vessel", np.array(model.network.name))
    return xr.Dataset(variables, coords)
