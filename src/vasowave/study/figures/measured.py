"""The figures of what was measured: hemodynamics, networks, nominal parameters, beats, ventricles."""

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from vasowave.study.animal.reading import fitted_decay, pressure_flow_loop, upstroke_line
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.figures.fit import plot_modulus, plot_phase
from vasowave.study.figures.groups import plot_waveforms
from vasowave.study.figures.matplotlib_style import (
    CTL,
    DATA,
    FAINT,
    NARROW,
    WIDEST,
    closed,
    closed_time,
    group_looks,
    label_axes,
    new_figure,
    short,
)
from vasowave.study.figures.network import plot_network
from vasowave.study.figures.panels import grid, outer, shown_figure, without_legend
from vasowave.study.figures.signals import plot_baseline, plot_detected_beats, plot_ensemble

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_MOST_COLUMNS = 4  # of panels, with the words below them side by side
_TITLE = 88  # letters of the titles side by side
_DEEP = 4  # generations that need two columns of a journal
_BEATS = {"width": WIDEST, "left": 1.8, "right": 0.2, "bottom": 1.0, "top": 0.8, "between": 1.6, "beside": 1.9}  # cm
_HEIGHT = 6.0  # cm
_TOP = 1.6  # times the isovolumic peak: the legend stands above the curves


