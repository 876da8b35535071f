"""The structured tree: a bed of branching vessels whose radii, lengths and walls follow a few rules.

Every vessel of radius r has a length λ r and two daughters of radii α r and β r, down to the first that are not wider
than the smallest radius; α^ξ + β^ξ = 1, and (β/α)² is the asymmetry. Waves in each are those of Womersley's theory. The
impedance at the root is found from the ends up, once for each radius α^i β^j r0, not for each vessel (Olufsen 1999,
Am. J. Physiol. 276; Olufsen et al. 2012, J. Fluid Mech. 705; Chambers et al. 2020, Math. Med. Biol. 37).
"""

from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache
from typing import ClassVar

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from scipy.special import jve

from vasowave.base.descriptions import BedLaw, Parameter, Quantity
from vasowave.base.errors import InputError
from vasowave.base.units import MMHG
from vasowave.pulse.model.outlets import KNOWN, Bed, Site, Values
from vasowave.pulse.model.rational import (
    CLOSE,
    SIGNAL,
    Rational,
    fitted,
    joined,
    misfit,
    nearby,
    refined,
    worth_fitting,
)
from vasowave.pulse.network.network import Network

_HARMONICS = 96  # to which the rational function is fitted
_POLES = 10
_MOST = 4000  # radii of a tree, at most
_THINNEST = 2e-4  # cm; below it the law of the viscosity has no meaning


