"""Curves that the result of one animal holds; nothing is simulated."""

import numpy as np
import xarray as xr

from vasowave.base.descriptions import NORMAL
from vasowave.base.errors import InputError
from vasowave.pulse.cycle.cycle import resample
from vasowave.pulse.cycle.waveform import amplitudes, cycle_foot
from vasowave.study.animal.law_result import LawResult
from vasowave.study.animal.result import AnimalResult

_LOOP_SAMPLES = 256  # points of a pressure-flow loop, so that it is drawn round


def law_curve(law: LawResult) -> tuple[np.ndarray, np.ndarray] | None:
    """Return pressure (mmHg) and area (cm²) of the calibrated law of the root vessel, if the result holds them."""
    vessels = law.vessels
    if "law_pressure" not in vessels.data_vars:
        return None
    return vessels["law_pressure"].values, vessels["law_area"].values


def pressure_flow_loop(result: AnimalResult) -> tuple[np.ndarray, np.ndarray]:
    """Return measured flow (ml/s) and pressure (mmHg) at the same, at least 256, times of the cycle."""
    recording = result.recording
    measured = [recording[name].values for name in ("flow", "pressure")]
    count = max(_LOOP_SAMPLES, *map(len, measured))
    flow, pressure = (resample(signal, count) for signal in measured)
    return flow, pressure


def upstroke_line(result: AnimalResult, flow: np.ndarray) -> np.ndarray:
    """Return the pressure, mmHg, on the line of slope Z_c through the samples of the upstroke (eq. 8)."""
    nominal = result.nominal
    center = float(nominal["upstroke_pressure"].mean()), float(nominal["upstroke_flow"].mean())
    return center[0] + float(nominal["Z_c"]) * (flow - center[1])


def fitted_decay(result: AnimalResult) -> tuple[np.ndarray, np.ndarray]:
    """Return time (s) and pressure (mmHg) of the exponential fitted to the diastolic decay (eq. 12).

    It decays to the pressure behind the beds. A decay that reaches below that has none; its line is that to 0 mmHg.
    """
    nominal = result.nominal
    time, tau, falling = nominal["decay_time"].values, float(nominal["tau"]), nominal["decay_pressure"].values
    behind = float(result.recording.get("wedge_pressure", 0.0))
    behind = behind if falling.min() > behind else 0.0
    # A log-linear fit passes through the means, so the amplitude follows from them.
    level = np.exp(np.mean(np.log(falling - behind)) + np.mean(time - time[0]) / tau)
    return time, behind + level * np.exp(-(time - time[0]) / tau)


def largest_waves(waves: xr.Dataset) -> dict[str, int]:
    """Return the row of the wave of largest area of each kind, by its name."""
    rows: dict[str, int] = {}
    for row in np.argsort(-np.abs(waves["wave_area"].values), kind="stable"):
        rows.setdefault(str(waves["wave_name"].values[row]), int(row))
    return rows


def residual_autocorrelation(result: AnimalResult, wall: str) -> xr.DataArray:
    """Circular autocorrelation of the residuals of a fit, at lags (s) of 0 … N//2 samples.

    Attribute ``white_noise``: half width of the 95 % band of independent noise.
    """
    residual = result.laws[wall].residual.values
    rho = autocorrelation(residual)
    lag = np.arange(len(rho)) * (result.period / len(residual))
    return xr.DataArray(rho, {"lag": lag}, "lag", attrs={"units": "1", "white_noise": NORMAL / np.sqrt(len(residual))})


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


def impedance_error(result: AnimalResult) -> np.ndarray | None:
    """Return the relative standard error of every harmonic of the measured impedance, which is its phase's too, rad.

    From the scatter of the averaged beats, the errors of pressure and flow taken as independent; None without beats.
    """
    recording = result.recording
    if not {"pressure_error", "flow_error"} <= set(recording.data_vars):
        return None
    harmonic = result.measured.impedance["harmonic"].values.astype(int)
    relative_errors = []
    for name in ("pressure", "flow"):
        error = recording[f"{name}_error"].values
        padded = np.append(error, np.full(max(0, harmonic.max() + 1 - len(error)), np.nan))
        relative_errors.append(padded[harmonic] / np.abs(amplitudes(recording[name].values)[harmonic]))
    return np.nan_to_num(np.hypot(*relative_errors))


def from_foot(result: AnimalResult, quantity: str) -> tuple[np.ndarray, np.ndarray]:
    """Return time over the period and the measured samples of a cycle that begins at the foot of its pressure, closed.

    `quantity` is ``pressure`` or ``flow``; pressure and flow are moved alike.
    """
    recording = result.recording
    time = recording["time" if quantity == "pressure" else "flow_time"].values
    share = (time / result.period - cycle_foot(recording["pressure"].values)) % 1.0
    order = np.argsort(share)
    values = recording[quantity].values[order]
    return np.append(share[order], share[order[0]] + 1), np.append(values, values[0])
