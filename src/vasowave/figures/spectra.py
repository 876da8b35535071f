"""Impedance spectra: modulus and phase (the paper's figures "Impd" and "hemoData")."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.figures.style import DATA, FAINT, label_axes, plain_log

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes


def plot_modulus(ax: "Axes", spectrum: "xr.Dataset", **line: Any) -> "Axes":
    """Draw |Z| over frequency (eq. 19); harmonics whose flow is at noise level are grey and hollow."""
    _draw(ax, spectrum, "modulus", line)
    ax.set_yscale("log")
    plain_log(ax.yaxis)
    return label_axes(ax, "frequency [Hz]", "|Z| [mmHg s/ml]")


def plot_phase(ax: "Axes", spectrum: "xr.Dataset", **line: Any) -> "Axes":
    """Draw the phase θ of Z over frequency (eq. 19); negative where pressure lags flow."""
    _draw(ax, spectrum, "phase", line)
    ax.axhline(0, color=FAINT, linewidth=0.8, zorder=0)
    ax.set_ylim(-np.pi, np.pi)
    ax.set_yticks([-np.pi, -np.pi / 2, 0, np.pi / 2, np.pi], ["-π", "-π/2", "0", "π/2", "π"])
    return label_axes(ax, "frequency [Hz]", "phase θ [rad]")


def _draw(ax: "Axes", spectrum: "xr.Dataset", name: str, line: dict[str, Any]) -> None:
    good = spectrum["reliable"].values.astype(bool)
    frequency, values = spectrum["frequency"].values, spectrum[name].values
    look: dict[str, Any] = {"color": DATA, "marker": "o", "markersize": 3, "linewidth": 1} | line
    ax.plot(frequency[good], values[good], **look)
    ax.plot(frequency[~good], values[~good], "o", color="0.6", fillstyle="none", markersize=3)
