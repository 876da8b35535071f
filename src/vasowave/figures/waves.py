"""Wave intensity with its named waves (the paper's figure "WIA")."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from vasowave.analysis import WaveIntensity


def plot_wave_intensity(
    ax: "Axes", waves: "WaveIntensity", period: float, named: "pd.DataFrame | None" = None
) -> "Axes":
    """Draw WI₊ and WI₋ of one station over one period (s); `named`, from `named_waves`, labels the peaks."""
    time = np.arange(len(waves.forward_intensity)) * period / len(waves.forward_intensity)
    ax.plot(time, waves.forward_intensity, color="black", linewidth=1, label="forward")
    ax.plot(time, waves.backward_intensity, color="black", linestyle="--", linewidth=1, label="backward")
    if named is not None:
        for wave, at, peak in zip(named["wave"], named["peak time [s]"], named["peak [W/cm2/s2]"]):
            offset = (0, 4) if peak > 0 else (0, -12)
            ax.annotate(wave, (at, peak), offset, textcoords="offset points", ha="center", fontsize="small")
    ax.margins(y=0.12)
    ax.axhline(0, color="0.7", linewidth=0.8, zorder=0)
    ax.set(xlabel="time [s]", ylabel="wave intensity [W/(cm² s²)]", xlim=(0, period))
    ax.legend(frameon=False)
    return ax


def plot_separated_pressure(ax: "Axes", waves: "WaveIntensity", period: float) -> "Axes":
    """Draw p₊ and p₋ of one station over one period (s); both start at p(0)."""
    time = np.arange(len(waves.forward_pressure)) * period / len(waves.forward_pressure)
    ax.plot(time, waves.forward_pressure, color="black", linewidth=1, label="forward")
    ax.plot(time, waves.backward_pressure, color="black", linestyle="--", linewidth=1, label="backward")
    ax.set(xlabel="time [s]", ylabel="pressure [mmHg]", xlim=(0, period))
    ax.legend(frameon=False)
    return ax
