"""The published tables of Qureshi et al., as facts."""

from functools import cache
from importlib.resources import as_file, files

import pandas as pd

from vasowave.base.errors import InputError, did_you_mean
from vasowave.pulse.network.network import Network
from vasowave.pulse.network_formats import read_network

_TABLES = ("hemodynamics", "nominal", "bounds", "optimized_linear", "optimized_tangent", "model_selection")


@cache
def control_network() -> Network:
    """Return the 21-vessel network of the control mouse (Table 2 of the paper).

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.control_network()
    Network(21 vessels, 11 terminals, root '1' r0 0.047 cm, total length 4.484 cm)
    """
    return _network("network_control")


@cache
def hypertensive_network() -> Network:
    """Return the 21-vessel network of the hypertensive mouse (Table 2 of the paper)."""
    return _network("network_hypertensive")


def published_table(name: str) -> pd.DataFrame:
    """Return a published table with units in its column names.

    Parameters
    ----------
    name : {"hemodynamics", "nominal", "bounds", "optimized_linear", "optimized_tangent", "model_selection"}
        Table 1, the nominal values, the bounds, the optima of both walls, the AICc/BIC table. Numbers are as printed;
        docs/deviations.md lists the slips among them.
    """
    if name not in _TABLES:
        raise InputError(f"no published table '{name}'{did_you_mean(name, _TABLES)}; there are: {', '.join(_TABLES)}")
    with as_file(files("vasowave.pulse.examples") / "data" / f"{name}.csv") as path:
        return pd.read_csv(path)


def _network(name: str) -> Network:
    with as_file(files("vasowave.pulse.examples") / "data" / f"{name}.csv") as path:
        return read_network(path)
