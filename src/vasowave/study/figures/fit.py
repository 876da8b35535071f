"""Measured and fitted at the inlet: waveforms, residuals, spectra, how walls stiffen; many animals at one glance."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vasowave.base.descriptions import NORMAL
from vasowave.pulse.cycle.cycle import resample
from vasowave.study.animal.reading import law_curve, residual_autocorrelation
from vasowave.study.animal.result import AnimalResult
from vasowave.study.figures.loops import plot_loops
from vasowave.study.figures.matplotlib_style import (
    CTL,
    DATA,
    FAINT,
    LABELS,
    SMALL,
    WIDEST,
    closed,
    group_looks,
    label_axes,
    legend_above,
    new_figure,
    plain_log,
    plot_cycle,
    short,
    source_looks,
    wall_lines,
)
from vasowave.study.figures.rendering import mark

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    Draw = Callable[..., Axes]

ON_A_SHEET = 48  # animals
_ABREAST = 6  # fits in a row of a sheet
_POINTS = 128  # of a curve of 2.5 cm
_PANEL = 2.7  # cm, height of a panel with its title
_FITTED_RESPONSES = {"fit.lag", "fit.inertia"}


class FitPanel(NamedTuple):
    """A panel of a fit."""

    draw: "Draw"
    """Draws a result into axes, in a color, with laws told by its shades or by dashes alone."""
    title: str
    """What the workbench calls it."""
    figure: str = ""
    caption: str = ""
    """Name and caption of its figure in the report, empty where that has none."""


PANELS: dict[str, FitPanel] = {}
"""The panels of a fit by name, in the order of the workbench."""


def fit_panel(name: str, title: str, figure: str = "", caption: str = "") -> Callable[["Draw"], "Draw"]:
    """Make a function that draws a fit a panel of notebooks, workbench and, with a caption, report."""

    def register(draw: "Draw") -> "Draw":
        PANELS[name] = FitPanel(draw, title, figure, caption)
        return draw

    return register


@fit_panel("pressure", "pressure")
def plot_pressure(ax: "Axes", result: AnimalResult, color: str = CTL, shaded: bool = True) -> "Axes":
    """Draw measured pressure, and each wall law's at the inlet of the root vessel, over one cycle."""
    _plot_inlet(ax, result, "pressure", color, shaded).legend()
    return ax


@fit_panel("flow", "flow")
def plot_flow(ax: "Axes", result: AnimalResult, color: str = CTL, shaded: bool = True) -> "Axes":
    """Draw measured flow, and each wall law's at the inlet of the root vessel, over one cycle.

    Where the measured flow is the model's inflow the curves coincide.
    """
    return _plot_inlet(ax, result, "flow", color, shaded)


def _plot_inlet(ax: "Axes", result: AnimalResult, quantity: str, color: str, shaded: bool) -> "Axes":
    plot_cycle(ax, result.recording[quantity], result.period, color=DATA, label="measured")
    for wall, line in wall_lines(result.laws, color, shaded).items():
        plot_cycle(ax, _as_recorded(result, wall, quantity), result.period, **line)
    return label_axes(ax, "time [s]", LABELS[quantity])


def _as_recorded(result: AnimalResult, wall: str, quantity: str) -> "xr.DataArray":
    """Return what a wall law gives of a quantity at the inlet, behind a response of the pressure that was fitted."""
    law = result.laws[wall]
    if quantity != "pressure" or _FITTED_RESPONSES.isdisjoint(finding.code for finding in law.findings):
        return law.simulated(quantity, result.root)
    residual = law.residual.to_numpy()  # of what was recorded and is compared
    measured = result.recording[quantity]
    compared = resample(measured.to_numpy(), len(residual)) - residual
    return measured.copy(data=resample(compared, measured.size))


@fit_panel("residuals", "residuals")
def plot_residuals(ax: "Axes", result: AnimalResult, color: str = CTL, shaded: bool = True) -> "Axes":
    """Draw measured minus simulated pressure over one cycle, or flow, where the pressure entered the model."""
    ax.axhline(0.0, color=FAINT, linewidth=0.8)
    quantity, unit = "pressure", "mmHg"
    for wall, line in wall_lines(result.laws, color, shaded).items():
        quantity, residual = result.laws[wall].compared, result.laws[wall].residual
        unit, rmse = str(residual.attrs["units"]), float(np.sqrt(np.mean(residual.values**2)))
        label = f"{wall}, RMSE {rmse:.2f} mmHg" if quantity == "pressure" else f"{wall}, RMSE {rmse:.3g} {unit}"
        ax.plot(residual["time"].values, residual.values, **(line | {"label": label}))
    legend_above(ax, columns=2)
    return label_axes(ax, "time [s]", f"residual {quantity} [{unit}]")


