"""How one pressure and the slow modes of many beds relax together, without a matrix of all modes.

The modes meet each other only through the flow of their own bed and through the pressure. So (z - A)⁻¹ is a block for
each bed and one column times one row, and exp(A) is the integral of it times e^z along a contour around the
eigenvalues (Weideman and Trefethen, Math. Comput. 76, 2007): a block for each bed, and a few dozen columns times rows.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vasowave.pulse.model.rational import Rational


@dataclass(frozen=True)
class ContourRules:
    """Where the integral is taken: z = distance + 2 - 2 cosh(θ/width) + iθ, in cycles⁻¹, at evenly spaced θ."""

    distance: float = 5.0  # from the imaginary axis: rounding errors grow by its exponential
    spacing: float = 0.85  # between two places, which leaves exp(-2π distance/spacing) = 1e-16
    narrowest: float = 8.0  # width for real eigenvalues; narrower, the wings come too near to them
    swing: float = 0.8  # widths by a mode's phase in a cycle, at which the contour still passes to the right of it
    lowest: float = -37.0  # real part beyond which e^z is none
    at_once: int = 200_000  # modes times places that are in memory together
    doublings: int = 5  # of the width, at most, until traces agree
    agreement: float = 1e-9  # of traces, as a share


RULES = ContourRules()
_NONE = 1e-300  # trace of a map that leaves nothing


class SlowModes(NamedTuple):
    """Modes of beds behind a resistance each, and the pressure that is common to all, in times of one cycle.

    Attributes
    ----------
    resistance : array, shape (terminal,)
        What stands before the modes, mmHg s/ml.
    poles, residues : complex array, shape (terminal, mode)
        As of `Rational`, times the cycle.
    softness : float
        Rise of the pressure by a flow of 1 ml/s over a cycle, mmHg s/ml; 0 where it is held.
    """

    resistance: np.ndarray
    poles: np.ndarray
    residues: np.ndarray
    softness: float

    @property
    def present(self) -> np.ndarray:
        """Which modes a bed has, shape (terminal, mode)."""
        return np.asarray(self.residues != 0)

    def without_flow(self) -> np.ndarray:
        """Return what a cycle leaves of each bed's modes, shape (terminal, component, component)."""
        terminals, count = self.poles.shape
        after = np.where(self.present, np.exp(self.poles), 0.0)
        blocks, mode = np.zeros((terminals, count, 2, count, 2)), np.arange(count)
        blocks[:, mode, 0, mode, 0] = after.real
        turning = np.where(self.poles.imag != 0, after, 0.0)
        blocks[:, mode, 1, mode, 1] = turning.real
        blocks[:, mode, 1, mode, 0], blocks[:, mode, 0, mode, 1] = turning.imag, -turning.imag
        return blocks.reshape(terminals, 2 * count, 2 * count)

    def responses(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return flow by pressure, (place, terminal), and by components: that by flow, and pressure by that.

        The last two have the shape (place, terminal, component); z are places of the complex plane.
        """
        z = z[:, np.newaxis, np.newaxis]
        direct = np.where(self.present, 1.0 / (z - self.poles), 0.0)
        conjugate = np.where(self.present, 1.0 / (z - self.poles.conj()), 0.0)
        forward, backward = 0.5 * self.residues * direct, 0.5 * self.residues.conj() * conjugate
        turned = np.where(self.poles.imag != 0, -1j * (forward - backward), 0.0)
        components = np.stack([forward + backward, turned], axis=-1)
        pressure = 0.5 * np.stack([direct + conjugate, 1j * (direct - conjugate)], axis=-1)
        admittance = 1.0 / (self.resistance + (forward + backward).sum(axis=-1))
        shape = (*admittance.shape, 2 * self.poles.shape[1])
        return admittance, components.reshape(shape), pressure.reshape(shape)

    @property
    def is_reactive(self) -> bool:
        """Whether a bed is more than resistances and compliances, whose eigenvalues are real and negative."""
        reactive = (self.poles.imag != 0) | (self.residues.imag != 0) | (self.residues.real < 0)
        return bool(np.any(reactive & self.present))


@dataclass(frozen=True, eq=False)
class Relaxation:
    """What a cycle leaves of a pressure and, bed by bed, of the components of modes: diag(0, blocks) + columns @ rows.

    Attributes
    ----------
    blocks : array, shape (terminal, component, component)
    columns : array, shape (1 + terminal * component, rank)
    rows : array, shape (rank, 1 + terminal * component)
    """

    blocks: np.ndarray
    columns: np.ndarray
    rows: np.ndarray

    @property
    def trace(self) -> float:
        """Sum of what is left of every variable of itself."""
        return float(np.trace(self.blocks, axis1=1, axis2=2).sum() + np.einsum("ik,ki->", self.columns, self.rows))

    def after(self, x: np.ndarray) -> np.ndarray:
        """Return what a cycle leaves of x, shape (1 + terminal * component, …)."""
        retained = self.columns @ (self.rows @ x)
        retained[1:] += _by_bed(np.matmul, self.blocks, x)
        return np.asarray(retained)

    def all_to_come(self, x: np.ndarray, softer: float = 1.0) -> np.ndarray:
        """Return the sum of what all cycles to come leave of x, where vessels are `softer` as a cycle begins."""
        return self.summed(softer)(x)

    def summed(self, softer: float = 1.0) -> Callable[[np.ndarray], np.ndarray]:
        """Return what makes of x the sum of what all cycles to come leave of it.

        By the factor `softer` the vessels are softer as a cycle begins than at mean pressure. A pressure is then more
        volume, which the stiffer vessels of most of the cycle discharge; where the next begins, what is left spreads
        over the softer ones. The vessels' share of it is that of their mode.
        """
        share = np.clip(self.columns[0] @ self.rows[:, 0] / max(self.trace, _NONE), 0.0, 1.0)
        spread = 1.0 + (softer - 1.0) * float(share)
        blocks, rows = self.blocks / spread, self.rows / spread
        rows[:, 0] *= softer
        cycle, columns = Relaxation(blocks, self.columns, rows), self.columns.copy()
        remainder = np.eye(blocks.shape[1]) - blocks
        columns[1:] = _by_bed(np.linalg.solve, remainder, columns)
        meeting = np.eye(len(rows)) - rows @ columns

        def relaxed(x: np.ndarray) -> np.ndarray:
            coming = cycle.after(x)
            coming[1:] = _by_bed(np.linalg.solve, remainder, coming)  # of all cycles, if the beds did not meet
            return np.asarray(coming + columns @ np.linalg.solve(meeting, rows @ coming))

        return relaxed


def bed_relaxation(beds: Rational, compliance: float, period: float) -> Relaxation:
    """Return what a cycle leaves of a pressure and of the modes of beds.

    Parameters
    ----------
    beds : Rational
        Resistances, and slow modes behind them.
    compliance : float
        Of what has the pressure, ml/mmHg; infinite where it is held: beds relax alone, and of it nothing is left.
    period : float
        s.
    """
    modes = SlowModes(beds.direct, beds.poles * period, beds.residues * period, period / compliance)
    swing = float(np.max(np.abs(modes.poles.imag), where=modes.present, initial=0.0))
    width = max(RULES.narrowest, RULES.swing * swing)
    current = _integrated(modes, width)
    for _ in range(RULES.doublings if modes.is_reactive else 0):
        width *= 2.0
        wider = _integrated(modes, width)
        if abs(wider.trace - current.trace) <= RULES.agreement * max(1.0, abs(wider.trace)):
            break
        current = wider
    return current


def _integrated(modes: SlowModes, width: float) -> Relaxation:
    """Return the integral of the resolvent along the contour of one width."""
    places, weights = _contour(width)
    blocks, columns, rows = modes.without_flow(), [], []
    chunk = max(1, RULES.at_once // max(1, modes.poles.size))
    for first in range(0, len(places), chunk):
        z, weight = places[first : first + chunk, np.newaxis], weights[first : first + chunk, np.newaxis]
        admittance, components, pressure = modes.responses(z[:, 0])
        moved, flow = admittance[..., np.newaxis] * components, admittance[..., np.newaxis] * pressure
        blocks -= ((weight[..., np.newaxis] * moved).transpose(1, 2, 0) @ pressure.transpose(1, 0, 2)).real
        share = weight / (z + modes.softness * admittance.sum(axis=1, keepdims=True))
        column = share * np.hstack([np.ones_like(z), moved.reshape(len(z), -1)])
        row = np.hstack([np.ones_like(z), modes.softness * flow.reshape(len(z), -1)])
        columns += [column.real, -column.imag]
        rows += [row.real, row.imag]
    rank = 0 if modes.softness == 0 else 2 * len(places)
    return Relaxation(blocks, np.vstack(columns)[:rank].T, np.vstack(rows)[:rank])


def _contour(width: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the places of the contour above the real axis and their weights: the sum's real part is the integral."""
    last = width * np.arccosh(1.0 + 0.5 * (RULES.distance - RULES.lowest))
    theta = RULES.spacing * (0.5 + np.arange(np.ceil(last / RULES.spacing)))
    z = RULES.distance + 2.0 - 2.0 * np.cosh(theta / width) + 1j * theta
    along = 1j - 2.0 / width * np.sinh(theta / width)
    return z, np.exp(z) * along * RULES.spacing / (np.pi * 1j)


def _by_bed(operation: Callable[..., np.ndarray], blocks: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return what an operation makes of the components of x bed by bed, shape (terminal * component, …)."""
    components = x[1:].reshape(*blocks.shape[:2], math.prod(x.shape[1:]))
    return operation(blocks, components).reshape(x[1:].shape)
