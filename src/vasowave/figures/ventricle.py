"""The ventricle that ejects into the network: its pressure, and its loop of pressure and volume."""

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from vasowave.figures.style import CTL, DATA, FAINT, WIDEST, label_axes, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_HEIGHT = 6.0  # cm
_TOP = 1.6  # times the isovolumic peak: the legend stands above the curves


def ventricle_figure(data: xr.Dataset, color: str = CTL) -> "Figure":
    """Return pressure over time beside pressure over volume, of `AnimalResult.ventricle`."""
    figure = new_figure(WIDEST, _HEIGHT)
    over_time, over_volume = figure.subplots(1, 2)
    plot_pressure(over_time, data, color)
    plot_loop(over_volume, data, color)
    return figure


def plot_pressure(ax: "Axes", data: xr.Dataset, color: str = CTL) -> "Axes":
    """Draw the pressure of the ventricle as measured, as fitted, and as it would be if nothing left it."""
    time = 1000 * data["time"].to_numpy()
    ax.plot(time, data["isovolumic_pressure"], color=FAINT, linestyle="--", label="if nothing left it")
    ax.plot(time, data["pressure"], color=DATA, linewidth=2.2, label="measured")
    ax.plot(time, data["fitted_pressure"], color=color, label="by elastance and flow")
    ax.legend(loc="upper right")
    ax.set_ylim(0, _TOP * float(data["isovolumic_pressure"].max()))
    return label_axes(ax, "time [ms]", "pressure [mmHg]")


def plot_loop(ax: "Axes", data: xr.Dataset, color: str = CTL) -> "Axes":
    """Draw pressure over volume, with the lines whose slopes are the elastances of ventricle and artery."""
    volume, pressure = 1000 * data["volume"].to_numpy(), data["pressure"].to_numpy()
    ax.plot(volume, pressure, color=DATA, linewidth=2.2)
    isovolumic = data["isovolumic_pressure"].to_numpy()
    peak = int(np.argmax(isovolumic))
    filled = float(volume[0])
    top, at = float(isovolumic[peak]), (volume[peak], data["fitted_pressure"].to_numpy()[peak])
    ax.plot([0, filled], [0, top], color=color, label="E_es, the ventricle's")
    ax.plot([filled, filled - 1000 * float(data["stroke_volume"])], [0, at[1]], color=color, linestyle=":",
            label="−E_a, the artery's")  # fmt: skip
    ax.set_xlim(0, 1.05 * filled)
    ax.set_ylim(0, _TOP * top)
    ax.legend(loc="upper right")
    return label_axes(ax, "volume above V₀ [µl]", "pressure [mmHg]")
