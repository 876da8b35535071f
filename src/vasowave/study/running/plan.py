"""Read a study from its two files, with what is wrong in them, and record what it declared to compare."""

import json
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from vasowave.base.errors import InputError
from vasowave.base.findings import warn
from vasowave.base.io.files import alone_in, lies_inside, write_file
from vasowave.base.io.textfile import read_bytes
from vasowave.base.runtime.kept import digest_of
from vasowave.base.stores import parsed_as, stored
from vasowave.study.cohort.declared import Declaration
from vasowave.study.folder.animals import read_animals
from vasowave.study.folder.designing import design_problems
from vasowave.study.folder.places import study_path
from vasowave.study.folder.problems import StudyProblem, refuse
from vasowave.study.folder.reading import read_settings
from vasowave.study.folder.settings import StudyFile
from vasowave.study.folder.study import Study
from vasowave.study.running.programs import NOT_RUN, programs_not_run

RECORD = "declared.json"
"""What a study declared to compare, with times: written when it is first found in order, or run."""


def inspect_study(path: str | Path) -> tuple[Study | None, list[StudyProblem]]:
    """Return the study (None if there are errors) and everything that is wrong or odd in its two files.

    Animals with an error in their row are left out of a study with errors.

    Raises
    ------
    InputError
        There is no study file.
    """
    path = study_path(Path(path))
    settings, document = read_settings(path)
    groups = settings.groups if settings else None
    name = settings.animals if settings else document.values.get("animals") or StudyFile.animals
    if not lies_inside(path.parent, str(name)):  # which is told, and not looked into
        return None, document.problems
    rows, wrong = read_animals(path.parent / str(name), groups, (settings.design.subject or "") if settings else "")
    problems = [*document.problems, *wrong]
    if settings is None:
        return None, problems
    study = Study(path, settings, tuple(rows))
    complete = not any(problem.error for problem in problems)
    problems += programs_not_run(settings, document)
    return study, [*problems, *design_problems(study, document.place(("design",), key=True), complete)]


def read_study(path: str | Path) -> Study:
    """Read ``study.yaml`` (or the folder that holds it) and its table of animals; no program that it names is run.

    Warns
    -----
    VasowaveWarning
        A program was not looked at, since nobody has allowed it to run (see `trust_study`).

    Raises
    ------
    InputError
        Everything that is wrong in them, at once, with file, line and column.

    Examples
    --------
    >>> import vasowave as vw
    >>> from pathlib import Path
    >>> mouse = vw.virtual_mouse()
    >>> rows = (f"{t:.6f},{p:.6f},{q:.6f}" for t, p, q in zip(mouse.time, mouse.pressure, mouse.flow))
    >>> _ = Path("cycle.csv").write_text("\\n".join(["time [s],pressure [mmHg],flow [ml/s]", *rows, ""]))
    >>> vw.write_network(vw.control_network(), "lung.csv")
    >>> _ = Path("animals.csv").write_text("animal,group,network,recording\\nmouse 6,CTL,lung.csv,cycle.csv\\n")
    >>> _ = Path("study.yaml").write_text("groups: [CTL]\\ncalibration: {walls: [linear], starts: 1}\\n")
    >>> [row.animal for row in vw.read_study("study.yaml").animals]
    ['mouse 6']
    """
    study, problems = inspect_study(path)
    refuse(problems)
    assert study is not None
    for problem in problems:
        if problem.finding.code == NOT_RUN.code:
            warn(problem.finding, stacklevel=2)
    return study


def declare(study: Study) -> tuple[Declaration, ...]:
    """Write what a study declares into its record if that is new, and return all that it ever declared.

    Raises
    ------
    InputError
        The record is damaged, or cannot be written.
    """
    path, content = study.folder / RECORD, _declared_now(study)
    if (before := read_declared(path)) and before[-1].content == content:
        return before
    with alone_in(study.folder):
        if (before := read_declared(path)) and before[-1].content == content:
            return before
        now = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
        after = (*before, Declaration(now, (study.results / "index.json").is_file(), content))
        plain = {"sha256": digest_of(after), "declared": [asdict(declaration) for declaration in after]}
        write_file(path, json.dumps(plain, indent=1, ensure_ascii=False) + "\n")
    return after


def _declared_now(study: Study) -> dict[str, Any]:
    settings = study.settings
    columns = [variable for variable in study.variables if variable.name in settings.design.terms]
    declared = {
        "groups": settings.groups,
        "quantities": settings.report.quantities,
        "law": settings.report.law or settings.calibration.walls[0],
        "design": asdict(settings.design),
        "animals": {
            row.animal: {"group": row.group} | {column.name: column.levels.get(row.animal, "") for column in columns}
            for row in study.animals
        },
        "reference": {
            variable.name: variable.order[0] for variable in study.variables if variable.name == settings.design.second
        },
    }
    return parsed_as(dict[str, Any], json.dumps(declared))


@dataclass(frozen=True)
class _Record:
    sha256: str
    declared: tuple[Declaration, ...]


@stored("record of what was declared", RECORD)
def read_declared(path: Path) -> tuple[Declaration, ...]:
    """Return what a record holds; nothing where there is none.

    Raises
    ------
    InputError
        It is damaged.
    """
    if not path.is_file():
        return ()
    try:
        content = read_bytes(path)
        if content.startswith(b"["):  # of an earlier version, without a check sum
            return parsed_as(tuple[Declaration, ...], content)
        record = parsed_as(_Record, content)
        if record.sha256 != digest_of(record.declared):
            raise ValueError("its content does not match its SHA-256")
        return record.declared
    except ValueError as error:
        raise InputError(f"{path}: damaged ({error}); put back what it was, or remove it to declare anew") from None
