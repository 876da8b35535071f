"""Bare arrays of simulations, turned into labelled datasets with units."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import xarray as xr

from vasowave.base.errors import VasowaveError
from vasowave.base.findings import texts
from vasowave.pulse.model import walls
from vasowave.pulse.solver.result import Run, in_blocks, with_viscous

STATIONS = ("inlet", "middle", "outlet")

_OF_MEMBERS = (
    *("cycles", "change", "courant", "steps_per_cycle", "volume_error", "error_estimate"),
    *("mach", "steepness", "lowest_pressure", "area_strain", "grid_error"),
)
"""Attributes of one run that an ensemble has as variables."""

_Along = tuple[str, np.ndarray] | tuple[str, np.ndarray, dict[str, str]]

_LABELS = {
    "pressure": ("mmHg", "transmural pressure"),
    "flow": ("ml/s", "volume flow"),
    "area": ("cm2", "cross-sectional area"),
    "velocity": ("cm/s", "mean velocity"),
    "wave_speed": ("cm/s", "pulse wave velocity"),
}


def as_dataset(run: Run) -> xr.Dataset:
    """Label one run: dims (time, vessel, station), or (time, cell) if every cell was kept."""
    network = run.model.network
    per_cell = run.cells.shape[1] > 0
    if per_cell:
        rows, is_cell = run.grid.vessel[run.grid.is_cell], run.grid.is_cell
        area, flow = run.cells[0][:, is_cell], run.cells[1][:, is_cell]
        wall, area0 = type(run.grid.wall)(*(value[is_cell] for value in run.grid.wall)), run.grid.area0[is_cell]
        dims: tuple[str, ...] = ("time", "cell")
        position = "cell", run.grid.position[is_cell], {"units": "cm", "long_name": "distance from the inlet"}
        along: dict[str, _Along] = {"vessel": ("cell", np.array(network.name)[rows]), "position": position}
        coords = _coordinates(len(area), run.period, along)
    else:
        wall, area0 = run.grid.at_stations
        area, flow = np.moveaxis(run.stations[:2], -1, -2)
        dims = ("time", "vessel", "station")
        coords = _at_stations(network.name, len(area), run.period)
    elastic = pressure = run.pressure
    if per_cell or len(run.recorded) > 2:
        elastic = in_blocks(lambda values: walls.pressure(wall, values, area0), area)
    if per_cell:
        pressure = with_viscous(elastic, run.cells[:, :, run.grid.is_cell])
    values = {
        "pressure": pressure,
        "flow": flow,
        "area": area,
        "velocity": flow / area,
        "wave_speed": in_blocks(lambda values: walls.wave_speed(wall, values, run.model.blood.inertia), elastic),
    }
    return xr.Dataset(
        {
            name: (dims, value if per_cell else np.moveaxis(value, -1, 1), {"units": unit, "long_name": words})
            for (name, value), (unit, words) in zip(values.items(), _LABELS.values(), strict=True)
        },
        coords=coords,
        attrs=_attributes(run),
    )


def _coordinates(samples: int, period: float, along: dict[str, _Along]) -> xr.Coordinates:
    time = np.arange(samples) * (period / samples)
    return xr.Dataset(coords={"time": ("time", time, {"units": "s"}), **along}).coords


@lru_cache(maxsize=16)
def _at_stations(names: tuple[str, ...], samples: int, period: float) -> xr.Coordinates:
    """Return the coordinates of all runs of these vessels: their indexes cost as much as all their waves."""
    along: dict[str, _Along] = {"vessel": ("vessel", np.array(names)), "station": ("station", np.array(STATIONS))}
    return _coordinates(samples, period, along)


def stack(outcomes: Sequence[xr.Dataset | VasowaveError]) -> xr.Dataset:
    """Label an ensemble: a first dimension `ensemble`, and `failure` with the message of every member that failed.

    Raises the first member's error if all of them failed.
    """
    good = {i: outcome for i, outcome in enumerate(outcomes) if isinstance(outcome, xr.Dataset)}
    failures = [str(outcome) if isinstance(outcome, VasowaveError) else "" for outcome in outcomes]
    if not good:
        first = outcomes[0]
        assert isinstance(first, VasowaveError)
        raise type(first)(f"all {len(outcomes)} members failed; the first: {first}")
    members = xr.concat(list(good.values()), dim="ensemble", combine_attrs="drop")
    members = members.assign_coords(ensemble=list(good)).reindex(ensemble=range(len(outcomes)))
    for name in _OF_MEMBERS:
        column = [good[i].attrs[name] if i in good else np.nan for i in range(len(outcomes))]
        members[name] = ("ensemble", np.array(column, dtype=float))
    members["notes"] = (
        "ensemble",
        np.array([good[i].attrs["notes"] if i in good else "" for i in range(len(outcomes))]),
    )
    members["failure"] = ("ensemble", np.array(failures))
    members.attrs = {"period": next(iter(good.values())).attrs["period"]}
    return members


def _attributes(run: Run) -> dict[str, float | int | str]:
    attributes: dict[str, float | int | str] = {
        "wall": type(run.model.wall).__name__,
        "period": run.period,
        "cycles": len(run.convergence.changes),
        "change": run.convergence.changes[-1],
        "tolerance": run.tolerance,
        "converged": int(run.convergence.converged),
        "courant": float(run.courant),
        "steps_per_cycle": run.steps,
        "cell_size": float(run.grid.spacing.max()),
        "volume_error": run.volume_error,
        "error_estimate": run.error_estimate,
        "notes": "\n".join(texts(run.notes)),
    }
    if np.any(run.model.wall_viscosity):
        attributes["wall_viscosity"] = float(np.mean(run.model.wall_viscosity))
    for name, extreme in {"mach": run.mach, **run.extremes._asdict()}.items():
        attributes |= {name: extreme.value, f"{name}_vessel": extreme.vessel, f"{name}_time": extreme.time}
    return attributes
