"""Vessels that narrow along their way, as the solver's straight tubes: each as long as a cell of the grid."""

from dataclasses import replace

import numpy as np

from vasowave.errors import InputError
from vasowave.model.model import Model
from vasowave.network.network import Network

PIECE = 0.1
"""Longest piece, cm: the solver's usual cell, so that pieces ask for no smaller steps; see docs/decisions.md."""


def tapered(model: Model, fall: np.ndarray, longest: float = PIECE) -> Model:
    """Return the model with every vessel that narrows cut into straight pieces of falling radius.

    Outlets stay at the ends they had, and each piece has its vessel's wall; the radius of the network is that of a
    vessel's middle.

    Parameters
    ----------
    model : Model
    fall : array, shape (vessel,)
        Radius at a vessel's inlet less that at its outlet, as a share of the radius in the middle; above -2, below 2.
        Where it is 0 the vessel stays one tube.
    longest : float
        Longest piece, cm.

    Raises
    ------
    InputError
        A vessel that would be closed at one end, or a model that has a shape already.

    Examples
    --------
    >>> import numpy as np
    >>> import vasowave as vw
    >>> from vasowave.model.tapering import tapered
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> model = vw.Model(network, vw.LinearWall(60.0), vw.estimate_nominal(network, mouse).outlets)
    >>> tapered(model, np.full(21, 0.2)).network
    Network(52 vessels, 11 terminals, root '1.1' r0 ... cm, total length 4.484 cm)
    """
    network = model.network
    if model.shape is not None:
        raise InputError("the vessels of this model have a shape already; cut a model that was made without one")
    if not np.all(np.abs(fall) < 2):
        raise InputError(f"vessel '{network.name[np.argmax(np.abs(fall))]}' tapers until it is closed at one end")
    count = np.where(fall == 0, 1, np.maximum(np.ceil(network.length / longest - 1e-9), 1)).astype(int)
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    vessel = np.repeat(np.arange(len(network)), count)
    number = np.arange(len(vessel)) - first[vessel]
    above = network.parent[vessel]
    parent = np.where(number > 0, np.arange(len(vessel)) - 1, np.where(above >= 0, (first + count - 1)[above], -1))
    wide, thin = (1 + fall[vessel] * (0.5 - (number + side) / count[vessel]) for side in (0, 1))
    factor = (3 * (wide * thin) ** 3 / (wide**2 + wide * thin + thin**2)) ** 0.25  # the mean of r⁻⁴ along the piece
    names = tuple(f"{network.name[row]}.{i + 1}" for row, i in zip(vessel, number, strict=True))
    cut = Network(
        names, parent, (network.length / count)[vessel], network.radius[vessel] * factor, pressure=network.pressure
    )
    return replace(model, network=cut, wall=type(model.wall)(*(value[vessel] for value in model.wall)))
