"""How the nominal parameters came about: Z_c from the pressure-flow loop, τ from the diastolic decay ("parEst")."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.animal.reading import fitted_decay, pressure_flow_loop, upstroke_line
from vasowave.animal.result import AnimalResult
from vasowave.figures.style import CTL, DATA, closed, closed_time, label_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes


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
