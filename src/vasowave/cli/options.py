"""Options of a command, one for every setting, with the default and the meaning that the setting itself states."""

import inspect
from collections.abc import Mapping
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin

import typer
from pydantic import BaseModel
from typer.main import get_command

from vasowave.imaging.options import Options
from vasowave.settings import Setting, Text, settings_of
from vasowave.study.document import Document
from vasowave.study.problems import refuse
from vasowave.study.reading import validated
from vasowave.study.settings import StudyFile
from vasowave.study.template import written

_NOT_FOR_ONE = ("title", "animals", "species", "groups")
"""Keys of a study file that say nothing of a single animal."""


class GivenOptions(Document):
    """Settings given as options; their places are the options' names."""

    def place(self, path: Any, key: bool = False) -> str:
        """Return the option that the value at `path` was given with."""
        words = [str(part) for part in path if str(part) not in self.values]
        return _flag((words or list(path))[0])


def with_settings(name: str, command: Any) -> Any:
    """Return a command with an option for every setting; its function is called with them as one mapping, `given`."""
    function = command.callback.__wrapped__
    own = [one for one in inspect.signature(function).parameters.values() if one.name != "given"]
    options = _image_options() if name == "extract" else _study_options()

    def called(**arguments: Any) -> None:
        given = {key: arguments.pop(key) for key in options}
        function(**arguments, given={key: value for key, value in given.items() if value not in (None, [])})

    parameters = [inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=kind)
                  for key, kind in options.items()]  # fmt: skip
    called.__signature__ = inspect.Signature([*own, *parameters])  # type: ignore[attr-defined]
    called.__annotations__ = {one.name: one.annotation for one in [*own, *parameters]}
    called.__doc__ = function.__doc__
    single = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    single.command(name, epilog=command.epilog)(called)
    return get_command(single)


def read_image_options(given: Mapping[str, Any]) -> Options:
    """Return what was `given` as options for an extraction.

    Raises
    ------
    InputError
        A value that cannot be read or contradicts another.
    """
    texts = {name: _text(one.kind) for name, one in settings_of(Options).items()}
    return Options(**{name: reader.read(given[name]) if (reader := texts[name]) else given[name] for name in given})


def read_settings(given: Mapping[str, Any], title: str, group: str) -> StudyFile:
    """Return the settings of a study of one group, with those that were `given` as options.

    Raises
    ------
    InputError
        Everything that is wrong in them, each with its option.
    """
    values: dict[str, Any] = {"title": title, "groups": [group]}
    for section, key, field in _keys():
        if key in given:
            (values.setdefault(section, {}) if section else values)[key] = _value(field, given[key])
    document = GivenOptions("options", values)
    settings = validated(document)
    refuse(document.problems)
    assert settings is not None
    return settings


def _image_options() -> dict[str, Any]:
    return {name: _image_option(name, one) for name, one in settings_of(Options).items()}


def _image_option(name: str, one: Setting) -> Any:
    text, several = _text(one.kind), ["--outlet"] if name == "outlets" else []
    kind: Any = _plain(one.kind) if text is None else list[str] if text.several else str
    shown = False if one.default is None else str(one.default)
    return Annotated[kind | None, typer.Option(*several, _flag(name), help=_help(one.meaning), show_default=shown)]


def _text(kind: Any) -> Text | None:
    """Return how a value of an annotated kind is read from text; None where the terminal's own reading serves."""
    return next((one for inner in (kind, *get_args(kind)) for one in get_args(inner) if isinstance(one, Text)), None)


def _plain(kind: Any) -> Any:
    """Return the bare type of a setting; a choice of words is text, which the setting's own check refuses best."""
    inner = [one for one in get_args(kind) if one is not NoneType]
    if get_origin(kind) is Literal:
        return str
    return _plain(inner[0]) if inner else kind


def _study_options() -> dict[str, Any]:
    return {key: _study_option(section, key, field) for section, key, field in _keys()}


def _keys() -> list[tuple[str, str, Any]]:
    """Return section (empty for the top level), name and field of every setting of a study."""
    keys = []
    for name, field in StudyFile.model_fields.items():
        section = field.annotation
        if isinstance(section, type) and issubclass(section, BaseModel):
            keys += [(name, key, inner) for key, inner in section.model_fields.items()]
        elif name not in _NOT_FOR_ONE:
            keys.append(("", name, field))
    return keys


def _study_option(section: str, key: str, field: Any) -> Any:
    default, flag = field.get_default(call_default_factory=True), _flag(key)
    shown: dict[str, Any] = {"help": _help(field.description or ""), "rich_help_panel": section or "more",
                             "show_default": _shown(default)}  # fmt: skip
    if isinstance(default, bool):
        return Annotated[bool | None, typer.Option(f"{flag}/--no-{flag[2:]}", **shown)]
    if isinstance(default, dict):
        return Annotated[list[str] | None, typer.Option(flag, metavar="NAME=VALUE", **shown)]
    return Annotated[str | None, typer.Option(flag, metavar="VALUE", **shown)]


def _flag(name: Any) -> str:
    return f"--{str(name).replace('_', '-')}"


def _help(meaning: str) -> str:
    return meaning.replace("[", r"\[")


def _shown(default: Any) -> str | bool:
    if default is None or default == {}:
        return False
    return ",".join(map(str, default)) if isinstance(default, list | tuple) else written(default)


def _value(field: Any, given: Any) -> Any:
    """Return what stands in a study file for the text of an option; ``low:high`` and ``one,other`` are lists."""
    if isinstance(given, list):  # one mapping, whose entries were given one by one
        pairs = [text.partition("=") for text in given]
        return {name.strip(): _list(value, ":") if ":" in value else value for name, _, value in pairs}
    several = get_origin(field.annotation) in (tuple, list)
    return _list(given, ",") if several and isinstance(given, str) else given


def _list(text: str, separator: str) -> list[str]:
    return [part.strip() for part in text.split(separator)]
