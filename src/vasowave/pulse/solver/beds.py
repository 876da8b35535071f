"""What the kernels know of beds: the exact steps of a few first-order equations each.

A bed answers ``p = pressure + resistance · q`` at the present half step, and then lets the flow into its modes.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vasowave.pulse.model.rational import Rational
from vasowave.pulse.solver.cells import OPTIONS


class BedSteps(NamedTuple):
    """The exact response of beds over half a step and a whole one, to a flow that is constant meanwhile.

    Attributes
    ----------
    decay_half, decay : complex array, shape (terminal, mode)
        What is left of the modes of `Rational`, exp(p dt/2) and exp(p dt).
    gain_half, gain : complex array, shape (terminal, mode)
        What the flow adds to them, mmHg s/ml.
    resistance : array, shape (terminal,)
        What a flow meets over half a step, mmHg s/ml.
    behind : array, shape (terminal,)
        Pressure behind the beds, mmHg, at the present half step; that of the modes is counted from it.
    """

    decay_half: np.ndarray
    decay: np.ndarray
    gain_half: np.ndarray
    gain: np.ndarray
    resistance: np.ndarray
    behind: np.ndarray


def bed_steps(beds: Rational, dt: float, behind: float | np.ndarray) -> BedSteps:
    """Return what beds do in a step of `dt` (s) before the pressure `behind` them (mmHg, shape (terminal,))."""
    (half, gain_half), (full, gain) = beds.over(dt / 2), beds.over(dt)
    resistance = beds.direct + gain_half.real.sum(axis=1)
    return BedSteps(half, full, gain_half, gain, resistance, np.array(behind, dtype=float))


class Pulsation(NamedTuple):
    """A pressure behind the beds that varies in time: a term."""

    pressure: np.ndarray  # (step, terminal) mmHg

    def before_nodes(self, step, n):
        """Let the pressure behind the beds be that of half step n."""
        behind = step.scheme.outlet.behind
        for j in range(len(behind)):
            behind[j] = self.pressure[n, j]


class PulsationTangent(NamedTuple):
    """The tangent of `Pulsation`."""

    base: Pulsation
    moved: np.ndarray  # (direction, step, terminal) mmHg

    def change_inflow(self, step, tangent, n, d):
        """Add what flows into the nodes as the direction changes what stands before the beds of that pressure."""
        ends, inflow = step.scheme.ends, tangent.at_nodes.inflow
        for k in range(ends.first_terminal, len(inflow)):
            j = k - ends.first_terminal
            inflow[k] += self.moved[d, n, j] / step.scheme.outlet.resistance[j]


@njit(**OPTIONS)
def bed_pressure(bed, memory, j):
    """Pressure without flow, mmHg, of terminal j, whose modes were `memory` half a step before."""
    pressure = bed.behind[j]
    for i in range(memory.shape[1]):
        decay, mode = bed.decay_half[j, i], memory[j, i]
        pressure += decay.real * mode.real - decay.imag * mode.imag
    return pressure


@njit(**OPTIONS)
def remember(bed, memory, j, q):
    """Let the flow `q` (ml/s) of this half step into the modes of terminal j."""
    for i in range(memory.shape[1]):
        memory[j, i] = bed.decay[j, i] * memory[j, i] + bed.gain[j, i] * q