@fit_panel("autocorrelation", "their autocorrelation")
def plot_autocorrelation(ax: "Axes", result: AnimalResult, color: str = CTL, shaded: bool = True) -> "Axes":
    """Draw the circular autocorrelation of the residuals up to half a period, and the 95 % band of white noise."""
    lines = wall_lines(result.laws, color, shaded)
    curves = {wall: residual_autocorrelation(result, wall) for wall in lines}
    for wall, rho in curves.items():
        ax.plot(rho["lag"].values, rho.values, **lines[wall])
    if curves:
        band = max(rho.attrs["white_noise"] for rho in curves.values())
        ax.axhspan(-band, band, color="0.9", zorder=0, label="white noise, 95 %")
    ax.set(xlim=(0, result.period / 2), ylim=(-1.05, 1.05))
    legend_above(ax, columns=3)
    return label_axes(ax, "lag [s]", "autocorrelation [1]")


@fit_panel(
    "pressure_area",
    "pressure and area",
    "PAsim",
    "Pressure against area at the middle of the root vessel over one cycle (thick), and the wall law from zero "
    "pressure on (thin, if the results hold it).",
)
def plot_pressure_area(ax: "Axes", result: AnimalResult, color: str = CTL, shaded: bool = True) -> "Axes":
    """Draw pressure against area at the middle of the root vessel over the cycle, and thinly the law, if stored."""
    vessels, root = result.network, result.root
    for wall, line in wall_lines(result.laws, color, shaded).items():
        pressure, area = (
            result.laws[wall].simulated(quantity, root, "middle").values for quantity in ("pressure", "area")
        )
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


def sheets(results: Sequence[AnimalResult]) -> list[list[AnimalResult]]:
    """Return the animals that were calibrated, those with the largest error first, as many as a sheet holds."""
    fitted = [result for result in results if result.laws]
    # By the law that fits best; errors that rounding makes unlike are one, in any order.
    fitted.sort(key=lambda result: round(min(_errors(result).values()), 6), reverse=True)
    return [fitted[first : first + ON_A_SHEET] for first in range(0, len(fitted), ON_A_SHEET)]


