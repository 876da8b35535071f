"""Settings: each is declared once, by the function or dataclass that uses it, and read from there.

Type and limits of a setting stand in its annotation, its default in the signature, its meaning and unit in the numpydoc
docstring. The study file with its schema, template and table in the documentation, and the options of the command line,
are all made from what `settings_of` finds.
"""

import inspect
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from functools import cache
from types import NoneType, UnionType
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    Literal,
    NamedTuple,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from annotated_types import Ge, Gt, Le, Lt

from vasowave.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Dataclass = TypeVar("Dataclass", bound="DataclassInstance")

_SECTION = re.compile(r"^(?:Parameters|Attributes)\n-+\n(.*?)(?=^\S[^\n]*\n-+$|\Z)", re.MULTILINE | re.DOTALL)
_ENTRY = re.compile(r"^(\S[^\n:]*?)(?: :[^\n]*)?\n((?:^ +[^\n]*\n?)+)", re.MULTILINE)  # "name : type", then its meaning


@dataclass(frozen=True)
class Check:
    """A condition on a value that limits do not say: a function that returns the value or raises `InputError`."""

    function: Callable[[Any], Any]
    schema: Callable[[], dict[str, Any]] = dict

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Return the check for pydantic, which calls this by name."""
        from pydantic_core import core_schema

        return core_schema.no_info_after_validator_function(self.function, handler(source))

    def __get_pydantic_json_schema__(self, inner: Any, handler: Any) -> Any:
        """Return what an editor may know of the condition."""
        return handler(inner) | self.schema()


@dataclass(frozen=True)
class Text:
    """How a value is read where it comes as text: by a function of one text, or of `several`."""

    read: Callable[[Any], Any]
    several: bool = False


def ordered(pair: tuple[float, float]) -> tuple[float, float]:
    """Return a pair whose first number is below the second; else raise `InputError`."""
    if not pair[0] < pair[1]:
        raise InputError(f"{pair[0]:g} is not below {pair[1]:g}; give the lower value first")
    return pair


Positive = Annotated[float, Gt(0)]
Range = Annotated[tuple[Positive, Positive], Check(ordered)]


class Setting(NamedTuple):
    """One setting: its annotation, default, and meaning with unit."""

    kind: Any
    default: Any
    meaning: str


def settings_of(owner: Callable[..., Any]) -> dict[str, Setting]:
    """Return the settings that a function or dataclass takes, by name; arguments without a default are none."""
    return dict(_settings_of(owner))


@cache
def _settings_of(owner: Callable[..., Any]) -> dict[str, Setting]:
    kinds, meanings = get_type_hints(owner, include_extras=True), _meanings(owner)
    return {name: Setting(kinds[name], value, meanings.get(name, "")) for name, value in _defaults(owner).items()}


def with_settings(values: Dataclass, settings: Mapping[str, Any]) -> Dataclass:
    """Return a dataclass instance with some settings given by name; `InputError` for a name that it does not have."""
    known = [one.name for one in fields(values)]
    if wrong := next((name for name in settings if name not in known), None):
        hint = did_you_mean(wrong, known)
        raise InputError(f"there is no setting '{wrong}'{hint}; choose from: {', '.join(known)}")
    return replace(values, **settings)


def check_settings(values: Any) -> None:
    """Raise `InputError` if a field of the dataclass instance `values` is not what its annotation allows."""
    for name, setting in settings_of(type(values)).items():
        try:
            _check(setting.kind, getattr(values, name))
        except InputError as error:
            raise InputError(f"{name}: {error}") from None


def _check(kind: Any, value: Any) -> None:
    """Raise `InputError` if a value is not of an annotated kind. Types that are none of ours are left alone."""
    origin, inner = get_origin(kind), get_args(kind)
    if origin is Annotated:
        _check(inner[0], value)
        for condition in inner[1:]:
            _check_condition(condition, value)
    elif origin in (Union, UnionType):
        if value is not None or NoneType not in inner:
            _check(next(one for one in inner if one is not NoneType), value)
    elif origin is Literal:
        if value not in inner:
            known = ", ".join(f"'{one}'" for one in inner)
            raise InputError(f"unknown '{value}'{did_you_mean(str(value), map(str, inner))}; choose from {known}")
    elif origin is tuple:
        for i, one in enumerate(value):
            _check(inner[0] if inner[-1] is ... else inner[i], one)
    elif origin is not None and issubclass(origin, Mapping):
        for name, one in value.items():
            _check(inner[0], name)
            _check(inner[1], one)
    elif kind in (int, float) and (isinstance(value, str | None) or not math.isfinite(value)):
        raise InputError(f"{value!r} is not a number")


def _check_condition(condition: Any, value: Any) -> None:
    if isinstance(condition, Check):
        condition.function(value)
    elif isinstance(condition, Ge) and not value >= condition.ge:
        raise InputError(f"{value:g} is too small; at least {condition.ge}")
    elif isinstance(condition, Gt) and not value > condition.gt:
        raise InputError(f"{value:g} is too small; it must be above {condition.gt}")
    elif isinstance(condition, Le) and not value <= condition.le:
        raise InputError(f"{value:g} is too large; at most {condition.le}")
    elif isinstance(condition, Lt) and not value < condition.lt:
        raise InputError(f"{value:g} is too large; it must be below {condition.lt}")


def _defaults(owner: Callable[..., Any]) -> dict[str, Any]:
    if is_dataclass(owner):
        made = {one.name: one.default_factory() for one in fields(owner) if one.default_factory is not MISSING}
        plain = {one.name: one.default for one in fields(owner) if one.default is not MISSING}
        return {one.name: (made | plain)[one.name] for one in fields(owner) if one.name in made | plain}
    given = inspect.signature(owner).parameters.values()
    return {one.name: one.default for one in given if one.default is not inspect.Parameter.empty}


def _meanings(owner: Any) -> dict[str, str]:
    """Return what the docstring says of each argument or attribute; a class inherits what its bases say."""
    meanings: dict[str, str] = {}
    for one in reversed(inspect.getmro(owner)) if inspect.isclass(owner) else (owner,):
        text = inspect.cleandoc(one.__doc__ or "")
        section = _SECTION.search(text)
        for names, meaning in _ENTRY.findall(section[1] if section else ""):
            meanings |= dict.fromkeys(names.split(", "), " ".join(meaning.split()))
    return meanings
