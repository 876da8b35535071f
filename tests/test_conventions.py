"""What holds in every module: numbers are explained where a reader finds them, values do not change."""

import dataclasses
import difflib
import inspect

import constants
import vasowave
from approval import approve
from vasowave.settings import settings_of

STATEFUL = {"Objective", "_Stages", "Document", "GivenOptions"}  # what counts or searches, piece by piece


def test_the_documentation_lists_every_number_that_was_chosen_with_the_value_in_force():
    listed, found = constants.PAGE.read_text(encoding="utf-8").splitlines(), constants.page().splitlines()
    changed = [line for line in difflib.ndiff(listed, found) if line[0] in "-+"] if listed != found else []
    assert changed == [], "run `uv run python tools/constants.py` and read what it changes in docs/"


def test_values_cannot_be_changed_after_they_were_made():
    changing = {
        name
        for module in constants.modules()
        for name, kind in inspect.getmembers(module, dataclasses.is_dataclass)
        if kind.__module__ == module.__name__ and not kind.__dataclass_params__.frozen
    }
    assert changing == STATEFUL


def test_approved_what_the_public_names_take_and_what_stands_where_nothing_is_given():
    approve("interface", (line for name in vasowave.__all__ for line in described(name)))


def described(name):
    thing = getattr(vasowave, name)
    if not callable(thing):
        return
    yield f"{name}: " + ", ".join(inspect.signature(thing).parameters)
    for setting, (_, default, _) in settings_of(thing).items():
        yield f"  {setting} = {shown(default)}"
    for inner, method in inspect.getmembers(thing, inspect.isfunction) if inspect.isclass(thing) else ():
        if not inner.startswith("_"):
            given = inspect.signature(method).parameters.values()
            yield f"  .{inner}: " + ", ".join(str(one).partition(":")[0] + default_of(one) for one in given)


def default_of(parameter):
    return "" if parameter.default is parameter.empty else f" = {shown(parameter.default)}"


def shown(value):
    """Values of ours by their parts, functions by their names: nothing that differs from one run to the next."""
    return value.__name__ if callable(value) and hasattr(value, "__name__") else repr(value)
