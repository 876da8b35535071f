"""Wall laws: how transmural pressure and cross-sectional area belong together.

A law is one `NamedTuple` class: its fields are its parameters (numbers, or one value per vessel), its static
methods are its equations, written in the area ratio ``a = A/A0`` with NumPy functions, and `law` says in words, symbols
and bounds what they are. The same lines serve arrays here and single cells inside the compiled solver, and no other
file knows which laws there are: a further law is one more class in `BUILT_IN`, or in a file of your own (`laws`).
"""

from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

from vasowave.base.descriptions import Law, Parameter, Quantity
from vasowave.pulse.model.names import ParameterName

Values = float | np.ndarray


def tangent(x: Values) -> Values:
    """Tangent for |x| < π/2; the compiled solver takes its own, see `solver.powers`."""
    return np.tan(x)


def arctangent(x: Values) -> Values:
    """Arctangent; the compiled solver takes its own, see `solver.powers`."""
    return np.arctan(x)


def power(x: Values, m: Values) -> Values:
    """x^m for x > 0; the compiled solver takes its own, see `solver.powers`."""
    return x**m


def collapsed(y: Values) -> Values:
    """Solve a^10 - a^-3/2 = y by Newton's method for log(a^10 + [-y]) = log(a^-3/2 + [y]), which is nearly straight.

    The brackets are positive parts. It begins with the slope at y = 0; five steps are exact to double precision.
    """
    over, under = np.maximum(y, 0.0), np.maximum(-y, 0.0)
    a = power(1.0 + 10.0 / 11.5 * over, 0.1) * power(1.0 + 1.5 / 11.5 * under, -2.0 / 3.0)
    for _ in range(5):
        wide, flat = power(a, 10.0), power(a, -1.5)
        slope = 10.0 * wide / (wide + under) + 1.5 * flat / (flat + over)
        a = a * power((flat + over) / (wide + under), 1.0 / slope)
    return a


@runtime_checkable
class Wall(Protocol):
    """What the solver and the analyses ask of a wall law; every equation takes the law's parameters last."""

    _fields: tuple[str, ...]

    @staticmethod
    def law() -> Law:
        """Return what is said of the law."""

    @staticmethod
    def pressure_at(a: Values, *parameters: Values) -> Values:
        """Pressure, mmHg, at area ratio a."""

    @staticmethod
    def ratio_at(p: Values, *parameters: Values) -> Values:
        """Area ratio at pressure p."""

    @staticmethod
    def slope_at(p: Values, *parameters: Values) -> Values:
        """Derivative of the area ratio, 1/mmHg, at pressure p."""

    @staticmethod
    def limits(*parameters: Values) -> tuple[Values, Values]:
        """Area ratios between which the law holds."""


class LinearWall(NamedTuple):
    """Linear elastic wall, p = β (√(A/A0) - 1) (eq. 3).

    Attributes
    ----------
    beta : float or array, shape (vessel,)
        Stiffness β = Eh/((1-κ²) r0), mmHg.

    Examples
    --------
    >>> import vasowave as vw
    >>> float(vw.walls.pressure(vw.LinearWall(beta=60.0), area=1.21, area0=1.0))  # 10 % wider
    6.0...
    """

    beta: Values

    @staticmethod
    def law() -> Law:
        """Return what is said of the law; the paper keeps β between β0 and 2.5 β0."""
        beta = Parameter("mmHg", "β", "wall stiffness", "3", 1.0, (0.2, 20.0), (1.0, 2.5))
        return Law("linear", "linear elastic", "p = β (√(A/A₀) − 1)", "3", (beta,), "beta")

    @staticmethod
    def pressure_at(a: Values, beta: Values) -> Values:
        """Pressure, mmHg, at area ratio a (eq. 3)."""
        return beta * (np.sqrt(a) - 1.0)

    @staticmethod
    def ratio_at(p: Values, beta: Values) -> Values:
        """Area ratio at pressure p: eq. 3 solved for A/A0."""
        s = 1.0 + p / beta
        return s * s

    @staticmethod
    def slope_at(p: Values, beta: Values) -> Values:
        """d(A/A0)/dp, 1/mmHg: eqs. 26, 27 per unit of A0 L."""
        return 2.0 / beta * (1.0 + p / beta)

    @staticmethod
    def limits(beta: Values) -> tuple[Values, Values]:
        """Area ratios between which the law holds: any positive one."""
        return 0.0 * beta, 0.0 * beta + np.inf


