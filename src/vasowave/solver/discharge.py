"""The one slow mode of the cycle map: vessels and beds discharge together, while all other waves are gone in a cycle.

Vessels of compliance C_v discharge through the beds' proximal resistances into their capacitors, and these through
the distal ones (see `outlets.Circuit`); where a bed has only a part of that, so has the circuit. The slower of the two
rates of that circuit says how much of a mode is left after a cycle, the volume that a cycle adds says how much of the
mode there was: what all cycles to come would bring is known after the first.
"""

from dataclasses import dataclass

import numpy as np

from vasowave.model import walls
from vasowave.model.outlets import Bed, Circuit
from vasowave.solver.grid import Grid
from vasowave.solver.state import Scale, State


@dataclass(frozen=True, eq=False)
class Discharge:
    """What all cycles to come bring, if only the common discharge is left.

    Attributes
    ----------
    volume : array, shape (variable,)
        Volume of every variable of a state, ml/mmHg.
    to_come : array, shape (variable,)
        Change in all cycles to come for each ml that a cycle brought, mmHg/ml.
    """

    volume: np.ndarray
    to_come: np.ndarray

    def after(self, change: np.ndarray) -> np.ndarray:
        """Return what follows the change over one cycle, mmHg; both of shape (variable,) or (row, variable)."""
        return np.multiply.outer(change @ self.volume, self.to_come)


def common_discharge(grid: Grid, scale: Scale, state: State, period: float) -> Discharge:
    """Return the discharge of a model about the `state` at the start of a cycle; none where it has no such circuit."""
    beds = grid.model.outlets
    if not isinstance(beds, Bed):
        none = np.zeros(len(scale.vector(state)))
        return Discharge(none, none)
    wall, area0 = grid.wall, grid.area0
    per_pressure = walls.area_compliance(wall, walls.pressure(wall, state.area, area0), area0)
    circuit = beds.circuit()
    held = np.where(circuit.compliance > 0, 1.0, 0.0)[:, np.newaxis] * np.ones_like(state.memory)
    mode = scale.vector(State(np.asarray(per_pressure), np.zeros(len(area0)), held))
    volume = scale.volume(np.where(grid.is_cell, grid.spacing, 0.0), np.asarray(circuit.compliance, dtype=float))
    kept = np.exp(-period * _slow_rate(volume[: len(scale.compliance)].sum(), circuit))
    return Discharge(volume, kept / (1 - kept) / (mode @ volume) * mode)


def _slow_rate(C_v: float, circuit: Circuit) -> float:
    """Rate, 1/s, at which C_v discharges through G1 into C and this through G2, once they discharge together.

    The slower root of s² - (G1/C_v + (G1 + G2)/C) s + G1 G2/(C_v C); without C or without R1 there is one rate.
    """
    C = float(np.sum(circuit.compliance))
    if not C or not np.all(circuit.proximal):
        return float(np.sum(1 / (circuit.proximal + circuit.distal)) / (C_v + C))
    G1, G2 = np.sum(1 / circuit.proximal), np.sum(1 / circuit.distal)
    half, product = 0.5 * (G1 / C_v + (G1 + G2) / C), G1 * G2 / (C_v * C)
    return float(product / (half + np.sqrt(half**2 - product)))
