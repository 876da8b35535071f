"""Outlets: what the vascular bed behind each terminal vessel answers to its flow.

A bed is one class derived from `Bed`: its fields are its parameters, one value per terminal vessel. `bed` says in
words, symbols and bounds what they are, `nominal` where a fit starts, and `circuit` what they are to the flow; the rest
follows. A further circuit is one more class in `BUILT_IN`, or in a file of your own (`laws`, which
lists all beds).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, ClassVar, NamedTuple, Protocol, Self, dataclass_transform, runtime_checkable

import numpy as np

from vasowave.base.descriptions import BedLaw, Parameter, Quantity
from vasowave.base.errors import InputError
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.per_vessel import one_per_vessel
from vasowave.pulse.model.rational import (
    MOST,
    Rational,
    bare,
    fitted,
    importance,
    joined,
    misfit,
    refined,
    worth_fitting,
)
from vasowave.pulse.network.network import Network

Values = float | np.ndarray

RESISTANCE_RATIO = 0.2  # a = R1/R_T before the fit
KNOWN = 0.5  # SD of the logarithm of nearly all of the resistance, which mean pressure over mean flow gives
RESISTANCE, COMPLIANCE = "mmHg s/ml", "ml/mmHg"

OF_DROP = 0.5
"""SD of the model's error of the mean pressure, as a share of the mean fall along its vessels.

