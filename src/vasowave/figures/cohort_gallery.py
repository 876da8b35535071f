"""The figures of a cohort, composed from the panels; each function returns one figure of the paper."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.animal.reading import data_of, network, wall_laws
from vasowave.figures.beats import plot_detected_beats, plot_ensemble
from vasowave.figures.fit import plot_autocorrelation, plot_residuals
from vasowave.figures.groups import plot_groups, plot_importance, plot_ratios, plot_waveforms
from vasowave.figures.loop import plot_pressure_area
from vasowave.figures.network import plot_network
from vasowave.figures.nominal import plot_decay, plot_upstroke
from vasowave.figures.spectra import plot_modulus, plot_phase
from vasowave.figures.starts import plot_waterfall
from vasowave.figures.style import GroupLook, group_looks, label_axes, new_figure, plain_log, wall_line
from vasowave.figures.waves import plot_separated_pressure, plot_wave_intensity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLUMN = 8.5  # cm, width of one group's panels
_LEAST_RANGE = 1.02  # differences far below a percent are agreement, and look like it
_WIDE_RANGE = 3.0  # a waterfall that rises more gets a logarithmic axis
Share = Literal["none", "row"]
Panel = Callable[["Axes", xr.DataTree, str], object]


@dataclass(frozen=True, eq=False)
class Cohort:
    """Animals in their groups, and the one of each group that stands for it where one is shown.

    Attributes
    ----------
    groups : dict of str to list of DataTree
    shown : dict of str to DataTree
    table : DataFrame
        From `cohort.cohort_table`: one row per animal and source.
    """

    groups: dict[str, list[xr.DataTree]]
    shown: dict[str, xr.DataTree]
    table: pd.DataFrame

    @cached_property
    def looks(self) -> dict[str, GroupLook]:
        """Color and marker of every group."""
        return group_looks(self.groups)

    @property
    def trees(self) -> list[xr.DataTree]:
        """All animals, group by group."""
        return [tree for trees in self.groups.values() for tree in trees]

    @property
    def walls(self) -> list[str]:
        """Wall laws that were calibrated in any animal."""
        return list(dict.fromkeys(wall for tree in self.trees for wall in wall_laws(tree)))

    def name(self, group: str) -> str:
        """Return how captions call the animal that stands for a group."""
        return f"{self.shown[group].attrs['animal']} ({group})"


def hemodynamics_figure(cohort: Cohort) -> "Figure":
    """Measured pressure, flow, impedance modulus and phase, one column per group ("hemoData")."""
    figure, axes = _grid(cohort, 4, 19)
    for column, (group, trees) in enumerate(cohort.groups.items()):
        color, shown = cohort.looks[group].color, cohort.shown[group].attrs["animal"]
        axes[0, column].set_title(f"{group} (n = {len(trees)}); black: {shown}")
        for row, quantity in enumerate(("pressure", "flow")):
            plot_waveforms(axes[row, column], trees, quantity, color, shown)
        for tree in sorted(trees, key=lambda tree: tree.attrs["animal"] == shown):
            first = tree.attrs["animal"] == shown
            line = {"linewidth": 1.8} if first else {"color": color, "linewidth": 0.8, "markersize": 2}
            plot_modulus(axes[2, column], data_of(tree, "measured/impedance"), **line)
            plot_phase(axes[3, column], data_of(tree, "measured/impedance"), **line)
    return _outer(figure, axes)


def networks_figure(cohort: Cohort) -> "Figure":
    """The directed graph of every group's network ("Network", c); the same one only once."""
    distinct: dict[bytes, list[str]] = {}
    for group, tree in cohort.shown.items():
        distinct.setdefault(data_of(tree, "network").to_dataframe().to_csv().encode(), []).append(group)
    trees = [cohort.shown[groups[0]] for groups in distinct.values()]
    heights = [min(40.0, max(4.0, 0.85 * len(network(tree).terminals))) for tree in trees]
    deepest = max(len(network(tree).generations) for tree in trees)
    figure = new_figure(min(60.0, max(12.0, 2.1 * deepest)), sum(heights))
    axes = figure.subplots(len(trees), 1, squeeze=False, height_ratios=heights)[:, 0]
    for ax, tree, groups in zip(axes, trees, distinct.values(), strict=True):
        plot_network(ax, network(tree), cohort.looks[groups[0]].color)
        ax.set_title(" and ".join(groups))
    return figure


