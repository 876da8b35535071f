"""Where vessels run in space: along measured axes, or drawn as a flat tree of their true lengths."""

from pathlib import Path

import numpy as np

from vasowave.columns import read_columns
from vasowave.errors import InputError
from vasowave.figures.network import layout
from vasowave.network import Network

_WIDEST = np.radians(70.0)  # from the root's direction


def drawn_axes(network: Network) -> list[np.ndarray]:
    """Return a straight axis for each vessel, shape (2, 3), x, y, z in cm: true lengths, directions as in the figure.

    Every vessel points to the middle of the terminals behind it, which are fanned out over 140°.
    """
    place = layout(network)[1]
    half = max(float(np.ptp(place)) / 2.0, 0.5)
    angle = _WIDEST * (place - place[network.root]) / max(half, float(np.abs(place - place[network.root]).max()))
    direction = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(len(network))])
    axes: list[np.ndarray] = [np.empty((0, 3))] * len(network)
    for rows in network.generations:
        for row in rows:
            start = axes[network.parent[row]][-1] if network.parent[row] >= 0 else np.zeros(3)
            axes[row] = np.stack([start, start + network.length[row] * direction[row]])
    return axes


def read_axes(path: str | Path, network: Network) -> list[np.ndarray]:
    """Return the axes in the table of points that `vasowave extract` writes (``centerlines.csv``), x, y, z in cm.

    Raises
    ------
    InputError
        No such table, or a vessel of the network without two points in it.
    """
    table = read_columns(path)
    owner = np.array([row[table.require("vessel")] for row in table.cells])
    points = np.column_stack([table.numbers(table.require(axis), "length") for axis in "xyz"])
    axes = [points[owner == name] for name in network.name]
    short = next((name for name, axis in zip(network.name, axes) if len(axis) < 2), None)
    if short is not None:
        raise InputError(f"{path}: no axis of vessel '{short}'; are these the centerlines of this network?")
    return axes
