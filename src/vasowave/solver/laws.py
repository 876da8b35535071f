"""What the kernels may call of a wall law or an outlet, chosen by its type when the kernel is compiled.

The equations stand in `vasowave.model.walls`; here they are only handed to the compiler. A new wall law needs nothing
here.
An outlet answers ``p = memory + resistance · q`` at the present half step, and then remembers the flow.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numba.extending import overload, register_jitable

from vasowave.model import walls
from vasowave.model.outlets import Bed, Outlets
from vasowave.solver import powers, trigonometry

# Numba cannot unpack a tuple of arrays at one index, so the call is written out by the count of parameters.
_CALL = {
    1: lambda law: lambda wall, j, x: law(x, wall[0][j]),
    2: lambda law: lambda wall, j, x: law(x, wall[0][j], wall[1][j]),
    3: lambda law: lambda wall, j, x: law(x, wall[0][j], wall[1][j], wall[2][j]),
    4: lambda law: lambda wall, j, x: law(x, wall[0][j], wall[1][j], wall[2][j], wall[3][j]),
}


def pressure_at(wall, j, x):
    """Pressure, mmHg, at area ratio x in cell j."""
    raise NotImplementedError("compiled code only")


def ratio_at(wall, j, x):
    """Area ratio at pressure x (mmHg) in cell j."""
    raise NotImplementedError("compiled code only")


def slope_at(wall, j, x):
    """Derivative of the area ratio, 1/mmHg, at pressure x in cell j."""
    raise NotImplementedError("compiled code only")


def _hand_over(name: str, stub: Any) -> None:
    @overload(stub)
    def choose(wall, j, x):
        law_class = wall.instance_class
        return _CALL[len(law_class._fields)](register_jitable(getattr(law_class, name)))


for _stub in (pressure_at, ratio_at, slope_at):
    _hand_over(_stub.__name__, _stub)

overload(walls.tangent)(lambda x: trigonometry.tangent)
overload(walls.arctangent)(lambda x: trigonometry.arctangent)
overload(walls.power)(lambda x, m: powers.power)


class BedSteps(NamedTuple):
    """The exact response of a bed over half a step and a whole one, to a flow that is constant meanwhile.

    Attributes
    ----------
    decay_half, decay : array, shape (terminal,)
        What is left of the capacitor's pressure, exp(-dt/2τ) and exp(-dt/τ).
    gain_half, gain : array, shape (terminal,)
        What the flow adds to it, mmHg s/ml.
    fast : array, shape (terminal,)
        Resistance before the capacitor, mmHg s/ml.
    behind : array, shape (terminal,)
        Pressure behind the bed, mmHg; that of the capacitor is counted from it.
    """

    decay_half: np.ndarray
    decay: np.ndarray
    gain_half: np.ndarray
    gain: np.ndarray
    fast: np.ndarray
    behind: np.ndarray

    def memory_scale(self, impedance: np.ndarray) -> np.ndarray:
        """Factors that turn the memory into pressures, shape (terminal, 1): it is the capacitor's pressure."""
        return np.ones((len(impedance), 1))

    def remembered(self) -> np.ndarray:
        """Times, in steps, whose waves make the memory at the start of a cycle, half a step before t = 0."""
        return np.array([-0.5])

    def memory_of(self, pressure: np.ndarray, flow: np.ndarray) -> np.ndarray:
        """Memory from pressure (mmHg) and flow (ml/s) of the terminals at these times, shape (time, terminal)."""
        return (pressure - self.behind - self.fast * flow).T.copy()


class ConvolutionSteps(NamedTuple):
    """A periodic impulse response, mmHg s/ml per step, shape (terminal, step); the paper's form of eq. 7.

    `behind` is the pressure behind the outlets, mmHg, shape (terminal,).
    """

    response: np.ndarray
    behind: np.ndarray

    def memory_scale(self, impedance: np.ndarray) -> np.ndarray:
        """Factors that turn the memory into pressures, shape (terminal, step): it is the flow of one cycle."""
        return np.broadcast_to(impedance[:, np.newaxis], self.response.shape)

    def remembered(self) -> np.ndarray:
        """Times, in steps, whose waves make the memory at the start of a cycle: all of the cycle before."""
        return np.arange(self.response.shape[1])

    def memory_of(self, pressure: np.ndarray, flow: np.ndarray) -> np.ndarray:
        """Memory from pressure (mmHg) and flow (ml/s) of the terminals at these times, shape (time, terminal)."""
        return flow.T.copy()


OutletSteps = BedSteps | ConvolutionSteps


def outlet_steps(outlets: Outlets, steps: int, period: float, behind: float | np.ndarray) -> OutletSteps:
    """Return the outlets' response over one of `steps` steps a cycle: exact for a `Bed`, else by convolution.

    `behind` is the pressure behind them, mmHg, shape (terminal,).
    """
    behind = np.array(behind, dtype=float)  # a copy: kernels are compiled for arrays in order
    if isinstance(outlets, Bed):
        circuit, dt = outlets.circuit(), period / steps
        (half, gain_half), (whole, gain) = circuit.over(dt / 2), circuit.over(dt)
        return BedSteps(half, whole, gain_half, gain, np.array(circuit.proximal), behind)
    Z = outlets.impedance_at(steps // 2 + 1, period)
    return ConvolutionSteps(np.ascontiguousarray(np.fft.irfft(Z, steps, axis=0).T), behind)


def outlet_line(outlet, memory, j, step):
    """Return pressure without flow (mmHg) and resistance (mmHg s/ml) of terminal j: p = pressure + resistance q."""
    raise NotImplementedError("compiled code only")


def remember(outlet, memory, j, step, q):
    """Let the flow `q` (ml/s) of this half step into the memory of terminal j."""
    raise NotImplementedError("compiled code only")


@overload(outlet_line)
def _outlet_line(outlet, memory, j, step):
    if outlet.instance_class is BedSteps:
        return lambda outlet, memory, j, step: (
            outlet.behind[j] + outlet.decay_half[j] * memory[j, 0],
            outlet.fast[j] + outlet.gain_half[j],
        )
    return lambda outlet, memory, j, step: (
        outlet.behind[j] + _past_flow(outlet.response[j], memory[j], step),
        outlet.response[j, 0],
    )


@overload(remember)
def _remember(outlet, memory, j, step, q):
    if outlet.instance_class is BedSteps:

        def charge(outlet, memory, j, step, q):
            memory[j, 0] = outlet.decay[j] * memory[j, 0] + outlet.gain[j] * q

        return charge

    def keep(outlet, memory, j, step, q):
        memory[j, step] = q

    return keep


@njit(nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def _past_flow(response, history, step):
    """Sum response[k] · flow k steps ago over one period; `history` is a ring whose next place is `step`."""
    total = 0.0
    count = len(response)
    for k in range(1, step + 1):
        total += response[k] * history[step - k]
    for k in range(step + 1, count):
        total += response[k] * history[step - k + count]
    return total
