"""Pressure-area loop at the middle of a vessel ("PAsim"): how each wall law stiffens."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave import walls
from vasowave.animal.reading import network, simulated, wall_laws, wall_of
from vasowave.figures.style import CTL, FAINT, label_axes, wall_line

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes


def plot_pressure_area(ax: "Axes", tree: "xr.DataTree", vessel: str | None = None, color: str = CTL) -> "Axes":
    """Draw pressure against area at the middle of `vessel` (default: the root), and thinly the law from p = 0 on."""
    vessels = network(tree)
    row = vessels.root if vessel is None else vessels.row(vessel)
    name = vessels.name[row]
    for wall in wall_laws(tree):
        pressure, area = (simulated(tree, wall, what, name, "middle").values for what in ("pressure", "area"))
        # An elastic wall goes up and down the same curve; in order of pressure its dashes do not cover each other.
        order = np.argsort(pressure)
        line = wall_line(wall, color)
        whole = np.linspace(0.0, pressure.min(), 100)
        law = walls.area(wall_of(tree, wall, name), whole, vessels.area0[row])
        ax.plot(law, whole, **(line | {"linewidth": 0.8, "label": None}))
        ax.plot(area[order], pressure[order], **(line | {"linewidth": 2.2}))
    ax.axvline(vessels.area0[row], color=FAINT, linewidth=0.8)
    ax.annotate("A₀", (vessels.area0[row], 1.0), xycoords=("data", "axes fraction"), xytext=(3, -2),
                textcoords="offset points", va="top", color="0.35")  # fmt: skip
    ax.locator_params(axis="x", nbins=5)
    ax.legend()
    return label_axes(ax, "area [cm²]", "pressure [mmHg]")
