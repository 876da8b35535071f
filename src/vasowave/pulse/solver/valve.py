"""What the kernels know of a ventricle at the inlet: its volume, and whether its valve is open.

With the valve open the inlet's node is a bed: ``p = E V - (R + E dt/2) q`` with the volume V before the half step.
With the valve closed it is an inlet without flow. The valve opens where the ventricle's pressure passes that of the
node, and closes where the flow would turn; a half step in which it does either is solved a second time.
"""

from typing import NamedTuple

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.model.ventricle import Ventricle

_NOTHING = 1e-9  # of the volume in a period is a flow that is none


class Heart(NamedTuple):
    """A ventricle and its state: a term. The inflow of its `StepArguments` is its elastance."""

    filled: float  # ml above V0, when contraction begins
    resistance: float  # of the open valve, mmHg s/ml
    dt: float  # s
    volume: np.ndarray  # (1,) ml above V0, half a step before
    is_open: np.ndarray  # (1,) 1 or 0

    def begin(self, step, n):
        """Make the ventricle what it is when contraction begins."""
        self.volume[0], self.is_open[0] = self.filled, 0.0

    def meet(self, step, n):
        """Ask of the inlet's node what the ventricle does at this half step."""
        nodes, k, elastance = step.half.nodes, step.scheme.ends.inlet, step.inflow[n, 0]
        nodes.source[k] = 0.0
        if self.is_open[0] > 0.0:
            nodes.weight[k], nodes.outlet[k] = self.resistance + 0.5 * self.dt * elastance, 1.0
            nodes.memory[k] = elastance * self.volume[0]
        else:
            nodes.weight[k], nodes.outlet[k], nodes.memory[k] = 1.0, 0.0, 0.0

    def moves(self, step, n):
        """Move the valve as flow and pressure at the node ask for; returns whether it moved."""
        ends, half = step.scheme.ends, step.half
        flow, pressure = half.faces.flow[ends.face[ends.inlet]], half.nodes.pressure[0, ends.inlet]
        opens = 1.0 if step.inflow[n, 0] * self.volume[0] > pressure else 0.0
        if self.is_open[0] > 0.0:
            opens = 1.0 if flow >= 0.0 else 0.0
        moved = opens != self.is_open[0]
        self.is_open[0] = opens
        return moved

    def after_nodes(self, step, n):
        """Take what leaves in one step from the volume."""
        ends = step.scheme.ends
        self.volume[0] -= self.dt * step.half.faces.flow[ends.face[ends.inlet]]


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
