"""The look of every figure: colors, line styles, sizes; readable in grey.

Data are black. The animal's group sets hue and marker, the wall law sets dash, shade and hatch. The paper's two laws
have its lines, linear dashed and darker, tangent solid; any further law takes the next look of a list.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import cycle
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

NARROW, WIDEST = 8.5, 17.4
"""Widths of one and of two columns of a journal, cm: a figure has one of them."""

SMALL = 7.0
"""Smallest letters of a figure, pt."""

SCALE = "cividis"
"""Colors of a quantity; their lightness rises evenly: readable in grey and by the color-blind."""

LABELS = {"pressure": "pressure [mmHg]", "flow": "flow [ml/s]", "ecg": "ECG [mV]"}
"""Labels of the axes of signals."""

DATA = "#000000"
CTL = "#00a7c4"
HPH = "#d6259b"
FAINT = "#b3b3b3"
_LETTER, _HANDLE = 4.2, 36.0  # points of a letter of a legend, and of the line before the words with its room
_DARK = 0.45  # share of the way to black
_KNOWN = {"CTL": (CTL, "o"), "HPH": (HPH, "s")}
# Told apart by people who are blind to red or green (Okabe and Ito), and by their markers in grey.
_OTHERS = (("#e69f00", "^"), ("#0072b2", "D"), ("#009e73", "v"), ("#d55e00", "P"), ("#7f5fa8", "X"), ("#8c6d1f", "*"))
_SETTINGS: dict[Any, Any] = {
    "font.size": 8,
    "font.family": "sans-serif",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.labelsize": 8,
    "axes.xmargin": 0.02,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "lines.linewidth": 1.4,
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
    "svg.hashsalt": "vasowave",
    "savefig.dpi": 200,
    "savefig.transparent": True,
    "text.parse_math": False,  # a group may be called $x$
}


class SourceLook(NamedTuple):
    """The look of what comes from one source: measured, or a wall law."""

    dash: Any
    """Line style of matplotlib."""
    shade: float
    """How much darker than the group's color, as a share of the way to black."""
    marker: str
    hatch: str
    filled: bool
    """Whether markers are."""
    short: str
    """Name where room is scarce."""


_SOURCES = {
    "measured": SourceLook("solid", 0.0, "o", "", True, "data"),
    "linear": SourceLook((0, (5, 2)), _DARK, "o", "//////", False, "lin."),
    "tangent": SourceLook("solid", 0.0, "o", "", True, "tan."),
}
_FURTHER = (
    SourceLook("dashdot", 0.3, "s", "......", False, ""),
    SourceLook((0, (1, 1.2)), 0.65, "^", "xxxx", False, ""),
    SourceLook((0, (7, 2, 1, 2, 1, 2)), 0.15, "D", "----", False, ""),
)


_OF_A_WINDOW = ("backend", "backend_fallback", "interactive", "toolbar")


class GroupLook(NamedTuple):
    """The look of a group of animals."""

    color: str
    marker: str


def group_looks(labels: Iterable[str]) -> dict[str, GroupLook]:
    """Return color and marker of every group: CTL cyan, HPH magenta, other labels from a colour-blind safe set."""
    further_looks = cycle(_OTHERS)
    return {label: GroupLook(*(_KNOWN.get(label) or next(further_looks))) for label in dict.fromkeys(labels)}


@contextmanager
def style() -> Iterator[None]:
    """Draw and save in the style of vasowave within this block, whatever a file ``matplotlibrc`` says.

    Matplotlib reads one from the current folder, which may be a study from elsewhere, and LaTeX is a program.
    """
    import matplotlib

    defaults = {name: value for name, value in matplotlib.rcParamsDefault.items() if name not in _OF_A_WINDOW}
    with matplotlib.rc_context(defaults | _SETTINGS):
        yield


def new_figure(width: float, height: float) -> "Figure":
    """Return an empty figure of `width` × `height` cm, without any window or global state."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width / 2.54, height / 2.54), layout="constrained")


def shown_figure(width: float, height: float) -> "Figure":
    """Return an empty figure of `width` × `height` cm that notebooks and ``plt.show()`` show."""
    from matplotlib import pyplot

    return pyplot.figure(figsize=(width / 2.54, height / 2.54), layout="constrained")


def source_looks(sources: Iterable[str]) -> dict[str, SourceLook]:
    """Return how each source is drawn: the paper's wall laws as there, any further one after a list."""
    further = cycle(_FURTHER)
    return {
        name: _SOURCES.get(name) or next(further)._replace(short=name if len(name) < 6 else f"{name[:4]}.")
        for name in dict.fromkeys(sources)
    }


