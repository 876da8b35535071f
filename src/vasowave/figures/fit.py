"""Measured and fitted waveforms where the catheter was, and what is left between them ("Residuals")."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.animal.reading import residual_autocorrelation
from vasowave.animal.result import AnimalResult
from vasowave.figures.style import CTL, DATA, FAINT, closed, closed_time, label_axes, legend_above, wall_lines

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes


def plot_pressure(ax: "Axes", result: AnimalResult, color: str = CTL, shaded: bool = True) -> "Axes":
    """Draw measured pressure, and each wall law's at the inlet of the root vessel, over one cycle."""
    recording = result.recording
    ax.plot(_closed_time(recording["time"], result), closed(recording["pressure"].values), color=DATA, label="measured")
    _plot_simulated(ax, result, "pressure", color, shaded)
    ax.legend()
    return label_axes(ax, "time [s]", "pressure [mmHg]")


def plot_flow(ax: "Axes", result: AnimalResult, color: str = CTL, shaded: bool = True) -> "Axes":
    """Draw measured flow, and each wall law's at the inlet of the root vessel, over one cycle.

    Where the measured flow is the model's inflow the curves coincide.
    """
    recording = result.recording
    ax.plot(
        _closed_time(recording["flow_time"], result), closed(recording["flow"].values), color=DATA, label="measured"
    )
    _plot_simulated(ax, result, "flow", color, shaded)
    return label_axes(ax, "time [s]", "flow [ml/s]")


def plot_residuals(ax: "Axes", result: AnimalResult, color: str = CTL, shaded: bool = True) -> "Axes":
    """Draw measured minus simulated pressure over one cycle, or flow, where the pressure entered the model."""
    ax.axhline(0.0, color=FAINT, linewidth=0.8)
    what, unit = "pressure", "mmHg"
    for wall, line in wall_lines(result.laws, color, shaded).items():
        what, residual = result.laws[wall].compared, result.laws[wall].residual
        unit, left = str(residual.attrs["units"]), float(np.sqrt(np.mean(residual.values**2)))
        said = f"{wall}, RMSE {left:.2f} mmHg" if what == "pressure" else f"{wall}, RMSE {left:.3g} {unit}"
        ax.plot(residual["time"].values, residual.values, **(line | {"label": said}))
    legend_above(ax, columns=2)
    return label_axes(ax, "time [s]", f"residual {what} [{unit}]")


def plot_autocorrelation(ax: "Axes", result: AnimalResult, color: str = CTL, shaded: bool = True) -> "Axes":
    """Draw the circular autocorrelation of the residuals up to half a period, and the 95 % band of white noise."""
    lines = wall_lines(result.laws, color, shaded)
    curves = {wall: residual_autocorrelation(result, wall) for wall in lines}
    for wall, rho in curves.items():
        ax.plot(rho["lag"].values, rho.values, **lines[wall])
    if curves:
        band = max(rho.attrs["white_noise"] for rho in curves.values())
        ax.axhspan(-band, band, color="0.9", zorder=0, label="white noise, 95 %")
    ax.set(xlim=(0, result.period / 2), ylim=(-1.05, 1.05))
    legend_above(ax, columns=3)
    return label_axes(ax, "lag [s]", "autocorrelation [1]")


def _plot_simulated(ax: "Axes", result: AnimalResult, quantity: str, color: str, shaded: bool) -> None:
    for wall, line in wall_lines(result.laws, color, shaded).items():
        values = result.laws[wall].simulated(quantity, result.root)
        ax.plot(_closed_time(values["time"], result), closed(values.values), **line)


def _closed_time(time: "xr.DataArray", result: AnimalResult) -> np.ndarray:
    return closed_time(time.values, result.period)
