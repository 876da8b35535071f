"""The files and folders on which everything rests that a command says of a study."""

from pathlib import Path

from vasowave.base.io.answers import Basis, basis_of
from vasowave.base.io.files import FOLDER_LOCK
from vasowave.base.runtime.kept import PACKAGE
from vasowave.pulse.model.laws import BEDS, LAWS
from vasowave.study.folder.places import RESULTS
from vasowave.study.results.results import ANIMALS, INDEX
from vasowave.study.results.store import CACHE
from vasowave.study.running.plan import RECORD, inspect_study
from vasowave.study.running.reporting import REPORT_FOLDER

_OURS = (RECORD, FOLDER_LOCK)
"""Files that are written beside those of a study, and are no part of any of them."""

_TEMPLATES = PACKAGE / "study" / "report" / "templates"


def basis_of_study(path: Path) -> Basis | None:
    """Return what is read of a study; None where something else decides, too: an error, or a law that is not ours."""
    study, problems = inspect_study(path)
    if study is None or any(problem.error for problem in problems):
        return None
    fitted = study.settings.calibration
    if not ({*fitted.walls} <= {*LAWS} and fitted.beds in BEDS):
        return None
    files = [study.path, study.table, *(file for row in study.animals for file in row.files.values())]
    return basis_of(files, {file.parent for file in files}, _OURS)


def with_outcome(basis: Basis, folder: Path, ran: bool) -> Basis:
    """Return a basis with what the study in a folder has written: what it declared and, if it `ran`, what came out."""
    results, report = folder / RESULTS, folder / REPORT_FOLDER
    places = [results / CACHE, results / ANIMALS, report, *(place for place in report.rglob("*") if place.is_dir())]
    files = [results / INDEX, *(file for place in places for file in place.glob("*") if file.is_file())]
    written = basis_of([folder / RECORD, *(files if ran else ())], [*places, _TEMPLATES] if ran else ())
    return Basis(basis.files | written.files, basis.folders | written.folders, basis.ours)