def wall_lines(walls: Iterable[str], color: str = CTL, shaded: bool = True) -> dict[str, dict[str, Any]]:
    """Return the line style of each wall law; `color` is the group's, or one for all laws where it is not `shaded`."""
    return {
        wall: {
            "color": darker(color, source_look.shade if shaded else 0.0),
            "linestyle": source_look.dash,
            "label": f"{wall} wall",
            "zorder": 4 if source_look.shade else 3,
        }
        for wall, source_look in source_looks(walls).items()
    }


def darker(color: str, shade: float) -> str:
    """Return a color that is so much darker, as a share of the way to black."""
    from matplotlib.colors import to_hex, to_rgb

    red, green, blue = ((1 - shade) * channel for channel in to_rgb(color))
    return to_hex((red, green, blue)) if shade else color


def wave_line(direction: str, color: str = DATA) -> dict[str, Any]:
    """Return the line style of a forward (solid) or backward (dotted, darker) wave; `color` is the group's."""
    if direction == "forward":
        return {"color": color, "linestyle": "solid", "label": "forward"}
    return {"color": darker(color, _DARK), "linestyle": (0, (1, 1)), "label": "backward"}


def label_axes(ax: "Axes", x: str, y: str) -> "Axes":
    """Write the labels, ``"pressure [mmHg]"`` and the like, and return `ax`."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    return ax


def legend_above(ax: "Axes", columns: int = 1) -> None:
    """Put the legend above the panel, where it covers no curve, in as many columns as stand beside each other there."""
    spec, labels = ax.get_subplotspec(), ax.get_legend_handles_labels()[1]
    panels = spec.get_gridspec().ncols if spec is not None else 1
    width = 2.54 * ax.figure.get_figwidth() / panels  # type: ignore[union-attr]
    count = columns_that_fit(labels, width, columns) if labels else 1
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=count, borderaxespad=0.0)


def short(name: str, max_letters: int = 22) -> str:
    """Return a name that fits into a figure: its beginning and an ellipsis where it is longer than `max_letters`."""
    return name if len(name) <= max_letters else f"{name[: max_letters - 1]}…"


def columns_that_fit(labels: Sequence[str], width: float, max_columns: int = 4) -> int:
    """Return how many labels of a legend stand side by side in a figure of `width` cm, `max_columns` at most."""
    room, sizes = width / 2.54 * 72, [_HANDLE + _LETTER * len(label) for label in labels]
    for count in range(min(max_columns, len(labels)), 1, -1):
        columns = np.array_split(sizes, count)  # a legend is filled column by column
        if sum(float(column.max()) for column in columns) <= room:
            return count
    return 1


def plain_log(axis: "Axis") -> None:
    """Label a logarithmic axis at 1, 2 and 5 of every decade, as plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(_plain))
    axis.set_minor_formatter(NullFormatter())


def closed(values: np.ndarray) -> np.ndarray:
    """Return one period with its first sample repeated at the end, so that loops close."""
    return np.append(values, values[:1])


def closed_time(time: np.ndarray, period: float) -> np.ndarray:
    """Return the times, s, that belong to `closed` values."""
    return np.append(time, time[0] + period)


def plot_cycle(ax: "Axes", wave: "xr.DataArray", period: float, **line: Any) -> None:
    """Draw one period over its times, s, closed."""
    ax.plot(closed_time(wave[wave.dims[0]].values, period), closed(wave.values), **line)


def ratio_ticks(low: float, high: float) -> list[float]:
    """Return round ratios over a range, fewer of each decade the wider it is."""
    leading = (1, 2, 3, 5) if high < 8 * low else (1, 2, 5) if high < 200 * low else (1,)
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    ticks = [digit * 10.0**decade for decade in decades for digit in leading]
    return [tick for tick in ticks if low / 1.3 <= tick <= high * 1.3]


def color_stops(count: int) -> list[list[int]]:
    """Return colors of evenly rising lightness, readable in grey and by the color-blind, as red, green and blue."""
    from matplotlib import colormaps

    return [[round(255 * channel) for channel in colormaps[SCALE](k / (count - 1))[:3]] for k in range(count)]


def _plain(value: float, place: int | None = None) -> str:
    return f"{value:g}"
