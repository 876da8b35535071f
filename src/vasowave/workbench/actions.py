"""Everything that the page can change, each as one typed action over the functions that the command line calls."""

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import field, replace
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from annotated_types import Ge, MaxLen, MinLen

from vasowave.errors import InputError, did_you_mean
from vasowave.io.files import made_inside, write_file
from vasowave.recording import read_edits
from vasowave.recording.edits import BeatEdit, edits_text
from vasowave.settings import settings_class
from vasowave.species import SpeciesName
from vasowave.study.adding import add_files
from vasowave.study.animals import read_row
from vasowave.study.names import checked_name
from vasowave.study.rows import COLUMNS
from vasowave.study.table import read_rows, written_rows
from vasowave.study.template import new_study, with_groups, with_value
from vasowave.workbench.desk import Desk, unchanged
from vasowave.workbench.lung_actions import LUNG_ACTIONS
from vasowave.workbench.lungs import Lungs
from vasowave.workbench.recordings import Recordings, edits_file, mean_between, row_of
from vasowave.workbench.running import Runs

_Time = Annotated[float, Ge(0)]
Name = Annotated[str, MinLen(1), MaxLen(500)]


class Workplace(NamedTuple):
    """What actions work on."""

    desk: Desk
    recordings: Recordings
    runs: Runs
    lungs: Lungs


@settings_class
class NewStudy:
    """Make a study in the folder that is open."""

    groups: list[Name] = field(default_factory=lambda: ["CTL", "HPH"])
    species: SpeciesName = "mouse"

    def do(self, at: Workplace) -> str:
        """Do it."""
        new_study(at.desk.folder, [checked_name(one.strip()) for one in self.groups], self.species)
        return "a new study"


@settings_class
class AddFiles:
    """Write a row for every recording among files that were dropped into the study; `vasowave add`."""

    files: Annotated[list[Name], MinLen(1), MaxLen(10_000)]
    group: str = ""

    def do(self, at: Workplace) -> Mapping[str, Any]:
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

    def do(self, at: Workplace) -> str:
        """Do it."""
        return _set_cells(at.desk, self.animal, self.cells, self.was)


@settings_class
class RemoveAnimal:
    """Take the row of an animal out of the table; its files stay."""

    animal: Name

    def do(self, at: Workplace) -> str:
        """Do it."""
        with at.desk.changing(f"remove {self.animal}", at.desk.table):
            table = read_rows(at.desk.table)
            rows = tuple(row for row in table.rows if row["animal"] != self.animal)
            if len(rows) == len(table.rows):
                raise InputError(f"there is no animal '{self.animal}' in {at.desk.table.name}")
            write_file(at.desk.table, written_rows(replace(table, rows=rows), ()))
        return f"{self.animal} removed from the table; its files stay"


@settings_class
class SetStretch:
    """Average the beats of one stretch alone, s; nothing given is the whole recording."""

    animal: Name
    start: Annotated[float, Ge(0)] | None = None
    end: Annotated[float, Ge(0)] | None = None

    def do(self, at: Workplace) -> str:
        """Do it."""
        written = ("" if one is None else f"{one:.6g}" for one in (self.start, self.end))
        return _set_cells(at.desk, self.animal, dict(zip(("start [s]", "end [s]"), written, strict=True)), {})


@settings_class
class SetZero:
    """Take the mean pressure of a stretch for the transducer's zero; without a stretch, none."""

    animal: Name
    start: Annotated[float, Ge(0)] | None = None
    end: Annotated[float, Ge(0)] | None = None

    def do(self, at: Workplace) -> str:
        """Do it."""
        row, _ = row_of(at.desk, self.animal)
        if self.start is None or self.end is None:
            return _set_cells(at.desk, self.animal, {"zero [mmHg]": ""}, {})
        above = mean_between(at.recordings.opened(row).traces, self.start, self.end)
        return _set_cells(at.desk, self.animal, {"zero [mmHg]": f"{above + (row.zero or 0.0):.4g}"}, {})


@settings_class
class EditBeats:
    """Decide on beats: `edits` are added, each in place of one near the same time; `forget` are taken back."""

    animal: Name
    edits: list[tuple[Literal["reject", "keep", "move"], _Time, _Time | None]] = field(default_factory=list)
    forget: list[float] = field(default_factory=list)

    def do(self, at: Workplace) -> str:
        """Do it."""
        desk = at.desk
        row, _ = row_of(desk, self.animal)
        cell = os.path.relpath(row.beat_edits or edits_file(desk, self.animal), desk.folder).replace(os.sep, "/")
        path = desk.inside(cell)
        given = [BeatEdit(*one) for one in self.edits]
        if any((one.action == "move") != (one.to is not None) for one in given):
            raise InputError("a beat is moved to a time, and rejected or kept without one")
        with desk.changing(f"beats of {self.animal}", path, desk.table):
            gone = [*self.forget, *(one.time for one in given)]
            before = read_edits(path) if path.is_file() else ()
            kept = [one for one in before if all(abs(one.time - time) > _SAME for time in gone)]
            made_inside(desk.folder, str(path.parent.relative_to(desk.folder)))
            write_file(path, edits_text([*kept, *given]))
            table = read_rows(desk.table)
            _write_cells(desk, table, self.animal, {"beat edits": cell})
        return f"{len(kept) + len(given)} edits in {cell}"


