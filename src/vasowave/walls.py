"""Wall laws: how transmural pressure and cross-sectional area belong together.

A wall law is one `NamedTuple` class whose fields are its parameters (numbers, or one value per vessel) and whose
static methods are its equations, written in the area ratio ``a = A/A0`` with NumPy functions. The same lines serve
arrays here and single cells inside the compiled solver, so a third law is one more class in this file.
"""

from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

Values = float | np.ndarray


def tangent(x: Values) -> Values:
    """Tangent for |x| < π/2; the compiled solver takes its own, see `solver.trigonometry`."""
    return np.tan(x)


def arctangent(x: Values) -> Values:
    """Arctangent; the compiled solver takes its own, see `solver.trigonometry`."""
    return np.arctan(x)


@runtime_checkable
class Wall(Protocol):
    """What the solver and the analyses ask of a wall law; every method takes the law's parameters last."""

    _fields: tuple[str, ...]

    @staticmethod
    def pressure_at(a: Values, *parameters: Values) -> Values:
        """Pressure, mmHg, at area ratio a."""
        ...

    @staticmethod
    def ratio_at(p: Values, *parameters: Values) -> Values:
        """Area ratio at pressure p."""
        ...

    @staticmethod
    def slope_at(p: Values, *parameters: Values) -> Values:
        """Derivative of the area ratio, 1/mmHg, at pressure p."""
        ...

    @staticmethod
    def limits(*parameters: Values) -> tuple[Values, Values]:
        """Area ratios between which the law holds."""
        ...

    @staticmethod
    def wave_speed_squared_at_rest(inertia: float, *parameters: Values) -> Values:
        """c0², cm²/s², at p = 0 (eq. 33)."""
        ...


class LinearWall(NamedTuple):
    """Linear elastic wall, p = β (√(A/A0) - 1) (eq. 3).

    Attributes
    ----------
    beta : float or array, shape (vessel,)
        Stiffness β = Eh/((1-κ²) r0), mmHg.
    """

    beta: Values

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

    @staticmethod
    def wave_speed_squared_at_rest(inertia: float, beta: Values) -> Values:
        """c0² = β/(2ρ), cm²/s² (eq. 33)."""
        return beta / (2.0 * inertia)


class TangentWall(NamedTuple):
    """Nonlinear wall that stiffens with pressure, p = p1 tan(π/γ (A/A0 - 1)) (eq. 4).

    Attributes
    ----------
    p1 : float or array, shape (vessel,)
        Half-width pressure, mmHg, as in eq. 4. (The paper's table of optima lists π times this number.)
    gamma : float or array, shape (vessel,)
        Scale γ of the largest area, A∞ = (1 + γ/2) A0 (eq. 5).
    """

    p1: Values
    gamma: Values

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

    @staticmethod
    def wave_speed_squared_at_rest(inertia: float, p1: Values, gamma: Values) -> Values:
        """c0² = π p1/(γρ), cm²/s² (eq. 33)."""
        return np.pi * p1 / (gamma * inertia)


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


def largest_area(wall: Wall, area0: Values) -> Values:
    """Area A∞ at infinite pressure, cm² (eq. 5); infinite for the linear law."""
    return area0 * wall.limits(*_parameters(wall))[1]


def _parameters(wall: Wall) -> tuple[np.ndarray, ...]:
    return tuple(np.asarray(value, dtype=float) for value in wall)  # type: ignore[attr-defined]
