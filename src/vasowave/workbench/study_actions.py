"""What the Study desk can change: the study file, and rows, cells and columns of the table of animals."""

import re
from collections.abc import Mapping
from dataclasses import field, replace
from typing import TYPE_CHECKING, Annotated, Any

from annotated_types import MaxLen, MinLen

from vasowave.errors import InputError
from vasowave.io.files import write_file
from vasowave.settings import settings_class
from vasowave.species import SpeciesName
from vasowave.study.adding import add_files
from vasowave.study.animals import read_animals
from vasowave.study.names import checked_name
from vasowave.study.rows import COLUMNS
from vasowave.study.table import read_rows, written_rows
from vasowave.study.template import new_study, with_groups, with_value
from vasowave.workbench.cells import set_cells

if TYPE_CHECKING:
    from vasowave.workbench.actions import Workplace

Name = Annotated[str, MinLen(1), MaxLen(500)]


@settings_class
class NewStudy:
    """Make a study in the folder that is open."""

    groups: list[Name] = field(default_factory=lambda: ["CTL", "HPH"])
    species: SpeciesName = "mouse"

    def do(self, at: "Workplace") -> str:
        """Do it."""
        new_study(at.desk.folder, [checked_name(one.strip()) for one in self.groups], self.species)
        return "a new study"


@settings_class
class AddFiles:
    """Write a row for every recording among files that were dropped into the study; `vasowave add`."""

    files: Annotated[list[Name], MinLen(1), MaxLen(10_000)]
    group: str = ""

    def do(self, at: "Workplace") -> Mapping[str, Any]:
        """Do it."""
        desk = at.desk
        if not desk.file.exists():
            new_study(desk.folder)
        files = [desk.inside(one) for one in self.files]
        with desk.changing("add files", desk.table, desk.file):
            added = add_files(desk.folder, files, group=self.group)
        names = [row["animal"] for row in added.rows]
        return {"animals": names, "said": [*added.said, *(f"not added: {why}" for why in added.refused)]}


@settings_class
class SetCells:
    """Write cells of one animal; `was` holds what the page showed in them."""

    animal: Name
    cells: dict[Name, Annotated[str, MaxLen(2000)]]
    was: dict[str, str] = field(default_factory=dict)

    def do(self, at: "Workplace") -> str:
        """Do it."""
        return set_cells(at.desk, self.animal, self.cells, self.was)


@settings_class
class UseNetwork:
    """Choose a network for every animal that has none, or whose file is not there."""

    network: Name

    def do(self, at: "Workplace") -> Mapping[str, Any]:
        """Do it."""
        desk = at.desk
        if not desk.inside(self.network).is_file():
            raise InputError(f"there is no file {self.network} in this study")
        with desk.changing(f"network {self.network}", desk.table):
            table = read_rows(desk.table)
            lacking = [row for row in table.rows if not (desk.folder / (row.get("network") or ".")).is_file()]
            for row in lacking:
                row["network"] = self.network
            write_file(desk.table, written_rows(table, ()))
        names = [row["animal"] for row in lacking]
        return {"animals": names, "said": [f"{self.network} is the network of: {', '.join(names) or 'no animal more'}"]}


@settings_class
class AddColumn:
    """Give the table a column of the lab's own: sex, weight [g], date."""

    title: Annotated[str, MinLen(1), MaxLen(100)]

    def do(self, at: "Workplace") -> str:
        """Do it."""
        title, table = " ".join(self.title.split()), at.desk.table
        if not title or not title.isprintable():
            raise InputError("a column has a title")
        if title.casefold() in map(str.casefold, COLUMNS):
            raise InputError(f"'{title}' is no column of your own: it has a meaning here, and stands among all columns")
        with at.desk.changing(f"column {title}", table):
            known = read_rows(table)
            write_file(table, written_rows(replace(known, titles=(*known.titles, title)), ()))
            wrong = [one for one in read_animals(table, None)[1] if one.error and f"column '{title}'" in one.place.part]
            if wrong:
                raise InputError(f"{title}: {wrong[0].finding}")
        return f"a column '{title}' of your own"


@settings_class
class RemoveColumn:
    """Take a column of the lab's own out of the table, with what stands in it."""

    title: Name

    def do(self, at: "Workplace") -> str:
        """Do it."""
        table = at.desk.table
        with at.desk.changing(f"remove column {self.title}", table):
            known = read_rows(table)
            if self.title in COLUMNS or self.title not in known.titles:
                raise InputError(f"there is no column '{self.title}' of your own in {table.name}")
            titles = tuple(title for title in known.titles if title != self.title)
            write_file(table, written_rows(replace(known, titles=titles), ()))
        return f"column '{self.title}' removed"


@settings_class
class RemoveAnimal:
    """Take the row of an animal out of the table; its files stay."""

    animal: Name

    def do(self, at: "Workplace") -> str:
        """Do it."""
        with at.desk.changing(f"remove {self.animal}", at.desk.table):
            table = read_rows(at.desk.table)
            rows = tuple(row for row in table.rows if row["animal"] != self.animal)
            if len(rows) == len(table.rows):
                raise InputError(f"there is no animal '{self.animal}' in {at.desk.table.name}")
            write_file(at.desk.table, written_rows(replace(table, rows=rows), ()))
        return f"{self.animal} removed from the table; its files stay"


@settings_class
class SetSetting:
    """Write one key of study.yaml; `was` is what the page showed."""

    key: Annotated[str, MaxLen(100)]
    value: Annotated[str, MaxLen(2000)]

    def do(self, at: "Workplace") -> str:
        """Do it."""
        if not re.fullmatch(r"\w+(\.\w+)?", self.key) or "\n" in self.value:
            raise InputError(f"'{self.key}: {self.value}' is no key with a value")
        with at.desk.changing(f"{self.key}: {self.value}", at.desk.file):
            write_file(at.desk.file, with_value(at.desk.file, self.key.split("."), self.value))
        return f"{self.key}: {self.value}"


@settings_class
class SetGroups:
    """Name the groups of the study, the reference first."""

    groups: list[Name]

    def do(self, at: "Workplace") -> str:
        """Do it."""
        labels = [checked_name(one.strip()) for one in self.groups]
        with at.desk.changing("groups", at.desk.file):
            write_file(at.desk.file, with_groups(at.desk.file, labels))
        return f"groups: {', '.join(labels)}"


STUDY_ACTIONS = {
    "new-study": NewStudy,
    "add-files": AddFiles,
    "set-cells": SetCells,
    "use-network": UseNetwork,
    "add-column": AddColumn,
    "remove-column": RemoveColumn,
    "remove-animal": RemoveAnimal,
    "set-setting": SetSetting,
    "set-groups": SetGroups,
}
"""By the name that the page gives."""
