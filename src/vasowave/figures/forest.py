"""A forest plot: one row for each quantity, its effect and interval, the same by other sources, every animal."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vasowave.figures.marks import mark
from vasowave.figures.style import DATA, FAINT, GroupLook, SourceLook, label_axes, new_figure, ratio_ticks, short

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROW = 0.62  # cm
_BELOW = 0.26  # of a row: from one source to the next


class Point(NamedTuple):
    """A ratio with its interval (equal to it where none is known), and the source that it comes from."""

    value: float
    low: float
    high: float
    source: str
    tip: str = ""


class Dot(NamedTuple):
    """One animal's value as a ratio, its group, name, and words."""

    value: float
    group: str
    animal: str
    tip: str


class Row(NamedTuple):
    """One row of a forest plot.

    Attributes
    ----------
    heading : str
        What the row is about; written above the first row of several.
    label : str
        Name of the quantity.
    effect, aside : str
        Written at the right: the effect in numbers, and what is said of it.
    point : Point
        Drawn large.
    beside : sequence of Point
        The same by other sources, drawn small below it.
    dots : sequence of Dot
    """

    heading: str
    label: str
    effect: str
    aside: str
    point: Point
    beside: Sequence[Point] = ()
    dots: Sequence[Dot] = ()


def forest_figure(
    rows: Sequence[Row],
    groups: Mapping[str, GroupLook],
    sources: Mapping[str, SourceLook],
    axis: str,
    columns: tuple[str, str],
) -> "Figure":
    """Draw rows on one logarithmic axis called `axis`; `columns` name the numbers at the right."""
    places = _places(rows)
    height = 2.0 + _ROW * (1 - min(places))
    figure = new_figure(17, height)
    widths = [4.5, 6.7, 5.0] if columns[1] else [4.5, 5.5, 6.2]  # values with their units are long
    left, middle, right = figure.subplots(1, 3, sharey=True, width_ratios=widths)
    for ax in (left, right):
        ax.set_axis_off()
    for y, row in zip(places, rows, strict=True):
        _draw(middle, y, row, groups, sources)
        _write(left, 1.0, y, row.label, ha="right")
        _write(right, 0.0, y, row.effect)
        _write(right, 1.0, y, row.aside, ha="right")
    for y, heading in _headings(rows, places):
        _write(left, 0.0, y, heading, fontweight="bold")
    _write(right, 0.0, 0.9, columns[0], color="0.35")
    _write(right, 1.0, 0.9, columns[1], color="0.35", ha="right")
    middle.set_ylim(min(places) - 0.8, 1.3)
    for ax in (left, right):
        ax.set_xlim(0, 1)
    _legend(figure, rows, groups, sources)
    _scale(middle, rows)
    label_axes(middle, axis, "").tick_params(axis="y", length=0, labelleft=False)
    middle.spines["left"].set_visible(False)
    return figure


def _write(ax: "Axes", x: float, y: float, text: str, **look: Any) -> None:
    """Write into a column; its width is given, whatever the text."""
    ax.text(x, y, text, va="center", fontsize=8.5, **look).set_in_layout(False)


def _places(rows: Sequence[Row]) -> list[float]:
    """Return the height of every row, with room above the first of each heading."""
    places, y, heading = [], 0.0, ""
    for row in rows:
        y -= 1.9 if row.heading != heading else 1.0
        heading = row.heading
        places.append(y)
    return [place + 1.0 for place in places]


def _headings(rows: Sequence[Row], places: Sequence[float]) -> list[tuple[float, str]]:
    first: dict[str, float] = {}
    for y, row in zip(places, rows, strict=True):
        first.setdefault(row.heading, y + 0.9)
    return [(y, heading) for heading, y in first.items()]


def _draw(ax: "Axes", y: float, row: Row, groups: Mapping[str, GroupLook], sources: Mapping[str, SourceLook]) -> None:
    for dot in row.dots:
        look = groups[dot.group]
        (drawn,) = ax.plot([dot.value], [y], look.marker, color=look.color, ms=4.5, alpha=0.55, mec="none")
        mark(drawn, dot.tip, dot.animal)
    _point(ax, y, row.point, DATA, "D", 6, 1.6)
    for place, point in enumerate(row.beside, start=1):
        _point(ax, y - _BELOW * place, point, "0.45", sources[point.source].marker, 3.5, 0.9)


def _point(ax: "Axes", y: float, point: Point, color: str, marker: str, size: float, width: float) -> None:
    ax.plot([point.low, point.high], [y, y], color=color, lw=width, solid_capstyle="butt", zorder=3)
    face = color if marker == "D" else "none"
    (drawn,) = ax.plot([point.value], [y], marker, color=color, mfc=face, ms=size, zorder=4)
    mark(drawn, point.tip)


def _scale(ax: "Axes", rows: Sequence[Row]) -> None:
    """Show every interval and every animal, unless one is so wide that the others could not be read."""
    points = [point for row in rows for point in (row.point, *row.beside)]
    ends = np.array(
        [end for one in points for end in (one.low, one.high)] + [d.value for row in rows for d in row.dots]
    )
    ends = ends[(ends > 0) & np.isfinite(ends)]
    low, high = max(0.02, min(1.0, ends.min()) / 1.1), min(50.0, max(1.0, ends.max()) * 1.1)
    ax.set_xscale("log")
    ax.set_xlim(low, high)
    ticks = [tick for tick in ratio_ticks(low, high) if low <= tick <= high]
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.minorticks_off()
    ax.axvline(1, color=FAINT, lw=0.9, zorder=0)


def _legend(
    figure: "Figure", rows: Sequence[Row], groups: Mapping[str, GroupLook], sources: Mapping[str, SourceLook]
) -> None:
    from matplotlib.lines import Line2D

    entries = []
    for group in dict.fromkeys(dot.group for row in rows for dot in row.dots):
        look = groups[group]
        entries.append(
            Line2D([], [], color=look.color, marker=look.marker, ls="", ms=4.5, alpha=0.55, label=short(group))
        )
    for source in dict.fromkeys(point.source for row in rows for point in row.beside):
        marker = sources[source].marker
        name = source if source == "data" else f"{source} wall"
        entries.append(Line2D([], [], color="0.45", marker=marker, mfc="none", ms=3.5, lw=0.9, label=name))
    if entries:
        figure.legend(handles=entries, loc="outside upper center", ncols=4)
