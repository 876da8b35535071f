"""The parameters that are fitted: their nominal values, bounds, and the model that they make."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from vasowave.blood import Blood
from vasowave.errors import InputError, did_you_mean
from vasowave.model import Model
from vasowave.network import Network
from vasowave.nominal import Nominal
from vasowave.outlets import Windkessel
from vasowave.walls import LinearWall, TangentWall

FACTORS = ("r1", "r2", "c1")
"""Factors of all R1, R2 and C of the nominal Windkessels."""

UNITS = {"beta": "mmHg", "p1": "mmHg", "gamma": "1", "r1": "1", "r2": "1", "c1": "1"}

_FACTOR_BOUNDS_PAPER = dict.fromkeys(FACTORS, (0.05, 2.5, False))
_FACTOR_BOUNDS_WIDE = {"r1": (0.002, 10.0, False), "r2": (0.05, 10.0, False), "c1": (0.02, 20.0, False)}

PAPER_BOUNDS: dict[str, tuple[float, float, bool]] = {
    "beta": (1.0, 2.5, True),
    "p1": (1 / (2 * math.pi), 2.0, True),
    "gamma": (1.0, 2 * math.pi, False),
    **_FACTOR_BOUNDS_PAPER,
}
"""The paper's bounds (Table "Bounds"): lower, upper, and whether they multiply β0."""

WIDE_BOUNDS: dict[str, tuple[float, float, bool]] = {
    "beta": (0.2, 20.0, True),
    "p1": (0.02, 20.0, True),
    "gamma": (0.3, 6 * math.pi, False),
    **_FACTOR_BOUNDS_WIDE,
}
"""Bounds that only keep the search among possible animals; three published optima lie outside the paper's."""

_WALLS: dict[str, Any] = {"linear": LinearWall, "tangent": TangentWall}


def parameter_names(wall: str) -> tuple[str, ...]:
    """Return the names of all parameters of a fit with the wall law "linear" or "tangent"."""
    return (*_WALLS[wall]._fields, *FACTORS)


@dataclass(frozen=True, eq=False)
class Space:
    """The parameters of one fit; searches move in the logarithms of the free ones.

    Attributes
    ----------
    wall : type
        LinearWall or TangentWall.
    names : tuple of str
        All parameters: the wall's, then r1, r2, c1.
    nominal, lower, upper : array, shape (parameter,)
        In the units of `UNITS`.
    free : bool array, shape (parameter,)
        False where a parameter is held at its nominal or given value.
    """

    wall: Any
    names: tuple[str, ...]
    nominal: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    free: np.ndarray
    network: Network
    outlets: Windkessel
    blood: Blood

    @property
    def free_names(self) -> tuple[str, ...]:
        """Names of the free parameters."""
        return tuple(name for name, free in zip(self.names, self.free, strict=True) if free)

    @property
    def log_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Logarithms of the free parameters' bounds."""
        return np.log(self.lower[self.free]), np.log(self.upper[self.free])

    def values(self, x: np.ndarray) -> np.ndarray:
        """Return all parameters for the logarithms `x` of the free ones."""
        values = self.nominal.copy()
        values[self.free] = np.exp(x)
        return values

    def model(self, values: np.ndarray) -> Model:
        """Return the model that all parameters together make."""
        count = len(self.names) - len(FACTORS)
        r1, r2, c1 = values[count:]
        outlets = Windkessel(r1 * self.outlets.R1, r2 * self.outlets.R2, c1 * self.outlets.C)
        return Model(self.network, self.wall(*values[:count]), outlets, self.blood)


def parameter_space(
    wall: str,
    network: Network,
    nominal: Nominal,
    blood: Blood,
    bounds: Mapping[str, tuple[float, float]],
    fixed: Mapping[str, float],
    paper_bounds: bool,
) -> Space:
    """Return the parameters of a fit.

    Raises
    ------
    InputError
        An unknown wall or parameter, bounds that are not positive and ordered, or nothing left to fit.
    """
    if wall not in _WALLS:
        raise InputError(f"unknown wall law '{wall}'{did_you_mean(wall, _WALLS)}; choose from: {', '.join(_WALLS)}")
    law = nominal.linear_wall if wall == "linear" else nominal.tangent_wall
    names = parameter_names(wall)
    for name in (*bounds, *fixed):
        if name not in names:
            raise InputError(
                f"the {wall} wall has no parameter '{name}'{did_you_mean(name, names)}; it has: {', '.join(names)}"
            )
    values = np.array([*(float(v) for v in law), 1.0, 1.0, 1.0])
    table = PAPER_BOUNDS if paper_bounds else WIDE_BOUNDS
    lower, upper = np.empty(len(names)), np.empty(len(names))
    for i, name in enumerate(names):
        low, high, times_beta0 = table[name]
        unit = nominal.beta if times_beta0 else 1.0
        lower[i], upper[i] = bounds.get(name, (low * unit, high * unit))
        if not 0 < lower[i] < upper[i] < math.inf:
            raise InputError(f"bounds of {name}: {lower[i]:g} to {upper[i]:g}; they must be positive and ordered")
        if name in fixed:
            if not (math.isfinite(fixed[name]) and fixed[name] > 0):
                raise InputError(f"{name} cannot be held at {fixed[name]:g}; it must be positive")
            values[i] = fixed[name]
    free = np.array([name not in fixed for name in names])
    if not free.any():
        raise InputError("every parameter is held fixed; leave at least one free, or use simulate")
    return Space(_WALLS[wall], names, values, lower, upper, free, network, nominal.outlets, blood)