class TangentWall(NamedTuple):
    """Nonlinear wall that stiffens with pressure, p = p1 tan(π/γ (A/A0 - 1)) (eq. 4).

    Attributes
    ----------
    p1 : float or array, shape (vessel,)
        Half-width pressure, mmHg, as in eq. 4. (The paper's table of optima lists π times this number.)
    gamma : float or array, shape (vessel,)
        Scale γ of the largest area, A∞ = (1 + γ/2) A0 (eq. 5).

    Examples
    --------
    >>> import vasowave as vw
    >>> float(vw.walls.stiffness(vw.TangentWall(p1=7.0, gamma=4.0)))  # 2π p1/γ (eq. 24)
    10.99...
    """

    p1: Values
    gamma: Values

    @staticmethod
    def law() -> Law:
        """Return what is said of the law; nominally γ = 2 and p1 = β0/π, with the linear law's c0 (eq. 10)."""
        p1 = Parameter(
            "mmHg", "p_1", "half-width pressure of the wall", "4", 1 / np.pi, (0.02, 20.0), (0.5 / np.pi, 2.0)
        )
        gamma = Parameter("1", "γ", "scale of the largest area", "4", 2.0, (0.3, 6 * np.pi), (1.0, 2 * np.pi))
        stiffness = Quantity("mmHg", "p_1/γ", "wall stiffness of the tangent law", "10")
        formula = "p = p₁ tan(π/γ (A/A₀ − 1))"
        return Law(
            "tangent", "stiffening tangent", formula, "4", (p1, gamma), "p1_over_gamma", ("p1_over_gamma", stiffness)
        )

    @staticmethod
    def pressure_at(a: Values, p1: Values, gamma: Values) -> Values:
        """Pressure, mmHg, at area ratio a (eq. 4)."""
        return p1 * tangent(np.pi / gamma * (a - 1.0))

    @staticmethod
    def ratio_at(p: Values, p1: Values, gamma: Values) -> Values:
        """Area ratio at pressure p: eq. 4 solved for A/A0."""
        return 1.0 + gamma / np.pi * arctangent(p / p1)

    @staticmethod
    def slope_at(p: Values, p1: Values, gamma: Values) -> Values:
        """d(A/A0)/dp, 1/mmHg: eqs. 26, 27 per unit of A0 L."""
        return gamma / np.pi * p1 / (p1 * p1 + p * p)

    @staticmethod
    def limits(p1: Values, gamma: Values) -> tuple[Values, Values]:
        """Area ratios between which the law holds: the poles of the tangent, the upper one at A∞ (eq. 5)."""
        return np.maximum(0.0, 1.0 - 0.5 * gamma), 1.0 + 0.5 * gamma


class PowerWall(NamedTuple):
    """Wall whose stiffening is a number, p = β/(2m) ((A/A0)^m - 1): the power law of the field's tube laws.

    m = 1/2 is the linear wall (eq. 3), m = 1 a straight line between area and pressure; larger m stiffens. Below p = 0,
    where the formula would collapse at -β/(2m), the law goes on as the linear wall, with the same slope at p = 0.

    Attributes
    ----------
    beta : float or array, shape (vessel,)
        Stiffness β at p = 0, mmHg.
    m : float or array, shape (vessel,)
        Exponent.

    Examples
    --------
    >>> import vasowave as vw
    >>> wall = vw.PowerWall(beta=60.0, m=1.0)
    >>> round(float(wall.ratio_at(15.0, *wall)), 12)  # 1 + 2 m p/beta
    1.5
    """

    beta: Values
    m: Values

    @staticmethod
    def law() -> Law:
        """Return what is said of the law; nominally it is the linear one."""
        beta = Parameter("mmHg", "β", "wall stiffness", "", 1.0, (1e-4, 20.0))
        m = Parameter("1", "m", "exponent of the wall", "", 0.5, (0.05, 50.0))
        return Law("power", "power", "p = β/(2m) ((A/A₀)^m − 1)", "", (beta, m), linear_at=("m", 0.5))

    @staticmethod
    def pressure_at(a: Values, beta: Values, m: Values) -> Values:
        """Pressure, mmHg, at area ratio a."""
        stretched = beta / (2.0 * m) * (power(np.maximum(a, 1.0), m) - 1.0)
        return stretched + beta * (np.sqrt(np.minimum(a, 1.0)) - 1.0)

    @staticmethod
    def ratio_at(p: Values, beta: Values, m: Values) -> Values:
        """Area ratio at pressure p; one of the two factors is 1."""
        compressed = 1.0 + np.minimum(p, 0.0) / beta
        return power(1.0 + 2.0 * m * np.maximum(p, 0.0) / beta, 1.0 / m) * compressed * compressed

    @staticmethod
    def slope_at(p: Values, beta: Values, m: Values) -> Values:
        """d(A/A0)/dp, 1/mmHg."""
        stretched = 1.0 + 2.0 * m * np.maximum(p, 0.0) / beta
        return 2.0 / beta * power(stretched, 1.0 / m) / stretched * (1.0 + np.minimum(p, 0.0) / beta)

    @staticmethod
    def limits(beta: Values, m: Values) -> tuple[Values, Values]:
        """Area ratios between which the law holds: any positive one."""
        return 0.0 * beta, 0.0 * beta + np.inf


