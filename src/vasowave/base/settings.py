"""Settings: each is declared once, as a typed field of a class, and everything else is made from that declaration.

Type and limits of a setting stand in its annotation, its default behind it, its meaning and unit in the docstring
below::

    @settings_class
    class Search:
        starts: Annotated[int, Ge(1), Le(1000)] = 20
        \"\"\"Starts of each fit.\"\"\"

The constructor checks the values. The study file with its schema, template and table in the documentation, and the
options of the command line, are made from what `settings_of` finds.
"""

import ast
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from functools import cache, wraps
from itertools import pairwise
from textwrap import dedent
from typing import (
    Annotated,
    Any,
    Literal,
    NamedTuple,
    TypeVar,
    dataclass_transform,
    get_args,
    get_origin,
    get_type_hints,
)

from annotated_types import Gt
from pydantic import ConfigDict, TypeAdapter, ValidationError
from pydantic_core import ArgsKwargs, core_schema

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.faces import PARSING
from vasowave.base.findings import ITSELF, Finding, FindingKind, error_kind

Values = TypeVar("Values")

_RULES = ConfigDict(extra="forbid", allow_inf_nan=False, arbitrary_types_allowed=True)


def _error(name: str, text: str, remedy: str) -> FindingKind:
    return error_kind(f"setting.{name}", f"{{key}}: {text}", remedy)


_A_NUMBER = "write one"
EMPTY = _error("empty", "the value is empty; {remedy}", "give one or leave it out")
MISSING_VALUE = _error("missing", "there is no value; {remedy}", "give one")
EMPTY_CHOICE = _error("empty-choice", "the value is empty; {remedy}", "choose from: {known}")
UNKNOWN_WORD = _error("unknown-word", "'{given}' is not known{hint}; {remedy}", "choose from: {known}")
WRONG = _error("wrong", "{text}", ITSELF)
UNKNOWN_KEY = error_kind("setting.unknown-key", "unknown key '{key}'{hint}; {remedy}", "known here: {known}")
AT_ODDS = error_kind("setting.at-odds", "{text}", ITSELF)
DECIMAL_COMMA = _error("decimal-comma", "{given} is not a number; {remedy}", "write a decimal point")
NOT_VALID = _error("not-valid", "{given}: {why}; {remedy}", "correct the value")
_NO_WHOLE = _error("no-whole-number", "{given} is not a whole number; {remedy}", _A_NUMBER)
_NO_NUMBER = _error("no-number", "{given} is not a number; {remedy}", _A_NUMBER)
_NO_TRUTH = _error("neither-true-nor-false", "{given} is neither true nor false; {remedy}", "write one of the two")
_NO_PAIR = _error("no-pair", "{remedy}", "write a list of two numbers: {form}")
_TOO_MANY = _error("too-many", "{actual_length} values are too many at once; {remedy}", "at most {max_length:g}")
_NO_LIST = _error("no-list", "{remedy}", "write a list: {form}")
_NO_SECTION = _error("no-section", "{remedy}", "write its keys in indented lines 'key: value' below")
_NO_NAMES = _error("no-names", "{remedy}", "write 'name: value' in indented lines below, or {{name: value}}")
_CODES = {
    **dict.fromkeys(("int_parsing", "int_from_float", "int_type"), _NO_WHOLE),
    **dict.fromkeys(("float_parsing", "float_type"), _NO_NUMBER),
    **dict.fromkeys(("bool_parsing", "bool_type"), _NO_TRUTH),
    **dict.fromkeys(("list_type", "tuple_type"), _NO_LIST),
    **dict.fromkeys(("too_long", "missing"), _NO_PAIR),
    **dict.fromkeys(("dict_type", "mapping_type"), _NO_NAMES),
    "dataclass_type": _NO_SECTION,
    "int_parsing_size": _error("too-large", "{given} is too large; {remedy}", _A_NUMBER),
    "string_type": _error("no-text", "{given} is not text; {remedy}", "put it between quotation marks"),
    "string_too_short": _error("empty-text", "{given} is empty; {remedy}", "write a text, or leave the key out"),
    "string_too_long": _error("long-text", "{given} is too long; {remedy}", "at most {max_length:g} letters"),
    "too_short": _error("too-few", "{remedy}", "at least {min_length:g} must be given"),
    "finite_number": _error("not-finite", "{given} is not a number; {remedy}", "give a finite one"),
    "greater_than": _error("not-above", "{given} is too small; {remedy}", "it must be above {gt:g}"),
    "greater_than_equal": _error("below-least", "{given} is too small; {remedy}", "at least {ge:g}"),
    "less_than": _error("not-below", "{given} is too large; {remedy}", "it must be below {lt:g}"),
    "less_than_equal": _error("above-most", "{given} is too large; {remedy}", "at most {le:g}"),
}
"""By pydantic's codes."""

