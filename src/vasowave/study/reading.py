"""From the text of ``study.yaml`` to its settings, or to the list of everything that is wrong with it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from vasowave.animal.animal import known_parameters
from vasowave.errors import InputError
from vasowave.model.law_files import looking_in
from vasowave.model.laws import find_bed, find_law
from vasowave.settings import read_values, settings_of, unknown_word
from vasowave.study.document import Document, parse_document, read_document
from vasowave.study.problems import Problem
from vasowave.study.settings import StudyFile

STUDY_FILE = "study.yaml"


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
    known = settings_of(StudyFile)
    empty = [key for key, value in document.values.items() if value is None and key in known and known[key].section]
    document.problems += _unknown_parameters(document)
    settings = read_values(StudyFile, {key: value for key, value in document.values.items() if key not in empty})
    if isinstance(settings, list):
        for at, of_key, wrong in settings:
            document.say(wrong, document.place(at, key=of_key))
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
    viscous = calibration.get("viscous") is True
    known = known_parameters(named, beds if _is_found(find_bed, beds) else "windkessel", viscous)
    problems = []
    for section in ("bounds", "fixed"):
        given = calibration.get(section)
        for name in given if isinstance(given, dict) else ():
            if name not in known:
                at = ["calibration", section]
                unknown = unknown_word(at, name, known)
                problems.append(Problem(unknown.at(**document.place([*at, name], key=True)._asdict())))
    return problems


def _is_found(find: Callable[[str], Any], name: Any) -> bool:
    try:
        find(str(name))
    except InputError:
        return False
    return True
