"""The network as a directed graph with its shares of flow (the paper's "Network", c), and in three dimensions."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.pulse.network.network import Network
from vasowave.study.figures.matplotlib_style import CTL, DATA, SMALL, short
from vasowave.study.figures.rendering import mark

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_WIDEST = 6.0  # points, of the root's line
_THINNEST = 0.5
_KEY = 1.4  # rows below the tree, for what the widths of lines mean
_SHORTEST = 4  # letters of a name that is cut
_AIR = 2.0  # points between a label and the lines above and below it, together
_PANEL = 0.77  # of a figure that its only panel has before the layout is made
_SPREAD = np.radians(75.0)
"""Angle between the outer daughters of a junction; in lungs of mice it is about that."""


def plot_network(
    ax: "Axes", network: Network, color: str | Sequence[str] = CTL, tips: Sequence[str] = (), share: bool = True,
    widest: float | None = None,
) -> "Axes":  # fmt: skip
    """Draw the network from the inlet at the left; width is the radius, to the scale drawn below, arrows are the flow.

    Lengths are not to scale, as in the paper's graph. Labels are names and shares of the flow; where there is no room
    for both, names alone, then their beginnings, and none where they would touch each other. Where a loop closes, a
    dotted line leads from the end of one vessel to that of the one with which it meets.

    Parameters
    ----------
    ax : matplotlib Axes
    network : Network
    color : str or sequence of str
        Of all vessels, or of each.
    tips : sequence of str, optional
        Words for each vessel, shown by a page.
    share : bool
        Whether labels hold the share of the flow.
    widest : float, optional
        Radius that is drawn widest, cm, which networks beside each other have in common; by default the network's own
        largest.
    """
    widest = widest or float(network.radius.max())
    colors = [color] * len(network) if isinstance(color, str) else color
    x, y = layout(network)
    scale = _WIDEST / widest
    widths = np.maximum(_THINNEST, scale * network.radius)
    labels = _labels(ax, network, (x, y), widths, share)
    for row in range(len(network)):
        tail, head = (x[row], x[row] + 1.0) if network.flow_fraction[row] >= 0 else (x[row] + 1.0, x[row])
        drawn = ax.annotate("", (head, y[row]), (tail, y[row]), arrowprops=_arrow(widths[row], colors[row]))
        if tips and drawn.arrow_patch is not None:
            mark(drawn.arrow_patch, tips[row])
        below = [y[daughter] for daughter in network.daughters[row]]
        if below:
            ax.plot([x[row] + 1.0] * 2, [min(below), max(below)], color=colors[row], linewidth=1.2)
        ax.annotate(labels[row], (x[row] + 0.45, y[row]), (0.0, 2.0 + widths[row] / 2), textcoords="offset points",
                    ha="center", va="bottom", fontsize=SMALL, color=DATA)  # fmt: skip
    _draw_joints(ax, network, (x, y))
    for row in network.inlets:
        ax.plot([x[row]], [y[row]], "o", color=DATA, ms=5, zorder=5)
        ax.annotate("inlet", (x[row], y[row]), (0.0, -2.0 - _WIDEST / 2), textcoords="offset points", ha="left",
                    va="top", fontsize=SMALL, fontstyle="italic")  # fmt: skip
    _draw_key(ax, y.min() - _KEY + 0.2, x.max() + 1.0, widest, scale)
    ax.set_xlim(-0.1, x.max() + 1.05)
    ax.set_ylim(y.min() - _KEY, y.max() + 0.8)
    ax.set_axis_off()
    return ax


def _labels(
    ax: "Axes", network: Network, places: tuple[np.ndarray, np.ndarray], widths: np.ndarray, share: bool
) -> list[str]:
    """Return what is written at each vessel in the room that it has below the next line of its generation."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    figure = ax.get_figure(root=True)
    x, y = places
    width, height = (72 * size * _PANEL for size in figure.get_size_inches()) if figure else (0.0, 0.0)
    share_of_figure = ax.get_position()
    room = width * share_of_figure.width / _PANEL / (x.max() + 1.15) - 3.0
    row = height * share_of_figure.height / _PANEL / (y.max() - y.min() + _KEY + 0.8)
    letters = FontProperties(size=SMALL)
    for rows in network.generations:
        above = rows[np.argsort(y[rows])]
        free = row * np.diff(y[above]) - (widths[above][1:] + widths[above][:-1]) / 2
        if len(free) and free.min() < SMALL + _AIR:
            return [""] * len(network)

    def fits(text: str) -> bool:
        return bool(TextPath((0, 0), text, prop=letters).get_extents().width < room)

    labels = []
    for name, flow in zip(network.name, network.flow_fraction, strict=True):
        full = [f"{short(name, 12)} ({100 * abs(flow):.0f} %)"] if share else []
        shorter = [short(name, length) for length in range(12, _SHORTEST - 1, -1)]
        labels.append(next((text for text in [*full, *shorter] if fits(text)), ""))
    return labels


