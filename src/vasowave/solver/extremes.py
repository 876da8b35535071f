"""What the waves of a run reach at most, and where and when: by this a reader sees where it may be believed."""

from typing import NamedTuple

import numpy as np

from vasowave import walls
from vasowave.solver.grid import Grid


class Extreme(NamedTuple):
    """The most extreme value of one quantity, the vessel that has it and the time, s."""

    value: float
    vessel: str
    time: float


class Extremes(NamedTuple):
    """The most extreme values in all vessels at the output times.

    Attributes
    ----------
    steepness : Extreme
        Largest share of a vessel's pulse pressure that lies within one cell, 1: |∂p/∂t| dx/c over the range of p.
    lowest_pressure : Extreme
        Transmural, mmHg.
    area_strain : Extreme
        Largest area over that of the network, minus 1.
    grid_error : Extreme
        Error of the pressure, mmHg: what the cells' dispersion leaves by the end of a vessel, summed from the root, and
        what a straight line across a cell misses of the pressure where drag bends it.
    """

    steepness: Extreme
    lowest_pressure: Extreme
    area_strain: Extreme
    grid_error: Extreme


def find_extremes(grid: Grid, period: float, steps: int, p: np.ndarray, recorded: np.ndarray) -> Extremes:
    """Return the extremes of the waves of pressure (mmHg, shape (sample, station, vessel)) on a grid.

    The grid's error is that of the `recorded` waves, which may have more samples.
    """
    model, network = grid.model, grid.model.network
    A = np.asarray(walls.area(model.wall, p, model.area0))
    c = np.asarray(walls.wave_speed(model.wall, p, model.blood.inertia))
    dx = grid.spacing[grid.vessels.first]
    rise = np.abs(np.diff(p, axis=0)) * (len(p) / period)
    pulse = np.maximum(np.ptp(p, axis=(0, 1)), 1e-12)

    def largest(values: np.ndarray, count: int, sign: float = 1.0) -> Extreme:
        sample, station, vessel = np.unravel_index(np.argmax(sign * values), values.shape)
        time = float(sample * period / count)
        return Extreme(float(values[sample, station, vessel]), network.name[vessel], time)

    return Extremes(
        largest(rise * dx / c[:-1] / pulse, len(p)),
        largest(p, len(p), -1.0),
        largest(A / network.area - 1.0, len(p)),
        largest(_grid_error(grid, period, steps, recorded), len(recorded)),
    )


def _grid_error(grid: Grid, period: float, steps: int, p: np.ndarray) -> np.ndarray:
    """Return the error of pressure, mmHg, that the cells leave, shape of `p`."""
    model = grid.model
    A = np.asarray(walls.area(model.wall, p, model.area0))
    c = np.asarray(walls.wave_speed(model.wall, p, model.blood.inertia))
    return _dispersion(p, c.mean(axis=(0, 1)), grid, period, steps) + _bent_by_drag(p, A, c, grid, period)


def _dispersion(p: np.ndarray, c: np.ndarray, grid: Grid, period: float, steps: int) -> np.ndarray:
    """Error of pressure, mmHg, from the modified equation of the scheme: p_t + c p_x = -c dx² (1 - ν²)/6 p_xxx.

    A wave that has passed a vessel of length L is wrong by dx² L (1 - ν²)/(6 c³) ∂³p/∂t³; what the vessels before it
    left is added.
    """
    network, dx = grid.model.network, grid.spacing[grid.vessels.first]
    third = np.zeros_like(p)  # differences, not a Fourier series: a run from rest does not repeat itself
    third[1:-2] = np.diff(p, 3, axis=0) * (len(p) / period) ** 3
    courant = np.minimum(c * period / steps / dx, 1.0)
    error = np.abs(third) * (dx**2 * network.length * (1 - courant**2) / (6 * c**3))
    inherited = error.max(axis=(0, 1))
    for rows in network.generations[1:]:
        inherited[rows] += inherited[network.parent[rows]]
    before = np.where(network.parent >= 0, inherited[network.parent], 0.0)
    return error + before


def _bent_by_drag(p: np.ndarray, A: np.ndarray, c: np.ndarray, grid: Grid, period: float) -> np.ndarray:
    """Error of pressure, mmHg, of a straight line across a cell, dx²/8 ∂²p/∂x²; what waves have of it is dispersion.

    Mass and momentum make p_tt + k p_t = c² p_xx, k being the drag, 1/s. Where k exceeds the frequencies, pressure
    diffuses, and falls along a thin vessel within a far shorter length than a wave of that frequency has.
    """
    k0, k1 = grid.model.blood.friction.coefficients(grid.model.blood.viscosity, period)
    rate = np.zeros_like(p)
    rate[1:-1] = (p[2:] - p[:-2]) * (0.5 * len(p) / period)
    drag = (k0 + k1 * np.sqrt(A)) / A
    return grid.spacing[grid.vessels.first] ** 2 / 8 * drag * np.abs(rate) / c**2
