"""The figures of the first page: measured waveforms of all animals, and the network with what the model says of it."""

from functools import partial
from operator import mul
from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.pulse.network.network import Network
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort, common_level
from vasowave.study.figures.fit import plot_flow, plot_pressure
from vasowave.study.figures.groups import plot_flow_loops, plot_mean_impedance, plot_mean_waveform, plot_waveforms
from vasowave.study.figures.matplotlib_style import (
    NARROW,
    SCALE,
    WIDEST,
    columns_that_fit,
    darker,
    group_looks,
    new_figure,
    plain_log,
    short,
)
from vasowave.study.figures.network import plot_network
from vasowave.study.figures.rendering import mark, readable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_LABELS = 4  # of axes side by side
_TITLE = 46  # letters of a title over one column of a journal


def waveforms_figure(cohort: Cohort) -> "Figure":
    """Measured pressure and flow of every animal with mean and SD of each group; of one animal with its fits.

    Occasions, or levels of a second factor, have a column of panels each.
    """
    if cohort.single:
        return _one_animal(cohort)
    levels = list(dict.fromkeys(cell.level for cell in cohort.cells.values()))
    width = NARROW if len(levels) < 3 else WIDEST
    figure = new_figure(width, 9.5)
    axes = figure.subplots(2, len(levels), sharex=True, sharey="row", squeeze=False)
    looks = group_looks(cohort.groups)
    for group, level, results in cohort.cells.values():
        for ax, quantity in zip(axes[:, levels.index(level)], ("pressure", "flow"), strict=True):
            plot_waveforms(ax, results, quantity, looks[group].color)
            plot_mean_waveform(ax, results, quantity, looks[group])
    for ax, level in zip(axes[0], levels, strict=True):
        ax.set_title(short(level, 60 // len(levels)))
    handles = _legend(cohort)
    columns = columns_that_fit([str(handle.get_label()) for handle in handles], width, max_columns=2)
    figure.legend(handles=handles, loc="outside upper center", ncols=columns)
    for ax in axes.flat:  # limits are final now; then inner labels go
        readable(ax)
    for ax in [*axes[0], *(axes[1, :-1] if len(levels) > _MOST_LABELS else ())]:
        ax.set_xlabel("")
    for ax in axes[:, 1:].flat:
        ax.set_ylabel("")
    return figure


def flow_loops_figure(cohort: Cohort) -> "Figure":
    """Measured pressure over flow of every animal with the loop of each group's mean cycle.

    Occasions, or levels of a second factor, have a panel each.
    """
    levels = list(dict.fromkeys(cell.level for cell in cohort.cells.values()))
    figure = new_figure(NARROW if len(levels) < 3 else WIDEST, 7.5)
    axes = dict(zip(levels, figure.subplots(1, len(levels), sharex=True, sharey=True, squeeze=False)[0], strict=True))
    looks = group_looks(cohort.groups)
    for group, level, results in cohort.cells.values():
        plot_flow_loops(axes[level], results, looks[group])
    for place, (level, ax) in enumerate(axes.items()):
        ax.set_title(short(level, 60 // len(levels)))
        if place:
            ax.set_ylabel("")
    figure.legend(handles=_legend(cohort), loc="outside upper center", ncols=2)
    return figure


def impedances_figure(cohort: Cohort) -> "Figure":
    """Measured impedance of each group, mean and SD over frequency, with the harmonics of the first above.

    Of occasions, or levels of a second factor, at the first that all groups have.
    """
    figure = new_figure(NARROW, 9.5)
    axes = figure.subplots(2, 1, sharex=True)
    looks = group_looks(cohort.groups)
    level = common_level(cohort.groups, cohort.second)
    for group, _, results in (cell for cell in cohort.cells.values() if cell.level == level or not level):
        for ax, quantity in zip(axes, ("modulus", "phase"), strict=True):
            plot_mean_impedance(ax, results, quantity, looks[group])
    axes[0].set_yscale("log")
    plain_log(axes[0].yaxis)
    axes[0].set_xlabel("")
    rate = np.mean([1 / result.period for result in next(iter(cohort.groups.values()))])
    above = axes[0].secondary_xaxis("top", functions=(partial(mul, 1 / rate), partial(mul, rate)))
    above.set_xlabel(f"harmonic of {short(cohort.reference, 18)}")
    handles = _legend(cohort)
    figure.legend(handles=handles, loc="outside upper center", ncols=2)
    return figure


def _legend(cohort: Cohort) -> list[Any]:
    from matplotlib.lines import Line2D

    looks = group_looks(cohort.groups)
    return [
        Line2D([], [], color=darker(looks[group].color, 0.2), marker=looks[group].marker, ms=4, lw=1.8,
               label=f"{short(group, 18)} ({cohort.counts(group)})")
        for group in cohort.groups
    ]  # fmt: skip


def _one_animal(cohort: Cohort) -> "Figure":
    (result,) = cohort.results
    figure = new_figure(NARROW, 9.5)
    pressure, flow = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
    color = next(iter(group_looks(cohort.groups).values())).color
    if "pressure_sd" in result.recording.data_vars:
        mean, sd = result.recording["pressure"].values, result.recording["pressure_sd"].values
        time = result.recording["time"].values
        pressure.fill_between(time, mean - sd, mean + sd, color="0.8", lw=0, label="SD of the beats")
    plot_pressure(pressure, result, color)
    plot_flow(flow, result, color)
    for ax in (pressure, flow):
        for line in ax.get_lines():
            mark(line, str(line.get_label()), result.name)
        readable(ax)
    pressure.set_xlabel("")
    return figure


def tree_figure(cohort: Cohort, wall: str) -> "Figure":
    """The network of each group's shown animal, colored by how far the mean pressure falls from the inlet by a law."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize, to_hex

    results = {group: result for group, result in cohort.shown.items() if wall in result.laws}
    means = {group: mean_pressures(result, wall) for group, result in results.items()}
    inlets = {
        group: float(result.laws[wall].simulated("pressure", result.root).mean()) for group, result in results.items()
    }
    heights = [min(14.0, max(3.0, 1.0 + 0.6 * len(result.network.terminals))) for result in results.values()]
    figure = new_figure(NARROW, sum(heights) + 1.2)
    axes = figure.subplots(len(results), 1, squeeze=False, height_ratios=heights)[:, 0]
    falls = {group: inlets[group] - means[group] for group in results}
    pressure_falls = np.concatenate(list(falls.values()))
    widest = max(float(result.network.radius.max()) for result in results.values())
    scale = ScalarMappable(Normalize(float(pressure_falls.min()), float(pressure_falls.max())), SCALE)
    for ax, (group, result) in zip(axes, results.items(), strict=True):
        network = result.network
        colors = [to_hex(tuple(color)) for color in scale.to_rgba(falls[group])]
        plot_network(ax, network, colors, _tips(result, wall, network, means[group]), share=False, widest=widest)
        name = "" if cohort.single else f"{short(cohort.name(group), _TITLE)},"
        separator = "\n" if len(name) > _TITLE - len(at_inlet := f"{inlets[group]:.1f} mmHg at the inlet") else " "
        ax.set_title(f"{name}{separator}{at_inlet}".strip())
    label = f"fall of the mean pressure, {wall} wall [mmHg]"
    bar = figure.colorbar(scale, ax=list(axes), orientation="horizontal", aspect=45, pad=0.02, label=label)
    bar.outline.set_visible(False)
    return figure


def mean_pressures(result: AnimalResult, wall: str) -> np.ndarray:
    """Return the mean pressure at the middle of every vessel, mmHg, in the order of the network."""
    pressure = result.laws[wall].simulation["pressure"].sel(station="middle").mean("time")
    return pressure.sel(vessel=list(result.network.name)).values


def _tips(result: AnimalResult, wall: str, network: Network, mean: np.ndarray) -> list[str]:
    speed = dict(zip(result.laws[wall].vessels["vessel"].values, result.laws[wall].vessels["wave_speed"].values))
    return [
        f"vessel {name}: radius {network.radius[row]:.3g} cm, length {network.length[row]:.3g} cm, "
        f"{100 * abs(network.flow_fraction[row]):.2g} % of the flow; mean pressure {mean[row]:.1f} mmHg, wave speed "
        f"{speed[name]:.0f} cm/s"
        for row, name in enumerate(network.name)
    ]
