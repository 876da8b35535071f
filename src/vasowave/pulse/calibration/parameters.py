"""The parameters that are fitted, the wall law's and the outlets' factors: their bounds, and the model they make.

Whatever a law, a model or the solver says of numbers that cannot be, a search's trial of them has failed.
"""

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vasowave.base.descriptions import Parameter
from vasowave.base.errors import InputError, NumericalError, VasowaveError
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.laws import bed_factors, find_bed, find_law, parameter_name, wall_parameters
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.names import ParameterName, joined, resolved
from vasowave.pulse.model.nominal import Nominal
from vasowave.pulse.model.outlets import Bed
from vasowave.pulse.model.parameters import model_fields
from vasowave.pulse.model.walls import VISCOSITY, WALL_VISCOSITY
from vasowave.pulse.network.network import Network

IMPOSSIBLE_ERRORS = (VasowaveError, ArithmeticError, ValueError)
"""What numbers that cannot be may end in; the last two come from laws of users, built-in ones return NaN."""


def fitted_parameters(
    wall: str | type, bed: str | type = "windkessel", viscous: bool | None = None
) -> dict[ParameterName, Parameter]:
    """Return every parameter of a fit by its name: the wall law's, the factors of the beds, the wall's viscosity.

    Raises
    ------
    InputError
        An unknown wall law or bed, or two parameters of one name.
    """
    viscosity = {WALL_VISCOSITY: VISCOSITY} if viscous else {}
    return joined(wall_parameters(find_law(wall)), bed_factors(find_bed(bed)), viscosity)


@dataclass(frozen=True, eq=False)
class ParameterSpace:
    """The parameters of one fit; searches move in the logarithms of the free ones.

    Attributes
    ----------
    law : type
        Class of the wall law.
    parameters : dict of ParameterName to Parameter
        All of them: the wall's, the outlets' factors and, where walls are viscous, their viscosity.
    nominal, lower, upper : array, shape (parameter,)
        In the units of the parameters.
    free : bool array, shape (parameter,)
        False where a parameter is held at its nominal or given value.
    """

    law: Any
    parameters: dict[ParameterName, Parameter]
    nominal: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    free: np.ndarray
    network: Network
    outlets: Bed
    blood: Blood
    outlet_pressure: float
    outlet_pulsation: np.ndarray | None = None

    @property
    def names(self) -> tuple[ParameterName, ...]:
        """Names of all parameters."""
        return tuple(self.parameters)

    def names_of(self, owner: str) -> tuple[ParameterName, ...]:
        """Names of the parameters of the ``wall``, in the order of its fields, or of the factors of the ``bed``."""
        return tuple(name for name in self.names if name.owner == owner)

    @property
    def shared(self) -> tuple[ParameterName, ...]:
        """The two factors of the beds between which the recording splits one resistance, if there are two."""
        bed = type(self.outlets)
        return tuple(parameter_name(bed, name) for name in bed.bed().shared or ())

    @property
    def free_names(self) -> tuple[ParameterName, ...]:
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
        fields = model_fields(dict(zip(self.names, values, strict=True)), self.law, self.outlets)
        return Model(self.network, blood=self.blood, outlet_pressure=self.outlet_pressure,
                     outlet_pulsation=self.outlet_pulsation, **fields)  # fmt: skip


@dataclass(frozen=True)
class ParameterLimits:
    """Bounds of parameters, values that are held, whether other bounds are the paper's, whether the wall is viscous."""

    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    fixed: Mapping[str, float] = field(default_factory=dict)
    paper_bounds: bool = False
    viscous: bool | None = None


def parameter_space(
    wall: str | type, network: Network, nominal: Nominal, blood: Blood, limits: ParameterLimits = ParameterLimits()
) -> ParameterSpace:
    """Return the parameters of a fit.

    Raises
    ------
    InputError
        An unknown wall or parameter, bounds that are not positive and ordered, or nothing left to fit.
    """
    law, parameters = find_law(wall), fitted_parameters(wall, type(nominal.outlets), limits.viscous)
    owner = f"the {law.law().name} wall"
    bounds, fixed = resolved(limits.bounds, parameters, owner), resolved(limits.fixed, parameters, owner)
    spans = {
        name: bounds.get(name) or _span(parameter, nominal, limits.paper_bounds)
        for name, parameter in parameters.items()
    }
    for name, (low, high) in spans.items():
        if not 0 < low < high < math.inf:
            raise InputError(f"bounds of {name}: {low:g} to {high:g}; they must be positive and ordered")
    for held, value in fixed.items():
        if not (math.isfinite(value) and value > 0):
            raise InputError(f"{held} cannot be held at {value:g}; it must be positive")
    free = np.array(
        [name not in fixed and (not parameter.held or name in bounds) for name, parameter in parameters.items()]
    )
    if not free.any():
        raise InputError("every parameter is held fixed; leave at least one free, or use simulate")
    values = [
        fixed.get(name, parameter.nominal * parameter.scale(nominal.beta)) for name, parameter in parameters.items()
    ]
    lower, upper = np.array(list(spans.values()), dtype=float).T
    return ParameterSpace(law, parameters, np.array(values), lower, upper, free, network, nominal.outlets, blood,
                 nominal.outlet_pressure, nominal.outlet_pulsation)  # fmt: skip


def _span(parameter: Parameter, nominal: Nominal, paper: bool) -> tuple[float, float]:
    low, high = parameter.limits(paper)
    unit = parameter.scale(nominal.beta)
    return low * unit, high * unit


@contextmanager
def trial() -> Iterator[None]:
    """Raise `NumericalError`, with the reason, for whatever parameters that cannot be end in inside the block."""
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused where it is used
            yield
    except NumericalError:
        raise
    except VasowaveError as error:
        raise NumericalError(str(error)) from error
    except IMPOSSIBLE_ERRORS as error:
        raise NumericalError(f"these parameters make no model ({type(error).__name__}: {error})") from error
