"""The figures of what the calibrated models say: fits, waves, impedance, starts, vessels along the network, sites."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from vasowave.pulse.cycle.observation import NUMBERS
from vasowave.pulse.network.network import Network
from vasowave.study.animal.reading import impedance_error, largest_waves
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.figures.fit import (
    FitPanel,
    plot_autocorrelation,
    plot_flow,
    plot_modulus,
    plot_phase,
    plot_pressure,
    plot_residuals,
)
from vasowave.study.figures.matplotlib_style import (
    CTL,
    DATA,
    FAINT,
    LABELS,
    NARROW,
    SMALL,
    WIDEST,
    group_looks,
    label_axes,
    new_figure,
    plain_log,
    plot_cycle,
    short,
    source_looks,
    wall_lines,
    wave_line,
)
from vasowave.study.figures.panels import Panel, name_above, shared_legend, shown_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_LEAST_RANGE = 1.02  # differences far below a percent are agreement, and look like it
_ROOM = {"left": 0.11, "right": 0.985, "bottom": 0.09, "top": 0.95, "wspace": 0.25, "hspace": 0.4}  # of a fit
_TITLE = 14  # letters of a vessel's name that stand above a column
_WIDE_RANGE = 3.0  # a waterfall that rises more gets a logarithmic axis
_ABREAST = 2  # panels in a row
_HEIGHT = 5.5  # of a row, cm
_SITE_TITLE = 44  # letters
_NUMBERS = "mean, largest or smallest value"
_WIDE = 3.0  # pt: a prediction shows on both sides of a fit that lies on it


def fit_figure(result: AnimalResult, color: str = CTL) -> "Figure":
    """Measured and fitted pressure and flow, and the residuals."""
    figure = new_figure(WIDEST, 12)
    figure.set_layout_engine("none")  # of every animal there is one: finding the room takes as long as drawing
    panels = figure.subplot_mosaic([["p", "q"], ["r", "r"]], height_ratios=[3, 2], gridspec_kw=_ROOM)
    plot_pressure(panels["p"], result, color)
    plot_flow(panels["q"], result, color)
    plot_residuals(panels["r"], result, color)
    return figure


def vessels_figure(result: AnimalResult, color: str = CTL) -> "Figure":
    """Pressure and flow at the middle of the vessels that carry most flow: one column each, one scale a row."""
    network = result.network
    vessels = main_vessels(network)
    figure = new_figure(NARROW if len(vessels) < 3 else WIDEST, 11.5)
    axes = figure.subplots(2, len(vessels), sharex=True, sharey="row", squeeze=False)
    for column, vessel in enumerate(vessels):
        for row, quantity in enumerate(("pressure", "flow")):
            ax = plot_vessel(axes[row, column], result, vessel, quantity, color)
            ax.label_outer()
            ax.locator_params(axis="x", nbins=3)
        share = 100 * network.flow_fraction[network.row(vessel)]
        axes[0, column].set_title(f"{short(vessel, _TITLE)}\n{share:.0f} % of flow", fontsize="medium")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def panel_figure(cohort: Cohort, panel: FitPanel) -> "Figure":
    """One panel of a fit, for the shown animal of each group."""
    return shown_figure(cohort, [panel.draw], 7.5)


def residuals_figure(cohort: Cohort) -> "Figure":
    """Residuals and their autocorrelation ("Residuals")."""
    figure = shown_figure(cohort, [plot_residuals, plot_autocorrelation], 12.5)
    for ax, (group, result) in zip(figure.axes, cohort.shown.items(), strict=False):
        errors = [f"{wall} {float(result.laws[wall].calibration['RMSE']):.2f}" for wall in result.laws]
        whose = "" if cohort.single else f"{name_above(cohort, group)}\n"
        ax.set_title(f"{whose}RMSE [mmHg]: {', '.join(errors)}")
    return shared_legend(figure, figure.axes[-1], 3)


def impedance_figure(cohort: Cohort) -> "Figure":
    """Measured and simulated impedance spectra ("Impd")."""

    def panel(plot: Callable[..., "Axes"]) -> Panel:
        def draw(ax: "Axes", result: AnimalResult, color: str) -> None:
            plot(ax, result.measured.impedance, impedance_error(result), label="measured", linewidth=1.4)
            for wall, line in wall_lines(result.laws, color).items():
                plot(ax, result.laws[wall].impedance, **(line | {"markersize": 2}))

        return draw

    figure = shown_figure(cohort, [panel(plot_modulus), panel(plot_phase)], 13)
    return shared_legend(figure, figure.axes[0], 3)


def along_network_figure(cohort: Cohort) -> "Figure":
    """Wave speed, fall of the mean pressure, mean wall shear and strain by the distance from the inlet ("Tree").

    Lines are 95 % intervals by a posterior, where there is one.
    """

    def panel(distance: str, quantity: str, label: str) -> Panel:
        def draw(ax: "Axes", result: AnimalResult, color: str) -> None:
            looks = source_looks(result.laws)
            for wall, line in wall_lines(looks, color).items():
                data, source_look = result.laws[wall].vessels, looks[wall]
                if quantity not in data:  # stored before it was computed
                    continue
                ax.plot(data[distance], data[quantity], source_look.marker, color=line["color"], ms=4,
                        label=line["label"], mfc=line["color"] if source_look.filled else "none")  # fmt: skip
                if f"{quantity}_low" in data:
                    ends = data[f"{quantity}_low"], data[f"{quantity}_high"]
                    ax.vlines(data[distance], *ends, color=line["color"], linewidth=0.5)
            label_axes(ax, "distance from the inlet [cm]", label)

        return draw

    speed = panel("distance", "wave_speed", "wave speed [cm/s]")
    drop = panel("terminal_distance", "mean_drop", "pressure drop [mmHg]")
    shear = panel("distance", "mean_shear", "mean wall shear [Pa]")
    strain = panel("distance", "strain", "strain of the radius [1]")
    figure = shown_figure(cohort, [speed, drop, shear, strain], 21)
    return shared_legend(figure, figure.axes[0], 3)


def waves_figure(cohort: Cohort, group: str) -> "Figure":
    """Separated pressure and wave intensity of a group's shown animal, measured and of each wall law ("WIA")."""
    result, color = cohort.shown[group], group_looks(cohort.groups)[group].color
    sources = result.sources
    figure = new_figure(WIDEST, 1.5 + 4.8 * len(sources))
    axes = figure.subplots(len(sources), 2, sharex=True, sharey="col", squeeze=False)
    for row, source in enumerate(sources):
        plot_separated_pressure(axes[row, 0], result.sources[source].waves, color)
        plot_wave_intensity(axes[row, 1], result.sources[source].waves, color)
        axes[row, 0].set_title(source if source == "measured" else f"{source} wall")
    for ax in axes[:-1].flat:
        ax.set_xlabel("")
    return shared_legend(figure, axes[0, 0], 3)


