"""What a change does to the waves at the inlet of the root: before and after."""

from typing import TYPE_CHECKING

from vasowave.study.figures.matplotlib_style import DATA, HPH, LABELS, WIDEST, label_axes, new_figure, style

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_HEIGHT = 6.5  # cm
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
