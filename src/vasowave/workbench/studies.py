"""What the Study desk shows: the table as it stands, what is wrong or odd beside the cell, and how far the run is."""

import threading
from typing import Any

from vasowave.base.errors import VasowaveError
from vasowave.base.settings import settings_of
from vasowave.base.species import SPECIES
from vasowave.study.entering.checking import check_study
from vasowave.study.entering.table import read_rows
from vasowave.study.entering.template import written
from vasowave.study.folder.animal_columns import COLUMNS, FILES, REQUIRED_COLUMNS
from vasowave.study.folder.problems import StudyProblem, by_kind
from vasowave.study.folder.settings import StudyFile
from vasowave.study.results.overview import HEADER
from vasowave.study.running.plan import inspect_study
from vasowave.study.running.programs import is_trusted, programs_of
from vasowave.study.running.reporting import REPORT_FOLDER
from vasowave.study.running.status import study_status
from vasowave.workbench.arrivals import RECORDED, Arrivals, unlisted
from vasowave.workbench.cures import as_shown
from vasowave.workbench.desk import Desk
from vasowave.workbench.lungs import LUNGS
from vasowave.workbench.running import Runs

_SETTINGS = ("title", "species", "calibration.walls", "calibration.starts", "calibration.beds", "averaging.beats",
             "averaging.drift", "averaging.fiducial", "averaging.reject_ventilation", "inference")  # fmt: skip
"""Keys that the desk offers; the others are written in the file."""

_WORDS = {"kind": ("cycle", "raw"), "synthetic": ("yes", "no"), "shared recording": ("yes", "no")}
"""What a cell may hold, of columns of words."""

_checking = threading.Lock()


def state(desk: Desk, runs: Runs, arrivals: Arrivals) -> dict[str, Any]:
    """Return what a page asks every second: whether anything changed or arrived, and how far a run is."""
    runner = runs.runner(desk)
    answer: dict[str, Any] = {
        "mark": desk.mark(),
        "study": desk.file.is_file(),
        "report": (desk.folder / REPORT_FOLDER / "report.html").is_file(),
        "results": (desk.results / "index.json").is_file(),
        "undo": desk.done[-1].name if desk.done else "",
        "redo": desk.undone[-1].name if desk.undone else "",
        "arrived": len(arrivals.ready()),
    }
    study = inspect_study(desk.folder)[0] if runner and answer["study"] else None
    return answer | {"run": runs.progress(desk, study)}


def shown(desk: Desk) -> dict[str, Any]:
    """Return the study as its two files say it, and what is wrong in them; no recording is read."""
    if not desk.file.is_file():
        return {"study": False, "folder": str(desk.folder.absolute()), "species": [*SPECIES, "other"]}
    study, problems = inspect_study(desk.folder)
    settings = study.settings if study is not None else StudyFile()
    try:
        table = read_rows(desk.table)
        titles, rows = table.titles, [dict(row) for row in table.rows]
    except VasowaveError:  # which stands among the problems
        titles, rows = (), []
    statuses = {status.animal: status for status in study_status(study).animals} if study is not None else {}
    return {
        "study": True,
        "programs": programs_to_read(desk),
        "folder": str(desk.folder.absolute()),
        "title": settings.title,
        "groups": settings.groups,
        "columns": [[title, column.meaning, title in REQUIRED_COLUMNS] for title, column in COLUMNS.items()],
        "files": FILES,
        "words": _WORDS,
        "titles": list(titles),
        "header": [list(column) for column in HEADER],
        "rows": rows,
        "networks": [*_files(desk, "networks"), *_extracted(desk)],
        "problems": [_problem(problem, rows) for problem in problems],
        "settings": [_setting(settings, key) for key in _SETTINGS],
        "status": {name: {"state": status.state, "text": str(status)} for name, status in statuses.items()},
        "outdated": _outdated(desk, statuses),
        "watched": RECORDED,
        "unlisted": unlisted(desk),
    }


def programs_to_read(desk: Desk) -> list[dict[str, str]]:
    """Return the programs of the study, with their text, that nobody has allowed to run."""
    try:
        programs = programs_of(desk.folder)
    except VasowaveError:  # which stands among the problems
        return []
    return [{"name": program.name, "path": program.path, "sha256": program.sha256,
             "text": program.source.decode(errors="replace")}
            for program in programs if not is_trusted(desk.folder, program)]  # fmt: skip


def checked(desk: Desk) -> dict[str, Any]:
    """Return what `vasowave check` says: everything wrong or odd, and what was read of every animal."""
    with _checking:
        report = check_study(desk.folder)
    rows = [dict(row) for row in read_rows(desk.table).rows] if desk.table.is_file() else []
    return {
        "problems": [_problem(problem, rows) for problem in report.problems],
        "notes": [_note(group, rows) for group in by_kind(report.notes)],
        "read": {animal.animal: list(animal.row()) for animal in report.read},
    }


def _note(group: list[StudyProblem], rows: list[dict[str, str]]) -> dict[str, Any]:
    """Return what animals have alike by the text of the first; a remedy of the first would mend no other."""
    names = [name for problem in group for name in problem.animals]
    return _problem(group[0], rows) | ({"animals": names, "remedies": []} if len(group) > 1 else {})


def outdated(desk: Desk) -> list[str]:
    """Return the animals whose result is no longer that of their row, files and settings."""
    study = inspect_study(desk.folder)[0] if desk.file.is_file() else None
    return (
        _outdated(desk, {status.animal: status for status in study_status(study).animals}) if study is not None else []
    )


def _problem(problem: StudyProblem, rows: list[dict[str, str]]) -> dict[str, Any]:
    """Return a problem as the page shows it: beside its cell, with what mends it."""
    place = problem.place
    column = next((title for title in COLUMNS if place.part == f"column '{title}'"), "")
    by_name = {row.get("animal", ""): row for row in rows}
    animals = [name for name in problem.animals if name in by_name]
    return as_shown(problem.finding, animals, by_name[animals[0]] if animals else None) | {
        "place": str(place),
        "error": problem.error,
        "animals": animals,
        "column": column,
    }


def _setting(settings: StudyFile, key: str) -> dict[str, str]:
    value: Any = settings
    section: Any = StudyFile
    for name in key.split("."):
        setting = settings_of(section)[name]
        value, section = getattr(value, name), setting.section
    return {"key": key, "value": "" if value is None else written(value), "meaning": setting.meaning}


def _files(desk: Desk, folder: str) -> list[str]:
    place = desk.folder / folder
    return [file.relative_to(desk.folder).as_posix() for file in sorted(place.rglob("*"))
            if file.is_file() and not file.name.startswith(".")]  # fmt: skip


def _extracted(desk: Desk) -> list[str]:
    """Return the networks that were extracted from images here."""
    networks = sorted((desk.folder / LUNGS).glob("*/network.csv"))
    return [network.relative_to(desk.folder).as_posix() for network in networks]


def _outdated(desk: Desk, statuses: dict[str, Any]) -> list[str]:
    """Return the animals whose result is no longer that of their row, files and settings."""
    try:
        stored = desk.stored()
    except VasowaveError:
        return []
    return [name for name, status in statuses.items() if name in stored and status.state != "done"]