def waterfall_figure(cohort: Cohort) -> "Figure":
    """Ends of the starts, one panel per wall law, one line per animal."""
    figure = new_figure(NARROW if len(cohort.walls) == 1 else WIDEST, 7)
    axes = figure.subplots(1, len(cohort.walls), squeeze=False, sharey=True)[0]
    looks = group_looks(cohort.groups)
    for ax, wall in zip(axes, cohort.walls, strict=True):
        for group, results in cohort.groups.items():
            for place, result in enumerate(result for result in results if wall in result.laws):
                plot_waterfall(ax, result.laws[wall].calibration, color=looks[group].color,
                               marker=looks[group].marker, label=None if place else short(group))  # fmt: skip
        ax.set_title(f"{wall} wall")
    for ax in axes[1:]:
        ax.set_ylabel("")
    if not cohort.single:
        axes[0].legend()
    highest = max(ax.get_ylim()[1] for ax in axes)
    highest = max(highest, _LEAST_RANGE)
    axes[0].set_ylim(1 - 0.04 * (highest - 1), highest)
    axes[0].ticklabel_format(axis="y", useOffset=False)
    if highest > _WIDE_RANGE:
        axes[0].set_yscale("log")
        plain_log(axes[0].yaxis)
    return figure


def plot_waterfall(ax: "Axes", calibration: "xr.Dataset", **line: Any) -> "Axes":
    """Draw S of every start over the best S, in rising order; starts that could not be simulated are left out."""
    S = calibration["start_S"].values
    S = np.sort(S[np.isfinite(S)])
    line_style: dict[str, Any] = {"marker": "o", "markersize": 3, "linewidth": 0.9} | line
    ax.plot(np.arange(1, len(S) + 1), S / S[0], **line_style)
    ax.locator_params(axis="x", integer=True)
    return label_axes(ax, "start, in order of S [1]", "S / best S [1]")


