"""The slow modes of the cycle map: vessels and beds discharge together, while all other waves are gone in a cycle.

Vessels as one compliance, with one pressure, and the slow modes of the beds (`Rational`) behind their fast resistances
make a small linear system. What is left of each of its states after a cycle says, from the change that one cycle
brought, what all cycles to come would bring.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from vasowave.pulse.model import walls
from vasowave.pulse.model.rational import Rational
from vasowave.pulse.solver.grid import Grid
from vasowave.pulse.solver.state import Scale, State

_GONE = 12.0  # a mode that decays by more than this many time constants in a cycle is a part of the resistance
_NONE = 1e-300  # share of a mode that is left after a cycle, as good as none
_LEAST = 1e-3  # share of a bed's resistance that stands before its slow modes, at least


@dataclass(frozen=True, eq=False)
class Discharge:
    """What all cycles to come bring, if only the slow modes are left.

    Attributes
    ----------
    volume : array, shape (variable,)
        Share of every variable of a state in the pressure of the vessels.
    pressure : array, shape (variable,)
        What one mmHg in all vessels is to every variable.
    modes : int array, shape (mode,)
        Which variables are the slow modes of the beds.
    to_come : array, shape (1 + mode, 1 + mode)
        Change of that pressure and of these modes in all cycles to come, for each mmHg that a cycle brought.
    """

    volume: np.ndarray
    pressure: np.ndarray
    modes: np.ndarray
    to_come: np.ndarray

    def after(self, change: np.ndarray) -> np.ndarray:
        """Return what follows the change over one cycle, mmHg; both of shape (variable,)."""
        response = self.to_come @ np.append(change @ self.volume, change[self.modes])
        coming = response[0] * self.pressure
        coming[self.modes] = response[1:]
        return coming


def common_discharge(
    grid: Grid, scale: Scale, state: State, beds: Rational, period: float, held: bool = False
) -> Discharge:
    """Return the discharge of a model with these beds about the `state` at the start of a cycle.

    With `held`, where a pressure drives the network, that of the vessels does not change: the beds discharge alone.
    """
    wall, area0 = grid.wall, grid.area0
    per_pressure = np.asarray(walls.area_compliance(wall, walls.pressure(wall, state.area, area0), area0))
    pressure = scale.vector(State(per_pressure, np.zeros(len(area0)), np.zeros_like(state.memory)))
    volume = np.zeros(len(pressure))
    volume[: len(scale.compliance)] = scale.compliance * np.where(grid.is_cell, grid.spacing, 0.0)[scale.held]
    slow = (-beds.poles.real * period < _GONE) & (beds.residues != 0)
    components = np.stack([slow, slow & (beds.poles.imag != 0)], axis=-1).ravel()
    modes = len(pressure) - components.size + np.flatnonzero(components)
    system = _system(beds, slow, float(volume.sum()))
    retained = np.concatenate([[not held], components])
    after = expm(system[np.ix_(retained, retained)] * period)
    if not held:
        after = _from_softer(after, float(volume @ pressure / volume.sum()))
    to_come = np.linalg.solve(np.eye(len(after)) - after, after)
    if held:
        to_come = np.pad(to_come, ((1, 0), (1, 0)))
    return Discharge(volume / (volume @ pressure), pressure, modes, to_come)


def _from_softer(after: np.ndarray, softer: float) -> np.ndarray:
    """Return what is left after a cycle where vessels are `softer` as it begins than at mean pressure, by this factor.

    A pressure is then more volume, which the stiffer vessels of most of the cycle discharge; where the next begins,
    what is left spreads over the softer ones. The vessels' share of it is that of their mode.
    """
    share = np.clip(after[0, 0] / max(float(np.trace(after)), _NONE), 0.0, 1.0)
    return np.asarray(np.column_stack([softer * after[:, 0], after[:, 1:]]) / (1.0 + (softer - 1.0) * share))


def _system(beds: Rational, slow: np.ndarray, C_v: float) -> np.ndarray:
    """Return the derivatives, 1/s, of the vessels' pressure and the parts of all modes by each other."""
    mode_resistance = -(beds.residues / beds.poles).real
    before = beds.direct + np.where(slow, 0.0, mode_resistance).sum(axis=1)
    before = np.maximum(before, _LEAST * (beds.direct + mode_resistance.sum(axis=1)))
    terminals, width = slow.shape
    first = 1 + 2 * np.arange(terminals * width)
    A, into = np.zeros((1 + 2 * len(first),) * 2), np.zeros((1 + 2 * len(first), terminals))
    poles, residues = beds.poles.ravel(), beds.residues.ravel()
    A[first, first] = A[first + 1, first + 1] = poles.real
    A[first, first + 1], A[first + 1, first] = -poles.imag, poles.imag
    terminal = np.repeat(np.arange(terminals), width)
    into[0] = -1.0 / C_v
    into[first, terminal], into[first + 1, terminal] = residues.real, residues.imag
    flow = np.zeros((terminals, len(A)))
    flow[:, 0] = 1.0 / before
    flow[terminal, first] = np.where(slow.ravel(), -1.0 / before[terminal], 0.0)
    return np.asarray(A + into @ flow)