@settings_class
class SetSetting:
    """Write one key of study.yaml; `was` is what the page showed."""

    key: Annotated[str, MaxLen(100)]
    value: Annotated[str, MaxLen(2000)]

    def do(self, at: Workplace) -> str:
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

    def do(self, at: Workplace) -> str:
        """Do it."""
        labels = [checked_name(one.strip()) for one in self.groups]
        with at.desk.changing("groups", at.desk.file):
            write_file(at.desk.file, with_groups(at.desk.file, labels))
        return f"groups: {', '.join(labels)}"


@settings_class
class Undo:
    """Take the last change back."""

    def do(self, at: Workplace) -> str:
        """Do it."""
        return f"undone: {at.desk.undo()}"


@settings_class
class Redo:
    """Make the change again that was taken back."""

    def do(self, at: Workplace) -> str:
        """Do it."""
        return f"done again: {at.desk.redo()}"


@settings_class
class Run:
    """Run the study, or go on with it."""

    def do(self, at: Workplace) -> str:
        """Do it."""
        at.runs.start(at.desk)
        return "the run begins"


@settings_class
class Stop:
    """Interrupt the run; what had finished is kept."""

    def do(self, at: Workplace) -> str:
        """Do it."""
        at.runs.stop(at.desk)
        return "the run is being stopped; what had finished is kept"


@settings_class
class AtEnd:
    """Say whether a run stops when the workbench ends."""

    stop: bool

    def do(self, at: Workplace) -> str:
        """Do it."""
        at.runs.stops_with_us = self.stop
        return f"a run {'stops' if self.stop else 'goes on'} when the workbench ends"


_SAME = 1e-3  # s between two times that mean the same beat

ACTIONS: Mapping[str, Callable[..., Any]] = {
    "new-study": NewStudy,
    "add-files": AddFiles,
    "set-cells": SetCells,
    "remove-animal": RemoveAnimal,
    "set-stretch": SetStretch,
    "set-zero": SetZero,
    "edit-beats": EditBeats,
    "set-setting": SetSetting,
    "set-groups": SetGroups,
    "undo": Undo,
    "redo": Redo,
    "run": Run,
    "stop": Stop,
    "at-end": AtEnd,
    **LUNG_ACTIONS,
}
"""By the name that the page gives."""


def act(at: Workplace, asked: object) -> Any:
    """Do what the page asks, ``{"do": NAME, ...}``, and return what there is to say.

    Raises
    ------
    InputError
        No such action, a value that it does not take, or what the action itself refuses.
    """
    if not isinstance(asked, dict) or not isinstance(asked.get("do"), str):
        raise InputError("a message names what to do")
    kind = ACTIONS.get(asked["do"])
    if kind is None:
        raise InputError(f"there is no action '{asked['do'][:80]}'{did_you_mean(asked['do'][:80], ACTIONS)}")
    given = {str(key): value for key, value in asked.items() if key != "do"}
    return kind(**given).do(at)


def _set_cells(desk: Desk, animal: str, cells: Mapping[str, str], was: Mapping[str, str]) -> str:
    unknown = next((title for title in cells if title not in COLUMNS), None)
    if unknown is not None:
        raise InputError(f"there is no column '{unknown}'{did_you_mean(unknown, COLUMNS)}")
    with desk.changing(f"{', '.join(cells)} of {animal}", desk.table):
        table = read_rows(desk.table)
        row = _row(table.rows, animal, desk.table)
        unchanged(animal, {title: text for title, text in was.items() if title in COLUMNS}, row)
        _check(desk, {**row, **cells}, cells, table.rows, animal)
        _write_cells(desk, table, animal, cells)
    return f"{animal}: {', '.join(f'{title} {text}' for title, text in cells.items())}"


def _write_cells(desk: Desk, table: Any, animal: str, cells: Mapping[str, str]) -> None:
    row = _row(table.rows, animal, desk.table)
    row.update({title: " ".join(text.split()) for title, text in cells.items()})
    write_file(desk.table, written_rows(table, ()))


def _row(rows: tuple[dict[str, str], ...], animal: str, table: Path) -> dict[str, str]:
    found = [row for row in rows if row["animal"] == animal]
    if len(found) != 1:
        why = "there is no animal" if not found else "two rows are called"
        raise InputError(f"{why} '{animal}' in {table.name}")
    return found[0]


def _check(desk: Desk, row: Mapping[str, str], cells: Mapping[str, str], rows: Any, animal: str) -> None:
    """Refuse a value that no cell of the column can hold; what may be lacking for a while may be empty."""
    from vasowave.findings import Place

    _, wrong = read_row(row, desk.folder, None, lambda title: Place(part=title))
    mine = [one for one in wrong if one.error and cells.get(one.place.part)]
    if mine:
        raise InputError(f"{mine[0].place.part}: {mine[0].finding}")
    name = cells.get("animal", animal)
    if not name or any(one["animal"].casefold() == name.casefold() for one in rows if one["animal"] != animal):
        raise InputError(f"'{name}': an animal has a name that no other has")
    for title in ("network", "recording", "flow", "beat edits"):
        if cells.get(title):
            desk.inside(cells[title])
