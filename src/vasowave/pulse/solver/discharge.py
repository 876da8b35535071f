"""The slow modes of the cycle map: vessels and beds discharge together, while all other waves are gone in a cycle.

Vessels as one compliance, with one pressure, and the slow modes of the beds (`Rational`) behind their fast resistances
make a small linear system. What is left of each of its states after a cycle says, from the change that one cycle
brought, what all cycles to come would bring.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vasowave.pulse.model import walls
from vasowave.pulse.model.rational import Rational
from vasowave.pulse.solver.grid import Grid
from vasowave.pulse.solver.relaxation import Relaxation, bed_relaxation
from vasowave.pulse.solver.state import Scale, State

_GONE = 12.0  # a mode that decays by more than this many time constants in a cycle is a part of the resistance
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
    modes : int array, shape (component,)
        Which variables are the two components of the slow modes, bed by bed.
    relaxation : Relaxation
        What a cycle leaves of that pressure and of these components.
    softer : float
        How much softer than at mean pressure the vessels are as a cycle begins.
    """

    volume: np.ndarray
    pressure: np.ndarray
    modes: np.ndarray
    relaxation: Relaxation
    softer: float

    @cached_property
    def _to_come(self) -> Callable[[np.ndarray], np.ndarray]:
        return self.relaxation.summed(self.softer)

    def after(self, change: np.ndarray) -> np.ndarray:
        """Return what follows the change over one cycle, mmHg; both of shape (variable,)."""
        response = self._to_come(np.append(change @ self.volume, change[self.modes]))
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
    total = float(volume.sum())
    slow, components = _slow_modes(beds, period)
    modes = len(pressure) - 2 * beds.poles.size + components
    relaxing = bed_relaxation(slow, np.inf if held else total, period)
    return Discharge(volume / (volume @ pressure), pressure, modes, relaxing, float(volume @ pressure / total))


def _slow_modes(beds: Rational, period: float) -> tuple[Rational, np.ndarray]:
    """Return beds of slow modes alone, behind what stands before these, and which components of all modes they are."""
    slow = (-beds.poles.real * period < _GONE) & (beds.residues != 0)
    mode_resistance = -(beds.residues / beds.poles).real
    before = beds.direct + np.where(slow, 0.0, mode_resistance).sum(axis=1)
    before = np.maximum(before, _LEAST * (beds.direct + mode_resistance.sum(axis=1)))
    order = np.argsort(~slow, axis=1, kind="stable")[:, : int(slow.sum(axis=1).max())]
    residues = np.where(slow, beds.residues, 0.0)
    mode = np.arange(len(slow))[:, np.newaxis] * slow.shape[1] + order
    components = (2 * mode[..., np.newaxis] + np.arange(2)).ravel()
    return Rational(before, *(np.take_along_axis(values, order, 1) for values in (beds.poles, residues))), components
