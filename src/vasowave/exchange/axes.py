"""The axes of vessels in space: measured, or drawn as a flat tree of their true lengths."""

from pathlib import Path

import numpy as np

from vasowave.errors import InputError
from vasowave.figures.network import layout
from vasowave.io.columns import read_columns
from vasowave.network.network import Network

_APART = np.radians(75.0)  # between the outermost daughters of a vessel


def drawn_axes(network: Network) -> list[np.ndarray]:
    """Return a straight axis for each vessel, shape (2, 3), x, y, z in cm: true lengths, ordered as in the figure.

    Daughters leave their parent as arteries do: a wide one goes on nearly straight, a thin one turns away.
    """
    angle = _angles(network)
    direction = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(len(network))])
    axes: list[np.ndarray] = [np.empty((0, 3))] * len(network)
    for rows in network.generations:
        for row in rows:
            start = axes[network.parent[row]][-1] if network.parent[row] >= 0 else np.zeros(3)
            axes[row] = np.stack([start, start + network.length[row] * direction[row]])
    return axes


def _angles(network: Network) -> np.ndarray:
    """Return the direction of each vessel, rad from that of the root, shape (vessel,)."""
    place, angle = layout(network)[1], np.zeros(len(network))
    for row in np.concatenate(network.generations):
        daughters = np.array(sorted(network.daughters[row], key=place.__getitem__), dtype=int)
        fan = np.linspace(-0.5, 0.5, len(daughters)) if len(daughters) > 1 else np.zeros(len(daughters))
        if len(daughters):
            straight = np.average(fan, weights=network.area[daughters])
            angle[daughters] = angle[row] + _APART * (fan - straight)
    return angle


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
