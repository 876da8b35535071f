"""The model that values of parameters make: what fits, posteriors, sweeps and sliders all go through."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.pulse.model.laws import bed_factors, parameter_names, wall_parameters
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.names import ParameterName, joined, resolved
from vasowave.pulse.model.outlets import Bed, Outlets
from vasowave.pulse.model.walls import VISCOSITY, WALL_VISCOSITY

_SIZES = {ParameterName("network", name): "1" for name in ("radius", "length")}


def model_fields(values: Mapping[ParameterName, Any], law: Any, beds: Outlets) -> dict[str, Any]:
    """Return wall, outlets and viscosity of a model, as `Model` takes them.

    Parameters
    ----------
    values : mapping of ParameterName to float or array
        Those of the wall law in the order of its fields, the factors of the beds in theirs, and the wall's viscosity
        where it is not 0; what belongs to none of them does not count.
    law : type
        Class of the wall law.
    beds : Outlets
        The beds that factors are of.
    """
    wall, factors = ([value for name, value in values.items() if name.owner == owner] for owner in ("wall", "bed"))
    outlets = beds.scaled(*factors) if factors and isinstance(beds, Bed) else beds
    return {"wall": law(*wall), "outlets": outlets, "wall_viscosity": values.get(WALL_VISCOSITY, 0.0)}


def model_values(model: Model) -> dict[ParameterName, Any]:
    """Return the values of a model's wall, its viscosity, and 1 as the factor of each field of its beds."""
    wall = zip(parameter_names(type(model.wall)), model.wall, strict=True)
    return dict(wall) | dict.fromkeys(_factor_names(model), 1.0) | {WALL_VISCOSITY: model.wall_viscosity}


def with_parameters(model: Model, values: Mapping[str, Any], beds: Outlets | None = None) -> Model:
    """Return a model with other values of its parameters.

    Parameters
    ----------
    model : Model
        What has no value stays as it is here.
    values : mapping of str to float or array
        By the names of `model_values` or `changeable`, short or in full. Those of beds are factors.
    beds : Outlets, optional
        The beds that factors are of; by default the model's.

    Raises
    ------
    InputError
        An unknown parameter, or a model that cannot be.
    """
    values = resolved(values, joined(changeable(model), dict.fromkeys(_factor_names(model))), "this model")
    network, factors = model.network, {*_factor_names(model)}
    if sizes := {name.field: getattr(network, name) * values[name] for name in _SIZES if name in values}:
        network = replace(network, **sizes)
    fitted = {name: values.get(name, value) for name, value in model_values(model).items()
              if name not in factors or factors & values.keys()}  # fmt: skip
    fields = model_fields(fitted, type(model.wall), model.outlets if beds is None else beds)
    if totals := {name: values[name] for name in _totals(model) if name in values}:
        fields["outlets"] = fields["outlets"].with_totals(network.flow_fraction[network.terminals], totals)
    return model.changed(network=network, **fields)


def changed_model(model: Model, values: Mapping[str, float]) -> Model:
    """Return a model with other values of the parameters that `sweep` names.

    Raises
    ------
    InputError
        An unknown parameter, a value that is not positive, or a model that cannot be.
    """
    return with_parameters(model, {name: float(value[0]) for name, value in checked_values(model, values).items()})


def checked_values(model: Model, values: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return sequences of values by the names of `changeable`; raises as `changed_model`."""
    return {
        name: _checked(name, sequence) for name, sequence in resolved(values, changeable(model), "this model").items()
    }


def _checked(name: str, sequence: Any) -> np.ndarray:
    values = np.atleast_1d(np.asarray(sequence, dtype=float))
    allowed = np.isfinite(values) & ((values > 0) | ((values == 0) & (name == WALL_VISCOSITY)))  # 0: an elastic wall
    if values.ndim != 1 or not len(values) or not np.all(allowed):
        listed = ", ".join(f"{value:g}" for value in values.ravel()) or "none"
        raise InputError(f"{name}: give positive numbers, not {listed}")
    if name == "a" and values.max() >= 1:
        raise InputError(f"a: {values.max():g}; R1 is a part of the total resistance, so a lies below 1")
    return values


def changeable(model: Model) -> dict[str, str]:
    """Return what `sweep` can change of a model, and its unit, by name."""
    walls = {name: parameter.unit for name, parameter in wall_parameters(type(model.wall)).items()}
    return joined(walls, _totals(model), _SIZES, {WALL_VISCOSITY: VISCOSITY.unit})


def _totals(model: Model) -> dict[str, str]:
    return model.outlets.knobs() if isinstance(model.outlets, Bed) else {}


def _factor_names(model: Model) -> tuple[ParameterName, ...]:
    return tuple(bed_factors(type(model.outlets))) if isinstance(model.outlets, Bed) else ()