class VeinWall(NamedTuple):
    """Wall that collapses under negative pressure, p = β/23 ((A/A0)^10 - (A/A0)^-3/2): the tube law of veins.

    The exponents are those of Müller and Toro (2014, Int. J. Numer. Meth. Biomed. Eng. 30, 681); -3/2 is that of a tube
    pressed flat (Shapiro 1977, J. Biomech. Eng. 99, 126). β is the stiffness at p = 0, so that a vein, an artery and
    their waves compare by one number.

    Attributes
    ----------
    beta : float or array, shape (vessel,)
        Stiffness β at p = 0, mmHg.

    Examples
    --------
    >>> import vasowave as vw
    >>> wall = vw.VeinWall(beta=23.0)
    >>> round(float(wall.ratio_at(-7.0, *wall)), 3)  # (A/A0)^-3/2 is nearly 7
    0.273
    """

    beta: Values

    @staticmethod
    def law() -> Law:
        """Return what is said of the law; nominally it is as stiff at p = 0 as the linear one."""
        beta = Parameter("mmHg", "β", "wall stiffness", "", 1.0, (1e-3, 20.0))
        return Law("vein", "collapsible", "p = β/23 ((A/A₀)^10 − (A/A₀)^(−3/2))", "", (beta,), lowest=-np.inf)

    @staticmethod
    def pressure_at(a: Values, beta: Values) -> Values:
        """Pressure, mmHg, at area ratio a."""
        return beta / 23.0 * (power(a, 10.0) - power(a, -1.5))

    @staticmethod
    def ratio_at(p: Values, beta: Values) -> Values:
        """Area ratio at pressure p."""
        return collapsed(23.0 * p / beta)

    @staticmethod
    def slope_at(p: Values, beta: Values) -> Values:
        """d(A/A0)/dp, 1/mmHg."""
        a = collapsed(23.0 * p / beta)
        return 23.0 / beta * a / (10.0 * power(a, 10.0) + 1.5 * power(a, -1.5))

    @staticmethod
    def limits(beta: Values) -> tuple[Values, Values]:
        """Area ratios between which the law holds: any positive one."""
        return 0.0 * beta, 0.0 * beta + np.inf


def pressure(wall: Wall, area: Values, area0: Values) -> Values:
    """Transmural pressure p, mmHg (eqs. 3 and 4), at cross-sectional area A (cm²); arrays broadcast, vessels last."""
    return wall.pressure_at(np.asarray(area) / area0, *_parameters(wall))


def area(wall: Wall, pressure: Values, area0: Values) -> Values:
    """Cross-sectional area A, cm², at transmural pressure p (mmHg); arrays broadcast, vessels last."""
    return area0 * wall.ratio_at(pressure, *_parameters(wall))


def area_compliance(wall: Wall, pressure: Values, area0: Values) -> Values:
    """Area compliance dA/dp, cm²/mmHg (eqs. 25 to 27 without the length), at transmural pressure p (mmHg)."""
    return area0 * wall.slope_at(pressure, *_parameters(wall))


def wave_speed(wall: Wall, pressure: Values, inertia: float) -> Values:
    """Pulse wave velocity c = √(A/ρ · dp/dA), cm/s (eqs. 31 and 32), at transmural pressure p (mmHg).

    Parameters
    ----------
    wall : Wall
    pressure : float or array
        mmHg; vessels on the last axis where the wall has one value per vessel.
    inertia : float
        Density in mmHg s²/cm², see `Blood.inertia`.
    """
    k = _parameters(wall)
    return np.sqrt(wall.ratio_at(pressure, *k) / (inertia * wall.slope_at(pressure, *k)))


def wave_speed_at_rest(wall: Wall, inertia: float) -> Values:
    """Wave speed c0, cm/s, at p = 0 (eq. 33): √(β/(2ρ)) of the linear law, √(π p1/(γρ)) of the tangent law."""
    return 1.0 / np.sqrt(inertia * wall.slope_at(0.0, *_parameters(wall)))


def stiffness(wall: Wall) -> Values:
    """Stiffness β, mmHg, of the linear law that a law becomes at small strain: 2π p1/γ of the tangent law (eq. 24)."""
    return 2.0 / wall.slope_at(0.0, *_parameters(wall))


def _parameters(wall: Wall) -> tuple[np.ndarray, ...]:
    return tuple(np.asarray(value, dtype=float) for value in wall)  # type: ignore[attr-defined]


WALL_VISCOSITY = ParameterName("model", "wall_viscosity")
"""Name by which the viscosity of walls is fitted."""

VISCOSITY = Parameter("mmHg s", "η_w", "viscosity of the wall", "", 0.002, (1e-6, 1.0), spread=2.0)
"""That of `Model.wall_viscosity`, with any law. An artery of a mouse that lost a tenth of what it stores would have
0.002 s times its stiffness; hardly anything is known of it beforehand."""

BUILT_IN: tuple[Any, ...] = (LinearWall, TangentWall, PowerWall, VeinWall)
"""The laws of this file."""
