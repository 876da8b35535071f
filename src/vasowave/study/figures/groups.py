"""Groups of animals: means beside every animal ("ParOpt"), also cell by cell, importance indices, ratios, waveforms."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vasowave.base.descriptions import ROUNDING
from vasowave.base.errors import InputError
from vasowave.study.animal.reading import from_foot
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.pooling import Interval
from vasowave.study.figures.matplotlib_style import (
    DATA,
    FAINT,
    LABELS,
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
from vasowave.study.figures.rendering import mark

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

_APART = 1.25  # of two sources, where the points of one are 0.3 wide
_SHARES = 128  # of a cycle at which waveforms are averaged
_STEP, _GAP = 1.0, 0.7  # from cell to cell, and further from group to group or from source to source
_MOST = 16  # letters of a level
_LINE = 2.6  # letters side by side that one upright line takes


@dataclass(frozen=True)
class _Additions:
    """What `plot_groups` draws and writes besides the animals."""

    means: Mapping[tuple[str, str], Interval] | None = None
    annotations: Mapping[str, str] | None = None
    named: bool = True


def plot_groups(
    ax: "Axes",
    table: "pd.DataFrame",
    quantity: str,
    label: str = "",
    groups: Mapping[str, GroupLook] | None = None,
    sources: Mapping[str, SourceLook] | None = None,
    **additions: Any,
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
    means : mapping of (str, str) to Interval, optional
        Of group and source.
    annotations : mapping of str to str, optional
        Words above a group, its p.
    named : bool
        Whether names of groups stand below; else a legend has to say them.
    """
    if not {quantity, "group"} <= set(table.columns):
        raise InputError(f"no column '{quantity}' or 'group'; there are: {', '.join(map(str, table.columns))}")
    drawn = _Additions(**additions)
    groups, means, annotations = groups or group_looks(table["group"]), drawn.means or {}, drawn.annotations or {}
    table = table if "source" in table.columns else table.assign(source="measured")
    source_names = table["source"].unique().tolist()
    sources, step = sources or source_looks(source_names), _APART * len(source_names) + 0.4
    ticks: dict[float, str] = {}
    for column, (group, rows) in enumerate(table.groupby("group", sort=False)):
        sizes = []
        for place, source in enumerate(source_names):
            animals = rows[(rows["source"] == source) & np.isfinite(rows[quantity].astype(float))]
            mean = means.get((str(group), source))
            _animals(ax, column * step + _APART * place, animals, quantity, groups[str(group)], sources[source], mean)
            ticks[column * step + _APART * place] = sources[source].short if len(source_names) > 1 else ""
            sizes.append(str(animals["subject"].nunique() if "subject" in animals else len(animals)))
        middle = column * step + _APART * (len(source_names) - 1) / 2
        count = f"n = {', '.join(dict.fromkeys(sizes))}"
        name = f"{short(str(group), 14)}\n{count}" if drawn.named else count
        ticks[middle] = f"{ticks.get(middle, '')}\n{name}" if len(source_names) > 1 else name
        if words := annotations.get(str(group)):
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
        heights = np.array([names.index(name) for name in rows["quantity"]]) + (place + 0.5) / len(series) * 0.7 - 0.35
        group_look, color = groups[group], darker(groups[group].color, sources[source].shade)
        text = short(group) if source == "measured" else f"{short(group)}, {source} wall"
        eta = rows["eta"].to_numpy(float)
        reach = np.stack([eta - rows["low"], rows["high"] - eta])
        reach[np.abs(reach) < ROUNDING * (1 + np.abs(eta))] = 0.0  # an end that is the value itself
        ax.errorbar(eta, heights, xerr=reach, fmt=group_look.marker, color=color,
                    mfc=color if sources[source].filled else "white", ms=4, elinewidth=1, capsize=2,
                    label=text)  # fmt: skip
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
        line_style: dict[str, Any] = (
            {"color": DATA, "linewidth": 1.8, "zorder": 4} if first else {"color": color, "lw": 0.6}
        )
        (line,) = ax.plot(*from_foot(result, quantity), **line_style)
        mark(line, result.name, result.name)
    ax.set_xlim(0, 1)
    return label_axes(ax, "time from the foot [T]", LABELS[quantity])


