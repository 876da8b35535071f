"""What changes along the tree: wave speed, characteristic impedance, reflection at junctions, pressure drop."""

import numpy as np
import pandas as pd

from vasowave.base.errors import InputError
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.walls import area, wave_speed
from vasowave.pulse.network.network import Network, from_root


def wave_speeds(model: Model, pressure: float | np.ndarray) -> pd.DataFrame:
    """Wave speed and what follows from it in every vessel at a transmural pressure (eqs. 31, 32, 8).

    Parameters
    ----------
    model : Model
    pressure : float or array, shape (vessel,)
        mmHg, the mean pressure for instance.

    Returns
    -------
    DataFrame
        Indexed by vessel: ``generation`` (root 0), ``distance [cm]`` from the root's inlet to the vessel's end,
        ``radius [cm]`` and ``wave speed [cm/s]`` at that pressure, ``Z_c [mmHg s/ml]`` = ρc/A, ``arrival [s]``, the
        time a wave from the root's inlet needs to the vessel's end, and ``reflection``, the pressure reflection
        coefficient of its distal junction, (Y - ΣY_daughters)/(Y + ΣY_daughters), or of its bed at high frequency,
        (R1 - Z_c)/(R1 + Z_c) of a Windkessel.

    Raises
    ------
    InputError
        A pressure that is not finite, has another shape, or at which a vessel is collapsed.
    """
    network = model.network
    if np.shape(pressure) not in ((), (len(network),)) or not np.all(np.isfinite(pressure)):
        raise InputError(f"pressure must be one finite number or {len(network)} of them")
    A = np.broadcast_to(area(model.wall, pressure, model.area0), len(network))
    with np.errstate(invalid="ignore"):  # of a collapsed vessel, which is refused
        c = np.broadcast_to(wave_speed(model.wall, pressure, model.blood.inertia), len(network))
    bad = np.flatnonzero(~((A > 0) & np.isfinite(c) & (c > 0)))
    if len(bad):
        raise InputError(f"vessel '{network.name[bad[0]]}' is collapsed at {np.min(pressure):g} mmHg; no wave travels")
    Z_c = model.blood.inertia * c / A
    generation = np.empty(len(network), dtype=int)
    for level, rows in enumerate(network.generations):
        generation[rows] = level
    return pd.DataFrame(
        {
            "generation": generation,
            "distance [cm]": from_root(network, network.length),
            "radius [cm]": np.sqrt(A / np.pi),
            "wave speed [cm/s]": c,
            "Z_c [mmHg s/ml]": Z_c,
            "arrival [s]": from_root(network, network.length / c),
            "reflection": _reflection(model, Z_c),
        },
        index=pd.Index(network.name, name="vessel"),
    )


def pressure_drop(network: Network, inlet: np.ndarray, outlets: np.ndarray) -> pd.DataFrame:
    """Drop of pressure from the root's inlet to the end of every terminal vessel, mmHg.

    Parameters
    ----------
    network : Network
    inlet : array, shape (time,)
        Pressure at the root's inlet over one period, mmHg.
    outlets : array, shape (time, terminal)
        Pressure at the distal ends of ``network.terminals``, mmHg.

    Returns
    -------
    DataFrame
        Indexed by terminal: ``distance [cm]``, ``mean drop [mmHg]``, ``systolic drop [mmHg]`` and ``diastolic drop
        [mmHg]`` (largest and smallest values compared, whenever they occur; negative where the pulse grows on its
        way), ``largest drop [mmHg]`` at one instant, and ``mean gradient [mmHg/cm]``.

    Raises
    ------
    InputError
        Shapes that do not fit, or a value that is not finite.
    """
    p, ends = np.asarray(inlet, dtype=float), np.asarray(outlets, dtype=float)
    terminals = network.terminals
    if p.ndim != 1 or len(p) == 0 or ends.shape != (len(p), len(terminals)):
        raise InputError(f"inlet has shape {p.shape}, outlets {ends.shape}; give (time,) and (time, {len(terminals)})")
    if not (np.all(np.isfinite(p)) and np.all(np.isfinite(ends))):
        raise InputError("a pressure is not finite")
    distance = from_root(network, network.length)[terminals]
    mean = p.mean() - ends.mean(0)
    return pd.DataFrame(
        {
            "distance [cm]": distance,
            "mean drop [mmHg]": mean,
            "systolic drop [mmHg]": p.max() - ends.max(0),
            "diastolic drop [mmHg]": p.min() - ends.min(0),
            "largest drop [mmHg]": (p[:, np.newaxis] - ends).max(0),
            "mean gradient [mmHg/cm]": mean / distance,
        },
        index=pd.Index([network.name[row] for row in terminals], name="terminal"),
    )


def _reflection(model: Model, Z_c: np.ndarray) -> np.ndarray:
    network, Y = model.network, 1 / Z_c
    below = np.zeros(len(network))
    for junction in network.junctions:
        for row in junction.ending:
            below[row] = sum(Y[vessel] for vessel in (*junction.beginning, *junction.ending) if vessel != row)
    coefficient = (Y - below) / (Y + below)
    R, Z = model.outlets.fast_resistance(), Z_c[network.terminals]
    coefficient[network.terminals] = (R - Z) / (R + Z)
    return coefficient
