"""Groups of animals: boxes with every animal ("ParOpt"), importance indices ("ParAll_change"), ratios, waveforms."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.animal.result import AnimalResult
from vasowave.errors import InputError
from vasowave.figures.marks import mark
from vasowave.figures.style import (
    DATA,
    FAINT,
    GroupLook,
    SourceLook,
    closed,
    closed_time,
    group_looks,
    label_axes,
    ratio_ticks,
    short,
    source_looks,
)

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


def plot_groups(
    ax: "Axes",
    table: "pd.DataFrame",
    quantity: str,
    label: str = "",
    groups: Mapping[str, GroupLook] | None = None,
    sources: Mapping[str, SourceLook] | None = None,
) -> "Axes":
    """Draw a box per group, and per source where a group has several, and a point per animal; a cross is the mean.

    Parameters
    ----------
    ax : matplotlib Axes
    table : DataFrame
        Columns ``group``, `quantity` and, where several stand side by side, ``source``, whose hatch tells them apart.
    quantity : str
        Name of a column, ``quantity [unit]``.
    label : str
        Of the axis, if not the name of the column.
    groups, sources : mapping, optional
        How they look, where one figure holds several panels.
    """
    if not {quantity, "group"} <= set(table.columns):
        raise InputError(f"no column '{quantity}' or 'group'; there are: {', '.join(map(str, table.columns))}")
    groups = groups or group_looks(table["group"])
    table = table if "source" in table.columns else table.assign(source="measured")
    there = table["source"].unique().tolist()
    sources, step = sources or source_looks(there), len(there) + 0.6
    ticks: dict[float, str] = {}
    for column, (group, rows) in enumerate(table.groupby("group", sort=False)):
        for place, source in enumerate(there):
            x = rows.loc[rows["source"] == source, quantity].to_numpy(dtype=float)
            _box(ax, column * step + place, x[np.isfinite(x)], groups[str(group)], sources[source].hatch)
            ticks[column * step + place] = sources[source].short if len(there) > 1 else f"(n = {len(x)})"
        middle, above = column * step + (len(there) - 1) / 2, len(there) > 1
        ticks[middle] = (
            f"{ticks.get(middle, '')}\n{short(str(group), 14)}"
            if above
            else f"{short(str(group), 14)}\n{ticks[middle]}"
        )
    ax.set_xticks(list(ticks), list(ticks.values()), fontsize=7.5)
    ax.tick_params(axis="x", length=0)
    ax.set_xlim(-0.7, max(ticks) + (len(there) - 1) / 2 + 0.7)
    return label_axes(ax, "", label or quantity)


def plot_importance(
    ax: "Axes", indices: "pd.DataFrame", groups: Mapping[str, GroupLook], sources: Mapping[str, SourceLook]
) -> "Axes":
    """Draw the importance index η (eq. 20): one row per ``quantity``, one bar per ``source`` and compared ``group``."""
    names = indices["quantity"].unique().tolist()
    series = list(dict.fromkeys(zip(indices["source"], indices["group"])))
    height = 0.8 / len(series)
    for place, (source, group) in enumerate(series):
        rows = indices[(indices["source"] == source) & (indices["group"] == group)]
        at = np.array([names.index(name) for name in rows["quantity"]]) + (place - (len(series) - 1) / 2) * height
        text = short(group) if source == "measured" else f"{short(group)}, {source} wall"
        style: dict[str, Any] = {
            "color": groups[group].color,
            "edgecolor": DATA,
            "linewidth": 0.6,
            "hatch": sources[source].hatch,
        }
        ax.barh(at, rows["eta"], height, label=text, alpha=0.75, **style)
    ax.axvline(0, color=DATA, linewidth=0.8)
    ax.set_yticks(range(len(names)), names)
    ax.invert_yaxis()
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderaxespad=0.0)
    return label_axes(ax, "importance index η [1]", "")


def plot_ratios(ax: "Axes", contrasts: "pd.DataFrame") -> "Axes":
    """Draw the ratio of geometric means with its interval for every row of `cohort.contrasts`, on a log axis."""
    rows = np.arange(len(contrasts))[::-1]
    ratio = contrasts["ratio"].to_numpy()
    reach = np.stack([ratio - contrasts["ratio low"], contrasts["ratio high"] - ratio])
    ax.errorbar(ratio, rows, xerr=reach, fmt="o", color=DATA, capsize=3, linewidth=1, markersize=4)
    ax.axvline(1, color=FAINT, linewidth=0.8, zorder=0)
    ax.set_yticks(rows, contrasts["quantity"].tolist())
    ax.set_ylim(-0.7, len(rows) - 0.3)
    ax.set_xscale("log")
    ticks = ratio_ticks(min(contrasts["ratio low"].min(), 1), max(contrasts["ratio high"].max(), 1))
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.minorticks_off()
    return label_axes(ax, "ratio of geometric means [1]", "")


def plot_waveforms(ax: "Axes", results: "Sequence[AnimalResult]", quantity: str, color: str, shown: str = "") -> "Axes":
    """Draw the measured cycle of every animal of a group, the one called `shown` in black (the paper's "hemoData")."""
    for result in results:
        recording = result.recording
        time = recording["time" if quantity == "pressure" else "flow_time"].values
        first = result.name == shown
        look: dict[str, Any] = {"color": DATA, "linewidth": 1.8, "zorder": 4} if first else {"color": color, "lw": 0.9}
        (line,) = ax.plot(closed_time(time, result.period), closed(recording[quantity].values), **look)
        mark(line, result.name, result.name)
    return label_axes(ax, "time [s]", {"pressure": "pressure [mmHg]", "flow": "flow [ml/s]"}[quantity])


def _box(ax: "Axes", at: float, x: np.ndarray, look: GroupLook, hatch: str) -> None:
    if len(x) == 0:
        return
    drawn = ax.boxplot(
        [x], positions=[at], widths=0.7, patch_artist=True, showfliers=False, showmeans=True, manage_ticks=False,
        meanprops={"marker": "x", "markeredgecolor": DATA, "markersize": 5}, medianprops={"color": DATA},
    )  # fmt: skip
    drawn["boxes"][0].set(facecolor=(look.color, 0.45), hatch=hatch)
    # Animals side by side in order of rank, so that equal values stay visible.
    spread = (np.argsort(np.argsort(x)) % 3 - 1) * 0.14
    ax.plot(at + spread, x, look.marker, color=DATA, markersize=2.5, ls="none")
