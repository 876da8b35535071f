"""What the waves of a run reach at most, and where and when: by this a reader sees where it may be believed."""

from typing import NamedTuple

import numpy as np

from vasowave.model import walls
from vasowave.solver.grid import Grid
from vasowave.solver.grid_error import Judged


class Extreme(NamedTuple):
    """The most extreme value of one quantity, the vessel that has it and the time, s."""

    value: float
    vessel: str
    time: float


class Extremes(NamedTuple):
    """The most extreme values in all vessels.

    Attributes
    ----------
    steepness : Extreme
        Largest share of a vessel's pulse pressure that lies within one cell, 1: |∂p/∂t| dx/c over the range of p.
    lowest_pressure : Extreme
        Transmural, at the output times, mmHg.
    area_strain : Extreme
        Largest area over that of the network, minus 1, at the output times.
    grid_error : Extreme
        Error of the pressure, mmHg: what the cells' dispersion leaves by the end of a vessel, summed from the root and
        over echoes, and what a straight line across a cell misses of the pressure where drag bends it.
    """

    steepness: Extreme
    lowest_pressure: Extreme
    area_strain: Extreme
    grid_error: Extreme


def find_extremes(grid: Grid, period: float, p: np.ndarray, judged: Judged) -> Extremes:
    """Return the extremes of the waves of pressure (mmHg, shape (sample, station, vessel)) on a grid, as `judged`."""
    network = grid.model.network
    wall, area0 = grid.at_stations
    strain = np.asarray(walls.area(wall, p, area0) / walls.area(wall, network.pressure, area0)) - 1.0

    def at_samples(values: np.ndarray, sign: float = 1.0) -> Extreme:
        sample, station, vessel = np.unravel_index(np.argmax(sign * values), values.shape)
        time = float(sample * period / len(values))
        return Extreme(float(values[sample, station, vessel]), network.name[vessel], time)

    def in_vessels(values: np.ndarray, times: np.ndarray) -> Extreme:
        vessel = np.argmax(values)
        return Extreme(float(values[vessel]), network.name[vessel], float(times[vessel]))

    return Extremes(
        in_vessels(judged.steepness, judged.steepest),
        at_samples(p, -1.0),
        at_samples(strain),
        in_vessels(judged.error, judged.worst),
    )
