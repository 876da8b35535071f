"""Files that are saved beside the recordings of a study while it is open, as a recorder does: each becomes a row."""

import os
import threading
import time
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path

from vasowave.base.errors import VasowaveError
from vasowave.catheter.read.formats import RECORDINGS
from vasowave.study.entering.adding import Added, add_files
from vasowave.study.entering.animal_sheet import animal_sheet
from vasowave.study.entering.sorting import is_prose, names_signal, pair_name
from vasowave.study.entering.table import read_rows
from vasowave.study.entering.template import FOLDERS
from vasowave.study.folder.animal_columns import FILES
from vasowave.workbench.desk import Desk

RECORDED = FOLDERS[1]
"""The folder of a study that is watched, with those in it; so are those in which rows name recordings at first."""

_SETTLED_S = 3.0  # for which a file stays as it is before it counts as whole: a recorder writes while it records

_MAX_SHEET_BYTES = 1 << 20  # of a table of animals

Mark = tuple[int, int]
"""Size of a file, and its time in ns."""


class Arrivals:
    """The files beside the recordings of a study that are in no row, and came while it was open.

    Holds state because a file that was there at first, or was added and taken out again, does not arrive; one that
    became no row arrives again when it has changed.

    Parameters
    ----------
    desk : Desk
    clock : callable, optional
        Returns the time, s.
    """

    def __init__(self, desk: Desk, clock: Callable[[], float] = time.monotonic) -> None:
        self.desk: Desk = desk
        self.clock: Callable[[], float] = clock
        self.turn: threading.RLock = threading.RLock()
        self.folders: set[Path] = set()
        with suppress(VasowaveError):  # which stands among the problems
            self.folders = {file.parent for file in listed(desk, "recording", "flow") - listed(desk)}
        self.seen: set[Path] = {*self._files()}
        self.refused: dict[Path, Mark] = {}
        self.growing: dict[Path, tuple[Mark, float]] = {}

    def expect(self, file: Path) -> None:
        """Leave a file to whoever put it there."""
        with self.turn:
            self.seen.add(_plain(file))

    def ready(self) -> list[Path]:
        """Return the files that arrived and have not changed for some seconds; none while no table can be read."""
        with self.turn:
            if not self.desk.file.is_file():
                self.seen |= {*self._files()}
                return []
            new = {file: mark for file, mark in self._files().items()
                   if file not in self.seen and self.refused.get(file) != mark}  # fmt: skip
            try:
                self.seen |= listed(self.desk, *FILES) if new else set()
            except VasowaveError:
                return []
            now, before = self.clock(), self.growing
            self.growing = {file: (mark, before[file][1] if before.get(file, ())[:1] == (mark,) else now)
                            for file, mark in new.items() if file not in self.seen}  # fmt: skip
            return [file for file, (_, since) in self.growing.items() if now - since >= _SETTLED_S]

    def add(self) -> Added | None:
        """Write rows of the files that arrived; None where there are none.

        Pressure and flow may be two files: what became no row, and by its name is one of them, is tried with the other.

        Raises
        ------
        InputError
            No recording is among them, or the table cannot be written.
        """
        desk = self.desk
        with self.turn:
            if not (ready := self.ready()):
                return None
            names = {*map(pair_name, ready)}
            halves = [file for file in self.refused
                      if names_signal(file) and pair_name(file) in names and file.is_file()]  # fmt: skip
            self.refused |= {file: self.growing.pop(file)[0] for file in ready}
        with desk.changing("add " + ", ".join(file.name for file in ready), desk.table, desk.file) as change:
            added = add_files(desk.folder, sorted({*halves, *ready}))
            change.read_again()
        with self.turn:
            self.seen |= listed(desk, *FILES)
            self.refused = {file: mark for file, mark in self.refused.items() if file not in self.seen}
        return added

    def _files(self) -> dict[Path, Mark]:
        return recordings_in({*_folders(self.desk), *self.folders})


def unlisted(desk: Desk) -> list[str]:
    """Return the names of files in the study's folder of recordings that are in no row and may come into one."""
    place = (desk.folder / RECORDED).resolve()
    files = {*recordings_in(_folders(desk))}
    try:
        free = files - listed(desk, *FILES) if files else set()
    except VasowaveError:  # which stands among the problems
        return []
    return [f"{RECORDED}/{file.relative_to(place).as_posix()}" for file in sorted(free) if not _beside_rows(file)]


def _beside_rows(file: Path) -> bool:
    """Whether a file is a text or a table of animals, which has done its work when it was added."""
    with suppress(VasowaveError, OSError):
        return is_prose(file) or (file.stat().st_size < _MAX_SHEET_BYTES and animal_sheet(file) is not None)
    return False


def recordings_in(folders: Collection[Path]) -> dict[Path, Mark]:
    """Return the files in some folders whose type is a recording's."""
    files: dict[Path, Mark] = {}
    for folder in folders:
        with suppress(OSError):
            entries = [entry for entry in os.scandir(folder) if entry.name[0] not in ".~"]
            for entry in (entry for entry in entries if Path(entry.name).suffix.lower() in RECORDINGS.suffixes):
                with suppress(OSError):  # one that cannot be looked at hides no other
                    if entry.is_file():
                        files[folder / entry.name] = _mark(entry)
    return files


def _folders(desk: Desk) -> list[Path]:
    """Return the folder of recordings of a study, and those in it."""
    return [Path(place).resolve() for place, _, _ in os.walk(desk.folder / RECORDED)]


def listed(desk: Desk, *titles: str) -> set[Path]:
    """Return the table of a study and the files that its rows name in some columns; raises if it cannot be read."""
    rows = read_rows(desk.table).rows if desk.file.is_file() else ()
    files = {desk.folder / row[title] for row in rows for title in titles if row.get(title)}
    return {_plain(file) for file in (desk.table, *files)}


def _plain(file: Path) -> Path:
    """Return a file in its folder, whatever links lead to that."""
    return file.parent.resolve() / file.name


def _mark(entry: os.DirEntry[str]) -> Mark:
    about = entry.stat()
    return about.st_size, about.st_mtime_ns
