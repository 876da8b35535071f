"""What the figures read from the tree of one animal; nothing is computed here."""

import numpy as np
import xarray as xr

from vasowave.network import Network
from vasowave.walls import LinearWall, TangentWall

_LAWS: dict[str, type] = {"linear": LinearWall, "tangent": TangentWall}


def wall_laws(tree: xr.DataTree) -> list[str]:
    """Return the names of the wall laws that were calibrated, linear first."""
    return [wall for wall in _LAWS if wall in tree.children and "calibration" in tree[wall].children]


def period(tree: xr.DataTree) -> float:
    """Return T, s."""
    return float(tree["recording"].attrs["period"])


def network(tree: xr.DataTree) -> Network:
    """Return the network of the animal."""
    data = tree["network"]
    names = [str(name) for name in data["vessel"].values]
    parents = [str(name) for name in data["parent"].values]
    rows = np.array([names.index(name) if name else -1 for name in parents])
    return Network(tuple(names), rows, data["length"].values, data["radius"].values)


def root_vessel(tree: xr.DataTree) -> str:
    """Return the name of the root vessel."""
    data = tree["network"]
    return str(data["vessel"].values[np.flatnonzero(data["parent"].values == "")[0]])


def simulated(tree: xr.DataTree, wall: str, quantity: str, vessel: str, station: str = "inlet") -> xr.DataArray:
    """Return one simulated quantity over the cycle at one station, shape (time,)."""
    return tree[f"{wall}/simulation"][quantity].sel(vessel=vessel, station=station)


def wall_of(tree: xr.DataTree, wall: str, vessel: str) -> LinearWall | TangentWall:
    """Return the calibrated wall law of one vessel."""
    law = _LAWS[wall]
    calibration = tree[f"{wall}/calibration"]
    return law(*(float(calibration[name].sel(vessel=vessel)) for name in law._fields))
