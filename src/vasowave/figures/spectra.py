"""Impedance spectra: modulus and phase (the paper's figure "Impd")."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from vasowave.analysis import InputImpedance


def plot_modulus(ax: "Axes", spectrum: "InputImpedance", color: str = "black", label: str = "") -> "Axes":
    """Draw |Z| over frequency; harmonics whose flow is at noise level are grey and hollow."""
    _draw(ax, spectrum, spectrum.modulus, color, label)
    ax.set(xlabel="frequency [Hz]", ylabel="impedance modulus [mmHg s/ml]", yscale="log")
    return ax


def plot_phase(ax: "Axes", spectrum: "InputImpedance", color: str = "black", label: str = "") -> "Axes":
    """Draw the phase of Z over frequency; negative where pressure lags flow."""
    _draw(ax, spectrum, spectrum.phase, color, label)
    ax.axhline(0, color="0.7", linewidth=0.8, zorder=0)
    ax.set(xlabel="frequency [Hz]", ylabel="impedance phase [rad]", ylim=(-np.pi, np.pi))
    return ax


def _draw(ax: "Axes", spectrum: "InputImpedance", values: np.ndarray, color: str, label: str) -> None:
    good = ~spectrum.at_noise
    ax.plot(spectrum.frequency[good], values[good], "o-", color=color, markersize=4, linewidth=1, label=label or None)
    ax.plot(spectrum.frequency[~good], values[~good], "o", color="0.6", fillstyle="none", markersize=4)
