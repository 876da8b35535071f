"""One study and what was done to it here: every change of a file with what stood there before, so that it is undone."""

import hashlib
from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from vasowave.base.errors import InputError
from vasowave.base.io.files import alone_in, content_of, lies_inside, made_inside, write_files
from vasowave.base.io.remembered import Made, made_once, marks_of
from vasowave.study.folder.places import RESULTS, STUDY_FILE
from vasowave.study.folder.reading import read_settings
from vasowave.study.folder.settings import StudyFile
from vasowave.study.results.results import ANIMALS, INDEX, Results, read_results

EDITS = "edits"
"""Folder of the files that hold what was decided of beats, and corrections of trees."""

_STEPS = 200  # that can be undone


class Step(NamedTuple):
    """One change: what it is called, and of every file what stood there before and after, None for no file."""

    name: str
    before: dict[Path, bytes | None]
    after: dict[Path, bytes | None]


class Change:
    """What is being done to some files of a study.

    Holds state because of each it knows what it holds now, if nobody else wrote into it.
    """

    def __init__(self, folder: Path, files: tuple[Path, ...]) -> None:
        self.folder = folder
        self.before: dict[Path, bytes | None] = {file: content_of(file) for file in files}
        self.now: dict[Path, bytes | None] = dict(self.before)

    def write(self, file: Path, text: str) -> None:
        """Write one of the files; `InputError` if another hand wrote into it since it was read."""
        _write(self.folder, {file: text}, {file: self.now[file]})
        self.now[file] = text.encode()

    def read_again(self) -> None:
        """Take what the files hold for what was written here."""
        self.now = {file: content_of(file) for file in self.now}

    def take_back(self) -> None:
        """Put back what the files held, but for one that another hand changed since."""
        for file, content in self.now.items():
            if content != self.before[file]:
                with suppress(InputError):
                    _write(self.folder, {file: self.before[file]}, {file: content})


class Desk:
    """A study that is open.

    Holds state because what was done can be undone, and done again.

    Parameters
    ----------
    folder : Path
        Of the study; it need not hold one yet.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.done: list[Step] = []
        self.undone: list[Step] = []

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
        """Return the results of the study, read anew only where a file of them changed; raises as `read_results`."""
        return self.of_results("read", lambda: read_results(self.folder))

    def of_results(self, name: Hashable, make: Callable[[], Made]) -> Made:
        """Return what is made of the results, made anew only where a file of them changed; `name` tells what it is."""

        def files() -> list[Path]:
            return [self.results / INDEX, *sorted((self.results / ANIMALS).glob("*.nc"))]

        return made_once(lambda: (name, str(self.results), tuple(map(str, files())), marks_of(files())), make)

    def inside(self, name: str) -> Path:
        """Return a file of the study by its name.

        Raises
        ------
        InputError
            The name, or a link on the way, leads out of the study.
        """
        if "\0" in name or not lies_inside(self.folder, name):
            raise InputError(f"'{name[:80]}' is not a file inside this study")
        return self.folder / name

    @contextmanager
    def changing(self, name: str, *files: Path) -> Iterator[Change]:
        """Let the files change inside: all of them, as one step that can be undone, or none."""
        with alone_in(self.folder):
            change = Change(self.folder, files)
            try:
                yield change
            except BaseException:
                change.take_back()
                raise
            if change.now != change.before:
                self.done = [*self.done, Step(name, change.before, change.now)][-_STEPS:]
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

    def _turn(self, taken: list[Step], destination: list[Step], back: bool) -> str:
        with alone_in(self.folder):
            if not taken:
                raise InputError("there is nothing to undo" if back else "there is nothing to do again")
            step = taken[-1]
            now, then = (step.after, step.before) if back else (step.before, step.after)
            _write(self.folder, {file: content for file, content in then.items() if content != now[file]}, now)
            destination.append(taken.pop())
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


def _write(folder: Path, contents: Mapping[Path, bytes | str | None], expected: Mapping[Path, bytes | None]) -> None:
    """Write files of the study in a folder, and make the folders that they lie in."""
    for file, content in contents.items():
        if content is not None:
            made_inside(folder, str(file.parent.relative_to(folder)))
    write_files(contents, expected)


def unchanged(subject: str, shown: Mapping[str, str], now: Mapping[str, str]) -> None:
    """Raise `InputError` if something is not as the page showed it, so that nobody's change is written over."""
    changed = [name for name, text in shown.items() if now.get(name, "") != text]
    if changed:
        raise InputError(f"{subject}: {', '.join(changed)} was changed elsewhere meanwhile to "
                         f"'{now.get(changed[0], '')}'; look at it, then change it again")  # fmt: skip
