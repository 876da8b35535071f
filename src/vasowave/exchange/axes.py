"""The axes of vessels in space: measured, or drawn as a flat tree of their true lengths."""

from pathlib import Path

import numpy as np

from vasowave.errors import InputError
from vasowave.figures.network import layout
from vasowave.io.columns import read_columns
from vasowave.network.network import Network

_BESIDE = 1.0  # distance between inlets, in lengths of their vessels
_LEAST_BOW, _BOW_POINTS = 0.15, 13  # height over its chord, so that parallel vessels lie apart
_APART = np.radians(75.0)  # between the outermost daughters of a vessel


def drawn_axes(network: Network) -> list[np.ndarray]:
    """Return a straight axis for each vessel, shape (2, 3), x, y, z in cm: true lengths, ordered as in the figure.

    Daughters leave their parent as arteries do: a wide one goes on nearly straight, a thin one turns away. A vessel
    that closes a loop is a bow to where it ends; it is drawn longer than it is where that is too far away.
    """
    angle = _angles(network)
    direction = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(len(network))])
    axes: list[np.ndarray] = [np.empty((0, 3))] * len(network)
    places: dict[int, np.ndarray] = {}
    for number, row in enumerate(network.inlets):
        places[int(network.start[row])] = np.array([0.0, -_BESIDE * number * network.length[row], 0.0])
    for rows in network.generations:
        for row in rows:
            start, node = places[int(network.start[row])], int(network.end[row])
            if node in places:
                axes[row] = _bow(start, places[node], float(network.length[row]))
                continue
            places[node] = start + network.length[row] * direction[row]
            axes[row] = np.stack([start, places[node]])
    return axes


def _bow(start: np.ndarray, end: np.ndarray, length: float) -> np.ndarray:
    """Return an arc of a parabola between two points, as long as a vessel that is longer than their distance."""
    chord = end - start
    distance = max(float(np.linalg.norm(chord)), 1e-9 * length)
    height = max(np.sqrt(3.0 / 8.0 * max(length / distance - 1.0, 0.0)), _LEAST_BOW) * distance
    share = np.linspace(0.0, 1.0, _BOW_POINTS)[:, np.newaxis]
    side = np.array([-chord[1], chord[0], 0.0]) / distance
    return np.asarray(start + share * chord - 4.0 * height * share * (1.0 - share) * side)


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
