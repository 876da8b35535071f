"""The figures of one calibrated animal, composed from the panels, and their files."""

import io
from typing import TYPE_CHECKING

from vasowave.animal.reading import network
from vasowave.figures.fit import plot_flow, plot_pressure, plot_residuals
from vasowave.figures.loop import plot_pressure_area
from vasowave.figures.network import plot_network
from vasowave.figures.nominal import plot_decay, plot_upstroke
from vasowave.figures.style import CTL, new_figure, style
from vasowave.figures.tree import main_vessels, plot_vessel

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_NO_METADATA = {"Date": None, "Creator": None, "Format": None, "Type": None}


def gallery(tree: "xr.DataTree", color: str = CTL) -> dict[str, "Figure"]:
    """Return the figures of one animal by name: fit, nominal, tree, loop, network.

    Parameters
    ----------
    tree : DataTree
        Of one animal: ``recording``, ``network``, ``nominal``, and ``calibration`` and ``simulation`` of each wall law.
    color : str
        The group's color, see `figures.style`.
    """
    with style():
        return {
            "fit": fit_figure(tree, color),
            "nominal": nominal_figure(tree, color),
            "tree": tree_figure(tree, color),
            "loop": loop_figure(tree, color),
            "network": network_figure(tree, color),
        }


def fit_figure(tree: "xr.DataTree", color: str = CTL) -> "Figure":
    """Measured and fitted pressure and flow, and the residuals."""
    figure = new_figure(17, 12)
    panels = figure.subplot_mosaic([["p", "q"], ["r", "r"]], height_ratios=[3, 2])
    plot_pressure(panels["p"], tree, color)
    plot_flow(panels["q"], tree, color)
    plot_residuals(panels["r"], tree, color)
    return figure


def nominal_figure(tree: "xr.DataTree", color: str = CTL) -> "Figure":
    """Pressure-flow loop with the slope Z_c, and diastolic decay with its time constant."""
    figure = new_figure(17, 7.5)
    left, right = figure.subplots(1, 2)
    plot_upstroke(left, tree, color)
    plot_decay(right, tree, color)
    return figure


def tree_figure(tree: "xr.DataTree", color: str = CTL) -> "Figure":
    """Pressure and flow at the middle of the vessels that carry most flow: one column each, one scale a row."""
    whole = network(tree)
    vessels = main_vessels(whole)
    figure = new_figure(max(8.0, 1.5 + 3.4 * len(vessels)), 10)
    axes = figure.subplots(2, len(vessels), sharex=True, sharey="row", squeeze=False)
    for column, vessel in enumerate(vessels):
        for row, quantity in enumerate(("pressure", "flow")):
            ax = plot_vessel(axes[row, column], tree, vessel, quantity, color)
            ax.label_outer()
            ax.locator_params(axis="x", nbins=3)
        share = 100 * whole.flow_fraction[whole.row(vessel)]
        axes[0, column].set_title(f"vessel {vessel} ({share:.0f} %)")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def loop_figure(tree: "xr.DataTree", color: str = CTL) -> "Figure":
    """Pressure-area loop at the middle of the root vessel."""
    figure = new_figure(11, 8)
    plot_pressure_area(figure.subplots(), tree, color=color)
    return figure


def network_figure(tree: "xr.DataTree", color: str = CTL) -> "Figure":
    """The directed graph of the network with flow fractions."""
    whole = network(tree)
    height = min(60.0, max(5.0, 1.0 * len(whole.terminals)))
    figure = new_figure(min(60.0, max(12.0, 2.1 * len(whole.generations))), height)
    plot_network(figure.subplots(), whole, color)
    return figure


def svg(figure: "Figure") -> str:
    """Return the figure as SVG text with editable letters and no reference to anything outside."""
    text = io.StringIO()
    with style():
        figure.savefig(text, format="svg", metadata=_NO_METADATA)
    return text.getvalue()


def png(figure: "Figure") -> bytes:
    """Return the figure as pixels, 200 dpi."""
    data = io.BytesIO()
    with style():
        figure.savefig(data, format="png", metadata={"Software": None})
    return data.getvalue()