def plot_wave_intensity(ax: "Axes", waves: "xr.Dataset", color: str = DATA) -> "Axes":
    """Draw WI₊ and WI₋ over time/T (eq. 16), and at their peaks the names of the largest wave of each kind."""
    time = waves["normalized_time"].values
    ax.plot(time, waves["WI_plus"].values, **wave_line("forward", color))
    ax.plot(time, waves["WI_minus"].values, **wave_line("backward", color))
    for name, row in largest_waves(waves).items():
        peak_time, peak = float(waves["wave_time"][row]) / waves.attrs["period"], float(waves["wave_peak"][row])
        offset, place = ((0, 3), "bottom") if peak > 0 else ((0, -3), "top")
        ax.annotate(name, (peak_time, peak), offset, textcoords="offset points", ha="center", va=place, fontsize=SMALL)
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


def main_vessels(network: Network, count: int = 6) -> list[str]:
    """Return the names of up to `count` vessels that show the network, from the root outwards, or all if one is left.

    The root, its two largest daughters, the terminal at the end of each one's main path, then what carries most flow.
    """
    flow = network.flow_fraction
    daughters = sorted(network.daughters[network.root], key=lambda row: -flow[row])[:2]
    ends = [_main_path(network, row)[-1] for row in daughters]
    by_flow = np.argsort(-flow, kind="stable").tolist()
    chosen = list(dict.fromkeys([network.root, *daughters, *ends, *by_flow]))
    chosen = chosen[: count if len(chosen) > count + 1 else count + 1]
    depth = {row: level for level, rows in enumerate(network.generations) for row in rows.tolist()}
    return [network.name[row] for row in sorted(chosen, key=lambda row: (depth[row], row))]


def _main_path(network: Network, row: int) -> list[int]:
    """Return the rows from `row` to a terminal, at every junction into the daughter with most flow."""
    path = [row]
    while network.daughters[path[-1]]:
        path.append(max(network.daughters[path[-1]], key=lambda daughter: network.flow_fraction[daughter]))
    return path


def plot_vessel(ax: "Axes", result: AnimalResult, vessel: str, quantity: str, color: str) -> "Axes":
    """Draw pressure or flow at the middle of one vessel, one line per wall law; data where measured."""
    if vessel == result.root and quantity == "pressure":
        plot_cycle(ax, result.recording["pressure"], result.period, color=DATA, linewidth=1, label="measured (inlet)")
    for wall, line in wall_lines(result.laws, color).items():
        plot_cycle(ax, result.laws[wall].simulated(quantity, vessel, "middle"), result.period, **line)
    return label_axes(ax, "time [s]", LABELS[quantity])


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
    handles_by_label = {
        label: drawn for ax in axes for drawn, label in zip(*ax.get_legend_handles_labels(), strict=True)
    }
    figure.legend(handles_by_label.values(), handles_by_label.keys(), loc="outside upper center", ncols=2)
    return figure


def plot_site(ax: "Axes", result: AnimalResult, site: int, color: str = CTL) -> "Axes":
    """Draw one site over a cycle: observed, with each wall law, and predicted without it by the first of them."""
    laws = sites_of(result)
    lines = wall_lines(laws, color)
    for place, (wall, data) in enumerate(laws.items()):
        site_data = data.isel(site=site)
        if place == 0:
            if site_data["measured"].notnull().any():
                plot_cycle(ax, site_data["measured"], result.period, color=DATA, label="observed")
            for name in NUMBERS:
                if site_data[name].notnull():
                    ax.axhline(float(site_data[name]), color=DATA, linestyle=":", label=f"observed: {_NUMBERS}")
            predicted = {"color": FAINT, "linewidth": _WIDE, "label": "predicted without it"}
            plot_cycle(ax, site_data["predicted"], result.period, **predicted)
        plot_cycle(ax, site_data["simulated"], result.period, **lines[wall])
    ax.set_title(short(str(site_data["site"].values), _SITE_TITLE), fontsize="medium")
    return label_axes(ax, "time [s]", f"{site_data['observed'].item()} [{site_data['unit'].item()}]")
