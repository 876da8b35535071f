"""What of a model can be changed by a factor, and the model that factors make."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vasowave.base.errors import InputError, did_you_mean
from vasowave.pulse.model.laws import bed_factors
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.outlets import Bed, Outlets
from vasowave.pulse.model.parameters import model_values, with_parameters
from vasowave.pulse.model.walls import WALL_VISCOSITY

OF_HEART = ("HR", "CO")
"""Factors of what drives the vessels."""
_SIZES, _BEDS = ("radius", "length"), "R_T"


def changeable_factors(model: Model) -> list[str]:
    """Return the names of the factors that `predict` takes for a model."""
    walls, beds = _factor_names(model)
    return [*walls, *beds, *([_BEDS] if _resistances(model.outlets, beds) else []), *_SIZES, *OF_HEART]


def _factor_names(model: Model) -> tuple[dict[str, Any], list[str]]:
    """Return the values of the wall law, and the names of the factors of the beds."""
    walls = {str(name): value for name, value in model_values(model).items() if name.owner == "wall"}
    walls.pop(str(WALL_VISCOSITY), None)
    return walls, [str(name) for name in bed_factors(type(model.outlets))] if isinstance(model.outlets, Bed) else []


def with_factors(model: Model, factors: Mapping[str, float]) -> Model:
    """Return a model whose parameters are multiplied."""
    walls, beds = _factor_names(model)
    resistances = _resistances(model.outlets, beds)
    values: dict[str, Any] = {}
    for name, factor in factors.items():
        if name == _BEDS and resistances:
            values |= {bed: factor * values.get(bed, 1.0) for bed in resistances}
        elif name in walls:
            values[name] = factor * np.asarray(walls[name])
        elif name in _SIZES or name in beds:
            values[name] = factor * values.get(name, 1.0)
        else:
            allowed = changeable_factors(model)
            raise InputError(
                f"'{name}' cannot be changed{did_you_mean(name, allowed)}; there are: {', '.join(allowed)}"
            )
    return with_parameters(model, values) if values else model


def _resistances(outlets: Outlets, factors: list[str]) -> list[str]:
    """Return the factors of beds that change their resistance."""
    if not isinstance(outlets, Bed):
        return []
    moved = [outlets.scaled(*(1.1 if name == factor else 1.0 for factor in factors)) for name in factors]
    total = outlets.total_resistance()
    return [name for name, beds in zip(factors, moved, strict=True) if beds.total_resistance() > 1.001 * total]
