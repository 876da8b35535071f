"""Outlets: what the vascular bed behind each terminal vessel answers to its flow.

Two kinds, one interface: an outlet knows its impedance at the harmonics of the heart rate and checks its own values.
The solver steps a Windkessel by its differential equation and convolves every other outlet with the flow.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from vasowave.descriptions import Parameter, Quantity
from vasowave.errors import InputError
from vasowave.per_vessel import one_per_vessel

Values = float | np.ndarray


@runtime_checkable
class Outlets(Protocol):
    """What a model, the linear solution, the solver and the analyses ask of the outlets."""

    def checked(self, names: Sequence[str]) -> "Outlets":
        """Return the outlets with one value for each terminal vessel of these names, or raise `InputError`."""
        ...

    def impedance_at(self, count: int, period: float) -> np.ndarray:
        """Impedance at the harmonics 0 … count-1 of the period (s), mmHg s/ml, shape (count, terminal)."""
        ...

    def fast_resistance(self) -> np.ndarray:
        """Resistance that a sudden change of flow meets, mmHg s/ml, shape (terminal,)."""
        ...

    def time_constants(self) -> np.ndarray:
        """Times over which the beds discharge, s, shape (terminal,); NaN where they are not known."""
        ...

    def total_resistance(self) -> float:
        """Resistance of all beds in parallel, mmHg s/ml."""
        ...

    def resistance_ratio(self) -> float:
        """Share of the resistance that a sudden change of flow meets, the mean over the beds."""
        ...

    def weighted_compliance(self) -> np.ndarray:
        """Compliance of each bed as the network sees it, ml/mmHg; `InputError` where it has none."""
        ...


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

    Examples
    --------
    >>> import vasowave as vw
    >>> beds = vw.Windkessel(R1=[20.0, 30.0], R2=[130.0, 170.0], C=[1e-3, 8e-4])
    >>> beds.total_resistance()  # 150 and 200 mmHg s/ml in parallel
    85.71...
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

    def scaled(self, r1: float, r2: float, c1: float) -> "Windkessel":
        """Return the beds with all R1, R2 and C multiplied by these factors."""
        return Windkessel(r1 * np.asarray(self.R1), r2 * np.asarray(self.R2), c1 * np.asarray(self.C))

    def impedance(self, omega: Values) -> np.ndarray:
        """Impedance, mmHg s/ml (eq. 7), at the angular frequencies ω (rad/s); shape (*omega.shape, terminal)."""
        omega = np.asarray(omega, dtype=float)[..., np.newaxis]
        return np.asarray(self.R1) + np.asarray(self.R2) / (1 + 1j * omega * np.asarray(self.R2) * np.asarray(self.C))

    def checked(self, names: Sequence[str]) -> "Windkessel":
        """Return one positive value of each parameter for every terminal, or raise `InputError` naming the vessel."""
        checked: Windkessel = one_per_vessel(self, names, "outlet")
        return checked

    def impedance_at(self, count: int, period: float) -> np.ndarray:
        """Impedance at the harmonics 0 … count-1 of the period (s), mmHg s/ml, shape (count, terminal) (eq. 7)."""
        return self.impedance(2 * np.pi / period * np.arange(count))

    def fast_resistance(self) -> np.ndarray:
        """Resistance R1 that a sudden change of flow meets, mmHg s/ml, shape (terminal,)."""
        return np.asarray(self.R1, dtype=float)

    def time_constants(self) -> np.ndarray:
        """R2 C, s, shape (terminal,)."""
        return np.asarray(self.R2) * np.asarray(self.C)

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

    Examples
    --------
    >>> import vasowave as vw
    >>> import numpy as np
    >>> beds = vw.Windkessel([20.0], [130.0], [1e-3])
    >>> omega = 2 * np.pi / 0.11 * np.arange(20)
    >>> vw.ImpedanceSpectrum(beds.impedance(omega)).total_resistance()
    150.0
    """

    Z: np.ndarray

    def checked(self, names: Sequence[str]) -> "ImpedanceSpectrum":
        """Return itself, or raise `InputError` naming the vessel whose impedance cannot be used."""
        Z = np.asarray(self.Z)
        if Z.ndim != 2 or Z.shape[1] != len(names) or len(Z) < 2:
            raise InputError(
                f"impedance spectrum has shape {Z.shape}; "
                f"it must be (harmonics, {len(names)}): one column per terminal vessel"
            )
        bad = np.flatnonzero(~np.all(np.isfinite(Z), axis=0) | (Z[0].real <= 0) | (Z[-1].real < 0))
        if len(bad):
            raise InputError(
                f"vessel '{names[bad[0]]}': its impedance is not finite, or its resistance is not positive"
            )
        return self

    def impedance_at(self, count: int, period: float) -> np.ndarray:
        """Impedance at the harmonics 0 … count-1, mmHg s/ml, shape (count, terminal); the period is the spectrum's."""
        Z = np.asarray(self.Z)
        beyond = np.broadcast_to(Z[-1].real, (max(0, count - len(Z)), Z.shape[1]))
        return np.concatenate([Z[:count], beyond])

    def fast_resistance(self) -> np.ndarray:
        """NaN for each terminal: where a spectrum ends, it need not have settled."""
        return np.full(np.shape(self.Z)[1], np.nan)

    def time_constants(self) -> np.ndarray:
        """NaN for each terminal: a spectrum names none."""
        return np.full(np.shape(self.Z)[1], np.nan)

    def total_resistance(self) -> float:
        """Resistance of all beds in parallel, mmHg s/ml."""
        return float(1.0 / np.sum(1.0 / np.asarray(self.Z)[0].real))

    def resistance_ratio(self) -> float:
        """NaN, as `fast_resistance`."""
        return float("nan")

    def weighted_compliance(self) -> np.ndarray:
        """Raise `InputError`: a spectrum names no capacitor."""
        raise InputError("compliance needs Windkessel outlets; an impedance spectrum names no capacitor")