class StructuredTree(Bed):
    """Branching vessels behind every terminal; one value per terminal vessel, so that trees may differ.

    Attributes
    ----------
    root_radius : array, shape (terminal,)
        Radius of the first vessel, cm.
    length_ratio : array
        Length over radius λ of every vessel.
    stiffness : array
        Stiffness of the walls, 4/3 Eh/r, mmHg: β of a linear wall.
    exponent : array
        ξ in r^ξ = r1^ξ + r2^ξ.
    asymmetry : array
        (r2/r1)², at most 1.
    smallest : array
        Radius from which on vessels have no daughters, cm; the pressure behind them is that behind the bed.
    dilation : array
        Factor of all radii at unchanged lengths: below 1 the whole bed is constricted.
    stiffening : array
        What thin vessels are stiffer by: the stiffness is multiplied by 1 + stiffening exp(-r/stiffening_radius).
    stiffening_radius : array
        cm.
    hematocrit : array
        With which viscosity falls with the radius (Pries et al. 1994); 0 for one viscosity.
    viscosity : array
        Kinematic viscosity of the blood in wide vessels, cm²/s.
    density : array
        g/ml.

    Examples
    --------
    >>> import vasowave as vw
    >>> beds = vw.StructuredTree.of_factors(0.88, 0.68, root_radius=[0.018, 0.024], length_ratio=17.0, stiffness=60.0)
    >>> beds.total_resistance()  # mmHg s/ml
    656.89...
    """

    root_radius: Values
    length_ratio: Values
    stiffness: Values
    exponent: Values = 2.98
    asymmetry: Values = 0.597
    smallest: Values = 0.005
    dilation: Values = 1.0
    stiffening: Values = 0.0
    stiffening_radius: Values = 0.01
    hematocrit: Values = 0.0
    viscosity: Values = 0.0462
    density: Values = 1.057

    NOMINAL: ClassVar[Mapping[str, float]] = {}
    """Values with which fits begin, in place of those above; a class derived from this one may have its own."""

    MAY_BE: ClassVar[Mapping[str, float]] = {"stiffening": 0.0, "hematocrit": 0.0, "viscosity": 0.0}

    @staticmethod
    def bed() -> BedLaw:
        """Return what is said of the bed."""
        quantities = {
            "root_radius": Quantity("cm", "r_0", "radius of a tree's first vessel"),
            "length_ratio": Quantity("1", "λ", "length over radius in the trees"),
            "stiffness": Quantity("mmHg", "β_t", "stiffness of the walls in the trees"),
            "exponent": Quantity("1", "ξ", "exponent of the radii at branchings of the trees"),
            "asymmetry": Quantity("1", "η", "asymmetry of the branchings of the trees"),
            "smallest": Quantity("cm", "r_min", "smallest radius of the trees"),
            "dilation": Quantity("1", "D", "factor of all radii of the trees"),
            "stiffening": Quantity("1", "κ", "what thin vessels of the trees are stiffer by"),
            "stiffening_radius": Quantity("cm", "r_κ", "radius over which that falls"),
            "hematocrit": Quantity("1", "H", "hematocrit in the trees"),
            "viscosity": Quantity("cm2/s", "ν", "viscosity in wide vessels of the trees"),
            "density": Quantity("g/ml", "ρ", "density of the blood in the trees"),
        }
        factor_table = {
            "tree_length": ("length_ratio", 0.02, 50.0, KNOWN),
            "tree_stiffness": ("stiffness", 0.02, 50.0, 1.0),
            "tree_exponent": ("exponent", 0.8, 1.4, 0.06),
            "tree_asymmetry": ("asymmetry", 0.1, 1.6, 0.25),
            "tree_smallest": ("smallest", 0.1, 3.0, 0.4),
            "tree_dilation": ("dilation", 0.3, 3.0, 0.2),
            "tree_stiffening": ("stiffening", 0.02, 50.0, 1.0),
            "tree_hematocrit": ("hematocrit", 0.4, 1.6, 0.1),
        }
        factors = {
            name: Parameter("1", f"f_{quantities[field].symbol}", f"factor of the nominal {field} of all trees", "",
                            1.0, (low, high), None, spread, field not in ("length_ratio", "stiffness"))
            for name, (field, low, high, spread) in factor_table.items()
        }  # fmt: skip
        return BedLaw("tree", "structured trees", "Z(ω) by recursion over the radii α^i β^j r_0", "", quantities,
                      factors, None, tuple(field for field, *_ in factor_table.values()))  # fmt: skip

    @classmethod
    def of_factors(cls, alpha: float, beta: float, **values: Values) -> "StructuredTree":
        """Return trees of these factors α and β of the daughters' radii, `beta` the smaller.

        Raises
        ------
        InputError
            Factors that are not below 1, or whose daughters together are narrower than a vessel of the parent's radius.
        """
        if not 0 < beta <= alpha < 1:
            raise InputError(f"alpha = {alpha:g}, beta = {beta:g}: give 0 < beta <= alpha < 1")
        exponent = brentq(lambda xi: alpha**xi + beta**xi - 1.0, 1e-3, 1e3)
        return cls(exponent=exponent, asymmetry=(beta / alpha) ** 2, **values)

    @classmethod
    def nominal(cls, resistance: np.ndarray, time_constant: float) -> "StructuredTree":
        """Raise `InputError`: `of` knows the radii."""
        raise InputError("structured trees begin with the radii of the terminal vessels; use StructuredTree.of")

    @classmethod
    def of(cls, network: Network, site: Site) -> "StructuredTree":
        """Return trees as wide as the terminal vessels and as stiff, so long that they have the resistance together."""
        radii, names = network.radius[network.terminals], [network.name[row] for row in network.terminals]
        blood = {"viscosity": site.blood.viscosity, "density": site.blood.density}
        usual = {"smallest": _smallest(radii), **cls.NOMINAL, **blood}
        trees = cls(radii, 1.0, site.stiffness, **usual).checked(names)
        return trees._replace(length_ratio=trees.length_ratio * site.resistance / trees.total_resistance())

    def circuit(self) -> None:
        """Return nothing: a tree is no circuit."""
        return

    def checked(self, names: Sequence[str]) -> "StructuredTree":
        """Return one value of each parameter for every terminal, or raise `InputError` naming the vessel."""
        trees = super().checked(names)
        for j, name in enumerate(names):
            exponent, asymmetry, smallest, hematocrit, radius, dilation = (
                float(np.asarray(value)[j])
                for value in (
                    trees.exponent,
                    trees.asymmetry,
                    trees.smallest,
                    trees.hematocrit,
                    trees.root_radius,
                    trees.dilation,
                )
            )
            if asymmetry > 1:
                raise InputError(
                    f"vessel '{name}': asymmetry = {asymmetry:g}; it is (r2/r1)² of the narrower, at most 1"
                )
            if hematocrit >= 1:
                raise InputError(f"vessel '{name}': hematocrit = {hematocrit:g}; give a share, below 1")
            if hematocrit and dilation * smallest * asymmetry < _THINNEST:
                raise InputError(
                    f"vessel '{name}': its tree reaches radii below {_THINNEST:g} cm, where viscosity by hematocrit "
                    "has no meaning; raise smallest, or take hematocrit 0"
                )
            alpha, _ = _ratios(exponent, asymmetry)
            depth = max(0.0, np.log(smallest / radius) / np.log(alpha))
            if not depth**2 / 2 < _MOST:
                raise InputError(
                    f"vessel '{name}': its tree has about {depth**2 / 2:.0f} different radii, more than {_MOST}; raise "
                    "smallest, or lower exponent"
                )
        return trees

    def impedance(self, omega: Values) -> np.ndarray:
        """Impedance, mmHg s/ml, at the angular frequencies ω (rad/s); shape (*omega.shape, terminal)."""
        shape = np.shape(omega)
        columns = [tree.impedance(np.abs(np.ravel(omega))) for tree in self._trees]
        Z = np.stack(columns, axis=-1).reshape(*shape, len(columns))
        return np.where(np.asarray(omega)[..., np.newaxis] < 0, Z.conj(), Z)

    def rational(self, period: float, neighbor: "StructuredTree | None" = None) -> Rational:
        """Return the rational function nearest to the impedance at the harmonics of a period (s)."""
        if neighbor is None:
            return _rational(self, period)
        base, heart = _rational(neighbor, period), 2 * np.pi / period
        omega = heart * _between(coarse=base.poles.shape[1] <= _POLES)
        return nearby(omega, self.impedance(omega) - neighbor.impedance(omega), base, heart)

    def misfit(self, period: float) -> np.ndarray:
        """Return the largest error of the rational function at the harmonics of the signal, a share, (terminal,)."""
        omega = 2 * np.pi / period * np.arange(SIGNAL + 1)
        return misfit(self.impedance(omega), self.rational(period).impedance(1j * omega))

    def fast_resistance(self) -> np.ndarray:
        """Characteristic impedance of the first vessels at high frequencies, mmHg s/ml, shape (terminal,)."""
        return np.array([tree.surge for tree in self._trees])

    def time_constants(self) -> np.ndarray:
        """Resistance times compliance of every tree, s, shape (terminal,)."""
        return self._resistances * self.weighted_compliance()

    def total_resistance(self) -> float:
        """Resistance R_T of all trees in parallel, mmHg s/ml."""
        return float(1.0 / np.sum(1.0 / self._resistances))

    def resistance_ratio(self) -> float:
        """Share of the resistance that a sudden change of flow meets, the mean over the trees."""
        return float(np.mean(self.fast_resistance() / self._resistances))

    def weighted_compliance(self) -> np.ndarray:
        """Volume that a steady flow holds in every tree, over the pressure at its root, ml/mmHg, shape (terminal,)."""
        return np.array([tree.steady[1] for tree in self._trees])

    def knobs(self) -> dict[str, str]:
        """Return what can be given in `with_totals`, and its unit: the values of the fields."""
        law = self.bed()
        return {name: law.quantities[name].unit for name in law.fitted}

    def with_totals(self, fractions: np.ndarray, values: Mapping[str, float]) -> "StructuredTree":
        """Return trees of which all have these values of the fields."""
        return self._replace(**{name: np.full(len(fractions), value) for name, value in values.items()})

    @cached_property
    def _trees(self) -> "list[_Tree]":
        rows = zip(*np.broadcast_arrays(*map(np.atleast_1d, self)), strict=True)
        return [_Tree(dict(zip(self._fields, map(float, row), strict=True))) for row in rows]

    @cached_property
    def _resistances(self) -> np.ndarray:
        return np.array([tree.steady[0] for tree in self._trees])


