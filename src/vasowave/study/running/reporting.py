"""Tables, figures and report of a study, from its stored results alone."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from vasowave.base.cures import RunAgain
from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, warn
from vasowave.base.io.files import inside
from vasowave.base.runtime.memory import seldom_collected
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.missing import Missing, missing_animals
from vasowave.study.cohort.primary import primary_law
from vasowave.study.folder.places import YAML, study_path
from vasowave.study.folder.study import Study
from vasowave.study.report.wording import some_of
from vasowave.study.report.write import Tell, write_cohort_report, write_report
from vasowave.study.results.attribution import attributed
from vasowave.study.results.loading import animal_key
from vasowave.study.results.physiology import looks_of
from vasowave.study.results.results import Results, read_results
from vasowave.study.running.executors import side_by_side
from vasowave.study.running.plan import inspect_study
from vasowave.study.running.status import outdated

REPORT_FOLDER, ONE_BY_ONE = "report", "report of animals"
_MAX_NAMED_ANIMALS = 6  # animals, in a sentence
CHANGED = look_kind(
    "report.study-changed",
    "{path}: the study changed since it was run ({changes}). The report shows it as it was run; {remedy}",
    "run it again: what changed is computed, and the report written anew",
    RunAgain(),
)


def _warned(stored: Results, results: list[AnimalResult]) -> list[AnimalResult]:
    return [replace(result, looks=looks_of(result, stored.settings.species)) for result in results]


def report_study(
    study: Path, pdf: bool | None = None, workers: int = 1, animal: str = "", announce: Tell | None = None
) -> Path:
    """Write the report of a study that was run and return its page; nothing is simulated, and no recording is needed.

    The folder is ``report`` beside the results, or ``report of animals`` with a folder of its own for an animal.

    Parameters
    ----------
    study : Path
        The study's folder or file.
    pdf : bool, optional
        Whether the page is also written as PDF; by default as the study file said when the study was run.
    workers : int
        Processes that read results and draw figures. A script that asks for more than one must do so below
        ``if __name__ == "__main__":``.
    animal : str
        Write the report of this one alone.
    announce : callable, optional
        Called with the questions of the page and their answers.

    Raises
    ------
    InputError
        There are no results or none of this animal, they are damaged, or the report cannot be written.

    Warns
    -----
    VasowaveWarning
        The study's files changed since it was run; the report shows what was run.
    """
    if not Path(study).exists() and Path(study).suffix.lower() not in YAML:
        raise InputError(f"{study}: there is no such folder")
    path = study_path(Path(study))
    folder, stored = path.parent, read_results(path.parent)
    report_settings = stored.settings.report if pdf is None else replace(stored.settings.report, pdf=pdf)
    if animal:
        animal_folder = inside(folder, f"{ONE_BY_ONE}/{stored.file_of(animal).stem}")
        result = stored[animal]
        _tell_changed(path, stored, [result])
        return write_report(_warned(stored, [result]), animal_folder, pdf=report_settings.pdf)
    place = inside(folder, REPORT_FOLDER)
    with side_by_side(workers, len(stored)) as parallel_map, seldom_collected():
        results = _warned(stored, stored.in_order(parallel_map, whole=False))
        _tell_changed(path, stored, results)
        cohort = stored.gathered(results, results[0].group)
        return write_cohort_report(
            attributed(cohort, report_settings),
            place,
            report_settings,
            title=stored.settings.title,
            mapper=parallel_map,
            on_answers=announce,
        )


def _tell_changed(path: Path, stored: Results, results: Sequence[AnimalResult]) -> None:
    """Warn if the study's files no longer say what was run; a report does not need them, and they may be gone."""
    study, problems = inspect_study(path) if path.is_file() else (None, [])
    if study is None:
        return
    rows, known_animals = {row.animal for row in study.animals}, {*stored, *(failure.animal for failure in stored.lost)}
    keys = {result.name: str(result.origin.get("key")) for result in results}
    lost = [] if any(problem.error for problem in problems) else [name for name in keys if name not in rows]
    groups = {entry.animal: entry.group for entry in stored.animals}
    moved = [f"{row.animal} ({row.group}, was {before})" for row in study.animals
             if (before := groups.get(row.animal, row.group)) != row.group]  # fmt: skip
    settings, columns = outdated(study, stored)
    listed = {
        "animals in another group": moved,
        "animals whose row, files or settings (or the program) changed": _changed(study, keys),
        "new animals": [row.animal for row in study.animals if row.animal not in known_animals],
        "animals no longer in the table": lost,
        "columns of the table of animals": columns,
        "settings": settings,
    }
    changes = "; ".join(f"{title}: {some_of(names, _MAX_NAMED_ANIMALS)}" for title, names in listed.items() if names)
    if changes:
        warn(CHANGED(path=str(path), changes=changes), stacklevel=3)


def _changed(study: Study, keys: dict[str, str]) -> list[str]:
    """Return the animals whose result has another key than their row has now; files that are gone say nothing."""
    changed = []
    for row in study.animals:
        try:
            if keys.get(row.animal, now := animal_key(row, study.settings, study.folder)) != now:
                changed.append(row.animal)
        except InputError:
            continue
    return changed


def missing_of(study: Path) -> tuple[Missing, ...]:
    """Return which animals the primary comparison of a study that was run misses, group by group.

    Parameters
    ----------
    study : Path
        The study's folder or file.

    Raises
    ------
    InputError
        There are no results, or they are damaged.
    """
    stored = read_results(study_path(Path(study)).parent)
    cohort = stored.gathered(stored.in_order(whole=False))
    return missing_animals(cohort, primary_law(cohort, stored.settings.report))
