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
from vasowave.study.entering.table import read_rows
from vasowave.study.entering.template import FOLDERS
from vasowave.study.folder.rows import FILES
from vasowave.workbench.desk import Desk

RECORDED = FOLDERS[1]
"""The folder of a study that is watched, with those in it; so are those in which rows name recordings at first."""

_SETTLED_S = 3.0  # for which a file stays as it is before it counts as whole: a recorder writes while it records

Mark = tuple[int, int]
"""Size of a file, and its time in ns."""


class Arrivals:
    """The files beside the recordings of a study that are in no row, and came while it was open.

    Holds state because a file that was there at first, or was added and taken out again, does not arrive.

    Parameters
    ----------
    desk : Desk
    clock : callable, optional
        Returns the time, s.
    """

    def __init__(self, desk: Desk, clock: Callable[[], float] = time.monotonic) -> None:
        self.desk, self.clock = desk, clock
        self.turn, self.folders = threading.RLock(), set[Path]()
        with suppress(VasowaveError):  # which stands among the problems
            self.folders = {file.parent for file in listed(desk, "recording", "flow") - listed(desk)}
        self.seen = self._files()
        self.tried: set[Path] = set()
        self.growing: dict[Path, tuple[Mark, float]] = {}

    def expect(self, file: Path) -> None:
        """Leave a file to whoever put it there."""
        with self.turn, suppress(OSError):
            self.seen[_plain(file)] = _mark(file)

    def ready(self) -> list[Path]:
        """Return the files that arrived and have not changed for some seconds; none while the table cannot be read."""
        with self.turn:
            new = {file: mark for file, mark in self._files().items() if self.seen.get(file) != mark}
            try:
                in_rows = listed(self.desk, *FILES) if new else set()
            except VasowaveError:
                return []
            self.seen |= {file: mark for file, mark in new.items() if file in in_rows}
            now, before = self.clock(), self.growing
            self.growing = {file: (mark, before[file][1] if before.get(file, ())[:1] == (mark,) else now)
                            for file, mark in new.items() if file not in in_rows}  # fmt: skip
            return [file for file, (_, since) in self.growing.items() if now - since >= _SETTLED_S]

    def add(self) -> Added | None:
        """Write rows of the files that arrived; None where there are none.

        Each is tried once, and again with the next where it became no row: pressure and flow may be two files.

        Raises
        ------
        InputError
            No recording is among them, or the table cannot be written.
        """
        desk = self.desk
        with self.turn:
            ready = self.ready()
            if not ready:
                return None
            self.seen |= {file: self.growing.pop(file)[0] for file in ready}
            self.tried |= {*ready}
            files = sorted(file for file in self.tried - listed(desk, *FILES) if file.is_file())
        with desk.changing("add " + ", ".join(file.name for file in ready), desk.table, desk.file) as change:
            added = add_files(desk.folder, files)
            change.read_again()
        with self.turn:
            self.tried -= listed(desk, *FILES)
        return added

    def _files(self) -> dict[Path, Mark]:
        return recordings_in({*_folders(self.desk), *self.folders})


def unlisted(desk: Desk) -> list[str]:
    """Return the names of files in the study's folder of recordings that are in no row."""
    place = (desk.folder / RECORDED).resolve()
    files = {*recordings_in(_folders(desk))}
    try:
        free = files - listed(desk, *FILES) if files else set()
    except VasowaveError:  # which stands among the problems
        return []
    return [f"{RECORDED}/{file.relative_to(place).as_posix()}" for file in sorted(free)]


def recordings_in(folders: Collection[Path]) -> dict[Path, Mark]:
    """Return the files in some folders whose type is a recording's."""
    files: dict[Path, Mark] = {}
    for folder in folders:
        with suppress(OSError):
            for file in folder.iterdir():
                if file.suffix.lower() in RECORDINGS.suffixes and file.name[0] not in ".~" and file.is_file():
                    files[file] = _mark(file)
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


def _mark(file: Path) -> Mark:
    about = file.stat()
    return about.st_size, about.st_mtime_ns
