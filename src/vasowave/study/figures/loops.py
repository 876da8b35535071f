"""The figure of loops of pressure and volume, with the line through their corners."""

from typing import TYPE_CHECKING

import xarray as xr

from vasowave.study.figures.matplotlib_style import CTL, DATA, HPH, NARROW, label_axes, new_figure, shown_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_HEIGHT = 8.0  # cm
_FAMILY = "#8c8c8c"
_TOP = 1.35  # times the highest pressure: the legend stands above the loops


def loops_figure(loops: xr.Dataset, color: str = CTL) -> "Figure":
    """Return the figure of `plot_loops`."""
    figure = new_figure(NARROW, _HEIGHT)
    plot_loops(loops, figure.subplots(), color)
    return figure


def plot_loops(loops: xr.Dataset, ax: "Axes | None" = None, color: str = CTL) -> "Axes":
    """Draw `AnimalResult.loops`: steady ones black, those of the family grey, with corners and end-systolic line."""
    ax = ax or shown_figure(NARROW, _HEIGHT).subplots()
    scale, unit = (1000.0, "µl") if loops["volume"].max() < 1.0 else (1.0, "ml")
    volume, pressure = scale * loops["volume"].to_numpy(), loops["pressure"].to_numpy()
    steady, family = (loops[name].to_numpy().astype(bool) for name in ("steady", "family"))
    for chosen, color_of_loops, width in ((~steady, _FAMILY, 0.7), (steady, DATA, 1.0)):
        ax.plot(volume[chosen].T, pressure[chosen].T, color=color_of_loops, linewidth=width)
    cornered = family if family.any() else steady
    corners = loops.isel(loop=cornered)
    ax.plot(scale * corners["end_systolic_volume"], corners["end_systolic_pressure"], "o", color=color, markersize=4,
            label="end of systole")  # fmt: skip
    if "line_volume" in loops:
        ax.plot(scale * loops["line_volume"], loops["line_pressure"], color=color, linestyle="dashed", label="E_es")
    ax.plot(volume[cornered, 0], pressure[cornered, 0], "s", color=HPH, markersize=3.5, markerfacecolor="none",
            label="end of diastole")  # fmt: skip
    ax.legend(loc="upper left", ncols=2)
    ax.set_ylim(min(0.0, pressure.min()), _TOP * pressure.max())
    return label_axes(ax, f"volume [{unit}]", "pressure [mmHg]")
