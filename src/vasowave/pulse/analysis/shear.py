"""What the waves of a model do to its vessels: shear at the wall, strain, transit, and what reaches each bed."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base import units
from vasowave.base.errors import InputError, did_you_mean
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.model import Model
from vasowave.pulse.network.graph import in_loops
from vasowave.pulse.network.network import Network

LOADS = (
    "mean shear [Pa]", "peak shear [Pa]", "oscillatory shear [1]", "strain [1]", "transit time [s]",
    "mean flow [ml/s]", "pulse power [mW]",
)  # fmt: skip
"""Columns of `vessel_loads`."""

_PASCAL = 0.1
"""One dyn/cm² in Pa."""


def wall_shear(flow: np.ndarray, area: np.ndarray, period: float, blood: Blood | None = None) -> np.ndarray:
    """Return the shear stress at the wall that Womersley's profile has with a flow, Pa.

    Of each harmonic τ = i μ α² F Q/(2 π a³ (1 - F)) with F = 2 J₁(Λ)/(Λ J₀(Λ)), Λ = i^(3/2) α, α² = a² ω/ν, and
    τ = 4 μ Q/(π a³) of the mean (Womersley 1955). The radius a is that of the mean area: what the wall's motion adds is
    of second order.

    Parameters
    ----------
    flow, area : float array, shape (time, ...)
        Evenly spaced over one period, the end not repeated; ml/s and cm².
    period : float
        s.
    blood : Blood, optional

    Returns
    -------
    float array, shape (time, ...)
        Positive in the direction of a positive flow.

    Raises
    ------
    InputError
        Shapes that differ, an area or a period that is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> import vasowave as vw
    >>> steady = vw.wall_shear(np.full(64, 0.2), np.full(64, 0.007), 0.11)  # a mouse's pulmonary artery
    >>> round(float(steady[0]), 2)  # Pa
    11.82
    """
    from scipy.special import jve

    blood = blood or Blood()
    flow, area = np.asarray(flow, dtype=float), np.asarray(area, dtype=float)
    if flow.shape != area.shape or flow.ndim == 0 or not (np.all(area > 0) and period > 0):
        raise InputError(f"flow {flow.shape} and area {area.shape} must have one shape, area and period be positive")
    radius = np.sqrt(area.mean(axis=0) / np.pi)
    spectrum = np.fft.rfft(flow, axis=0)
    angular = (2 * np.pi * np.arange(1, len(spectrum)) / period).reshape(-1, *[1] * (flow.ndim - 1))
    squared = radius**2 * angular / blood.viscosity
    argument = 1j**1.5 * np.sqrt(squared)
    ratio = 2 * jve(1, argument) / (argument * jve(0, argument))  # scaled alike, so that wide vessels do not overflow
    viscosity = blood.density * blood.viscosity
    stress = np.empty_like(spectrum)
    stress[0] = 4 * viscosity * spectrum[0] / (np.pi * radius**3)
    stress[1:] = 1j * viscosity * squared * ratio * spectrum[1:] / (2 * np.pi * radius**3 * (1 - ratio))
    return _PASCAL * np.fft.irfft(stress, len(flow), axis=0)


def vessel_loads(model: Model, waves: xr.Dataset) -> pd.DataFrame:
    """Return what simulated waves do to each vessel.

    Parameters
    ----------
    model : Model
    waves : Dataset
        From `simulate` with this model.

    Returns
    -------
    DataFrame
        Indexed by vessel, at its middle: ``mean shear [Pa]``, ``peak shear [Pa]`` (largest magnitude) and ``oscillatory
        shear [1]``, half of 1 less the magnitude of the mean over the mean magnitude (Ku et al. 1985), by
        `wall_shear`; ``strain [1]``, range of the radius over its
        mean; ``transit time [s]``, volume over mean flow; ``mean flow [ml/s]``; and ``pulse power [mW]``, what
        oscillates of the power that leaves it (of terminals into their beds).

    Raises
    ------
    InputError
        Waves of other vessels.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> model = vw.Model(network, vw.LinearWall(60.0), vw.estimate_nominal(network, mouse).outlets)
    >>> loads = vw.vessel_loads(model, vw.simulate(model, mouse))
    >>> float(loads["mean flow [ml/s]"].iloc[network.terminals].sum().round(3))  # what enters
    0.18
    """
    network = model.network
    if list(waves["vessel"].values) != list(network.name):
        raise InputError("the waves are of other vessels than the model's; simulate the model first")
    middle, outlet = waves.sel(station="middle"), waves.sel(station="outlet")
    flow, area = (middle[name].transpose("time", "vessel").to_numpy() for name in ("flow", "area"))
    stress = wall_shear(flow, area, float(waves.attrs["period"]), model.blood)
    radius, output = np.sqrt(area / np.pi), flow.mean(axis=0)
    pressure, leaving = (outlet[name].transpose("time", "vessel").to_numpy() for name in ("pressure", "flow"))
    power = np.mean(pressure * leaving, axis=0) - pressure.mean(axis=0) * leaving.mean(axis=0)
    magnitude = np.abs(stress).mean(axis=0)
    columns = (
        stress.mean(axis=0), np.abs(stress).max(axis=0), 0.5 * (1 - np.abs(stress.mean(axis=0)) / magnitude),
        np.ptp(radius, axis=0) / radius.mean(axis=0), network.length * area.mean(axis=0) / np.abs(output),
        output, units.MILLIWATT * power,
    )  # fmt: skip
    return pd.DataFrame(dict(zip(LOADS, columns, strict=True)), pd.Index(network.name, name="vessel"))


def regional_loads(network: Network, loads: pd.DataFrame, regions: Sequence[str]) -> pd.DataFrame:
    """Return what reaches parts of a tree, each a vessel with all below it.

    Parameters
    ----------
    network : Network
        A tree.
    loads : DataFrame
        From `vessel_loads`.
    regions : sequence of str
        The vessel at which each part begins.

    Returns
    -------
    DataFrame
        Indexed by that vessel: ``mean flow [ml/s]`` into it and its ``share [1]``, ``beds``, ``pulse power [mW]`` into
        them, and ``mean shear [Pa]``, weighted by the area of the walls.

    Raises
    ------
    InputError
        A name that is not a vessel, or a network with loops or several inlets.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> model = vw.Model(network, vw.LinearWall(60.0), vw.estimate_nominal(network, mouse).outlets)
    >>> loads = vw.vessel_loads(model, vw.simulate(model, mouse))
    >>> vw.regional_loads(network, loads, ["2", "3"])["beds"].to_list()
    [5, 6]
    """
    if len(network.inlets) > 1 or in_loops(network.start, network.end).any():
        raise InputError("the network has loops or several inlets, so that its parts have no own flow; give a tree")
    terminals, walls = set(network.terminals.tolist()), network.radius * network.length
    entering = loads["mean flow [ml/s]"].iloc[network.root]
    rows = []
    for region in [regions] if isinstance(regions, str) else regions:
        if region not in network.name:
            raise InputError(f"no vessel '{region}'{did_you_mean(region, network.name)}")
        below = [network.name.index(region)]
        for row in below:  # grows while it is gone through
            below.extend(int(daughter) for daughter in network.daughters[row])
        beds = [row for row in below if row in terminals]
        inside = loads.iloc[below]
        rows.append({
            "mean flow [ml/s]": inside["mean flow [ml/s]"].iloc[0],
            "share [1]": inside["mean flow [ml/s]"].iloc[0] / entering,
            "beds": len(beds),
            "pulse power [mW]": loads["pulse power [mW]"].iloc[beds].sum(),
            "mean shear [Pa]": np.average(inside["mean shear [Pa]"], weights=walls[below]),
        })  # fmt: skip
    return pd.DataFrame(rows, index=pd.Index([regions] if isinstance(regions, str) else list(regions), name="region"))
