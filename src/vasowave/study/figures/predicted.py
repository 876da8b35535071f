"""What a change does to the waves at the inlet of the root, and which parameter matters for which quantity."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.study.figures.matplotlib_style import CTL, DATA, HPH, LABELS, WIDEST, label_axes, new_figure, style

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

_HEIGHT = 6.5  # cm
_PANELS = 5  # quantities, the first of the table: pressures and the power of the ventricle
_LOOKS = (("before", DATA, "solid"), ("after", HPH, (0, (5, 2))))
"""Name, color and line of each end."""


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