def sheet_figure(results: Sequence[AnimalResult], groups: Sequence[str]) -> "Figure":
    """Draw measured and fitted pressure of up to `ON_A_SHEET` animals, each over one cycle in a panel of its own.

    Parameters
    ----------
    results : sequence of AnimalResult
    groups : sequence of str
        All groups of the study in their order, which sets the colors.
    """
    looks, rows = group_looks(groups), -(-len(results) // _ABREAST)
    height = _PANEL * rows + 0.8
    figure = new_figure(WIDEST, height)
    figure.set_layout_engine("none")  # nothing stands outside the panels
    room = {"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 1 - 0.8 / height, "wspace": 0.08, "hspace": 0.75}
    axes = figure.subplots(rows, _ABREAST, squeeze=False, gridspec_kw=room).ravel()
    for ax, result in zip(axes, results, strict=False):
        _draw_small(ax, result, looks[result.group].color)
    for ax in axes:
        ax.set_axis_off()
    return figure


def _draw_small(ax: "Axes", result: AnimalResult, color: str) -> None:
    pressure = result.recording["pressure"].values
    (line,) = ax.plot(*_thinned(pressure), color=DATA, linewidth=0.9)
    for wall, line_style in wall_lines(result.laws, color).items():
        inlet = result.laws[wall].simulated("pressure", result.root).values
        ax.plot(*_thinned(inlet), **(line_style | {"linewidth": 0.9}))
    looks = source_looks(result.laws)
    errors = ", ".join(f"{looks[wall].short} {error:.2f}" for wall, error in _errors(result).items())
    ax.set_title(f"{short(result.name, 16)}\n{errors}", fontsize=SMALL, pad=2)
    ax.text(0.98, 0.98, f"{pressure.min():.0f} to {pressure.max():.0f}", transform=ax.transAxes, fontsize=SMALL,
            ha="right", va="top")  # fmt: skip
    mark(line, f"{result.name} ({result.group}), RMSE [mmHg]: {errors}", result.name)


def _thinned(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return shares of the cycle and the values there, closed."""
    closed_values = closed(values)
    chosen = np.unique(np.linspace(0, len(closed_values) - 1, _POINTS).round().astype(int))
    return chosen / (len(closed_values) - 1), closed_values[chosen]


def _errors(result: AnimalResult) -> dict[str, float]:
    return {wall: law.rmse for wall, law in result.laws.items()}


def plot_modulus(ax: "Axes", spectrum: "xr.Dataset", error: np.ndarray | None = None, **line: Any) -> "Axes":
    """Draw |Z| over frequency (eq. 19); harmonics whose flow is at noise level are grey and hollow.

    `error` is the relative standard error of every harmonic, shape (harmonic,), drawn as an interval of 95 %.
    """
    modulus = spectrum["modulus"].values
    factor = np.exp(NORMAL * (np.zeros(len(modulus)) if error is None else error))
    _draw_spectrum(ax, spectrum, modulus, (modulus - modulus / factor, modulus * factor - modulus), line)
    ax.set_yscale("log")
    plain_log(ax.yaxis)
    return label_axes(ax, "frequency [Hz]", "|Z| [mmHg s/ml]")


@fit_panel("impedance", "impedance")
def plot_impedance(ax: "Axes", result: AnimalResult, color: str = CTL, shaded: bool = True) -> "Axes":
    """Draw the modulus of the measured impedance by harmonic."""
    return plot_modulus(ax, result.measured.impedance)


@fit_panel("loops", "loops of a ventricle")
def plot_ventricular_loops(ax: "Axes", result: AnimalResult, color: str = CTL, shaded: bool = True) -> "Axes":
    """Draw the loops of pressure and volume in a ventricle, where they were recorded, with the end-systolic line."""
    if result.loops is not None:
        return plot_loops(result.loops, ax, color)
    ax.text(0.5, 0.5, "no loops of pressure and volume recorded", transform=ax.transAxes, ha="center", va="center")
    ax.set_axis_off()
    return ax


def plot_phase(ax: "Axes", spectrum: "xr.Dataset", error: np.ndarray | None = None, **line: Any) -> "Axes":
    """Draw the phase θ of Z over frequency (eq. 19), unwrapped; negative where pressure lags flow.

    `error` is the standard error of every harmonic, rad.
    """
    from matplotlib.ticker import FuncFormatter, MultipleLocator

    phase = unwrapped(spectrum["phase"].values, spectrum["reliable"].values.astype(bool))
    reach = NORMAL * (np.zeros(len(phase)) if error is None else error)
    _draw_spectrum(ax, spectrum, phase, (reach, reach), line)
    ax.axhline(0, color=FAINT, linewidth=0.8, zorder=0)
    ax.update_datalim([(0, -np.pi / 2), (0, np.pi / 2)])
    ax.autoscale_view()
    ax.yaxis.set_major_locator(MultipleLocator(np.pi / 2))
    ax.yaxis.set_major_formatter(FuncFormatter(_halves))
    return label_axes(ax, "frequency [Hz]", "phase θ [rad]")


def unwrapped(phase: np.ndarray, reliable: np.ndarray) -> np.ndarray:
    """Return phases without jumps of 2π from one reliable harmonic to the next; the others join their branch."""
    smooth, place = phase.copy(), np.arange(len(phase))
    if reliable.any():
        smooth[reliable] = np.unwrap(phase[reliable])
        branch = np.interp(place, place[reliable], smooth[reliable])
        smooth += np.where(reliable, 0.0, 2 * np.pi * np.round((branch - phase) / (2 * np.pi)))
    return smooth


def _halves(phase: float, place: int | None = None) -> str:
    """Return a multiple of π/2 as people write it."""
    count = round(phase / (np.pi / 2))
    multiples = {1: "π", -1: "−π", 0: "0"}
    if count % 2:
        return f"{multiples[count]}/2" if abs(count) == 1 else f"{count}π/2".replace("-", "−")
    half = count // 2
    return multiples.get(half, f"{half}π".replace("-", "−"))


def _draw_spectrum(
    ax: "Axes", spectrum: "xr.Dataset", values: np.ndarray, reach: tuple[np.ndarray, np.ndarray], line: dict[str, Any]
) -> None:
    good = spectrum["reliable"].values.astype(bool)
    frequency = spectrum["frequency"].values
    line_style: dict[str, Any] = {"color": DATA, "marker": "o", "markersize": 3, "linewidth": 1} | line
    ax.plot(frequency[good], values[good], **line_style)
    ax.plot(frequency[~good], values[~good], "o", color="0.6", fillstyle="none", markersize=3)
    if np.any(reach):
        reaches = np.stack(reach)[:, good]
        ax.errorbar(
            frequency[good],
            values[good],
            yerr=reaches,
            fmt="none",
            ecolor=line_style["color"],
            elinewidth=0.8,
            capsize=2,
        )