_MAX_LETTERS = 80  # of a value in a message
_LONGEST_PAIR = 3  # values that stand together, the coordinates of a place; what may hold more is a list

_OF_SHAPE = (_NO_SECTION, _NO_NAMES, _NO_LIST, _NO_PAIR)
"""What is said of an empty value, too."""


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def settings_class(cls: type[Values]) -> type[Values]:
    """Make a class of settings: a frozen dataclass whose constructor raises `InputError` for what it does not allow."""
    made: Any = dataclass(frozen=True)(cls)

    @wraps(made.__init__)
    def checked(self: Any, /, *args: Any, **kwargs: Any) -> None:
        try:
            _adapter(made).validator.validate_python(ArgsKwargs(args, kwargs), self_instance=self)
        except ValidationError as error:
            raise InputError(_sentence(made, error.errors(include_url=False)[0])) from None

    made.__init__, made.__pydantic_config__ = checked, _RULES
    return made


@dataclass(frozen=True)
class Check:
    """A condition on a value that limits do not say: a function that returns the value or raises `InputError`."""

    function: Callable[[Any], Any]
    schema: Callable[[], dict[str, Any]] = dict

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Return the check for pydantic, which calls this by name."""
        return core_schema.no_info_after_validator_function(self.function, handler(source))

    def __get_pydantic_json_schema__(self, inner: Any, handler: Any) -> Any:
        """Return what an editor may know of the condition."""
        return handler(inner) | self.schema()


@dataclass(frozen=True, eq=False)
class Example:
    """A value that shows how a setting is written."""

    value: Any


@dataclass(frozen=True, eq=False)
class Names:
    """The names that a setting may have; its docstring lists them where it says {names}."""

    words: Callable[[], Iterable[str]]


def ordered(pair: tuple[float, float]) -> tuple[float, float]:
    """Return a pair whose first number is below the second; else raise `InputError`."""
    if not pair[0] < pair[1]:
        raise InputError(f"{pair[0]:g} is not below {pair[1]:g}; give the lower value first")
    return pair


Positive = Annotated[float, Gt(0)]
Range = Annotated[tuple[Positive, Positive], Check(ordered)]


class Setting(NamedTuple):
    """One setting: its annotation, default, meaning with unit, and an example where its form needs one."""

    kind: Any
    default: Any
    meaning: str
    example: Any = None

    @property
    def section(self) -> type | None:
        """The class of settings that it holds, if it is a section of others."""
        return self.kind if is_dataclass(self.kind) and isinstance(self.kind, type) else None


def settings_of(owner: type) -> Mapping[str, Setting]:
    """Return the settings that a class declares or inherits, by name."""
    return _settings_of(owner)


@cache
def _settings_of(owner: Any) -> Mapping[str, Setting]:
    kinds, meanings = get_type_hints(owner, include_extras=True), _meanings(owner)
    settings = {}
    for attribute in fields(owner):
        metadata = getattr(kinds[attribute.name], "__metadata__", ())
        examples = [annotation.value for annotation in metadata if isinstance(annotation, Example)]
        names = ", ".join(
            name for annotation in metadata if isinstance(annotation, Names) for name in annotation.words()
        )
        default = attribute.default if attribute.default_factory is MISSING else attribute.default_factory()
        meaning = meanings.get(attribute.name, "").replace("{names}", names)
        settings[attribute.name] = Setting(kinds[attribute.name], default, meaning, *examples)
    return settings


def given_values(owner: type[Values], base: Any, changes: Mapping[str, Any]) -> Values:
    """Return settings of a class: those that `base`, an instance of it or of a base, says, then `changes` by name.

    Raises
    ------
    InputError
        A value that its setting does not allow; a name that is none of them; `base` is something else.
    """
    if base is None:
        return owner(**changes)
    kind: type = type(base)
    if is_dataclass(kind) and issubclass(owner, kind):
        return owner(**{name: getattr(base, name) for name in settings_of(kind)} | dict(changes))
    raise InputError(f"{base!r} is no {owner.__name__}; give its settings by name: {', '.join(settings_of(owner))}")


def summary(owner: type) -> str:
    """Return the first paragraph of a class's docstring."""
    return " ".join(inspect.cleandoc(owner.__doc__ or "").partition("\n\n")[0].split())


