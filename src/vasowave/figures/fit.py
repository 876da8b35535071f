"""Measured and fitted waveforms where the catheter was, and what is left between them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vasowave.calibration.result import Fit
from vasowave.figures.style import CTL, DATA, closed, closed_time, label_axes, legend_above, wall_line
from vasowave.results import inlet

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_pressure(ax: "Axes", fits: Sequence[Fit], color: str = CTL) -> "Axes":
    """Draw measured pressure, and each wall law's at the inlet of the root vessel, over one cycle."""
    recording = fits[0].recording
    ax.plot(closed_time(recording.time, recording.period), closed(recording.pressure), color=DATA, label="measured")
    for fit in fits:
        time, pressure, _ = inlet(fit)
        ax.plot(closed_time(time, recording.period), closed(pressure), **wall_line(fit.wall, color))
    ax.legend()
    return label_axes(ax, "time [s]", "pressure [mmHg]")


def plot_flow(ax: "Axes", fits: Sequence[Fit], color: str = CTL) -> "Axes":
    """Draw measured flow, and each wall law's at the inlet of the root vessel, over one cycle.

    The measured flow is the model's inflow, so the curves coincide.
    """
    recording = fits[0].recording
    measured_time = np.arange(len(recording.flow)) * (recording.period / len(recording.flow))
    ax.plot(closed_time(measured_time, recording.period), closed(recording.flow), color=DATA, label="measured")
    for fit in fits:
        time, _, flow = inlet(fit)
        ax.plot(closed_time(time, recording.period), closed(flow), **wall_line(fit.wall, color))
    return label_axes(ax, "time [s]", "flow [ml/s]")


def plot_residuals(ax: "Axes", fits: Sequence[Fit], color: str = CTL) -> "Axes":
    """Draw measured minus simulated pressure over one cycle."""
    ax.axhline(0.0, color=DATA, linewidth=0.8)
    for fit in fits:
        line = wall_line(fit.wall, color) | {"label": f"{fit.wall}, RMSE {fit.rmse:.2f} mmHg"}
        ax.plot(fit.recording.time, fit.pressure_residual, **line)
    legend_above(ax, columns=2)
    return label_axes(ax, "time [s]", "residual pressure [mmHg]")
