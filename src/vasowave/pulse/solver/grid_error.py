"""What the cells leave of error in the waves that they carried, seen in the waves themselves."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from vasowave.pulse.model import walls
from vasowave.pulse.model.model import Model
from vasowave.pulse.network.network import from_root
from vasowave.pulse.solver.grid import Grid
from vasowave.pulse.solver.middles import Middles

_FRONT = 2.0  # cells that a wave passes between two times at which it is judged: cells carry no front within fewer
_FEWEST = 64  # such times a cycle
_AT_ONCE = 256  # vessels that are judged together: the waves of more leave the processor's cache
_ENDLESS = 1e-9  # logarithm of what an echo loses, below which it would never end


class Judged(NamedTuple):
    """How steep the waves of every vessel are, and how wrong; shapes (vessel,)."""

    steepness: np.ndarray  # largest share of a vessel's pulse pressure within one cell
    steepest: np.ndarray  # its time, s
    error: np.ndarray  # of pressure, mmHg
    worst: np.ndarray  # its time, s
    dispersion: np.ndarray  # of the error, what the vessel's own cells leave by its end


def judge(grid: Grid, period: float, steps: int, area: np.ndarray, middles: Middles) -> Judged:
    """Return how steep and how wrong waves of area (cm², shape (time, vessel, station)) are on a grid."""
    values, network = np.zeros((len(Judged._fields), len(grid.counts))), grid.model.network
    mean = _as_in_middle(grid, area.mean(axis=0)).mean(axis=-1)
    for rows, waves in _waves_by_cells(grid, period, area, mean):
        values[:, rows] = waves.judged(period, steps)
    judged = Judged(*values)
    gathered = echoes(grid.model, period, mean) * from_root(network, judged.dispersion)
    judged = judged._replace(error=judged.error - judged.dispersion + gathered)
    return _with_middles(judged, grid, period, middles)


def _with_middles(judged: Judged, grid: Grid, period: float, middles: Middles) -> Judged:
    """Return what was judged, with what cells miss in the middle of vessels where much pressure is lost."""
    rows = middles.rows
    if not len(rows):
        return judged
    missed = middles.error / grid.counts[rows] ** 2
    when, largest = missed.argmax(axis=0), missed.max(axis=0)
    error, worst = judged.error.copy(), judged.worst.copy()
    worst[rows] = np.where(largest > error[rows], when * period / len(missed), worst[rows])
    error[rows] = np.maximum(error[rows], largest)
    return judged._replace(error=error, worst=worst)


def echoes(model: Model, period: float, area: np.ndarray) -> float:
    """Return how many times the error of one passage the echoes have that run to and fro between inlet and beds.

    At the inlet, where the flow is given, a wave returns whole, at a bed as (R - Z)/(R + Z), where R is what a sudden
    change of flow meets, and on its way drag takes exp(-k L/(2c)) of it. If g is left of it, there and back, that is
    g^(n/2) after n passages with n times the error of one, and n g^(n/2) is largest at n = 2/ln(1/g). Vessels have
    their mean `area` (cm², shape (vessel,)). Beds that do not say what a sudden change meets count as without echo.
    """
    network, blood = model.network, model.blood
    speed = walls.wave_speed(model.wall, walls.pressure(model.wall, area, model.area0), blood.inertia)
    k0, k1 = blood.friction.coefficients(blood.viscosity, period)
    lost = from_root(network, (k0 + k1 * np.sqrt(area)) / area * network.length / speed)
    ends = network.terminals
    bed, vessel = model.outlets.fast_resistance(), (blood.inertia * speed / area)[ends]
    reflected = np.abs(bed - vessel) / (bed + vessel) * np.exp(-lost[ends])
    g = float(network.flow_fraction[ends] @ reflected)
    return max(1.0, 2.0 / (math.e * max(-math.log(g), _ENDLESS))) if g > 0 else 1.0


def _waves_by_cells(
    grid: Grid, period: float, area: np.ndarray, mean_area: np.ndarray
) -> Iterator[tuple[np.ndarray, "_Waves"]]:
    """Yield vessels whose cells a wave passes in like times, and their waves at times so far apart.

    Further apart, a front would pass between two unseen; nearer together, what comes from finer cells would look
    steeper than these cells can carry.
    """
    model = grid.model
    mean = walls.pressure(model.wall, mean_area, model.area0)
    through_cell = grid.spacing[grid.vessels.first] / walls.wave_speed(model.wall, mean, model.blood.inertia)
    strides = np.round(_FRONT * through_cell * len(area) / period)
    strides = np.clip(strides, 1, max(1, len(area) // _FEWEST)).astype(int)
    for stride in np.unique(strides):
        alike = np.flatnonzero(strides == stride)
        for first in range(0, len(alike), _AT_ONCE):
            rows = alike[first : first + _AT_ONCE]
            yield rows, _Waves(grid, rows, area[::stride, rows], stride * period / len(area))


def _as_in_middle(grid: Grid, area: np.ndarray) -> np.ndarray:
    """Return areas, shape (..., vessel, station), as if vessels had everywhere the radius of their middle."""
    return np.asarray(area * (grid.model.area0 / np.atleast_2d(grid.at_stations[1])).T)


class _Waves:
    """Waves of some vessels, `interval` s apart, shape (time, vessel, station)."""

    def __init__(self, grid: Grid, rows: np.ndarray, area: np.ndarray, interval: float) -> None:
        model = grid.model
        everywhere, area0 = grid.at_stations
        wall: Any = type(model.wall)(*(np.atleast_2d(value).T[rows] for value in everywhere))
        self.blood, self.area, self.interval = model.blood, area, interval
        self.pressure = np.asarray(walls.pressure(wall, area, np.atleast_2d(area0).T[rows]))
        self.speed = np.asarray(walls.wave_speed(wall, self.pressure, self.blood.inertia))
        self.spacing = grid.spacing[grid.vessels.first[rows]][:, np.newaxis]
        self.length = model.network.length[rows][:, np.newaxis]

    def judged(self, period: float, steps: int) -> tuple[np.ndarray, ...]:
        """Return the fields of `Judged`, without what the vessels before these left."""
        dispersion = self.dispersion(period / steps)
        error = dispersion + self.bent_by_drag(period)
        return *self.peaks(self.steepness()), *self.peaks(error), dispersion.max(axis=(0, 2))

    def peaks(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the largest value in every vessel, and its time, s."""
        anywhere = values.max(axis=2)
        return anywhere.max(axis=0), anywhere.argmax(axis=0) * self.interval

    def steepness(self) -> np.ndarray:
        """Share of a vessel's pulse pressure that lies within one cell: |∂p/∂t| dx/c over the range of p."""
        rise = np.abs(np.diff(self.pressure, axis=0)) / self.interval
        pulse = np.maximum(np.ptp(self.pressure, axis=(0, 2)), 1e-12)[:, np.newaxis]
        return rise * self.spacing / self.speed[:-1] / pulse

    def dispersion(self, dt: float) -> np.ndarray:
        """Error of pressure, mmHg, from the modified equation of the scheme: p_t + c p_x = -c dx² (1 - ν²)/6 p_xxx.

        A wave that has passed a vessel of length L is wrong by dx² L (1 - ν²)/(6 c³) ∂³p/∂t³.
        """
        c = self.speed.mean(axis=(0, 2))[:, np.newaxis]
        third = np.zeros_like(self.pressure)  # differences: a run from rest is no Fourier series
        third[1:-2] = np.diff(self.pressure, 3, axis=0) / self.interval**3
        courant = np.minimum(c * dt / self.spacing, 1.0)
        return np.abs(third) * (self.spacing**2 * self.length * (1 - courant**2) / (6 * c**3))

    def bent_by_drag(self, period: float) -> np.ndarray:
        """Error of pressure, mmHg, of a straight line across a cell, dx²/8 ∂²p/∂x²; what waves have is dispersion.

        Mass and momentum make p_tt + k p_t = c² p_xx, k being the drag, 1/s. Where k exceeds the frequencies, pressure
        diffuses, and falls along a thin vessel within a far shorter length than a wave of that frequency has.
        """
        k0, k1 = self.blood.friction.coefficients(self.blood.viscosity, period)
        drag = (k0 + k1 * np.sqrt(self.area)) / self.area
        rate = np.zeros_like(self.pressure)
        rate[1:-1] = (self.pressure[2:] - self.pressure[:-2]) / (2 * self.interval)
        return self.spacing**2 / 8 * drag * np.abs(rate) / self.speed**2
