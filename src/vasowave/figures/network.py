"""The network as a directed graph, with the share of the flow that each vessel carries (the paper's "Network", c)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.figures.marks import mark
from vasowave.figures.style import CTL, DATA, short
from vasowave.network.network import Network

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST_LABELS = 60  # more would cover each other
_SMALL = 7.0  # points: below, there is no room for shares


def plot_network(
    ax: "Axes", network: Network, color: str | Sequence[str] = CTL, tips: Sequence[str] = (), size: float = 7.5
) -> "Axes":
    """Draw the tree from the root at the left; width follows the radius, labels give name and share of flow.

    As in the paper's graph, lengths are not to scale.

    Parameters
    ----------
    ax : matplotlib Axes
    network : Network
    color : str or sequence of str
        Of all vessels, or of each.
    tips : sequence of str, optional
        Words for each vessel, shown by a page.
    size : float
        Of the letters, points; small ones give the names alone.
    """
    colors = [color] * len(network) if isinstance(color, str) else color
    x, y = layout(network)
    widths = 0.8 + 5.0 * network.radius / network.radius[network.root]
    for row in range(len(network)):
        drawn = ax.annotate("", (x[row] + 1.0, y[row]), (x[row], y[row]), arrowprops=_arrow(widths[row], colors[row]))
        if tips and drawn.arrow_patch is not None:
            mark(drawn.arrow_patch, tips[row])
        below = [y[daughter] for daughter in network.daughters[row]]
        if below:
            ax.plot([x[row] + 1.0] * 2, [min(below), max(below)], color=colors[row], linewidth=1.2)
        if len(network) <= _MOST_LABELS:
            share = f"  ({100 * network.flow_fraction[row]:.0f} %)" if size > _SMALL else ""
            text = f"{short(network.name[row], 12)}{share}"
            above = (0.0, 2.0 + widths[row] / 2)
            ax.annotate(text, (x[row] + 0.45, y[row]), xytext=above, textcoords="offset points", ha="center",
                        va="bottom", fontsize=size, color=DATA)  # fmt: skip
    ax.set_xlim(-0.05, x.max() + 1.05)
    ax.set_ylim(y.min() - 0.4, y.max() + 0.8)
    ax.set_axis_off()
    return ax


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
    terminals, ahead = [], [network.root]
    while ahead:
        row = ahead.pop()
        ahead.extend(reversed(network.daughters[row]))
        if not network.daughters[row]:
            terminals.append(row)
    return terminals
