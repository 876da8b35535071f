"""From the text of ``study.yaml`` to its settings, or to the list of everything that is wrong with it."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel, ValidationError

from vasowave.animal.animal import known_parameters
from vasowave.errors import InputError, did_you_mean
from vasowave.findings import Finding, Kind, error_kind
from vasowave.model.law_files import looking_in
from vasowave.model.laws import find_bed, find_law
from vasowave.study.document import Document, parse_document, read_document
from vasowave.study.problems import Problem
from vasowave.study.settings import StudyFile

STUDY_FILE = "study.yaml"


def _error(what: str, text: str, remedy: str = "") -> Kind:
    return error_kind(f"setting.{what}", f"{{key}}: {text}", remedy)


EMPTY = _error("empty", "the value is empty; {remedy}", "give one or remove the line")
EMPTY_CHOICE = _error("empty-choice", "the value is empty; choose from: {known}")
UNKNOWN_WORD = _error("unknown-word", "'{given}' is not known{hint}; choose from: {known}")
WRONG = _error("wrong", "{text}")
UNKNOWN_KEY = error_kind("setting.unknown-key", "unknown key '{key}'{hint}; known here: {known}")
AT_ODDS = error_kind("setting.at-odds", "{text}")
DECIMAL_COMMA = _error("decimal-comma", "{given} is not a number; {remedy}", "write a decimal point")
NOT_VALID = _error("not-valid", "{given}: {why}")
_NO_WHOLE = _error("no-whole-number", "{given} is not a whole number")
_NO_NUMBER = _error("no-number", "{given} is not a number")
_NO_TRUTH = _error("neither-true-nor-false", "{given} is neither true nor false")
_PAIR = _error("no-pair", "{remedy}", "write a list of two numbers: [lower, upper]")
_LIST = _error("no-list", "{remedy}", "write a list: [one, other]")
_CODES = {
    **dict.fromkeys(("int_parsing", "int_from_float", "int_type"), _NO_WHOLE),
    **dict.fromkeys(("float_parsing", "float_type"), _NO_NUMBER),
    **dict.fromkeys(("bool_parsing", "bool_type"), _NO_TRUTH),
    **dict.fromkeys(("list_type", "tuple_type"), _LIST),
    **dict.fromkeys(("too_long", "missing"), _PAIR),
    "int_parsing_size": _error("too-large", "{given} is too large"),
    "string_type": _error("no-text", "{given} is not text; {remedy}", "put it between quotation marks"),
    "string_too_short": _error("empty-text", "{given} is empty"),
    "finite_number": _error("not-finite", "{given} is not a finite number"),
    "model_type": _error("no-section", "{remedy}", "write its keys in indented lines 'key: value' below"),
    "dict_type": _error("no-names", "{remedy}", "write 'name: value' in indented lines below, or {name: value}"),
    "greater_than": _error("not-above", "{given} should be greater than {gt:g}"),
    "greater_than_equal": _error("below-least", "{given} should be greater than or equal to {ge:g}"),
    "less_than": _error("not-below", "{given} should be less than {lt:g}"),
    "less_than_equal": _error("above-most", "{given} should be less than or equal to {le:g}"),
}
"""By pydantic's codes."""

_OF_SHAPE = ("model_type", "dict_type", "list_type", "tuple_type", "too_long", "missing")
"""Codes that hold for an empty value, too."""


def study_path(study: Path) -> Path:
    """Return the study file that a folder or a file name means."""
    return study / STUDY_FILE if study.is_dir() else study


def read_settings(path: Path) -> tuple[StudyFile | None, Document]:
    """Return the settings (None if there are errors) and the document, whose `problems` hold what is wrong."""
    document = read_document(path)
    with looking_in(path.parent):
        return validated(document), document


def parse_settings(raw: bytes, name: str = STUDY_FILE) -> tuple[StudyFile | None, list[Problem]]:
    """Return the settings (None if there are errors) and what is wrong; never raises."""
    document = parse_document(raw, name)
    return validated(document), document.problems


def validated(document: Document) -> StudyFile | None:
    """Return the settings a document holds; what is wrong is added to its problems, and then None is returned."""
    # A section whose lines are all commented out is an empty one, not a wrong one.
    values = {k: v for k, v in document.values.items() if v is not None or not _section(StudyFile, k)}
    document.problems += _unknown_parameters(document)
    try:
        settings = StudyFile.model_validate(values)
    except ValidationError as error:
        for one in error.errors(include_url=False):
            unknown = one["type"] == "extra_forbidden"
            document.say(_wrong(one), document.place(list(one["loc"]), key=unknown))
        return None
    return None if document.problems else settings


