"""What the figures read from the tree of one animal; nothing is computed here."""

from typing import Any

import numpy as np
import xarray as xr

from vasowave.errors import InputError
from vasowave.network import Network
from vasowave.walls import LinearWall, TangentWall, Wall

_LAWS: dict[str, Any] = {"linear": LinearWall, "tangent": TangentWall}


def data_of(tree: xr.DataTree, path: str) -> xr.Dataset:
    """Return the data of one group of the tree, ``linear/waves`` for instance."""
    node = tree[path]
    if not isinstance(node, xr.DataTree):
        raise InputError(f"the tree of this animal holds no group '{path}'")
    return node.to_dataset()


def wall_laws(tree: xr.DataTree) -> list[str]:
    """Return the names of the wall laws that were calibrated, linear first."""
    return [wall for wall in _LAWS if wall in tree.children and "calibration" in tree.children[wall].children]


def period(tree: xr.DataTree) -> float:
    """Return T, s."""
    return float(data_of(tree, "recording").attrs["period"])


def network(tree: xr.DataTree) -> Network:
    """Return the network of the animal."""
    data = data_of(tree, "network")
    names = [str(name) for name in data["vessel"].values]
    parents = [str(name) for name in data["parent"].values]
    rows = np.array([names.index(name) if name else -1 for name in parents])
    return Network(tuple(names), rows, data["length"].values, data["radius"].values)


def root_vessel(tree: xr.DataTree) -> str:
    """Return the name of the root vessel."""
    data = data_of(tree, "network")
    return str(data["vessel"].values[np.flatnonzero(data["parent"].values == "")[0]])


def simulated(tree: xr.DataTree, wall: str, quantity: str, vessel: str, station: str = "inlet") -> xr.DataArray:
    """Return one simulated quantity over the cycle at one station, shape (time,)."""
    return data_of(tree, f"{wall}/simulation")[quantity].sel(vessel=vessel, station=station)


def wall_of(tree: xr.DataTree, wall: str, vessel: str) -> Wall:
    """Return the calibrated wall law of one vessel."""
    law = _LAWS[wall]
    calibration = data_of(tree, f"{wall}/calibration")
    return law(*(float(calibration[name].sel(vessel=vessel)) for name in law._fields))
