"""Options of `fit`, from the settings of a study."""

from collections.abc import Collection, Mapping
from typing import Annotated, Any, get_args, get_origin

import typer
from pydantic import BaseModel

from vasowave.cli.options import flag, help_of
from vasowave.findings import Place
from vasowave.study.document import Document
from vasowave.study.problems import refuse
from vasowave.study.reading import validated
from vasowave.study.settings import StudyFile
from vasowave.study.template import written

_NOT_FOR_ONE = ("title", "animals", "groups")
"""Keys of a study file that say nothing of a single animal."""


class GivenOptions(Document):
    """Settings given as options; their places are the options' names."""

    def place(self, path: Any, key: bool = False) -> Place:
        """Return the option that the value at `path` was given with."""
        words = [str(part) for part in path if str(part) not in self.values]
        return Place(part=flag((words or list(path))[0]))


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


def study_options(leave: Collection[str] = ()) -> dict[str, Any]:
    """Return the annotation of an option for every setting of one animal's study but those to `leave` out."""
    return {key: _study_option(section, key, field) for section, key, field in _keys() if key not in leave}


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
    default, name = field.get_default(call_default_factory=True), flag(key)
    shown: dict[str, Any] = {"help": help_of(field.description or ""), "rich_help_panel": section or "more",
                             "show_default": _shown(default)}  # fmt: skip
    if isinstance(default, bool):
        return Annotated[bool | None, typer.Option(f"{name}/--no-{name[2:]}", **shown)]
    if isinstance(default, dict):
        return Annotated[list[str] | None, typer.Option(name, metavar="NAME=VALUE", **shown)]
    return Annotated[str | None, typer.Option(name, metavar="VALUE", **shown)]


def _shown(default: Any) -> str | bool:
    if default is None or default == {}:
        return False
    return ",".join(map(str, default)) if isinstance(default, list | tuple) else written(default)


def _value(field: Any, given: Any) -> Any:
    """Return what stands in a study file for the text of an option; ``low:high`` and ``one,other`` are lists."""
    if isinstance(given, list):  # one mapping, whose entries were given one by one
        pairs = [text.partition("=") for text in given]
        return {name.strip(): _list(value, ":") if ":" in value else value for name, _, value in pairs}
    return _list(given, ",") if isinstance(given, str) and _holds_several(field.annotation) else given


def _holds_several(annotation: Any) -> bool:
    return get_origin(annotation) in (tuple, list) or any(map(_holds_several, get_args(annotation)))


def _list(text: str, separator: str) -> list[str]:
    return [part.strip() for part in text.split(separator)]
