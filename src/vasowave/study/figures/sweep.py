"""The effect of one or two parameters on the pressure at the root: waves, and systolic, mean and diastolic pressure."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.base.errors import InputError
from vasowave.study.figures.matplotlib_style import DATA, SCALE, WIDEST, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_HEIGHT = 7.0  # cm
_DASHES = ("solid", (0, (5, 2)), "dashdot", (0, (1, 1.2)), (0, (7, 2, 1, 2)))
"""Lines of the values of a second parameter."""


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
    figure = new_figure(WIDEST, _HEIGHT)
    waves, levels = figure.subplots(1, 2)
    _draw_waves(waves, dataset, axes)
    _draw_levels(levels, dataset, axes)
    return figure


def _draw_waves(ax: "Axes", dataset: "xr.Dataset", axes: list[str]) -> None:
    from matplotlib import colormaps

    values, unit = dataset[axes[0]].values, _unit(dataset, axes[0])
    shades = colormaps[SCALE](np.linspace(0.0, 0.9, len(values)))
    for i, value in enumerate(values):
        for dash, pressure in zip(_DASHES, _waves_of(dataset.isel({axes[0]: i})["root_pressure"], axes), strict=False):
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


def _waves_of(pressure: "xr.DataArray", axes: list[str]) -> list[np.ndarray]:
    """Return the waves of one value of the first parameter, one for every value of the second."""
    return list(pressure.transpose(axes[1], "time").values) if len(axes) == 2 else [pressure.values]