No vessel is a pump, so that blood loses between nothing and, by two SD, twice as much there as the model has it; mean
pressure over mean flow then bounds the resistance of the beds.
"""

_FAR = 0.5  # error of a spectrum's rational function from which it is no bed's


@runtime_checkable
class Outlets(Protocol):
    """What a model, the linear solution, the solver and the analyses ask of the outlets."""

    def checked(self, names: Sequence[str]) -> "Outlets":
        """Return the outlets with one value for each terminal vessel of these names, or raise `InputError`."""
        ...

    def impedance_at(self, count: int, period: float) -> np.ndarray:
        """Impedance at the harmonics 0 … count-1 of the period (s), mmHg s/ml, shape (count, terminal)."""
        ...

    def rational(self, period: float, neighbor: Self | None = None) -> Rational:
        """Return the impedance as the solver steps it in a cycle of `period` (s).

        What is only approximated is found anew, or from what was found for beds of a `neighbor`, as derivatives need.
        """
        ...

    def misfit(self, period: float) -> np.ndarray:
        """Return by how much the solver's function misses the impedance at the signal's harmonics, (terminal,).

        The largest of the harmonics 1 to 10 of the period (s), as a share of the impedance.
        """
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
        """Compliance of each bed as the network sees it, ml/mmHg; `InputError` where it is not known."""
        ...


class Circuit(NamedTuple):
    """What every bed with one time constant is: a resistance, and behind it a capacitor with a resistance across.

    Attributes
    ----------
    proximal, distal : array, shape (terminal,)
        Resistances before and across the capacitor, mmHg s/ml; 0 where there is none.
    compliance : array, shape (terminal,)
        ml/mmHg; 0 where there is no capacitor, and then nothing distal either.
    """

    proximal: np.ndarray
    distal: np.ndarray
    compliance: np.ndarray

    def impedance(self, omega: np.ndarray) -> np.ndarray:
        """Impedance, mmHg s/ml (eq. 7), at angular frequencies (rad/s) of shape (..., 1)."""
        return self.proximal + self.distal / (1 + 1j * omega * self.distal * self.compliance)

    def passes(self, omega: np.ndarray) -> np.ndarray:
        """Share of a pressure behind the circuit that stands before it where nothing flows, of shape (..., terminal).

        The capacitor is filled against the pressure around the lung, not against that behind the bed.
        """
        return 1 / (1 + 1j * omega * self.distal * self.compliance)

    def rational(self) -> Rational:
        """Return the circuit as a resistance and a pole: the pressure of the capacitor."""
        held = self.compliance > 0
        if not held.any():
            return bare(self.proximal)
        compliance = np.where(held, self.compliance, 1.0)
        poles = np.where(held, -1.0 / np.where(held, self.distal * compliance, 1.0), -1.0)
        residues = np.where(held, 1.0 / compliance, 0.0)
        return Rational(np.array(self.proximal, dtype=float), poles[:, np.newaxis] + 0j, residues[:, np.newaxis] + 0j)


class Site(NamedTuple):
    """What is known of all beds together before a fit.

    Attributes
    ----------
    resistance : float
        R_T, mmHg s/ml.
    time_constant : float
        τ of the recording's diastole, s.
    stiffness : float
        β of the vessels, mmHg.
    blood : Blood
    """

    resistance: float
    time_constant: float
    stiffness: float
    blood: Blood


@dataclass_transform(frozen_default=True, eq_default=False)
class Bed:
    """Base of all beds with one time constant or none; a class derived from it is a frozen dataclass.

    The solver integrates its differential equation exactly for a flow that is constant during a step.

    Examples
    --------
    >>> import vasowave as vw
    >>> isinstance(vw.Resistance(R=[150.0]), vw.Bed)
    True
    """

    _fields: ClassVar[tuple[str, ...]] = ()

    MAY_BE: ClassVar[Mapping[str, float]] = {}
    """Fields that need not be positive, and the least that they may be."""

    def __init_subclass__(cls, **keywords: Any) -> None:
        """Make the fields of a bed the arguments by which it is made."""
        super().__init_subclass__(**keywords)
        dataclass(frozen=True, eq=False)(cls)
        cls._fields = tuple(field.name for field in fields(cls))  # type: ignore[arg-type]

    @staticmethod
    def bed() -> BedLaw:
        """Return what is said of the bed."""
        raise NotImplementedError

    @classmethod
    def nominal(cls, resistance: np.ndarray, time_constant: float) -> Self:
        """Return beds of these resistances (mmHg s/ml, shape (terminal,)) with the recording's time constant (s)."""
        raise NotImplementedError

    @classmethod
    def of(cls, network: Network, site: Site) -> Self:
        """Return nominal beds of all terminals of a network: by `nominal`, the resistance shared as by eq. 11."""
        return cls.nominal(site.resistance / network.flow_fraction[network.terminals], site.time_constant)

    def circuit(self) -> Circuit | None:
        """Return what the bed is to the flow; None if it is more than a capacitor and two resistances."""
        raise NotImplementedError

    @property
    def _circuit(self) -> Circuit:
        """The circuit of a bed that is one; what is more overrides all that asks for it."""
        circuit = self.circuit()
        assert circuit is not None
        return circuit

    def __iter__(self) -> Iterator[Any]:
        """Go through the values of the fields."""
        return (getattr(self, name) for name in self._fields)

    def _asdict(self) -> dict[str, Any]:
        return dict(zip(self._fields, self, strict=True))

    def _replace(self, **values: Any) -> Self:
        return type(self)(**self._asdict() | values)

    def scaled(self, *factors: float) -> Self:
        """Return the beds with each field that is fitted multiplied by its factor."""
        fitted = zip(self.bed().fitted or self._fields, factors, strict=True)
        return self._replace(**{name: factor * np.asarray(getattr(self, name)) for name, factor in fitted})

    def moved(self, logarithms: np.ndarray) -> Self:
        """Return the beds with these added to the logarithms of the fields, shape (field, terminal)."""
        return type(self)(*(np.asarray(value) * np.exp(by) for value, by in zip(self, logarithms, strict=True)))

    def checked(self, names: Sequence[str]) -> Self:
        """Return one positive value of each parameter for every terminal, or raise `InputError` naming the vessel."""
        checked: Self = one_per_vessel(self, names, "outlet", self.MAY_BE)
        return checked

    def impedance(self, omega: Values) -> np.ndarray:
        """Impedance, mmHg s/ml, at the angular frequencies ω (rad/s); shape (*omega.shape, terminal)."""
        return self._circuit.impedance(np.asarray(omega, dtype=float)[..., np.newaxis])

    def impedance_at(self, count: int, period: float) -> np.ndarray:
        """Impedance at the harmonics 0 … count-1 of the period (s), mmHg s/ml, shape (count, terminal)."""
        return self.impedance(2 * np.pi / period * np.arange(count))

    def rational(self, period: float, neighbor: Self | None = None) -> Rational:
        """Return the circuit, whatever the period: exact."""
        return self._circuit.rational()

    def misfit(self, period: float) -> np.ndarray:
        """Return zeros: a circuit is stepped exactly."""
        return np.zeros(len(self.fast_resistance()))

    def fast_resistance(self) -> np.ndarray:
        """Resistance that a sudden change of flow meets, mmHg s/ml, shape (terminal,)."""
        return np.asarray(self._circuit.proximal, dtype=float)

    def time_constants(self) -> np.ndarray:
        """Times over which the capacitors discharge, s, shape (terminal,); 0 where there are none."""
        _, distal, compliance = self._circuit
        return distal * compliance

    def total_resistance(self) -> float:
        """Resistance R_T of all beds in parallel, mmHg s/ml: 1/R_T = Σ 1/(R1 + R2)."""
        proximal, distal, _ = self._circuit
        return float(1.0 / np.sum(1.0 / (proximal + distal)))

    def resistance_ratio(self) -> float:
        """Ratio a = R1/(R1 + R2), the mean over the beds."""
        proximal, distal, _ = self._circuit
        return float(np.mean(proximal / (proximal + distal)))

    def weighted_compliance(self) -> np.ndarray:
        """Compliance Ĉ_p = (R2/R_T) C of each bed, ml/mmHg (below eq. 30), shape (terminal,); 0 without capacitor."""
        proximal, distal, compliance = self._circuit
        return distal / (proximal + distal) * compliance

    def knobs(self) -> dict[str, str]:
        """Return what can be given in `with_totals`, and its unit."""
        return {"R_T": RESISTANCE} | ({"tau": "s"} if np.any(self.time_constants() > 0) else {})

    def with_totals(self, fractions: np.ndarray, values: Mapping[str, float]) -> Self:
        """Return beds of another total resistance ``R_T`` (at the same times) or time constant ``tau`` (their median).

        `fractions` are the shares of the mean flow that reach the beds, shape (terminal,).
        """
        resist = values.get("R_T", now := self.total_resistance()) / now
        slow = 1.0
        if "tau" in values:
            slow = values["tau"] / float(np.median(self.time_constants()))
        by_unit = {RESISTANCE: resist, COMPLIANCE: slow / resist, "s": slow}
        return self.scaled(*(by_unit.get(quantity.unit, 1.0) for quantity in self.bed().quantities.values()))