def _draw_key(ax: "Axes", y: float, right: float, radius: float, scale: float) -> None:
    """Draw two lines of round radii and what their widths mean."""
    step = right / 3.4
    for place, size in enumerate((_rounded(radius), _rounded(radius / 3))):
        ax.plot([place * step, (place + 0.3) * step], [y, y], color="0.35", lw=scale * size, solid_capstyle="butt")
        ax.annotate(f"{size:g} cm", ((place + 0.3) * step, y), (3, 0), textcoords="offset points", va="center",
                    fontsize=SMALL)  # fmt: skip
    ax.annotate("radius; arrows: flow", (2 * step, y), (0, 0), textcoords="offset points", va="center", fontsize=SMALL)


def _rounded(value: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is not above `value`."""
    decade = 10.0 ** np.floor(np.log10(value))
    return float(max(digit for digit in (1, 2, 5) if digit * decade <= value * (1 + 1e-9)) * decade)


def _draw_joints(ax: "Axes", network: Network, places: tuple[np.ndarray, np.ndarray]) -> None:
    """Join the ends of vessels that end in one node: the first carries on, the others are led to it."""
    x, y = places
    for junction in network.junctions:
        first = int(network.parent[junction.beginning[0]])
        for row in (row for row in junction.ending if row != first):
            ax.annotate("", (x[first] + 1.0, y[first]), (x[row] + 1.0, y[row]), zorder=1,
                        arrowprops={"arrowstyle": "-", "linestyle": ":", "linewidth": 1.2, "color": "0.45",
                                    "shrinkA": 0, "shrinkB": 0, "connectionstyle": "arc3,rad=0.25"})  # fmt: skip


def layout(network: Network) -> tuple[np.ndarray, np.ndarray]:
    """Return the place of every vessel: x is its generation, y the middle of its daughters; each shape (vessel,)."""
    x, y = np.zeros(len(network)), np.zeros(len(network))
    for place, row in enumerate(_terminals_in_order(network)):
        y[row] = -float(place)
    for generation, rows in reversed(list(enumerate(network.generations))):
        x[rows] = generation
        for row in rows:
            if network.daughters[row]:
                y[row] = np.mean([y[daughter] for daughter in network.daughters[row]])
    return x, y


def _arrow(width: float, color: str) -> dict[str, Any]:
    return {"arrowstyle": "-|>", "linewidth": width, "color": color, "shrinkA": 0, "shrinkB": 0,
            "mutation_scale": 6 + width, "joinstyle": "miter", "capstyle": "butt"}  # fmt: skip


def _terminals_in_order(network: Network) -> list[int]:
    terminals, ahead = [], network.inlets[::-1].tolist()
    while ahead:
        row = ahead.pop()
        ahead.extend(reversed(network.daughters[row]))
        if not network.daughters[row]:
            terminals.append(row)
    return terminals


def axes_in_space(network: Network) -> np.ndarray:
    """Return start and end of every vessel, cm, shape (vessel, 2, 3).

    Daughters leave in one plane, the thinner the more to the side, and planes of successive junctions stand across each
    other. Lengths are those of the network; a vessel that closes a loop is drawn to where it ends.
    """
    axes = np.zeros((len(network), 2, 3))
    along, across = np.zeros((2, len(network), 3))
    along[network.inlets], across[network.inlets] = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)
    axes[network.inlets, 0, 0] = np.arange(len(network.inlets)) * network.length[network.root]
    places: dict[int, np.ndarray] = {}
    for rows in network.generations:
        for row in rows:
            end = axes[row, 0] + network.length[row] * along[row]
            axes[row, 1] = places.setdefault(int(network.end[row]), end)
            aside = np.cross(across[row], along[row])
            for daughter, angle in zip(network.daughters[row], _angles(network, row), strict=True):
                axes[daughter, 0] = axes[row, 1]
                along[daughter] = np.cos(angle) * along[row] + np.sin(angle) * aside
                across[daughter] = np.cross(along[daughter], across[row])
    return axes


def _angles(network: Network, row: int) -> np.ndarray:
    """Return the angle between a vessel and each of its daughters in their plane, rad: widest on its own axis."""
    area = network.radius[list(network.daughters[row])] ** 2
    if len(area) < 2:
        return np.zeros(len(area))
    even = np.linspace(-0.5, 0.5, len(area))
    return np.asarray(_SPREAD * (even - np.sum(even * area) / area.sum()))
