"""The figure of loops of pressure and volume, with the lines through their corners."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.pulse.analysis.ventricular_function import VentricularFunction
from vasowave.study.figures.matplotlib_style import CTL, DATA, HPH, NARROW, label_axes, new_figure, shown_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_HEIGHT = 8.0  # cm
_FAMILY = "#8c8c8c"
_TOP = 1.35  # times the highest pressure: the legend stands above the loops


def loops_figure(function: VentricularFunction, color: str = CTL) -> "Figure":
    """Return the figure of `plot_loops`."""
    figure = new_figure(NARROW, _HEIGHT)
    plot_loops(function, figure.subplots(), color)
    return figure


def plot_loops(function: VentricularFunction, ax: "Axes | None" = None, color: str = CTL) -> "Axes":
    """Draw the loops: steady ones black, those of the family grey, with their corners and the end-systolic line."""
    if ax is None:
        ax = shown_figure(NARROW, _HEIGHT).subplots()
    largest = max(float(loop.volume.max()) for loop in function.loops)
    scale, unit = (1000.0, "µl") if largest < 1.0 else (1.0, "ml")
    steady = set(function.steady)
    drawn = [*(n for n in function.family if n not in steady), *function.steady]
    for number in drawn:
        loop = function.loops[number]
        color_of_loop, width = (DATA, 1.0) if number in steady else (_FAMILY, 0.7)
        ax.plot(scale * loop.volume, loop.pressure, color=color_of_loop, linewidth=width)
    cornered = [function.loops[number] for number in function.family or function.steady]
    zero = function.estimates["V_0"].value if "E_es" in function.estimates else None
    corners = np.array([loop.end_systole(zero) for loop in cornered])
    ax.plot(scale * corners[:, 0], corners[:, 1], "o", color=color, markersize=4, label="end of systole")
    if zero is not None:
        ends = np.array([max(zero, -0.1 * largest), corners[:, 0].max()])
        slope = function.estimates["E_es"].value
        ax.plot(scale * ends, slope * (ends - zero), color=color, linestyle="dashed", label="E_es")
    ax.plot([scale * loop.volume[0] for loop in cornered], [loop.pressure[0] for loop in cornered], "s", color=HPH,
            markersize=3.5, markerfacecolor="none", label="end of diastole")  # fmt: skip
    ax.legend(loc="upper left", ncols=2)
    ax.set_ylim(min(0.0, *(loop.pressure.min() for loop in function.loops)),
                _TOP * max(loop.pressure.max() for loop in function.loops))  # fmt: skip
    return label_axes(ax, f"volume [{unit}]", "pressure [mmHg]")