def read_values(owner: type[Values], values: Mapping[str, Any]) -> Values | list[tuple[tuple[Any, ...], bool, Finding]]:
    """Return an instance of a class of settings made from values, which may be text, as a file has them.

    Or everything that is wrong with them: where it is, whether the key is meant and not the value, and what it is.
    """
    kind: Any = owner
    try:
        return _adapter(kind).validate_python(values)
    except ValidationError as error:
        wrong = error.errors(include_url=False)
        return [
            (problem["loc"], problem["type"] == "unexpected_keyword_argument", _finding(owner, problem))
            for problem in wrong
        ]


def is_true(value: Any) -> bool:
    """Whether the value of a setting, which may be text as a file has it, is true; what is no truth value is not."""
    try:
        return _adapter(bool).validate_python(value)
    except ValidationError:
        return False


def schema_of(owner: type) -> dict[str, Any]:
    """Return the JSON schema of a class of settings, with what every setting means."""
    schema = _adapter(owner).json_schema()
    _describe(schema, owner)
    for name, inner in schema.get("$defs", {}).items():
        kind = next(
            setting.section
            for setting in settings_of(owner).values()
            if setting.section and setting.section.__name__ == name
        )
        _describe(inner, kind)
    return schema


def unknown_word(path: Sequence[Any], value: Any, words: Sequence[str]) -> Finding:
    """Return what is said of a word that a setting does not know."""
    hint = did_you_mean(str(value), words)
    return UNKNOWN_WORD(key=_name(path), given=str(value), hint=hint, known=", ".join(words))


@cache
def _adapter(owner: Any) -> TypeAdapter[Any]:
    return TypeAdapter(owner)


def _describe(schema: dict[str, Any], owner: type) -> None:
    schema["description"] = summary(owner)
    for name, setting in settings_of(owner).items():
        schema["properties"][name] |= {"description": setting.meaning} if setting.meaning else {}


def _meanings(owner: type) -> dict[str, str]:
    """Return the docstring below every field of a class and its bases."""
    meanings: dict[str, str] = {}
    for cls in reversed(owner.__mro__[:-1]):
        try:
            with PARSING:
                (tree,) = ast.parse(dedent(inspect.getsource(cls))).body
        except OSError:  # made while the program runs, and so without docstrings
            continue
        for statement, below in pairwise(tree.body if isinstance(tree, ast.ClassDef) else ()):
            if (
                isinstance(statement, ast.AnnAssign)
                and isinstance(statement.target, ast.Name)
                and isinstance(below, ast.Expr)
            ):
                meanings[statement.target.id] = " ".join(ast.literal_eval(below.value).split())
    return meanings


def _sentence(owner: type, error: Mapping[str, Any]) -> str:
    if error["type"] == "unexpected_keyword_argument":
        name, names = str(error["loc"][-1]), list(settings_of(owner))
        return f"there is no setting '{name}'{did_you_mean(name, names)}; choose from: {', '.join(names)}"
    return str(_finding(owner, error))