def hemodynamics_figure(cohort: Cohort) -> "Figure":
    """Measured pressure, flow, impedance modulus and phase, one column per group, or group and level ("hemoData")."""
    labels = cells_drawn(cohort)
    figure, axes = grid(cohort, 4, 19, len(labels))
    for column, label in enumerate(labels):
        group, _, results = cohort.cells[label]
        color, shown = group_looks(cohort.groups)[group].color, _shown(cohort, label)
        if not cohort.single:
            axes[0, column].set_title(_title(cohort, label, shown, _TITLE // len(labels)))
        for row, quantity in enumerate(("pressure", "flow")):
            plot_waveforms(axes[row, column], results, quantity, color, shown)
        for result in sorted(results, key=lambda result: result.name == shown):  # the shown one last, above the others
            above = result.name == shown
            line = {"linewidth": 1.8} if above else {"color": color, "linewidth": 0.8, "markersize": 2}
            plot_modulus(axes[2, column], result.measured.impedance, **line)
            plot_phase(axes[3, column], result.measured.impedance, **line)
    return outer(figure, axes)


def cells_drawn(cohort: Cohort) -> list[str]:
    """Return the cells that have a column of panels: all where few are crossed, else each group where it is shown."""
    if len(cohort.cells) <= _MOST_COLUMNS or not cohort.crossed:
        return list(cohort.cells)
    return [label for label, cell in cohort.cells.items()
            if any(result.name == cohort.shown[cell.group].name for result in cell.results)]  # fmt: skip


def _shown(cohort: Cohort, label: str) -> str:
    """Return which recording of a cell is of the animal that is shown of its group; empty if none is."""
    group, _, results = cohort.cells[label]
    subject = cohort.subjects[cohort.shown[group].name]
    names = [result.name for result in results if cohort.subjects[result.name] == subject]
    return next((name for name in names if name == cohort.shown[group].name), next(iter(names), ""))


def _title(cohort: Cohort, label: str, shown: str, max_letters: int) -> str:
    """Return what stands above a column: whose, how many, which is black; line by line where columns are narrow."""
    group, level, _ = cohort.cells[label]
    black = f"black: {short(shown)}" if shown else ""
    title = f"{short(group)} ({cohort.count(label)}); {black}"
    if not level and len(title) <= max_letters:
        return title
    lines = [group, f"{level} ({cohort.count(label)})" if level else cohort.count(label), black]
    return "\n".join(short(line, max_letters) for line in lines if line)


def networks_figure(cohort: Cohort) -> "Figure":
    """The directed graph of every group's network ("Network", c); the same one only once."""
    distinct = cohort.shown_networks
    results = [cohort.shown[groups[0]] for groups in distinct]
    heights = [min(40.0, max(4.0, 0.85 * len(result.network.terminals))) for result in results]
    deepest = max(len(result.network.generations) for result in results)
    figure = new_figure(NARROW if deepest < _DEEP else WIDEST, sum(heights))
    axes = figure.subplots(len(results), 1, squeeze=False, height_ratios=heights)[:, 0]
    for ax, result, groups in zip(axes, results, distinct, strict=True):
        plot_network(ax, result.network, group_looks(cohort.groups)[groups[0]].color)
        if not cohort.single:
            ax.set_title(" and ".join(map(short, groups)))
    return figure


def nominal_figure(cohort: Cohort) -> "Figure":
    """Slope Z_c and diastolic decay of each group's shown animal ("parEst", a and b)."""
    return shown_figure(cohort, [plot_upstroke, plot_decay], 13, share="none")


def beats_figure(result: AnimalResult) -> "Figure":
    """Beats detected and kept of one animal's continuous recording, its baseline, and the averaged cycle."""
    beats = result.beats if result.beats is not None else xr.Dataset()
    signals = [name for name in ("ecg", "pressure", "flow") if f"trace_{name}" in beats.data_vars]
    levels = ["level"] if {"level", "drift"} <= set(beats.data_vars) else []
    rows: list[Any] = [*([name, name] for name in [*signals, *levels]), ["p", "q"]]
    height = 3.6 * (len(rows) - 1) + 5.6
    figure = new_figure(_BEATS["width"], height)
    figure.set_layout_engine("none")  # of every animal there is one: finding the room takes as long as drawing
    axes = figure.subplot_mosaic(rows, gridspec_kw=_beats_room(height, len(rows)))
    for place, name in enumerate(signals):
        plot_detected_beats(axes[name], beats, name)
        if place > 0:
            without_legend(axes[name])
        if place < len(signals) - 1:
            axes[name].set_xlabel("")
    for name in levels:
        plot_baseline(axes[name], beats)
    for panel, name in (("p", "pressure"), ("q", "flow")):
        plot_ensemble(axes[panel], result, name)
    return figure


def _beats_room(height: float, rows: int) -> dict[str, float]:
    """Return the room of so many rows of panels as matplotlib takes it: shares of the figure, gaps of a panel."""
    cm = _BEATS
    panel = (height - cm["bottom"] - cm["top"] - (rows - 1) * cm["between"]) / rows
    half = (cm["width"] - cm["left"] - cm["right"] - cm["beside"]) / 2
    return {
        "left": cm["left"] / cm["width"],
        "right": 1 - cm["right"] / cm["width"],
        "bottom": cm["bottom"] / height,
        "top": 1 - cm["top"] / height,
        "hspace": cm["between"] / panel,
        "wspace": cm["beside"] / half,
    }


def plot_upstroke(ax: "Axes", result: AnimalResult, color: str = CTL) -> "Axes":
    """Draw the measured pressure-flow loop, the samples of the upstroke and the line whose slope is Z_c (eq. 8)."""
    nominal = result.nominal
    flow, pressure = pressure_flow_loop(result)
    ax.plot(closed(flow), closed(pressure), color=DATA, label="measured")
    ax.plot(nominal["upstroke_flow"].values, nominal["upstroke_pressure"].values, ".", color=color, markersize=4,
            label="upstroke")  # fmt: skip
    ends = np.array([flow.min(), flow.max()])
    slope = f"Z_c = {float(nominal['Z_c']):.3g} mmHg s/ml"
    ax.plot(ends, upstroke_line(result, ends), color=color, linestyle="dashed", label=slope)
    ax.legend()
    return label_axes(ax, "flow [ml/s]", "pressure [mmHg]")


def plot_decay(ax: "Axes", result: AnimalResult, color: str = CTL) -> "Axes":
    """Draw the measured pressure and the exponential fitted to its diastolic decay (eq. 12)."""
    recording, T = result.recording, result.period
    time, decay = fitted_decay(result)
    cycle, measured = closed_time(recording["time"].values, T), recording["pressure"].values
    if time[-1] > T:
        cycle, measured = np.concatenate([cycle[:-1], cycle + T]), np.tile(measured, 2)
    ax.plot(cycle, closed(measured), color=DATA, label="measured")
    tau = f"τ = {float(result.nominal['tau']):.3g} s"
    ax.plot(time, decay, color=color, linestyle="dashed", linewidth=2.2, label=tau)
    ax.set_xlim(0.0, max(T, time[-1] + 0.05 * T))
    ax.legend()
    return label_axes(ax, "time [s]", "pressure [mmHg]")


def ventricle_figure(data: xr.Dataset, color: str = CTL) -> "Figure":
    """Return pressure over time beside pressure over volume, of `AnimalResult.ventricle`."""
    figure = new_figure(WIDEST, _HEIGHT)
    over_time, over_volume = figure.subplots(1, 2)
    plot_ventricle(over_time, data, color)
    plot_loop(over_volume, data, color)
    return figure


def plot_ventricle(ax: "Axes", data: xr.Dataset, color: str = CTL) -> "Axes":
    """Draw the pressure of the ventricle as measured, as fitted, and as it would be if nothing left it."""
    time = 1000 * data["time"].to_numpy()
    ax.plot(time, data["isovolumic_pressure"], color=FAINT, linestyle="--", label="if nothing left it")
    ax.plot(time, data["pressure"], color=DATA, linewidth=2.2, label="measured")
    ax.plot(time, data["fitted_pressure"], color=color, label="by elastance and flow")
    ax.legend(loc="upper right")
    ax.set_ylim(0, _TOP * float(data["isovolumic_pressure"].max()))
    return label_axes(ax, "time [ms]", "pressure [mmHg]")


def plot_loop(ax: "Axes", data: xr.Dataset, color: str = CTL) -> "Axes":
    """Draw pressure over volume, with the lines whose slopes are the elastances of ventricle and artery."""
    volume, pressure = 1000 * data["volume"].to_numpy(), data["pressure"].to_numpy()
    ax.plot(volume, pressure, color=DATA, linewidth=2.2)
    isovolumic = data["isovolumic_pressure"].to_numpy()
    peak = int(np.argmax(isovolumic))
    filled = float(volume[0])
    top, end_systole = float(isovolumic[peak]), (volume[peak], data["fitted_pressure"].to_numpy()[peak])
    ax.plot([0, filled], [0, top], color=color, label="E_es, the ventricle's")
    ax.plot([filled, filled - 1000 * float(data["stroke_volume"])], [0, end_systole[1]], color=color, linestyle=":",
            label="−E_a, the artery's")  # fmt: skip
    ax.set_xlim(0, 1.05 * filled)
    ax.set_ylim(0, _TOP * top)
    ax.legend(loc="upper right")
    return label_axes(ax, "volume above V₀ [µl]", "pressure [mmHg]")
