"""Any wall law as the linear one (eq. 3), the tube law of openBF, with the same wall at mean pressure."""

from typing import NamedTuple

import numpy as np

from vasowave.errors import InputError
from vasowave.exchange.solved import Solved
from vasowave.model import walls


class LinearTube(NamedTuple):
    """The law p = β (√(A/A0) - 1) of each vessel, and where it leaves the model's own.

    Attributes
    ----------
    beta : float array, shape (vessel,)
        mmHg.
    area0 : float array, shape (vessel,)
        cm².
    misfit : float array, shape (vessel,)
        Largest difference from the pressure of the model's law at the areas of the cycle, mmHg.
    """

    beta: np.ndarray
    area0: np.ndarray
    misfit: np.ndarray


def linear_tube(solved: Solved) -> LinearTube:
    """Return the linear law that has the area and the slope dp/dA of the model's law at each vessel's mean pressure.

    With D = dp/dA there, β = 2 A D - p and √(A/A0) = 2 A D/β; a linear wall comes back as it is.

    Raises
    ------
    InputError
        A wall so soft at its mean pressure that no linear law has this slope; the vessel is named.
    """
    model, pressure, area = solved.model, solved.mean_pressure, solved.mean_area
    slope = 1.0 / np.asarray(walls.area_compliance(model.wall, pressure, model.area0))
    beta = 2.0 * area * slope - pressure
    soft = np.flatnonzero(~(beta > 0))
    if len(soft):
        raise InputError(
            f"vessel '{solved.network.name[soft[0]]}': no linear wall is as soft at {pressure[soft[0]]:.3g} mmHg as "
            "this one, and openBF knows no other; fit the linear law and export that"
        )
    area0 = area * (beta / (2.0 * area * slope)) ** 2
    misfit = [_misfit(solved, row, beta[row], area0[row]) for row in range(len(beta))]
    return LinearTube(beta, area0, np.array(misfit))


def _misfit(solved: Solved, row: int, beta: float, area0: float) -> float:
    along = solved.along(row)
    return float(np.abs(beta * (np.sqrt(along.area / area0) - 1.0) - along.pressure).max())
