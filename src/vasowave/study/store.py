"""Finished pieces of a study, found again by what went into them.

A piece is one file ``KEY-DIGEST.nc``: KEY stands for everything that entered its computation, the animal included,
DIGEST is the SHA-256 of the file itself. It appears by renaming a complete file, and a file that does not match its
DIGEST, or that does not hold its KEY, is not a piece. So there is no moment at which a killed program or a full disk
could leave something that is mistaken for a result, and no result of one animal is taken for another's.
"""

import hashlib
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from vasowave.errors import InputError
from vasowave.io.files import made_inside, not_written, remove_parts, write_file
from vasowave.io.textfile import look, read_bytes
from vasowave.runtime.kept import digest_of, program

CACHE = "cache"
_NUMERICAL = ("numpy", "scipy", "numba", "xarray")
_NOT_NUMERICAL = ("cli", "report", "figures", "cohort")
"""Parts of the package that only show what was computed; a change there asks for no recomputation."""
_DIGITS = 32  # of a key


def source_digest() -> str:
    """Return the digest of the sources that compute an animal, and of the numerical libraries' versions."""
    return program("", _NOT_NUMERICAL, _NUMERICAL)


def key_of(what: Any, files: Iterable[tuple[str, Path]]) -> str:
    """Return the key of values, of the bytes of files by their roles, and of the program; never of a file's time.

    Raises
    ------
    InputError
        A file cannot be read.
    """
    return digest_of(source_digest(), what, [(role, look(path).sha256) for role, path in files])[:_DIGITS]


class Store:
    """The folder `name` of finished pieces in `folder`. One program at a time may write to it (see `study.lock`).

    Parameters
    ----------
    folder : Path
    name : str
        Made if missing; unfinished files of an earlier program are removed.
    """

    def __init__(self, folder: Path, name: str = CACHE) -> None:
        self.folder = made_inside(folder, name)
        remove_parts(self.folder)

    def find(self, key: str) -> Path | None:
        """Return the piece of `key`; None if there is none, or only a damaged one, which is removed.

        Raises
        ------
        InputError
            Something that is no file stands in its place and cannot be removed.
        """
        there = os.listdir(self.folder) if self.folder.is_dir() else []  # by a pattern, thousands would take seconds
        for path in (self.folder / name for name in sorted(there) if name.startswith(f"{key}-") and name[-3:] == ".nc"):
            if _is_whole(path, key):
                return path
            if path.is_dir() and not path.is_symlink():
                raise InputError(f"{path}: a folder where a finished piece should be; remove it and run again")
            try:
                path.unlink(missing_ok=True)
            except OSError as error:
                raise not_written(path, error) from None
        return None

    def keep(self, key: str, content: bytes) -> Path:
        """Store a piece, in whose content its key stands, and return its file.

        Raises
        ------
        InputError
            It could not be written, because the disk is full or read-only; nothing is left of it.
        """
        if not self.folder.is_dir():
            raise InputError(f"{self.folder}: was removed while the study ran; run again, nothing else is lost")
        return write_file(self.folder / f"{key}-{hashlib.sha256(content).hexdigest()}.nc", content)


def piece_digest(path: Path) -> str:
    """Return the SHA-256 that the name of a piece states."""
    return path.stem.rpartition("-")[2]


def _is_whole(path: Path, key: str) -> bool:
    try:
        content = read_bytes(path)
    except InputError:  # a folder or a link to nowhere in its place
        return False
    return hashlib.sha256(content).hexdigest() == piece_digest(path) and key.encode() in content
