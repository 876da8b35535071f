"""Pressure-area loop at the middle of the root vessel ("PAsim"): how each wall law stiffens."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.animal.reading import law_curve
from vasowave.animal.result import AnimalResult
from vasowave.figures.style import CTL, FAINT, label_axes, wall_lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_pressure_area(ax: "Axes", result: AnimalResult, color: str = CTL, shaded: bool = True) -> "Axes":
    """Draw pressure against area at the middle of the root vessel over the cycle, and thinly the law, if stored."""
    vessels, root = result.network, result.root
    for wall, line in wall_lines(result.laws, color, shaded).items():
        pressure, area = (result.laws[wall].simulated(what, root, "middle").values for what in ("pressure", "area"))
        # An elastic wall goes up and down the same curve; in order of pressure its dashes do not cover each other.
        order = np.argsort(pressure)
        if (curve := law_curve(result.laws[wall])) is not None:
            ax.plot(*reversed(curve), **(line | {"linewidth": 0.8, "label": None}))
        ax.plot(area[order], pressure[order], **(line | {"linewidth": 2.2}))
    at_rest = vessels.area[vessels.root]
    ax.axvline(at_rest, color=FAINT, linewidth=0.8)
    ax.annotate("A₀", (at_rest, 1.0), xycoords=("data", "axes fraction"), xytext=(3, -2), textcoords="offset points",
                va="top", color="0.35")  # fmt: skip
    ax.locator_params(axis="x", nbins=5)
    ax.legend(handlelength=3.2)
    return label_axes(ax, "area [cm²]", "pressure [mmHg]")
