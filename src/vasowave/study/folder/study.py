"""A study as its two files describe it: settings and animals."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from vasowave.study.cohort.design import Layout, laid_out
from vasowave.study.cohort.variables import Variable
from vasowave.study.folder.animals import variables_of
from vasowave.study.folder.places import RESULTS
from vasowave.study.folder.rows import AnimalRow
from vasowave.study.folder.settings import StudyFile


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

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """The columns of the table that are the lab's own, each of one type."""
        return variables_of(self.animals)

    @cached_property
    def lab_columns(self) -> dict[str, Variable]:
        """The same by name."""
        return {variable.name: variable for variable in self.variables}

    @cached_property
    def layout(self) -> Layout | None:
        """The design applied to the animals, None where groups of independent animals are compared; see `laid_out`."""
        design, members = self.settings.design, {row.animal: row.group for row in self.animals}
        groups = [group for group in self.settings.groups if group in members.values()]
        return None if design.plain else laid_out(design, self.lab_columns, members, groups)

    @property
    def results(self) -> Path:
        """The folder of the results."""
        return self.folder / RESULTS