def nominal_figure(cohort: Cohort) -> "Figure":
    """Slope Z_c and diastolic decay of each group's shown animal ("parEst", a and b)."""
    return _shown_figure(cohort, [plot_upstroke, plot_decay], 13, share="none")


def pressure_area_figure(cohort: Cohort) -> "Figure":
    """Pressure against area at the middle of the root vessel ("PAsim")."""
    return _shown_figure(cohort, [lambda ax, tree, color: plot_pressure_area(ax, tree, color=color)], 7.5)


def residuals_figure(cohort: Cohort) -> "Figure":
    """Residuals and their autocorrelation ("Residuals")."""
    figure = _shown_figure(cohort, [plot_residuals, plot_autocorrelation], 12.5)
    for ax, (group, tree) in zip(figure.axes, cohort.shown.items(), strict=False):
        errors = [f"{wall} {float(data_of(tree, f'{wall}/calibration')['RMSE']):.2f}" for wall in wall_laws(tree)]
        ax.set_title(f"{cohort.name(group)}\nRMSE [mmHg]: {', '.join(errors)}")
    return _shared_legend(figure, figure.axes[-1], 3)


def impedance_figure(cohort: Cohort) -> "Figure":
    """Measured and simulated impedance spectra ("Impd")."""

    def panel(plot: Callable[..., "Axes"]) -> Panel:
        def draw(ax: "Axes", tree: xr.DataTree, color: str) -> None:
            plot(ax, data_of(tree, "measured/impedance"), label="measured", linewidth=1.4)
            for wall in wall_laws(tree):
                plot(ax, data_of(tree, f"{wall}/impedance"), **(wall_line(wall, color) | {"markersize": 2}))

        return draw

    figure = _shown_figure(cohort, [panel(plot_modulus), panel(plot_phase)], 13)
    return _shared_legend(figure, figure.axes[0], 3)


def along_tree_figure(cohort: Cohort) -> "Figure":
    """Wave speed at mean pressure and fall of the mean pressure, against the distance from the inlet."""

    def panel(distance: str, quantity: str, label: str) -> Panel:
        def draw(ax: "Axes", tree: xr.DataTree, color: str) -> None:
            for wall in wall_laws(tree):
                data, line = data_of(tree, f"{wall}/tree"), wall_line(wall, color)
                face = {"linear": "none"}.get(wall, line["color"])
                ax.plot(data[distance], data[quantity], "o", color=line["color"], mfc=face, ms=4, label=line["label"])
            label_axes(ax, "distance from the inlet [cm]", label)

        return draw

    panels = [
        panel("distance", "wave_speed", "wave speed [cm/s]"),
        panel("terminal_distance", "mean_drop", "pressure drop [mmHg]"),
    ]
    figure = _shown_figure(cohort, panels, 12)
    return _shared_legend(figure, figure.axes[0], 2)


def waves_figure(cohort: Cohort, group: str) -> "Figure":
    """Separated pressure and wave intensity of a group's shown animal, measured and of each wall law ("WIA")."""
    tree, color = cohort.shown[group], cohort.looks[group].color
    sources = ["measured", *wall_laws(tree)]
    figure = new_figure(17, 1.5 + 4.8 * len(sources))
    axes = figure.subplots(len(sources), 2, sharex=True, sharey="col", squeeze=False)
    for row, source in enumerate(sources):
        plot_separated_pressure(axes[row, 0], data_of(tree, f"{source}/waves"), color)
        plot_wave_intensity(axes[row, 1], data_of(tree, f"{source}/waves"), color)
        axes[row, 0].set_title(source if source == "measured" else f"{source} wall")
    for ax in axes[:-1].flat:
        ax.set_xlabel("")
    return _shared_legend(figure, axes[0, 0], 3)


