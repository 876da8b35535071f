"""Every animal of groups that were measured at several occasions or levels, with a line through those of one animal."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vasowave.cohort.group_means import GroupMean
from vasowave.figures.groups import plot_mean
from vasowave.figures.marks import mark
from vasowave.figures.style import SMALL, GroupLook, SourceLook, darker, label_axes, short

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

_STEP, _GAP = 1.0, 0.7  # from cell to cell, and further from group to group or from source to source
_MOST = 16  # letters of a level
_LINE = 2.6  # letters side by side that one upright line takes


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
    groups: Mapping[str, GroupLook],
    sources: Mapping[str, SourceLook],
    means: Mapping[tuple[str, str], GroupMean],
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
    groups, sources : mapping
        How they look.
    means : mapping of (str, str) to GroupMean
        Of cell and source.
    room : int
        Letters that fit below the panel side by side; where levels need more they stand upright.
    """
    places = _places(table, quantity, sources)
    for (group, source), rows in table.groupby(["group", "source"], sort=False):
        at = {one.cell: one.x for one in places if (one.group, one.source) == (group, source)}
        _animals(ax, at, rows, quantity, groups[str(group)], sources[str(source)])
    for one in places:
        if (mean := means.get((one.cell, one.source))) is not None:
            plot_mean(ax, one.x + 0.3, mean)
    widest = max(len(line) for one in places for line in one.tick.split("\n"))
    upright = (widest + 0.5) * (places[-1].x + 1.3) > room * _STEP
    texts = [one.tick.replace("\n", ", ") if upright else one.tick for one in places]
    if len(places) > room / _LINE:  # not even upright: the first of each group and source, the caption has the order
        firsts = [one == 0 or _run(places[one]) != _run(places[one - 1]) for one in range(len(places))]
        texts = [text if first else "" for text, first in zip(texts, firsts, strict=True)]
    ax.set_xticks([one.x for one in places], texts, fontsize=SMALL, rotation=90 if upright else 0)
    ax.tick_params(axis="x", length=0)
    ax.set_xlim(-0.6, places[-1].x + 0.7)
    return label_axes(ax, "", label)


def _run(place: _Place) -> tuple[str, str]:
    return place.group, place.source


def _places(table: "pd.DataFrame", quantity: str, sources: Mapping[str, SourceLook]) -> list[_Place]:
    """Return where each cell of each source stands, and what is written below it."""
    several = table["source"].nunique() > 1
    places: list[_Place] = []
    x, before = 0.0, ("", "")
    order = {"group": [*table["group"].unique()], "source": [*sources], "cell": [*table["cell"].unique()]}
    table = table.sort_values([*order], key=lambda one: one.map(order[str(one.name)].index), kind="stable")
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


def _animals(
    ax: "Axes", at: Mapping[str, float], rows: "pd.DataFrame", quantity: str, look: GroupLook, source: SourceLook
) -> None:
    """Draw the points of one group by one source, and the lines through those of one animal."""
    color = darker(look.color, source.shade)
    rows = rows[np.isfinite(rows[quantity].astype(float))].assign(x=rows["cell"].map(at))
    for _, own in rows.sort_values("x", kind="stable").groupby("subject", sort=False):
        if own["x"].nunique() > 1:
            (line,) = ax.plot(own["x"], own[quantity], color=color, lw=0.7, alpha=0.6, zorder=1)
            mark(line, "", str(own["animal"].iloc[0]))
        for name, x, value in zip(own["animal"], own["x"], own[quantity].astype(float), strict=True):
            (point,) = ax.plot([x], [value], look.marker, color=color, mfc=color if source.filled else "none", ms=3.2)
            mark(point, str(name), str(name))
