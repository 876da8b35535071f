"""How the nominal parameters came about: Z_c from the pressure-flow loop, τ from the diastolic decay ("parEst")."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.figures.style import CTL, DATA, closed, closed_time, label_axes
from vasowave.nominal import Nominal
from vasowave.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LOOP_SAMPLES = 256


def plot_upstroke(ax: "Axes", nominal: Nominal, recording: Recording, color: str = CTL) -> "Axes":
    """Draw the measured pressure-flow loop, the samples of the upstroke and the line whose slope is Z_c (eq. 8)."""
    even = recording.resampled(max(_LOOP_SAMPLES, len(recording.pressure), len(recording.flow)))
    ax.plot(closed(even.flow), closed(even.pressure), color=DATA, label="measured")
    flow, pressure = nominal.upstroke
    ax.plot(flow, pressure, ".", color=color, markersize=4, label="upstroke")
    ends = np.array([even.flow.min(), even.flow.max()])
    line = pressure.mean() + nominal.characteristic_impedance * (ends - flow.mean())
    label = f"$Z_c$ = {nominal.characteristic_impedance:.3g} mmHg s/ml"
    ax.plot(ends, line, color=color, linestyle="dashed", label=label)
    ax.legend()
    return label_axes(ax, "flow [ml/s]", "pressure [mmHg]")


def plot_decay(ax: "Axes", nominal: Nominal, recording: Recording, color: str = CTL) -> "Axes":
    """Draw the measured pressure and the exponential fitted to its diastolic decay (eq. 12)."""
    time, pressure = nominal.decay
    period, start = recording.period, time[0]
    cycle = closed_time(recording.time, period)
    shown = np.concatenate([cycle[:-1], cycle + period]) if time[-1] > period else cycle
    measured = np.tile(recording.pressure, 2) if time[-1] > period else recording.pressure
    ax.plot(shown, closed(measured), color=DATA, label="measured")
    # A log-linear fit passes through the means, so the amplitude follows from them.
    level = np.exp(np.mean(np.log(pressure)) + np.mean(time - start) / nominal.time_constant)
    fitted = level * np.exp(-(time - start) / nominal.time_constant)
    label = f"τ = {nominal.time_constant:.3g} s"
    ax.plot(time, fitted, color=color, linestyle="dashed", linewidth=2.2, label=label)
    ax.set_xlim(0.0, max(period, time[-1] + 0.05 * period))
    ax.legend()
    return label_axes(ax, "time [s]", "pressure [mmHg]")
