"""A forest plot: one row for each quantity, its effect and interval, the same by other sources, every animal."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vasowave.study.figures.matplotlib_style import (
    DATA,
    FAINT,
    WIDEST,
    GroupLook,
    SourceLook,
    columns_that_fit,
    label_axes,
    new_figure,
    ratio_ticks,
    short,
)
from vasowave.study.figures.rendering import mark

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LANE = 0.14  # cm: what is drawn of one quantity stands in lanes below each other, and covers nothing
_LEAST, _GAP = 3.6, 1.8  # lanes of a row for its letters, and between what is drawn of two rows
_CLEARANCE = 0.5  # lanes that a diamond is larger than what stands below it
_HEADING, _LINE = 3.2, 2.6  # lanes of a heading, and of each further line of it
_TITLES = 5.2  # lanes that the titles of the columns stand above the first row
_DOT = 3.8  # points
_MANY, _PAGE = 12, 150.0  # rows, and lanes of all rows on a page
_MOST_LANES = 12
"""Lanes of one group's animals in a row; with more animals than these hold, points overlap."""


class Form(NamedTuple):
    """Widths of a forest plot and its axis (a little less than its panel, cm), and the place of the words of a row.

    `above` is how many lanes they stand above the interval; at 0 they stand beside it.
    """

    width: float
    axis: float
    above: float = 0.0


WIDE, NARROW = Form(WIDEST, 4.7), Form(11, 9.8, above=2.6)
"""For a sheet of paper or a screen, and for a phone."""


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


class ForestRow(NamedTuple):
    """One row of a forest plot."""

    heading: str
    """What the row is about, in lines that fit; written above the first row of several."""
    label: str
    """Name of the quantity."""
    effect: str
    aside: str
    """Written at the right: the effect in numbers, and what is said of it."""
    point: Point
    """Drawn large."""
    further_points: Sequence[Point] = ()
    """The same by other sources, drawn small below it."""
    dots: Sequence[Dot] = ()
    """Drawn below these, each group in lanes of its own."""


def forest_figure(
    rows: Sequence[ForestRow],
    groups: Mapping[str, GroupLook],
    sources: Mapping[str, SourceLook],
    axis: str,
    columns: tuple[str, str],
    form: Form = WIDE,
    make: Callable[[float, float], "Figure"] = new_figure,
) -> "Figure":
    """Draw rows on one logarithmic axis called `axis`; `columns` name the numbers at the right."""
    limits = _limits(rows)
    max_lanes = _most_lanes(rows)
    lanes = [_lanes(row, limits, form.axis, max_lanes) for row in rows]
    places = _places(rows, lanes, form.above)
    bottom = places[-1] - max(_LEAST, lanes[-1].height + _CLEARANCE) if rows else 0.0
    figure = make(form.width, 2.7 + _LANE * (_TITLES - _HEADING + form.above - bottom))
    middle = _side_texts(figure, places, rows, columns) if form is WIDE else _above(figure, places, rows, columns)
    for y, row, row_lanes in zip(places, rows, lanes, strict=True):
        _draw(middle, y, row, row_lanes, groups, sources, limits)
        top, end = (y + 1, y - row_lanes.height - _CLEARANCE) if form.above else (4.5, bottom - 0.5)
        middle.plot([1, 1], [top, end], color=FAINT, lw=0.9, zorder=0)
    middle.set_ylim(bottom - 0.5, _TITLES + 1.3 + form.above)
    _legend(figure, rows, groups, sources)
    _scale(middle, limits)
    label_axes(middle, axis, "").tick_params(axis="y", length=0, labelleft=False)
    middle.spines["left"].set_visible(False)
    return figure


