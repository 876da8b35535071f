"""A study as its two files describe it: settings and animals."""

from dataclasses import dataclass
from pathlib import Path

from vasowave.study.animals import AnimalRow, read_animals
from vasowave.study.problems import Problem, refuse
from vasowave.study.reading import read_settings, study_path
from vasowave.study.settings import StudyFile

RESULTS = "results"
"""Folder of the results, beside the study file."""


@dataclass(frozen=True)
class Study:
    """A study that can be run.

    Attributes
    ----------
    path : Path
        The study file.
    settings : StudyFile
    animals : tuple of AnimalRow
    """

    path: Path
    settings: StudyFile
    animals: tuple[AnimalRow, ...]

    @property
    def folder(self) -> Path:
        """The folder of the study file."""
        return self.path.parent

    @property
    def table(self) -> Path:
        """The table of animals."""
        return self.folder / self.settings.animals

    @property
    def results(self) -> Path:
        """The folder of the results."""
        return self.folder / RESULTS


def inspect_study(path: Path) -> tuple[Study | None, list[Problem]]:
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
    name = settings.animals if settings else document.values.get("animals") or StudyFile.model_fields["animals"].default
    rows, wrong = read_animals(path.parent / str(name), groups)
    problems = [*document.problems, *wrong]
    return Study(path, settings, tuple(rows)) if settings else None, problems


def read_study(path: Path) -> Study:
    """Read ``study.yaml`` (or the folder that holds it) and its table of animals.

    Raises
    ------
    InputError
        Everything that is wrong in them, at once, with file, line and column.
    """
    study, problems = inspect_study(path)
    refuse(problems)
    assert study is not None
    return study
