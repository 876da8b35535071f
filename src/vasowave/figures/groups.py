"""Groups of animals: means beside every animal ("ParOpt"), importance indices ("ParAll_change"), ratios, waveforms."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.animal.reading import from_foot
from vasowave.animal.result import AnimalResult
from vasowave.cohort.group_means import GroupMean
from vasowave.descriptions import ROUNDING
from vasowave.errors import InputError
from vasowave.figures.marks import mark
from vasowave.figures.style import (
    DATA,
    FAINT,
    SMALL,
    GroupLook,
    SourceLook,
    darker,
    group_looks,
    label_axes,
    ratio_ticks,
    short,
    source_looks,
)

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

_APART = 1.25  # of two sources, where the points of one are 0.3 wide
_SHARES = 128  # of a cycle at which waveforms are averaged


def plot_groups(
    ax: "Axes",
    table: "pd.DataFrame",
    quantity: str,
    label: str = "",
    groups: Mapping[str, GroupLook] | None = None,
    sources: Mapping[str, SourceLook] | None = None,
    means: Mapping[tuple[str, str], GroupMean] | None = None,
    said: Mapping[str, str] | None = None,
    named: bool = True,
) -> "Axes":
    """Draw a point per animal and beside them the group's mean with its interval; sources stand side by side.

    Parameters
    ----------
    ax : matplotlib Axes
    table : DataFrame
        Columns ``group``, `quantity` and, where several stand side by side, ``source``: one's points may be hollow.
        Where rows are of the same animals, ``subject``, by which n counts them.
    quantity : str
        Name of a column, ``quantity [unit]``.
    label : str
        Of the axis, if not the name of the column.
    groups, sources : mapping, optional
        How they look, where one figure holds several panels.
    means : mapping of (str, str) to GroupMean, optional
        Of group and source.
    said : mapping of str to str, optional
        Words above a group, its p.
    named : bool
        Whether names of groups stand below; else a legend has to say them.
    """
    if not {quantity, "group"} <= set(table.columns):
        raise InputError(f"no column '{quantity}' or 'group'; there are: {', '.join(map(str, table.columns))}")
    groups = groups or group_looks(table["group"])
    table = table if "source" in table.columns else table.assign(source="measured")
    there = table["source"].unique().tolist()
    sources, step = sources or source_looks(there), _APART * len(there) + 0.4
    ticks: dict[float, str] = {}
    for column, (group, rows) in enumerate(table.groupby("group", sort=False)):
        sizes = []
        for place, source in enumerate(there):
            own = rows[(rows["source"] == source) & np.isfinite(rows[quantity].astype(float))]
            mean = (means or {}).get((str(group), source))
            _animals(ax, column * step + _APART * place, own, quantity, groups[str(group)], sources[source], mean)
            ticks[column * step + _APART * place] = sources[source].short if len(there) > 1 else ""
            sizes.append(str(own["subject"].nunique() if "subject" in own else len(own)))
        middle = column * step + _APART * (len(there) - 1) / 2
        count = f"n = {', '.join(dict.fromkeys(sizes))}"
        name = f"{short(str(group), 14)}\n{count}" if named else count
        ticks[middle] = f"{ticks.get(middle, '')}\n{name}" if len(there) > 1 else name
        if words := (said or {}).get(str(group)):
            ax.annotate(words, (middle, 1.0), (0, 1), ("data", "axes fraction"), "offset points", ha="center",
                        va="bottom", fontsize=SMALL)  # fmt: skip
    ax.set_xticks(list(ticks), list(ticks.values()), fontsize=SMALL)
    ax.tick_params(axis="x", length=0)
    ax.set_xlim(-0.7, max(ticks) + 0.7)
    return label_axes(ax, "", label or quantity)


def plot_importance(
    ax: "Axes", indices: "pd.DataFrame", groups: Mapping[str, GroupLook], sources: Mapping[str, SourceLook]
) -> "Axes":
    """Draw the importance index η (eq. 20) with its interval: one row per ``quantity``, in it sources and groups."""
    names = indices["quantity"].unique().tolist()
    series = list(dict.fromkeys(zip(indices["source"], indices["group"])))
    for place, (source, group) in enumerate(series):
        rows = indices[(indices["source"] == source) & (indices["group"] == group)]
        at = np.array([names.index(name) for name in rows["quantity"]]) + (place + 0.5) / len(series) * 0.7 - 0.35
        look, color = groups[group], darker(groups[group].color, sources[source].shade)
        text = short(group) if source == "measured" else f"{short(group)}, {source} wall"
        eta = rows["eta"].to_numpy(float)
        reach = np.stack([eta - rows["low"], rows["high"] - eta])
        reach[np.abs(reach) < ROUNDING * (1 + np.abs(eta))] = 0.0  # an end that is the value itself
        ax.errorbar(eta, at, xerr=reach, fmt=look.marker, color=color, mfc=color if sources[source].filled else "white",
                    ms=4, elinewidth=1, capsize=2, label=text)  # fmt: skip
    for row in range(1, len(names)):
        ax.axhline(row - 0.5, color="0.9", linewidth=0.6, zorder=0)
    ax.axvline(0, color=DATA, linewidth=0.8, zorder=0)
    ax.set_yticks(range(len(names)), names)
    ax.set_ylim(len(names) - 0.5, -0.5)
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=1 if len(series) < 3 else 2, borderaxespad=0.0)
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
    """Draw the measured cycle of every animal of a group from its foot, the one called `shown` in black."""
    for result in results:
        first = result.name == shown
        look: dict[str, Any] = {"color": DATA, "linewidth": 1.8, "zorder": 4} if first else {"color": color, "lw": 0.6}
        (line,) = ax.plot(*from_foot(result, quantity), **look)
        mark(line, result.name, result.name)
    ax.set_xlim(0, 1)
    return label_axes(ax, "time from the foot [T]", {"pressure": "pressure [mmHg]", "flow": "flow [ml/s]"}[quantity])


def plot_mean_waveform(ax: "Axes", results: "Sequence[AnimalResult]", quantity: str, look: GroupLook) -> None:
    """Draw the mean of the cycles of `plot_waveforms` at equal shares of the cycle, and a band of one SD."""
    if len(results) < 2:
        return
    share = np.linspace(0, 1, _SHARES + 1)
    cycles = [np.interp(share, *from_foot(result, quantity), period=1.0) for result in results]
    mean, spread = np.mean(cycles, axis=0), np.std(cycles, axis=0, ddof=1)
    ax.fill_between(share, mean - spread, mean + spread, color=look.color, alpha=0.25, lw=0, zorder=1)
    (line,) = ax.plot(share, mean, color=darker(look.color, 0.2), marker=look.marker, markevery=(8, 24), ms=4, lw=1.8,
                      zorder=5)  # fmt: skip
    mark(line, f"mean of {results[0].group}")


def _animals(
    ax: "Axes", at: float, rows: "pd.DataFrame", quantity: str, look: GroupLook, source: SourceLook,
    mean: GroupMean | None,
) -> None:  # fmt: skip
    x = rows[quantity].to_numpy(dtype=float)
    # Animals side by side in order of rank, so that equal values stay visible.
    spread = (np.argsort(np.argsort(x)) % 3 - 1) * 0.12 - 0.16
    color = darker(look.color, source.shade)
    for place, value, name in zip(at + spread, x, rows["animal"] if "animal" in rows else [""] * len(x), strict=True):
        (point,) = ax.plot([place], [value], look.marker, color=color, mfc=color if source.filled else "none", ms=3.2)
        if name:
            mark(point, str(name), str(name))
    if mean is not None:
        plot_mean(ax, at + 0.24, mean)


def plot_mean(ax: "Axes", at: float, mean: GroupMean) -> None:
    """Draw a mean with its interval, where one is known."""
    reach = [[mean.value - mean.low], [mean.high - mean.value]]
    known = None if np.isnan(mean.low) else reach
    ax.errorbar([at], [mean.value], yerr=known, fmt="_", color=DATA, ms=6, mew=1.6, elinewidth=1, capsize=2)
