"""What holds in every module: values do not change."""

import dataclasses
import inspect
from typing import get_args, get_type_hints

import numpy as np
import pytest

import constants
import vasowave
from approval import approve
from vasowave.base import Accessor
from vasowave.catheter.signals import RawRecording
from vasowave.lung.read import Volume
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import control_network
from vasowave.pulse.model import LAWS, LinearWall, one_per_vessel

STATEFUL = {"Objective", "_Searches", "Valleys", "ResponseValleys", "CorrectedNetwork", "_BehindInstrument", "_Places",
            "Document", "GivenOptions"}  # fmt: skip
"""What counts, searches or keeps, piece by piece."""


def test_values_cannot_be_changed_after_they_were_made():
    changing = {
        name
        for module in constants.modules()
        for name, kind in inspect.getmembers(module, dataclasses.is_dataclass)
        if kind.__module__ == module.__name__ and not kind.__dataclass_params__.frozen
    }
    assert changing == STATEFUL


@pytest.mark.parametrize(
    "value",
    [
        Recording(
            np.full(64, 14.0) + np.arange(64), np.ones(64), 0.11, pressure_error=np.ones(3), flow_error=np.ones(3)
        ),
        RawRecording(np.arange(600.0), np.ones(600), sampling_rate=500.0, ecg=np.ones(600)),
        Volume(np.arange(27.0).reshape(3, 3, 3), np.ones(3), np.zeros(3)),
        control_network(),
        one_per_vessel(LinearWall(57.0), ("a", "b"), "wall"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_the_arrays_of_a_value_cannot_be_changed(value):
    names = getattr(value, "_fields", ()) or [field.name for field in dataclasses.fields(value)]
    arrays = [one for one in (getattr(value, name) for name in names) if isinstance(one, np.ndarray)]
    assert arrays
    assert not any(array.flags.writeable for array in arrays)


def test_approved_what_is_said_of_the_parameters_of_every_wall_law():
    approve("laws", (f"{name}: {one}" for name, kind in LAWS.items() for one in kind.law()))


def test_approved_what_the_public_names_take_and_what_stands_where_nothing_is_given():
    approve("interface", (line for name in vasowave.__all__ for line in described(name)))


def described(name):
    thing = getattr(vasowave, name)
    if not callable(thing):
        return
    yield f"{name}: " + ", ".join(inspect.signature(thing).parameters)
    kinds = get_type_hints(thing, include_extras=True)
    for setting, default in defaults(thing).items():
        yield f"  {setting}{limits(kinds[setting])} = {shown(default)}"
    for inner, method in inspect.getmembers(thing, is_method) if inspect.isclass(thing) else ():
        if not inner.startswith("_"):
            given = inspect.signature(method).parameters.values()
            yield f"  .{inner}: " + ", ".join(str(one).partition(":")[0] + default_of(one) for one in given)


def is_method(member):
    return inspect.isfunction(member) or isinstance(member, Accessor)


def defaults(thing):
    if dataclasses.is_dataclass(thing):
        given = ((one.name, one.default, one.default_factory) for one in dataclasses.fields(thing))
        made = {name: value if factory is dataclasses.MISSING else factory() for name, value, factory in given}
        return {name: value for name, value in made.items() if value is not dataclasses.MISSING}
    given = inspect.signature(thing).parameters.values()
    return {one.name: one.default for one in given if one.default is not one.empty}


def limits(kind):
    """What an annotation demands of a number, also of one that may be left out."""
    demanded = [one for part in (kind, *get_args(kind)) for one in getattr(part, "__metadata__", ())]
    said = ", ".join(repr(one) for one in demanded if type(one).__module__ == "annotated_types")
    return f" ({said})" if said else ""


def default_of(parameter):
    return "" if parameter.default is parameter.empty else f" = {shown(parameter.default)}"


def shown(value):
    """Values of ours by their parts, functions by their names: nothing that differs from one run to the next."""
    return value.__name__ if callable(value) and hasattr(value, "__name__") else repr(value)
