"""What the result of one animal says; nothing is simulated, no wall law is known but by what is stored of it."""

import json
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vasowave.errors import InputError
from vasowave.network import MEASURED, Network
from vasowave.recording.cycle import resample

_LOOP_SAMPLES = 256  # points of a pressure-flow loop, so that it is drawn round


class StoredLaw(NamedTuple):
    """What a result says of one wall law.

    Attributes
    ----------
    name, title, formula, equation : str
        As in the law's own description; empty where the result does not tell.
    stiffness : str
        Quantity that stands for the stiffness in tables.
    parameters : tuple of str
        Those of the wall, without the factors of the outlets.
    """

    name: str
    title: str
    formula: str
    equation: str
    stiffness: str
    parameters: tuple[str, ...]


def data_of(result: xr.DataTree, path: str) -> xr.Dataset:
    """Return the data of one group of the result, ``measured/waves`` for instance.

    Raises
    ------
    InputError
        There is no such group.
    """
    try:
        node = result[path]
    except KeyError:
        node = None
    if not isinstance(node, xr.DataTree):
        raise InputError(f"the result of this animal holds no group '{path}'")
    return node.to_dataset(inherit=False)


def name_of(result: xr.DataTree) -> str:
    """Return the name of the animal."""
    return str(result.attrs["animal"])


def group_of(result: xr.DataTree) -> str:
    """Return the group of the animal."""
    return str(result.attrs["group"])


def notes_of(result: xr.DataTree) -> list[str]:
    """Return what a reader must know about the animal."""
    return [str(note) for note in json.loads(result.attrs.get("notes", "[]"))]


def is_synthetic(result: xr.DataTree) -> bool:
    """Say whether the animal was made and not measured: what its file says, whatever it is called."""
    return bool(int(result.attrs.get("synthetic", 0)))


def settings_of(result: xr.DataTree) -> dict[str, Any]:
    """Return the settings that the animal was analyzed with."""
    return dict(json.loads(result.attrs.get("settings", "{}")))


def wall_laws(result: xr.DataTree) -> list[str]:
    """Return the names of the wall laws that were calibrated, in the order stored."""
    return [str(name) for name, node in result.children.items() if "calibration" in node.children]


def sources(result: xr.DataTree) -> list[str]:
    """Return where numbers of the animal come from: ``measured``, and every calibrated wall law."""
    return ["measured", *wall_laws(result)]


def law_of(result: xr.DataTree, wall: str) -> StoredLaw:
    """Return what the result says of a wall law."""
    calibration = data_of(result, f"{wall}/calibration")
    own = tuple(str(name) for name in calibration["parameter"].values if name in calibration.data_vars)
    said = {key: str(calibration.attrs.get(key, "")) for key in ("title", "formula", "equation")}
    stiffness = str(calibration.attrs.get("stiffness", "stiffness"))
    return StoredLaw(wall, **said, stiffness=stiffness, parameters=own)


def period(result: xr.DataTree) -> float:
    """Return T, s."""
    return float(data_of(result, "recording").attrs["period"])


def network(result: xr.DataTree) -> Network:
    """Return the network of the animal, with all that is known of its vessels."""
    data = data_of(result, "network")
    names = tuple(map(str, data["vessel"].values))
    rows = {name: row for row, name in enumerate(names)} | {"": -1}
    parent = np.array([rows[str(name)] for name in data["parent"].values])
    known = {field: data[field].values for field in MEASURED if field in data}
    pressure = float(data["image_pressure"]) if "image_pressure" in data else 0.0
    return Network(names, parent, data["length"].values, data["radius"].values, None, pressure, **known)


def root_vessel(result: xr.DataTree) -> str:
    """Return the name of the root vessel."""
    data = data_of(result, "network")
    return str(data["vessel"].values[np.flatnonzero(data["parent"].values == "")[0]])


def simulated(result: xr.DataTree, wall: str, quantity: str, vessel: str, station: str = "inlet") -> xr.DataArray:
    """Return one simulated quantity over the cycle at one station, shape (time,)."""
    return data_of(result, f"{wall}/simulation")[quantity].sel(vessel=vessel, station=station)