def _side_texts(
    figure: "Figure", places: Sequence[float], rows: Sequence[ForestRow], columns: tuple[str, str]
) -> "Axes":
    """Write the words of the rows left and right of a panel, and return the panel."""
    widths = [5.1, 6.1, 5.0] if columns[1] else [5.1, 5.1, 6.0]  # values with their units are long
    left_panel, middle, right_panel = figure.subplots(1, 3, sharey=True, width_ratios=widths)
    for ax in (left_panel, right_panel):
        ax.set_axis_off()
    for y, row in zip(places, rows, strict=True):
        _write(left_panel, 1.0, y, row.label, ha="right")
        _write(right_panel, 0.0, y, row.effect)
        _write(right_panel, 1.0, y, row.aside, ha="right")
    _write_headings(left_panel, rows, places, 0.0)
    _write(right_panel, 0.0, _TITLES, columns[0], color="0.35")
    _write(right_panel, 1.0, _TITLES, columns[1], color="0.35", ha="right")
    return middle


def _above(figure: "Figure", places: Sequence[float], rows: Sequence[ForestRow], columns: tuple[str, str]) -> "Axes":
    """Write the words of the rows above their intervals, and return the panel."""
    panel = figure.subplots()
    effect = 0.86 if columns[1] else 1.0
    for y, row in zip(places, rows, strict=True):
        _write(panel, 0.0, y + NARROW.above, row.label)
        _write(panel, effect, y + NARROW.above, row.effect, ha="right")
        _write(panel, 1.0, y + NARROW.above, row.aside, ha="right")
    _write_headings(panel, rows, places, NARROW.above)
    _write(panel, effect, _TITLES + NARROW.above, columns[0], color="0.35", ha="right")
    _write(panel, 1.0, _TITLES + NARROW.above, columns[1], color="0.35", ha="right")
    return panel


class _Lanes(NamedTuple):
    """In which lane below the interval every animal stands, and how many lanes a row has."""

    dots: list[int]
    height: int


def _most_lanes(rows: Sequence[ForestRow]) -> int:
    """Return how many lanes one group's animals may have, so that a figure of many rows stands on one page."""
    if len(rows) <= _MANY:
        return _MOST_LANES
    sides = max(len({dot.group for dot in row.dots}) for row in rows) or 1
    further_points = max(len(row.further_points) for row in rows)
    return max(1, min(_MOST_LANES, int((_PAGE / len(rows) - further_points - _CLEARANCE - _GAP) / sides)))


def _lanes(row: ForestRow, limits: tuple[float, float], axis: float, max_lanes: int) -> _Lanes:
    """Return lanes in which no point covers another: first the other sources', then those of each group."""
    length = axis / 2.54 * 72 / float(np.log(limits[1] / limits[0]))  # points of a factor of e
    lanes, first = [0] * len(row.dots), 1 + len(row.further_points)
    for group in dict.fromkeys(dot.group for dot in row.dots):
        group_dots = sorted((dot.value, place) for place, dot in enumerate(row.dots) if dot.group == group)
        ends: list[float] = []  # where each lane's last point ends
        for value, place in group_dots:
            x = length * float(np.log(value))
            free = next((lane for lane, end in enumerate(ends) if x >= end), len(ends))
            if free == len(ends) < max_lanes:
                ends.append(x)
            lane = min(free, max_lanes - 1)
            ends[lane], lanes[place] = x + _DOT, first + lane
        first += len(ends)
    return _Lanes(lanes, first)


def _write(ax: "Axes", x: float, y: float, text: str, **text_style: Any) -> None:
    """Write at a share of a panel's width, which is given, whatever the text."""
    ax.text(x, y, text, va="center", fontsize=8.5, transform=ax.get_yaxis_transform(), **text_style).set_in_layout(
        False
    )


def _places(rows: Sequence[ForestRow], lanes: Sequence[_Lanes], above: float) -> list[float]:
    """Return the height of every row's interval, in lanes, with room above the first of each heading."""
    places: list[float] = []
    y, heading = 0.0, ""
    for row, row_lanes in zip(rows, lanes, strict=True):
        lines = _LINE * row.heading.count("\n")
        y -= 0.0 if row.heading == heading else lines if not places else _HEADING + lines
        heading = row.heading
        places.append(y)
        y -= max(_LEAST, row_lanes.height + _CLEARANCE + _GAP) + above
    return places