def _unknown_parameters(document: Document) -> list[Problem]:
    """Return the parameters under ``bounds`` and ``fixed`` that no wall law of the study, nor any of ours, has."""
    calibration = document.values.get("calibration")
    if not isinstance(calibration, dict):
        return []
    walls = calibration.get("walls")
    named = [wall for wall in walls if _is_found(find_law, wall)] if isinstance(walls, list) else []
    beds = str(calibration.get("beds", "windkessel"))
    known = known_parameters(named, beds if _is_found(find_bed, beds) else "windkessel")
    problems = []
    for section in ("bounds", "fixed"):
        given = calibration.get(section)
        for name in given if isinstance(given, dict) else ():
            if name not in known:
                at = ["calibration", section]
                unknown = _not_known(at, name, known)
                problems.append(Problem(unknown.at(**document.place([*at, name], key=True)._asdict())))
    return problems


def _is_found(find: Callable[[str], Any], name: Any) -> bool:
    try:
        find(str(name))
    except InputError:
        return False
    return True


def _wrong(error: Mapping[str, Any]) -> Finding:
    at, code, given = list(error["loc"]), error["type"], error["input"]
    key, told, nested = _name(at), error.get("ctx", {}), isinstance(given, dict | list)
    if code == "extra_forbidden":
        return _unknown_key(at)
    if code == "literal_error":
        known = _choices(at)
        return EMPTY_CHOICE(key=key, known=", ".join(known)) if given is None else _not_known(at, given, known)
    if code == "value_error":
        return WRONG(key=key, text=str(told["error"])) if at else AT_ODDS(text=str(told["error"]))
    if given is None and code not in _OF_SHAPE:
        return EMPTY(key=key)
    if code == "float_parsing" and "," in str(given):
        return DECIMAL_COMMA(key=key, given=f"'{given}'")
    values = {"key": key, "given": "the value" if nested else f"'{given}'"}
    if code not in _CODES:
        return NOT_VALID(**values, why=str(error["msg"]))
    return _CODES[code](**values, **{name: limit for name, limit in told.items() if isinstance(limit, int | float)})


def _not_known(at: list[Any], given: Any, known: Sequence[str]) -> Finding:
    return UNKNOWN_WORD(key=_name(at), given=str(given), hint=did_you_mean(str(given), known), known=", ".join(known))


def _unknown_key(at: list[Any]) -> Finding:
    key, model = str(at[-1]), _model_at(at[:-1])
    hint = did_you_mean(key, model.model_fields)
    elsewhere = [name for name in _sections(StudyFile) if key in _section(StudyFile, name)]  # type: ignore[operator]
    if not hint and elsewhere:
        hint = f" here; it belongs under '{elsewhere[0]}:'"
    elif not hint and key in StudyFile.model_fields:
        hint = " here; it belongs to the top level, without indentation"
    return UNKNOWN_KEY(key=key, hint=hint, known=", ".join(model.model_fields))


def _choices(at: Sequence[Any]) -> list[str]:
    """Return the words that a value may be."""
    model: Any = StudyFile
    for name in at:
        model = model.model_fields[str(name)].annotation
        if not (isinstance(model, type) and issubclass(model, BaseModel)):
            break
    return list(_literals(model))


def _literals(annotation: Any) -> Iterator[str]:
    if get_origin(annotation) is Literal:
        yield from map(str, get_args(annotation))
    else:
        for part in get_args(annotation):
            yield from _literals(part)


def _model_at(at: Iterable[Any]) -> type[BaseModel]:
    model: type[BaseModel] = StudyFile
    for name in at:
        inner = model.model_fields[str(name)].annotation
        assert isinstance(inner, type)
        model = inner
    return model


def _sections(model: type[BaseModel]) -> list[str]:
    return [name for name in model.model_fields if _section(model, name)]


def _section(model: type[BaseModel], name: str) -> Mapping[str, Any] | None:
    """Return the keys of the section called `name`, None if that is no section."""
    field = model.model_fields.get(name)
    kind = field.annotation if field else None
    return kind.model_fields if isinstance(kind, type) and issubclass(kind, BaseModel) else None


def _name(at: Iterable[Any]) -> str:
    return ".".join(str(part) for part in at)
