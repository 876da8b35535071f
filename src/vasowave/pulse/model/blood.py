"""Blood: density, viscosity, boundary layer, and the friction it exerts on the wall.

Every friction law here has the form ``(k0 + k1 √A) q/A``: two numbers, which the solver takes as they are.
"""

import math
from dataclasses import dataclass, field
from typing import Annotated, Literal, Protocol

from annotated_types import Ge
from pydantic import SkipValidation

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.settings import Positive, settings_class


class Friction(Protocol):
    """The right-hand side of the momentum equation is ``-(k0 + k1 √A) q/A``."""

    def coefficients(self, viscosity: float, period: float) -> tuple[float, float]:
        """Return k0 (cm²/s) and k1 (cm/s) for a kinematic viscosity (cm²/s) and a period (s)."""
        ...


def boundary_layer(viscosity: float, period: float) -> float:
    """Thickness of the viscous boundary layer δ = √(νT/2π), cm (below eq. 2).

    The paper's section 2.5 prints √(2πν/T), which is not a length; see docs/deviations.md.
    """
    return math.sqrt(viscosity * period / (2 * math.pi))


def relative_to_usual(hematocrit: float | None, temperature: float | None = None) -> float:
    """Viscosity of blood in wide vessels over that at a hematocrit of 0.45 and 37 °C.

    By the hematocrit as Pries et al. (1994, Circ. Res. 75); by the temperature (°C) as that of water, to which the
    viscosity of blood keeps its ratio (Merrill 1969, Physiol. Rev. 49). None: as usual.

    Raises
    ------
    InputError
        It is beyond those of blood, as a hematocrit in percent.
    """
    cells = 1.0
    if hematocrit is not None:
        lowest, highest = _HEMATOCRITS
        if not lowest <= hematocrit <= highest:
            raise InputError(
                f"hematocrit {hematocrit:g} is not between {lowest:g} and {highest:g}; give the share of cells, as 0.45"
            )
        cells = float((1 + 2.2 * ((1 - hematocrit) ** -0.8 - 1) / (0.55**-0.8 - 1)) / 3.2)
    if temperature is None:
        return cells
    if not _TEMPERATURES[0] <= temperature <= _TEMPERATURES[1]:
        low, high = _TEMPERATURES
        raise InputError(
            f"temperature {temperature:g} °C is not that of an animal's blood; give one of {low:g} to {high:g}"
        )
    return cells * 10 ** (_water(temperature) - _water(_USUAL))


def _water(temperature: float) -> float:
    """Logarithm of the viscosity of water over that at 20 °C (Kestin, Sokolov and Wakeham 1978)."""
    away = 20.0 - temperature
    return away / (temperature + 96.0) * (1.2364 - 1.37e-3 * away + 5.7e-6 * away**2)


_HEMATOCRITS = 0.2, 0.8
_TEMPERATURES = 20.0, 45.0  # °C
_USUAL = 37.0  # °C


@settings_class
class BoundaryLayer:
    """Flat profile with a linear boundary layer: friction 2πνr/δ · q/A (eq. 2).

    In vessels thinner than 4 δ it drags less than `Poiseuille`'s profile, which drags least of all steady ones.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Blood(friction=vw.BoundaryLayer(reference_radius=0.07)).friction
    BoundaryLayer(reference_radius=0.07)
    """

    reference_radius: Positive | None = None
    """For boundary-layer: This radius (cm) in every vessel at all times instead of the local one, √(A/π), with which
    eq. 2 is written; the paper's own fits used 0.07."""

    def coefficients(self, viscosity: float, period: float) -> tuple[float, float]:
        """Return (2πν r_ref/δ, 0) or (0, 2√π ν/δ); both vanish with the viscosity."""
        if viscosity == 0:
            return 0.0, 0.0
        delta = boundary_layer(viscosity, period)
        if self.reference_radius is not None:
            return 2 * math.pi * viscosity * self.reference_radius / delta, 0.0
        return 0.0, 2 * math.sqrt(math.pi) * viscosity / delta


@settings_class
class PowerLaw:
    """Profile u ∝ 1 - (s/r)^ζ over the cross-section: friction 2π(ζ + 2)ν · q/A.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.PowerLaw(9.0).coefficients(viscosity=0.0462, period=0.11)[0] / 0.0462  # 22π
    69.11...
    """

    exponent: Positive = 9.0
    """For power-law: Exponent ζ of the velocity profile: 2 is Poiseuille's parabola, 9 a blunt profile usual for large
    arteries. The convective term keeps the factor 1 of a flat profile, as in eq. 2."""

    def coefficients(self, viscosity: float, period: float) -> tuple[float, float]:
        """Return (2π(ζ + 2)ν, 0)."""
        return 2 * math.pi * (self.exponent + 2) * viscosity, 0.0


@dataclass(frozen=True)
class Poiseuille:
    """Parabolic profile: friction 8πν · q/A.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Poiseuille().coefficients(viscosity=0.0462, period=0.11)[0] / 0.0462  # 8π
    25.13...
    """

    def coefficients(self, viscosity: float, period: float) -> tuple[float, float]:
        """Return (8πν, 0)."""
        return 8 * math.pi * viscosity, 0.0


FrictionName = Literal["boundary-layer", "poiseuille", "power-law"]
FRICTIONS: dict[FrictionName, type] = {"boundary-layer": BoundaryLayer, "poiseuille": Poiseuille, "power-law": PowerLaw}
"""The friction laws by the name under which a study chooses them."""


_MAX_DENSITY, _MAX_VISCOSITY = 10.0, 3.0  # g/ml and cm²/s: beyond, the number is in another unit


@settings_class
class Fluid:
    """A Newtonian fluid; the defaults are the paper's averages for the blood of mice."""

    density: Positive = 1.057
    """Density ρ, g/ml."""
    viscosity: Annotated[float, Ge(0)] = 0.0462
    """Kinematic viscosity ν, cm²/s."""


@settings_class
class Blood(Fluid):
    """Blood as a Newtonian fluid; the defaults are the paper's averages for mice.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Blood(density=1.06, friction=vw.Poiseuille())
    Blood(density=1.06, viscosity=0.0462, friction=Poiseuille())
    """

    friction: SkipValidation[Friction] = field(default_factory=BoundaryLayer)
    """Friction law: `BoundaryLayer` (eq. 2), `Poiseuille` or `PowerLaw`."""

    def __post_init__(self) -> None:
        """Check the friction law, and density and viscosity for another unit."""
        if not hasattr(self.friction, "coefficients"):
            raise InputError(f"{self.friction!r} is no friction law; use BoundaryLayer(), PowerLaw(9) or Poiseuille()")
        if self.density > _MAX_DENSITY:
            raise InputError(f"density {self.density:g} g/ml is no liquid's; of kg/m³ write a thousandth")
        if self.viscosity > _MAX_VISCOSITY:
            raise InputError(f"viscosity {self.viscosity:g} cm²/s is no blood's (kinematic, 0.03 to 0.1); 4 mPa s at "
                             "1.06 g/ml are 0.038 cm²/s")  # fmt: skip

    @property
    def inertia(self) -> float:
        """Density in the units of the model, mmHg s²/cm²."""
        return self.density / units.MMHG
