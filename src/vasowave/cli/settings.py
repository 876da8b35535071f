"""Options of a command made from the fields of a dataclass, so that a setting is defined once."""

from collections.abc import Callable, Mapping
from dataclasses import fields
from inspect import Parameter, signature
from typing import Annotated, Any, Literal, get_args, get_origin

import typer


def with_settings(settings: type, names: Mapping[str, tuple[str, ...]] | None = None) -> Callable[..., Any]:
    """Return a decorator that puts one option for each field of `settings` in the place of ``**given``.

    A field is annotated with its help and whether it comes as text to be read ("place", "region") or as several such
    texts ("places"), see `imaging.options.Setting`; `names` has the options that are not called like their field.
    """

    def decorated(command: Callable[..., Any]) -> Callable[..., Any]:
        shape = signature(command)
        own = [entry for entry in shape.parameters.values() if entry.kind is not Parameter.VAR_KEYWORD]
        made = [_parameter(entry, (names or {}).get(entry.name, ())) for entry in fields(settings)]
        command.__signature__ = shape.replace(parameters=[*own, *made])  # type: ignore[attr-defined]
        return command

    return decorated


def _parameter(entry: Any, names: tuple[str, ...]) -> Parameter:
    kind, setting = get_args(entry.type)
    option: Any = Annotated[_given_as(kind, setting.read), typer.Option(*names, help=setting.help)]
    return Parameter(entry.name, Parameter.KEYWORD_ONLY, default=entry.default, annotation=option)


def _given_as(kind: Any, read: str) -> Any:
    """Return the type that a terminal can give for a setting of type `kind`."""
    if read:
        return list[str] | None if read == "places" else str | None
    return str if get_origin(kind) is Literal else kind
