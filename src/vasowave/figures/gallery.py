"""The figures of one calibrated animal, composed from the panels, and their files."""

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from vasowave.calibration.result import Fit
from vasowave.figures.fit import plot_flow, plot_pressure, plot_residuals
from vasowave.figures.loop import plot_pressure_area
from vasowave.figures.network import plot_network
from vasowave.figures.nominal import plot_decay, plot_upstroke
from vasowave.figures.style import CTL, new_figure, style
from vasowave.figures.tree import main_vessels, plot_vessel

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NO_METADATA = {"Date": None, "Creator": None, "Format": None, "Type": None}


def gallery(fits: Sequence[Fit], color: str = CTL) -> dict[str, "Figure"]:
    """Return the figures of one animal by name: fit, nominal, tree, loop, network.

    Parameters
    ----------
    fits : sequence of Fit
        One per wall law, of the same recording.
    color : str
        The group's color, see `figures.style`.
    """
    with style():
        return {
            "fit": fit_figure(fits, color),
            "nominal": nominal_figure(fits[0], color),
            "tree": tree_figure(fits, color),
            "loop": loop_figure(fits, color),
            "network": network_figure(fits[0], color),
        }


def fit_figure(fits: Sequence[Fit], color: str = CTL) -> "Figure":
    """Measured and fitted pressure and flow, and the residuals."""
    figure = new_figure(17, 12)
    panels = figure.subplot_mosaic([["p", "q"], ["r", "r"]], height_ratios=[3, 2])
    plot_pressure(panels["p"], fits, color)
    plot_flow(panels["q"], fits, color)
    plot_residuals(panels["r"], fits, color)
    return figure


def nominal_figure(fit: Fit, color: str = CTL) -> "Figure":
    """Pressure-flow loop with the slope Z_c, and diastolic decay with its time constant."""
    figure = new_figure(17, 7.5)
    left, right = figure.subplots(1, 2)
    plot_upstroke(left, fit.nominal, fit.recording, color)
    plot_decay(right, fit.nominal, fit.recording, color)
    return figure


def tree_figure(fits: Sequence[Fit], color: str = CTL) -> "Figure":
    """Pressure and flow at the middle of the vessels that carry most flow: one column each, one scale a row."""
    network = fits[0].model.network
    vessels = main_vessels(network)
    figure = new_figure(max(8.0, 1.5 + 3.4 * len(vessels)), 10)
    axes = figure.subplots(2, len(vessels), sharex=True, sharey="row", squeeze=False)
    for column, vessel in enumerate(vessels):
        for row, quantity in enumerate(("pressure", "flow")):
            ax = plot_vessel(axes[row, column], fits, vessel, quantity, color)
            ax.label_outer()
            ax.locator_params(axis="x", nbins=3)
        share = 100 * network.flow_fraction[network.row(vessel)]
        axes[0, column].set_title(f"vessel {vessel} ({share:.0f} %)")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def loop_figure(fits: Sequence[Fit], color: str = CTL) -> "Figure":
    """Pressure-area loop at the middle of the root vessel."""
    figure = new_figure(11, 8)
    plot_pressure_area(figure.subplots(), fits, color=color)
    return figure


def network_figure(fit: Fit, color: str = CTL) -> "Figure":
    """The directed graph of the network with flow fractions."""
    network = fit.model.network
    height = min(60.0, max(5.0, 1.0 * len(network.terminals)))
    figure = new_figure(min(60.0, max(12.0, 2.1 * len(network.generations))), height)
    plot_network(figure.subplots(), network, color)
    return figure


def svg(figure: "Figure") -> str:
    """Return the figure as SVG text with editable letters and no reference to anything outside."""
    page = io.StringIO()
    with style():
        figure.savefig(page, format="svg", metadata=_NO_METADATA)
    return page.getvalue()


def write_figures(figures: dict[str, "Figure"], folder: Path) -> list[Path]:
    """Write every figure to `folder` as SVG and PNG, and return the paths."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, figure in figures.items():
        vector, pixels = folder / f"{name}.svg", folder / f"{name}.png"
        vector.write_text(svg(figure), encoding="utf-8")
        with style():
            figure.savefig(pixels, format="png", metadata={"Software": None})
        written += [vector, pixels]
    return written
