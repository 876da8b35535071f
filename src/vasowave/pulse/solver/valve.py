"""What the kernels know of a ventricle at the inlet: its volume, and whether its valve is open.

With the valve open the inlet's node is a bed: ``p = E V - (R + E dt/2) q`` with the volume V before the half step.
With the valve closed it is an inlet without flow. The valve opens where the ventricle's pressure passes that of the
node, and closes where the flow would turn; a half step in which it does either is solved a second time.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vasowave.base.errors import NumericalError
from vasowave.pulse.model.ventricle import Ventricle
from vasowave.pulse.solver.cells import OPTIONS

_NOTHING = 1e-9  # of the volume in a period is a flow that is none


class Heart(NamedTuple):
    """A ventricle and its state."""

    filled: float  # ml above V0, when contraction begins
    resistance: float  # of the open valve, mmHg s/ml
    dt: float  # s
    volume: np.ndarray  # (1,) ml above V0, half a step before
    is_open: np.ndarray  # (1,) 1 or 0


def make_heart(driven: object, dt: float) -> Heart | None:
    """Return what a ventricle is to the kernels, None where a flow or a pressure drives the network."""
    if not isinstance(driven, Ventricle):
        return None
    return Heart(driven.filled, driven.valve_resistance, dt, np.zeros(1), np.zeros(1))


def ventricular_waves(ventricle: Ventricle, flow: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return pressure (mmHg) and volume above V0 (ml) of a ventricle from the flow out of it at every step (ml/s)."""
    volume = ventricle.filled - (np.cumsum(flow) - 0.5 * flow) * (ventricle.period / len(flow))
    return ventricle.resampled(len(flow)) * volume, volume


def require_emptied(ventricle: Ventricle, flow: np.ndarray) -> None:
    """Raise `NumericalError` where the flow at every step (ml/s) says that the valve never opens, or never closes."""
    passes = flow > _NOTHING * ventricle.filled / ventricle.period
    if passes[-1]:
        raise NumericalError(
            f"the ventricle still ejects ({flow[-1]:.3g} ml/s) when its cycle of {ventricle.period:g} s ends and "
            "contraction begins anew; let its elastance fall earlier"
        )
    if not np.any(passes):
        raise NumericalError(
            f"the ventricle's valve never opens: {float(np.max(ventricle.elastance)) * ventricle.filled:.3g} mmHg, its "
            "most, does not pass the pressure behind the beds; raise filling_pressure or elastance"
        )


@njit(**OPTIONS)
def fill(heart):
    """Make the ventricle what it is when contraction begins."""
    heart.volume[0], heart.is_open[0] = heart.filled, 0.0


@njit(**OPTIONS)
def meet_ventricle(elastance, heart, ends, nodes):
    """What the ventricle asks of its node at this half step."""
    k = ends.inlet
    nodes.source[k] = 0.0
    if heart.is_open[0] > 0.0:
        nodes.weight[k], nodes.outlet[k] = heart.resistance + 0.5 * heart.dt * elastance, 1.0
        nodes.memory[k] = elastance * heart.volume[0]
    else:
        nodes.weight[k], nodes.outlet[k], nodes.memory[k] = 1.0, 0.0, 0.0


@njit(**OPTIONS)
def valve_moves(elastance, heart, flow, pressure):
    """Whether flow (ml/s) and pressure (mmHg) at the node move the valve, which is then moved."""
    opens = 1.0 if elastance * heart.volume[0] > pressure else 0.0
    if heart.is_open[0] > 0.0:
        opens = 1.0 if flow >= 0.0 else 0.0
    moves = opens != heart.is_open[0]
    heart.is_open[0] = opens
    return moves


@njit(**OPTIONS)
def eject(heart, flow):
    """Take what leaves in one step from the volume."""
    heart.volume[0] -= heart.dt * flow
