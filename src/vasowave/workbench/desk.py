"""One study and what was done to it here: every change of a file with what stood there before, so that it is undone."""

import hashlib
import os
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from vasowave.errors import InputError
from vasowave.io.files import made_inside, write_file
from vasowave.io.remembered import remembered
from vasowave.runtime.locks import lock_open_file
from vasowave.study.plan import RESULTS
from vasowave.study.reading import STUDY_FILE, read_settings
from vasowave.study.results import INDEX, Results, read_results
from vasowave.study.settings import StudyFile

EDITS = "edits"
"""Folder of the files that hold what was decided of beats, and corrections of trees."""

_LOCK = ".vasowave-workbench.lock"
_PATIENCE = 5.0  # s to wait for another workbench that writes into the same study
_STEPS = 200  # that can be undone


class Step(NamedTuple):
    """One change: what it is called, and of every file what stood there before and after, None for no file."""

    name: str
    before: dict[Path, bytes | None]
    after: dict[Path, bytes | None]


class Desk:
    """A study that is open.

    Parameters
    ----------
    folder : Path
        Of the study; it need not hold one yet.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.done: list[Step] = []
        self.undone: list[Step] = []
        self._lock = threading.Lock()

    @property
    def file(self) -> Path:
        """The study file."""
        return self.folder / STUDY_FILE

    @property
    def table(self) -> Path:
        """The table of animals."""
        settings = read_settings(self.file)[0] if self.file.is_file() else None
        return self.inside((settings or StudyFile()).animals)

    @property
    def results(self) -> Path:
        """The folder of the results."""
        return self.folder / RESULTS

    def stored(self) -> Results:
        """Return the results of the study, whose index is read anew only where it changed; raises as `read_results`."""
        index = self.results / INDEX
        return _results_of(index) if index.is_file() else read_results(self.folder)

    def inside(self, name: str) -> Path:
        """Return a file of the study by its name.

        Raises
        ------
        InputError
            The name, or a link on the way, leads out of the study.
        """
        try:
            path, home = self.folder / name, self.folder.resolve()
            good = path.resolve().is_relative_to(home) and path.resolve() != home
        except (OSError, RuntimeError, ValueError):
            good = False
        if not good or "\0" in name:
            raise InputError(f"'{name[:80]}' is no file inside this study")
        return path

    @contextmanager
    def changing(self, name: str, *files: Path) -> Iterator[None]:
        """Let the files change inside: all of them, as one step that can be undone, or none."""
        with self._alone():
            before = {file: _content(file) for file in files}
            try:
                yield
            except BaseException:
                for file, content in before.items():
                    if _content(file) != content:
                        _put(file, content)
                raise
            after = {file: _content(file) for file in files}
            if after != before:
                self.done = [*self.done, Step(name, before, after)][-_STEPS:]
                self.undone.clear()

    def undo(self) -> str:
        """Put back what stood there before the last change and return its name.

        Raises
        ------
        InputError
            There is none, or a file was changed elsewhere since.
        """
        return self._turn(self.done, self.undone, back=True)

    def redo(self) -> str:
        """Make the change again that was undone last; raises as `undo`."""
        return self._turn(self.undone, self.done, back=False)

    def _turn(self, taken: list[Step], given: list[Step], back: bool) -> str:
        with self._alone():
            if not taken:
                raise InputError("there is nothing to undo" if back else "there is nothing to do again")
            step = taken[-1]
            now, then = (step.after, step.before) if back else (step.before, step.after)
            for file, content in now.items():
                if _content(file) != content:
                    raise InputError(f"{file.name} was changed elsewhere since; nothing was undone, so that nothing is "
                                     "lost: mend it by hand")  # fmt: skip
            for file, content in then.items():
                if content != now[file]:
                    _put(file, content)
            given.append(taken.pop())
            return step.name

    def mark(self) -> str:
        """Return what is another text whenever a file of the study, or what is kept of its run, has changed."""
        files = [self.file, self.results / INDEX, *sorted(self.results.glob("*.json")), self.results]
        with suppress(InputError):
            files.append(self.table)
        files += sorted((self.folder / EDITS).glob("*.*"))
        digest = hashlib.sha256()
        for file in files:
            try:
                about = file.stat()
                digest.update(f"{file.name} {about.st_size} {about.st_mtime_ns} {about.st_ino};".encode())
            except OSError:
                digest.update(f"{file.name} -;".encode())
        return digest.hexdigest()[:16]

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Be the only one who writes into this study: of all threads here, and of all workbenches."""
        with self._lock:
            if not self.folder.is_dir():
                yield
                return
            with open(os.open(self.folder / _LOCK, os.O_RDWR | os.O_CREAT, 0o644), "rb+") as file:
                begun = time.monotonic()
                while True:
                    try:
                        lock_open_file(file.fileno())
                        break
                    except BlockingIOError:
                        if time.monotonic() - begun > _PATIENCE:
                            raise InputError("another workbench is writing into this study; try again") from None
                        time.sleep(0.02)
                    except OSError:  # a file system without locks
                        break
                yield


@remembered
def _results_of(index: Path) -> Results:
    return read_results(index.parent)


def unchanged(what: str, seen: Mapping[str, str], now: Mapping[str, str]) -> None:
    """Raise `InputError` if something is not as the page showed it, so that nobody's change is written over."""
    other = [name for name, text in seen.items() if now.get(name, "") != text]
    if other:
        raise InputError(f"{what}: {', '.join(other)} was changed elsewhere meanwhile to "
                         f"'{now.get(other[0], '')}'; look at it, then change it again")  # fmt: skip


def _content(file: Path) -> bytes | None:
    try:
        return file.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise InputError(f"{file}: {(error.strerror or 'cannot be read').lower()}") from None


def _put(file: Path, content: bytes | None) -> None:
    if content is None:
        file.unlink(missing_ok=True)
    else:
        made_inside(file.parent.parent, file.parent.name)
        write_file(file, content)