class BloodTree(StructuredTree):
    """Structured trees in which viscosity falls with the radius, at a hematocrit of 0.45.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Fitting(bed="blood_tree").bed
    'blood_tree'
    """

    NOMINAL: ClassVar[Mapping[str, float]] = {"hematocrit": 0.45}

    @staticmethod
    def bed() -> BedLaw:
        """Return what is said of the bed."""
        return StructuredTree.bed()._replace(name="blood_tree", title="structured trees with viscosity by radius")


class _Tree:
    """One tree: every radius in it once, the smallest first, and which two radii its daughters have."""

    def __init__(self, values: Mapping[str, float]) -> None:
        self.values = values
        alpha, beta = _ratios(values["exponent"], values["asymmetry"])
        shares, self.daughters = _branching(values["root_radius"] / values["smallest"], alpha, beta)
        radius = values["root_radius"] * shares
        wide = values["dilation"] * radius
        stiffer = 1.0 + values["stiffening"] * np.exp(-wide / values["stiffening_radius"])
        thicker = relative_viscosity(wide, values["hematocrit"]) if values["hematocrit"] else 1.0
        self.inertia = values["density"] / MMHG
        self.length, self.area = values["length_ratio"] * radius, np.pi * wide**2
        self.compliance = 2 * self.area / (values["stiffness"] * stiffer)  # per length
        self.viscosity = values["viscosity"] * thicker + 0.0 * radius

    @cached_property
    def steady(self) -> tuple[float, float]:
        """Resistance (mmHg s/ml), and the volume that a steady flow holds over the pressure at the root (ml/mmHg)."""
        vessel_resistance = 8 * np.pi * self.inertia * self.viscosity * self.length / self.area**2
        resistance, stored = np.zeros(len(vessel_resistance)), np.zeros(len(vessel_resistance))
        for k, two in enumerate(self.daughters):
            behind = 0.0 if two is None else 1.0 / np.sum(1.0 / resistance[list(two)])
            below = 0.0 if two is None else stored[list(two)].sum()
            resistance[k] = vessel_resistance[k] + behind
            share = behind / resistance[k] if behind else 0.0
            stored[k] = self.compliance[k] * self.length[k] * 0.5 * (1.0 + share) + share * below
        return float(resistance[-1]), float(stored[-1])

    @property
    def surge(self) -> float:
        """Characteristic impedance of the first vessel at high frequencies, mmHg s/ml."""
        return float(np.sqrt(self.inertia / self.area[-1] / self.compliance[-1]))

    def impedance(self, omega: np.ndarray) -> np.ndarray:
        """Impedance, mmHg s/ml, at angular frequencies (rad/s) from 0 on."""
        moving = omega > 0
        spectrum = np.full(len(omega), self.steady[0], dtype=complex)
        w, (area, viscosity) = omega[moving], (values[:, np.newaxis] for values in (self.area, self.viscosity))
        if not len(w):
            return spectrum
        drag = unsteady(np.sqrt(area / np.pi * w / viscosity)) if np.all(viscosity) else np.ones((len(area), len(w)))
        inertia, compliance = self.inertia / area / drag, self.compliance[:, np.newaxis]
        characteristic = np.sqrt(inertia / compliance)
        turned = np.exp(-2j * w * self.length[:, np.newaxis] * np.sqrt(inertia * compliance))
        across = characteristic * (1 - turned) / (1 + turned)
        Z = np.empty_like(across)
        for k, two in enumerate(self.daughters):
            if two is None:
                Z[k] = across[k]
            else:
                first, second = Z[two[0]], Z[two[1]]
                load = first * second / (first + second)
                Z[k] = (load + across[k]) / (1.0 + load * across[k] / characteristic[k] ** 2)
        spectrum[moving] = Z[-1]
        return spectrum


