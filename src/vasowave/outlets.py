"""Outlets: what the vascular bed behind each terminal vessel answers to its flow.

Two kinds, one interface in the solver: the pressure at the end of a terminal vessel is a memory of past flow plus an
instantaneous resistance times the present flow.
"""

from typing import NamedTuple

import numpy as np

Values = float | np.ndarray


class Windkessel(NamedTuple):
    """Three-element Windkessel Z = R1 + R2/(1 + iωR2C) (eq. 7), one value per terminal vessel.

    The solver integrates its differential equation exactly for a flow that is constant during a step.

    Attributes
    ----------
    R1 : array, shape (terminal,)
        Proximal resistance, mmHg s/ml.
    R2 : array, shape (terminal,)
        Distal resistance, mmHg s/ml.
    C : array, shape (terminal,)
        Compliance C_p, ml/mmHg.
    """

    R1: Values
    R2: Values
    C: Values

    def impedance(self, omega: Values) -> np.ndarray:
        """Impedance, mmHg s/ml (eq. 7), at the angular frequencies ω (rad/s); shape (*omega.shape, terminal)."""
        omega = np.asarray(omega, dtype=float)[..., np.newaxis]
        return np.asarray(self.R1) + np.asarray(self.R2) / (1 + 1j * omega * np.asarray(self.R2) * np.asarray(self.C))

    def total_resistance(self) -> float:
        """Resistance R_T of all beds in parallel, mmHg s/ml: 1/R_T = Σ 1/(R1 + R2)."""
        return float(1.0 / np.sum(1.0 / (np.asarray(self.R1) + np.asarray(self.R2))))

    def weighted_compliance(self) -> np.ndarray:
        """Compliance Ĉ_p = (R2/R_T) C of each bed, ml/mmHg (below eq. 30), shape (terminal,)."""
        R1, R2, C = np.asarray(self.R1), np.asarray(self.R2), np.asarray(self.C)
        return R2 / (R1 + R2) * C


class ImpedanceSpectrum(NamedTuple):
    """Any bed given by its impedance at the harmonics of the heart rate; the solver convolves it with the flow.

    Attributes
    ----------
    Z : complex array, shape (harmonic, terminal)
        Impedance at ω_k = 2πk/T, k = 0 … K, mmHg s/ml; Z[0] is the resistance. Harmonics above K are taken as
        Z[K].real, the resistance that very fast changes meet.
    """

    Z: np.ndarray

    def impedance_at_harmonics(self, count: int) -> np.ndarray:
        """Impedance at harmonics 0 … count-1, mmHg s/ml, shape (count, terminal)."""
        Z = np.asarray(self.Z)
        beyond = np.broadcast_to(Z[-1].real, (max(0, count - len(Z)), Z.shape[1]))
        return np.concatenate([Z[:count], beyond])


Outlets = Windkessel | ImpedanceSpectrum
