"""The programs that a study names, wall laws and beds of its own, and the permission to run them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from vasowave.base.cures import TrustPrograms
from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind
from vasowave.base.io.textfile import read_bytes
from vasowave.base.io.trusted import allow, is_allowed
from vasowave.base.stores import parsed
from vasowave.pulse.model.law_files import ALLOW, LawFile, files_of, is_unread, looking_in, named, remember
from vasowave.study.folder.places import study_path
from vasowave.study.folder.problems import StudyProblem
from vasowave.study.folder.reading import Document, read_document
from vasowave.study.folder.settings import StudyFile
from vasowave.study.results.results import INDEX

NOT_RUN = look_kind(
    "study.program-not-run",
    "a wall law or bed is the program {file}, which was not run: what it says, and bounds and fixed values of its "
    "parameters, were not looked at; {remedy}",
    ALLOW,
    TrustPrograms(),
)


def programs_of(study: str | Path) -> tuple[LawFile, ...]:
    """Return the programs that a study, or its results, name; nothing is run.

    Raises
    ------
    InputError
        A file cannot be read, or is no program's.
    """
    path = study_path(Path(study))
    names = _names(read_document(path).values.get("calibration")) if path.is_file() else []
    with looking_in(path.parent):
        now = [named(law) for law in names]
    index = next((place / INDEX for place in (path.parent / "results", path.parent) if (place / INDEX).is_file()), None)
    then: list[str] = []
    if index is not None:
        try:
            then = _names(parsed(read_bytes(index))["settings"]["calibration"])
        except (InputError, ValueError, LookupError, TypeError):  # whoever reads the results says so
            then = []
        remember(then, [path.parent, Path.cwd()])  # where a fit was made, its laws may lie
    return files_of((*now, *(law if "@" in law else law.replace(":", "@installed:", 1) for law in then)))


def _names(calibration: object) -> list[str]:
    if not isinstance(calibration, dict):
        return []
    walls = calibration.get("walls")
    laws = [*(walls if isinstance(walls, list) else ()), calibration.get("beds")]
    return [name for name in map(str, laws) if ":" in name]


def trust_study(study: str | Path, programs: Sequence[LawFile] | None = None) -> tuple[Path, ...]:
    """Allow the programs that a study names, wall laws and beds of its own, to run; read them before.

    The permission holds for the study in this folder and these bytes of the programs. It stands in a folder of the
    user's own, see `io.trusted`.

    Parameters
    ----------
    study : str or Path
        The study's folder or file, or the folder of a fit.
    programs : sequence of LawFile, optional
        What somebody has read; by default what stands there now.

    Returns
    -------
    tuple of Path
        The files that were allowed.

    Raises
    ------
    InputError
        A file cannot be read, or is no program's.

    Examples
    --------
    >>> import vasowave as vw
    >>> from pathlib import Path
    >>> _ = Path("study.yaml").write_text("groups: [CTL]\\ncalibration: {walls: [linear]}\\n")
    >>> vw.trust_study("study.yaml")
    ()
    """
    allowed = programs_of(study) if programs is None else programs
    for program in allowed:
        for folder in {study_path(Path(study)).parent.resolve(), Path(program.path).resolve().parent}:
            allow(folder, program.source, program.path)
    return tuple(Path(program.path) for program in allowed)


def is_trusted(study: Path, program: LawFile) -> bool:
    """Whether a program may run for a study."""
    return is_allowed(study_path(Path(study)).parent, program.source)


def programs_not_run(settings: StudyFile, document: Document) -> list[StudyProblem]:
    """Return which programs of a study that was just read nobody has allowed to run."""
    place, folder = document.place(("calibration", "walls")), Path(document.name).parent
    with looking_in(folder):
        files = files_of(law for law in (*settings.calibration.walls, settings.calibration.beds) if is_unread(law))
    return [StudyProblem(NOT_RUN(file=file.path).placed(place)) for file in files]


def without_unread(settings: StudyFile, folder: Path) -> StudyFile:
    """Return settings without the laws and beds that must not run, and what is said of their parameters."""
    fit, report = settings.calibration, settings.report
    with looking_in(folder):
        walls = tuple(law for law in fit.walls if not is_unread(law))
        if len(walls) == len(fit.walls) and not is_unread(fit.beds):
            return settings
        beds = "windkessel" if is_unread(fit.beds) else fit.beds
    ours: Any = {name: {key: value for key, value in getattr(fit, name).items() if "." not in key}
            for name in ("bounds", "fixed")}  # fmt: skip
    quantities = tuple(name for name in report.quantities if "." not in name)
    return replace(
        settings,
        calibration=replace(fit, walls=walls or ("linear",), beds=beds, **ours),
        report=replace(report, law=report.law if report.law in walls else None, quantities=quantities),
        model_selection=settings.model_selection and len(walls) > 1,
    )


def refuse_unread(settings: StudyFile, folder: Path) -> None:
    """Raise `InputError` if a study names a program that nobody has allowed to run."""
    with looking_in(folder):
        files = files_of(law for law in (*settings.calibration.walls, settings.calibration.beds) if is_unread(law))
    if files:
        raise InputError(f"{', '.join(file.path for file in files)}: a program that this study names, and nobody has "
                         f"allowed it to run; {ALLOW}", [TrustPrograms()])  # fmt: skip