def _share(symbol: str, spread: float, low: float, high: float, paper: bool = False) -> Parameter:
    """Return the factor of the nominal values of a field."""
    field = symbol[0].upper() + symbol[1:]
    bounds = (0.05, 2.5) if paper else None
    return Parameter("1", symbol, f"factor of the nominal {field} of all beds", "", 1.0, (low, high), bounds, spread)


class Windkessel(Bed):
    """Three-element Windkessel Z = R1 + R2/(1 + iωR2C) (eq. 7), one value per terminal vessel.

    Attributes
    ----------
    R1 : array, shape (terminal,)
        Proximal resistance, mmHg s/ml.
    R2 : array, shape (terminal,)
        Distal resistance, mmHg s/ml.
    C : array, shape (terminal,)
        Compliance C of each, ml/mmHg; the C_p of results weighs it by R2/(R1 + R2), see `weighted_compliance`.

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
    def bed() -> BedLaw:
        """Return what is said of the bed; the paper keeps all factors between 0.05 and 2.5."""
        quantities = {
            "R1": Quantity(RESISTANCE, "R_1", "proximal resistance", "7"),
            "R2": Quantity(RESISTANCE, "R_2", "distal resistance", "7"),
            "C": Quantity(COMPLIANCE, "C", "compliance of the vascular bed", "7"),
        }
        factors = {
            "r1": _share("r_1", 1.0, 0.002, 10.0, True),
            "r2": _share("r_2", KNOWN, 0.05, 10.0, True),
            "c1": _share("c_1", 1.0, 0.02, 20.0, True)._replace(meaning="factor of the nominal C of all beds"),
        }
        return BedLaw("windkessel", "three-element Windkessels", "Z = R1 + R2/(1 + iωR2C)", "7", quantities, factors,
                      ("r1", "r2"))  # fmt: skip

    @classmethod
    def nominal(cls, resistance: np.ndarray, time_constant: float, a: float = RESISTANCE_RATIO) -> "Windkessel":
        """Return R1 = a R, R2 = (1 - a) R, C = τ/R (eqs. 11, 13)."""
        return cls(a * resistance, (1 - a) * resistance, time_constant / resistance)

    def circuit(self) -> Circuit:
        """Return the fields as they are."""
        return Circuit(np.asarray(self.R1), np.asarray(self.R2), np.asarray(self.C))

    def knobs(self) -> dict[str, str]:
        """Return what can be given in `with_totals`, and its unit."""
        return {"R_T": RESISTANCE, "a": "1", "tau": "s"}

    def with_totals(self, fractions: np.ndarray, values: Mapping[str, float]) -> "Windkessel":
        """Return beds of these R_T, a and tau = R_T C, shared as the paper does (eqs. 11, 13)."""
        tau = float(np.median(self.time_constants())) / (1.0 - self.resistance_ratio())
        now = {"R_T": self.total_resistance(), "a": self.resistance_ratio(), "tau": tau, **values}
        return self.nominal(now["R_T"] / fractions, now["tau"], now["a"])


class CompliantBed(Bed):
    """Two-element Windkessel: a resistance with a compliance beside it, Z = R/(1 + iωRC).

    Attributes
    ----------
    R : array, shape (terminal,)
        Resistance, mmHg s/ml.
    C : array, shape (terminal,)
        Compliance, ml/mmHg.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.CompliantBed(R=[150.0, 200.0], C=[1e-3, 8e-4]).total_resistance()  # mmHg s/ml
    85.71...
    """

    R: Values
    C: Values

    @staticmethod
    def bed() -> BedLaw:
        """Return what is said of the bed."""
        quantities = {
            "R": Quantity(RESISTANCE, "R", "resistance of the vascular bed"),
            "C": Quantity(COMPLIANCE, "C", "compliance of the vascular bed"),
        }
        factors = {"r": _share("r", KNOWN, 0.05, 10.0), "c": _share("c", 1.0, 0.02, 20.0)}
        return BedLaw("rc", "resistances with a compliance each", "Z = R/(1 + iωRC)", "", quantities, factors)

    @classmethod
    def nominal(cls, resistance: np.ndarray, time_constant: float) -> "CompliantBed":
        """Return the resistances, and C = τ/R."""
        return cls(resistance, time_constant / resistance)

    def circuit(self) -> Circuit:
        """Return a capacitor with nothing before it."""
        R = np.asarray(self.R)
        return Circuit(0 * R, R, np.asarray(self.C))


class Resistance(Bed):
    """A bare resistance, Z = R.

    Attributes
    ----------
    R : array, shape (terminal,)
        mmHg s/ml.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Resistance(R=[150.0, 200.0]).total_resistance()  # mmHg s/ml
    85.71...
    """

    R: Values

    @staticmethod
    def bed() -> BedLaw:
        """Return what is said of the bed."""
        quantities = {"R": Quantity(RESISTANCE, "R", "resistance of the vascular bed")}
        factors = {"r": _share("r", KNOWN, 0.05, 10.0)}
        return BedLaw("resistance", "bare resistances", "Z = R", "", quantities, factors)

    @classmethod
    def nominal(cls, resistance: np.ndarray, time_constant: float) -> "Resistance":
        """Return the resistances; no compliance stands for the time constant."""
        return cls(resistance)

    def circuit(self) -> Circuit:
        """Return a resistance with nothing behind it."""
        R = np.asarray(self.R)
        return Circuit(R, 0 * R, 0 * R)


class ReflectionCoefficient(Bed):
    """Beds that send a share of every wave back: Z = Z_c (1 + R_t)/(1 - R_t), whatever the frequency.

    Attributes
    ----------
    Z_c : array, shape (terminal,)
        Characteristic impedance of the vessel to which the coefficient belongs, mmHg s/ml.
    R_t : array, shape (terminal,)
        Reflection coefficient of pressure, between -1 (open) and 1 (closed); 0 sends nothing back.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.ReflectionCoefficient(Z_c=[20.0], R_t=[0.5]).total_resistance()  # mmHg s/ml
    60.0
    """

    Z_c: Values
    R_t: Values

    MAY_BE: ClassVar[Mapping[str, float]] = {"R_t": -1.0}

    @staticmethod
    def bed() -> BedLaw:
        """Return what is said of the bed; a factor of Z_c is one of the resistance."""
        quantities = {
            "Z_c": Quantity(RESISTANCE, "Z_c", "characteristic impedance before the reflection"),
            "R_t": Quantity("1", "R_t", "reflection coefficient of the vascular bed"),
        }
        factors = {"r": _share("r", KNOWN, 0.05, 10.0)._replace(meaning="factor of the nominal resistance of all beds")}
        return BedLaw("reflection", "reflection coefficients", "Z = Z_c (1 + R_t)/(1 - R_t)", "", quantities, factors,
                      None, ("R_t",))  # fmt: skip

    @classmethod
    def nominal(cls, resistance: np.ndarray, time_constant: float) -> "ReflectionCoefficient":
        """Return the coefficients that make these resistances of a share `RESISTANCE_RATIO` of them before the bed."""
        return cls(RESISTANCE_RATIO * resistance, (1 - RESISTANCE_RATIO) / (1 + RESISTANCE_RATIO) + 0 * resistance)

    @classmethod
    def of(cls, network: Network, site: Site) -> "ReflectionCoefficient":
        """Return the coefficients with which the terminal vessels, as stiff as the root, have the resistance."""
        Z_c = np.sqrt(0.5 * site.blood.inertia * site.stiffness) / network.area[network.terminals]
        resistance = site.resistance / network.flow_fraction[network.terminals]
        return cls(Z_c, (resistance - Z_c) / (resistance + Z_c))

    def scaled(self, *factors: float) -> "ReflectionCoefficient":
        """Return the beds with resistances multiplied by the factor, before the same vessels."""
        Z_c, resistance = np.asarray(self.Z_c), factors[0] * self.circuit().proximal
        return type(self)(Z_c, (resistance - Z_c) / (resistance + Z_c))

    def checked(self, names: Sequence[str]) -> "ReflectionCoefficient":
        """Return one value of each parameter for every terminal, or raise `InputError` naming the vessel."""
        beds = super().checked(names)
        bad = np.flatnonzero(np.abs(np.asarray(beds.R_t)) >= 1)
        if len(bad):
            raise InputError(
                f"vessel '{names[bad[0]]}': R_t = {np.asarray(beds.R_t)[bad[0]]:g}; it lies between -1 and 1"
            )
        return beds

    def circuit(self) -> Circuit:
        """Return the resistance that reflects as much."""
        R = np.asarray(self.Z_c) * (1 + np.asarray(self.R_t)) / (1 - np.asarray(self.R_t))
        return Circuit(R, 0 * R, 0 * R)

    def with_totals(self, fractions: np.ndarray, values: Mapping[str, float]) -> "ReflectionCoefficient":
        """Return beds of another total resistance ``R_T``."""
        return self.scaled(values.get("R_T", now := self.total_resistance()) / now)


BUILT_IN: tuple[Any, ...] = (Windkessel, CompliantBed, Resistance, ReflectionCoefficient)
"""The beds of this file."""


@dataclass(frozen=True, eq=False)
class ImpedanceSpectrum:
    """Any bed given by its impedance at the harmonics of the heart rate.

    The solver steps the rational function nearest to it (`Rational`), which also says what it is between the harmonics
    and beyond the last.

    Attributes
    ----------
    Z : complex array, shape (harmonic, terminal)
        Impedance at ω_k = 2πk/T, k = 0 … K, mmHg s/ml; Z[0] is the resistance.

    Examples
    --------
    >>> import vasowave as vw
    >>> import numpy as np
    >>> beds = vw.Windkessel([20.0], [130.0], [1e-3])
    >>> omega = 2 * np.pi / 0.11 * np.arange(20)
    >>> spectrum = vw.ImpedanceSpectrum(beds.impedance(omega))
    >>> spectrum.total_resistance()
    150.0
    >>> spectrum.fast_resistance()  # found, though the last harmonic given still has an imaginary part
    array([20.])
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
        worst = int(np.argmax(self.error))
        if self.error[worst] > _FAR:
            raise InputError(f"vessel '{names[worst]}': {_refusal(Z[:, worst], self.error[worst])}")
        return self

    @cached_property
    def unscaled(self) -> Rational:
        """The rational function for a period of 2π, at which the harmonics are the angular frequencies."""
        Z = np.asarray(self.Z, dtype=complex)
        rows, spectra = worth_fitting(len(Z)), Z[:MOST]
        harmonic = np.arange(len(spectra), dtype=float)
        coarse = [fitted(rows.astype(float), column) for column in Z[rows].T]
        return joined(
            [refined(harmonic, 1.0, column, start, noise=True) for column, start in zip(spectra.T, coarse, strict=True)]
        )

    @cached_property
    def error(self) -> np.ndarray:
        """Root mean square of the rational function's error, as that of the impedance without its mean, (terminal,).

        Harmonics count as they do in a flow: less and less from the sixteenth on.
        """
        Z, k = np.asarray(self.Z), np.arange(len(self.Z))
        weight = importance(k)[:, np.newaxis]
        difference = weight * np.abs(self.unscaled.impedance(1j * k) - Z)
        return np.asarray(np.sqrt(np.sum(difference**2, axis=0) / np.sum((weight * np.abs(Z))[1:] ** 2, axis=0)))

    def misfit(self, period: float) -> np.ndarray:
        """Return the largest error of the rational function at the harmonics of the signal, a share, (terminal,)."""
        Z = np.asarray(self.Z)
        return misfit(Z, self.unscaled.impedance(1j * np.arange(len(Z))))

    def rational(self, period: float, neighbor: Self | None = None) -> Rational:
        """Return the rational function for this period (s)."""
        base = 2 * np.pi / period
        return Rational(self.unscaled.direct, self.unscaled.poles * base, self.unscaled.residues * base)

    def impedance_at(self, count: int, period: float) -> np.ndarray:
        """Impedance at the harmonics 0 … count-1, mmHg s/ml, shape (count, terminal); the period is the spectrum's."""
        return np.concatenate([np.asarray(self.Z)[:count], self.unscaled.impedance(1j * np.arange(len(self.Z), count))])

    def fast_resistance(self) -> np.ndarray:
        """Resistance that a sudden change of flow meets, mmHg s/ml, shape (terminal,)."""
        return self.unscaled.direct

    def time_constants(self) -> np.ndarray:
        """NaN for each terminal: a spectrum names none."""
        return np.full(np.shape(self.Z)[1], np.nan)

    def total_resistance(self) -> float:
        """Resistance of all beds in parallel, mmHg s/ml."""
        return float(1.0 / np.sum(1.0 / np.asarray(self.Z)[0].real))

    def resistance_ratio(self) -> float:
        """Share of the resistance that a sudden change of flow meets, the mean over the beds."""
        return float(np.mean(self.unscaled.direct / np.asarray(self.Z)[0].real))

    def weighted_compliance(self) -> np.ndarray:
        """Raise `InputError`: a spectrum names no capacitor."""
        raise InputError("compliance needs Windkessel outlets; an impedance spectrum names no capacitor")


def _refusal(Z: np.ndarray, error: float) -> str:
    """Return why the impedance of one bed cannot be stepped, where the nearest rational function is far from it."""
    away = f"the nearest that the solver can step is {100 * error:.0f} % away"
    lowest = int(np.argmin(Z.real))
    if Z[lowest].real < 0:
        return (
            f"no passive bed has this impedance, whose real part is {Z[lowest].real:.3g} mmHg s/ml at harmonic "
            f"{lowest} ({away}); check the sign of its phase, its unit and its order (from the mean on)"
        )
    turned = ImpedanceSpectrum(Z.conj()[:, np.newaxis]).error[0]
    if turned < 0.5 * error:
        return (
            f"the sign of this impedance's phase looks turned: {away}, and {100 * turned:.1f} % with the other sign; "
            "where a bed stores blood, the phase is negative"
        )
    return (
        f"this impedance has more resonances than the solver can step: {away}; give more harmonics, or a tube with "
        "resonances as a vessel of the network"
    )
