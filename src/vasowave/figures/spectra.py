"""Impedance spectra: modulus and phase (the paper's figures "Impd" and "hemoData")."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.descriptions import NORMAL
from vasowave.figures.style import DATA, FAINT, label_axes, plain_log

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes


def plot_modulus(ax: "Axes", spectrum: "xr.Dataset", error: np.ndarray | None = None, **line: Any) -> "Axes":
    """Draw |Z| over frequency (eq. 19); harmonics whose flow is at noise level are grey and hollow.

    `error` is the relative standard error of every harmonic, shape (harmonic,), drawn as an interval of 95 %.
    """
    modulus = spectrum["modulus"].values
    factor = np.exp(NORMAL * (np.zeros(len(modulus)) if error is None else error))
    _draw(ax, spectrum, modulus, (modulus - modulus / factor, modulus * factor - modulus), line)
    ax.set_yscale("log")
    plain_log(ax.yaxis)
    return label_axes(ax, "frequency [Hz]", "|Z| [mmHg s/ml]")


def plot_phase(ax: "Axes", spectrum: "xr.Dataset", error: np.ndarray | None = None, **line: Any) -> "Axes":
    """Draw the phase θ of Z over frequency (eq. 19), unwrapped; negative where pressure lags flow.

    `error` is the standard error of every harmonic, rad.
    """
    from matplotlib.ticker import FuncFormatter, MultipleLocator

    phase = unwrapped(spectrum["phase"].values, spectrum["reliable"].values.astype(bool))
    reach = NORMAL * (np.zeros(len(phase)) if error is None else error)
    _draw(ax, spectrum, phase, (reach, reach), line)
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
    whole = {1: "π", -1: "−π", 0: "0"}
    if count % 2:
        return f"{whole[count]}/2" if abs(count) == 1 else f"{count}π/2".replace("-", "−")
    half = count // 2
    return whole.get(half, f"{half}π".replace("-", "−"))


def _draw(
    ax: "Axes", spectrum: "xr.Dataset", values: np.ndarray, reach: tuple[np.ndarray, np.ndarray], line: dict[str, Any]
) -> None:
    good = spectrum["reliable"].values.astype(bool)
    frequency = spectrum["frequency"].values
    look: dict[str, Any] = {"color": DATA, "marker": "o", "markersize": 3, "linewidth": 1} | line
    ax.plot(frequency[good], values[good], **look)
    ax.plot(frequency[~good], values[~good], "o", color="0.6", fillstyle="none", markersize=3)
    if np.any(reach):
        both = np.stack(reach)[:, good]
        ax.errorbar(
            frequency[good], values[good], yerr=both, fmt="none", ecolor=look["color"], elinewidth=0.8, capsize=2
        )
