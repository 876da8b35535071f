"""Options of `extract`, from the settings of an extraction."""

from collections.abc import Mapping
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin

import typer

from vasowave.cli.options import flag, help_of
from vasowave.imaging.options import Options
from vasowave.settings import Setting, Text, settings_of


def read_image_options(given: Mapping[str, Any]) -> Options:
    """Return what was `given` as options for an extraction.

    Raises
    ------
    InputError
        A value that cannot be read or contradicts another.
    """
    texts = {name: _text(one.kind) for name, one in settings_of(Options).items()}
    return Options(**{name: reader.read(given[name]) if (reader := texts[name]) else given[name] for name in given})


def image_options() -> dict[str, Any]:
    """Return the annotation of an option for every setting of an extraction."""
    return {name: _image_option(name, one) for name, one in settings_of(Options).items()}


def _image_option(name: str, one: Setting) -> Any:
    text, several = _text(one.kind), ["--outlet"] if name == "outlets" else []
    kind: Any = _plain(one.kind) if text is None else list[str] if text.several else str
    shown = False if one.default is None else str(one.default)
    return Annotated[kind | None, typer.Option(*several, flag(name), help=help_of(one.meaning), show_default=shown)]


def _text(kind: Any) -> Text | None:
    """Return how a value of an annotated kind is read from text; None where the terminal's own reading serves."""
    return next((one for inner in (kind, *get_args(kind)) for one in get_args(inner) if isinstance(one, Text)), None)


def _plain(kind: Any) -> Any:
    """Return the bare type of a setting; a choice of words is text, which the setting's own check refuses best."""
    inner = [one for one in get_args(kind) if one is not NoneType]
    if get_origin(kind) is Literal:
        return str
    return _plain(inner[0]) if inner else kind