def plot_mean_waveform(ax: "Axes", results: "Sequence[AnimalResult]", quantity: str, group_look: GroupLook) -> None:
    """Draw the mean of the cycles of `plot_waveforms` at equal shares of the cycle, and a band of one SD."""
    if len(results) < 2:
        return
    share = np.linspace(0, 1, _SHARES + 1)
    cycles = [np.interp(share, *from_foot(result, quantity), period=1.0) for result in results]
    mean, spread = np.mean(cycles, axis=0), np.std(cycles, axis=0, ddof=1)
    ax.fill_between(share, mean - spread, mean + spread, color=group_look.color, alpha=0.25, lw=0, zorder=1)
    (line,) = ax.plot(share, mean, color=darker(group_look.color, 0.2), marker=group_look.marker, markevery=(8, 24),
                      ms=4, lw=1.8, zorder=5)  # fmt: skip
    mark(line, f"mean of {results[0].group}")


def plot_flow_loops(ax: "Axes", results: "Sequence[AnimalResult]", group_look: GroupLook) -> "Axes":
    """Draw measured pressure over flow of every animal of a group, and of their mean cycles; a dot is the foot."""
    share = np.linspace(0, 1, _SHARES + 1)
    cycles = np.array([[np.interp(share, *from_foot(result, quantity), period=1.0) for quantity in ("flow", "pressure")]
                       for result in results])  # fmt: skip
    for result, (flow, pressure) in zip(results, cycles, strict=True):
        (line,) = ax.plot(flow, pressure, color=group_look.color, lw=0.6)
        mark(line, result.name, result.name)
    flow, pressure = cycles.mean(axis=0)
    (line,) = ax.plot(flow, pressure, color=darker(group_look.color, 0.2), marker=group_look.marker, markevery=[0],
                      ms=5, lw=1.8, zorder=5)  # fmt: skip
    mark(line, f"mean of {results[0].group}")
    return label_axes(ax, LABELS["flow"], LABELS["pressure"])


def plot_mean_impedance(ax: "Axes", results: "Sequence[AnimalResult]", quantity: str, group_look: GroupLook) -> "Axes":
    """Draw mean and SD (band) of a group's modulus (geometric) or phase at harmonics whose flow all animals tell."""
    spectra = [result.measured.impedance for result in results]
    count = min(spectrum.sizes["harmonic"] for spectrum in spectra)
    heard = np.all([spectrum["reliable"].values[:count] != 0 for spectrum in spectra], axis=0)
    values = np.array([spectrum[quantity].values[:count] for spectrum in spectra])[:, heard]
    frequency = np.mean([spectrum["frequency"].values[:count] for spectrum in spectra], axis=0)[heard]
    if quantity == "phase":  # angles have no mean across a whole turn; their directions have
        direction = np.exp(1j * values).mean(axis=0)
        mean, spread = np.unwrap(np.angle(direction)), np.sqrt(-2 * np.log(np.minimum(np.abs(direction), 1.0)))
        low, high = mean - spread, mean + spread
    else:
        mean, spread = np.log(values).mean(axis=0), np.log(values).std(axis=0)
        low, mean, high = np.exp(mean - spread), np.exp(mean), np.exp(mean + spread)
    (line,) = ax.plot(
        frequency, mean, color=darker(group_look.color, 0.2), marker=group_look.marker, ms=4, lw=1.6, zorder=5
    )
    mark(line, f"mean of {results[0].group}")
    if len(results) > 1:
        ax.fill_between(frequency, low, high, color=group_look.color, alpha=0.25, lw=0, zorder=1)
    unit = "mmHg s/ml" if quantity == "modulus" else "rad"
    return label_axes(ax, "frequency [Hz]", f"{quantity} [{unit}]")


def _animals(
    ax: "Axes", position: float, rows: "pd.DataFrame", quantity: str, group_look: GroupLook, source: SourceLook,
    mean: Interval | None,
) -> None:  # fmt: skip
    x = rows[quantity].to_numpy(dtype=float)
    # Animals side by side in order of rank, so that equal values stay visible.
    spread = (np.argsort(np.argsort(x)) % 3 - 1) * 0.12 - 0.16
    names = rows["animal"] if "animal" in rows else [""] * len(x)
    for place, value, name in zip(position + spread, x, names, strict=True):
        _animal(ax, (place, value), str(name), group_look, source)
    if mean is not None:
        plot_mean(ax, position + 0.24, mean)


def plot_mean(ax: "Axes", position: float, mean: Interval) -> None:
    """Draw a mean with its interval, where one is known."""
    reach = [[mean.value - mean.low], [mean.high - mean.value]]
    interval = None if np.isnan(mean.low) else reach
    ax.errorbar([position], [mean.value], yerr=interval, fmt="_", color=DATA, ms=6, mew=1.6, elinewidth=1, capsize=2)


class _Place(NamedTuple):
    group: str
    cell: str
    source: str
    x: float
    tick: str


