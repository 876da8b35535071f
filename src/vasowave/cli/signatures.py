"""Signatures that typer makes options of: given parameters, and the fields of dataclasses."""

import dataclasses
import functools
import inspect
from collections.abc import Callable, Mapping
from contextvars import ContextVar
from typing import Any, get_type_hints

VERBOSE: ContextVar[bool] = ContextVar("VERBOSE", default=False)
"""Whether the user asked for details (-v)."""

TYPED: ContextVar[Mapping[str, object] | None] = ContextVar("TYPED", default=None)
"""The options of columns that were typed; None of a command that has none."""

OPTIONS: ContextVar[frozenset[str] | None] = ContextVar("OPTIONS", default=None)
"""The options of the command that runs; None where none does."""


def with_parameters(function: Callable[..., None], parameters: list[inspect.Parameter]) -> Callable[..., None]:
    """Give a function the parameters that typer makes options of."""
    function.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    function.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return function


def with_option_groups(command: Callable[..., None]) -> Callable[..., None]:
    """Let every field of the dataclasses that a command takes be an option, in the order of the fields."""
    hints = get_type_hints(command, include_extras=True)
    groups: dict[str, Any] = {name: hint for name, hint in hints.items() if dataclasses.is_dataclass(hint)}
    parameters = [
        option.replace(kind=inspect.Parameter.KEYWORD_ONLY)
        for parameter in inspect.signature(command).parameters.values()
        for option in (
            inspect.signature(groups[parameter.name]).parameters.values() if parameter.name in groups else (parameter,)
        )
    ]

    @functools.wraps(command)
    def called(**options: Any) -> None:
        values = {
            name: group(**{field.name: options.pop(field.name) for field in dataclasses.fields(group)})
            for name, group in groups.items()
        }
        command(**options, **values)

    return with_parameters(called, parameters)
