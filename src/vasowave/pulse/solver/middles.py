"""The middle of a vessel, which its cells know only by the two ends of one of them.

Where much pressure is lost in a short vessel, as in a stenosis, it falls along it in no straight line: the drag grows
and the flow is accelerated as the vessel narrows. What a line misses is seen at the vessel's ends.
"""

from typing import NamedTuple

import numpy as np

from vasowave.pulse.model import walls
from vasowave.pulse.model.model import Model

_STEEP = 0.1  # share of the largest pressure that one cell may lose, whatever is known of what lies between
_ALLOWED = 0.0025  # share of the largest pressure by which a middle may be wrong
_NOTHING = 0.03  # share of the largest pressure: a smaller fall is not looked at
_LOOKS = 128  # times of the cycle, at least, at which that is looked at
_SLOWEST = 0.05  # 1 - u²/c², at least
_HALF = np.array([1.0, 4.0, 2.0, 4.0, 1.0]) / 12.0  # Simpson's weights of five places


class Middles(NamedTuple):
    """Vessels along which much pressure is lost, and what one cell as long as each would miss of its middle."""

    rows: np.ndarray  # (steep vessel,)
    fall: np.ndarray  # (steep vessel,) largest loss of pressure, as a share of the largest pressure
    error: np.ndarray  # (time, steep vessel) mmHg
    largest: float  # mmHg, pressure of any vessel


def middle_errors(model: Model, period: float, ends: tuple[np.ndarray, np.ndarray], rows: np.ndarray) -> np.ndarray:
    """Return by how much the middle of one cell as long as the vessel is wrong, mmHg, shape (time, vessel).

    Flow that changes slowly falls by dp/dx = -drag q ρ/A² /(1 - u²/c²): the middle is where half the integral of
    A²/drag (1 - u²/c²) over the pressure is reached. A cell takes the mean area of its ends instead.

    Parameters
    ----------
    model : Model
    period : float
        s.
    ends : pair of array, shape (2, time, vessel)
        Pressure (mmHg) and flow at the inlets and at the outlets of the vessels `rows`.
    """
    (inlet, q), (outlet, _) = ends
    wall, area0 = model.at(rows, np.full(len(rows), 0.5))
    k0, k1 = model.blood.friction.coefficients(model.blood.viscosity, period)
    k0 = k0 or float(k1 == 0.0)  # a drag that is the same everywhere cancels, so any number serves where there is none

    def conductance(p: np.ndarray) -> np.ndarray:
        A = np.asarray(walls.area(wall, p, area0))
        by_speed = model.blood.inertia * q**2 * walls.area_compliance(wall, p, area0) / A**3
        return np.asarray(A**2 / (k0 + k1 * np.sqrt(A)) * np.maximum(1.0 - by_speed, _SLOWEST))

    mean = 0.5 * (walls.area(wall, inlet, area0) + walls.area(wall, outlet, area0))
    taken = np.asarray(walls.pressure(wall, mean, area0))
    share = np.linspace(0.0, 1.0, len(_HALF))[:, np.newaxis, np.newaxis]
    below, above = outlet + share * (taken - outlet), taken + share[1:] * (inlet - taken)
    let = conductance(np.concatenate([below, above]))  # at once: most of the cost is that of the calls
    integrals = np.tensordot(_HALF, let[: len(_HALF)], axes=1), np.tensordot(_HALF, let[len(_HALF) - 1 :], axes=1)
    error = np.abs((inlet - taken) * integrals[1] - (taken - outlet) * integrals[0]) / (2.0 * let[len(_HALF) - 1])
    return np.where(np.isfinite(error), np.minimum(error, np.abs(inlet - outlet)), np.abs(inlet - outlet))


def cells_for_middles(middles: Middles, cells: np.ndarray) -> np.ndarray:
    """Return with how many cells each vessel would know its middle, shape (vessel,); 1 where any number does."""
    counts = np.ones(len(cells), dtype=np.int64)
    if len(middles.rows):
        error = np.max(middles.error, axis=0) / middles.largest
        needed = 2 * np.ceil(0.5 * np.sqrt(error / _ALLOWED))
        alone = (cells[middles.rows] == 1) & (middles.fall > _STEEP)
        needed = np.where(alone, np.maximum(needed, 2 * np.ceil(middles.fall / (2 * _STEEP))), needed)
        counts[middles.rows] = np.where((error > _ALLOWED) | alone, needed, 1)
    return counts


def find_middles(model: Model, period: float, recorded: np.ndarray) -> Middles:
    """Return how wrong the middles would be of vessels along which much pressure is lost.

    `recorded` are areas (cm²) and flows at the stations, shape (2, time, vessel, station); some of their times are
    taken.
    """
    sampled = recorded[:, :: max(1, recorded.shape[1] // _LOOKS)]
    vessels, pressures = np.arange(sampled.shape[2]), []
    for station, share in ((0, 0.0), (2, 1.0)):
        wall, area0 = model.at(vessels, np.full(len(vessels), share))
        pressures.append(np.asarray(walls.pressure(wall, sampled[0, :, :, station], area0)))
    largest, fall = float(np.max(np.abs(pressures))), np.max(np.abs(pressures[0] - pressures[1]), axis=0)
    rows = np.flatnonzero(fall > _NOTHING * largest)
    if not len(rows):
        return Middles(rows, np.zeros(0), np.zeros((sampled.shape[1], 0)), largest)
    inlet, outlet = (
        np.array([p[:, rows], sampled[1][:, rows, station]]) for p, station in zip(pressures, (0, 2), strict=True)
    )
    return Middles(rows, fall[rows] / largest, middle_errors(model, period, (inlet, outlet), rows), largest)