def at_inlets(result: xr.DataTree) -> xr.DataTree:
    """Return the result with, of every simulation, only pressure and flow at the inlet of the root vessel.

    That is all that most of a report asks of an animal, and a tenth of its size.
    """
    light = result.copy()
    for wall in wall_laws(result):
        waves = data_of(result, f"{wall}/simulation")[["pressure", "flow"]]
        light[f"{wall}/simulation"].dataset = waves.sel(vessel=[root_vessel(result)], station=["inlet"])
    return light


def law_curve(result: xr.DataTree, wall: str) -> tuple[np.ndarray, np.ndarray] | None:
    """Return pressure (mmHg) and area (cm²) of the calibrated law of the root vessel, if the result holds them."""
    vessels = data_of(result, f"{wall}/tree")
    if "law_pressure" not in vessels.data_vars:
        return None
    return vessels["law_pressure"].values, vessels["law_area"].values


def pressure_flow_loop(result: xr.DataTree) -> tuple[np.ndarray, np.ndarray]:
    """Return measured flow (ml/s) and pressure (mmHg) at the same, at least 256, times of the cycle."""
    recording = data_of(result, "recording")
    measured = [recording[name].values for name in ("flow", "pressure")]
    count = max(_LOOP_SAMPLES, *map(len, measured))
    flow, pressure = (resample(signal, count) for signal in measured)
    return flow, pressure


def upstroke_line(result: xr.DataTree, flow: np.ndarray) -> np.ndarray:
    """Return the pressure, mmHg, on the line of slope Z_c through the samples of the upstroke (eq. 8)."""
    nominal = data_of(result, "nominal")
    center = float(nominal["upstroke_pressure"].mean()), float(nominal["upstroke_flow"].mean())
    return center[0] + float(nominal["Z_c"]) * (flow - center[1])


def fitted_decay(result: xr.DataTree) -> tuple[np.ndarray, np.ndarray]:
    """Return time (s) and pressure (mmHg) of the exponential fitted to the diastolic decay (eq. 12)."""
    nominal = data_of(result, "nominal")
    time, tau = nominal["decay_time"].values, float(nominal["tau"])
    # A log-linear fit passes through the means, so the amplitude follows from them.
    level = np.exp(np.mean(np.log(nominal["decay_pressure"].values)) + np.mean(time - time[0]) / tau)
    return time, level * np.exp(-(time - time[0]) / tau)


def largest_waves(waves: xr.Dataset) -> dict[str, int]:
    """Return the row of the wave of largest area of each kind, by its name."""
    rows: dict[str, int] = {}
    for row in np.argsort(-np.abs(waves["wave_area"].values), kind="stable"):
        rows.setdefault(str(waves["wave_name"].values[row]), int(row))
    return rows


def residual_autocorrelation(result: xr.DataTree, wall: str) -> xr.DataArray:
    """Circular autocorrelation of the pressure residuals of a fit, at lags (s) of 0 … N//2 samples.

    Attribute ``white_noise``: half width of the 95 % band of independent noise.
    """
    residual = data_of(result, f"{wall}/calibration")["pressure_residual"].values
    rho = autocorrelation(residual)
    lag = np.arange(len(rho)) * (period(result) / len(residual))
    return xr.DataArray(rho, {"lag": lag}, "lag", attrs={"units": "1", "white_noise": 1.96 / np.sqrt(len(residual))})


def autocorrelation(residual: np.ndarray) -> np.ndarray:
    """Circular autocorrelation of the centered residuals at lags of 0 … N//2 samples.

    Raises
    ------
    InputError
        The residuals do not vary.
    """
    r = np.asarray(residual, dtype=float)
    power = np.abs(np.fft.rfft(r - r.mean())) ** 2
    if not power.sum() > 0:
        raise InputError("the residuals do not vary; they have no autocorrelation")
    covariance = np.fft.irfft(power, len(r))
    return covariance[: len(r) // 2 + 1] / covariance[0]
