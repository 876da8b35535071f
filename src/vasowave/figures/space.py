"""A network in three dimensions where only lengths and radii are known: directions are drawn, not measured."""

import numpy as np

from vasowave.network.network import Network

_SPREAD = np.radians(75.0)
"""Angle between the outer daughters of a junction; in lungs of mice it is about that."""


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