def _ratios(exponent: float, asymmetry: float) -> tuple[float, float]:
    """Return α and β."""
    alpha = (1.0 + asymmetry ** (exponent / 2)) ** (-1.0 / exponent)
    return alpha, alpha * np.sqrt(asymmetry)


def _smallest(radii: np.ndarray) -> float:
    """Return where fits let trees end, cm: at 50 µm, or where the narrowest of them has branched a few times."""
    return float(min(StructuredTree.smallest, 0.4 * radii.min()))


def _branching(depth: float, alpha: float, beta: float) -> tuple[np.ndarray, list[tuple[int, int] | None]]:
    """Return the radii of a tree over that of its root, daughters before parents, and the rows of their daughters.

    The root is `depth` times as wide as the smallest radius.
    """
    generation, exponents = {(0, 0)}, [(0, 0)]
    while generation:
        parents = [(i, j) for i, j in generation if alpha**i * beta**j * depth > 1.0]
        generation = {daughter for i, j in parents for daughter in ((i + 1, j), (i, j + 1))}
        exponents += generation
    powers = exponents[::-1]
    row = {power: k for k, power in enumerate(powers)}
    shares = np.array([alpha**i * beta**j for i, j in powers])
    daughters = ((row.get((i + 1, j)), row.get((i, j + 1))) for i, j in powers)
    ends = shares * depth <= 1.0
    return shares, [None if end else two for end, two in zip(ends, daughters, strict=True)]  # type: ignore[misc]