def boxes_figure(cohort: Cohort, quantities: dict[str, str], sources: Sequence[str]) -> "Figure":
    """Box-and-whisker plots of quantities, one panel each ("ParOpt"); the linear wall is hatched.

    Parameters
    ----------
    cohort : Cohort
    quantities : dict of str to str
        Column of the table to label of the axis.
    sources : sequence of str
        Of the table's column ``source``; each panel shows those that have the quantity.
    """
    table = cohort.table[cohort.table["source"].isin(sources)]
    columns = min(len(quantities), 4)
    rows = -(-len(quantities) // columns)
    width = max(4.3, 1.6 + 0.75 * len(cohort.groups) * len(sources))
    figure = new_figure(max(8.0, width * columns), 5.2 * rows)
    axes = figure.subplots(rows, columns, squeeze=False)
    for ax, (quantity, label) in zip(axes.flat, quantities.items(), strict=False):
        there = table[np.isfinite(table[quantity].astype(float))]
        plot_groups(ax, there, quantity, label)
    for ax in axes.flat[len(quantities) :]:
        ax.remove()
    return figure


def importance_figure(cohort: Cohort, measured: pd.DataFrame, modeled: pd.DataFrame) -> "Figure":
    """Importance index of the data's indices and of the models' parameters ("ParAll_change")."""
    parts = [part for part in (measured, modeled) if len(part)]
    figure = new_figure(9.0 * len(parts), max(5.0, 2.6 + 0.85 * max(part["quantity"].nunique() for part in parts)))
    for ax, part in zip(figure.subplots(1, len(parts), squeeze=False)[0], parts, strict=True):
        plot_importance(ax, part, cohort.looks)
    return figure


def ratios_figure(contrasts: pd.DataFrame) -> "Figure":
    """Ratios of geometric means with their intervals."""
    figure = new_figure(15, 2.2 + 0.55 * len(contrasts))
    plot_ratios(figure.subplots(), contrasts)
    return figure


def waterfall_figure(cohort: Cohort) -> "Figure":
    """Where the starts ended, one panel per wall law, one line per animal."""
    figure = new_figure(_COLUMN * max(1, len(cohort.walls)), 7)
    axes = figure.subplots(1, len(cohort.walls), squeeze=False, sharey=True)[0]
    for ax, wall in zip(axes, cohort.walls, strict=True):
        for group, trees in cohort.groups.items():
            look = cohort.looks[group]
            for place, tree in enumerate(tree for tree in trees if wall in wall_laws(tree)):
                label = group if place == 0 else None
                plot_waterfall(
                    ax, data_of(tree, f"{wall}/calibration"), color=look.color, marker=look.marker, label=label
                )
        ax.set_title(f"{wall} wall")
    for ax in axes[1:]:
        ax.set_ylabel("")
    axes[0].legend()
    highest = max(ax.get_ylim()[1] for ax in axes)
    axes[0].set_ylim(top=max(highest, _LEAST_RANGE))
    axes[0].ticklabel_format(axis="y", useOffset=False)
    if highest > _WIDE_RANGE:
        axes[0].set_yscale("log")
        plain_log(axes[0].yaxis)
    return figure


def beats_figure(tree: xr.DataTree) -> "Figure":
    """What was detected and kept of one animal's continuous recording, and the averaged cycle."""
    signals = [name for name in ("ecg", "pressure", "flow") if f"trace_{name}" in data_of(tree, "beats").data_vars]
    figure = new_figure(17, 3.6 * len(signals) + 5.6)
    rows: list[Any] = [[name, name] for name in signals]
    axes = figure.subplot_mosaic([*rows, ["p", "q"]])
    for place, name in enumerate(signals):
        plot_detected_beats(axes[name], data_of(tree, "beats"), name)
        if place > 0:
            _without_legend(axes[name])
        if place < len(signals) - 1:
            axes[name].set_xlabel("")
    for panel, name in (("p", "pressure"), ("q", "flow")):
        plot_ensemble(axes[panel], tree, name)
    return figure


def _shown_figure(cohort: Cohort, panels: Sequence[Panel], height: float, share: Share = "row") -> "Figure":
    """Draw the panels, one row each, for the shown animal of each group, one column each."""
    figure, axes = _grid(cohort, len(panels), height, share)
    for column, (group, tree) in enumerate(cohort.shown.items()):
        for row, panel in enumerate(panels):
            panel(axes[row, column], tree, cohort.looks[group].color)
        axes[0, column].set_title(cohort.name(group))
    return figure if share == "none" else _outer(figure, axes)


def _grid(cohort: Cohort, rows: int, height: float, share: Share = "row") -> tuple["Figure", np.ndarray]:
    figure = new_figure(max(11.0, _COLUMN * len(cohort.groups)), height)
    return figure, figure.subplots(rows, len(cohort.groups), squeeze=False, sharey=share)


def _outer(figure: "Figure", axes: np.ndarray) -> "Figure":
    """Leave the labels of shared axes to the outer panels."""
    for ax in axes[:, 1:].flat:
        ax.set_ylabel("")
    return figure


def _shared_legend(figure: "Figure", ax: "Axes", columns: int) -> "Figure":
    for panel in figure.axes:
        _without_legend(panel)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=columns)
    return figure


def _without_legend(ax: "Axes") -> None:
    if legend := ax.get_legend():
        legend.remove()
