"""Which programs a user has allowed to run, and for which folders: a record in a folder of the user's own.

Each permission is one file, named by the SHA-256 of the folder and of the program, so that a folder that moves, or a
program that changes by a byte, is asked about anew.
"""

import hashlib
import os
import platform
from pathlib import Path

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, warn
from vasowave.base.io.files import make_folder, write_file

NOT_RECORDED = look_kind(
    "trust.not-recorded", "the permission to run {program} holds for this command alone ({why}); {remedy}",
    "make your folder of settings writable, or allow the program each time",
)  # fmt: skip
_ALLOWED: set[str] = set()  # in this process


def state_folder() -> Path | None:
    """Return the user's folder of what programs remember; None where there is none.

    ``XDG_STATE_HOME``, else ``~/.local/state``, on macOS ``~/Library/Application Support``, on Windows
    ``LOCALAPPDATA``; of this program ``vasowave`` therein.
    """
    home = Path(os.path.expanduser("~"))
    folders = {"Darwin": home / "Library" / "Application Support", "Windows": home / "AppData" / "Local"}
    variable = os.environ.get("XDG_STATE_HOME") or (os.name == "nt" and os.environ.get("LOCALAPPDATA")) or ""
    place = Path(variable) if variable else folders.get(platform.system(), home / ".local" / "state")
    return place / "vasowave" if place.is_absolute() else None


def is_allowed(folder: Path, program: bytes) -> bool:
    """Whether a program, its bytes, may run for what lies in a folder."""
    name, place = _permission(folder, program), state_folder()
    return name in _ALLOWED or (place is not None and (place / "trusted" / name).is_file())


def allow(folder: Path, program: bytes, title: str) -> None:
    """Let a program run for what lies in a folder, from now on; `title` is what a person calls it.

    Warns
    -----
    VasowaveWarning
        It cannot be recorded, and holds for this process alone.
    """
    name, place = _permission(folder, program), state_folder()
    _ALLOWED.add(name)
    statement = f"{title}\nSHA-256 {hashlib.sha256(program).hexdigest()}\nfor {folder.resolve()}\n"
    try:
        if place is None:
            raise InputError("there is no folder of your own")
        write_file(make_folder(place / "trusted", 0o700) / name, statement)
    except InputError as error:
        warn(NOT_RECORDED(program=title, why=str(error)))


def _permission(folder: Path, program: bytes) -> str:
    digest = hashlib.sha256(program).hexdigest()
    return hashlib.sha256(os.fsencode(folder.resolve()) + b"\0" + digest.encode()).hexdigest()