def _finding(owner: type, refused: Mapping[str, Any]) -> Finding:
    """Return what is wrong with a value, from what pydantic says of it."""
    path, code, value, context = list(refused["loc"]), refused["type"], refused["input"], refused.get("ctx", {})
    named = [*settings_of(owner)]
    if path and isinstance(path[0], int) and path[0] < len(named):
        path[0] = named[path[0]]  # a value that was given by its place
    key = _name(path)
    if code == "unexpected_keyword_argument":
        return _unknown_key(owner, path)
    if code == "literal_error":
        words = list(_words(_kind_at(owner, path)))
        return EMPTY_CHOICE(key=key, known=", ".join(words)) if value is None else unknown_word(path, value, words)
    if code == "value_error":
        return WRONG(key=key, text=str(context["error"])) if path else AT_ODDS(text=str(context["error"]))
    if code == "missing" and isinstance(path[-1], str):  # a whole setting, and no part of a pair
        return MISSING_VALUE(key=key)
    kind = _CODES.get(code, NOT_VALID)
    if code == "too_long" and context["max_length"] > _LONGEST_PAIR:
        return _TOO_MANY(key=key, actual_length=len(value), max_length=context["max_length"])
    if value is None and kind not in _OF_SHAPE:
        return EMPTY(key=key)
    if code == "float_parsing" and isinstance(value, str) and "," in value:
        return DECIMAL_COMMA(key=key, given=_shown(value))
    limits = {name: limit for name, limit in context.items() if isinstance(limit, int | float)}
    if kind in (_NO_PAIR, _NO_LIST):
        form = "[lower, upper]" if kind is _NO_PAIR else "[one, other]"
        return kind(key=key, form=_list_at(owner, path) or form)
    return kind(key=key, given=_shown(value), **limits | ({"why": str(refused["msg"])} if kind is NOT_VALID else {}))


def _shown(value: Any) -> str:
    if isinstance(value, str):
        return f"'{value if len(value) <= _MAX_LETTERS else value[:_MAX_LETTERS] + '…'}'"
    return f"{value:g}" if isinstance(value, float) else str(value) if isinstance(value, int) else "the value"


def _unknown_key(owner: type, path: list[Any]) -> Finding:
    key, inner = str(path[-1]), owner
    for name in path[:-1]:
        inner = settings_of(inner)[name].section or inner
    hint = did_you_mean(key, settings_of(inner))
    elsewhere = [
        name for name, setting in settings_of(owner).items() if setting.section and key in settings_of(setting.section)
    ]
    if not hint and elsewhere:
        hint = f" here; it belongs under '{elsewhere[0]}:'"
    elif not hint and key in settings_of(owner):
        hint = " here; it belongs to the top level, without indentation"
    return UNKNOWN_KEY(key=key, hint=hint, known=", ".join(settings_of(inner)))


def _kind_at(owner: type, path: Iterable[Any]) -> Any:
    kind: Any = owner
    for name in path:
        if not is_dataclass(kind):
            break
        kind = settings_of(kind)[name].kind  # type: ignore[arg-type]
    return kind


def _list_at(owner: Any, path: Iterable[Any]) -> str:
    """Return the example of the setting that a value belongs to, if that is a list."""
    for name in path:
        if not is_dataclass(owner) or not isinstance(name, str):
            break
        setting = settings_of(owner)[name]  # type: ignore[arg-type]
        if isinstance(setting.example, tuple):
            return str([*setting.example])
        owner = setting.kind
    return ""


def _words(kind: Any) -> Iterator[str]:
    """Return the words that a value of an annotated kind may be."""
    if get_origin(kind) is Literal:
        yield from map(str, get_args(kind))
    else:
        for argument in get_args(kind):
            yield from _words(argument)


def _name(path: Iterable[Any]) -> str:
    return ".".join(map(str, path))
