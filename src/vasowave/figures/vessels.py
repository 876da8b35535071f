"""Pressure and flow along the network ("PQsim"): chosen vessels, every wall law."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.animal.result import AnimalResult
from vasowave.figures.style import CTL, DATA, closed, closed_time, label_axes, quantity_label, wall_lines
from vasowave.network.network import Network

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def main_vessels(network: Network, count: int = 6) -> list[str]:
    """Return the names of up to `count` vessels that show the network, from the root outwards, or all if one is left.

    The root, its two largest daughters, the terminal at the end of each one's main path, then what carries most flow.
    """
    flow = network.flow_fraction
    daughters = sorted(network.daughters[network.root], key=lambda row: -flow[row])[:2]
    ends = [_main_path(network, row)[-1] for row in daughters]
    rest = np.argsort(-flow, kind="stable").tolist()
    chosen = list(dict.fromkeys([network.root, *daughters, *ends, *rest]))
    chosen = chosen[: count if len(chosen) > count + 1 else count + 1]
    depth = {row: level for level, rows in enumerate(network.generations) for row in rows.tolist()}
    return [network.name[row] for row in sorted(chosen, key=lambda row: (depth[row], row))]


def _main_path(network: Network, row: int) -> list[int]:
    """Return the rows from `row` to a terminal, at every junction into the daughter with most flow."""
    path = [row]
    while network.daughters[path[-1]]:
        path.append(max(network.daughters[path[-1]], key=lambda daughter: network.flow_fraction[daughter]))
    return path


def plot_vessel(
    ax: "Axes",
    result: AnimalResult,
    vessel: str,
    quantity: str = "pressure",
    color: str = CTL,
    station: str = "middle",
) -> "Axes":
    """Draw one simulated quantity at one station of one vessel, one line per wall law; data where measured."""
    if vessel == result.root and quantity == "pressure":
        measured = result.recording["pressure"]
        time = closed_time(measured["time"].values, result.period)
        ax.plot(time, closed(measured.values), color=DATA, linewidth=1.0, label="measured (inlet)")
    label = quantity
    for wall, line in wall_lines(result.laws, color).items():
        values = result.laws[wall].simulated(quantity, vessel, station)
        label = quantity_label({"units": values.attrs.get("units", "")}, quantity)
        ax.plot(closed_time(values["time"].values, result.period), closed(values.values), **line)
    return label_axes(ax, "time [s]", label)
