"""What was observed at further sites, beside the fit and what the fit without each site predicts."""

from typing import TYPE_CHECKING

import xarray as xr

from vasowave.animal.result import AnimalResult
from vasowave.figures.style import (
    CTL,
    DATA,
    FAINT,
    NARROW,
    WIDEST,
    closed,
    closed_time,
    label_axes,
    new_figure,
    short,
    wall_lines,
)
from vasowave.recording.observation import NUMBERS

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ABREAST = 2  # panels in a row
_HEIGHT = 5.5  # of a row, cm
_TITLE = 44  # letters
_NUMBERS = "mean, largest or smallest value"
_WIDE = 3.0  # pt: a prediction shows on both sides of a fit that lies on it


def sites_of(result: AnimalResult) -> dict[str, xr.Dataset]:
    """Return what is known of further sites, by wall law."""
    return {wall: law.sites for wall, law in result.laws.items() if law.sites is not None}


def sites_figure(result: AnimalResult, color: str = CTL) -> "Figure":
    """Return a panel for every further site of an animal."""
    data = next(iter(sites_of(result).values()))
    count = data.sizes["site"]
    rows = -(-count // _ABREAST)
    figure = new_figure(NARROW if count == 1 else WIDEST, _HEIGHT * rows)
    axes = figure.subplots(rows, min(count, _ABREAST), squeeze=False).ravel()
    for site in range(count):
        plot_site(axes[site], result, site, color)
    for spare in axes[count:]:
        spare.set_axis_off()
    said = {label: drawn for ax in axes for drawn, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    figure.legend(said.values(), said.keys(), loc="outside upper center", ncols=2)
    return figure


def plot_site(ax: "Axes", result: AnimalResult, site: int, color: str = CTL) -> "Axes":
    """Draw one site over a cycle: observed, with each wall law, and predicted without it by the first of them."""
    laws = sites_of(result)
    lines = wall_lines(laws, color)
    for place, (wall, data) in enumerate(laws.items()):
        one = data.isel(site=site)
        time = closed_time(one["time"].values, result.period)
        if place == 0:
            _observed(ax, one, time)
            ax.plot(time, closed(one["predicted"].values), color=FAINT, linewidth=_WIDE, label="predicted without it")
        ax.plot(time, closed(one["simulated"].values), **lines[wall])
    ax.set_title(short(str(one["site"].values), _TITLE), fontsize="medium")
    return label_axes(ax, "time [s]", f"{one['observed'].item()} [{one['unit'].item()}]")


def _observed(ax: "Axes", one: xr.Dataset, time: "np.ndarray") -> None:
    if one["measured"].notnull().any():
        ax.plot(time, closed(one["measured"].values), color=DATA, label="observed")
    for name in NUMBERS:
        if one[name].notnull():
            ax.axhline(float(one[name]), color=DATA, linestyle=":", label=f"observed: {_NUMBERS}")
