"""How the nominal parameters came about: Z_c from the pressure-flow loop, τ from the diastolic decay ("parEst")."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.animal.reading import data_of, period
from vasowave.figures.style import CTL, DATA, closed, closed_time, label_axes
from vasowave.recording.cycle import resample

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

_LOOP_SAMPLES = 256


def plot_upstroke(ax: "Axes", tree: "xr.DataTree", color: str = CTL) -> "Axes":
    """Draw the measured pressure-flow loop, the samples of the upstroke and the line whose slope is Z_c (eq. 8)."""
    nominal, recording = data_of(tree, "nominal"), data_of(tree, "recording")
    measured = [recording[name].values for name in ("flow", "pressure")]
    count = max(_LOOP_SAMPLES, *map(len, measured))
    q, p = (resample(signal, count) for signal in measured)
    ax.plot(closed(q), closed(p), color=DATA, label="measured")
    flow, pressure = nominal["upstroke_flow"].values, nominal["upstroke_pressure"].values
    ax.plot(flow, pressure, ".", color=color, markersize=4, label="upstroke")
    ends, Z_c = np.array([q.min(), q.max()]), float(nominal["Z_c"])
    line = pressure.mean() + Z_c * (ends - flow.mean())
    ax.plot(ends, line, color=color, linestyle="dashed", label=f"$Z_c$ = {Z_c:.3g} mmHg s/ml")
    ax.legend()
    return label_axes(ax, "flow [ml/s]", "pressure [mmHg]")


def plot_decay(ax: "Axes", tree: "xr.DataTree", color: str = CTL) -> "Axes":
    """Draw the measured pressure and the exponential fitted to its diastolic decay (eq. 12)."""
    nominal, recording, T = data_of(tree, "nominal"), data_of(tree, "recording"), period(tree)
    time, pressure = nominal["decay_time"].values, nominal["decay_pressure"].values
    tau, start, measured = float(nominal["tau"]), time[0], recording["pressure"].values
    cycle = closed_time(recording["time"].values, T)
    if time[-1] > T:
        cycle, measured = np.concatenate([cycle[:-1], cycle + T]), np.tile(measured, 2)
    ax.plot(cycle, closed(measured), color=DATA, label="measured")
    # A log-linear fit passes through the means, so the amplitude follows from them.
    level = np.exp(np.mean(np.log(pressure)) + np.mean(time - start) / tau)
    fitted = level * np.exp(-(time - start) / tau)
    ax.plot(time, fitted, color=color, linestyle="dashed", linewidth=2.2, label=f"τ = {tau:.3g} s")
    ax.set_xlim(0.0, max(T, time[-1] + 0.05 * T))
    ax.legend()
    return label_axes(ax, "time [s]", "pressure [mmHg]")
