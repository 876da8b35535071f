"""The network of an animal as it is stored, and back."""

import numpy as np
import xarray as xr

from vasowave.animal.labelled import labelled
from vasowave.network.network import MEASURED, Network

_MEASURED = {
    "radius_sd": ("cm", "standard deviation of the radius, NaN where not known"),
    "taper": ("1", "fall of the radius along the vessel, NaN where not measured"),
    "taper_sd": ("1", "standard deviation of the taper"),
}


def network_dataset(network: Network) -> xr.Dataset:
    """Return topology and morphometry by vessel; the root's parent is empty; the nodes are those of graphs alone."""
    parents = [network.name[row] if row >= 0 else "" for row in network.parent]
    known = {name: values for name in MEASURED if (values := getattr(network, name)) is not None}
    ends = {} if network.nodes is None else {"start": network.start, "end": network.end}
    return xr.Dataset(
        {
            "parent": ("vessel", np.array(parents, dtype=object), {"long_name": "name of the parent vessel"}),
            **{
                f"{end}_node": xr.Variable("vessel", node, {"long_name": f"number of the node at its {end}"})
                for end, node in ends.items()
            },
            "length": labelled("vessel", network.length, "cm", "length"),
            "radius": labelled("vessel", network.radius, "cm", "radius at the pressure of the image"),
            "image_pressure": labelled((), network.pressure, "mmHg", "pressure of the image, 0 where not known"),
            "flow_fraction": labelled("vessel", network.flow_fraction, "1", "share of the root's mean flow (eq. 11)"),
            **{name: labelled("vessel", values, *_MEASURED[name]) for name, values in known.items()},
        },
        coords={"vessel": np.array(network.name, dtype=object)},
    )  # fmt: skip


def network_of(data: xr.Dataset) -> Network:
    """Return the network that `network_dataset` made a dataset of, with all that is known of its vessels."""
    names = tuple(map(str, data["vessel"].values))
    rows = {name: row for row, name in enumerate(names)} | {"": -1}
    parent = np.array([rows[str(name)] for name in data["parent"].values])
    known = {name: data[name].values for name in MEASURED if name in data}
    if "start_node" in data:
        known["nodes"] = np.column_stack([data["start_node"].values, data["end_node"].values])
    pressure = float(data["image_pressure"]) if "image_pressure" in data else 0.0
    return Network(names, parent, data["length"].values, data["radius"].values, None, pressure, **known)
