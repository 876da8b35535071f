"""Separated waves and wave intensity with its named waves (the paper's figure "WIA")."""

from typing import TYPE_CHECKING

from vasowave.animal.reading import largest_waves
from vasowave.figures.style import DATA, FAINT, label_axes, wave_line

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes


def plot_wave_intensity(ax: "Axes", waves: "xr.Dataset", color: str = DATA) -> "Axes":
    """Draw WI₊ and WI₋ over time/T (eq. 16), and at their peaks the names of the largest wave of each kind."""
    time = waves["normalized_time"].values
    ax.plot(time, waves["WI_plus"].values, **wave_line("forward", color))
    ax.plot(time, waves["WI_minus"].values, **wave_line("backward", color))
    for name, row in largest_waves(waves).items():
        at, peak = float(waves["wave_time"][row]) / waves.attrs["period"], float(waves["wave_peak"][row])
        offset, place = ((0, 3), "bottom") if peak > 0 else ((0, -3), "top")
        ax.annotate(name, (at, peak), offset, textcoords="offset points", ha="center", va=place, fontsize="small")
    ax.margins(y=0.18)
    ax.axhline(0, color=FAINT, linewidth=0.8, zorder=0)
    ax.set_xlim(0, 1)
    return label_axes(ax, "time/T [1]", "intensity [W/(cm² s²)]")


def plot_separated_pressure(ax: "Axes", waves: "xr.Dataset", color: str = DATA) -> "Axes":
    """Draw p₊ and p₋ over time/T (eq. 15) and the pressure that they make up; both start at p(0)."""
    time = waves["normalized_time"].values
    ax.plot(time, waves["pressure"].values, color=DATA, linewidth=1, label="pressure")
    ax.plot(time, waves["p_plus"].values, **wave_line("forward", color))
    ax.plot(time, waves["p_minus"].values, **wave_line("backward", color))
    ax.set_xlim(0, 1)
    return label_axes(ax, "time/T [1]", "pressure [mmHg]")
