"""Outlets: what the vascular bed behind each terminal vessel answers to its flow.

Two kinds, one interface in the solver: the pressure at the end of a terminal vessel is a memory of past flow plus an
instantaneous resistance times the present flow.
"""

from typing import NamedTuple

import numpy as np

from vasowave.errors import InputError
from vasowave.quantities import Parameter, Quantity

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

    @staticmethod
    def quantities() -> dict[str, Quantity]:
        """Return what the fields are."""
        return {
            "R1": Quantity("mmHg s/ml", "R_1", "proximal resistance", "7"),
            "R2": Quantity("mmHg s/ml", "R_2", "distal resistance", "7"),
            "C": Quantity("ml/mmHg", "C", "compliance of the vascular bed", "7"),
        }

    @staticmethod
    def factors() -> dict[str, Parameter]:
        """Return the factors of all beds' R1, R2 and C, which are fitted; the paper keeps them between 0.05 and 2.5."""
        paper = (0.05, 2.5)
        return {
            "r1": Parameter("1", "r_1", "factor of the nominal R_1 of all beds", "", 1.0, (0.002, 10.0), paper),
            "r2": Parameter("1", "r_2", "factor of the nominal R_2 of all beds", "", 1.0, (0.05, 10.0), paper),
            "c1": Parameter("1", "c_1", "factor of the nominal C of all beds", "", 1.0, (0.02, 20.0), paper),
        }

    def fast_resistance(self) -> np.ndarray:
        """Resistance that the fastest changes meet at each bed, R1, mmHg s/ml, shape (terminal,)."""
        return np.asarray(self.R1)

    def scaled(self, r1: float, r2: float, c1: float) -> "Windkessel":
        """Return the beds with all R1, R2 and C multiplied by these factors."""
        return Windkessel(r1 * np.asarray(self.R1), r2 * np.asarray(self.R2), c1 * np.asarray(self.C))

    def impedance(self, omega: Values) -> np.ndarray:
        """Impedance, mmHg s/ml (eq. 7), at the angular frequencies ω (rad/s); shape (*omega.shape, terminal)."""
        omega = np.asarray(omega, dtype=float)[..., np.newaxis]
        return np.asarray(self.R1) + np.asarray(self.R2) / (1 + 1j * omega * np.asarray(self.R2) * np.asarray(self.C))

    def total_resistance(self) -> float:
        """Resistance R_T of all beds in parallel, mmHg s/ml: 1/R_T = Σ 1/(R1 + R2)."""
        return float(1.0 / np.sum(1.0 / (np.asarray(self.R1) + np.asarray(self.R2))))

    def resistance_ratio(self) -> float:
        """Ratio a = R1/(R1 + R2), the mean over the beds."""
        R1, R2 = np.asarray(self.R1), np.asarray(self.R2)
        return float(np.mean(R1 / (R1 + R2)))

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

    def total_resistance(self) -> float:
        """Resistance R_T of all beds in parallel, mmHg s/ml."""
        return float(1.0 / np.sum(1.0 / np.asarray(self.Z)[0].real))

    def fast_resistance(self) -> np.ndarray:
        """Resistance that the fastest changes meet at each bed, that of the last harmonic, mmHg s/ml."""
        return np.asarray(self.Z)[-1].real

    def resistance_ratio(self) -> float:
        """Ratio of the resistance that fast changes meet to that of steady flow, the mean over the beds."""
        Z = np.asarray(self.Z).real
        return float(np.mean(Z[-1] / Z[0]))

    def weighted_compliance(self) -> np.ndarray:
        """Raise `InputError`: a spectrum has no single compliance."""
        raise InputError("compliance needs Windkessel outlets; an impedance spectrum names no capacitor")

    def impedance_at_harmonics(self, count: int) -> np.ndarray:
        """Impedance at harmonics 0 … count-1, mmHg s/ml, shape (count, terminal)."""
        Z = np.asarray(self.Z)
        beyond = np.broadcast_to(Z[-1].real, (max(0, count - len(Z)), Z.shape[1]))
        return np.concatenate([Z[:count], beyond])


Outlets = Windkessel | ImpedanceSpectrum
