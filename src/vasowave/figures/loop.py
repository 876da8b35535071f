"""Pressure-area loop at the middle of a vessel ("PAsim"): how each wall law stiffens."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vasowave import walls
from vasowave.calibration.result import Fit
from vasowave.figures.style import CTL, label_axes, wall_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_pressure_area(ax: "Axes", fits: Sequence[Fit], vessel: str | None = None, color: str = CTL) -> "Axes":
    """Draw pressure against area at the middle of `vessel` (default: the root), and thinly the law from p = 0 on."""
    network = fits[0].model.network
    row = network.root if vessel is None else network.row(vessel)
    for fit in fits:
        here = fit.simulation.sel(vessel=network.name[row], station="middle")
        # An elastic wall goes up and down the same curve; in order of pressure its dashes do not cover each other.
        order = np.argsort(here["pressure"].to_numpy())
        pressure, area = here["pressure"].to_numpy()[order], here["area"].to_numpy()[order]
        line = wall_line(fit.wall, color)
        law = type(fit.model.wall)(*(np.asarray(value)[row] for value in fit.model.wall))
        whole = np.linspace(0.0, pressure[0], 100)
        ax.plot(walls.area(law, whole, network.area0[row]), whole, **(line | {"linewidth": 0.8, "label": None}))
        ax.plot(area, pressure, **(line | {"linewidth": 2.2}))
    ax.axvline(network.area0[row], color="0.6", linewidth=0.8)
    ax.annotate("$A_0$", (network.area0[row], 1.0), xycoords=("data", "axes fraction"), xytext=(3, -9),
                textcoords="offset points", color="0.35")  # fmt: skip
    ax.legend()
    return label_axes(ax, "area [cm²]", "pressure [mmHg]")
