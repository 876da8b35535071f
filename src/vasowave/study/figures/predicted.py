"""What a change, or a sweep, of parameters does to the waves at the root, and which matters for which quantity."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.base.errors import InputError
from vasowave.study.figures.matplotlib_style import CTL, DATA, HPH, LABELS, SCALE, WIDEST, label_axes, new_figure, style

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_HEIGHT, _SWEEP_HEIGHT = 6.5, 7.0  # cm
_PANELS = 5  # quantities, the first of the table: pressures and the power of the ventricle
_LOOKS = (("before", DATA, "solid"), ("after", HPH, (0, (5, 2))))
"""Name, color and line of each end."""
_DASHES = ("solid", (0, (5, 2)), "dashdot", (0, (1, 1.2)), (0, (7, 2, 1, 2)))
"""Lines of the values of a second parameter."""


def predicted_figure(ends: "tuple[xr.Dataset, xr.Dataset]", root: str, change: str) -> "Figure":
    """Draw pressure and flow at the inlet of the root over one cycle, before and after a change."""
    with style():
        figure = new_figure(WIDEST, _HEIGHT)
        for ax, signal in zip(figure.subplots(1, 2), ("pressure", "flow"), strict=True):
            for (name, color, dash), waves in zip(_LOOKS, ends, strict=True):
                wave = waves[signal].sel(vessel=root, station="inlet")
                ax.plot(1e3 * wave["time"].values, wave.values, color=color, linestyle=dash, label=name)
            label_axes(ax, "time [ms]", LABELS[signal])
        figure.axes[0].set_title(f"{change} of the fit")
        figure.axes[0].legend(loc="upper right")
    return figure


def sensitivity_figure(table: "pd.DataFrame") -> "Figure":
    """Draw Sobol' indices of first and total order, a panel for each quantity, with their 95 % intervals."""
    names, parameters = table.index.unique("quantity")[:_PANELS], [*table.index.unique("parameter")]
    with style():
        figure = new_figure(WIDEST, _HEIGHT)
        panels = figure.subplots(1, len(names), sharey=True)
        for ax, name in zip(panels, names, strict=True):
            rows = table.loc[name]
            for order, color, shift in (("first", DATA, -0.18), ("total", CTL, 0.18)):
                middle, low, high = (rows[f"{order}{end}"].to_numpy() for end in ("", "_low", "_high"))
                places = np.arange(len(parameters)) + shift
                ax.barh(places, middle, 0.34, color=color, label=order, xerr=(middle - low, high - middle))
            label_axes(ax, "share of variance", "")
            ax.set(title=name, xlim=(0, 1.05))
        panels[0].set_yticks(range(len(parameters)), parameters)
        panels[0].invert_yaxis()
        panels[-1].legend(loc="lower right")
    return figure


def sweep_figure(dataset: "xr.Dataset") -> "Figure":
    """Draw a sweep: pressure at the root over one cycle, and its systole, mean and diastole over the first parameter.

    Color is the first parameter, the kind of line the second.

    Raises
    ------
    InputError
        More than two parameters, or more values of the second than there are kinds of lines.
    """
    axes = [str(name) for name in dataset["mach"].dims]
    if len(axes) > 2 or (len(axes) == 2 and dataset.sizes[axes[1]] > len(_DASHES)):
        raise InputError(
            f"a plot shows one parameter, and a second of at most {len(_DASHES)} values; draw the CSV or netCDF instead"
        )
    figure = new_figure(WIDEST, _SWEEP_HEIGHT)
    waves, levels = figure.subplots(1, 2)
    _draw_waves(waves, dataset, axes)
    _draw_levels(levels, dataset, axes)
    return figure


def _draw_waves(ax: "Axes", dataset: "xr.Dataset", axes: list[str]) -> None:
    from matplotlib import colormaps

    values, unit = dataset[axes[0]].values, _unit(dataset, axes[0])
    shades = colormaps[SCALE](np.linspace(0.0, 0.9, len(values)))
    for i, value in enumerate(values):
        pressures = dataset["root_pressure"].isel({axes[0]: i}).transpose(*axes[1:], "time").values
        for dash, pressure in zip(_DASHES, np.atleast_2d(pressures), strict=False):
            ends = i in (0, len(values) - 1) and dash == _DASHES[0]
            label = f"{axes[0]} {value:.4g} {unit}".strip() if ends else None
            ax.plot(1e3 * dataset["time"].values, pressure, color=shades[i], linestyle=dash, label=label)
    ax.set(xlabel="time [ms]", ylabel="pressure at the root [mmHg]")
    ax.legend(handlelength=3.5, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)


def _draw_levels(ax: "Axes", dataset: "xr.Dataset", axes: list[str]) -> None:
    pressure = dataset["root_pressure"].transpose(axes[0], ..., "time")
    levels_by_name = {
        "systolic": pressure.max("time"),
        "mean": pressure.mean("time"),
        "diastolic": pressure.min("time"),
    }
    for (name, level), marker in zip(levels_by_name.items(), ("^", "o", "v"), strict=True):
        for j, dash in enumerate(_DASHES[: dataset.sizes[axes[1]] if len(axes) == 2 else 1]):
            second = f", {axes[1]} {float(dataset[axes[1]][j]):.4g}" if len(axes) == 2 else ""
            values = level.isel({axes[1]: j}) if second else level
            label = f"{name}{second}" if name == "mean" else name if j == 0 else None
            ax.plot(
                dataset[axes[0]].values, values, color=DATA, linestyle=dash, marker=marker, markersize=3, label=label
            )
    unit = _unit(dataset, axes[0])
    ax.set(xlabel=f"{axes[0]} [{unit}]" if unit else axes[0], ylabel="pressure at the root [mmHg]")
    ax.legend(handlelength=3.5, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)


def _unit(dataset: "xr.Dataset", name: str) -> str:
    """Return the unit of a parameter, empty where it has none."""
    unit = str(dataset[name].attrs.get("units", "1"))
    return "" if unit == "1" else unit
