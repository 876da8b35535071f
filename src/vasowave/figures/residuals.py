"""Residuals of a fit and their autocorrelation (the paper's figure "Residuals")."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_residuals(ax: "Axes", residuals: dict[str, np.ndarray], period: float) -> "Axes":
    """Draw residuals of pressure (mmHg, shape (sample,)) over one period T (s), one line per model."""
    for style, (name, r) in zip(_styles(residuals), residuals.items()):
        ax.plot(np.arange(len(r)) * period / len(r), r, color="black", linestyle=style, linewidth=1, label=name)
    ax.axhline(0, color="0.7", linewidth=0.8, zorder=0)
    ax.set(xlabel="time [s]", ylabel="measured - simulated pressure [mmHg]", xlim=(0, period))
    ax.legend(frameon=False)
    return ax


def plot_autocorrelation(ax: "Axes", residuals: dict[str, np.ndarray], period: float) -> "Axes":
    """Draw the circular autocorrelation of residuals up to half a period, with the 95 % band of white noise."""
    for style, (name, r) in zip(_styles(residuals), residuals.items()):
        rho = autocorrelation(r)
        lag = np.arange(len(rho)) * period / len(r)
        ax.plot(lag, rho, color="black", linestyle=style, linewidth=1, label=name)
    band = 1.96 / np.sqrt(min(len(r) for r in residuals.values()))
    ax.axhspan(-band, band, color="0.9", zorder=0, label="white noise, 95 %")
    ax.set(xlabel="lag [s]", ylabel="autocorrelation [-]", xlim=(0, period / 2), ylim=(-1.05, 1.05))
    ax.legend(frameon=False)
    return ax


def autocorrelation(residuals: np.ndarray) -> np.ndarray:
    """Circular autocorrelation of the centered residuals at lags of 0 … N//2 samples."""
    r = np.asarray(residuals, dtype=float)
    power = np.abs(np.fft.rfft(r - r.mean())) ** 2
    if not power.sum() > 0:
        raise InputError("the residuals do not vary; they have no autocorrelation")
    covariance = np.fft.irfft(power, len(r))
    return covariance[: len(r) // 2 + 1] / covariance[0]


def _styles(residuals: dict[str, np.ndarray]) -> list[str]:
    """Linear dashed, tangent solid; other models take what is left."""
    left = iter([":", "-.", "-", "--"] * len(residuals))
    known = {"linear": "--", "tangent": "-"}
    return [known.get(name) or next(left) for name in residuals]