def _write_headings(ax: "Axes", rows: Sequence[ForestRow], places: Sequence[float], above: float) -> None:
    """Write what rows are about above the first of them."""
    first: dict[str, float] = {}
    for y, row in zip(places, rows, strict=True):
        first.setdefault(row.heading, y + _HEADING + above)
    for heading, y in first.items():
        for place, line in enumerate(reversed(heading.split("\n"))):
            _write(ax, 0.0, y + _LINE * place, line, fontweight="bold")


def _draw(
    ax: "Axes",
    y: float,
    row: ForestRow,
    lanes: _Lanes,
    groups: Mapping[str, GroupLook],
    sources: Mapping[str, SourceLook],
    limits: tuple[float, float],
) -> None:
    for dot, lane in zip(row.dots, lanes.dots, strict=True):
        group_look = groups[dot.group]
        (drawn,) = ax.plot(
            [dot.value], [y - _CLEARANCE - lane], group_look.marker, color=group_look.color, ms=_DOT, mec="none"
        )
        mark(drawn, dot.tip, dot.animal, dot.group)
    _point(ax, y, row.point, _Pen(DATA, "D", 6, 1.6), limits)
    for place, point in enumerate(row.further_points, start=1):
        marker, layer = sources[point.source].marker, _called(point.source)
        _point(ax, y - _CLEARANCE - place, point, _Pen("0.45", marker, 3.5, 0.9), limits, layer)


class _Pen(NamedTuple):
    """Colour and marker of a point, its size and the width of its interval in typographic points."""

    color: str
    marker: str
    size: float
    width: float


def _point(ax: "Axes", y: float, point: Point, pen: _Pen, limits: tuple[float, float], layer: str = "") -> None:
    """Draw a point with its interval; an arrow stands where the interval goes on beyond the axis."""
    color, marker, size, width = pen
    (line,) = ax.plot([point.low, point.high], [y, y], color=color, lw=width, solid_capstyle="butt", zorder=3)
    mark(line, layer=layer)
    face = color if marker == "D" else "none"
    (drawn,) = ax.plot([point.value], [y], marker, color=color, mfc=face, ms=size, zorder=4)
    mark(drawn, point.tip, layer=layer)
    for end, arrow, beyond in zip(limits, "<>", (point.low < limits[0], point.high > limits[1]), strict=True):
        if beyond:
            (tip,) = ax.plot([end], [y], arrow, color=color, ms=size, mec="none", clip_on=False, zorder=4)
            mark(tip, layer=layer)


def _called(source: str) -> str:
    return source if source == "data" else f"{source} wall"


def _limits(rows: Sequence[ForestRow]) -> tuple[float, float]:
    """Return an axis with every interval and every animal, unless one is so wide that the others could not be read."""
    points = [point for row in rows for point in (row.point, *row.further_points)]
    ends = np.array(
        [end for interval in points for end in (interval.low, interval.high)]
        + [d.value for row in rows for d in row.dots]
    )
    ends = ends[(ends > 0) & np.isfinite(ends)]
    return max(0.02, min(1.0, ends.min()) / 1.1), min(50.0, max(1.0, ends.max()) * 1.1)


def _scale(ax: "Axes", limits: tuple[float, float]) -> None:
    low, high = limits
    ax.set_xscale("log")
    ax.set_xlim(low, high)
    ticks = [tick for tick in ratio_ticks(low, high) if low <= tick <= high]
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.minorticks_off()


def _legend(
    figure: "Figure", rows: Sequence[ForestRow], groups: Mapping[str, GroupLook], sources: Mapping[str, SourceLook]
) -> None:
    from matplotlib.lines import Line2D

    entries = []
    for group in dict.fromkeys(dot.group for row in rows for dot in row.dots):
        group_look = groups[group]
        entries.append(
            Line2D([], [], color=group_look.color, marker=group_look.marker, ls="", ms=_DOT, label=short(group))
        )
    for source in dict.fromkeys(point.source for row in rows for point in row.further_points):
        marker = sources[source].marker
        entries.append(Line2D([], [], color="0.45", marker=marker, mfc="none", ms=3.5, lw=0.9, label=_called(source)))
    if entries:
        columns = columns_that_fit([str(entry.get_label()) for entry in entries], 2.54 * figure.get_figwidth())
        figure.legend(handles=entries, loc="outside upper center", ncols=columns)