def plot_cells(
    ax: "Axes",
    table: "pd.DataFrame",
    quantity: str,
    label: str,
    looks: tuple[Mapping[str, GroupLook], Mapping[str, SourceLook]],
    means: Mapping[tuple[str, str], Interval],
    room: int = 26,
) -> "Axes":
    """Draw a point per recording, the levels of a group side by side, and beside them each cell's mean.

    Parameters
    ----------
    ax : matplotlib Axes
    table : DataFrame
        Columns ``animal, subject, group, cell, level, source`` and `quantity`.
    quantity, label : str
        Name of a column, and of the axis.
    looks : tuple of mapping
        How groups and sources look.
    means : mapping of (str, str) to Interval
        Of cell and source.
    room : int
        Letters that fit below the panel side by side; where levels need more they stand upright.
    """
    groups, sources = looks
    places = _places(table, quantity, sources)
    for (group, source), rows in table.groupby(["group", "source"], sort=False):
        positions = {place.cell: place.x for place in places if (place.group, place.source) == (group, source)}
        _animals_of_cells(ax, positions, rows, quantity, groups[str(group)], sources[str(source)])
    for place in places:
        if (mean := means.get((place.cell, place.source))) is not None:
            plot_mean(ax, place.x + 0.3, mean)
    widest = max(len(line) for place in places for line in place.tick.split("\n"))
    upright = (widest + 0.5) * (places[-1].x + 1.3) > room * _STEP
    texts = [place.tick.replace("\n", ", ") if upright else place.tick for place in places]
    if len(places) > room / _LINE:  # not even upright: the first of each group and source, the caption has the order
        runs = [(place.group, place.source) for place in places]
        firsts = [row == 0 or runs[row] != runs[row - 1] for row in range(len(runs))]
        texts = [text if first else "" for text, first in zip(texts, firsts, strict=True)]
    ax.set_xticks([place.x for place in places], texts, fontsize=SMALL, rotation=90 if upright else 0)
    ax.tick_params(axis="x", length=0)
    ax.set_xlim(-0.6, places[-1].x + 0.7)
    return label_axes(ax, "", label)


def _places(table: "pd.DataFrame", quantity: str, sources: Mapping[str, SourceLook]) -> list[_Place]:
    """Return where each cell of each source stands, and what is written below it."""
    several = table["source"].nunique() > 1
    places: list[_Place] = []
    x, before = 0.0, ("", "")
    order = {"group": [*table["group"].unique()], "source": [*sources], "cell": [*table["cell"].unique()]}
    table = table.sort_values([*order], key=lambda column: column.map(order[str(column.name)].index), kind="stable")
    for key, rows in table.groupby(["group", "source", "cell"], sort=False):
        group, source, cell = map(str, key)
        x += 0.0 if not places else _STEP if (group, source) == before else _STEP + _GAP
        before = (group, source)
        law = f"{sources[source].short}\n" if several else ""
        lacking = rows.loc[rows[quantity].isna(), "subject"].nunique()
        count = f"\nn = {rows['subject'].nunique() - lacking}" if lacking else ""
        tick = f"{law}{short(str(rows['level'].iloc[0]), _MOST)}{count}"
        places.append(_Place(group, cell, source, x, tick))
    return places


def _animals_of_cells(
    ax: "Axes",
    positions: Mapping[str, float],
    rows: "pd.DataFrame",
    quantity: str,
    group_look: GroupLook,
    source: SourceLook,
) -> None:
    """Draw the points of one group by one source, and the lines through those of one animal."""
    color = darker(group_look.color, source.shade)
    rows = rows[np.isfinite(rows[quantity].astype(float))].assign(x=rows["cell"].map(positions))
    for _, subject_rows in rows.sort_values("x", kind="stable").groupby("subject", sort=False):
        if subject_rows["x"].nunique() > 1:
            (line,) = ax.plot(subject_rows["x"], subject_rows[quantity], color=color, lw=0.7, alpha=0.6, zorder=1)
            mark(line, "", str(subject_rows["animal"].iloc[0]))
        places = zip(subject_rows["x"], subject_rows[quantity].astype(float), strict=True)
        for name, place in zip(subject_rows["animal"], places, strict=True):
            _animal(ax, place, str(name), group_look, source)


def _animal(ax: "Axes", place: tuple[float, float], name: str, group_look: GroupLook, source: SourceLook) -> None:
    """Draw the point of one animal, hollow where those of the source are."""
    x, y = place
    color = darker(group_look.color, source.shade)
    (point,) = ax.plot([x], [y], group_look.marker, color=color, mfc=color if source.filled else "none", ms=3.2)
    if name:
        mark(point, name, name)