def relative_viscosity(radius: np.ndarray, hematocrit: float) -> np.ndarray:
    """Viscosity of blood in vessels of a radius (cm), over that in wide ones (Pries et al. 1994, Circ. Res. 75)."""
    D = 2e4 * radius
    at_45 = 3.2 + 6.0 * np.exp(-0.085 * D) - 2.44 * np.exp(-0.06 * D**0.645)
    turn = 1.0 / (1.0 + 1e-11 * D**12)
    bend = (0.8 + np.exp(-0.075 * D)) * (turn - 1.0) + turn
    layer = (D / (D - 1.1)) ** 2
    viscosity = (1.0 + (at_45 - 1.0) * _hematocrit(bend, hematocrit) * layer) * layer
    return np.asarray(viscosity / (1.0 + 2.2 * _hematocrit(np.array(-0.8), hematocrit)))


def _hematocrit(bend: np.ndarray, hematocrit: float) -> np.ndarray:
    return np.asarray(((1.0 - hematocrit) ** bend - 1.0) / (0.55**bend - 1.0))


def unsteady(womersley: np.ndarray) -> np.ndarray:
    """Womersley's 1 - 2 J1(z)/(z J0(z)), z = i^{3/2} w: what is left of the inertia where friction is unsteady."""
    log = np.clip(np.log(womersley), *_LOGS[[0, -1]])
    return np.asarray(np.exp(_table()(log) + np.where(log == _LOGS[0], 2 * (np.log(womersley) - log), 0.0)))


_LOGS = np.linspace(np.log(1e-3), np.log(1e4), 1200)


@lru_cache(maxsize=1)
def _table() -> CubicSpline:
    z = 1j**1.5 * np.exp(_LOGS)
    exact = np.where(
        np.abs(z) < 0.05, 1j * np.abs(z) ** 2 / 8 + np.abs(z) ** 4 / 48, 1 - 2 * jve(1, z) / (z * jve(0, z))
    )
    return CubicSpline(_LOGS, np.log(exact))


def _between(coarse: bool) -> np.ndarray:
    """Return the multiples of the heart's frequency to which a few poles are fitted, or many."""
    return worth_fitting(_HARMONICS + 1) if coarse else 0.5 * np.arange(2 * _HARMONICS + 1)


@lru_cache(maxsize=32)
def _rational(beds: StructuredTree, period: float) -> Rational:
    heart, rows = 2 * np.pi / period, _between(coarse=True)
    impedance = beds.impedance(heart * rows)
    trees = [fitted(heart * rows, column, _POLES) for column in impedance.T]
    poor = misfit(impedance, joined(trees).impedance(1j * heart * rows)) > CLOSE
    if poor.any():
        fine = _between(coarse=False)
        Z = beds.impedance(heart * fine)
        fits = zip(Z.T, trees, poor, strict=True)
        trees = [refined(fine, heart, column, tree, noise=False) if bad else tree for column, tree, bad in fits]
    return joined(trees, _POLES)
