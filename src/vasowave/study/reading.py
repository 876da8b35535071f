"""From the text of ``study.yaml`` to its settings, or to the list of everything that is wrong with it."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from vasowave.animal.animal import known_parameters
from vasowave.errors import InputError, did_you_mean
from vasowave.law_files import looking_in
from vasowave.laws import find_law
from vasowave.study.document import Document, parse_document, read_document
from vasowave.study.problems import Problem
from vasowave.study.settings import StudyFile

STUDY_FILE = "study.yaml"

_WORDS = {
    "int_parsing": "is not a whole number",
    "int_from_float": "is not a whole number",
    "int_type": "is not a whole number",
    "int_parsing_size": "is too large",
    "float_parsing": "is not a number",
    "float_type": "is not a number",
    "bool_parsing": "is neither true nor false",
    "bool_type": "is neither true nor false",
    "string_type": "is not text; put it between quotation marks",
    "string_too_short": "is empty",
    "finite_number": "is not a finite number",
}
_SHAPES = {
    "model_type": "write its keys in indented lines 'key: value' below",
    "dict_type": "write 'name: value' in indented lines below, or {name: value}",
    "list_type": "write a list: [one, other]",
    "tuple_type": "write a list: [one, other]",
    "too_long": "write a list of two numbers: [lower, upper]",
    "missing": "write a list of two numbers: [lower, upper]",
}


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
        document.problems += [_problem(document, dict(one)) for one in error.errors(include_url=False)]
        return None
    return None if document.problems else settings


def _unknown_parameters(document: Document) -> list[Problem]:
    """Return the parameters under ``bounds`` and ``fixed`` that no wall law of the study, nor any of ours, has."""
    calibration = document.values.get("calibration")
    if not isinstance(calibration, dict):
        return []
    walls = calibration.get("walls")
    known = known_parameters([wall for wall in walls if _is_law(wall)] if isinstance(walls, list) else [])
    problems = []
    for section in ("bounds", "fixed"):
        given = calibration.get(section)
        for name in given if isinstance(given, dict) else ():
            if name not in known:
                message = f"'{name}' is not known{did_you_mean(name, known)}; choose from: {', '.join(known)}"
                place = document.place(("calibration", section, name), key=True)
                problems.append(Problem(place, f"calibration.{section}: {message}"))
    return problems


def _is_law(wall: Any) -> bool:
    try:
        find_law(str(wall))
    except InputError:
        return False
    return True


def _problem(document: Document, error: Mapping[str, Any]) -> Problem:
    at, kind, given = list(error["loc"]), error["type"], error["input"]
    if kind == "extra_forbidden":
        return Problem(document.place(at, key=True), _unknown_key(at))
    if kind == "literal_error":
        known = [word.strip(" '") for word in error["ctx"]["expected"].replace(" or ", ", ").split(",")]
        hint = did_you_mean(str(given), known)
        shown = "the value is empty" if given is None else f"'{given}' is not known"
        return Problem(document.place(at), f"{_name(at)}: {shown}{hint}; choose from: {', '.join(known)}")
    if kind == "value_error":
        message = str(error["msg"]).removeprefix("Value error, ")
    elif kind in _SHAPES:
        message = _SHAPES[kind]
    elif given is None:
        message = "the value is empty; give one or remove the line"
    elif kind in _WORDS and not isinstance(given, dict | list):
        comma = "; write a decimal point" if kind == "float_parsing" and "," in str(given) else ""
        message = f"'{given}' {_WORDS[kind]}{comma}"
    elif isinstance(given, dict | list):
        message = str(error["msg"]).replace("Input", "the value")
    else:
        message = str(error["msg"]).replace("Input", f"'{given}'")
    return Problem(document.place(at), f"{_name(at)}: {message}" if at else message)


def _unknown_key(at: list[Any]) -> str:
    key, model = str(at[-1]), _model_at(at[:-1])
    hint = did_you_mean(key, model.model_fields)
    elsewhere = [name for name in _sections(StudyFile) if key in _section(StudyFile, name)]  # type: ignore[operator]
    if not hint and elsewhere:
        hint = f" here; it belongs under '{elsewhere[0]}:'"
    elif not hint and key in StudyFile.model_fields:
        hint = " here; it belongs to the top level, without indentation"
    return f"unknown key '{key}'{hint}; known here: {', '.join(model.model_fields)}"


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
