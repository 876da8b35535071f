"""What a command said of files, said again at once for as long as they, their neighbors and the program are the same.

An answer stands in the user's own folder of what programs remember (see `io.trusted`), never beside the files: a folder
that comes from elsewhere brings no answers along. It counts only if the SHA-256 of every file that it rests on, all
names, sizes and times in the folders that these lie in, the sources of the program and the installed libraries are
what they were. Anything else is computed anew, in silence.
"""

import hashlib
import json
import os
import sys
import time
from collections.abc import Collection, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from vasowave.base.errors import InputError
from vasowave.base.io.files import make_folder
from vasowave.base.io.textfile import look
from vasowave.base.io.trusted import state_folder
from vasowave.base.runtime.kept import digest_of, keep, program, recall
from vasowave.base.runtime.writing import open_regular
from vasowave.base.stores import parsed

_DIGITS = 32  # of a digest, in the name of a file
_OUTDATED = 30 * 24 * 3600.0  # s after which an answer that nobody asked for is removed


class Basis(NamedTuple):
    """What an answer rests on: the SHA-256 of files, empty where there is none, and the digests of folders; files of
    some names, `ours`, do not count in a folder.
    """

    files: dict[str, str]
    folders: dict[str, str]
    ours: list[str]


def basis_of(files: Iterable[Path], folders: Iterable[Path], ours: Iterable[str] = ()) -> Basis:
    """Return what files hold and what folders list now, but for files of the names `ours`."""
    ours = sorted(ours)
    return Basis(
        {str(file): _content(file) for file in files}, {str(folder): _listing(folder, ours) for folder in folders}, ours
    )


def answer_to(question: Sequence[str]) -> Any:
    """Return what was answered to a question, None if that does not hold any more."""
    place = _place(question)
    if place is None:
        return None
    try:
        key = _key(question)  # of the program as it is before anything is computed
        with os.fdopen(open_regular(place), "rb") as file:
            content = recall(file, key)
        *basis, answer = parsed(b"" if content is None else content.tobytes())
        files, folders, ours = basis
        if Basis(*basis) != basis_of(map(Path, files), map(Path, folders), ours):
            return None
        os.utime(place)
    except (OSError, ValueError, TypeError):
        return None
    return answer


def keep_answer(question: Sequence[str], basis: Basis, answer: Any) -> None:
    """Keep an answer with what it rests on, as it was before the answer was looked for; where that is possible."""
    place = _place(question)
    if place is None:
        return
    with suppress(OSError, InputError):
        make_folder(place.parent, 0o700)
        keep(place, _key(question), json.dumps([*basis, answer]).encode())
        for file in place.parent.iterdir():
            if time.time() - file.stat().st_mtime > _OUTDATED:
                file.unlink()


def _place(question: Sequence[str]) -> Path | None:
    folder = state_folder()
    return None if folder is None else folder / "answers" / f"{digest_of(question)[:_DIGITS]}.answer"


def _key(question: Sequence[str]) -> str:
    """Return what stands for a question, the program that answers it, and its libraries."""
    return digest_of(question, program(), sys.version, _libraries())


def _libraries() -> list[str]:
    """Return the names of all that is installed, with versions."""
    names = []
    for folder in filter(os.path.isdir, sys.path):
        with suppress(OSError):
            names += [name for name in os.listdir(folder) if name.endswith("-info")]
    return sorted(names)


def _content(file: Path) -> str:
    try:
        return look(file).sha256
    except InputError:
        return ""


def _listing(folder: Path, ours: Collection[str]) -> str:
    """Return what changes with any file in a folder, or its name."""
    digest = hashlib.sha256()
    try:
        entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
        for entry in entries:
            if entry.is_file() and entry.name not in ours:
                about = entry.stat()
                marks = about.st_size, about.st_mtime_ns, about.st_ctime_ns, about.st_ino
                digest.update(f"{entry.name!r} {marks};".encode())
    except OSError:
        return ""
    return digest.hexdigest()
