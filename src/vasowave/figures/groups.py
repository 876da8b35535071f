"""Groups of animals: boxes with every animal (the paper's figure "ParOpt"), and ratios with intervals."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.errors import InputError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

COLORS = {"CTL": "cyan", "HPH": "magenta"}
"""Colors of the paper's groups; others take what is left."""


def plot_groups(ax: "Axes", table: "pd.DataFrame", quantity: str) -> "Axes":
    """Draw a box per group and a point per animal, for one column ``quantity [unit]`` of a table with ``group``."""
    if not {quantity, "group"} <= set(table.columns):
        raise InputError(f"no column '{quantity}' or 'group'; there are: {', '.join(map(str, table.columns))}")
    labels = table["group"].unique().tolist()
    samples = [table.loc[table["group"] == label, quantity].to_numpy(dtype=float) for label in labels]
    places = np.arange(1, len(labels) + 1)
    boxes = ax.boxplot(samples, positions=places, widths=0.5, patch_artist=True, showfliers=False)
    others = iter(["orange", "0.6", "yellowgreen", "tan"] * len(labels))
    for label, box, median in zip(labels, boxes["boxes"], boxes["medians"]):
        box.set(facecolor=COLORS.get(label) or next(others), alpha=0.4)
        median.set(color="black")
    for place, x in zip(places, samples):
        # Animals side by side in order of rank, so that equal values stay visible.
        spread = (np.argsort(np.argsort(x)) % 3 - 1) * 0.08
        ax.plot(place + spread, x, "o", color="black", markersize=3)
    ax.set_xticks(places, [f"{label} (n = {len(x)})" for label, x in zip(labels, samples)])
    ax.set(xlabel="group", ylabel=quantity)
    return ax


def plot_ratios(ax: "Axes", contrasts: "pd.DataFrame") -> "Axes":
    """Draw the ratio of geometric means with its interval for every row of `cohort.contrasts`, on a log axis."""
    rows = np.arange(len(contrasts))[::-1]
    ratio = contrasts["ratio"].to_numpy()
    reach = np.stack([ratio - contrasts["ratio low"], contrasts["ratio high"] - ratio])
    ax.errorbar(ratio, rows, xerr=reach, fmt="o", color="black", capsize=3, linewidth=1)
    ax.axvline(1, color="0.7", linewidth=0.8, zorder=0)
    ax.set_yticks(rows, contrasts["quantity"].tolist())
    ax.set(xlabel="ratio of geometric means [-]", xscale="log")
    return ax
