"""Where the starts of the optimization ended, in order: a waterfall tells how many agree."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.figures.style import label_axes

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes


def plot_waterfall(ax: "Axes", calibration: "xr.Dataset", **line: Any) -> "Axes":
    """Draw S of every start over the best S, in rising order; starts that could not be simulated are left out."""
    S = calibration["start_S"].values
    S = np.sort(S[np.isfinite(S)])
    look: dict[str, Any] = {"marker": "o", "markersize": 3, "linewidth": 0.9} | line
    ax.plot(np.arange(1, len(S) + 1), S / S[0], **look)
    ax.locator_params(axis="x", integer=True)
    return label_axes(ax, "start, in order of S", "S / best S [1]")
